use super::coefficients::Coefficients;
use super::motion::{HeldMotion, NodePose};
use crate::{Conditions, End, Instant, StepError};
use nalgebra::{Isometry3, Rotation3};

/// Conditions of one step at its start, its middle, its end, and its stage.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    start: Instant,
    middle: Instant,
    end: Instant,
    /// Conditions at the stage, where forces act.
    pub(super) stage: Instant,
}

/// One of the two ends of a rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Side {
    Root,
    Tip,
}

impl Side {
    fn of(self, instant: &Instant) -> End {
        match self {
            Self::Root => instant.root,
            Self::Tip => instant.tip,
        }
    }
}

impl Span {
    pub(super) fn sample(
        conditions: &dyn Conditions,
        time: f64,
        dt: f64,
        coefficients: &Coefficients,
    ) -> Result<Self, StepError> {
        let at = |fraction: f64| {
            let t = time + fraction * dt;
            let instant = conditions.at(t);
            instant.check(t)?;
            if [instant.root, instant.tip].iter().any(|end| matches!(end, End::Supported(_))) {
                let why = "the box scheme holds a whole end only: take the staggered chain";
                return Err(StepError::Conditions { fiber: 0, what: "end", time: t, why });
            }
            if instant.inside != 0.0 {
                let why = "the box scheme has none: take the staggered chain";
                return Err(StepError::Conditions { fiber: 0, what: "nozzle", time: t, why });
            }
            Ok(instant)
        };
        Ok(Self {
            start: at(0.0)?,
            middle: at(0.5)?,
            end: at(1.0)?,
            stage: at(coefficients.stage())?,
        })
    }

    /// Boundary condition of an end in this step. Its kind is the one in the middle of the step,
    /// since at the boundaries the conditions of neighbouring steps meet; a load has its value at
    /// the stage.
    pub(super) fn end(&self, side: Side) -> End {
        match (side.of(&self.middle), side.of(&self.stage)) {
            (End::Loaded { .. }, load @ End::Loaded { .. })
            | (End::Pinned { .. }, load @ End::Pinned { .. }) => load,
            (end, _) => end,
        }
    }

    /// Poses of a held or pinned end at the beginning, in the middle and at the end of the step.
    fn poses(&self, side: Side, now: &NodePose) -> Option<[NodePose; 3]> {
        let pose = |instant: &Instant| pose(&side.of(instant), now.frame);
        let middle = pose(&self.middle)?;
        let start = pose(&self.start).unwrap_or(*now);
        let end = pose(&self.end).unwrap_or_else(|| middle.beyond(&start));
        Some([start, middle, end])
    }

    /// Motion of a held or pinned root from its present pose. A support that starts the step
    /// elsewhere has jumped: the root then travels on a straight line to the support's last pose.
    pub(super) fn root_motion(&self, now: &NodePose, length: f64) -> Option<HeldMotion> {
        let [start, middle, end] = self.poses(Side::Root, now)?;
        Some(if start.is(now, length) {
            HeldMotion::through(start, middle, end)
        } else {
            HeldMotion::through(*now, now.half_way(&end), end)
        })
    }

    /// Motion of the support of a held or pinned tip, and the pose where it starts.
    pub(super) fn tip_motion(&self, now: &NodePose) -> Option<(HeldMotion, NodePose)> {
        let [start, middle, end] = self.poses(Side::Tip, now)?;
        Some((HeldMotion::through(start, middle, end), start))
    }
}

/// The prescribed pose, with `frame` where the frame is free.
fn pose(end: &End, frame: Rotation3<f64>) -> Option<NodePose> {
    match end {
        End::Held(Isometry3 { rotation, translation }) => {
            Some(NodePose { position: translation.vector, frame: rotation.to_rotation_matrix() })
        }
        End::Pinned { position, .. } => Some(NodePose { position: position.coords, frame }),
        End::Loaded { .. } | End::Supported(_) => None,
    }
}
