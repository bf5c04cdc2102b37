//! A batch with its register width hidden, and the choice of that width.

use super::answers::BatchResponse;
use super::attempt::BatchAttempts;
use super::coupled_step::BatchCoupledStep;
use super::inputs::BatchInputs;
use super::joint_loads::BatchJointLoads;
use super::ledger::BatchLedger;
use super::memory::BatchMemory;
use super::readout::BatchReadout;
use super::scheme::Scheme;
use super::simd_batch::SimdBatch;
use super::velocity_lanes::BatchVelocities;
use crate::Rod;

/// A [`SimdBatch`] of any register width.
pub(super) trait ErasedBatch:
    BatchInputs
    + BatchReadout
    + BatchMemory
    + BatchAttempts
    + BatchLedger
    + BatchCoupledStep
    + BatchResponse
    + BatchJointLoads
    + BatchVelocities
    + Send
    + Sync
{
}

impl<S: pulp::Simd> ErasedBatch for SimdBatch<S> {}

/// Builds a batch of at most eight rods: two lanes for one or two, else eight. All variants
/// compute the same numbers where the machine has fused multiply-add.
pub(super) fn build(rods: &[Rod], scheme: Scheme, flight: Option<Scheme>) -> Box<dyn ErasedBatch> {
    let wide = rods.len() > 2;
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V4::try_new()
        && wide
    {
        return Box::new(SimdBatch::new(simd, rods, scheme, flight));
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return if wide {
            Box::new(SimdBatch::new(pulp::x86::V3_512b(simd), rods, scheme, flight))
        } else {
            Box::new(SimdBatch::new(pulp::x86::V3_128b(simd), rods, scheme, flight))
        };
    }
    if wide {
        Box::new(SimdBatch::new(pulp::Scalar512b, rods, scheme, flight))
    } else {
        Box::new(SimdBatch::new(pulp::Scalar128b, rods, scheme, flight))
    }
}
