use super::elimination::EndRows;
use super::unknowns::{NodeLaw, Scales, Unknowns};
use crate::Load;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rapunzel_fiber::so3::hat;

/// A force or a moment: a part that keeps its direction in the world and one that follows the
/// material frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct MixedLoad {
    pub(super) world: Vector3<f64>,
    pub(super) follower: Vector3<f64>,
}

impl MixedLoad {
    /// A load divided by `unit`.
    pub(super) fn new(load: &Load, unit: f64) -> Self {
        let zero = Vector3::zeros();
        match load {
            Load::World(v) => Self { world: v / unit, follower: zero },
            Load::Follower(v) => Self { world: zero, follower: v / unit },
        }
    }
}

/// Boundary condition of an end at the stage of a step, in the units of the solver.
#[derive(Debug, Clone, Copy)]
pub(super) enum StageEnd {
    /// Velocity (world) and angular velocity (material frame) are prescribed.
    Held { velocity: Vector3<f64>, angular_velocity: Vector3<f64> },
    /// The velocity (world) is prescribed, and a moment acts on the rod.
    Pinned { velocity: Vector3<f64>, moment: MixedLoad },
    /// A force and a moment act on the rod.
    Loaded { force: MixedLoad, moment: MixedLoad },
}

impl StageEnd {
    /// Scales of the two triples of conditions, by their kind.
    pub(super) fn scales(&self, scales: &Scales) -> [f64; 2] {
        let Scales { end_velocity, end_load, .. } = *scales;
        match self {
            Self::Held { .. } => [end_velocity; 2],
            Self::Pinned { .. } => [end_velocity, end_load],
            Self::Loaded { .. } => [end_load; 2],
        }
    }
}

/// Residuals of the six conditions of an end: first for velocity or force, then for angular
/// velocity or moment. `side` is 1 at the tip and -1 at the root, where the load on the rod is
/// minus the internal force.
pub(super) fn residual(
    end: &StageEnd,
    side: f64,
    x: &Unknowns,
    law: &NodeLaw,
    frame: &Rotation3<f64>,
) -> [f64; 6] {
    let local = |load: &MixedLoad| frame.inverse() * load.world + load.follower;
    let (a, b) = match end {
        StageEnd::Held { velocity, angular_velocity } => {
            (x.v - frame.inverse() * velocity, x.omega - angular_velocity)
        }
        StageEnd::Pinned { velocity, moment } => {
            (x.v - frame.inverse() * velocity, law.moment(&x.kappa) - side * local(moment))
        }
        StageEnd::Loaded { force, moment } => {
            (x.n - side * local(force), law.moment(&x.kappa) - side * local(moment))
        }
    };
    [a.x, a.y, a.z, b.x, b.y, b.z]
}

/// The six conditions of an end, linearised.
pub(super) fn rows(
    end: &StageEnd,
    side: f64,
    residual: &[f64; 6],
    law: &NodeLaw,
    frame: &Rotation3<f64>,
) -> EndRows {
    let mut rows =
        EndRows { unknowns: [[0.0; 12]; 6], rotation: [[0.0; 3]; 6], rhs: residual.map(|r| -r) };
    let mut diagonal = |row: usize, col: usize, d: &Vector3<f64>| {
        for i in 0..3 {
            rows.unknowns[row + i][col + i] = d[i];
        }
    };
    let one = Vector3::repeat(1.0);
    // d(R^T f) = hat(R^T f) theta.
    let turned = |w: &Vector3<f64>| -hat(&(frame.inverse() * w));
    let (upper, lower) = match end {
        StageEnd::Held { velocity, .. } => {
            diagonal(0, 0, &one);
            diagonal(3, 3, &one);
            (turned(velocity), Matrix3::zeros())
        }
        StageEnd::Pinned { velocity, moment } => {
            diagonal(0, 0, &one);
            diagonal(3, 6, &law.stiffness);
            (turned(velocity), side * turned(&moment.world))
        }
        StageEnd::Loaded { force, moment } => {
            diagonal(0, 9, &one);
            diagonal(3, 6, &law.stiffness);
            (side * turned(&force.world), side * turned(&moment.world))
        }
    };
    for i in 0..3 {
        for j in 0..3 {
            rows.rotation[i][j] = upper[(i, j)];
            rows.rotation[3 + i][j] = lower[(i, j)];
        }
    }
    rows
}
