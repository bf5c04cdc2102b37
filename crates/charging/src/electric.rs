//! All electric forces on the fibres of a world.

use crate::ChargingError;
use crate::fibers::RestingFibers;
use crate::head::HeadModel;
use crate::report::ChargeReport;
use nalgebra::{Point3, Vector3};
use rapunzel_electrostatics::{
    Accuracy, ChargedFibers, Electrostatics, ElectrostaticsError, Fields, Method, Multipole,
};
use rapunzel_fiber::{Assembly, Layout};
use rapunzel_scene::Charging;

/// Part of the tolerance that what is found may be off by.
const FINEST: f64 = 0.1;
/// By how much more it may be off where that is out of reach.
const LOOSER: f64 = 3.0;
/// Part of the last residual that forces may be off by on the way to the equilibrium: the next
/// residual is some ten times that.
const ON_THE_WAY: f64 = 0.03;
/// Smallest tolerance of forces that is asked for.
const LEAST: f64 = 1e-9;
/// Where on a segment its charge is as far as the head is concerned: Gauss's two points.
const PLACES: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// What charge does in a world.
#[derive(Debug, Clone)]
pub(crate) struct Electric {
    pub(crate) charging: Charging,
    /// Radii of the fibres, m.
    radii: Vec<f64>,
    head: HeadModel,
    /// Share of the charge that is dealt.
    pub(crate) share: f64,
    /// Report on the last step.
    pub(crate) report: ChargeReport,
}

/// Electric energy, J, and forces on the nodes (world), N.
pub(crate) struct Forces {
    pub(crate) energy: f64,
    pub(crate) forces: Vec<Vector3<f64>>,
}

impl Electric {
    /// Nothing is dealt yet.
    pub(crate) fn new(charging: &Charging, assembly: &Assembly, head: HeadModel) -> Self {
        let layout = assembly.layout();
        let radius = |fiber: usize| assembly.radii()[layout.node_range(fiber).start];
        Self {
            charging: charging.clone(),
            radii: (0..layout.fibers()).map(radius).collect(),
            head,
            share: 0.0,
            report: ChargeReport::default(),
        }
    }

    /// What `solve` finds with the first accuracy that is within reach, from this part of the
    /// tolerance on.
    fn within_reach<T>(
        &self,
        mut part: f64,
        solve: impl Fn(Accuracy) -> Result<T, ElectrostaticsError>,
    ) -> Result<T, ElectrostaticsError> {
        loop {
            let tolerance = (part * self.charging.tolerance).max(LEAST);
            let found = solve(Accuracy::Tolerance(tolerance));
            if part >= 1.0 || !matches!(found, Err(ElectrostaticsError::OutOfReach { .. })) {
                return found;
            }
            part = (LOOSER * part).min(1.0);
        }
    }

    /// Energy and forces of the `charges` of all segments (C) with the nodes at `positions` (world,
    /// m), as exact as an iteration needs them whose last relative residual was this.
    ///
    /// # Errors
    /// [`ChargingError::InHead`] for charges in the head, and [`ChargingError::Electrostatics`].
    pub(crate) fn forces(
        &self,
        fibers: &RestingFibers,
        positions: &[Point3<f64>],
        charges: &[f64],
        residual: f64,
    ) -> Result<Forces, ChargingError> {
        let layout = fibers.assembly.layout();
        if charges.iter().all(|charge| *charge == 0.0) {
            return Ok(Forces { energy: 0.0, forces: vec![Vector3::zeros(); positions.len()] });
        }
        let (head, radii, share) = (&self.head, &self.radii[..], self.share);
        let part = (ON_THE_WAY * residual / self.charging.tolerance).clamp(FINEST, LOOSER * FINEST);
        let mutual = self.within_reach(part, |accuracy| {
            head.beside(&ChargedFibers { layout, charges, radii, accuracy }, positions, share)
        });
        let Electrostatics { mut energy, mut forces, .. } =
            mutual.map_err(|error| self.located(fibers, error, 1))?;
        let field = Vector3::from(self.charging.field);
        for (segment, charge) in charges.iter().enumerate() {
            let half = 0.5 * *charge * field;
            for node in layout.segment_nodes(segment) {
                energy -= half.dot(&positions[node].coords);
                forces[node] += half;
            }
        }
        if matches!(head, HeadModel::Ball { .. } | HeadModel::Thesis { .. }) {
            let (points, halves) = placed(layout, positions, charges);
            let act = |accuracy| head.act(&points, &halves, share, accuracy);
            let action = self.within_reach(part, act);
            let action = action.map_err(|error| self.located(fibers, error, PLACES.len()))?;
            energy += action.energy;
            for (point, force) in action.forces.iter().enumerate() {
                let [a, b] = layout.segment_nodes(point / PLACES.len());
                let part = PLACES[point % PLACES.len()];
                forces[a] += (1.0 - part) * force;
                forces[b] += part * force;
            }
        }
        Ok(Forces { energy, forces })
    }

    /// Potentials (V) and fields (V/m, world) of everything at `targets` (world, m); fibres are
    /// points on their axes. In a conductor it has its potential and no field.
    ///
    /// # Errors
    /// [`ChargingError::InHead`] for charges in the head, and [`ChargingError::Electrostatics`].
    pub(crate) fn fields(
        &self,
        fibers: &RestingFibers,
        targets: &[Point3<f64>],
    ) -> Result<Fields, ChargingError> {
        let layout = fibers.assembly.layout();
        let (points, halves) = placed(layout, &fibers.positions(), &fibers.charges());
        self.fields_of(fibers, &points, &halves, targets)
    }

    /// Potentials (V) and fields (V/m, world) at `targets` (world, m) of given `charges` (C) at
    /// `points` (world, m) and of everything else.
    pub(crate) fn fields_of(
        &self,
        fibers: &RestingFibers,
        points: &[Point3<f64>],
        charges: &[f64],
        targets: &[Point3<f64>],
    ) -> Result<Fields, ChargingError> {
        let all = |accuracy: Accuracy| {
            let response = self.head.response(points, charges, self.share, accuracy)?;
            // Within the conductor.
            let mut all = Fields {
                potentials: vec![response.potential; targets.len()],
                fields: vec![Vector3::zeros(); targets.len()],
            };
            let outside: Vec<_> =
                (0..targets.len()).filter(|i| !self.head.holds(&targets[*i])).collect();
            let places: Vec<_> = outside.iter().map(|i| targets[*i]).collect();
            let direct = Multipole { accuracy }.fields(points, charges, &places)?;
            let induced = response.induced.fields(&places, accuracy)?;
            let field = Vector3::from(self.charging.field);
            for (k, i) in outside.into_iter().enumerate() {
                let own = field.dot(&targets[i].coords);
                all.potentials[i] = direct.potentials[k] + induced.potentials[k] - own;
                all.fields[i] = direct.fields[k] + induced.fields[k] + field;
            }
            Ok(all)
        };
        self.within_reach(FINEST, all).map_err(|error| self.located(fibers, error, PLACES.len()))
    }

    /// The error of one of so many `places` on each segment, with the fibre that it is about.
    fn located(
        &self,
        fibers: &RestingFibers,
        error: ElectrostaticsError,
        places: usize,
    ) -> ChargingError {
        let object = self.charging.head.object();
        if let (ElectrostaticsError::Inside { index, depth }, Some(object)) = (&error, object) {
            let (layout, segment) = (fibers.assembly.layout(), index / places);
            let fiber = layout.segment_fibers()[segment];
            let segment = segment - layout.segment_range(fiber).start;
            return ChargingError::InHead {
                fiber,
                segment,
                object,
                depth: *depth,
                time: fibers.time,
            };
        }
        ChargingError::electric(fibers.time)(error)
    }
}

/// Two points on each segment (world, m) with half of its charge each, C.
pub(crate) fn placed(
    layout: &Layout,
    positions: &[Point3<f64>],
    charges: &[f64],
) -> (Vec<Point3<f64>>, Vec<f64>) {
    let segments = charges.iter().enumerate();
    segments
        .flat_map(|(segment, charge)| {
            let [a, b] = layout.segment_nodes(segment).map(|node| positions[node]);
            PLACES.map(|part| (a + part * (b - a), 0.5 * charge))
        })
        .unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HeadGeometry;
    use nalgebra::{Isometry3, Translation3};
    use rapunzel_collision::field::{Ball, DistanceField, Soup, shapes};
    use rapunzel_fiber::{Fiber, Material, Section};
    use rapunzel_scene::Scene;
    use std::sync::Arc;

    const PLACE: [f64; 3] = [-0.04, 0.0, -0.05];

    /// A ball about the origin, or a capsule along the z axis of which only the surface counts.
    fn head(shape: &str) -> HeadGeometry {
        let (radius, half) = (0.03, 0.005);
        let ball = Ball { center: Point3::origin(), radius };
        let mut surface: Soup = shapes::sphere(radius, 16);
        if shape.starts_with("Capsule") {
            for p in &mut surface.vertices {
                // The equator stays where it is.
                p.z += if p.z == 0.0 { 0.0 } else { f64::copysign(half, p.z) };
            }
        }
        let field: Arc<dyn DistanceField + Send + Sync> = Arc::new(ball);
        let pose = Isometry3::from_parts(Translation3::from(PLACE), Default::default());
        HeadGeometry { field, pose, surface }
    }

    /// Forces are the gradient of the energy for every kind of head: over a step of 0.2 mm the
    /// central difference is off by some squares of that over the gap of 1 cm.
    #[test]
    fn forces_are_the_gradient_of_the_energy() {
        for (kind, shape, tolerance) in [
            ("None", "Ball(radius: 0.03)", 1e-6),
            ("Thesis(object: 0, charge: 1e-10)", "Ball(radius: 0.03)", 1e-3),
            ("Conductor(object: 0, held: Potential(300))", "Ball(radius: 0.03)", 1e-3),
            ("Conductor(object: 0, held: Charge(1e-10))", "Ball(radius: 0.03)", 1e-3),
            (
                "Conductor(object: 0, held: Charge(1e-10))",
                "Capsule(length: 0.01, radius: 0.03)",
                1e-3,
            ),
        ] {
            let objects =
                if kind == "None" { "" } else { "(shape: OF, position: (-0.04, 0, -0.05))" };
            let text = format!(
                "(format: 1, duration: 1, stepper: (dt: 1),
                  fibers: [(length: 0.1, segments: 12, section: Circle(radius: 4e-5),
                    charge: (amount: Fiber(1e-10)))],
                  objects: [{}],
                  charging: (head: {kind}, field: (1e3, 2e3, -5e2), tolerance: 1e-5))",
                objects.replace("OF", shape)
            );
            let scene = Scene::from_ron(&text).expect("a scene");
            let charging = scene.charging.as_ref().expect("with charge");
            let section = Section::Circle { radius: 4e-5 };
            let fiber = Fiber::uniform(0.1, 12, section, &Material::HAIR).expect("a fibre");
            let fibers = RestingFibers::new(Assembly::new(vec![fiber])).expect("a rod");
            let own = (kind != "None").then(|| head(shape));
            let own = HeadModel::new(&charging.head, &scene.objects, own).expect("a head");
            let mut electric = Electric::new(charging, &fibers.assembly, own);
            electric.share = 1.0;
            let (places, charges) = (fibers.positions(), vec![1e-10 / 12.0; 12]);
            let at = |places: &[Point3<f64>]| {
                electric.forces(&fibers, places, &charges, 0.0).expect("outside")
            };
            let forces = at(&places).forces;
            for direction in [Vector3::x(), Vector3::y(), Vector3::z()] {
                let step = 2e-4;
                let moved =
                    |by: f64| -> Vec<_> { places.iter().map(|x| x + by * direction).collect() };
                let [ahead, behind] = [step, -step].map(|by| at(&moved(by)).energy);
                let slope = (behind - ahead) / (2.0 * step);
                let force: Vector3<f64> = forces.iter().sum();
                let error = (force.dot(&direction) - slope).abs() / force.norm();
                assert!(error < tolerance, "{kind}, {shape}: {error} along {direction}");
            }
        }
    }
}
