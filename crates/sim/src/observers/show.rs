use crate::World;
use crate::folder::{SPRINGS_USD, USD};
use crate::scene::{Format, Joint, MassSpring, Motion, Moves, Object, Scene, Tip, Wind};
use rapunzel_export::preview::Support;
use rapunzel_export::usd::{Prim, Shape};
use std::ops::Range;

/// What frames show.
#[derive(Debug)]
pub(crate) struct Show {
    /// As which files beside those for ParaView.
    pub(crate) formats: Vec<Format>,
    /// The USD layer of the strands, and the prim that holds them.
    pub(crate) layer: (&'static str, &'static str),
    /// What the strands are in it.
    pub(crate) prims: Vec<Prim>,
    pub(crate) objects: Objects,
    /// Which previews show.
    pub(crate) wind: Wind,
    /// What holds the strands, and when, s.
    holds: Vec<(Support, Range<f64>)>,
}

/// Which files hold the objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Objects {
    /// There are none.
    None,
    /// One for all frames: none moves.
    Once,
    /// One for each frame.
    Always,
}

/// Colours of hair, bundle by bundle: red, green and blue, linear.
const HAIR: [[f64; 3]; 6] = [
    [0.09, 0.045, 0.02],
    [0.35, 0.2, 0.08],
    [0.25, 0.06, 0.02],
    [0.03, 0.02, 0.015],
    [0.55, 0.4, 0.2],
    [0.35, 0.33, 0.3],
];
/// Colour of springs.
const ROPE: [f64; 3] = [0.5, 0.4, 0.25];

impl Show {
    /// Of a scene and its world.
    pub(crate) fn of(scene: &Scene, world: &World) -> Self {
        let springs = scene.mass_spring.as_ref();
        let wind = springs.map_or(scene.environment.wind, |springs| springs.wind);
        let layer = springs.map_or((USD, "Fibers"), |_| (SPRINGS_USD, "Springs"));
        Self {
            formats: scene.output.formats.clone(),
            layer,
            prims: prims(scene, world),
            objects: Objects::of(&scene.objects),
            wind,
            holds: springs.map_or_else(|| holds(scene), |springs| node_holds(springs, world)),
        }
    }

    /// What holds the strands at a time, s.
    pub(crate) fn supports(&self, time: f64) -> Vec<Support> {
        let now = self.holds.iter().filter(|(_, times)| times.contains(&time));
        now.map(|(support, _)| *support).collect()
    }
}

/// From the start on.
const ALWAYS: Range<f64> = 0.0..f64::INFINITY;

/// What holds the ends of fibres.
fn holds(scene: &Scene) -> Vec<(Support, Range<f64>)> {
    let bundles = scene.fibers.iter();
    let bundles = bundles.flat_map(|bundle| (0..bundle.arrangement.fibers()).map(move |_| bundle));
    let holds = bundles.enumerate().flat_map(|(strand, bundle)| {
        let by = |joint: &Joint| match joint {
            Joint::Clamped => Some(true),
            Joint::Ball { .. } => Some(false),
            Joint::Free => None,
        };
        let tip = match &bundle.tip {
            Tip::Free | Tip::Loaded { .. } => None,
            Tip::Pulled { until, .. } => Some((true, 0.0..*until)),
            Tip::Held => Some((true, ALWAYS)),
            Tip::Driven { joint, .. } => by(joint).map(|clamped| (clamped, ALWAYS)),
        };
        let root = by(&bundle.root_joint).map(|clamped| (clamped, ALWAYS));
        let ends = [(0, root), (bundle.segments, tip)];
        ends.into_iter().filter_map(move |(point, hold)| {
            let (clamped, times) = hold?;
            Some((Support { strand, point, clamped }, times))
        })
    });
    holds.collect()
}

/// What holds nodes of a mass-spring system.
fn node_holds(scene: &MassSpring, world: &World) -> Vec<(Support, Range<f64>)> {
    let Some(springs) = &world.springs else { return Vec::new() };
    let mut holds = Vec::new();
    for (node, [strand, point]) in springs.places() {
        let support = Support { strand, point, clamped: false };
        let taken = scene.holds.iter().filter(|hold| hold.node == node);
        let end = |release, until| if release { until } else { f64::INFINITY };
        if springs.is_held(node) {
            let ends = taken.clone().map(|hold| end(hold.release, hold.until));
            holds.push((support, 0.0..ends.fold(f64::INFINITY, f64::min)));
        }
        holds.extend(taken.map(|hold| (support, hold.from..end(hold.release, hold.until))));
    }
    holds
}

/// A prim for each bundle; of springs their surface, to which the lines are a guide.
fn prims(scene: &Scene, world: &World) -> Vec<Prim> {
    if let Some(springs) = &world.springs {
        let surface = springs.surface();
        let (strands, guide) = (0..springs.strands().len(), surface.is_some());
        let lines = Shape::Curves { strands, guide };
        let prim = |(name, shape): (&str, _)| Prim { name: name.to_owned(), shape, color: ROPE };
        let surface = surface.map(|shape| ("Surface", shape));
        return surface.into_iter().chain([("Lines", lines)]).map(prim).collect();
    }
    let bundles = scene.fibers.iter().scan(0, |end, bundle| {
        let first = *end;
        *end += bundle.arrangement.fibers();
        Some(first..*end)
    });
    let prim = |(i, strands): (usize, Range<usize>)| Prim {
        name: format!("Bundle_{i}"),
        shape: Shape::Curves { strands, guide: false },
        color: HAIR[i % HAIR.len()],
    };
    bundles.enumerate().map(prim).collect()
}

impl Objects {
    pub(crate) fn of(objects: &[Object]) -> Self {
        let still = |one: &Object| one.moves == Moves::Led && one.motion == Motion::Fixed;
        match objects {
            [] => Self::None,
            _ if objects.iter().all(still) => Self::Once,
            _ => Self::Always,
        }
    }

    /// The number of the file for a frame.
    pub(crate) fn file(self, frame: usize) -> Option<usize> {
        match self {
            Self::None => None,
            Self::Once => Some(0),
            Self::Always => Some(frame),
        }
    }

    /// How many files there are of so many frames.
    pub(crate) fn count(self, frames: u64) -> u64 {
        match self {
            Self::None => 0,
            Self::Once => 1,
            Self::Always => frames,
        }
    }
}
