//! Objects of all kinds among fibres: their friction, shapes and motion.

use crate::common::{Run, ply};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::{DistanceField, Terrain, shapes};
use rapunzel_sim::{ActiveContact, BodyRef, CouplingError, Scene, SimError, World};
use std::path::Path;

/// Radius of the hairs of this file, m.
const RADIUS: f64 = 3.5e-5;

fn nodes(run: &Run) -> impl Iterator<Item = Point3<f64>> {
    (0..run.fibers()).flat_map(|fiber| run.positions(fiber))
}

fn hair(rest: &str) -> String {
    format!("(length: 0.06, segments: 20, section: Circle(radius: {RADIUS:?}), {rest})")
}

fn read(fibers: &[String], objects: &str, friction: &str, gravity: f64, dt: f64) -> Scene {
    let text = format!(
        "(format: 1, duration: 1.0, fibers: [{}], objects: [{objects}],
        contact: (friction: {friction}),
        environment: (gravity: (0.0, 0.0, {gravity:?})), stepper: (dt: {dt:?}))",
        fibers.join(", ")
    );
    Scene::from_ron(&text).unwrap_or_else(|e| panic!("{e} in {text}"))
}

/// How far a hair slides in 50 ms on a slope of 20 degrees that has its own friction, tip first
/// downhill or root first.
fn slid(tip_first: bool, scene: &str, object: &str) -> f64 {
    let alpha = 20.0_f64.to_radians();
    let (sin, cos) = alpha.sin_cos();
    let (up, way) = (RADIUS + 1e-7, if tip_first { 1.0 } else { -1.0 });
    let lying = hair(&format!(
        "root: (position: ({:?}, 0.0, {:?}), orientation: Along(direction: ({:?}, 0.0, {:?}))), \
         root_joint: Free",
        up * sin,
        up * cos,
        way * cos,
        -way * sin
    ));
    let plane = format!("(shape: Plane(normal: ({sin:?}, 0.0, {cos:?})), friction: {object})");
    let mut run = Run::new(&read(&[lying], &plane, scene, -9.81, 1e-3));
    let start = run.world.state(0).positions[10];
    run.steps(50);
    (run.world.state(0).positions[10] - start).norm()
}

#[test]
fn an_object_has_its_own_friction() {
    // Backward Euler: after n steps the way is a dt^2 n (n + 1) / 2.
    let free = 0.5 * 9.81 * 20.0_f64.to_radians().sin() * 1e-6 * 50.0 * 51.0;
    let still = 4e-5 * 0.05;
    assert!((slid(true, "Isotropic(0.5)", "Isotropic(0.0)") - free).abs() < still);
    assert!(slid(true, "Isotropic(0.0)", "Isotropic(0.5)") < still);
    assert!((slid(true, "Isotropic(0.0)", "None") - free).abs() < still);
    // Tip first downhill is against the scales.
    let cuticle = "Cuticle(with: 0.2, against: 0.5, across: 0.3)";
    assert!(slid(true, "Isotropic(0.0)", cuticle) < still);
    let with = 0.5 * 9.81 * (20.0_f64.to_radians().sin() - 0.2 * 20.0_f64.to_radians().cos());
    let with = with * 1e-6 * 50.0 * 51.0;
    assert!((slid(false, "Isotropic(0.0)", cuticle) - with).abs() < still);
    // No friction is a number like others, and so is much of it.
    assert!(slid(true, "Isotropic(0.0)", "Isotropic(5.0)") < still);
}

/// Hairs fall into the hollows of a terrain and stay above its ground.
#[test]
fn hairs_land_on_a_terrain() {
    let ground =
        Terrain { sides: [0.12, 0.12], spacing: 0.002, amplitude: 0.01, wavelength: 0.04, seed: 5 };
    let object = "(shape: HeightField(sides: (0.12, 0.12), spacing: 0.002, amplitude: 0.01, \
                  wavelength: 0.04, seed: 5), position: (0, 0, -0.012))";
    let falling = |y: f64| {
        hair(&format!(
            "root: (position: (-0.03, {y:?}, 0.0), orientation: Along(direction: (1, 0, 0))), \
             root_joint: Free"
        ))
    };
    let mut run =
        Run::new(&read(&[-0.02, 0.0, 0.02].map(falling), object, "Isotropic(0.3)", -9.81, 1e-3));
    let mut active = 0;
    for _ in 0..120 {
        active = run.step().contact.active;
    }
    assert!(active >= 3, "they lie on it: {active}");
    let field = ground.field(0.002).expect("a terrain");
    for p in nodes(&run) {
        let gap = field.value(&(p + Vector3::new(0.0, 0.0, 0.012))) - RADIUS;
        assert!(gap > -0.02 * 2.0 * RADIUS, "{gap}");
    }
    let shown = run.world.surfaces().next().expect("an object").surface;
    assert!(shown.vertices.iter().all(|p| (p.z + 0.012).abs() <= 0.01));
}

/// A hair lies on a box from a file as on one that is said; what cannot be read is refused by name.
#[test]
fn a_mesh_is_read_from_beside_the_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let solid = shapes::cuboid(Vector3::new(0.02, 0.02, 0.005));
    std::fs::write(folder.path().join("box.ply"), ply(&solid)).expect("writable");
    let mut open = solid;
    open.triangles.pop();
    std::fs::write(folder.path().join("open.ply"), ply(&open)).expect("writable");
    std::fs::write(folder.path().join("text.ply"), "ply it is not").expect("writable");
    std::fs::write(folder.path().join("box.dae"), "").expect("writable");
    let across = hair(
        "root: (position: (-0.03, 0.001, 0.001), orientation: Along(direction: (1, 0, 0))), \
         root_joint: Free",
    );
    let scene = |shape: &str, folder: &Path| {
        let object = format!("(shape: {shape}, position: (0, 0, -0.005))");
        read(std::slice::from_ref(&across), &object, "Isotropic(0.3)", -9.81, 1e-3)
            .seen_from(folder)
    };
    let file = |name: &str| format!("Mesh(file: \"{name}\", spacing: 0.0005)");
    let ends = [&file("box.ply"), "Cuboid(sides: (0.04, 0.04, 0.01))"].map(|shape| {
        let mut run = Run::new(&scene(shape, folder.path()));
        let active = (0..40).map(|_| run.step().contact.active).max();
        assert!(active >= Some(2), "{shape}");
        nodes(&run).collect::<Vec<_>>()
    });
    // The grid of distances rounds edges by no more than half a diagonal of a cell.
    let error = ends[0].iter().zip(&ends[1]).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(error < 0.5 * 3.0_f64.sqrt() * 5e-4, "{error}");

    let refused = |name: &str| {
        let error = World::build(&scene(&file(name), folder.path())).err().expect("refused");
        let message = error.to_string();
        assert!(message.contains(&folder.path().join(name).display().to_string()), "{message}");
        (error, message)
    };
    let (error, message) = refused("open.ply");
    assert!(matches!(error, SimError::Mesh { object: 0, .. }), "{message}");
    assert!(message.contains("is at a hole"), "{message}");
    assert!(matches!(refused("none.ply").0, SimError::Io { .. }));
    assert!(refused("text.ply").1.contains("cannot be read as PLY"));
    assert!(refused("box.dae").1.contains("only .ply, .stl and .obj"));
}

/// A ball falls into the opening of a net of four bars, each clamped at one end, and rests there.
#[test]
fn a_ball_comes_to_rest_on_a_net() {
    let (bar, apart, radius, mass) = (5e-4_f64, 0.01_f64, 0.015, 0.002);
    let bars: Vec<_> = [(1.0, true), (1.0, false), (-1.0, true), (-1.0, false)]
        .map(|(side, along)| {
            let (start, place) = (-0.03 * side, -apart * side);
            let ([x, y], [dx, dy], z) = if along {
                ([start, place], [side, 0.0], 0.0)
            } else {
                ([place, start], [0.0, side], -0.0011)
            };
            format!(
                "(length: 0.06, segments: 20, section: Circle(radius: {bar:?}), damping_time: \
                 1e-3, root: (position: ({x:?}, {y:?}, {z:?}), orientation: Along(direction: \
                 ({dx:?}, {dy:?}, 0.0))))"
            )
        })
        .to_vec();
    let ball = format!(
        "(shape: Ball(radius: {radius:?}), position: (0.0, 0.0, 0.014), moves: Free(mass: \
         Mass({mass:?})))"
    );
    let mut run = Run::new(&read(&bars, &ball, "Isotropic(0.5)", -9.81, 1e-3));
    let mut energy = run.world.energy().total();
    // What a step may leave of penetration, the next may lift: two percent of a diameter.
    let (weight, lifted) = (mass * 9.81, 0.02 * 2.0 * bar * mass * 9.81);
    for _ in 0..250 {
        run.step();
        let now = run.world.energy().total();
        assert!(now <= energy + lifted, "{now} after {energy}");
        energy = now;
    }
    let body = run.world.body(0).expect("a free ball");
    // On bars that do not bend; these do, by a third of a millimetre.
    let height = ((radius + bar).powi(2) - apart * apart).sqrt();
    let center = body.center();
    assert!((height - 4e-4..height).contains(&center.z), "{center}");
    assert!(center.xy().coords.norm() < 1e-5 && body.velocity.norm() < 1e-3, "{body:?}");
    let on_ball = |one: &ActiveContact| one.sides[1] == BodyRef::Object(0);
    let borne: Vector3<f64> = run.world.contacts().filter(on_ball).map(|one| one.force).sum();
    assert!((borne + Vector3::new(0.0, 0.0, weight)).norm() < 0.02 * weight, "{borne}");
}

/// What hairs get of momentum in free flight, a ball loses, to rounding.
#[test]
fn a_free_ball_and_free_hairs_keep_their_momentum() {
    let flying = |y: f64| {
        hair(&format!(
            "shape: Helix(radius: 0.004, pitch: 0.1), root_joint: Free, velocity: (0.0, 0.0, 0.3), \
             root: (position: (-0.03, {y:?}, 0.0), orientation: Along(direction: (1, 0, 0)))"
        ))
    };
    let ball = "(shape: Ball(radius: 0.01), position: (0.002, 0.001, 0.018), moves: \
                Free(mass: Mass(4e-7), velocity: (0.1, 0.05, -0.2), spin: (0, 3000, 1000)))";
    let mut run = Run::new(&read(&[-0.002, 0.003].map(flying), ball, "Isotropic(0.4)", 0.0, 1e-3));
    let (before, start) = (run.momentum(), run.world.body(0).expect("free").velocity);
    let (mut active, mut error) = (0, 0.0_f64);
    for _ in 0..60 {
        active += run.step().contact.active;
        error = error.max((run.momentum() - before).norm() / before.norm());
    }
    let change = (run.world.body(0).expect("free").velocity - start).norm();
    assert!(active > 20 && change > 0.05, "they collide: {active}, {change}");
    assert!(error < 1e-10, "{error}");
}

/// A body without anything in its way falls as backward Euler does, and a saved one goes on.
#[test]
fn a_bar_tumbles_and_goes_on_from_a_snapshot() {
    let bar = "(shape: Capsule(length: 0.02, radius: 0.005), position: (0.1, 0.0, 0.0), turn: (10, \
               20, 30), moves: Free(mass: Density(500.0), velocity: (0, 0, 1), spin: (500, 0, 90)))";
    let scene = read(&[hair("")], bar, "Isotropic(0.3)", -9.81, 1e-3);
    let mut run = Run::new(&scene);
    let spin = run.world.body(0).expect("free").angular_momentum;
    run.steps(20);
    let body = run.world.body(0).expect("free");
    let height = 20.0e-3 - 0.5 * 9.81 * 1e-6 * 20.0 * 21.0;
    assert!((body.center() - Point3::new(0.1, 0.0, height)).norm() < 1e-14);
    assert_eq!(body.angular_momentum, spin);
    let mut other = Run::new(&scene);
    other.world.restore(&run.world.snapshot()).expect("its own");
    for run in [&mut run, &mut other] {
        run.steps(7);
    }
    assert_eq!(run.world.snapshot(), other.world.snapshot());
    assert_eq!(run.world.body(0), other.world.body(0));
    let without = read(&[hair("")], "", "Isotropic(0.3)", -9.81, 1e-3);
    assert!(other.world.restore(&Run::new(&without).world.snapshot()).is_err());
}

/// What moves too fast is refused with the step that would do, which then does.
#[test]
fn an_object_that_leaps_is_refused() {
    let ball = "(shape: Ball(radius: 0.01), position: (0.03, 0, -0.03), \
                motion: Translate(velocity: (0, 0, 10), until: 0.002))";
    let scene = |dt| read(&[hair("")], ball, "Isotropic(0.3)", 0.0, dt);
    let mut run = Run::new(&scene(1e-3));
    let error = run.world.step(1e-3).expect_err("10 mm over segments of 3 mm");
    let SimError::Coupling(CouplingError::Leap { object: 0, way, most, dt, .. }) = error else {
        panic!("{error}")
    };
    assert!((way - 0.01).abs() < 1e-12 && (most - 0.003).abs() < 1e-12, "{way} {most}");
    assert!((dt - 3e-4).abs() < 1e-12, "{dt}");
    assert!(error.to_string().contains("set stepper.dt to at most 3.00e-4 s"), "{error}");
    let mut run = Run::new(&scene(2.9e-4));
    assert!(run.world.step(2.9e-4).is_ok());
}

/// A clamped root that a ball is driven into cannot give way: told, with what and where.
#[test]
fn a_clamped_root_that_is_pressed_is_told() {
    let ball = "(shape: Ball(radius: 0.01), position: (0.0, 0.0, -0.0101), \
                motion: Translate(velocity: (0, 0, 0.5), until: 1))";
    let standing = hair("root: (orientation: Along(direction: (0, 0, 1)))");
    // Few iterations: more would not help either.
    let friction = "Isotropic(0.3), iterations: 20";
    let mut run = Run::new(&read(&[standing], ball, friction, 0.0, 1e-3));
    let report = run.world.step(1e-3).expect("is taken as far as it comes");
    let found = report.contact.first_unresolved.unwrap_or_else(|| panic!("{report:?}"));
    assert_eq!((found.sides, found.segment), ([BodyRef::Fiber(0), BodyRef::Object(0)], Some(0)));
    assert!(found.depth > 0.0 && found.time < 1e-3, "{found:?}");
    assert!(nodes(&run).all(|p| p.iter().all(|x| x.is_finite())));
}

/// Whether a held root touches a ledge below a wall or grows out of it, however deep it is there,
/// it takes whole steps: no shorter one would part the two.
#[test]
fn a_held_root_at_any_depth_takes_whole_steps() {
    let folder = tempfile::tempdir().expect("a folder");
    let ledge = "v -20 -20 -20\nv 20 -20 -20\nv 20 -20 0\nv 0 -20 0\nv 0 -20 20\nv -20 -20 20\n\
        v -20 20 -20\nv 20 20 -20\nv 20 20 0\nv 0 20 0\nv 0 20 20\nv -20 20 20\n\
        f 1 2 3 4\nf 1 4 5 6\nf 10 9 8 7\nf 12 11 10 7\nf 1 7 8 2\nf 2 8 9 3\nf 3 9 10 4\n\
        f 4 10 11 5\nf 5 11 12 6\nf 6 12 7 1\n";
    std::fs::write(folder.path().join("ledge.obj"), ledge).expect("writable");
    let object = "(shape: Mesh(file: \"ledge.obj\", spacing: 0.0005, scale: 0.001))";
    for depth in [0.0, 0.3, 0.49, 0.51, 0.7, 0.99, 1.01, 1.5, 10.0] {
        let height = 3.5e-5 - depth * 0.02 * 7e-5;
        let standing = hair(&format!(
            "root: (position: (1e-3, 0, {height:e}), orientation: Along(direction: (0, 1, 2)))"
        ));
        let scene = read(&[standing], object, "Isotropic(0.3)", 0.0, 1e-3);
        let report = Run::new(&scene.seen_from(folder.path())).step();
        assert_eq!((report.halvings, report.contact.unresolved), (0, 0), "{depth}: {report:?}");
    }
}

#[test]
fn objects_that_make_no_sense_are_refused() {
    for (object, path, message) in [
        ("shape: Ball(radius: 0.01), friction: Isotropic(-0.1)", "objects[0].friction", "is -0.1"),
        (
            "shape: Ball(radius: 0.01), friction: Cuticle(with: 0.1, against: -1.0, across: 0.2)",
            "objects[0].friction.against",
            "is -1.0",
        ),
        (
            "shape: Plane(normal: (0, 0, 1)), moves: Free(mass: Density(1.0))",
            "objects[0].moves",
            "has no end",
        ),
        (
            "shape: Ball(radius: 0.01), moves: Free(mass: Mass(0.0))",
            "objects[0].moves.mass",
            "is 0.0",
        ),
        (
            "shape: Ball(radius: 0.01), moves: Free(mass: Mass(1.0)), motion: Rotate(axis: (0, 0, \
             1), rate: 9.0, until: 1.0)",
            "objects[0].motion",
            "moves freely",
        ),
        (
            "shape: HeightField(sides: (1, 1), spacing: 0.1, amplitude: 0.1, wavelength: 0.2)",
            "objects[0].shape.spacing",
            "a quarter of the wavelength",
        ),
    ] {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [{}], objects: [({object})],
            contact: (friction: Isotropic(0.3)), stepper: (dt: 0.001))",
            hair("")
        );
        let error = Scene::from_ron(&text).expect_err(object);
        let problems = &error.problems;
        assert_eq!(problems[0].path, path, "{error}");
        assert!(problems[0].message.contains(message), "{error}");
    }
}

/// What lies at rest on two boxes bears on them with its weight, and on nothing else.
#[test]
fn objects_feel_the_weight_of_fibers() {
    let objects = "(shape: Cuboid(sides: (0.02, 0.02, 0.02)), position: (-0.025, 0, -0.01)), \
                   (shape: Cuboid(sides: (0.02, 0.02, 0.02)), position: (0.025, 0, -0.01)), \
                   (shape: Ball(radius: 0.01), position: (0, 0, -0.2))";
    let lying = hair(&format!(
        "root: (position: (-0.03, 0.0, {:?}), orientation: Along(direction: (1, 0, 0))), \
         root_joint: Free, damping_time: 0.01",
        RADIUS + 1e-7
    ));
    let mut run = Run::new(&read(&[lying], objects, "Isotropic(0.3)", -9.81, 5e-3));
    run.steps(200);
    let [left, right, nothing] = [0, 1, 2].map(|object| run.world.force_on(object));
    let weight = 9.81 * run.world.assembly().fibers()[0].mass();
    let sum = left + right;
    assert!((sum.z / weight + 1.0).abs() < 1e-2 && sum.xy().norm() < 1e-2 * weight, "{sum}");
    assert!((left.z / right.z - 1.0).abs() < 0.1, "{left} {right}");
    assert_eq!(nothing, Vector3::zeros());
    // Frames hold the same forces, on the fibre.
    let strands = run.world.stepper().strands();
    let on_fiber: Vector3<f64> = strands.flat_map(|strand| strand.contact_forces).sum();
    assert!((on_fiber + sum).norm() < 1e-12 * weight, "{on_fiber} and {sum}");
}
