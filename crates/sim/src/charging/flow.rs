//! Charge flows along the fibres and to the head.

use super::anderson::{Anderson, add, dot};
use super::electric::{Electric, placed};
use super::settle::{charges, positions, rod_mut};
use crate::scene::{Flow, Head, Held};
use crate::{SimError, World};
use nalgebra::Point3;
use rapunzel_electrostatics::{COULOMB_CONSTANT, ChargeFlow};
use rayon::prelude::*;

/// Most evaluations of the potentials, and changes of charge that their iteration remembers.
const MOST: usize = 80;
const DEPTH: usize = 40;

/// Lets charge flow for `dt` seconds while the fibres lie still. False if the charges after the step were
/// not found.
///
/// Implicit Euler for all fibres at once: sought are charges that flow to themselves in the potentials
/// that they make, so that any step is stable.
pub(super) fn flow(
    world: &mut World,
    flow: &Flow,
    resistance: f64,
    dt: f64,
) -> Result<bool, SimError> {
    let Some(electric) = &world.electric else { return Ok(true) };
    let head = match electric.charging.head {
        Head::Conductor { held: Held::Potential(potential), .. } if flow.drained => {
            Some(electric.share * potential)
        }
        _ => None,
    };
    let one = ChargeFlow { resistance, capacity: flow.capacity, head };
    let (start, places) = (charges(world), positions(world));
    let mut now = start.clone();
    let mut anderson = Anderson::new(DEPTH);
    let tolerance = electric.charging.tolerance;
    let mut found = false;
    for _ in 0..MOST {
        let outer = outer_potentials(electric, world, &places, &now)?;
        let next = advance(world, &one, &start, &outer, dt)?;
        let residual: Vec<f64> = next.iter().zip(&now).map(|(a, b)| a - b).collect();
        let size = dot(&now, &now).max(dot(&start, &start)).sqrt();
        if dot(&residual, &residual).sqrt() <= tolerance * size {
            (now, found) = (next, true);
            break;
        }
        let step = anderson.step(&now, &residual);
        add(&mut now, 1.0, &step);
    }
    let layout = world.assembly().layout().clone();
    for fiber in 0..layout.fibers() {
        if let Some(rod) = rod_mut(world, fiber) {
            rod.charges.copy_from_slice(&now[layout.segment_range(fiber)]);
        }
    }
    Ok(found)
}

/// What becomes of the charges `start` of all segments in given potentials.
fn advance(
    world: &World,
    flow: &ChargeFlow,
    start: &[f64],
    outer: &[f64],
    dt: f64,
) -> Result<Vec<f64>, SimError> {
    let assembly = world.assembly();
    let layout = assembly.layout();
    let one = |fiber: usize| {
        let range = layout.segment_range(fiber);
        let mut charges = start[range.clone()].to_vec();
        let lengths = assembly.fibers()[fiber].segment_lengths();
        flow.advance(lengths, &outer[range], &mut charges, dt)?;
        Ok(charges)
    };
    let moved: Result<Vec<_>, _> = (0..layout.fibers()).into_par_iter().map(one).collect();
    Ok(moved.map_err(SimError::electric(world.time()))?.concat())
}

/// The potentials (V) in the middles of the segments of all but what the fibre itself has.
fn outer_potentials(
    electric: &Electric,
    world: &World,
    places: &[Point3<f64>],
    charges: &[f64],
) -> Result<Vec<f64>, SimError> {
    let layout = world.assembly().layout();
    let middle = |segment: usize| {
        let [a, b] = layout.segment_nodes(segment);
        nalgebra::center(&places[a], &places[b])
    };
    let middles: Vec<_> = (0..layout.segments()).map(middle).collect();
    let (points, halves) = placed(layout, places, charges);
    let mut potentials = electric.fields_of(world, &points, &halves, &middles)?.potentials;
    potentials.par_iter_mut().zip(&middles).enumerate().for_each(|(segment, (potential, x))| {
        let own = layout.segment_range(layout.segment_fibers()[segment]);
        let own = 2 * own.start..2 * own.end;
        let sum = points[own.clone()].iter().zip(&halves[own]).map(|(p, q)| q / (p - x).norm());
        *potential -= COULOMB_CONSTANT * sum.sum::<f64>();
    });
    Ok(potentials)
}
