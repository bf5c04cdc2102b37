use pulp::Simd;
use pulp::bytemuck::Zeroable;

/// The ends when the step set out: first the root, then the tip.
pub(super) struct Outset<S: Simd> {
    pub(super) frames: [[S::f64s; 4]; 2],
    /// Forces in the segments beside them.
    pub(super) forces: [[S::f64s; 3]; 2],
    /// Elastic energies of their joints, zero where there is none.
    pub(super) stored: [S::f64s; 2],
    /// The share of the reactions after the step in their mean; the rest is that of those before.
    pub(super) share: S::f64s,
}

impl<S: Simd> Outset<S> {
    pub(super) fn new() -> Self {
        let zero = S::f64s::zeroed();
        Self { frames: [[zero; 4]; 2], forces: [[zero; 3]; 2], stored: [zero; 2], share: zero }
    }
}
