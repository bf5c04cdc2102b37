//! How all fibres come to rest together.

use super::anderson::{Anderson, dot};
use super::electric::Forces;
use super::rods::RestingRod;
use crate::{SimError, World};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::NodeProperties;
use rapunzel_rod_static::Shape;
use rayon::prelude::*;

/// Changes that the iteration remembers.
const DEPTH: usize = 12;
/// By how much a step is shortened that raises the energy.
const SHORTER: f64 = 0.25;
/// The shortest part of a step.
const SHORTEST: f64 = 1e-3;

/// What the search for the equilibrium came to.
pub(super) struct Settled {
    pub(super) evaluations: usize,
    pub(super) retreats: usize,
    /// Relative residual of the forces.
    pub(super) residual: f64,
    /// Whether that is within the tolerance.
    pub(super) at_rest: bool,
    /// In the end.
    pub(super) electric: Forces,
}

/// Fibres at rest under given electric forces, and the electric forces where they lie.
struct Trial {
    /// Forces on the nodes that they lie at rest with, N, coordinate by coordinate.
    held: Vec<f64>,
    /// By how much the electric forces differ from those.
    residual: Vec<f64>,
    electric: Forces,
    /// Mechanical and electric energy, J.
    energy: f64,
}

/// Lets all fibres come to rest under gravity, their loads and the electric forces of their charges.
///
/// The unknowns are the electric forces on the nodes. Under any given ones each fibre has its own
/// equilibrium, by Newton's method; sought are those that the charges make where that puts them. That
/// iteration, accelerated, goes down: its steps are shortened until they do not raise the energy of all
/// by more than the tolerance of it, so that it does not end where the energy is stationary but not least,
/// unless it begins there. The fibres are left in the equilibrium under the forces found.
pub(super) fn settle(world: &mut World) -> Result<Settled, SimError> {
    let (tolerance, most) = match &world.electric {
        Some(electric) => (electric.charging.tolerance, electric.charging.evaluations),
        None => (0.0, 1),
    };
    let start = flat(&evaluate(world, 1.0)?.forces);
    let mut now = trial(world, start, 1.0)?;
    let mut anderson = Anderson::new(DEPTH);
    let (mut evaluations, mut retreats) = (2, 0);
    loop {
        let size = dot(&now.residual, &now.residual).sqrt();
        let forces = flat(&now.electric.forces);
        let residual = if size > 0.0 { size / dot(&forces, &forces).sqrt() } else { 0.0 };
        let at_rest = residual <= tolerance;
        let settled = |electric, evaluations, retreats| Settled {
            evaluations,
            retreats,
            residual,
            at_rest,
            electric,
        };
        if at_rest || evaluations >= most {
            return Ok(settled(now.electric, evaluations, retreats));
        }
        let mut step = anderson.step(&now.held, &now.residual);
        // The energy is known as well as the forces are.
        let slack = tolerance * now.electric.energy.abs();
        let mut part = 1.0;
        let before = shapes(world);
        now = loop {
            let held: Vec<f64> = now.held.iter().zip(&step).map(|(f, s)| f + part * s).collect();
            evaluations += 1;
            let next = trial(world, held, residual);
            let ready = match &next {
                Ok(next) => next.energy <= now.energy + slack,
                Err(_) => false,
            };
            // So short a step is within what the forces are known by.
            if ready || part < SHORTEST {
                break next?;
            }
            lie(world, &before);
            if evaluations >= most {
                hold(world, &now.held);
                return Ok(settled(now.electric, evaluations, retreats));
            }
            retreats += 1;
            if part == 1.0 {
                // The way of the plain iteration goes down at first.
                anderson.forget();
                step.clone_from(&now.residual);
            }
            part *= SHORTER;
        };
    }
}

/// Lays the fibres at rest under `held` forces, from where they lie; `residual` is the last relative one.
fn trial(world: &mut World, held: Vec<f64>, residual: f64) -> Result<Trial, SimError> {
    hold(world, &held);
    let gravity = world.gravity();
    relax(world, &gravity)?;
    let electric = evaluate(world, residual)?;
    let mechanical: f64 = rods(world).map(|(_, rod)| rod.mechanical_energy(&gravity)).sum();
    let residual = flat(&electric.forces).iter().zip(&held).map(|(f, h)| f - h).collect();
    let energy = mechanical + electric.energy;
    Ok(Trial { held, residual, energy, electric })
}

/// Gives all fibres electric forces.
fn hold(world: &mut World, held: &[f64]) {
    let layout = world.assembly().layout().clone();
    for fiber in 0..layout.fibers() {
        let nodes = layout.node_range(fiber);
        if let Some(rod) = rod_mut(world, fiber) {
            let forces = held[3 * nodes.start..3 * nodes.end].chunks(3);
            rod.electric = forces.map(|f| Vector3::new(f[0], f[1], f[2])).collect();
        }
    }
}

/// Gives all fibres shapes.
fn lie(world: &mut World, shapes: &[Shape]) {
    for (fiber, shape) in shapes.iter().enumerate() {
        if let Some(rod) = rod_mut(world, fiber) {
            rod.lie(shape.clone());
        }
    }
}

/// Brings each fibre to rest by itself, in parallel.
///
/// # Errors
/// [`SimError::Rest`] with the first fibre that has no equilibrium.
pub(crate) fn relax(world: &mut World, gravity: &Vector3<f64>) -> Result<(), SimError> {
    let results: Vec<Result<(), SimError>> = world
        .groups
        .par_iter_mut()
        .map(|group| {
            let rods = group.batch.resting().map(|batch| &mut batch.rods[..]).unwrap_or_default();
            for (rod, &fiber) in rods.iter_mut().zip(&group.fibers) {
                rod.settle(gravity).map_err(|source| SimError::Rest { fiber, source })?;
            }
            Ok(())
        })
        .collect();
    results.into_iter().collect()
}

/// The electric forces where the fibres are. Those on the roots, which are held, are left out.
fn evaluate(world: &World, residual: f64) -> Result<Forces, SimError> {
    let Some(electric) = &world.electric else {
        return Ok(Forces { energy: 0.0, forces: vec![Vector3::zeros(); world.nodes()] });
    };
    let mut forces = electric.forces(world, &positions(world), &charges(world), residual)?;
    let layout = world.assembly().layout();
    for fiber in 0..layout.fibers() {
        forces.forces[layout.node_range(fiber).start] = Vector3::zeros();
    }
    Ok(forces)
}

/// All fibres with their numbers, in the order of the scene.
pub(super) fn rods(world: &World) -> impl Iterator<Item = (usize, &RestingRod)> {
    (0..world.assembly().fibers().len()).filter_map(|fiber| {
        let (group, lane) = world.lane(fiber);
        Some((fiber, &world.groups[group].batch.as_resting()?.rods[lane]))
    })
}

pub(super) fn rod_mut(world: &mut World, fiber: usize) -> Option<&mut RestingRod> {
    let (group, lane) = world.lane(fiber);
    Some(&mut world.groups[group].batch.resting()?.rods[lane])
}

/// Makes a fibre of another matter, the same all along; it keeps its shape until it settles.
pub(crate) fn set_matter(
    world: &mut World,
    fiber: usize,
    matter: &NodeProperties,
) -> Result<(), SimError> {
    let natural = world.assembly().fibers()[fiber].clone();
    let changed = rod_mut(world, fiber).map(|rod| rod.set_matter(&natural, matter));
    changed.unwrap_or(Ok(())).map_err(|source| SimError::Rest { fiber, source })
}

/// Nodes of all fibres, m, world.
pub(super) fn positions(world: &World) -> Vec<Point3<f64>> {
    rods(world).flat_map(|(_, rod)| rod.positions().iter().copied()).collect()
}

/// Charges of all segments, C.
pub(super) fn charges(world: &World) -> Vec<f64> {
    rods(world).flat_map(|(_, rod)| rod.charges.iter().copied()).collect()
}

fn shapes(world: &World) -> Vec<Shape> {
    rods(world).map(|(_, rod)| rod.shape().clone()).collect()
}

fn flat(vectors: &[Vector3<f64>]) -> Vec<f64> {
    vectors.iter().flat_map(|v| [v.x, v.y, v.z]).collect()
}
