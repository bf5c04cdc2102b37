//! Fibres that touch, through the scene: what must hold of any step.

use crate::common::Run;
use nalgebra::{Point3, Vector3};
use rapunzel_sim::{Scene, World};

/// Diameter of the hairs of this file, m.
const DIAMETER: f64 = 7e-5;

fn hair(segments: usize, rest: &str) -> String {
    format!("(length: 0.06, segments: {segments}, section: Circle(radius: 3.5e-5), {rest})")
}

fn scene(fibers: &[String], objects: &str, mu: f64, gravity: f64, dt: f64) -> String {
    format!(
        "(format: 1, duration: 1.0, fibers: [{}], objects: [{objects}],
        contact: (friction: Isotropic({mu:?})),
        environment: (gravity: (0.0, 0.0, {gravity:?})), stepper: (dt: {dt:?}))",
        fibers.join(", ")
    )
}

/// Least distance of the axes of two polylines.
fn distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    use rapunzel_collision::Capsule;
    let capsules = |x: &[Point3<f64>]| -> Vec<Capsule> {
        x.windows(2).map(|w| Capsule { start: w[0], end: w[1], radius: 0.0 }).collect()
    };
    let (a, b) = (capsules(a), capsules(b));
    a.iter()
        .flat_map(|s| b.iter().map(|t| s.closest(t).offset.norm()))
        .fold(f64::INFINITY, f64::min)
}

/// One hair is shot at another that is clamped; at 10 m/s it moves 143 diameters in a
/// step of 1 ms (test 29 of the contact report). It must stay on its side, whatever the angle.
#[test]
fn no_hair_passes_through_another() {
    for (k, speed) in [0.3_f64, 1.0, 3.0, 10.0].into_iter().cycle().take(12).enumerate() {
        let angle = 0.3 + 0.2 * k as f64;
        let (sin, cos) = angle.sin_cos();
        let target =
            hair(20, "root: (position: (-0.03, 0, 0), orientation: Along(direction: (1, 0, 0)))");
        let shot = hair(
            20,
            &format!(
                "root: (position: ({:?}, {:?}, 0.002), orientation: Along(direction: ({cos:?}, \
                 {sin:?}, 0.0))), root_joint: Free, velocity: (0.0, 0.0, {:?})",
                -0.03 * cos,
                -0.03 * sin,
                -speed
            ),
        );
        let mut run = Run::read(&scene(&[target, shot], "", 0.3, 0.0, 1e-3));
        let mut touched = false;
        // Later the shot may slip off the free end.
        let steps = if speed < 1.0 {
            16
        } else if speed < 3.0 {
            5
        } else {
            2
        };
        for _ in 0..steps {
            touched |= run.step().contact.active > 0;
            let (a, b) = (run.positions(0), run.positions(1));
            let near = distance(&a, &b);
            assert!(near >= 0.98 * DIAMETER, "{speed} m/s at {angle}: {near}");
        }
        assert!(touched, "{speed} m/s at {angle}");
        // The middle of the shot is above the middle of the target, or wrapped around it, but it
        // has not come out below.
        let (a, b) = (run.positions(0), run.positions(1));
        assert!(b[10].z > a[10].z, "{speed} m/s at {angle}: passed");
    }
}

/// Contacts give to one fibre what they take from the other.
#[test]
fn free_hairs_that_collide_keep_their_momentum() {
    let first = hair(
        20,
        "shape: Helix(radius: 0.004, pitch: 0.1), root_joint: Free, velocity: (0.0, 0.0, 0.3), \
         root: (position: (-0.03, 0.0, 0.0), orientation: Along(direction: (1, 0, 0)))",
    );
    let second = hair(
        20,
        "root_joint: Free, velocity: (0.1, 0.05, -0.2), \
         root: (position: (0.0, -0.03, 0.01), orientation: Along(direction: (0.2, 1.0, 0.1)))",
    );
    let mut run = Run::read(&scene(&[first, second], "", 0.4, 0.0, 1e-3));
    let before = run.momentum();
    let (mut active, mut size) = (0, 0.0_f64);
    for _ in 0..60 {
        let step = run.step();
        active += step.contact.active;
        let now = run.momentum();
        size = size.max(now.norm()).max(before.norm());
        assert!((now - before).norm() < 1e-11 * size.max(1e-8), "{now} {before}");
    }
    assert!(active > 20, "they collide: {active}");
}

/// Hairs that lie down a rough slope stay where they are, to the last bit of what the solver is
/// asked for; on a smooth one they slide as g sin(alpha) wants.
#[test]
fn hairs_stick_on_a_rough_slope_and_slide_on_a_smooth_one() {
    let alpha = 20.0_f64.to_radians();
    let plane = format!("(shape: Plane(normal: ({:?}, 0.0, {:?})))", alpha.sin(), alpha.cos());
    let (up, down) =
        (Vector3::new(alpha.sin(), 0.0, alpha.cos()), Vector3::new(alpha.cos(), 0.0, -alpha.sin()));
    let at = up * (0.5 * DIAMETER + 1e-7);
    let lying = hair(
        20,
        &format!(
            "root: (position: ({:?}, {:?}, {:?}), \
             orientation: Along(direction: ({:?}, 0, {:?}))), root_joint: Free",
            at.x, at.y, at.z, down.x, down.z
        ),
    );
    for mu in [0.5, 0.0, 0.2] {
        let mut run = Run::read(&scene(std::slice::from_ref(&lying), &plane, mu, -9.81, 1e-3));
        let start = run.positions(0)[10];
        for _ in 0..100 {
            run.step();
        }
        let way = (run.positions(0)[10] - start).dot(&down);
        let acceleration = 9.81 * (alpha.sin() - mu * alpha.cos()).max(0.0);
        // Backward Euler: after n steps the way is a dt^2 n (n + 1) / 2.
        let expected = 0.5 * acceleration * 1e-6 * 100.0 * 101.0;
        assert!((way - expected).abs() < 4e-5 * 0.1, "mu {mu}: {way} for {expected}");
    }
}

/// A small tress falls onto a ball with half a metre per second and buckles: every step within its
/// tolerances, nothing crosses, and the energy only falls; whether all contacts are solved at once
/// or one after the other, few contacts from the start, which takes fewer iterations.
#[test]
fn a_tress_lands_on_a_ball() {
    let tress = "(length: 0.06, segments: 24, section: Circle(radius: 3.5e-5), \
        shape: Helix(radius: 0.003, pitch: 0.015), velocity: (0, 0, -0.4), root_joint: Free, \
        arrangement: EllipseAtDensity(semi_axes: (0.0015, 0.0015), density: 1.5e6))";
    let ball = "(shape: Ball(radius: 0.02), position: (0, 0, -0.0605))";
    let iterations = ["Splitting", "Polished"].map(|solver| {
        let contact = format!("contact: (solver: {solver}, ");
        let text = scene(&[tress.into()], ball, 0.4, -9.81, 1e-3).replace("contact: (", &contact);
        land(&mut Run::read(&text))
    });
    assert!(iterations[0] < iterations[1], "{iterations:?}");
}

/// Returns the iterations that the contacts take.
fn land(run: &mut Run) -> usize {
    assert_eq!(run.fibers(), 11);
    let mut energy = run.world.energy().total();
    let (mut active, mut iterations) = (0, 0);
    for _ in 0..60 {
        let report = run.step().contact;
        active = active.max(report.active);
        iterations += report.iterations;
        assert!(report.depth <= 0.02 * DIAMETER && report.residual <= 1e-3, "{report:?}");
        let now = run.world.energy().total();
        // Gaps that are repaired may lift by what was allowed to be left.
        assert!(now <= energy + 1e-12, "{now} after {energy}");
        energy = now;
    }
    assert!(active > 11, "{active}");
    for i in 0..run.fibers() {
        let a = run.positions(i);
        for b in (0..i).map(|j| run.positions(j)) {
            assert!(distance(&a, &b) >= 0.98 * DIAMETER);
        }
        let center = Point3::new(0.0, 0.0, -0.0605);
        assert!(a.iter().all(|x| (x - center).norm() > 0.02 + 0.48 * DIAMETER));
    }
    iterations
}

/// What starts in something is refused, with what and where.
#[test]
fn overlaps_at_the_start_are_refused() {
    let crossing = hair(
        20,
        "root: (position: (0.0101, -0.03, 0.00003), orientation: Along(direction: (0, 1, 0)))",
    );
    let lying = hair(20, "root: (orientation: Along(direction: (1, 0, 0)))");
    let refused = |fibers: &[String], objects: &str| {
        let scene = Scene::from_ron(&scene(fibers, objects, 0.3, 0.0, 1e-3)).expect("sound");
        World::build(&scene).err().expect("an overlap").to_string()
    };
    let message = refused(&[lying.clone(), crossing], "");
    assert!(
        message.starts_with("fibre 0 starts 4.00e-5 m deep in fibre 1, at its segment 3"),
        "{message}"
    );
    let message = refused(&[lying], "(shape: Ball(radius: 0.01), position: (0.03, 0, 0.0))");
    assert!(message.contains("deep in objects[0]"), "{message}");
}

/// Held roots are not to be parted, however little they overlap; what is free is.
#[test]
fn roots_that_are_held_in_each_other_are_refused() {
    let hairs = |root: &str| {
        let beside = |y: f64| {
            format!("{root}(position: (0, {y}, 0), orientation: Along(direction: (1, 0, 0)))")
        };
        [0.0, 0.93 * DIAMETER].map(|y| hair(20, &beside(y)))
    };
    let built = |root: &str| {
        let scene = Scene::from_ron(&scene(&hairs(root), "", 0.3, 0.0, 1e-3)).expect("sound");
        World::build(&scene).map(|mut world| world.step(1e-3).expect("a step"))
    };
    let message = built("root: ").expect_err("held in each other").to_string();
    assert!(
        message.starts_with("fibre 0 starts 4.90e-6 m deep in fibre 1, at its segment 0"),
        "{message}"
    );
    let report = built("root_joint: Free, root: ").expect("parted").contact;
    assert!(report.active > 0 && report.depth <= 0.02 * DIAMETER, "{report:?}");
}

/// The cuticle: a hair that is pulled down a slope root first stays where one that lies the other
/// way round slides.
#[test]
fn scales_hold_one_way_only() {
    let alpha = 20.0_f64.to_radians();
    let plane = format!("(shape: Plane(normal: ({:?}, 0.0, {:?})))", alpha.sin(), alpha.cos());
    let slid = |direction: f64| {
        let (cos, sin) = (direction * alpha.cos(), -direction * alpha.sin());
        let up = 0.5 * DIAMETER + 1e-7;
        let lying = hair(
            20,
            &format!(
                "root: (position: ({:?}, 0.0, {:?}), orientation: Along(direction: ({cos:?}, 0.0, \
                 {sin:?}))), root_joint: Free",
                up * alpha.sin(),
                up * alpha.cos()
            ),
        );
        let text = scene(&[lying], &plane, 0.0, -9.81, 1e-3)
            .replace("Isotropic(0.0)", "Cuticle(with: 0.2, against: 0.5, across: 0.3)");
        let mut run = Run::read(&text);
        let start = run.positions(0)[10];
        for _ in 0..50 {
            run.step();
        }
        (run.positions(0)[10] - start).norm()
    };
    // Tip first downhill is against the scales.
    assert!(slid(1.0) < 4e-5 * 0.05, "{}", slid(1.0));
    let expected = 0.5 * 9.81 * (alpha.sin() - 0.2 * alpha.cos()) * 1e-6 * 50.0 * 51.0;
    assert!((slid(-1.0) - expected).abs() < 1e-3 * expected, "{} for {expected}", slid(-1.0));
}

/// The force of a plane on a straight hair whose clamped root is led toward it, exactly along the
/// hair, until the ends are nearer by `shortening`, as a part of the length; of Euler's load of a
/// rod that is clamped at one end and hinged at the other. The end must not creep while the hair
/// buckles: a hinge beside the axis bears less.
fn end_thrust(shortening: f64) -> f64 {
    let (length, radius, modulus) = (0.02, 3.5e-5_f64, 4e9);
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0,
        fibers: [(length: {length:?}, segments: 40, section: Circle(radius: {radius:?}),
            material: Elastic(density: 1320.0, youngs_modulus: {modulus:?}, shear_modulus: 1.5e9),
            damping_time: 2e-2, root: (orientation: Along(direction: (0, 0, 1))),
            motion: Translate(velocity: (0, 0, {:?}), until: 0.1))],
        objects: [(shape: Plane(normal: (0, 0, -1)), position: (0, 0, {:?}))],
        contact: (friction: Isotropic(5.0), residual: 1e-6),
        environment: (gravity: (0, 0, 0), viscosity: 1e-3), stepper: (dt: 1e-3))",
        shortening * length / 0.1,
        length + radius
    ));
    run.steps(300);
    let stiffness = modulus * std::f64::consts::PI / 4.0 * radius.powi(4);
    // The first root of tan x = x.
    let euler = 4.493_409_5_f64.powi(2) * stiffness / (length * length);
    run.world.force_on(0).z / euler
}

/// To which side, nothing tells: the fibre is straight to the last digit, and pressed along its
/// axis.
#[test]
fn a_straight_hair_that_is_pressed_end_on_buckles() {
    let [near, far] = [0.01, 0.02].map(end_thrust);
    let found = 2.0 * near - far;
    // 0.2 % are left of the segments: a twelfth of the squared angle that one spans.
    assert!((found - 1.0).abs() < 4e-3, "{near} and {far} of Euler's load");
}

/// Hairs that lie in a box in layers, so far from each other, each upon the gap between two, with
/// what is told of their roots.
fn pack([rows, columns]: [i32; 2], gap: f64, mu: f64, roots: &str) -> Run {
    let spacing = DIAMETER + gap;
    let fibers: Vec<_> = (0..rows * columns)
        .map(|k| {
            let (row, column) = (f64::from(k / columns), f64::from(k % columns));
            let y = spacing * (column + 0.5 * (row % 2.0));
            let z = 0.5 * spacing + spacing * row * 0.75_f64.sqrt();
            let root = format!(
                "root: (position: (0, {y:?}, {z:?}), orientation: Along(direction: (1, 0, 0)))"
            );
            hair(20, &format!("{root}, {roots}"))
        })
        .collect();
    let width = spacing * (f64::from(columns) - 0.5);
    let planes =
        [((0, 0, 1), 0.0), ((0, 1, 0), -0.5 * spacing), ((0, -1, 0), width + 0.5 * spacing)];
    let planes = planes.map(|((x, y, z), at)| {
        format!("(shape: Plane(normal: ({x}, {y}, {z})), position: (0.0, {at:?}, 0.0))")
    });
    Run::read(&scene(&fibers, &planes.join(", "), mu, -9.81, 1e-3))
}

/// What they bore in the step before they bear again, so that a step takes one solve of all
/// contacts.
#[test]
fn what_rests_is_hardly_solved_again() {
    let mut run = pack([5, 6], 1e-6, 0.3, "root_joint: Free");
    run.steps(40);
    let reports: Vec<_> = (0..20).map(|_| run.step().contact).collect();
    assert!(reports.iter().all(|report| report.active > 1000), "{reports:?}");
    let solves: usize = reports.iter().map(|report| report.solves).sum();
    assert!(solves <= 22, "{reports:?}");
}

/// Every hair is held by six others and its root, and far more impulses hold them than there are
/// ways to move: the solver must not look for more digits than are told of it. Without their roots
/// hairs that roll on each other, as wheels that lock, take ten times the iterations.
#[test]
fn what_is_packed_finds_its_rest() {
    let mut run = pack([8, 8], 7e-8, 0.5, "");
    for step in 0..3 {
        let report = run.step().contact;
        assert!(report.active > 2000, "{step}: {report:?}");
        // As many as a single solve may take, which some do where the tolerance is out of reach.
        assert!(report.iterations < 2000, "{step}: {report:?}");
    }
}
