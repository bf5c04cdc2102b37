//! Rods at rest that touch each other and objects.

use super::answer::{CaseAnswer, CaseContact, CaseEquilibrium, CaseTouch, Stability, TouchedBy};
use super::contact_gaps::CaseGaps;
use super::equilibria::equilibrium;
use super::problem::{piece, pose};
use super::start::{check_length, refused, table};
use crate::SimError;
use crate::case_error::CaseError;
use crate::curve::points;
use crate::file::read_text;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;
use rapunzel_rod_static::{
    AssemblyRest, AssemblyRod, Chain, Gap, RodAssembly, RootSupport, Shape, StaticError, Target,
};
use rapunzel_scene::case::{Case, CaseEnd, CaseRoot, CaseStart};
use std::path::Path;

/// Segments of each rod, at least.
const CONTACT_SEGMENTS: usize = 200;

/// A curve with frames.
struct FramedCurve {
    /// Arc lengths of the frames, m.
    ways: Vec<f64>,
    frames: Vec<UnitQuaternion<f64>>,
    /// Where it begins.
    root: Point3<f64>,
}

/// The rods of a case at rest.
pub(super) fn rest_in_contact(case: &Case) -> Result<CaseAnswer, SimError> {
    let alone = case.alone();
    let finer = CONTACT_SEGMENTS.div_ceil(case.parts);
    let segments = case.parts * finer;
    let gaps = CaseGaps::new(case, &alone, segments)?;
    let rods: Vec<AssemblyRod> =
        alone.iter().map(|rod| built(rod, segments)).collect::<Result<_, _>>()?;
    let nodes: Vec<Vec<Point3<f64>>> = rods.iter().map(AssemblyRod::stations).collect();
    if let Some((rod, other, at)) = gaps.first_overlap(&nodes) {
        let rods = gaps.rod_count();
        return Err(CaseError::Overlap { rod, other, rods, at: at.coords.into() }.into());
    }
    let rest = RodAssembly::new(rods)?.relax(&gaps).map_err(|error| match error {
        StaticError::Adrift { rod } => SimError::from(CaseError::Adrift(rod)),
        error => error.into(),
    })?;
    let equilibria = alone.iter().enumerate().map(|(i, rod)| one(rod, i, &rest, finer)).collect();
    let touches = rest.contacts.iter().map(|(gap, force)| touch(&gaps, &rest, gap, *force));
    Ok(CaseAnswer {
        name: case.name.clone(),
        length: case.length,
        radius: alone.iter().map(|rod| rod.matter().thickest()).fold(0.0, f64::max),
        wish: None,
        branch: None,
        equilibria,
        contact: Some(CaseContact {
            touches: touches.collect(),
            penetration: rest.penetration,
            slackness: rest.slackness,
            unbalanced: rest.unbalanced,
            iterations: rest.iterations,
        }),
    })
}

/// A rod of a case as one of an assembly.
fn built(case: &Case, segments: usize) -> Result<AssemblyRod, SimError> {
    let whole = piece(case, &case.matter(), case.length);
    let mut chain = Chain::new(&pose(&case.clamp)?, &[whole], segments)?;
    #[expect(clippy::cast_possible_truncation, reason = "between 0 and the segments")]
    let node = |at: f64| (at / case.length * segments as f64).round() as usize;
    let mut forces = chain.forces().to_vec();
    for mass in &case.masses {
        forces[node(mass.at)] += Vector3::from(case.gravity) * mass.mass;
    }
    for force in &case.forces {
        forces[node(force.at)] += Vector3::from(force.value);
    }
    let places = case.places.iter().filter(|place| node(place.at) > 0);
    let mut targets: Vec<_> =
        places.map(|place| Target::held(node(place.at), place.position.into())).collect();
    match case.end {
        CaseEnd::Free { force, .. } => forces[segments] += Vector3::from(force),
        CaseEnd::Joint { position } | CaseEnd::Clamped { position, .. } => {
            targets.push(Target::held(segments, position.into()));
        }
        // Refused when the case was checked.
        _ => {}
    }
    chain.set_forces(&forces)?;
    chain.set_targets(&targets)?;
    let root = match case.root {
        CaseRoot::Clamped => RootSupport::Clamped,
        CaseRoot::Joint => RootSupport::Joint,
        CaseRoot::Free => RootSupport::Free,
    };
    let mut start = started(case, &chain)?;
    if let CaseEnd::Clamped { position, orientation } = case.end {
        // What the end lacks is spread along the rod.
        let frame = pose(&rapunzel_scene::Pose { position, orientation })?.rotation;
        let lacking = (start.frames()[segments].inverse() * frame).scaled_axis();
        let by: Vec<_> = (1..=segments).map(|i| lacking * (i as f64 / segments as f64)).collect();
        start = chain.turned(&start, &by)?;
        chain.hold_tip_frame(true);
    }
    Ok(AssemblyRod { chain, root, start })
}

/// The shape that the search for a rod starts from.
fn started(case: &Case, chain: &Chain) -> Result<Shape, SimError> {
    let (path, FramedCurve { ways, frames, root }) = match &case.start {
        None => return Ok(chain.natural_shape()),
        Some(CaseStart::Curve(path)) => {
            let text = read_text(path)?;
            let all = points(&text).map_err(|(line, why)| refused(path, line, why))?;
            (path, along(path, &all, &pose(&case.clamp)?)?)
        }
        Some(CaseStart::Answer(path)) => {
            let states = table(path, &read_text(path)?)?;
            let frame = |state: &rapunzel_rod_static::State| so3::quaternion(&state.frame);
            let frames = states.iter().map(|(_, state)| frame(state)).collect();
            let root = states.first().map_or_else(Point3::origin, |(_, state)| state.position);
            let ways = states.iter().map(|(s, _)| *s).collect();
            (path, FramedCurve { ways, frames, root })
        }
    };
    let whole = ways[ways.len() - 1];
    check_length(case, path, whole)?;
    let held = case.root == CaseRoot::Clamped;
    let at = chain.arc_lengths().into_iter().map(|s| {
        let s = s / case.length * whole;
        let after = ways.partition_point(|way| *way <= s).clamp(1, ways.len() - 1);
        let [from, to] = [after - 1, after].map(|i| ways[i]);
        let part = ((s - from) / (to - from)).clamp(0.0, 1.0);
        let (a, b) = (&frames[after - 1], &frames[after]);
        a * UnitQuaternion::from_scaled_axis((a.inverse() * b).scaled_axis() * part)
    });
    let mut nodes: Vec<UnitQuaternion<f64>> = at.collect();
    if held {
        nodes[0] = chain.clamp().rotation;
    }
    let root = if case.root == CaseRoot::Free { root } else { case.clamp.position.into() };
    let mut moved = chain.clone();
    moved.set_clamp(&Isometry3::from_parts(root.coords.into(), nodes[0]))?;
    Ok(moved.shape_of(nodes)?)
}

/// A curve with frames: arc lengths, and frames carried along without twist from that of the root.
fn along(
    path: &Path,
    points: &[Point3<f64>],
    root: &Isometry3<f64>,
) -> Result<FramedCurve, SimError> {
    let (mut ways, mut frames) = (vec![0.0], vec![root.rotation]);
    let mut length = 0.0;
    for ends in points.windows(2) {
        let way = ends[1] - ends[0];
        let before = frames[frames.len() - 1];
        let Some(turn) =
            way.try_normalize(0.0).and_then(|along| so3::between(&(before * Vector3::z()), &along))
        else {
            let why = "has a point twice, or turns back".to_owned();
            return Err(refused(path, None, why));
        };
        // The direction of a way is that in its middle.
        ways.push(length + 0.5 * way.norm());
        frames.push(so3::quaternion(&turn) * before);
        length += way.norm();
    }
    if points.len() < 2 {
        return Err(refused(path, None, "has less than two points".into()));
    }
    ways.push(length);
    frames.push(frames[frames.len() - 1]);
    Ok(FramedCurve { ways, frames, root: points[0] })
}

/// A rod of the assembly as an equilibrium of its own.
fn one(case: &Case, rod: usize, rest: &AssemblyRest, finer: usize) -> CaseEquilibrium {
    let states = rest.states[rod].iter().enumerate().step_by(finer);
    let last = rest.states[rod].len() - 1;
    let at = states.map(|(i, state)| (case.length * i as f64 / last as f64, *state));
    let places = rest.pulls[rod].iter().take(case.places.len());
    let places = places.map(|pull| (*pull).into()).collect();
    let (elastic, load) = (rest.elastic[rod], rest.load[rod]);
    equilibrium(case, &at.collect::<Vec<_>>(), Stability::Stable, elastic, load, places)
}

/// A contact, as it is told.
fn touch(gaps: &CaseGaps, rest: &AssemblyRest, gap: &Gap, force: f64) -> CaseTouch {
    let [rod, _, other, _] = gap.between;
    let (normal, [own, others]) = gaps.sides(gap);
    let axis = own.iter().map(|(station, part)| rest.stations[rod][*station].coords * *part);
    let at = gaps.arc_length(rod, &own);
    let by = if other < gaps.rod_count() {
        TouchedBy::Rod(other, gaps.arc_length(other, &others))
    } else {
        TouchedBy::Object(other - gaps.rod_count())
    };
    let radius = gaps.radius(rod, &own);
    let position = axis.sum::<Vector3<f64>>() - normal * (radius + 0.5 * gap.value);
    let (position, normal) = (position.into(), normal.into());
    CaseTouch { rod, at, by, position, normal, gap: gap.value, force }
}
