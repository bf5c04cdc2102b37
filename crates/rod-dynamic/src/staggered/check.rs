//! Validation of rods, states and conditions.

use crate::support::Restraints;
use crate::{End, Instant, Rod, RodError, RodState, SectionLaws, StepError};
use nalgebra::Point3;

/// Slack that a rod held at both ends needs, as a fraction of its length: without it Newton's
/// matrix is singular.
const TAUT: f64 = 1e-9;

pub(super) fn check_laws(rod: &Rod) -> Result<(), RodError> {
    if let SectionLaws::Each(laws) = &rod.laws
        && laws.len() != rod.fiber.nodes().len()
    {
        let (expected, found) = (rod.fiber.nodes().len(), laws.len());
        return Err(RodError::Length { what: "laws", expected, found });
    }
    if rod.laws != SectionLaws::Linear && rod.damping_time > 0.0 {
        let why = "have their own damping; leave the damping time at 0";
        return Err(RodError::Invalid { what: "laws", why });
    }
    Ok(())
}

pub(super) fn check_state(rod: &Rod, state: &RodState) -> Result<(), RodError> {
    let n = rod.fiber.segments();
    for (what, expected, found) in [
        ("positions", n + 1, state.positions.len()),
        ("velocities", n + 1, state.velocities.len()),
        ("frames", n, state.frames.len()),
        ("angular velocities", n, state.angular_velocities.len()),
        ("curvatures", n + 1, state.curvatures.len()),
    ] {
        if expected != found {
            return Err(RodError::Length { what, expected, found });
        }
    }
    let mut numbers = state
        .velocities
        .iter()
        .chain(&state.angular_velocities)
        .chain(&state.curvatures)
        .flatten()
        .chain(state.frames.iter().flat_map(|f| f.matrix().iter()))
        .chain(&state.positions[0].coords);
    if numbers.all(|x| x.is_finite()) && state.time.is_finite() {
        Ok(())
    } else {
        Err(RodError::Invalid { what: "state", why: "all numbers must be finite" })
    }
}

pub(super) fn check_conditions(rod: &Rod, now: &Instant, time: f64) -> Result<(), StepError> {
    now.check(time)?;
    let error = |what, why| Err(StepError::Conditions { fiber: 0, what, time, why });
    let position = |end: &End| match end {
        End::Held(pose) => Some(pose.translation.vector),
        End::Pinned { position, .. } => Some(position.coords),
        End::Supported(support) if Restraints::of(&support.translations) == Restraints::Held => {
            Some(support.pose.translation.vector)
        }
        End::Loaded { .. } | End::Supported(_) => None,
    };
    if now.inside != 0.0 {
        check_nozzle(rod, now).or_else(|why| error("nozzle", why))?;
    }
    let length = || (1.0 - TAUT) * (rod.fiber.length() - now.inside);
    let mouth = |end: &End| match end {
        End::Held(pose) => Some((pose * Point3::new(0.0, 0.0, now.inside)).coords),
        _ => position(end),
    };

    match (mouth(&now.root), position(&now.tip), &now.tip) {
        (Some(root), Some(tip), _) if (root - tip).norm() > length() => error(
            "tip",
            "as far from the root as the rod is long, or further, which cannot stretch; \
                 pulled straight it cannot move and has any tension: bring the ends closer",
        ),
        // The part of the way from the root to the tip that the support holds.
        (Some(root), None, End::Supported(support))
            if (support.held() * (support.pose.translation.vector - root)).norm() > length() =>
        {
            error("tip", "held further from the root than the rod is long: bring the ends closer")
        }
        _ => Ok(()),
    }
}

/// Checks what is inside a nozzle.
fn check_nozzle(rod: &Rod, now: &Instant) -> Result<(), &'static str> {
    let lengths = rod.fiber.segment_lengths();
    let last = lengths[lengths.len() - 1];
    if now.inside < 0.0 {
        return Err("all of the fibre has left it: end the feed before, or make the fibre longer");
    }
    if now.inside > rod.fiber.length() - last {
        return Err("the whole fibre is inside: its last segment must stay outside");
    }
    if !matches!(now.root, End::Held(_)) {
        return Err("the root of what is inside must be held with its frame");
    }
    if rod.laws != SectionLaws::Linear {
        return Err("only rods with the linear law are fed");
    }
    Ok(())
}
