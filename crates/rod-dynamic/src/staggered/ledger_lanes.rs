//! The lines of a ledger, in lanes.

use super::array::get;
use crate::Ledger;
use pulp::Simd;
use rapunzel_lanes::{LANES, Lane};

/// Energy ledger of a step, one per lane.
#[derive(Clone, Copy)]
pub(super) struct LedgerLanes<S: Simd> {
    pub(super) kinetic: Lane<S>,
    pub(super) elastic: Lane<S>,
    pub(super) gravity: Lane<S>,
    pub(super) loads: Lane<S>,
    pub(super) drag: Lane<S>,
    pub(super) damping: Lane<S>,
    pub(super) supports: Lane<S>,
    pub(super) contacts: Lane<S>,
    pub(super) joints: Lane<S>,
    pub(super) integrator: Lane<S>,
    pub(super) solver: Lane<S>,
}

impl<S: Simd> LedgerLanes<S> {
    pub(super) fn zero(simd: S) -> Self {
        let zero = Lane::splat(simd, 0.0);
        Self {
            kinetic: zero,
            elastic: zero,
            gravity: zero,
            loads: zero,
            drag: zero,
            damping: zero,
            supports: zero,
            contacts: zero,
            joints: zero,
            integrator: zero,
            solver: zero,
        }
    }

    pub(super) fn ledgers(&self) -> [Ledger; LANES] {
        let mut ledgers = [Ledger::default(); LANES];
        for (lane, ledger) in ledgers.iter_mut().enumerate().take(S::F64_LANES) {
            let of = |line: Lane<S>| get(line, lane);
            *ledger = Ledger {
                kinetic: of(self.kinetic),
                elastic: of(self.elastic),
                gravity: of(self.gravity),
                loads: of(self.loads),
                drag: of(self.drag),
                damping: of(self.damping),
                supports: of(self.supports),
                contacts: of(self.contacts),
                joints: of(self.joints),
                integrator: of(self.integrator),
                solver: of(self.solver),
            };
        }
        ledgers
    }
}
