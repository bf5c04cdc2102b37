//! Fibres that taper and fibres of measured stiffness, in scenes and cases.

use rapunzel_sim::statics::{Case, solve};
use rapunzel_sim::{MemoryEstimate, Scene, World};
use std::f64::consts::PI;

const LENGTH: f64 = 0.1;
const RADIUS: f64 = 1e-3;
/// Radius at the tip over that at the root.
const TIP: f64 = 0.4;
const MODULUS: f64 = 1e7;

/// Bending stiffness at the root, N m^2.
fn stiffness() -> f64 {
    MODULUS * PI / 4.0 * RADIUS.powi(4)
}

/// What a cone is, in a scene or a case.
fn cone() -> String {
    format!(
        "taper: [(at: 0, section: Circle(radius: {RADIUS:?})), \
         (at: 1, section: Circle(radius: {:?}))]",
        TIP * RADIUS
    )
}

/// Angle by which a cone under the couple `m` (N m) on its end has turned at the arc length `s`:
/// the integral of `m / E I`, with `E I = B (1 - c s)^4`.
fn turned(m: f64, s: f64) -> f64 {
    let c = (1.0 - TIP) / LENGTH;
    m / (3.0 * c * stiffness()) * ((1.0 - c * s).powi(-3) - 1.0)
}

/// The couple that turns the end of the cone by an angle.
fn couple(angle: f64) -> f64 {
    angle / turned(1.0, LENGTH)
}

/// The angle at the end of a cone in a scene of so many segments, and the one it has there.
fn bent(segments: usize) -> [f64; 2] {
    let moment = couple(2.0);
    let text = format!(
        "(format: 1, duration: 100.0, fibers: [(
            length: {LENGTH}, segments: {segments}, {},
            material: Elastic(density: 1000.0, youngs_modulus: {MODULUS:?}, shear_modulus: 4e6),
            root: (orientation: Along(direction: (1, 0, 0))), damping_time: 0.1,
            tip: Loaded(moment: (value: (0, {moment:?}, 0), profile: Ramp(until: 2.0))))],
        environment: (gravity: (0, 0, 0)),
        stepper: (dt: 0.1, method: BackwardEuler))",
        cone()
    );
    let scene = Scene::from_ron(&text).unwrap_or_else(|error| panic!("{error}"));
    let mut world = World::build(&scene).expect("a world");
    for _ in 0..200 {
        world.step(0.1).expect("a step");
    }
    let state = world.state(0);
    let tangent = state.frames[segments - 1].matrix().column(2).into_owned();
    let middle = LENGTH * (1.0 - 0.5 / segments as f64);
    [(-tangent.z).atan2(tangent.x), turned(moment, middle)]
}

/// A cone under a couple on its end, at any deflection. Joints have the stiffness of their place,
/// so that the angle is a sum of midpoints: it is off by `h^2 / 24` times what the slope of the
/// curvature gains from end to end, but for the fourth power of the segments, `7 h^4 / 5760` times
/// its third derivative.
#[test]
fn a_tapered_cantilever_bends_as_its_closed_form_to_the_order_of_the_segments() {
    let c = (1.0 - TIP) / LENGTH;
    let slope = |s: f64| couple(2.0) / stiffness() * 4.0 * c * (1.0 - c * s).powi(-5);
    for segments in [20_u32, 40, 80] {
        let [found, right] = bent(segments as usize);
        let h = LENGTH / f64::from(segments);
        let end = LENGTH - 0.5 * h;
        let expected = h * h / 24.0 * (slope(end) - slope(0.0));
        let (error, next) = ((found - right).abs(), 7.0 * h * h / 240.0 * 30.0 * (c / TIP).powi(2));
        println!("{segments}: {error:.3e} for {expected:.3e}");
        assert!((error / expected - 1.0).abs() < next, "{segments}: {error:e} {expected:e} {next}");
    }
}

fn case(rest: &str) -> Case {
    let text = format!("(format: 1, length: {LENGTH}, gravity: (0, 0, 0), {rest})");
    Case::from_ron(&text).unwrap_or_else(|error| panic!("{error}"))
}

/// The same rod in `solve`: to the precision of the solver, large deflections with it.
#[test]
fn a_cone_at_rest_turns_as_its_closed_form() {
    let moment = couple(2.0);
    let text = format!(
        "rod: Solid(section: Circle(radius: {RADIUS:?}),
            material: Elastic(density: 1000.0, youngs_modulus: {MODULUS:?}, shear_modulus: 4e6)),
        {}, clamp: (orientation: Along(direction: (1, 0, 0))),
        end: Free(moment: (0, {moment:?}, 0))",
        cone()
    );
    let found = solve(&case(&text)).expect("an answer");
    for station in &found.equilibria[0].stations {
        let [x, _, z] = station.frame[2];
        let angle = (-z).atan2(x);
        let right = turned(moment, station.s);
        assert!((angle - right).abs() < 1e-8, "{}: {angle} for {right}", station.s);
    }
}

/// A cone under a small force on its end gives way by `P L^3 / 3 E I` over the ratio of its radii;
/// so does one that is given as measured, whose stiffness goes linearly between its points, by
/// `P L^3 / B` times the integral of `(1 - x)^2 / (1 - c x)`.
#[test]
fn a_force_on_the_end_bends_solid_and_measured_rods_as_theory_says() {
    let force = 1e-3 * 3.0 * stiffness() * TIP / LENGTH.powi(2);
    let end = format!(
        "clamp: (orientation: Along(direction: (1, 0, 0))), end: Free(force: (0, 0, {force:?}))"
    );
    let solid = format!(
        "rod: Solid(section: Circle(radius: {RADIUS:?}),
            material: Elastic(density: 1000.0, youngs_modulus: {MODULUS:?}, shear_modulus: 4e6)),
        {}, {end}",
        cone()
    );
    let sag = |text: &str| {
        let found = solve(&case(text)).expect("an answer").equilibria.remove(0);
        found.stations.last().expect("stations").position[2]
    };
    // Of the next order is the square of the slope at the end, 2e-3 at most.
    let close = |found: f64, right: f64| (found / right - 1.0).abs() < 4e-6;
    let (found, right) = (sag(&solid), 1e-3 * LENGTH);
    assert!(close(found, right), "{found} for {right}");
    let b = stiffness();
    let measured = format!(
        "rod: Measured(bending: ({b:?}, {b:?}), torsion: {b:?}, linear_density: 0.01, radius: 1e-3),
        taper: [(at: 0), (at: 1, bending: ({:?}, {:?}))], {end}",
        0.5 * b,
        0.5 * b
    );
    // By division (1 - x)^2 = -2 x (1 - x/2) + 1, hence the integral 2 ln 2 - 1.
    let right = force * LENGTH.powi(3) / b * (2.0 * 2.0_f64.ln() - 1.0);
    let found = sag(&measured);
    assert!(close(found, right), "{found} for {right}");
}

/// Chains, which places and following forces ask for, taper too: pulled by next to nothing, one
/// lies where the rod does.
#[test]
fn a_chain_tapers_as_the_rod_does() {
    let rod = format!(
        "rod: Solid(section: Circle(radius: {RADIUS:?}),
            material: Elastic(density: 1000.0, youngs_modulus: {MODULUS:?}, shear_modulus: 4e6)),
        {}, clamp: (orientation: Along(direction: (1, 0, 0))),
        end: Free(force: (0, 0, {:?}))",
        cone(),
        couple(0.2) / LENGTH
    );
    let pulled = format!("{rod}, places: [(at: 0.05, position: (0.05, 0, 0), stiffness: 1e-12)]");
    let [a, b] = [rod, pulled].map(|text| {
        let found = solve(&case(&text)).expect("an answer").equilibria.remove(0);
        found.stations.last().expect("stations").position
    });
    let apart = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    println!("{:.1e} of the length apart", apart / LENGTH);
    // The midpoint rule of 400 segments, as above, for a tenth of the angle: 1.4e-6 rad.
    assert!(a[2] > 0.01 * LENGTH && apart < 2e-6 * LENGTH, "{a:?} {b:?}");
}

/// One bundle twice: a solid, and the same by its numbers. They move alike to the last bit, and go
/// on from a snapshot so.
#[test]
fn what_is_measured_moves_as_the_solid_with_these_numbers_and_resumes_bit_for_bit() {
    let area = PI * RADIUS * RADIUS;
    let (density, shear) = (1000.0, 4e6);
    let scene = |matter: &str, taper: &str| {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [(length: {LENGTH}, segments: 12,
                section: Circle(radius: {RADIUS:?}), material: {matter}, {taper}
                root: (orientation: Along(direction: (1, 0, 0.3))), damping_time: 1e-3)],
            stepper: (dt: 2e-3))"
        );
        Scene::from_ron(&text).unwrap_or_else(|error| panic!("{error}"))
    };
    let solid = scene(
        &format!(
            "Elastic(density: {density:?}, youngs_modulus: {MODULUS:?}, shear_modulus: {shear:?})"
        ),
        "",
    );
    let node = World::build(&solid).expect("a world").assembly().fibers()[0].nodes()[0];
    let (k, i) = (node.stiffness, node.rotary_inertia);
    let measured = format!(
        "Measured(bending: ({:?}, {:?}), torsion: {:?}, linear_density: {:?},
            rotary_inertia: ({:?}, {:?}))",
        k.x, k.y, k.z, node.linear_density, i.x, i.y
    );
    assert!((node.linear_density / (density * area) - 1.0).abs() < 1e-15);
    let swung = |scene: &Scene, steps: usize| {
        let mut world = World::build(scene).expect("a world");
        for _ in 0..steps {
            world.step(2e-3).expect("a step");
        }
        world
    };
    let measured = scene(&measured, "");
    assert_eq!(swung(&solid, 20).state(0), swung(&measured, 20).state(0));
    // A cone goes on from what was saved, in a world that is built anew.
    let tapered = scene("Hair", &format!("{},", cone()));
    let (half, whole) = (swung(&tapered, 10).snapshot(), swung(&tapered, 20));
    let mut resumed = World::build(&tapered).expect("a world");
    resumed.restore(&half).expect("its own");
    for _ in 0..10 {
        resumed.step(2e-3).expect("a step");
    }
    assert_eq!(resumed.state(0), whole.state(0));
    // The scene survives being written, and its memory is that of its nodes.
    let written = tapered.to_ron().expect("a sound scene");
    assert_eq!(Scene::from_ron(&written).expect("reads back"), tapered);
    let bytes = |scene: &Scene| MemoryEstimate::new(scene).expect("sound").bytes();
    assert_eq!(bytes(&tapered), bytes(&solid));
}

/// Hair of keratin swells as much where it is thin: its stiffness goes with the fourth power of the
/// diameter at any humidity.
#[test]
fn keratin_tapers() {
    let text = "(format: 1, duration: 1.0, fibers: [(length: 0.1, segments: 10,
            material: Keratin(type: \"Caucasian\"), taper: [(at: 0, section: Ellipse(a: 4e-5, b: 3e-5)),
                (at: 1, section: Ellipse(a: 2e-5, b: 1.5e-5))])],
        environment: (climate: (humidity: [(0, 0.9)])), stepper: (dt: 1e-3))";
    let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{error}"));
    let world = World::build(&scene).expect("a world");
    let nodes = world.assembly().fibers()[0].nodes();
    let (root, tip) = (&nodes[0], &nodes[10]);
    for i in 0..3 {
        let ratio = root.stiffness[i] / tip.stiffness[i];
        assert!((ratio / 16.0 - 1.0).abs() < 1e-13, "{ratio}");
    }
    assert!(root.section.semi_axes().0 > 4e-5, "it swells");
    let whole = text.replace("taper: [(at: 0, section: ", "section: ");
    let whole = whole.replace("(at: 1, section: Ellipse(a: 2e-5, b: 1.5e-5))]", "");
    let whole = Scene::from_ron(&whole.replace("b: 3e-5)),", "b: 3e-5),")).expect("sound");
    let node = World::build(&whole).expect("a world").assembly().fibers()[0].nodes()[0];
    assert_eq!(&node, root);
}

#[test]
fn tables_that_make_no_sense_are_refused_with_their_place() {
    let scene = |taper: &str, material: &str| {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [(length: 0.1, segments: 10, material: {material},
                section: Circle(radius: 1e-4), taper: {taper})], stepper: (dt: 1e-3))"
        );
        Scene::from_ron(&text).expect_err("nonsense").to_string()
    };
    let measured = "Measured(bending: (1e-9, 1e-9), torsion: 1e-9, linear_density: 1e-5)";
    let keratin = "Keratin(type: \"Caucasian\", law: ThreeElement)";
    let cases: [(&str, &str, &str, &str); 10] = [
        ("[(at: 0)]", "Hair", "taper", "one at the root and one at the tip"),
        ("[(at: 0.1), (at: 1)]", "Hair", "taper[0].at", "begin at the root"),
        ("[(at: 0), (at: 0.09)]", "Hair", "taper[1].at", "end at the tip"),
        ("[(at: 0), (at: 0.6), (at: 0.5), (at: 1)]", "Hair", "taper[2].at", "order the points"),
        ("[(at: 0), (at: 0.5), (at: 0.5), (at: 1)]", "Hair", "taper[2].at", "order the points"),
        ("[(at: 0), (at: NaN), (at: 1)]", "Hair", "taper[1].at", "order the points"),
        (
            "[(at: 0), (at: 1, section: Circle(radius: 0))]",
            "Hair",
            "taper[1].section.radius",
            "between",
        ),
        ("[(at: 0), (at: 1, torsion: 1e-9)]", "Hair", "taper[1].torsion", "Measured"),
        ("[(at: 0), (at: 1, torsion: -1e-9)]", measured, "taper[1].torsion", "between"),
        ("[(at: 0), (at: 1)]", keratin, "taper", "law: Elastic"),
    ];
    for (taper, material, path, message) in cases {
        let error = scene(taper, material);
        assert!(error.contains(&format!("fibers[0].{path}:")), "{taper}: {error}");
        assert!(error.contains(message), "{taper}: {error}");
    }
    let text = "(format: 1, length: 0.1, rod: Measured(bending: (1e-3, 1e-3), torsion: 1e-3,
        linear_density: 0.01, radius: 1e-3), taper: [(at: 0.2), (at: 1)])";
    let error = Case::from_ron(text).expect_err("nonsense").to_string();
    assert!(error.contains("taper[0].at") && error.contains("begin at the root"), "{error}");
}
