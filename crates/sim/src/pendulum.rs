//! A stand-in for the integrators in tests: rigid spherical pendulums that hang from the roots.

use crate::group::Batch;
use nalgebra::{Point3, Rotation3, Vector3};
use rapunzel_fiber::so3;
use rapunzel_rod_dynamic::{
    Conditions, End, Energy, Rod, RodError, RodState, StepError, StepReport,
};

pub(crate) struct Pendulums(Vec<Pendulum>);

struct Pendulum {
    rod: Rod,
    time: f64,
    root: Point3<f64>,
    direction: Vector3<f64>,
    rate: Vector3<f64>,
}

impl Pendulums {
    pub(crate) fn new(rods: impl Iterator<Item = (Rod, RodState)>) -> Self {
        Self(rods.map(|(rod, state)| Pendulum::new(rod, &state)).collect())
    }
}

impl Pendulum {
    fn new(rod: Rod, state: &RodState) -> Self {
        let direction = state.frames[0] * Vector3::z();
        Self { rod, time: 0.0, root: state.positions[0], direction, rate: Vector3::zeros() }
    }

    /// Leapfrog for `w' = 3/(2L) d x g`, `d' = w x d`.
    fn step(&mut self, dt: f64, conditions: &dyn Conditions) -> StepReport {
        let pull = |time: f64, d: &Vector3<f64>| {
            1.5 / self.rod.fiber.length() * d.cross(&conditions.at(time).gravity)
        };
        let half = self.rate + 0.5 * dt * pull(self.time, &self.direction);
        let direction = so3::exp(&(half * dt)) * self.direction;
        self.rate = half + 0.5 * dt * pull(self.time + dt, &direction);
        self.direction = direction;
        self.time += dt;
        match conditions.at(self.time).root {
            End::Held(pose) => self.root = Point3::from(pose.translation.vector),
            End::Pinned(point) => self.root = point,
            End::Loaded { .. } => {}
        }
        StepReport { iterations: 1, halvings: 0, residual: 0.0 }
    }

    fn state(&self) -> RodState {
        let s = self.rod.fiber.arc_lengths();
        let (nodes, segments) = (s.len(), s.len() - 1);
        let frame = so3::between(&Vector3::z(), &self.direction)
            .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
        RodState {
            time: self.time,
            positions: s.iter().map(|s| self.root + *s * self.direction).collect(),
            velocities: s.iter().map(|s| *s * self.rate.cross(&self.direction)).collect(),
            frames: vec![frame; segments],
            angular_velocities: vec![frame.inverse() * self.rate; segments],
            forces: vec![Vector3::zeros(); segments],
            curvatures: vec![Vector3::zeros(); nodes],
        }
    }

    fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        let (length, mass) = (self.rod.fiber.length(), self.rod.fiber.mass());
        let center = self.root.coords + 0.5 * length * self.direction;
        Energy {
            kinetic: mass * length * length / 6.0 * self.rate.norm_squared(),
            elastic: 0.0,
            gravitational: -mass * gravity.dot(&center),
        }
    }
}

impl Batch for Pendulums {
    fn state(&self, lane: usize) -> RodState {
        self.0[lane].state()
    }

    fn energy(&self, lane: usize, gravity: &Vector3<f64>) -> Energy {
        self.0[lane].energy(gravity)
    }

    fn set_node_forces(&mut self, _: usize, _: &[Vector3<f64>]) -> Result<(), RodError> {
        Ok(())
    }

    fn step(&mut self, dt: f64, lanes: &[&dyn Conditions]) -> Result<StepReport, StepError> {
        let reports = self.0.iter_mut().zip(lanes).map(|(p, c)| p.step(dt, *c));
        Ok(reports.fold(StepReport::default(), |_, report| report))
    }

    fn save(&self, numbers: &mut Vec<f64>) {
        for p in &self.0 {
            numbers.push(p.time);
            numbers.extend(p.root.coords.iter().chain(&p.direction).chain(&p.rate));
        }
    }

    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError> {
        let (expected, found) = (10 * self.0.len(), numbers.len());
        if expected != found {
            return Err(RodError::Length { what: "saved numbers", expected, found });
        }
        for (p, n) in self.0.iter_mut().zip(numbers.chunks(10)) {
            p.time = n[0];
            p.root = Point3::new(n[1], n[2], n[3]);
            p.direction = Vector3::new(n[4], n[5], n[6]);
            p.rate = Vector3::new(n[7], n[8], n[9]);
        }
        Ok(())
    }
}
