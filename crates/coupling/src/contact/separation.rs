//! Fibres that are laid into each other, moved apart before the first step.

use super::detection::ContactDetector;
use super::node_motion::NodeMotion;
use super::rooted::rooted;
use super::sections::{OrientedSections, SectionShapes};
use crate::body_ref::BodyRef;
use crate::conditions::ROOT;
use crate::contact_point::ContactPoint;
use crate::held_places::HeldPlaces;
use crate::{CouplingError, Surroundings, TimeInterval};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Assembly;

/// Most lists of overlaps.
const MOST_ROUNDS: usize = 60;
/// Sweeps over a list.
const SWEEPS: usize = 200;
/// Gaps that are listed, in radii: nodes that give way come near others.
const LISTED_GAP: f64 = 2.0;
/// Depth that is none, in radii, and the gap that is aimed at, so that the last sweeps need not
/// converge.
const NOTHING: f64 = 0.01;

/// What it took to move fibres apart.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Separation {
    /// Number of overlaps at the start.
    pub overlaps: usize,
    /// Largest displacement of a node, m.
    pub moved: f64,
    /// Depth of the deepest overlap that is left, m; zero if there is none.
    pub left: f64,
}

/// Moves nodes (world, m, in the order of the assembly) until no fibre is in another or in an
/// object, as they are at the start of the step. Roots that are not free and on an object grow out
/// of it: the first segments of these fibres may be in it.
///
/// Overlaps are taken in turns, each moving the `free` ones of its nodes along its normal by as
/// little as parts the two (projected Gauss-Seidel on the linearized gaps); lists are made anew
/// until nothing overlaps, or for a bounded number of times. Lengths of segments change by squares
/// of the radii over their lengths. Cost: a detection and some sweeps for each list.
///
/// # Errors
/// [`CouplingError`] of detection.
///
/// # Panics
/// If there are not as many positions or flags as nodes.
pub fn separate(
    assembly: &Assembly,
    around: &Surroundings<'_>,
    free: &[bool],
    positions: &mut [Point3<f64>],
) -> Result<Separation, CouplingError> {
    let layout = assembly.layout();
    assert!(positions.len() == layout.nodes() && free.len() == layout.nodes());
    let shapes = SectionShapes::new(assembly);
    let smallest = shapes.radii.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = shapes.radii.iter().copied().fold(0.0, f64::max);
    let mut detector = ContactDetector::new(LISTED_GAP * largest, 0.0, false)?;
    let mut shifts = vec![Vector3::zeros(); positions.len()];
    let mut result = Separation::default();
    let laid = positions.to_vec();
    let mut points = Vec::new();
    for round in 0..=MOST_ROUNDS {
        let motion = NodeMotion {
            layout,
            // Tubes that hold flat sections, however these will lie.
            sections: OrientedSections { shapes: &shapes, directors: &[] },
            start: positions,
            end: positions,
            step: TimeInterval::instant(around.start),
            sought: None,
        };
        if round == 0 {
            let grows = |fiber: usize| (!free[layout.node_range(fiber).start]).then_some(ROOT);
            detector.root(rooted(&motion, around.objects, grows));
        }
        detector.detect(&motion, around.objects, &HeldPlaces::default(), &mut points)?;
        let nodes = |point: &ContactPoint| {
            [0, 1].map(|side| match point.sides[side] {
                BodyRef::Object(_) => None,
                BodyRef::Fiber(fiber) => {
                    let first = layout.node_range(fiber as usize).start;
                    Some((first + point.segments[side] as usize, point.fractions[side]))
                }
            })
        };
        let can_move = |point: &ContactPoint| {
            nodes(point).into_iter().flatten().any(|(node, _)| free[node] || free[node + 1])
        };
        points.retain(can_move);
        let deep = points.iter().filter(|point| point.gap < -NOTHING * smallest);
        result.left = deep.clone().map(|point| -point.gap).fold(0.0, f64::max);
        if round == 0 {
            result.overlaps = deep.count();
        }
        if result.left == 0.0 || round == MOST_ROUNDS {
            break;
        }
        shifts.fill(Vector3::zeros());
        for _ in 0..SWEEPS {
            for point in &points {
                part(point, nodes(point), free, NOTHING * smallest, &mut shifts);
            }
        }
        positions.iter_mut().zip(&shifts).for_each(|(position, shift)| *position += shift);
    }
    let ways = laid.iter().zip(&*positions).map(|(before, after)| (after - before).norm());
    result.moved = ways.fold(0.0, f64::max);
    Ok(result)
}

/// Moves the nodes at a contact point, numbers and fractions on both sides, so far that its gap
/// with the `shifts` since it was found is not below `least`, m.
fn part(
    point: &ContactPoint,
    nodes: [Option<(usize, f64)>; 2],
    free: &[bool],
    least: f64,
    shifts: &mut [Vector3<f64>],
) {
    let mut gap = point.gap - least;
    let mut compliance = 0.0;
    let both = || nodes.into_iter().zip([1.0, -1.0]).filter_map(|(side, sign)| Some((side?, sign)));
    let shares = |(node, fraction): (usize, f64)| [(node, 1.0 - fraction), (node + 1, fraction)];
    for (side, sign) in both() {
        for (node, share) in shares(side) {
            gap += sign * share * point.normal.dot(&shifts[node]);
            compliance += if free[node] { share * share } else { 0.0 };
        }
    }
    if gap >= 0.0 || compliance == 0.0 {
        return;
    }
    for (side, sign) in both() {
        for (node, share) in shares(side).into_iter().filter(|(node, _)| free[*node]) {
            shifts[node] -= point.normal * (sign * share * gap / compliance);
        }
    }
}
