//! Figure 8.18 by the thesis's own method: kinematic chains with and without bending springs.

use crate::size::Size;
use nalgebra::{Point3, Vector3};
use rapunzel_collision::{Candidates, Capsules};
use rapunzel_contact::thesis::chain::{
    Coupling, CylinderChain, JointMethod, JointSprings, LastWord, Root, SegmentContact,
    SegmentPartner, Settings, step,
};
use rapunzel_contact::thesis::projection::{Form, PolygonalCone};
use rapunzel_contact::{GaussSeidel, Tolerance};
use rapunzel_fiber::{Fiber, Layout};
use rapunzel_repro::plot::{Chart, Curve, Drawing, Picture, Pictures};
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, Figure, check};
use rapunzel_sim::scene::FrictionLaw;
use rapunzel_sim::{Scene, World};

/// When pictures are taken, s.
const TIMES: [f64; 4] = [0.0, 0.1, 0.2, 0.6];
/// Length of a step, s: method II leaves joints open by the third power of their turn in a step.
const DT: f64 = 1.5e-4;
/// Gaps up to which there are contacts, m: what closes in a step at four times the speed of the
/// fall.
const REACH: f64 = 3.0 * DT;
/// Axial moments of the segments over those across; see [`CylinderChain::with_axial_moments`].
const AXIAL: f64 = 1.0;
/// To which contacts are solved.
const TOLERANCE: Tolerance =
    Tolerance { residual: 1e-3, normal: 1e-3, slip: 1e-3, iterations: 2000 };
/// Of a hair, um.
const DIAMETER: f64 = 70.0;

/// The hairs of a scene as free chains over a plane.
struct Bundle {
    chains: Vec<CylinderChain>,
    layout: Layout,
    /// Pairs of segments of hairs that may touch.
    near: Candidates,
    /// Radius of a hair, m.
    radius: f64,
    /// Height of the plane, m.
    ground: f64,
    friction: PolygonalCone,
}

impl Bundle {
    fn new(scene: &Scene, springs: bool) -> Fallible<Self> {
        let contact = scene.contact.as_ref().ok_or("a scene with contact")?;
        let FrictionLaw::Isotropic(mu) = contact.friction else {
            return Err("a scene with the same friction in all directions".into());
        };
        let world = World::build(scene)?;
        let fibers = world.assembly().fibers();
        let chain = |(i, fiber): (usize, &Fiber)| -> Fallible<CylinderChain> {
            let (state, node) = (world.state(i), fiber.nodes()[0]);
            let (nodes, radius) = (state.positions, node.section.equivalent_radius());
            let first = state.frames[0] * Vector3::x();
            let chain =
                CylinderChain::new(&nodes, node.linear_density, radius, &first, Root::Free)?
                    .with_axial_moments(AXIAL)?;
            if !springs {
                return Ok(chain);
            }
            let (stiffness, natural) = (node.stiffness, chain.curvatures());
            Ok(chain.with_springs(JointSprings {
                stiffness,
                natural,
                coupling: Coupling::Implicit,
            })?)
        };
        let chains: Vec<CylinderChain> =
            fibers.iter().enumerate().map(chain).collect::<Fallible<_>>()?;
        Ok(Self {
            layout: Layout::new(chains.iter().map(|chain| chain.segments().len())),
            chains,
            near: Candidates::new(REACH, 1e-3)?,
            radius: *world.assembly().radii().first().ok_or("a scene with hairs")?,
            ground: scene.objects.first().ok_or("a scene with a plane")?.position[2],
            friction: PolygonalCone::regular(mu, 8)?,
        })
    }

    /// Nodes of every chain, m; where a joint is open, the end of the segment towards the root.
    fn nodes(&self) -> Vec<Vec<Point3<f64>>> {
        let nodes = |chain: &CylinderChain| {
            let count = chain.segments().len();
            let first = chain.ends(0)[0];
            std::iter::once(first).chain((0..count).map(|i| chain.ends(i)[1])).collect()
        };
        self.chains.iter().map(nodes).collect()
    }

    /// Contacts of the ends of all segments with the plane.
    fn on_the_plane(&self) -> impl Iterator<Item = SegmentContact> + '_ {
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
        ends.map(contact).filter(|contact| contact.gap < REACH)
    }

    /// Contacts of the hairs with each other.
    fn of_hairs(&mut self) -> Fallible<Vec<SegmentContact>> {
        let (positions, radii) = (self.nodes().concat(), vec![self.radius; self.layout.segments()]);
        let mut found = Vec::new();
        self.near.contacts(&Capsules::new(&self.layout, &positions, &radii)?, &mut found)?;
        let place = |segment: u32| {
            let chain = self.layout.segment_fibers()[segment as usize];
            (chain, segment as usize - self.layout.segment_range(chain).start)
        };
        let contact = |contact: &rapunzel_collision::CapsuleContact| {
            let [(other, under), (chain, segment)] = contact.pair.map(place);
            let normal = contact.normal.into_inner();
            let [start, end] = self.chains[other].ends(under);
            let axis = start + contact.fractions[0] * (end - start);
            SegmentContact {
                chain,
                segment,
                point: axis + (self.radius + 0.5 * contact.gap) * normal,
                normal,
                gap: contact.gap,
                partner: SegmentPartner::Segment { chain: other, segment: under },
                friction: self.friction.clone(),
            }
        };
        Ok(found.iter().map(contact).collect())
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

    /// From the lowest to the highest, m.
    fn height(&self) -> f64 {
        let nodes = self.nodes().concat();
        let heights = || nodes.iter().map(|p| p.z);
        heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min)
    }
}

/// What a run of a bundle left.
#[derive(Default)]
struct Outcome {
    pictures: Vec<Picture>,
    /// Mean angle at a joint over time, degrees, by the time in s.
    bends: Vec<[f64; 2]>,
    /// Height in the mean of the last fifth, mm; limp hairs never rest quite.
    height: f64,
    /// Widest gap of a joint and deepest penetration of the plane in all steps, um.
    gap: f64,
    depth: f64,
    /// Contacts of hairs with each other in a step, in the mean, and steps whose contacts were not
    /// solved.
    met: f64,
    unsolved: f64,
}

fn run(scene: &Scene, springs: bool, method: JointMethod, order: LastWord) -> Fallible<Outcome> {
    let contact = scene.contact.as_ref().ok_or("a scene with contact")?;
    let settings = Settings {
        dt: DT,
        gravity: Vector3::from(scene.environment.gravity),
        method,
        order,
        harmonizations: 1,
        restitution: contact.restitution,
        form: Form::Corrected.into(),
    };
    let mut solver = GaussSeidel::new(TOLERANCE);
    let mut bundle = Bundle::new(scene, springs)?;
    let mut outcome = Outcome::default();
    let name = if springs { "with springs" } else { "without" };
    let (mut steps, mut met, mut heights) = (0, 0, Vec::new());
    loop {
        let time = f64::from(steps) * DT;
        if steps % 20 == 0 {
            outcome.bends.push([time, bundle.bend()]);
            if time > 0.8 * scene.duration {
                heights.push(1e3 * bundle.height());
            }
        }
        if TIMES.get(outcome.pictures.len()).is_some_and(|due| time > due - 0.5 * DT) {
            let caption = format!("{name}, t = {time:.3} s");
            outcome.pictures.push(Picture { caption, fibers: bundle.nodes() });
        }
        if time > scene.duration - 0.5 * DT {
            break;
        }
        let mut contacts = bundle.of_hairs()?;
        met += contacts.iter().filter(|contact| contact.gap < 0.0).count();
        let hairs = contacts.len();
        contacts.extend(bundle.on_the_plane());
        outcome.depth =
            contacts[hairs..].iter().map(|c| -1e6 * c.gap).fold(outcome.depth, f64::max);
        let report = step(&mut bundle.chains, &contacts, &settings, &mut solver)?;
        outcome.gap = outcome.gap.max(1e6 * report.widest_gap);
        outcome.unsolved += f64::from(u8::from(report.contacts.is_some_and(|c| !c.converged)));
        steps += 1;
    }
    outcome.met = met as f64 / f64::from(steps);
    outcome.height = heights.iter().sum::<f64>() / heights.len() as f64;
    Ok(outcome)
}

/// What the thesis says of a bundle with and of one without springs.
fn judged(name: &str, order: LastWord, [stiff, limp]: &[Outcome; 2]) -> [ClaimCheck; 8] {
    let bend = |outcome: &Outcome| outcome.bends.last().map_or(f64::NAN, |last| last[1]);
    let most = |value: fn(&Outcome) -> f64| value(stiff).max(value(limp));
    let named = |what: &str| format!("{name}: {what}");
    let (gaps, depths) = match order {
        LastWord::JointsFirst => (Criterion::AtLeast(1.0), Criterion::AtMost(DIAMETER)),
        LastWord::ContactsFirst => (Criterion::AtMost(10.0), Criterion::AtLeast(DIAMETER)),
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
            named("mean angle without over that with"),
            bend(limp) / bend(stiff),
            "",
            Criterion::AtLeast(1.5),
            "jagged shapes against smooth ones",
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
        check(
            named("overlaps of hairs in a step"),
            most(|outcome| outcome.met),
            "",
            Criterion::AtLeast(1.0),
            "hairs meet each other",
        ),
        check(
            named("steps whose contacts were not solved"),
            most(|outcome| outcome.unsolved),
            "",
            Criterion::AtMost(0.0),
            "all are",
        ),
    ]
}

/// Figure 8.18: springs keep loops and smooth shapes, without them fibers collapse to jagged ones.
/// By both ways to close joints (8.5.1, 8.5.2) and both orders of Alg. 7 (8.6.5.3).
pub(crate) fn springs(_: Size) -> Fallible<Figure> {
    // Crowds take hours: 40 limp hairs with contacts last a third of a second a step.
    let scene = Size::Reduced.scene("partly-elastic", 4, 50)?;
    let (mut pictures, mut curves, mut checks) = (Vec::new(), Vec::new(), Vec::new());
    for (method, by) in [(JointMethod::ImpulseCorrection, "I"), (JointMethod::Linearized, "II")] {
        for (order, last) in
            [(LastWord::JointsFirst, "contacts"), (LastWord::ContactsFirst, "joints")]
        {
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
        parameters: "kinematic chains whose segments spin as slowly as they turn, contacts by the law \
                     and not by Alg. 6; steps of 0.15 ms; 4 of 40 hairs",
        drawings: vec![Drawing::Pictures(pictures), Drawing::Chart(chart)],
        checks,
    })
}
