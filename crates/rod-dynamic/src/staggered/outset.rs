use super::array::Array;
use super::ends::Ends;
use pulp::Simd;
use pulp::bytemuck::Zeroable;

/// State of the two ends at the start of a step, for the ledger; index 0 is the root, 1 the tip.
pub(super) struct Outset<S: Simd> {
    pub(super) frames: [[S::f64s; 4]; 2],
    /// Forces in the first and the last segment, N, world.
    pub(super) forces: [[S::f64s; 3]; 2],
    /// Elastic energies of the joints at the two ends, J, zero where there is none.
    pub(super) stored: [S::f64s; 2],
    /// Elastic energy of all other joints, J, of fibres that are fed through a nozzle.
    pub(super) bent: S::f64s,
    /// Force and moment of the loads on supported ends, N and N m, world; zero at others.
    pub(super) loads: [[[S::f64s; 3]; 2]; 2],
    /// Weight of the reactions after the step in their mean over the step; the reactions before it
    /// have the rest.
    pub(super) share: S::f64s,
}

impl<S: Simd> Outset<S> {
    pub(super) fn new() -> Self {
        let zero = S::f64s::zeroed();
        Self {
            frames: [[zero; 4]; 2],
            forces: [[zero; 3]; 2],
            stored: [zero; 2],
            bent: zero,
            loads: [[[zero; 3]; 2]; 2],
            share: zero,
        }
    }
}

/// State that an attempt at a step changes.
pub(super) struct Before<S: Simd> {
    /// Rotations of the segments as quaternions (4 per segment).
    pub(super) q: Array<S>,
    /// Forces in the segments, N (3 per segment).
    pub(super) force: Array<S>,
    /// Rotation vectors of the joints (3 per joint), if they were measured at the start of a
    /// motion.
    pub(super) phi: Array<S>,
    pub(super) ends: Ends<S>,
}
