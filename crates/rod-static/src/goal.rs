use crate::mesh::Scaled;
use crate::rod::EndCondition;
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
pub(crate) enum Goal {
    Free { force: Vector3<f64>, moment: Vector3<f64> },
    Position { position: Vector3<f64>, moment: Vector3<f64> },
    Tangent { position: Vector3<f64>, tangent: Vector3<f64>, torque: f64 },
    Held { position: Vector3<f64>, frame: UnitQuaternion<f64> },
}

impl Goal {
    pub(crate) fn of(end: &EndCondition, units: &Scaled) -> Self {
        match end {
            EndCondition::Free { force, moment } => {
                Self::Free { force: force / units.force(), moment: moment / units.energy() }
            }
            EndCondition::Position(p) => {
                Self::Position { position: p.coords / units.length, moment: Vector3::zeros() }
            }
            EndCondition::Tangent(p, t) => Self::Tangent {
                position: p.coords / units.length,
                tangent: t.into_inner(),
                torque: 0.0,
            },
            EndCondition::Held(pose) => Self::Held {
                position: pose.translation.vector / units.length,
                frame: pose.rotation,
            },
        }
    }

    /// The condition at the fraction `t` of the path from the state of `node` to this condition,
    /// with `turns` whole turns about the tangent along the path. `None` where a tangent or frame
    /// would turn by half a turn, whose direction is undefined.
    pub(crate) fn on_the_way(&self, node: &ShootingNode, turns: f64, t: f64) -> Option<Self> {
        let tangent = node.q * Vector3::z();
        Some(match *self {
            Self::Free { force, moment } => {
                Self::Free { force: node.n.lerp(&force, t), moment: node.m.lerp(&moment, t) }
            }
            Self::Position { position, moment } => Self::Position {
                position: node.r.lerp(&position, t),
                moment: node.m.lerp(&moment, t),
            },
            Self::Tangent { position, tangent: to, torque } => Self::Tangent {
                position: node.r.lerp(&position, t),
                tangent: so3::exp(&(so3::log(&so3::between(&tangent, &to)?) * t)) * tangent,
                torque: (1.0 - t) * node.m.dot(&tangent) + t * torque,
            },
            Self::Held { position, frame } => {
                let way = (frame * node.q.inverse()).scaled_axis();
                let twist = Vector3::z() * (TAU * turns * t);
                Self::Held {
                    position: node.r.lerp(&position, t),
                    frame: UnitQuaternion::from_scaled_axis(way * t)
                        * node.q
                        * UnitQuaternion::from_scaled_axis(twist),
                }
            }
        })
    }

    /// The condition perturbed by a small force on a free end, displacement of a joint, or rotation
    /// of a direction, along an axis that is generic for every rod.
    pub(crate) fn pushed(&self) -> Self {
        let push = Vector3::new(0.48, 0.6, 0.64) * PUSH;
        let turn = UnitQuaternion::from_scaled_axis(push);
        match *self {
            Self::Free { force, moment } => Self::Free { force: force + push, moment },
            Self::Position { position, moment } => {
                Self::Position { position: position + push, moment }
            }
            Self::Tangent { position, tangent, torque } => {
                Self::Tangent { position, tangent: turn * tangent, torque }
            }
            Self::Held { position, frame } => Self::Held { position, frame: turn * frame },
        }
    }

    /// Residual of the condition at `node`, and its derivatives. `None` where the tangent is
    /// opposite to the prescribed one.
    pub(crate) fn missed(&self, node: &ShootingNode) -> Option<(SVector<f64, 6>, BoundaryMatrix)> {
        let mut missed = SVector::<f64, 6>::zeros();
        let mut by = BoundaryMatrix::zeros();
        let mut set = |row: usize, value: Vector3<f64>, column: usize| {
            missed.fixed_rows_mut::<3>(row).copy_from(&value);
            by.fixed_view_mut::<3, 3>(row, column).fill_with_identity();
        };
        match self {
            Self::Free { force, moment } => {
                set(0, node.n - force, 9);
                set(3, node.m - moment, 6);
            }
            Self::Position { position, moment } => {
                set(0, node.r - position, 0);
                set(3, node.m - moment, 6);
            }
            Self::Held { position, frame } => {
                set(0, node.r - position, 0);
                set(3, (node.q * frame.inverse()).scaled_axis(), 3);
            }
            Self::Tangent { position, tangent, torque } => {
                set(0, node.r - position, 0);
                let own = node.q * Vector3::z();
                let off = so3::log(&so3::between(tangent, &own)?);
                let across = tangent.cross(&any_other(tangent)).normalize();
                for (row, e) in [(3, across), (4, tangent.cross(&across))] {
                    missed[row] = off.dot(&e);
                    by.fixed_view_mut::<1, 3>(row, 3).copy_from(&e.transpose());
                }
                missed[5] = node.m.dot(&own) - torque;
                by.fixed_view_mut::<1, 3>(5, 3).copy_from(&own.cross(&node.m).transpose());
                by.fixed_view_mut::<1, 3>(5, 6).copy_from(&own.transpose());
            }
        }
        Some((missed, by))
    }
}

/// A unit vector along the world axis that is farthest from the direction of `v`.
fn any_other(v: &Vector3<f64>) -> Vector3<f64> {
    let mut other = Vector3::zeros();
    other[v.iamin()] = 1.0;
    other
}
