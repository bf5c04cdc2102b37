use super::answer::{CaseAnswer, CaseBranch, CaseContact, CaseEquilibrium, CaseLimit, TouchedBy};
use super::fixed_object::surfaces;
use crate::SimError;
use crate::folder::{PREVIEW, claim};
use crate::storage::{save, write_atomically};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rapunzel_export::{Frame, Strand, vtp};
use rapunzel_scene::case::{Case, CaseEnd, CaseRoot, SlidingHold};
use rapunzel_studio::sheet::{self, PreviewFrame, Support};
use std::io::Write;
use std::path::Path;

const RODS: &str = "rods.vtp";
const ANSWER: &str = "answer.json";
const BRANCH: &str = "branch.csv";
const CONTACTS: &str = "contacts.csv";

/// Columns of the table of a branch beside the parameter.
const BRANCH_COLUMNS: &str = "elastic (J),loads (J),energy (J),end x (m),end y (m),end z (m),\
clamp fx (N),clamp fy (N),clamp fz (N),clamp mx (N m),clamp my (N m),clamp mz (N m),\
end fx (N),end fy (N),end fz (N),end mx (N m),end my (N m),end mz (N m),ways down,limits before";

/// Columns of the table of contacts: the rod and what pushes it.
const CONTACT_COLUMNS: &str = "rod,s (m),by,index,s there (m),x (m),y (m),z (m),normal x,normal y,\
normal z,gap (m),force (N)";

/// Columns of the table of a mode: a displacement over the largest, and the rotation for it.
const MODE_COLUMNS: &str = "s (m),ux,uy,uz,rx (rad/m),ry (rad/m),rz (rad/m)";

/// Columns of the table.
const COLUMNS: &str = "s (m),x (m),y (m),z (m),d1x,d1y,d1z,d2x,d2y,d2z,d3x,d3y,d3z,nx (N),ny (N),\
nz (N),mx (N m),my (N m),mz (N m),kappa1 (1/m),kappa2 (1/m),kappa3 (1/m)";

impl CaseAnswer {
    /// Writes the answer into a folder, which is made, in the place of an older one: `rod-0.csv`
    /// and so on, a table for each equilibrium, or each rod of those in contact, and then
    /// `contacts.csv`; with a branch `branch.csv`, a row for each of its
    /// points, and `mode-0.csv` and so on, the modes of its limits; `rods.vtp`, all for ParaView;
    /// `preview.png`, with what holds the rod of the case; and `answer.json`.
    ///
    /// # Errors
    /// Errors of [`claim`]; files that cannot be written.
    pub fn save(&self, folder: &Path, case: &Case) -> Result<(), SimError> {
        let tables: Vec<_> = (0..self.equilibria.len()).map(|i| format!("rod-{i}.csv")).collect();
        let limits = self.branch.as_ref().map_or(0, |branch| branch.limits.len());
        let modes: Vec<_> = (0..limits).map(|i| format!("mode-{i}.csv")).collect();
        let files = tables.iter().chain(&modes).map(String::as_str).chain([RODS, PREVIEW, ANSWER]);
        let files = files.chain(self.branch.as_ref().map(|_| BRANCH));
        let files = files.chain(self.contact.as_ref().map(|_| CONTACTS));
        claim(folder, &files.collect::<Vec<_>>())?;
        for (table, found) in tables.iter().zip(&self.equilibria) {
            write_atomically(&folder.join(table), |to| to.write_all(found.table().as_bytes()))?;
        }
        if let Some(branch) = &self.branch {
            write_atomically(&folder.join(BRANCH), |to| to.write_all(branch.table().as_bytes()))?;
            for (file, limit) in modes.iter().zip(&branch.limits) {
                write_atomically(&folder.join(file), |to| to.write_all(limit.table().as_bytes()))?;
            }
        }
        if let Some(contact) = &self.contact {
            let table = contact.table();
            write_atomically(&folder.join(CONTACTS), |to| to.write_all(table.as_bytes()))?;
        }
        // Equilibria are of one rod, or each of another of rods in contact.
        let alone = case.alone();
        let rod = |i: usize| alone.get(i).filter(|_| self.contact.is_some()).unwrap_or(case);
        let strands = self.equilibria.iter().enumerate().map(|(i, found)| {
            let matter = rod(i).matter();
            found.strand(&|part: f64| matter.at(part).section.equivalent_radius())
        });
        let frame = Frame { index: 0, time: 0.0, strands: strands.collect() };
        save(&folder.join(RODS), |to| vtp::write(to, &frame))?;
        let supports = self.equilibria.iter().enumerate();
        let supports = supports.flat_map(|(i, found)| found.supports(i, rod(i))).collect();
        let shown = surfaces(case)?;
        let objects = if shown.is_empty() { Vec::new() } else { vec![shown] };
        save(&folder.join(PREVIEW), |to| {
            sheet::write(to, &[PreviewFrame::new(frame, supports)?], &objects, &[])
        })?;
        write_atomically(&folder.join(ANSWER), |to| Ok(serde_json::to_writer(to, self)?))
    }
}

impl CaseBranch {
    /// The points as CSV, in SI units and degrees; the last column tells of a fold or a bifurcation
    /// that lies between a point and the one before it.
    #[must_use]
    pub fn table(&self) -> String {
        let parameter = if self.unit.is_empty() { "factor" } else { self.unit };
        let mut text = format!("parameter ({parameter}),{BRANCH_COLUMNS}\n");
        let mut limits = self.limits.iter();
        let mut before = self.points.first().map_or(0, |point| point.ways_down);
        for (i, point) in self.points.iter().enumerate() {
            let (elastic, loads) = (point.elastic_energy, point.load_energy);
            let vectors = [
                point.end_position,
                point.clamp_force,
                point.clamp_moment,
                point.end_force,
                point.end_moment,
            ];
            let numbers = [point.parameter, elastic, loads, elastic + loads].into_iter();
            for number in numbers.chain(vectors.into_iter().flatten()) {
                text += &format!("{number:?},");
            }
            let mut passed = Vec::new();
            let switches = self.switched == Some(i);
            while before != point.ways_down || switches && passed.is_empty() {
                let Some(limit) = limits.next() else { break };
                before = if switches { point.ways_down } else { limit.ways_down[1] };
                let kind = match (limit.is_fold, switches) {
                    (true, _) => "fold",
                    (false, false) => "bifurcation",
                    (false, true) => "other branch from the bifurcation",
                };
                passed.push(format!("{kind} at {:?}", limit.parameter));
            }
            before = point.ways_down;
            text += &format!("{},{}\n", point.ways_down, passed.join("; "));
        }
        text
    }
}

impl CaseContact {
    /// The contacts as CSV, in SI units, rods and objects by their indices.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!("{CONTACT_COLUMNS}\n");
        for touch in &self.touches {
            let by = match touch.by {
                TouchedBy::Object(object) => format!("object,{object},"),
                TouchedBy::Rod(rod, at) => format!("rod,{rod},{at:?}"),
            };
            let vectors = touch.position.into_iter().chain(touch.normal);
            let numbers = vectors.chain([touch.gap, touch.force]).map(|x| format!(",{x:?}"));
            text += &format!("{},{:?},{by}{}\n", touch.rod, touch.at, numbers.collect::<String>());
        }
        text
    }
}

impl CaseLimit {
    /// The mode as CSV.
    fn table(&self) -> String {
        let rows = self.mode.iter().map(|one| {
            let numbers = one.displacement.into_iter().chain(one.rotation);
            format!("{:?}{}\n", one.s, numbers.map(|x| format!(",{x:?}")).collect::<String>())
        });
        format!("{MODE_COLUMNS}\n{}", rows.collect::<String>())
    }
}

impl CaseEquilibrium {
    /// The stations as CSV, in SI units and the shortest digits that read back the same.
    #[must_use]
    pub fn table(&self) -> String {
        let rows = self.stations.iter().map(|station| {
            let vectors = [station.position].into_iter().chain(station.frame).chain([
                station.force,
                station.moment,
                station.curvature,
            ]);
            let numbers = vectors.flatten().map(|x| format!(",{x:?}"));
            format!("{:?}{}\n", station.s, numbers.collect::<String>())
        });
        format!("{COLUMNS}\n{}", rows.collect::<String>())
    }

    /// What holds it as a strand of the picture: clamps, and joints where it can turn.
    fn supports(&self, strand: usize, case: &Case) -> Vec<Support> {
        let end = match case.end {
            CaseEnd::Free { .. } => None,
            CaseEnd::Joint { .. } | CaseEnd::Sliding { hold: SlidingHold::Joint, .. } => {
                Some(false)
            }
            CaseEnd::Bearing { .. }
            | CaseEnd::Clamped { .. }
            | CaseEnd::Sliding { .. }
            | CaseEnd::Ring { .. } => Some(true),
        };
        let end = end.map(|clamped| (self.stations.len() - 1, clamped));
        let places = case.places.iter().filter(|place| place.stiffness.is_none()).map(|place| {
            let before = self.stations.partition_point(|station| station.s < place.at);
            (before.min(self.stations.len() - 1), false)
        });
        let root = (case.root != CaseRoot::Free).then_some((0, case.root == CaseRoot::Clamped));
        let supports = root.into_iter().chain(places).chain(end);
        supports.map(|(point, clamped)| Support { strand, point, clamped }).collect()
    }

    /// The rod as a strand, whose radius (m) is a function of the part of its length.
    fn strand(&self, radius: &dyn Fn(f64) -> f64) -> Strand {
        let stations = &self.stations;
        let frames = stations.iter().map(|station| {
            let columns = station.frame.map(Vector3::from);
            Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns))
        });
        let segments = stations.len() - 1;
        let length = stations[segments].s;
        Strand {
            points: stations.iter().map(|station| station.position.into()).collect(),
            radii: stations.iter().map(|station| radius(station.s / length)).collect(),
            velocities: vec![Vector3::zeros(); stations.len()],
            frames: frames.take(segments).collect(),
            curvatures: stations.iter().map(|station| station.curvature.into()).collect(),
            forces: stations[..segments].iter().map(|station| station.force.into()).collect(),
            contact_forces: vec![Vector3::zeros(); stations.len()],
            charges: vec![0.0; stations.len()],
        }
    }
}
