use crate::{EndSupport, Load, Restraint, RodError, StepError};
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_fiber::Fiber;

/// Boundary condition at one end of a rod.
///
/// The variant may change between steps (a held end may be released) but not within one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// Position and material frame are prescribed: a clamp, at rest or moving.
    Held(Isometry3<f64>),
    /// The position is prescribed and the frame is free, under a moment: a ball joint.
    Pinned {
        /// Position, m, world.
        position: Point3<f64>,
        /// Moment on the rod, N m.
        moment: Load,
    },
    /// Free, under a force (N) and a moment (N m) that act on the rod.
    Loaded {
        /// Force on the rod, N.
        force: Load,
        /// Moment on the rod, N m.
        moment: Load,
    },
    /// Each of the six freedoms is held, sprung or free by itself. The integrator of the staggered
    /// chain has such ends, [`crate::BoxIntegrator`] and the linear analysis refuse them.
    Supported(EndSupport),
}

impl End {
    /// A free end without load.
    pub const FREE: Self = Self::Loaded { force: Load::ZERO, moment: Load::ZERO };

    /// A ball joint at `position` (m, world) without moment.
    #[must_use]
    pub fn pinned(position: Point3<f64>) -> Self {
        Self::Pinned { position, moment: Load::ZERO }
    }

    /// Whether the position is prescribed whole.
    #[must_use]
    pub fn holds_position(&self) -> bool {
        match self {
            Self::Held(_) | Self::Pinned { .. } => true,
            Self::Loaded { .. } => false,
            Self::Supported(support) => {
                support.translations.iter().all(|one| *one == Restraint::Held)
            }
        }
    }
}

/// Linear drag coefficients of a fibre in slow flow, force per length and speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drag {
    /// Drag coefficient across the fibre, N s / m^2.
    pub normal: f64,
    /// Drag coefficient along the fibre, N s / m^2.
    pub tangential: f64,
}

impl Drag {
    /// Slender-body drag of a cylinder in creeping flow (Cox 1970): `4 pi mu / (ln(L/r) + 0.193)`
    /// across and `2 pi mu / (ln(L/r) - 0.807)` along, `mu` the dynamic viscosity in Pa s.
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless `viscosity >= 0` and `length > 3 radius > 0`.
    pub fn slender_body(viscosity: f64, length: f64, radius: f64) -> Result<Self, RodError> {
        let ok = viscosity >= 0.0 && radius > 0.0 && length > 3.0 * radius;
        if !(ok && viscosity.is_finite() && length.is_finite()) {
            return Err(RodError::Invalid {
                what: "drag",
                why: "needs viscosity >= 0 (Pa s) and length > 3 radius > 0 (m)",
            });
        }
        let slenderness = (length / radius).ln();
        let unit = std::f64::consts::PI * viscosity;
        Ok(Self {
            normal: 4.0 * unit / (slenderness + 0.193),
            tangential: 2.0 * unit / (slenderness - 0.807),
        })
    }
}

/// The air around a rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Air {
    /// Wind velocity, m/s, world frame.
    pub wind: Vector3<f64>,
    /// Drag coefficients of the fibre, for its velocity relative to the wind.
    pub drag: Drag,
}

/// Everything that acts on a rod at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// Acceleration of free fall, m/s^2, world frame.
    pub gravity: Vector3<f64>,
    /// Uniform force per length, N/m, world frame.
    pub distributed: Vector3<f64>,
    /// Boundary condition at the root (arc length 0).
    pub root: End,
    /// Boundary condition at the tip (arc length L).
    pub tip: End,
    /// Wind and drag, `None` for no air.
    pub air: Option<Air>,
    /// Length of the rod, from the root on, that is inside a nozzle, m, zero for none: straight on
    /// from the root, which is then held, in its frame, and without weight. The integrator of the
    /// staggered chain has nozzles, [`crate::BoxIntegrator`] and the linear analysis refuse them.
    pub inside: f64,
}

impl Instant {
    /// A rod clamped at `root`, its tip free, under `gravity`.
    #[must_use]
    pub fn clamped(root: Isometry3<f64>, gravity: Vector3<f64>) -> Self {
        Self {
            gravity,
            distributed: Vector3::zeros(),
            root: End::Held(root),
            tip: End::FREE,
            air: None,
            inside: 0.0,
        }
    }

    /// Dead load of `node`, N, world: gravity and the distributed force on half of the segments on
    /// both sides, and its own of `node_forces`, if there are any. `node` is not the root.
    pub(crate) fn node_load(
        &self,
        fiber: &Fiber,
        node_forces: &[Vector3<f64>],
        node: usize,
    ) -> Vector3<f64> {
        let (mut mass, mut length) = (0.0, 0.0);
        for segment in (node - 1)..(node + 1).min(fiber.segments()) {
            mass += 0.5 * fiber.segment_mass(segment);
            length += 0.5 * fiber.segment_lengths()[segment];
        }
        let own = node_forces.get(node).copied().unwrap_or_default();
        self.gravity * mass + self.distributed * length + own
    }

    /// Checks the numbers of conditions at `time`, s.
    ///
    /// # Errors
    /// [`StepError::Conditions`] unless all numbers are finite and `0 <= tangential <= normal` for
    /// drag.
    pub(crate) fn check(&self, time: f64) -> Result<(), StepError> {
        let finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
        let end_is_finite = |end: &End| match end {
            End::Held(pose) => {
                finite(&pose.translation.vector)
                    && pose.rotation.coords.iter().all(|x| x.is_finite())
            }
            End::Pinned { position, moment } => {
                finite(&position.coords) && finite(moment.components())
            }
            End::Loaded { force, moment } => {
                [force, moment].into_iter().map(Load::components).all(finite)
            }
            End::Supported(support) => support.is_sound(),
        };
        let air_is_sound = |Air { wind, drag: Drag { normal, tangential } }: &Air| {
            finite(wind) && normal >= tangential && *tangential >= 0.0 && normal.is_finite()
        };
        let parts = [
            ("gravity", finite(&self.gravity)),
            ("the distributed force", finite(&self.distributed)),
            ("the root", end_is_finite(&self.root)),
            ("the tip", end_is_finite(&self.tip)),
            ("the air", self.air.as_ref().is_none_or(air_is_sound)),
            ("the length inside the nozzle", self.inside.is_finite()),
        ];
        match parts.into_iter().find(|(_, sound)| !sound) {
            None => Ok(()),
            Some((what, _)) => Err(StepError::Conditions {
                fiber: 0,
                what,
                time,
                why: "every number must be finite, stiffness not negative, and \
                      0 <= tangential <= normal drag",
            }),
        }
    }
}

/// Conditions as a function of time. Any `Fn(f64) -> Instant` is one.
///
/// Must be a pure function of time: steps that are halved or repeated evaluate it again.
pub trait Conditions: Sync {
    /// The conditions at time `t`, s.
    fn at(&self, t: f64) -> Instant;
}

impl<F: Fn(f64) -> Instant + Sync> Conditions for F {
    fn at(&self, t: f64) -> Instant {
        self(t)
    }
}

/// Conditions that are constant in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steady(pub Instant);

impl Conditions for Steady {
    fn at(&self, _: f64) -> Instant {
        self.0
    }
}
