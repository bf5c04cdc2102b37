use super::answer::{CaseEquilibrium, Peak, Stability, Station};
use super::problem::{natural_curvature, piece, pose, problem};
use super::start::start;
use crate::SimError;
use nalgebra::Vector3;
use rapunzel_fiber::NodeProperties;
use rapunzel_rod_static as rods;
use rapunzel_scene::LoadFrame;
use rapunzel_scene::case::{Case, CaseEnd};
use rods::{Chain, State, StaticError, Target};

/// Segments of a chain between two stations, at least: its error falls with their square.
const CHAIN_SEGMENTS: usize = 400;
/// Part of the largest number of its kind along the rod below which one is only rounding.
const STATION_ROUNDING: f64 = 1e-12;

/// The equilibria of the case at its own length.
pub(super) fn equilibria(case: &Case) -> Result<Vec<CaseEquilibrium>, SimError> {
    if case.needs_chain() {
        return Ok(vec![chain(case)?]);
    }
    let found = match case.all_with_turns {
        None => vec![start(case, &problem(case)?)?],
        Some(turns) => problem(case)?.solutions(turns),
    };
    if found.is_empty() {
        return Err(StaticError::NotFound.into());
    }
    Ok(found.iter().map(|one| resolved(case, one)).collect())
}

/// The stable equilibrium of a case near one of a rod of another length, if Newton's method leads
/// from that to one; cases that need a chain have none.
pub(super) fn near(case: &Case, other: &CaseEquilibrium) -> Option<CaseEquilibrium> {
    if case.needs_chain() {
        return None;
    }
    let problem = problem(case).ok()?;
    let longer = case.length / other.stations.last()?.s;
    let guess: Vec<_> = other.stations.iter().map(|one| (one.s * longer, one.state())).collect();
    let found = problem.solve_near(&guess).ok()?;
    found.is_stable().then(|| resolved(case, &found))
}

pub(super) fn resolved(case: &Case, found: &rods::Equilibrium) -> CaseEquilibrium {
    let states: Vec<(f64, State)> = (0..=case.parts)
        .map(|i| case.length * i as f64 / case.parts as f64)
        .map(|s| (s, found.at(s)))
        .collect();
    let stability = match found.conjugate_points() {
        0 => Stability::Stable,
        ways => Stability::Unstable(ways),
    };
    let (elastic, loads) = (found.elastic_energy(), found.load_energy());
    equilibrium(case, &states, stability, elastic, loads, Vec::new())
}

/// The rod as a chain whose nodes are the stations and more between them.
fn chain(case: &Case) -> Result<CaseEquilibrium, SimError> {
    let finer = CHAIN_SEGMENTS.div_ceil(case.parts);
    let count = case.parts * finer;
    // Segments of a chain need no smooth properties: one piece, whose segments are all alike.
    let whole = piece(case, &case.matter(), case.length);
    let mut chain = Chain::new(&pose(&case.clamp)?, &[whole], count)?;
    #[expect(clippy::cast_possible_truncation, reason = "between 0 and the segments")]
    let node = |at: f64| (at / case.length * count as f64).round() as usize;
    let mut forces = chain.forces().to_vec();
    let mut followers = vec![Vector3::zeros(); count + 1];
    for mass in &case.masses {
        forces[node(mass.at)] += Vector3::from(case.gravity) * mass.mass;
    }
    for force in &case.forces {
        let on = match force.frame {
            LoadFrame::World => &mut forces,
            LoadFrame::Follower => &mut followers,
        };
        on[node(force.at)] += Vector3::from(force.value);
    }
    let follows = followers.iter().any(|force| *force != Vector3::zeros());
    let mut targets: Vec<Target> = case
        .places
        .iter()
        .map(|place| Target {
            node: node(place.at),
            place: place.position.into(),
            stiffness: place.stiffness.unwrap_or(f64::INFINITY),
        })
        .collect();
    match case.end {
        CaseEnd::Free { force, .. } => forces[count] += Vector3::from(force),
        CaseEnd::Joint { position } => targets.push(Target::held(count, position.into())),
        // Refused when the case was checked.
        _ => {}
    }
    chain.set_forces(&forces)?;
    chain.set_followers(&followers)?;
    chain.set_targets(&targets)?;
    let rest = chain.solve()?;
    let states = chain.states(&rest);
    let at = chain.arc_lengths().into_iter().zip(states).step_by(finer);
    let pulls = rest.pulls.iter().take(case.places.len()).map(|pull| (*pull).into()).collect();
    let stability = if follows { Stability::Unknown } else { Stability::Stable };
    let (elastic, loads) = (chain.elastic_energy(&rest.shape), 0.0 - chain.work(&rest.shape));
    Ok(equilibrium(case, &at.collect::<Vec<_>>(), stability, elastic, loads, pulls))
}

pub(super) fn equilibrium(
    case: &Case,
    states: &[(f64, State)],
    stability: Stability,
    elastic_energy: f64,
    load_energy: f64,
    place_forces: Vec<[f64; 3]>,
) -> CaseEquilibrium {
    let matter = case.matter();
    let natural = natural_curvature(case);
    let curvature = |(s, state): &(f64, State)| {
        let NodeProperties { stiffness, natural_curvature, .. } = matter.at(s / case.length);
        natural
            + natural_curvature
            + (state.frame.inverse() * state.moment).component_div(&stiffness)
    };
    // What is bent to the radius of its length, or more.
    let largest = |unit: f64, of: &dyn Fn(&State) -> f64| {
        states.iter().map(|(_, state)| of(state)).fold(unit, f64::max)
    };
    let stiffest =
        |most: f64, (s, _): &(f64, State)| most.max(matter.at(s / case.length).stiffness.max());
    let unit = states.iter().fold(0.0, stiffest) / case.length;
    let force = largest(unit / case.length, &|state| state.force.norm());
    let moment = largest(unit, &|state| state.moment.norm());
    let bent = states.iter().map(|at| curvature(at).norm()).fold(1.0 / case.length, f64::max);
    let far = largest(case.length, &|state| state.position.coords.norm());
    let stations: Vec<Station> = states
        .iter()
        .map(|at @ (s, state)| Station {
            s: *s,
            position: rounded(state.position.coords, far),
            frame: [0, 1, 2].map(|i| rounded(state.frame.matrix().column(i).into_owned(), 1.0)),
            force: rounded(state.force, force),
            moment: rounded(state.moment, moment),
            curvature: rounded(curvature(at), bent),
        })
        .collect();
    let bend = |station: &Station| station.curvature[0].hypot(station.curvature[1]);
    let sharpest =
        stations.iter().map(|station| Peak { at: station.s, curvature: bend(station) }).fold(
            Peak { at: 0.0, curvature: 0.0 },
            |a, b| if b.curvature > a.curvature { b } else { a },
        );
    let gravity = Vector3::from(case.gravity);
    let depth = |(_, state): &(f64, State)| match gravity.try_normalize(0.0) {
        Some(down) => down.dot(&state.position.coords),
        None => 0.0,
    };
    let (first, last) = (&stations[0], &stations[stations.len() - 1]);
    let lower = depth(&states[0]).max(depth(&states[states.len() - 1]));
    let deepest = states.iter().map(depth).fold(lower, f64::max);
    let sag = deepest - lower;
    CaseEquilibrium {
        stability,
        elastic_energy,
        load_energy,
        clamp_force: first.force,
        clamp_moment: first.moment,
        end_force: last.force,
        end_moment: last.moment,
        place_forces,
        sharpest,
        sag: if sag < STATION_ROUNDING * far { 0.0 } else { sag },
        stations,
    }
}

/// The vector without components that are only what rounding leaves of numbers of size `largest`.
fn rounded(v: impl Into<[f64; 3]>, largest: f64) -> [f64; 3] {
    v.into().map(|x| if x.abs() < STATION_ROUNDING * largest { 0.0 } else { x })
}
