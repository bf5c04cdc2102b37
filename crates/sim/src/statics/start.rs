//! From where the search for an equilibrium starts.

use super::problem::{natural_curvature, pose, problem_at};
use crate::SimError;
use crate::case_error::CaseError;
use crate::curve::points;
use crate::file::read_text;
use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use rapunzel_rod_static::{BranchEnd, Equilibrium, ParameterSweep, Problem, State, StaticError};
use rapunzel_scene::case::{Case, CaseEnd, CaseStart, Parameter};
use std::f64::consts::TAU;
use std::path::Path;

/// Part of the rod's length by which that of a start may differ.
const LENGTH_OFF: f64 = 0.01;
/// Parts of the guess of a ring.
const RING_PARTS: usize = 64;
/// Steps in which the loads of a ring are put on.
const LOAD_STEPS: usize = 10;

/// The equilibrium of `problem`, that of the case at some value of a parameter, near the start of
/// the case, or a stable one if it has none.
pub(super) fn start(case: &Case, problem: &Problem) -> Result<Equilibrium, SimError> {
    match &case.start {
        Some(CaseStart::Curve(path)) => {
            let text = read_text(path)?;
            let points = points(&text).map_err(|(line, why)| refused(path, line, why))?;
            let length = points.windows(2).map(|p| (p[1] - p[0]).norm()).sum();
            check_length(case, path, length)?;
            Ok(problem.solve_along(&points)?)
        }
        Some(CaseStart::Answer(path)) => {
            let states = table(path, &read_text(path)?)?;
            let length = states.last().map_or(0.0, |last| last.0);
            check_length(case, path, length)?;
            Ok(problem.solve_near(&states)?)
        }
        None if matches!(case.end, CaseEnd::Ring { .. }) => ring(case, problem),
        None => Ok(problem.solve()?),
    }
}

pub(super) fn refused(path: &Path, line: Option<usize>, why: String) -> SimError {
    CaseError::Start { path: path.to_owned(), line, why }.into()
}

pub(super) fn check_length(case: &Case, path: &Path, length: f64) -> Result<(), SimError> {
    if (length - case.length).abs() <= LENGTH_OFF * case.length {
        return Ok(());
    }
    let why = format!(
        "is {length:?} m long, but the rod is {:?} m long: scale the one or set `length` of the other",
        case.length
    );
    Err(refused(path, None, why))
}

/// The states in a table of an answer.
pub(super) fn table(path: &Path, text: &str) -> Result<Vec<(f64, State)>, SimError> {
    let mut states = Vec::new();
    for (line, row) in (1..).zip(text.lines()).skip(1) {
        let numbers: Result<Vec<f64>, _> = row.split(',').map(str::parse).collect();
        let numbers = numbers.ok().filter(|all| all.len() >= 19);
        let Some(all) = numbers.filter(|all| all.iter().all(|x| x.is_finite())) else {
            let why = "is no row of a table that `solve` wrote, with at least 19 numbers".into();
            return Err(refused(path, Some(line), why));
        };
        let vector = |i: usize| Vector3::new(all[i], all[i + 1], all[i + 2]);
        let axes = Matrix3::from_columns(&[vector(4), vector(7), vector(10)]);
        let state = State {
            position: Point3::from(vector(1)),
            frame: Rotation3::from_matrix_unchecked(axes),
            force: vector(13),
            moment: vector(16),
        };
        states.push((all[0], state));
    }
    if states.len() < 2 {
        return Err(refused(path, None, "has no rows: give a table that `solve` wrote".into()));
    }
    Ok(states)
}

/// The equilibrium near a flat ring with an even twist, without the loads of the case, and from
/// there with them.
fn ring(case: &Case, problem: &Problem) -> Result<Equilibrium, SimError> {
    let CaseEnd::Ring { twist } = case.end else { return Ok(problem.solve()?) };
    let root = pose(&case.clamp)?;
    let twist = twist.to_radians();
    let stiffness = case.matter().at(0.0).stiffness;
    // About the softer axis of the root.
    let axis = if stiffness.x <= stiffness.y { Vector3::x_axis() } else { Vector3::y_axis() };
    let radius = case.length / TAU;
    let state = |i: usize| {
        let part = i as f64 / RING_PARTS as f64;
        let (s, angle) = (case.length * part, TAU * part);
        let bent = UnitQuaternion::from_axis_angle(&axis, angle);
        let own = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), twist * part);
        let aside = axis.cross(&Vector3::z());
        let place = Vector3::z() * (radius * angle.sin()) + aside * (radius * (1.0 - angle.cos()));
        let frame = root.rotation * bent * own;
        let node = case.matter().at(part);
        let curvature =
            own.inverse() * (axis.into_inner() / radius) + Vector3::z() * twist / case.length;
        let strain = curvature - natural_curvature(case) - node.natural_curvature;
        // The moment of the twist turns with the tangent, and a force across balances that.
        let torque = node.stiffness.z * twist / case.length;
        let state = State {
            position: root.translation.vector.into(),
            frame: frame.to_rotation_matrix(),
            force: root.rotation * (axis.into_inner() * (torque / radius)),
            moment: frame * strain.component_mul(&node.stiffness),
        };
        (s, State { position: state.position + root.rotation * place, ..state })
    };
    let guess: Vec<_> = (0..RING_PARTS).map(state).collect();
    let loads = |factor: f64| match problem_at(case, Parameter::Loads, factor) {
        Ok(problem) => Ok(problem),
        Err(SimError::Static(error)) => Err(error),
        Err(_) => Err(StaticError::NotFound),
    };
    let unloaded = loads(0.0)?.solve_near(&guess)?;
    if let Ok(found) = problem.solve_from(&unloaded) {
        return Ok(found);
    }
    let sweep = ParameterSweep { problem: &loads, from: 0.0, to: 1.0, steps: LOAD_STEPS };
    let mut branch = sweep.follow(&unloaded)?;
    let last = branch.points.pop().filter(|_| branch.ended == BranchEnd::Reached);
    Ok(last.ok_or(StaticError::NotFound)?.equilibrium)
}
