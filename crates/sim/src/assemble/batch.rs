//! Integrators of fibres.

use super::start::FiberStart;
use crate::scene::RodMethod;
use rapunzel_coupling::{RodBatch, Rods};
use rapunzel_rod_dynamic::{
    BoxIntegrator, BoxOptions, Rod, RodError, RodIntegrator, Staggered, StaggeredBatch,
};

/// The rods of some fibres.
pub(super) fn rods(starts: &[&FiberStart]) -> Vec<Rod> {
    starts.iter().map(|start| start.rod.clone()).collect()
}

/// The integrator of a group of fibres of equal segment count, which touch nothing.
pub(super) fn batch(
    method: RodMethod,
    tolerance: Option<f64>,
    starts: &[&FiberStart],
) -> Result<Box<dyn RodBatch>, RodError> {
    match method {
        RodMethod::Staggered { rho_infinity } if tolerance.is_none() => {
            Ok(side_by_side(StaggeredBatch::new(rods(starts), rho_infinity)?, starts)?)
        }
        // With a tolerance the scene has been refused: its error is estimated for second order.
        RodMethod::BackwardEuler => {
            Ok(side_by_side(StaggeredBatch::backward_euler(rods(starts))?, starts)?)
        }
        RodMethod::Staggered { rho_infinity } => {
            let new = |rod| Staggered::with_rho_inf(rod, rho_infinity);
            Ok(Box::new(Rods { rods: started(starts, new)?, tolerance }))
        }
        RodMethod::Box { weights, residual } => {
            let coefficients = weights.coefficients()?;
            let options = BoxOptions { coefficients, tolerance: residual, ..BoxOptions::default() };
            let new = |rod| BoxIntegrator::new(rod, options);
            Ok(Box::new(Rods { rods: started(starts, new)?, tolerance }))
        }
    }
}

/// Fibres in SIMD lanes, each at its start.
pub(super) fn side_by_side(
    mut batch: StaggeredBatch,
    starts: &[&FiberStart],
) -> Result<Box<StaggeredBatch>, RodError> {
    for (lane, start) in starts.iter().enumerate() {
        if let Some(state) = start.moving(|| batch.state(lane)) {
            batch.set_state(lane, &state)?;
        }
    }
    Ok(Box::new(batch))
}

/// Integrators of single rods, each at its start.
fn started<I: RodIntegrator>(
    starts: &[&FiberStart],
    new: impl Fn(Rod) -> Result<I, RodError>,
) -> Result<Vec<I>, RodError> {
    let one = |start: &&FiberStart| {
        let mut integrator = new(start.rod.clone())?;
        if let Some(state) = start.moving(|| integrator.state()) {
            integrator.set_state(&state)?;
        }
        Ok(integrator)
    };
    starts.iter().map(one).collect()
}
