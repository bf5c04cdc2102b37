//! Figure 8.18 by the thesis's own method: kinematic chains with and without bending springs.

use crate::Fallible;
use crate::drawing::{Chart, Curve, Drawing, Picture, Pictures};
use crate::report::{Check, Criterion, Figure, check};
use crate::size::Size;
use nalgebra::{Point3, Vector3};
use rapunzel_contact::chain::{
    Chain, Coupling, Method, Order, Root, SegmentContact, SegmentPartner, Settings, Springs, step,
};
use rapunzel_contact::projection::{Differences, Form, Polygon};
use rapunzel_fiber::Fiber;
use rapunzel_sim::Scene;

/// When pictures are taken, s.
const TIMES: [f64; 4] = [0.0, 0.1, 0.2, 0.6];
/// Length of a step, s. In the thesis's milliseconds an impact at an end turns a segment of 3 mm by a good
/// part of a radian, and its joints are not closed any more.
const DT: f64 = 1e-4;
/// Gaps up to which contacts are looked for, m: what closes in a step at ten metres a second.
const REACH: f64 = 1e-3;
/// Of a hair, um.
const DIAMETER: f64 = 70.0;

/// The hairs of a scene as free chains over a plane on which they slide.
struct Bundle {
    chains: Vec<Chain>,
    /// Radius of a hair, m.
    radius: f64,
    /// Height of the plane, m.
    ground: f64,
    friction: Polygon,
}

impl Bundle {
    fn new(scene: &Scene, springs: bool) -> Fallible<Self> {
        let world = scene.build()?;
        let fibers = world.assembly().fibers();
        let chain = |(i, fiber): (usize, &Fiber)| -> Fallible<Chain> {
            let (state, node) = (world.state(i), fiber.nodes()[0]);
            let (nodes, radius) = (state.positions, node.section.equivalent_radius());
            let first = state.frames[0] * Vector3::x();
            let chain = Chain::new(&nodes, node.linear_density, radius, &first, Root::Free)?;
            if !springs {
                return Ok(chain);
            }
            let (stiffness, natural) = (node.stiffness, chain.curvatures());
            Ok(chain.with_springs(Springs { stiffness, natural, coupling: Coupling::Implicit })?)
        };
        Ok(Self {
            chains: fibers.iter().enumerate().map(chain).collect::<Fallible<_>>()?,
            radius: *world.assembly().radii().first().ok_or("a scene with hairs")?,
            ground: scene.objects.first().ok_or("a scene with a plane")?.position[2],
            friction: Polygon::regular(0.0, 4)?,
        })
    }

    /// Nodes of every chain, m; where a joint is open, the end of the segment towards the root.
    fn nodes(&self) -> Vec<Vec<Point3<f64>>> {
        let nodes = |chain: &Chain| {
            let count = chain.segments().len();
            let first = chain.ends(0)[0];
            std::iter::once(first).chain((0..count).map(|i| chain.ends(i)[1])).collect()
        };
        self.chains.iter().map(nodes).collect()
    }

    /// Contacts of the ends of all segments with the plane.
    fn contacts(&self) -> Vec<SegmentContact> {
        let chains = self.chains.iter().enumerate();
        let ends = chains.flat_map(|(chain, one)| {
            (0..one.segments().len()).flat_map(move |i| one.ends(i).map(|end| (chain, i, end)))
        });
        let contact = |(chain, segment, end): (usize, usize, Point3<f64>)| SegmentContact {
            chain,
            segment,
            point: end - self.radius * Vector3::z(),
            normal: Vector3::z(),
            gap: end.z - self.radius - self.ground,
            partner: SegmentPartner::Given(Vector3::zeros()),
            friction: self.friction.clone(),
        };
        ends.map(contact).filter(|contact| contact.gap < REACH).collect()
    }

    /// Mean angle at a joint, degrees.
    fn bend(&self) -> f64 {
        let (mut sum, mut joints) = (0.0, 0);
        for nodes in self.nodes() {
            for ends in nodes.windows(3) {
                sum += (ends[1] - ends[0]).angle(&(ends[2] - ends[1])).to_degrees();
                joints += 1;
            }
        }
        sum / f64::from(joints)
    }

    /// Height over the plane of what is highest, m.
    fn height(&self) -> f64 {
        self.nodes().concat().iter().map(|p| p.z - self.ground).fold(0.0, f64::max)
    }
}

/// What a run of a bundle left.
#[derive(Default)]
struct Outcome {
    pictures: Vec<Picture>,
    /// Mean angle at a joint over time, degrees, by the time in s.
    bends: Vec<[f64; 2]>,
    /// Height at the end, mm.
    height: f64,
    /// Widest gap of a joint and deepest penetration of the plane in all steps, um.
    gap: f64,
    depth: f64,
}

fn run(scene: &Scene, springs: bool, method: Method, order: Order) -> Fallible<Outcome> {
    let contact = scene.contact.as_ref().ok_or("a scene with contact")?;
    let settings = Settings {
        dt: DT,
        gravity: Vector3::from(scene.environment.gravity),
        method,
        order,
        harmonizations: 1,
        restitution: contact.restitution,
        form: Form::Corrected.into(),
        // Each segment by itself, as the thesis does it.
        projection: Differences { scope: Form::AsPrinted, ..Form::Corrected.into() },
    };
    let mut bundle = Bundle::new(scene, springs)?;
    let mut outcome = Outcome::default();
    let name = if springs { "with springs" } else { "without" };
    let mut steps = 0;
    loop {
        let time = f64::from(steps) * DT;
        if steps % 20 == 0 {
            outcome.bends.push([time, bundle.bend()]);
        }
        if TIMES.get(outcome.pictures.len()).is_some_and(|due| time > due - 0.5 * DT) {
            let caption = format!("{name}, t = {time:.3} s");
            outcome.pictures.push(Picture { caption, fibers: bundle.nodes() });
        }
        if time > scene.duration - 0.5 * DT {
            break;
        }
        let contacts = bundle.contacts();
        outcome.depth = contacts.iter().map(|c| -1e6 * c.gap).fold(outcome.depth, f64::max);
        let report = step(&mut bundle.chains, &contacts, &settings)?;
        outcome.gap = outcome.gap.max(1e6 * report.widest_gap);
        steps += 1;
    }
    outcome.height = 1e3 * bundle.height();
    Ok(outcome)
}

/// What the thesis says of a bundle with and of one without springs.
fn judged(name: &str, order: Order, [stiff, limp]: &[Outcome; 2]) -> [Check; 6] {
    let bend = |outcome: &Outcome| outcome.bends.last().map_or(f64::NAN, |last| last[1]);
    let most = |value: fn(&Outcome) -> f64| value(stiff).max(value(limp));
    let named = |what: &str| format!("{name}: {what}");
    let (gaps, depths) = match order {
        Order::JointsFirst => (Criterion::AtLeast(1.0), Criterion::AtMost(DIAMETER)),
        Order::ContactsFirst => (Criterion::AtMost(10.0), Criterion::AtLeast(DIAMETER)),
    };
    let smooth = "smooth with springs: a joint of the coils has 22 degrees";
    [
        check(
            named("height at rest, with springs"),
            stiff.height,
            "mm",
            Criterion::AtLeast(9.0),
            "stable loops keep it from lying flat; the coils are 12 mm high",
        ),
        check(
            named("height at rest, without"),
            limp.height,
            "mm",
            Criterion::AtMost(1.0),
            "loops collapse, the fibers sink under their weight",
        ),
        check(
            named("mean angle, with springs"),
            bend(stiff),
            "deg",
            Criterion::AtMost(30.0),
            smooth,
        ),
        check(
            named("mean angle, without"),
            bend(limp),
            "deg",
            Criterion::AtLeast(60.0),
            "jagged shapes",
        ),
        check(
            named("widest gap of a joint"),
            most(|outcome| outcome.gap),
            "um",
            gaps,
            "joints open where contacts have the last word (8.6.5.3)",
        ),
        check(
            named("deepest penetration"),
            most(|outcome| outcome.depth),
            "um",
            depths,
            "what lies sags where joints have the last word (8.6.5.3)",
        ),
    ]
}

/// Figure 8.18: springs keep loops and smooth shapes, without them fibers collapse to jagged ones. By
/// both ways to close joints (8.5.1, 8.5.2) and both orders of Alg. 7 (8.6.5.3).
pub(crate) fn springs(size: Size) -> Fallible<Figure> {
    let scene = size.scene("partly-elastic", 4, 50)?;
    let (mut pictures, mut curves, mut checks) = (Vec::new(), Vec::new(), Vec::new());
    for (method, by) in [(Method::ImpulseCorrection, "I"), (Method::Linearized, "II")] {
        for (order, last) in [(Order::JointsFirst, "contacts"), (Order::ContactsFirst, "joints")] {
            let name = format!("{by}, {last} last");
            let mut outcomes =
                [run(&scene, true, method, order)?, run(&scene, false, method, order)?];
            checks.extend(judged(&name, order, &outcomes));
            for (outcome, springs) in outcomes.iter_mut().zip(["springs", "none"]) {
                let points = std::mem::take(&mut outcome.bends);
                curves.push(Curve { name: format!("{name}, {springs}"), points });
            }
            // The thesis's own way.
            if pictures.is_empty() {
                pictures = outcomes.into_iter().flat_map(|outcome| outcome.pictures).collect();
            }
        }
    }
    let pictures = Pictures {
        title: "8.18 Chains on a plane, with and without bending springs".into(),
        view: "seen along x",
        axes: [Vector3::y(), Vector3::z()],
        columns: 4,
        pictures,
    };
    let chart = Chart {
        title: "8.18 Mean angle at a joint".into(),
        x: "time (s)",
        y: "angle (degrees)",
        log_from: None,
        curves,
    };
    Ok(Figure {
        scene: "scenes/contact/partly-elastic.ron",
        parameters: "kinematic chains by steps of 0.1 ms; the plane is smooth, and hairs do not meet: \
                     with friction, or contacts of hairs, chains break at the impact",
        drawings: vec![Drawing::Pictures(pictures), Drawing::Chart(chart)],
        checks,
    })
}
