//! A case as a problem of `rod-static`.

use crate::SimError;
use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};
use rapunzel_fiber::NodeProperties;
use rapunzel_rod_static as rods;
use rapunzel_scene::case::{Case, CaseEnd, CaseRoot, Parameter, SlidingHold};
use rapunzel_scene::{FiberMatter, Pose};
use rods::{EndCondition, EndHold, Piece, Problem, Properties};
use std::f64::consts::TAU;

/// The case as a problem of boundary values.
pub(super) fn problem(case: &Case) -> Result<Problem, SimError> {
    rooted(case, far_end(case)?)
}

/// The case with a parameter at a value.
pub(super) fn problem_at(case: &Case, of: Parameter, value: f64) -> Result<Problem, SimError> {
    let mut case = case.clone();
    let scale = |v: &mut [f64; 3]| v.iter_mut().for_each(|x| *x *= value);
    let loads = of == Parameter::Loads;
    if loads || of == Parameter::Gravity {
        scale(&mut case.gravity);
    }
    for (i, force) in case.forces.iter_mut().enumerate() {
        if loads || of == Parameter::Force(i) {
            scale(&mut force.value);
        }
    }
    match &mut case.end {
        CaseEnd::Free { force, moment } => {
            if loads || of == Parameter::EndForce {
                scale(force);
            }
            if loads || of == Parameter::EndMoment {
                scale(moment);
            }
        }
        CaseEnd::Sliding { force, .. } if loads || of == Parameter::EndForce => *force *= value,
        CaseEnd::Ring { twist } if of == Parameter::EndTwist => *twist += value,
        _ => {}
    }
    match of {
        Parameter::Length => case.length = value,
        Parameter::EndMove(way) => {
            if let CaseEnd::Joint { position }
            | CaseEnd::Bearing { position, .. }
            | CaseEnd::Clamped { position, .. }
            | CaseEnd::Sliding { position, .. } = &mut case.end
            {
                (0..3).for_each(|i| position[i] += value * way[i]);
            }
        }
        _ => {}
    }
    let mut end = far_end(&case)?;
    let angle = value.to_radians();
    match of {
        Parameter::EndTurn(axis) => {
            let axis = Unit::new_normalize(Vector3::from(axis));
            let turn = UnitQuaternion::from_axis_angle(&axis, angle);
            match &mut end {
                EndCondition::Tangent(_, t)
                | EndCondition::Sliding { hold: EndHold::Tangent(t), .. } => *t = turn * *t,
                EndCondition::Held(pose) => pose.rotation = turn * pose.rotation,
                EndCondition::Sliding { hold: EndHold::Frame(frame), .. } => *frame = turn * *frame,
                _ => {}
            }
        }
        Parameter::EndTwist => {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
            match &mut end {
                // A ring's has been turned already.
                EndCondition::Held(pose) if !matches!(case.end, CaseEnd::Ring { .. }) => {
                    pose.rotation *= turn;
                }
                EndCondition::Sliding { hold: EndHold::Frame(frame), .. } => *frame *= turn,
                _ => {}
            }
        }
        _ => {}
    }
    rooted(&case, end)
}

fn rooted(case: &Case, end: EndCondition) -> Result<Problem, SimError> {
    let problem = Problem::new(&pose(&case.clamp)?, pieces(case), end)?;
    Ok(match case.root {
        // A free root is refused when the case is checked.
        CaseRoot::Clamped | CaseRoot::Free => problem,
        CaseRoot::Joint => problem.hinged()?,
    })
}

fn far_end(case: &Case) -> Result<EndCondition, SimError> {
    let direction = |v: [f64; 3]| Unit::new_normalize(Vector3::from(v));
    Ok(match case.end {
        CaseEnd::Free { force, moment } => {
            EndCondition::Free { force: force.into(), moment: moment.into() }
        }
        CaseEnd::Joint { position } => EndCondition::Position(position.into()),
        CaseEnd::Bearing { position, direction: along } => {
            EndCondition::Tangent(Point3::from(position), direction(along))
        }
        CaseEnd::Clamped { position, orientation } => {
            EndCondition::Held(pose(&Pose { position, orientation })?)
        }
        CaseEnd::Sliding { position, direction: along, force, hold } => EndCondition::Sliding {
            point: position.into(),
            along: direction(along),
            force,
            hold: match hold {
                SlidingHold::Joint => EndHold::Joint,
                SlidingHold::Bearing { direction: along } => EndHold::Tangent(direction(along)),
                SlidingHold::Clamped { orientation } => {
                    EndHold::Frame(pose(&Pose { position, orientation })?.rotation)
                }
            },
        },
        CaseEnd::Ring { twist } => {
            let root = pose(&case.clamp)?;
            let turn = Vector3::z() * (twist / 360.0 % 1.0 * TAU);
            let rotation = root.rotation * UnitQuaternion::from_scaled_axis(turn);
            EndCondition::Held(Isometry3 { rotation, ..root })
        }
    })
}

/// A part of the rod of a length, m, whose properties depend on the arc length if they do.
pub(super) fn piece(case: &Case, matter: &FiberMatter, length: f64) -> Piece {
    let gravity = Vector3::from(case.gravity);
    let natural = natural_curvature(case);
    let properties = move |node: NodeProperties| Properties {
        stiffness: node.stiffness,
        natural_curvature: natural + node.natural_curvature,
        load: gravity * node.linear_density,
    };
    if matter.is_uniform() {
        return Piece::uniform(length, properties(matter.at(0.0)));
    }
    let (matter, whole) = (matter.clone(), case.length);
    Piece::varying(length, move |s| properties(matter.at(s / whole)))
}

/// The rod in pieces between its masses, its forces and the points of its taper.
fn pieces(case: &Case) -> Vec<Piece> {
    let matter = case.matter();
    let gravity = Vector3::from(case.gravity);
    let masses = case.masses.iter().map(|mass| (mass.at, gravity * mass.mass));
    let forces = case.forces.iter().map(|force| (force.at, Vector3::from(force.value)));
    let mut loads: Vec<(f64, Vector3<f64>)> = masses.chain(forces).collect();
    loads.extend(matter.kinks().map(|at| (at * case.length, Vector3::zeros())));
    loads.push((case.length, Vector3::zeros()));
    loads.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pieces: Vec<Piece> = Vec::new();
    let (mut from, mut sum) = (0.0, Vector3::zeros());
    for (i, (at, load)) in loads.iter().enumerate() {
        // What hangs on the clamp itself does not bend the rod.
        sum = if *at > 0.0 { sum + load } else { sum };
        let ends = loads.get(i + 1).is_none_or(|next| next.0 > *at);
        if ends && *at > from {
            pieces.push(piece(case, &matter, at - from).with_end_load(sum));
            (from, sum) = (*at, Vector3::zeros());
        }
    }
    pieces
}

pub(super) fn pose(pose: &Pose) -> Result<Isometry3<f64>, SimError> {
    pose.isometry().map_err(|source| SimError::Fiber { bundle: 0, source })
}

/// What all of the rod has of natural curvature, 1/m; joined rods have their own, which their
/// matter tells.
pub(super) fn natural_curvature(case: &Case) -> Vector3<f64> {
    if case.joined.is_empty() { case.natural_curvature.into() } else { Vector3::zeros() }
}
