use super::link::wall;
use super::{ChainForm, CylinderChain};
use crate::{ContactError, RigidBody};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rapunzel_fiber::so3;

/// Time integration of the springs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coupling {
    /// Text of the thesis (8.5.3): angular impulses `dt K (kappa - kappa_0)` at the start of the
    /// step. Stable for steps shorter than about `ds^2 sqrt(rho A / EI) / 4`, and for torsion
    /// `ds sqrt(rho / G)`.
    Explicit,
    /// The angular impulses are unknowns of the joint's Newton system with the curvature at the end
    /// of the step: stable for any step, with the numerical damping of implicit Euler.
    Implicit,
    /// Angular impulses for infinite stiffness: the orientation joint of (8.84) to (8.88),
    /// by the vector `log(R*^T R_k^T R_l)`, which is zero where the axial vector of the erratum is.
    Rigid,
}

/// Bending and torsion springs of a chain.
#[derive(Debug, Clone, PartialEq)]
pub struct JointSprings {
    /// Stiffnesses `E I_1`, `E I_2`, `G J`, N m^2.
    pub stiffness: Vector3<f64>,
    /// Natural curvature of every joint, in the mean material frame, 1/m.
    pub natural: Vec<Vector3<f64>>,
    /// Time integration of the springs.
    pub coupling: Coupling,
}

impl JointSprings {
    pub(super) fn check(&self, joints: usize) -> Result<(), ContactError> {
        if self.natural.len() != joints {
            let (what, found) = ("natural curvatures of a chain's joints", self.natural.len());
            return Err(ContactError::Length { what, expected: joints, found });
        }
        match self.stiffness.iter().find(|k| !(**k > 0.0 && k.is_finite())) {
            Some(&value) => {
                let (what, why) = ("stiffness of a chain", "must be > 0 N m^2");
                Err(ContactError::Invalid { what, value, why })
            }
            None => Ok(()),
        }
    }

    /// Diagonal of the compliance, 1/(N m^2).
    pub(super) fn compliance(&self) -> Matrix3<f64> {
        match self.coupling {
            Coupling::Rigid => Matrix3::zeros(),
            _ => Matrix3::from_diagonal(&self.stiffness.map(|k| 1.0 / k)),
        }
    }
}

/// A joint as its springs see it: the frames on its two sides and their distance.
pub(super) struct BendSpring {
    pub(super) distance: f64,
    /// `log(R_k^T R_l)`, the same in the frames of `k`, of `l` and the mean one.
    pub(super) angle: Vector3<f64>,
    /// Between the two.
    pub(super) mean: Rotation3<f64>,
}

impl CylinderChain {
    /// The joints' frames, root to tip; `None` for a hinge of the root, which has no springs.
    pub(super) fn bends(&self) -> Vec<Option<BendSpring>> {
        let frame = |i: usize| self.segments[i].pose.rotation.to_rotation_matrix();
        let held = wall(self).map(|(_, frame)| {
            frame.map(|wall| {
                bend(
                    self.half_lengths[0],
                    &wall,
                    &self.segments[0].pose.rotation.to_rotation_matrix(),
                )
            })
        });
        let inner = (1..self.segments.len()).map(|l| {
            let distance = self.half_lengths[l - 1] + self.half_lengths[l];
            Some(bend(distance, &frame(l - 1), &frame(l)))
        });
        held.into_iter().chain(inner).collect()
    }

    /// Curvature of every joint in its mean material frame, 1/m, `log(R_k^T R_l) / ds`: (8.102) to
    /// (8.104), corrected. Zero for a hinge of the root.
    #[must_use]
    pub fn curvatures(&self) -> Vec<Vector3<f64>> {
        let curvature = |bend: &BendSpring| bend.angle / bend.distance;
        self.bends().iter().map(|b| b.as_ref().map_or_else(Vector3::zeros, curvature)).collect()
    }

    /// Elastic energy of the springs, J.
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        let Some(springs) = &self.springs else { return 0.0 };
        self.bends()
            .iter()
            .zip(&springs.natural)
            .filter_map(|(bend, natural)| bend.as_ref().map(|bend| (bend, natural)))
            .map(|(bend, natural)| {
                let strain = bend.angle / bend.distance - natural;
                0.5 * bend.distance * strain.dot(&springs.stiffness.component_mul(&strain))
            })
            .sum()
    }

    /// Angular impulses (N m s, world) of explicit springs on every segment in a step of `dt`.
    pub(super) fn spring_impulses(&self, dt: f64, form: &ChainForm) -> Vec<Vector3<f64>> {
        let mut impulses = vec![Vector3::zeros(); self.segments.len()];
        let Some(springs) = self.springs.as_ref().filter(|s| s.coupling == Coupling::Explicit)
        else {
            return impulses;
        };
        let first = self.segments.len() - self.joints();
        for (joint, bend) in self.bends().iter().enumerate() {
            let Some(bend) = bend else { continue };
            let strain = if form.curvature.is_corrected() {
                bend.angle / bend.distance - springs.natural[joint]
            } else {
                self.printed_curvature[joint]
            };
            let impulse = dt * (bend.mean * springs.stiffness.component_mul(&strain));
            let l = joint + first;
            impulses[l] -= impulse;
            if l > 0 {
                impulses[l - 1] += impulse;
            }
        }
        impulses
    }

    /// The printed rule's curvatures after a step; `before` are the segments at its start.
    pub(super) fn print_curvatures(&mut self, before: &[RigidBody], dt: f64) {
        let Some(springs) = &self.springs else { return };
        let rate = |i: usize| before[i].angular_velocity() + self.segments[i].angular_velocity();
        let first = self.segments.len() - self.joints();
        for joint in 0..self.joints() {
            let l = joint + first;
            let (other, frame_k) = match l.checked_sub(1) {
                Some(k) => (rate(k), before[k].pose.rotation),
                None => (Vector3::zeros(), before[l].pose.rotation),
            };
            let frame_l = before[l].pose.rotation;
            let in_l = frame_l.inverse_transform_vector(&(rate(l) - other));
            let along =
                rate(l).dot(&(frame_l * Vector3::z())) - other.dot(&(frame_k * Vector3::z()));
            let change = 0.5 * dt * Vector3::new(in_l.x, in_l.y, along);
            self.printed_curvature[joint] += change - springs.natural[joint];
        }
    }
}

fn bend(distance: f64, k: &Rotation3<f64>, l: &Rotation3<f64>) -> BendSpring {
    let angle = so3::log(&(k.inverse() * l));
    BendSpring { distance, angle, mean: k * so3::exp(&(0.5 * angle)) }
}
