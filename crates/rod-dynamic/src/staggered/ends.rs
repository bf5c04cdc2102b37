//! Boundary conditions of the two ends of each fibre of a SIMD batch.

use super::array::{at, set};
use crate::support::Restraints;
use crate::{End, Instant, Load};
use nalgebra::Vector3;
use pulp::Simd;
use pulp::bytemuck::Zeroable;

/// Boundary conditions of both ends in all lanes; flags are 0 or 1 in each lane.
#[derive(Clone, Copy)]
pub(super) struct Ends<S: Simd> {
    /// 1 where the root's position is free.
    pub(super) root_free: S::f64s,
    /// 1 where a joint clamps the root's frame.
    pub(super) root_joint: S::f64s,
    /// Length of the rod that is inside a nozzle, m.
    pub(super) inside: S::f64s,
    pub(super) root_position: [S::f64s; 3],
    pub(super) root_frame: [S::f64s; 4],
    /// 1 where the tip's position is held.
    pub(super) tip_held: S::f64s,
    /// 1 where a joint clamps the tip's frame.
    pub(super) tip_joint: S::f64s,
    pub(super) tip_position: [S::f64s; 3],
    pub(super) tip_frame: [S::f64s; 4],
    /// Force on the root, N: world components, then follower components.
    pub(super) root_force: [[S::f64s; 3]; 2],
    /// Moment on the root, N m: world components, then follower components.
    pub(super) root_moment: [[S::f64s; 3]; 2],
    /// Force on the tip, N: world components, then follower components.
    pub(super) tip_force: [[S::f64s; 3]; 2],
    /// Moment on the tip, N m: world components, then follower components.
    pub(super) tip_moment: [[S::f64s; 3]; 2],
    /// Force in the last segment where the tip is held, N, world: an additional unknown.
    pub(super) tip_reaction: [S::f64s; 3],
    /// Whether any lane has a free root.
    pub(super) any_root_free: bool,
    /// 1 where moments or follower forces act, which have no potential.
    pub(super) circulatory: S::f64s,
    /// Whether moments or follower forces act in any lane.
    pub(super) any_circulatory: bool,
}

/// How the position of an [`End`] is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EndKind {
    Held,
    Loaded,
    /// Along each axis by itself.
    Supported,
}

/// Kinds of the two ends of one lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Held {
    pub(super) root: EndKind,
    pub(super) tip: EndKind,
    /// Whether all loads have a potential; moments and follower forces have none.
    pub(super) conservative: bool,
    /// Whether an end has a support of freedoms one by one.
    pub(super) supported: bool,
}

impl Held {
    /// A clamped root and a free tip: placeholder for lanes that are not in use.
    pub(super) const CLAMPED: Self =
        Self { root: EndKind::Held, tip: EndKind::Loaded, conservative: true, supported: false };

    /// Whether the step minimises the potential freely; a held tip makes it a problem of saddle
    /// points, where the energy of an iterate that leaves a gap says nothing. That of supports is
    /// not counted.
    #[inline(always)]
    pub(super) fn minimizes(&self) -> bool {
        self.conservative && !self.supported && self.tip == EndKind::Loaded
    }
}

impl<S: Simd> Ends<S> {
    pub(super) fn new() -> Self {
        let zero = S::f64s::zeroed();
        let load = [[zero; 3]; 2];
        Self {
            root_free: zero,
            root_joint: zero,
            inside: zero,
            root_position: [zero; 3],
            root_frame: [zero; 4],
            tip_held: zero,
            tip_joint: zero,
            tip_position: [zero; 3],
            tip_frame: [zero; 4],
            root_force: load,
            root_moment: load,
            tip_force: load,
            tip_moment: load,
            tip_reaction: [zero; 3],
            any_root_free: false,
            circulatory: zero,
            any_circulatory: false,
        }
    }

    /// Whether joints clamp the frames of the root and of the tip in one lane.
    pub(super) fn joined(&self, lane: usize) -> [bool; 2] {
        [self.root_joint, self.tip_joint].map(|flag| at(std::slice::from_ref(&flag), 0, lane) > 0.0)
    }

    /// Marks both frames of one lane as clamped, until its conditions are set.
    pub(super) fn join(&mut self, lane: usize) {
        for flag in [&mut self.root_joint, &mut self.tip_joint] {
            put(std::slice::from_mut(flag), lane, &[1.0]);
        }
    }

    /// Restores what belongs to the state from `old`: flags, reactions, and what is in a nozzle.
    pub(super) fn put_back(&mut self, old: &Self) {
        (self.root_free, self.root_joint) = (old.root_free, old.root_joint);
        (self.tip_held, self.tip_joint) = (old.tip_held, old.tip_joint);
        self.tip_reaction = old.tip_reaction;
        self.inside = old.inside;
    }

    /// Sets the conditions of one lane. A tip that was free until now starts from the force
    /// `reaction` (N, world).
    pub(super) fn set(&mut self, lane: usize, now: &Instant, reaction: [f64; 3]) -> Held {
        let was_held = at(std::slice::from_ref(&self.tip_held), 0, lane) > 0.0;
        let root = EndPart::of(&now.root);
        put(
            std::slice::from_mut(&mut self.root_free),
            lane,
            &[f64::from(root.kind != EndKind::Held)],
        );
        put(std::slice::from_mut(&mut self.root_joint), lane, &[f64::from(root.joint)]);
        put(&mut self.root_position, lane, root.position.as_slice());
        put(&mut self.root_frame, lane, &root.frame);
        put_load(&mut self.root_force, lane, &root.force);
        put_load(&mut self.root_moment, lane, &root.moment);
        let tip = EndPart::of(&now.tip);
        put(
            std::slice::from_mut(&mut self.tip_held),
            lane,
            &[f64::from(tip.kind == EndKind::Held)],
        );
        put(std::slice::from_mut(&mut self.tip_joint), lane, &[f64::from(tip.joint)]);
        put(&mut self.tip_position, lane, tip.position.as_slice());
        put(&mut self.tip_frame, lane, &tip.frame);
        put_load(&mut self.tip_force, lane, &tip.force);
        put_load(&mut self.tip_moment, lane, &tip.moment);
        if (!was_held && tip.kind != EndKind::Loaded) || tip.kind == EndKind::Supported {
            put(&mut self.tip_reaction, lane, &reaction);
        }
        let conservative = root.conservative() && tip.conservative();
        put(std::slice::from_mut(&mut self.circulatory), lane, &[f64::from(!conservative)]);
        let supported = [now.root, now.tip].iter().any(|end| matches!(end, End::Supported(_)));
        Held { root: root.kind, tip: tip.kind, conservative, supported }
    }
}

/// Frame in which an end is clamped, as a quaternion; the identity where it is not clamped.
pub(super) fn frame(end: &End) -> [f64; 4] {
    EndPart::of(end).frame
}

/// Components of one end, zero where its kind has none.
struct EndPart {
    kind: EndKind,
    /// Whether a joint clamps the frame.
    joint: bool,
    position: Vector3<f64>,
    frame: [f64; 4],
    force: Load,
    moment: Load,
}

impl EndPart {
    fn conservative(&self) -> bool {
        let none = |load: &Load| *load.components() == Vector3::zeros();
        none(&self.moment) && (matches!(self.force, Load::World(_)) || none(&self.force))
    }

    fn of(end: &End) -> Self {
        let none = Self {
            kind: EndKind::Held,
            joint: false,
            position: Vector3::zeros(),
            frame: [0.0, 0.0, 0.0, 1.0],
            force: Load::ZERO,
            moment: Load::ZERO,
        };
        match *end {
            End::Held(pose) => Self {
                joint: true,
                position: pose.translation.vector,
                frame: pose.rotation.coords.into(),
                ..none
            },
            End::Pinned { position, moment } => Self { position: position.coords, moment, ..none },
            End::Loaded { force, moment } => Self { kind: EndKind::Loaded, force, moment, ..none },
            End::Supported(support) => {
                let kind = match Restraints::of(&support.translations) {
                    Restraints::Held => EndKind::Held,
                    Restraints::Free => EndKind::Loaded,
                    Restraints::Mixed => EndKind::Supported,
                };
                let rotations = Restraints::of(&support.rotations);
                let joint = rotations != Restraints::Free;
                Self {
                    kind,
                    joint,
                    position: support.pose.translation.vector,
                    frame: if joint { support.pose.rotation.coords.into() } else { none.frame },
                    force: if kind == EndKind::Held { none.force } else { support.force },
                    moment: if joint { none.moment } else { support.moment },
                }
            }
        }
    }
}

fn put<T: pulp::bytemuck::Pod>(a: &mut [T], lane: usize, x: &[f64]) {
    for (i, x) in x.iter().enumerate() {
        set(a, i, lane, *x);
    }
}

fn put_load<T: pulp::bytemuck::Pod>(a: &mut [[T; 3]; 2], lane: usize, load: &Load) {
    let zero = Vector3::zeros();
    let (world, follower) = match load {
        Load::World(v) => (v, &zero),
        Load::Follower(v) => (&zero, v),
    };
    put(&mut a[0], lane, world.as_slice());
    put(&mut a[1], lane, follower.as_slice());
}
