//! Charge flows along the fibres and to the head.

use crate::ChargingError;
use crate::anderson::{AndersonAcceleration, add, dot};
use crate::electric::{Electric, placed};
use crate::fibers::RestingFibers;
use nalgebra::Point3;
use rapunzel_electrostatics::{COULOMB_CONSTANT, ChargeFlow};
use rapunzel_scene::{ConductorHold, Flow, Head};
use rayon::prelude::*;

/// Most evaluations of the potentials, and changes of charge that their iteration remembers.
const MOST: usize = 80;
const FLOW_DEPTH: usize = 40;

/// Lets charge flow for `dt` seconds while the fibres lie still. False if the charges after the
/// step were not found.
///
/// Implicit Euler for all fibres at once: sought are charges that flow to themselves in the
/// potentials that they make, so that any step is stable.
pub(super) fn flow(
    fibers: &mut RestingFibers,
    electric: &Electric,
    flow: &Flow,
    resistance: f64,
    dt: f64,
) -> Result<bool, ChargingError> {
    let head = match electric.charging.head {
        Head::Conductor { held: ConductorHold::Potential(potential), .. } if flow.drained => {
            Some(electric.share * potential)
        }
        _ => None,
    };
    let one = ChargeFlow { resistance, capacity: flow.capacity, head };
    let (start, places) = (fibers.charges(), fibers.positions());
    let mut now = start.clone();
    let mut anderson = AndersonAcceleration::new(FLOW_DEPTH);
    let tolerance = electric.charging.tolerance;
    let mut found = false;
    for _ in 0..MOST {
        let outer = outer_potentials(electric, fibers, &places, &now)?;
        let next = advance(fibers, &one, &start, &outer, dt)?;
        let residual: Vec<f64> = next.iter().zip(&now).map(|(a, b)| a - b).collect();
        let size = dot(&now, &now).max(dot(&start, &start)).sqrt();
        if dot(&residual, &residual).sqrt() <= tolerance * size {
            (now, found) = (next, true);
            break;
        }
        let step = anderson.step(&now, &residual);
        add(&mut now, 1.0, &step);
    }
    let layout = fibers.assembly.layout();
    for (fiber, rod) in fibers.rods.iter_mut().enumerate() {
        rod.charges.copy_from_slice(&now[layout.segment_range(fiber)]);
    }
    Ok(found)
}

/// What becomes of the charges `start` of all segments in given potentials.
fn advance(
    fibers: &RestingFibers,
    flow: &ChargeFlow,
    start: &[f64],
    outer: &[f64],
    dt: f64,
) -> Result<Vec<f64>, ChargingError> {
    let assembly = &fibers.assembly;
    let layout = assembly.layout();
    let one = |fiber: usize| {
        let range = layout.segment_range(fiber);
        let mut charges = start[range.clone()].to_vec();
        let lengths = assembly.fibers()[fiber].segment_lengths();
        flow.advance(lengths, &outer[range], &mut charges, dt)?;
        Ok(charges)
    };
    let moved: Result<Vec<_>, _> = (0..layout.fibers()).into_par_iter().map(one).collect();
    Ok(moved.map_err(ChargingError::electric(fibers.time))?.concat())
}

/// The potentials (V) in the middles of the segments of all but what the fibre itself has.
fn outer_potentials(
    electric: &Electric,
    fibers: &RestingFibers,
    places: &[Point3<f64>],
    charges: &[f64],
) -> Result<Vec<f64>, ChargingError> {
    let layout = fibers.assembly.layout();
    let middle = |segment: usize| {
        let [a, b] = layout.segment_nodes(segment);
        nalgebra::center(&places[a], &places[b])
    };
    let middles: Vec<_> = (0..layout.segments()).map(middle).collect();
    let (points, halves) = placed(layout, places, charges);
    let mut potentials = electric.fields_of(fibers, &points, &halves, &middles)?.potentials;
    potentials.par_iter_mut().zip(&middles).enumerate().for_each(|(segment, (potential, x))| {
        let own = layout.segment_range(layout.segment_fibers()[segment]);
        let own = 2 * own.start..2 * own.end;
        let sum = points[own.clone()].iter().zip(&halves[own]).map(|(p, q)| q / (p - x).norm());
        *potential -= COULOMB_CONSTANT * sum.sum::<f64>();
    });
    Ok(potentials)
}
