//! What touches before the first step.

use super::detection::ContactDetector;
use super::node_motion::NodeMotion;
use super::rooted::rooted;
use super::sections::{OrientedSections, SectionShapes};
use super::system::CoupledSystem;
use crate::CouplingError;
use crate::TimeInterval;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use crate::held_places::HeldPlaces;
use rapunzel_rod_dynamic::{Conditions, End};

/// How deep in each other things may be at the start, in radii: steps push them apart.
const OVERLAP: f64 = 0.2;

/// All contact points of a world, with the sections of all its segments. Fibres whose held roots
/// are deeper than `depth`, m, in a kinematic object grow out of it from now on, and so do those of
/// a groom whose roots are on one. A world is refused where things are so deep in each other that
/// no step would part them: ends that are held may be no deeper than `depth`, m, what a step may
/// leave of a gap that closes, and all else by a part of the smallest `radius`.
pub(super) fn contact_points(
    system: &CoupledSystem,
    detector: &mut ContactDetector,
    shapes: &SectionShapes,
    radius: f64,
    depth: f64,
) -> Result<Vec<ContactPoint>, CouplingError> {
    let (start, directors) = (system.fibers.positions(), system.fibers.directors(shapes));
    let motion = NodeMotion {
        layout: system.fibers.assembly().layout(),
        sections: OrientedSections { shapes, directors: &directors },
        start: &start,
        end: &start,
        step: TimeInterval::instant(system.start),
        sought: None,
    };
    let grows = |fiber: usize| {
        let held = ends(system, fiber)[0].holds_position();
        let (group, lane) = system.fibers.lane(fiber);
        let near = system.fibers.groups[group].lanes[lane].bundle.grows_within();
        held.then(|| near.unwrap_or(-depth))
    };
    detector.root(rooted(&motion, system.objects, grows));
    detector.hide(system.in_nozzles(system.start));
    let mut points = Vec::new();
    detector.detect(&motion, system.objects, &HeldPlaces::default(), &mut points)?;
    let too_deep = |point: &&ContactPoint| {
        let held = [0, 1].iter().all(|&side| is_held(system, point, side));
        -point.gap > if held { depth } else { OVERLAP * radius }
    };
    match points.iter().filter(too_deep).min_by(|a, b| a.gap.total_cmp(&b.gap)) {
        Some(point) => Err(CouplingError::Overlap {
            sides: point.sides,
            segment: point.segment(),
            depth: -point.gap,
        }),
        None => Ok(points),
    }
}

/// Whether a contact point is where nothing moves its side: at an end that is held, or on an object
/// that is kinematic.
fn is_held(system: &CoupledSystem, point: &ContactPoint, side: usize) -> bool {
    let fiber = match point.sides[side] {
        BodyRef::Object(object) => return !system.objects[object as usize].is_free(),
        BodyRef::Fiber(fiber) => fiber as usize,
    };
    let segments = system.fibers.assembly().fibers()[fiber].segments() as f64;
    let [root, tip] = ends(system, fiber);
    let places = [(0.0, root), (segments, tip)];
    places.iter().any(|(place, end)| point.at()[side] == *place && end.holds_position())
}

/// What holds the root and the tip of a fibre now.
fn ends(system: &CoupledSystem, fiber: usize) -> [End; 2] {
    let (group, lane) = system.fibers.lane(fiber);
    let now = system.fibers.groups[group].lanes[lane].during(system.start).at(system.start);
    [now.root, now.tip]
}
