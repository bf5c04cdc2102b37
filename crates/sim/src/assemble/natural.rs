//! Natural shapes of groomed fibres: with which they rest in the curves that are given.

use super::groups::{assembly, at_start};
use super::stage::BuildStage;
use super::start::{FiberStart, along};
use super::still::{Settling, Still};
use crate::SimError;
use crate::scene::{Bundle, GroomShape, Scene, Tip};
use nalgebra::{Point3, Vector3};
use rapunzel_coupling::{CollisionObject, Separation, separate};
use rapunzel_fiber::{Fiber, Layout};
use rapunzel_rod_dynamic::{
    End, FittedFiber, Instant, RodError, RodIntegrator, RodState, Staggered,
    bounded_natural_curvatures, fitted, fitted_end_load, natural_curvatures,
};
use rayon::prelude::*;

/// Distance, in lengths of a fibre, within which it rests as it is drawn.
const SAME: f64 = 1e-3;

/// How far groomed fibres settle at once: at their speed they move by half a thousandth of their
/// length in 0.1 s, and how they come to where they rest does not count.
const SETTLING: Settling =
    Settling { speed: 5e-3, reach: f64::INFINITY, steps: 75, residual: 1e-2 };
/// Times that fibres in contact settle.
const ROUNDS: usize = 3;
/// Times that settled fibres are let go and balanced with what contacts bear then.
const REBALANCINGS: usize = 2;

/// What became of fibres.
#[derive(Debug, Clone, Copy)]
struct Told {
    fibers: usize,
    /// Length of the longest, m.
    length: f64,
    /// Largest natural curvature, 1/m.
    curvature: f64,
    /// Fibres that start in another shape than the groom's.
    other: usize,
    /// Largest distance of a node from the groom, m.
    moved: f64,
}

/// Gives groomed fibres natural shapes with which they rest in their curves, and moves those apart
/// that are in each other where fibres touch. `at` is told of what takes long.
///
/// # Errors
/// [`SimError`] of what cannot be moved apart or rest.
pub(super) fn give_natural_shapes(
    scene: &Scene,
    starts: &mut [FiberStart],
    objects: &mut [CollisionObject],
    notes: &mut Vec<String>,
    at: &dyn Fn(BuildStage),
) -> Result<(), SimError> {
    if scene.fibers.iter().all(|bundle| bundle.groom.is_none()) {
        return Ok(());
    }
    if scene.contact.is_some() {
        at(BuildStage::MovingApart);
        notes.extend(move_apart(scene, starts, objects)?);
    }
    starts.par_iter_mut().try_for_each(|start| {
        let bundle = start.bundle;
        draw(start, &scene.fibers[bundle]).map_err(|source| SimError::Rod { bundle, source })
    })?;
    let rests = |bundle: &Bundle| {
        bundle.groom.as_ref().is_some_and(|groom| groom.natural != GroomShape::Drawn)
    };
    if !scene.fibers.iter().any(rests) {
        return Ok(());
    }
    let mut told = vec![None; starts.len()];
    match &scene.contact {
        None => rest(scene, starts, &[], RestStage::Alone, &mut told)?,
        Some(settings) => {
            let forces = Still::new(scene, starts, objects)?.contact_forces(settings)?;
            rest(scene, starts, &forces, RestStage::Touching, &mut told)?;
            let drawn: Vec<_> = starts.iter().map(|start| start.state.clone()).collect();
            // What asks for too much sags, and what contacts hold need not be stable: that leaves
            // its place again.
            for round in 0..ROUNDS {
                let mut still = Still::new(scene, starts, objects)?;
                let (fibers, _) = still.settle(settings, &SETTLING, None, &|step| {
                    let done = round * SETTLING.steps + step;
                    at(BuildStage::Settling { done, most: ROUNDS * SETTLING.steps });
                })?;
                take_states(starts, still.starts, &told);
                rest(scene, starts, &fibers.contact_forces(), RestStage::Settled, &mut told)?;
                // Some contacts were there only because fibres moved.
                for _ in 0..REBALANCINGS {
                    let forces = Still::new(scene, starts, objects)?.contact_forces(settings)?;
                    rest(scene, starts, &forces, RestStage::Settled, &mut told)?;
                }
            }
            for ((told, drawn), start) in told.iter_mut().zip(drawn).zip(&*starts) {
                let (Some(told), Some(drawn), Some(state)) = (told, drawn, &start.state) else {
                    continue;
                };
                let ways = drawn.positions.iter().zip(&state.positions);
                told.moved = ways.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            }
        }
    }
    for index in 0..scene.fibers.len() {
        let of = starts.iter().zip(&told).filter(|(start, _)| start.bundle == index);
        notes.extend(told_of(index, of.filter_map(|(_, told)| *told)));
    }
    Ok(())
}

/// Where fibres are that are given natural shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RestStage {
    /// In the curves of the groom, touching nothing: what does not stay there falls to where it
    /// does.
    Alone,
    /// In the curves of the groom, touching others: contacts hold them, so that their stability is
    /// not known from each alone.
    Touching,
    /// Where they have settled: what is left of their motion is balanced, whatever that takes.
    Settled,
}

/// Gives all groomed fibres natural shapes under their loads, and forces of contacts on all nodes,
/// N, if there are any, and tells of each.
fn rest(
    scene: &Scene,
    starts: &mut [FiberStart],
    forces: &[Vector3<f64>],
    stage: RestStage,
    told: &mut [Option<Told>],
) -> Result<(), SimError> {
    let layout = Layout::new(starts.iter().map(|start| start.rod.fiber.segments()));
    let gravity = scene.environment.gravity_at(0.0);
    let all = starts.par_iter_mut().zip(told).enumerate();
    all.try_for_each(|(fiber, (start, told))| {
        let bundle = &scene.fibers[start.bundle];
        let mut forces = forces.get(layout.node_range(fiber)).unwrap_or_default().to_vec();
        let segments = start.rod.fiber.segments();
        for (k, own) in bundle.node_forces(segments, 0.0).into_iter().flatten().enumerate() {
            forces.resize(segments + 1, Vector3::zeros());
            forces[k] += own;
        }
        *told = rest_one(start, bundle, gravity, &forces, stage)?;
        Ok(())
    })
}

/// Takes over the states that fibres which are to rest have come to. Others start where the scene
/// puts them.
fn take_states(starts: &mut [FiberStart], settled: Vec<FiberStart>, told: &[Option<Told>]) {
    for ((start, settled), told) in starts.iter_mut().zip(settled).zip(told) {
        if told.is_some() {
            start.state = settled.state;
        }
    }
}

/// Gives a groomed fibre its curve as its natural shape.
fn draw(start: &mut FiberStart, bundle: &Bundle) -> Result<(), RodError> {
    let (Some(_), Some(state)) = (&bundle.groom, &start.state) else { return Ok(()) };
    let fiber = &start.rod.fiber;
    let weightless = Instant::clamped(*fiber.root(), Vector3::zeros());
    let curvatures = natural_curvatures(fiber, state, &weightless, &[])?;
    start.rod.fiber = curved(fiber, &curvatures)?;
    Ok(())
}

/// A fibre with natural curvatures of its nodes, 1/m.
fn curved(fiber: &Fiber, curvatures: &[Vector3<f64>]) -> Result<Fiber, RodError> {
    let invalid = |_| RodError::Invalid { what: "natural curvature", why: "must be finite" };
    fiber.clone().with_node_curvatures(curvatures).map_err(invalid)
}

/// Moves the nodes of groomed fibres, but their roots, out of all that they overlap.
fn move_apart(
    scene: &Scene,
    starts: &mut [FiberStart],
    objects: &mut [CollisionObject],
) -> Result<Option<String>, SimError> {
    let assembly = assembly(starts);
    let layout = assembly.layout();
    let mut positions: Vec<Point3<f64>> = Vec::with_capacity(layout.nodes());
    let mut free = Vec::with_capacity(layout.nodes());
    for start in &*starts {
        let nodes = match &start.state {
            Some(state) => state.positions.clone(),
            None => {
                let natural = Staggered::new(start.rod.clone());
                let failed = |source| SimError::Rod { bundle: start.bundle, source };
                natural.map_err(failed)?.state().positions
            }
        };
        let groomed = scene.fibers[start.bundle].groom.is_some();
        free.extend((0..nodes.len()).map(|node| groomed && node > 0));
        positions.extend(nodes);
    }
    let moved = separate(&assembly, &at_start(scene, objects), &free, &mut positions)?;
    for (fiber, start) in starts.iter_mut().enumerate() {
        if scene.fibers[start.bundle].groom.is_none() {
            continue;
        }
        let nodes = start.rod.fiber.nodes().to_vec();
        let laid = along(&positions[layout.node_range(fiber)], |_| nodes);
        let (fiber, state) =
            laid.map_err(|source| SimError::Fiber { bundle: start.bundle, source })?;
        (start.rod.fiber, start.state) = (fiber, Some(state));
    }
    let Separation { overlaps, moved, left } = moved;
    let note = || {
        format!(
            "{overlaps} overlaps of fibres at the start: nodes were moved by at most {moved:.1e} m, \
             and the deepest that is left has {left:.1e} m"
        )
    };
    Ok((overlaps > 0).then(note))
}

/// Gives a groomed fibre the natural shape with which it rests under its loads: gravity (m/s^2) and
/// forces on its nodes (N).
fn rest_one(
    start: &mut FiberStart,
    bundle: &Bundle,
    gravity: Vector3<f64>,
    forces: &[Vector3<f64>],
    stage: RestStage,
) -> Result<Option<Told>, SimError> {
    let (Some(groom), Some(state)) = (&bundle.groom, &start.state) else { return Ok(None) };
    let failed = |source| SimError::Rod { bundle: start.bundle, source };
    let fiber = &start.rod.fiber;
    let mut conditions = Instant::clamped(*fiber.root(), gravity);
    if let Tip::Loaded { force, moment } = &bundle.tip {
        conditions.tip = End::Loaded { force: force.at(0.0), moment: moment.at(0.0) };
    }
    let most = match groom.natural {
        GroomShape::Drawn => return Ok(None),
        GroomShape::SagFree { most } => most,
        GroomShape::EndLoads { most } => {
            if stage != RestStage::Settled {
                let load = fitted_end_load(fiber, state, &conditions, forces);
                start.end_load = load.map_err(failed)?;
            }
            conditions.tip = start.end_load;
            most
        }
    };
    let held = |most: f64| held(fiber, state, &conditions, forces, most);
    let rested = match stage {
        RestStage::Alone => fitted(fiber, state, &conditions, forces, most).or_else(|_| held(most)),
        RestStage::Touching => held(most),
        RestStage::Settled => held(f64::INFINITY),
    };
    let FittedFiber { fiber, state, moved } = rested.map_err(failed)?;
    let curvature = fiber.nodes().iter().map(|node| node.natural_curvature.norm());
    let curvature = curvature.fold(0.0, f64::max);
    let length = fiber.length();
    (start.rod.fiber, start.state) = (fiber, Some(state));
    Ok(Some(Told { fibers: 1, length, curvature, other: 0, moved }))
}

/// A fibre with the natural curvatures that balance its loads where it is, if they change its
/// curvatures by at most `most`, 1/m.
fn held(
    fiber: &Fiber,
    state: &RodState,
    conditions: &Instant,
    forces: &[Vector3<f64>],
    most: f64,
) -> Result<FittedFiber, RodError> {
    let curvatures = bounded_natural_curvatures(fiber, state, conditions, forces, most)?;
    let fiber = curved(fiber, &curvatures)?;
    Ok(FittedFiber { fiber, state: state.clone(), moved: 0.0 })
}

/// How the fibres of bundle `index` rest, if any are to.
fn told_of(index: usize, fibers: impl Iterator<Item = Told>) -> Option<String> {
    let one = |told: Told| Told { other: usize::from(told.moved > SAME * told.length), ..told };
    let add = |sum: Told, one: Told| Told {
        fibers: sum.fibers + one.fibers,
        length: sum.length.max(one.length),
        curvature: sum.curvature.max(one.curvature),
        other: sum.other + one.other,
        moved: sum.moved.max(one.moved),
    };
    let Told { fibers, curvature, other, moved, .. } = fibers.map(one).reduce(add)?;
    Some(if other == 0 {
        format!(
            "fibers[{index}]: all {fibers} rest as they are drawn, by natural curvatures of at most \
             {curvature:.0} 1/m"
        )
    } else {
        format!(
            "fibers[{index}]: {other} of {fibers} do not rest as they are drawn, by natural \
             curvatures of at most {curvature:.0} 1/m: they start in equilibria nearby, their nodes \
             moved by up to {moved:.1e} m"
        )
    })
}
