use crate::mesh::Scaled;
use crate::rod::{EndCondition, EndHold};
use crate::step::ShootingNode;
use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;
use std::f64::consts::TAU;

/// Size of a perturbation, in units of force, lengths and radians.
const PUSH: f64 = 0.05;

/// Derivatives of the six end conditions (rows) by the state of the last node (columns).
pub(crate) type BoundaryMatrix = SMatrix<f64, 6, 12>;

/// Boundary condition at the end of the rod, in scaled units.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Goal {
    pub(crate) place: EndPlace,
    pub(crate) turning: EndTurning,
}

/// Condition on the place of the end, or the force on it.
#[derive(Debug, Clone, Copy)]
pub(crate) enum EndPlace {
    Free {
        force: Vector3<f64>,
    },
    Held {
        position: Vector3<f64>,
    },
    /// On the line through a point, with a dead force along it.
    OnLine {
        point: Vector3<f64>,
        along: Vector3<f64>,
        force: f64,
    },
}

/// Condition on the rotation of the end, or the moment on it.
#[derive(Debug, Clone, Copy)]
pub(crate) enum EndTurning {
    Free { moment: Vector3<f64> },
    Tangent { tangent: Vector3<f64>, torque: f64 },
    Held { frame: UnitQuaternion<f64> },
}

impl Goal {
    pub(crate) fn of(end: &EndCondition, units: &Scaled) -> Self {
        let held = |position: Vector3<f64>| EndPlace::Held { position: position / units.length };
        let hold = |hold: &EndHold| match *hold {
            EndHold::Joint => EndTurning::Free { moment: Vector3::zeros() },
            EndHold::Tangent(t) => EndTurning::Tangent { tangent: t.into_inner(), torque: 0.0 },
            EndHold::Frame(frame) => EndTurning::Held { frame },
        };
        let (place, turning) = match end {
            EndCondition::Free { force, moment } => (
                EndPlace::Free { force: force / units.force() },
                EndTurning::Free { moment: moment / units.energy() },
            ),
            EndCondition::Position(p) => (held(p.coords), hold(&EndHold::Joint)),
            EndCondition::Tangent(p, t) => (held(p.coords), hold(&EndHold::Tangent(*t))),
            EndCondition::Held(pose) => {
                (held(pose.translation.vector), hold(&EndHold::Frame(pose.rotation)))
            }
            EndCondition::Sliding { point, along, force, hold: turning } => (
                EndPlace::OnLine {
                    point: point.coords / units.length,
                    along: along.into_inner(),
                    force: force / units.force(),
                },
                hold(turning),
            ),
        };
        Self { place, turning }
    }

    /// The dead force on the end that does work.
    pub(crate) fn force_on_end(&self) -> Vector3<f64> {
        match self.place {
            EndPlace::Free { force } => force,
            EndPlace::Held { .. } => Vector3::zeros(),
            EndPlace::OnLine { along, force, .. } => along * force,
        }
    }

    /// The dead moment on the end.
    pub(crate) fn moment_on_end(&self) -> Vector3<f64> {
        match self.turning {
            EndTurning::Free { moment } => moment,
            EndTurning::Tangent { .. } | EndTurning::Held { .. } => Vector3::zeros(),
        }
    }

    /// Whether nothing holds the end.
    pub(crate) fn is_free(&self) -> bool {
        matches!((&self.place, &self.turning), (EndPlace::Free { .. }, EndTurning::Free { .. }))
    }

    /// The condition at the fraction `t` of the path from the state of `node` to this condition,
    /// with `turns` whole turns about the tangent along the path. `None` where a tangent or frame
    /// would turn by half a turn, whose direction is undefined.
    pub(crate) fn on_the_way(&self, node: &ShootingNode, turns: f64, t: f64) -> Option<Self> {
        let tangent = node.q * Vector3::z();
        let place = match self.place {
            EndPlace::Free { force } => EndPlace::Free { force: node.n.lerp(&force, t) },
            EndPlace::Held { position } => EndPlace::Held { position: node.r.lerp(&position, t) },
            EndPlace::OnLine { point, along, force } => EndPlace::OnLine {
                point: node.r.lerp(&point, t),
                along,
                force: (1.0 - t) * node.n.dot(&along) + t * force,
            },
        };
        let turning = match self.turning {
            EndTurning::Free { moment } => EndTurning::Free { moment: node.m.lerp(&moment, t) },
            EndTurning::Tangent { tangent: to, torque } => EndTurning::Tangent {
                tangent: so3::exp(&(so3::log(&so3::between(&tangent, &to)?) * t)) * tangent,
                torque: (1.0 - t) * node.m.dot(&tangent) + t * torque,
            },
            EndTurning::Held { frame } => {
                let way = (frame * node.q.inverse()).scaled_axis();
                let twist = Vector3::z() * (TAU * turns * t);
                let frame = UnitQuaternion::from_scaled_axis(way * t)
                    * node.q
                    * UnitQuaternion::from_scaled_axis(twist);
                EndTurning::Held { frame }
            }
        };
        Some(Self { place, turning })
    }

    /// The condition perturbed by a small force on a free end, displacement of a joint, or rotation
    /// of a direction, along an axis that is generic for every rod.
    pub(crate) fn pushed(&self) -> Self {
        let push = Vector3::new(0.48, 0.6, 0.64) * PUSH;
        let turn = UnitQuaternion::from_scaled_axis(push);
        let mut pushed = *self;
        match &mut pushed.turning {
            EndTurning::Free { .. } => match &mut pushed.place {
                EndPlace::Free { force } => *force += push,
                EndPlace::Held { position } => *position += push,
                EndPlace::OnLine { point, .. } => *point += push,
            },
            EndTurning::Tangent { tangent, .. } => *tangent = turn * *tangent,
            EndTurning::Held { frame } => *frame = turn * *frame,
        }
        pushed
    }

    /// Residual of the condition at `node`, and its derivatives. `None` where the tangent is
    /// opposite to the prescribed one.
    pub(crate) fn missed(&self, node: &ShootingNode) -> Option<(SVector<f64, 6>, BoundaryMatrix)> {
        let mut missed = SVector::<f64, 6>::zeros();
        let mut by = BoundaryMatrix::zeros();
        // Conditions on whole vectors: their first rows, residuals and first columns.
        let mut vectors: Vec<(usize, Vector3<f64>, usize)> = Vec::with_capacity(2);
        match self.place {
            EndPlace::Free { force } => vectors.push((0, node.n - force, 9)),
            EndPlace::Held { position } => vectors.push((0, node.r - position, 0)),
            EndPlace::OnLine { point, along, force } => {
                for (row, e) in across(&along).into_iter().enumerate() {
                    missed[row] = (node.r - point).dot(&e);
                    by.fixed_view_mut::<1, 3>(row, 0).copy_from(&e.transpose());
                }
                missed[2] = node.n.dot(&along) - force;
                by.fixed_view_mut::<1, 3>(2, 9).copy_from(&along.transpose());
            }
        }
        match self.turning {
            EndTurning::Free { moment } => vectors.push((3, node.m - moment, 6)),
            EndTurning::Held { frame } => {
                vectors.push((3, (node.q * frame.inverse()).scaled_axis(), 3));
            }
            EndTurning::Tangent { tangent, torque } => {
                let own = node.q * Vector3::z();
                let off = so3::log(&so3::between(&tangent, &own)?);
                for (row, e) in [3, 4].into_iter().zip(across(&tangent)) {
                    missed[row] = off.dot(&e);
                    by.fixed_view_mut::<1, 3>(row, 3).copy_from(&e.transpose());
                }
                missed[5] = node.m.dot(&own) - torque;
                by.fixed_view_mut::<1, 3>(5, 3).copy_from(&own.cross(&node.m).transpose());
                by.fixed_view_mut::<1, 3>(5, 6).copy_from(&own.transpose());
            }
        }
        for (row, value, column) in vectors {
            missed.fixed_rows_mut::<3>(row).copy_from(&value);
            by.fixed_view_mut::<3, 3>(row, column).fill_with_identity();
        }
        Some((missed, by))
    }
}

/// Two unit vectors across the unit vector `v` and each other.
fn across(v: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let mut other = Vector3::zeros();
    other[v.iamin()] = 1.0;
    let one = v.cross(&other).normalize();
    [one, v.cross(&one)]
}
