use super::answer::{CaseAnswer, CaseEquilibrium};
use crate::SimError;
use crate::folder::{PREVIEW, claim};
use crate::storage::{save, write_atomically};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rapunzel_export::{Frame, Strand, vtp};
use rapunzel_scene::case::{Case, CaseEnd};
use rapunzel_studio::sheet::{self, PreviewFrame, Support};
use std::io::Write;
use std::path::Path;

const RODS: &str = "rods.vtp";
const ANSWER: &str = "answer.json";

/// Columns of the table.
const COLUMNS: &str = "s (m),x (m),y (m),z (m),d1x,d1y,d1z,d2x,d2y,d2z,d3x,d3y,d3z,nx (N),ny (N),\
nz (N),mx (N m),my (N m),mz (N m),kappa1 (1/m),kappa2 (1/m),kappa3 (1/m)";

impl CaseAnswer {
    /// Writes the answer into a folder, which is made, in the place of an older one: `rod-0.csv`
    /// and so on, a table for each equilibrium; `rods.vtp`, all of them for ParaView;
    /// `preview.png`, with what holds the rod of the case; and `answer.json`.
    ///
    /// # Errors
    /// Errors of [`claim`]; files that cannot be written.
    pub fn save(&self, folder: &Path, case: &Case) -> Result<(), SimError> {
        let tables: Vec<_> = (0..self.equilibria.len()).map(|i| format!("rod-{i}.csv")).collect();
        let files = tables.iter().map(String::as_str).chain([RODS, PREVIEW, ANSWER]);
        claim(folder, &files.collect::<Vec<_>>())?;
        for (table, found) in tables.iter().zip(&self.equilibria) {
            write_atomically(&folder.join(table), |to| to.write_all(found.table().as_bytes()))?;
        }
        let matter = case.matter();
        let radius = |s: f64| matter.at(s / self.length).section.equivalent_radius();
        let strands = self.equilibria.iter().map(|found| found.strand(&radius));
        let frame = Frame { index: 0, time: 0.0, strands: strands.collect() };
        save(&folder.join(RODS), |to| vtp::write(to, &frame))?;
        let supports = self.equilibria.iter().enumerate();
        let supports = supports.flat_map(|(strand, found)| found.supports(strand, case)).collect();
        save(&folder.join(PREVIEW), |to| {
            sheet::write(to, &[PreviewFrame::new(frame, supports)?], &[], &[])
        })?;
        write_atomically(&folder.join(ANSWER), |to| Ok(serde_json::to_writer(to, self)?))
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
            CaseEnd::Joint { .. } => Some(false),
            CaseEnd::Bearing { .. } | CaseEnd::Clamped { .. } => Some(true),
        };
        let end = end.map(|clamped| (self.stations.len() - 1, clamped));
        let places = case.places.iter().filter(|place| place.stiffness.is_none()).map(|place| {
            let before = self.stations.partition_point(|station| station.s < place.at);
            (before.min(self.stations.len() - 1), false)
        });
        let supports = [(0, true)].into_iter().chain(places).chain(end);
        supports.map(|(point, clamped)| Support { strand, point, clamped }).collect()
    }

    /// The rod as a strand, whose radius (m) is a function of the arc length (m).
    fn strand(&self, radius: &dyn Fn(f64) -> f64) -> Strand {
        let stations = &self.stations;
        let frames = stations.iter().map(|station| {
            let columns = station.frame.map(Vector3::from);
            Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns))
        });
        let segments = stations.len() - 1;
        Strand {
            points: stations.iter().map(|station| station.position.into()).collect(),
            radii: stations.iter().map(|station| radius(station.s)).collect(),
            velocities: vec![Vector3::zeros(); stations.len()],
            frames: frames.take(segments).collect(),
            curvatures: stations.iter().map(|station| station.curvature.into()).collect(),
            forces: stations[..segments].iter().map(|station| station.force.into()).collect(),
            contact_forces: vec![Vector3::zeros(); stations.len()],
            charges: vec![0.0; stations.len()],
        }
    }
}
