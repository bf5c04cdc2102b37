//! The equilibria along the way of a parameter, and where the first of them loses its stability.

use super::answer::{
    BranchRow, CaseBranch, CaseEquilibrium, CaseLimit, Ended, ModeStation, Stability, Station,
};
use super::equilibria::resolved as resolved_at;
use super::problem::problem_at;
use super::start::start;
use crate::SimError;
use crate::case_error::CaseError;
use nalgebra::Vector3;
use rapunzel_rod_static as rods;
use rapunzel_scene::case::{BranchSwitch, Case, CaseSweep, Parameter};
use rods::{BranchEnd, LimitKind, LimitPoint, ParameterSweep, StaticError};

/// Steps in which a critical value is sought.
const CRITICAL_STEPS: usize = 20;

/// The branch that the sweep of a case asks for, and the equilibria that are shown.
pub(super) fn sweep(
    case: &Case,
    asked: &CaseSweep,
) -> Result<(CaseBranch, Vec<CaseEquilibrium>), SimError> {
    let CaseSweep { of, from, to, steps, shapes, switch } = *asked;
    let until = switch.map_or(SweepGoal::End, SweepGoal::Other);
    follow(case, of, [from, to], steps, until).map(|branch| told(case, of, &branch, shapes))
}

/// What a branch is followed for.
#[derive(Clone, Copy)]
enum SweepGoal {
    /// The end of the range.
    End,
    /// Where it loses its stability.
    Unstable,
    /// The end of the range on another branch.
    Other(BranchSwitch),
}

/// The branch up to where it loses its stability.
///
/// # Errors
/// [`CaseError::NotCritical`] if it does not.
pub(super) fn critical(
    case: &Case,
    of: Parameter,
    [from, to]: [f64; 2],
) -> Result<(CaseBranch, Vec<CaseEquilibrium>), SimError> {
    let branch = follow(case, of, [from, to], CRITICAL_STEPS, SweepGoal::Unstable)?;
    if branch.ended != BranchEnd::Lost || branch.limits.is_empty() {
        let last = branch.points.last().map_or(from, |point| point.parameter);
        let stuck = branch.ended != BranchEnd::Reached;
        return Err(CaseError::NotCritical { last, unit: of.unit(), stuck }.into());
    }
    let (told, _) = told(case, of, &branch, 2);
    let shown = told.limits.iter().map(|limit| limit.equilibrium.clone()).take(1).collect();
    Ok((CaseBranch { shown: Vec::new(), ..told }, shown))
}

fn follow(
    case: &Case,
    of: Parameter,
    [from, to]: [f64; 2],
    steps: usize,
    until: SweepGoal,
) -> Result<rods::Branch, SimError> {
    let first = problem_at(case, of, from)?;
    let problem = |value: f64| match problem_at(case, of, value) {
        Ok(problem) => Ok(problem),
        Err(SimError::Static(error)) => Err(error),
        Err(_) => Err(StaticError::NotFound),
    };
    let sweep = ParameterSweep { problem: &problem, from, to, steps };
    let start = start(&at(case, of, from), &first)?;
    Ok(match until {
        SweepGoal::End => sweep.follow(&start)?,
        SweepGoal::Unstable => sweep.until_unstable(&start)?,
        SweepGoal::Other(switch) => sweep.follow_other(&start, switch.at, switch.other_side)?,
    })
}

/// The case in what its answer depends on beside the equilibrium.
fn at(case: &Case, of: Parameter, value: f64) -> Case {
    let length = if of == Parameter::Length { value } else { case.length };
    Case { length, ..case.clone() }
}

fn told(
    case: &Case,
    of: Parameter,
    branch: &rods::Branch,
    shapes: usize,
) -> (CaseBranch, Vec<CaseEquilibrium>) {
    let resolved = |value: f64, found: &rods::Equilibrium| resolved_at(&at(case, of, value), found);
    let points = branch.points.iter().map(|point| {
        let (parameter, found) = (point.parameter, &point.equilibrium);
        let own = Case { parts: 2, ..at(case, of, parameter) };
        let numbers = resolved_at(&own, found);
        BranchRow {
            parameter,
            ways_down: found.conjugate_points(),
            elastic_energy: numbers.elastic_energy,
            load_energy: numbers.load_energy,
            clamp_force: numbers.clamp_force,
            clamp_moment: numbers.clamp_moment,
            end_force: numbers.end_force,
            end_moment: numbers.end_moment,
            end_position: numbers.stations[2].position,
        }
    });
    let last = branch.points.len() - 1;
    let mut shown: Vec<usize> = (0..shapes).map(|i| i * last / (shapes - 1)).collect();
    shown.dedup();
    let shapes = shown.iter().map(|i| &branch.points[*i]);
    let shapes = shapes.map(|point| resolved(point.parameter, &point.equilibrium)).collect();
    let limits = branch.limits.iter().map(|limit| {
        let mut equilibrium = resolved(limit.parameter, limit.mode.equilibrium());
        equilibrium.stability = match limit.conjugate_points[1] {
            0 => Stability::Stable,
            ways => Stability::Unstable(ways),
        };
        CaseLimit {
            is_fold: limit.kind == LimitKind::Fold,
            parameter: limit.parameter,
            ways_down: limit.conjugate_points,
            mode: mode(limit, &equilibrium),
            equilibrium,
        }
    });
    let ended = match branch.ended {
        BranchEnd::Reached => Ended::Reached,
        BranchEnd::Returned => Ended::Returned,
        BranchEnd::Lost => Ended::Lost,
        // Only on the way to another branch.
        BranchEnd::Long | BranchEnd::Met => Ended::Long,
        BranchEnd::Stuck => Ended::Stuck,
    };
    let (points, limits) = (points.collect(), limits.collect());
    let switched = branch.switched;
    (CaseBranch { unit: of.unit(), points, limits, ended, switched, shown }, shapes)
}

/// The mode at the stations of its equilibrium.
fn mode(limit: &LimitPoint, equilibrium: &CaseEquilibrium) -> Vec<ModeStation> {
    let stations = &equilibrium.stations;
    let all: Vec<[Vector3<f64>; 2]> = stations.iter().map(|one| limit.mode.at(one.s)).collect();
    let largest = |i: usize| all.iter().map(|one| one[i].norm()).fold(0.0, f64::max);
    let length = stations[stations.len() - 1].s;
    let (moved, turned) = (largest(0), largest(1));
    let size = if moved > 1e-9 * length * turned { moved } else { turned };
    let station = |(one, at): (&[Vector3<f64>; 2], &Station)| {
        let [displacement, rotation] = one.map(|v| (v / size).into());
        ModeStation { s: at.s, displacement, rotation }
    };
    all.iter().zip(stations).map(station).collect()
}
