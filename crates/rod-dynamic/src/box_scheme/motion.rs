use nalgebra::{Rotation3, Vector3};
use rapunzel_fiber::so3;

/// A position and a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NodePose {
    pub(super) position: Vector3<f64>,
    pub(super) frame: Rotation3<f64>,
}

impl NodePose {
    /// Whether `other` is the same pose up to rounding, for positions of magnitude `length`.
    pub(super) fn is(&self, other: &Self, length: f64) -> bool {
        let turn = so3::log(&(self.frame.inverse() * other.frame));
        (self.position - other.position).norm() <= 1e-9 * length && turn.norm() <= 1e-9
    }

    /// The pose that lies as far beyond `self` as `self` lies beyond `before`.
    pub(super) fn beyond(&self, before: &Self) -> Self {
        Self {
            position: 2.0 * self.position - before.position,
            frame: self.frame * (before.frame.inverse() * self.frame),
        }
    }

    /// The pose half way from `self` to `end`.
    pub(super) fn half_way(&self, end: &Self) -> Self {
        let turn = so3::log(&(self.frame.inverse() * end.frame));
        Self {
            position: 0.5 * (self.position + end.position),
            frame: self.frame * so3::exp(&(0.5 * turn)),
        }
    }
}

/// The motion of a held end during a step: the parabola through its poses at the beginning, in
/// the middle and at the end, whose velocity is exact to second order anywhere in the step. The
/// end must turn by less than pi in a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldMotion {
    start: NodePose,
    middle: NodePose,
    pub(super) end: NodePose,
}

/// A pose with its rates: velocity (world) and angular velocity (material frame), per step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving {
    pub(super) frame: Rotation3<f64>,
    pub(super) velocity: Vector3<f64>,
    pub(super) angular_velocity: Vector3<f64>,
}

impl Moving {
    /// A pose with the given frame and zero rates.
    pub(super) fn still(frame: Rotation3<f64>) -> Self {
        Self { frame, velocity: Vector3::zeros(), angular_velocity: Vector3::zeros() }
    }
}

impl HeldMotion {
    pub(super) fn through(start: NodePose, middle: NodePose, end: NodePose) -> Self {
        Self { start, middle, end }
    }

    /// Frame and rates at the fraction `s` of the step; rates are per step.
    pub(super) fn at(&self, s: f64) -> Moving {
        let turn = |p: &NodePose| so3::log(&(self.start.frame.inverse() * p.frame));
        let slope = |a: Vector3<f64>, b: Vector3<f64>| (4.0 * a - b) + 4.0 * s * (b - 2.0 * a);
        let shift = |p: &NodePose| p.position - self.start.position;
        let (a, b) = (turn(&self.middle), turn(&self.end));
        let angle = s * (4.0 * a - b) + 2.0 * s * s * (b - 2.0 * a);
        Moving {
            frame: self.start.frame * so3::exp(&angle),
            velocity: slope(shift(&self.middle), shift(&self.end)),
            angular_velocity: so3::right_jacobian(&angle) * slope(a, b),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_parabola_is_followed_exactly() {
        // x = t + 3 t^2 along x, turning about z by 2 t - t^2.
        let pose = |t: f64| NodePose {
            position: Vector3::new(t + 3.0 * t * t, 1.0, 0.0),
            frame: so3::exp(&Vector3::new(0.0, 0.0, 2.0 * t - t * t)),
        };
        let motion = HeldMotion::through(pose(0.0), pose(0.5), pose(1.0));
        for s in [0.0, 0.3, 0.5, 1.0] {
            let m = motion.at(s);
            assert_relative_eq!(m.velocity.x, 1.0 + 6.0 * s, epsilon = 1e-13);
            assert_relative_eq!(m.angular_velocity.z, 2.0 - 2.0 * s, epsilon = 1e-13);
            assert_relative_eq!(m.frame.matrix(), pose(s).frame.matrix(), epsilon = 1e-13);
        }
    }
}
