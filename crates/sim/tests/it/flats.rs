//! Flat fibres touch each other where their surfaces are.

use crate::common::Run;
use crate::common::books::Books;
use nalgebra::{Point3, Rotation3, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Semi-axes of a strip, m: thin and wide.
const THIN: f64 = 1e-4;
const WIDE: f64 = 3e-4;

/// Of a strip along x whose wide side is turned about x, from y to z, by an angle, rad: where a
/// plane across a direction touches it, m from its axis. The radius vector to where the normal of
/// an ellipse has a given direction, in closed form.
fn touched(angle: f64, towards: &Vector3<f64>) -> Vector3<f64> {
    let wide = Vector3::new(0.0, angle.cos(), angle.sin());
    let thin = Vector3::new(0.0, -angle.sin(), angle.cos());
    let (u, v) = (WIDE * towards.dot(&wide), THIN * towards.dot(&thin));
    (wide * (WIDE * u) + thin * (THIN * v)) / u.hypot(v)
}

/// A strip of a stiff material from a root along x or y, which the text says, turned about itself
/// by an angle, rad; `more` of it.
fn strip(root: Vector3<f64>, along: &str, angle: f64, more: &str) -> String {
    // The frame at a root along x has d1 downward, and turning that lifts d2, which is along y;
    // along y it has d2 downward.
    let (a, b) = if along == "x" { (THIN, WIDE) } else { (WIDE, THIN) };
    let direction = if along == "x" { "(1, 0, 0)" } else { "(0, 1, 0)" };
    let (x, y, z) = (root.x, root.y, root.z);
    format!(
        "(length: 0.01, segments: 5, section: Ellipse(a: {a:?}, b: {b:?}), damping_time: 1e-3,
            material: Elastic(density: 1000, youngs_modulus: 1e12, shear_modulus: 4e11), {more}
            root: (position: ({x:?}, {y:?}, {z:?}),
                orientation: Along(direction: {direction}, roll: {:?})))",
        angle.to_degrees()
    )
}

/// Where the axis through some nodes is at a number of segments from the first.
fn axis(nodes: &[Point3<f64>], at: f64) -> Point3<f64> {
    let before = (0..nodes.len() - 1).rfind(|&node| node as f64 <= at).unwrap_or_default();
    nodes[before].lerp(&nodes[before + 1], at - before as f64)
}

/// A strip that lies across another one, which is turned about its axis, is hinged at its root and
/// drawn down at its tip. It is borne where the ridge of the lower one is, aside of its axis: by
/// the law of levers the force tells where.
#[test]
fn a_strip_rests_on_the_ridge_of_another() {
    let (pull, before, after) = (1e-4, 3.1e-3, 6.9e-3);
    for (lower, upper) in [(0.0, 0.0), (0.6, 0.0), (-0.6, 0.4), (1.2, -0.3)] {
        let up = Vector3::z();
        let ridge = touched(lower, &up);
        // The upper one is a strip along x that is turned to y: what is along y there is along -x.
        let below =
            Rotation3::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2) * touched(upper, &-up);
        let height = ridge.z - below.z + 1e-9;
        let root = Vector3::new(5.3e-3, -before, height);
        let hinge = "root_joint: Supported(translations: (Held, Held, Held), \
                     rotations: (Free, Held, Held)),";
        let drawn = format!("{hinge} tip: Loaded(force: (value: (0, 0, {:?}))),", -pull);
        let mut run = Run::read(&format!(
            "(format: 1, duration: 1.0, fibers: [{}, {}],
            contact: (friction: Isotropic(0.0), residual: 1e-9, slip: 1e-9, depth: 1e-4),
            environment: (gravity: (0, 0, 0)), stepper: (dt: 1e-3))",
            strip(Vector3::zeros(), "x", lower, ""),
            strip(root, "y", upper, &drawn)
        ));
        // What is pressed so hard moves by a fiftieth of its way to where it rests in each.
        run.steps(600);
        let contacts: Vec<_> = run.world.contacts().collect();
        let [contact] = contacts[..] else { panic!("one contact: {contacts:?}") };
        let force = pull * (before + after) / (before + ridge.y);
        let expected = -up * force;
        // Bent by no more than this angle, rad, which moves places by so much at the flattest.
        let bent = force * 0.01_f64.powi(2) / (2.0 * 1e12 * PI / 4.0 * THIN.powi(3) * WIDE);
        let moved = bent * WIDE * WIDE / THIN;
        println!("{lower} {upper}: {:?} for {expected:?} N at {:?}", contact.force, contact.at);
        let open = (bent + moved / before) * force;
        assert!((contact.force - expected).norm() < open, "{:?}", contact.force);
        let places = contact.at.map(|at| at * 2e-3);
        for (place, own) in places.into_iter().zip([root.x + below.x, before + ridge.y]) {
            assert!((place - own).abs() < moved, "{place} of {own}");
        }
        assert!((contact.lever - ridge).norm() < moved, "{} of {ridge}", contact.lever);
        let axes = [0, 1].map(|fiber| axis(&run.positions(fiber), contact.at[fiber]));
        let gap = (axes[1] - axes[0]).z - ridge.z + below.z;
        let depth = 1e-4 * 2.0 * (THIN * WIDE).sqrt();
        assert!(gap.abs() < depth + bent * moved + bent * WIDE, "{gap}");
    }
}

/// A strip leans at 45 degrees on one that lies flat beside it, both along x. A plane between them
/// touches both at two points that face each other; there they push each other, across it.
#[test]
fn a_strip_leans_on_one_beside_it() {
    let pull = 1e-5;
    for angle in [0.3_f64, -0.5, 1.0] {
        let normal = Vector3::new(0.0, angle.sin(), angle.cos());
        let lean = FRAC_PI_4;
        let [under, over] = [touched(0.0, &normal), touched(lean, &-normal)];
        let case = |gap: f64, pull: f64| {
            let force = normal * -pull;
            let more = format!("tip: Loaded(force: (value: (0, {:?}, {:?}))),", force.y, force.z);
            let mut run = Run::read(&format!(
                "(format: 1, duration: 1.0, fibers: [{}, {}],
                contact: (friction: Isotropic(0.0), residual: 1e-9, slip: 1e-9, depth: 1e-4),
                environment: (gravity: (0, 0, 0)), stepper: (dt: 1e-3))",
                strip(Vector3::zeros(), "x", 0.0, ""),
                strip(under - over + gap * normal, "x", lean, &more)
            ));
            run.steps(30);
            run
        };
        let free = case(1e-6, 0.0);
        assert_eq!(free.world.contacts().count(), 0, "a hundredth of {THIN} m is between them");
        let run = case(1e-9, pull);
        let contacts: Vec<_> = run.world.contacts().collect();
        let force: Vector3<f64> = contacts.iter().map(|contact| contact.force).sum();
        println!("{angle}: {} contacts, {force:?} N along {normal:?}", contacts.len());
        assert!(force.norm() > 0.1 * pull);
        assert!((force.normalize() + normal).norm() < 1e-4, "{force:?} N along {normal:?}");
        for contact in contacts.iter().filter(|contact| contact.force.norm() > 1e-3 * pull) {
            assert!((contact.lever - under).norm() < 1e-3 * WIDE, "{} of {under}", contact.lever);
        }
    }
}

/// A fibre with an elliptic section rolls down two strips that are turned about their axes, as down
/// rails: by its perimeter in a turn, on their ridges. All works sum up to what it gains.
#[test]
fn an_ellipse_rolls_down_rails_of_strips() {
    let (a, b, slope, turn) = (1.1e-3, 1e-3, 0.12_f64, 0.5);
    let ridge = touched(turn, &Vector3::z());
    let (sin, cos) = slope.atan().sin_cos();
    let rail = |y: f64| {
        format!(
            "(length: 0.016, segments: 8, section: Ellipse(a: {THIN:?}, b: {WIDE:?}),
                damping_time: 1e-3,
                material: Elastic(density: 1000, youngs_modulus: 1e12, shear_modulus: 4e11),
                root: (position: (-3e-3, {y:?}, 0), orientation: Along(direction: (1, 0, 0),
                    roll: {:?})))",
            f64::to_degrees(turn)
        )
    };
    let mut books = Books::new(Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [{}, {}, (length: 0.03, segments: 6,
            section: Ellipse(a: {a:?}, b: {b:?}), root_joint: Free,
            material: Elastic(density: 1200, youngs_modulus: 4e9, shear_modulus: 1.5e9),
            root: (position: (0, 0, {:?}), orientation: Along(direction: (0, 1, 0))))],
        environment: (gravity: ({:?}, 0, {:?})),
        contact: (friction: Isotropic(1.0)), stepper: (dt: 2.5e-4), output: (ledger: true))",
        rail(0.007),
        rail(0.022),
        ridge.z + b + 1e-9,
        9.81 * sin,
        -9.81 * cos
    )));
    let start = books.run.world.state(2).positions[3].x;
    let (mut turned, mut way) = (0.0, 0.0);
    while turned < TAU {
        books.step();
        let state = books.run.world.state(2);
        let frame = state.frames[3].matrix();
        let height = (a * frame.column(0).z).hypot(b * frame.column(1).z);
        let apart = state.positions[3].z - height - ridge.z;
        // As on a plane: a step leaves 0.02 diameters of depth, and what turns in it opens a gap.
        assert!(apart.abs() < 0.04 * a, "{apart} at {turned}");
        way = state.positions[3].x - start;
        turned += (state.frames[3] * state.angular_velocities[3]).y * books.run.dt;
    }
    // The trapezoidal rule, which converges geometrically.
    let speed = |k: u32| (TAU * f64::from(k) / 256.0).sin_cos();
    let perimeter: f64 = (0..256).map(speed).map(|(s, c)| (a * s).hypot(b * c) * TAU / 256.0).sum();
    let expected = perimeter * turned / TAU;
    println!(
        "{way:.5e} for {expected:.5e} m; {:.1e} a step, {:.1e} in all",
        books.worst,
        books.whole()
    );
    assert!((way / expected - 1.0).abs() < 0.01, "{way} for {expected}");
    assert!(books.worst < 1e-9 && books.whole() < 1e-9, "{:e}", books.worst);
}
