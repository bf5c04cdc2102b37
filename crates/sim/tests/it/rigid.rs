//! Objects that touch each other, against the mechanics of rigid bodies.

use crate::common::{Run, ply};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::{DistanceField, Terrain, shapes};
use rapunzel_contact::RigidBody;
use rapunzel_sim::{BodyRef, CouplingError, Scene, SimError, World};

const G: f64 = 9.81;
/// Of the steps, s.
const DT: f64 = 1e-3;
/// Of the hair that hangs aside, m; depths are in its diameters.
const RADIUS: f64 = 3.5e-5;
/// What steps may leave: depth in diameters of the hair, slip in m/s.
const DEPTH: f64 = 1e-3;
const SLIP: f64 = 1e-7;

fn scene(objects: &str, contact: &str, gravity: Vector3<f64>) -> Scene {
    let [x, y, z] = gravity.into();
    let text = format!(
        "(format: 1, duration: 1.0,
        fibers: [(length: 0.2, segments: 2, section: Circle(radius: {RADIUS:?}),
            root: (position: (5, 5, 5), orientation: Along(direction: (0, 0, -1))))],
        objects: [{objects}],
        contact: ({contact}, residual: 1e-5, slip: {SLIP:?}, depth: {DEPTH:?}),
        environment: (gravity: ({x:?}, {y:?}, {z:?})), stepper: (dt: {DT:?}))"
    );
    Scene::from_ron(&text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

fn level() -> Vector3<f64> {
    Vector3::new(0.0, 0.0, -G)
}

/// Gravity as on a plane that slopes by `alpha`, rad, along x.
fn sloping(alpha: f64) -> Vector3<f64> {
    G * Vector3::new(alpha.sin(), 0.0, -alpha.cos())
}

/// What a constant acceleration adds up to in `n` steps of backward Euler from rest, m.
fn way(acceleration: f64, n: usize) -> f64 {
    acceleration * DT * DT * (n * (n + 1)) as f64 / 2.0
}

fn body(run: &Run, object: usize) -> RigidBody {
    run.world.body(object).expect("a free object").clone()
}

/// Momentum, and angular momentum about the origin, of objects 0 and 1.
fn momenta(run: &Run) -> [Vector3<f64>; 2] {
    let bodies = [0, 1].map(|i| body(run, i));
    let linear = bodies.iter().map(|body| body.mass() * body.velocity).sum();
    let angular = bodies.iter().map(|body| body.angular_momentum_about(&Point3::origin())).sum();
    [linear, angular]
}

/// Two smooth balls, the second `aside` of the way of the first: Newton's law along the normal, all
/// momenta kept, and no spin.
fn collide(aside: f64, restitution: f64) {
    let objects = format!(
        "(shape: Ball(radius: 0.01), position: (-0.0305, 0, 0), moves: Free(mass: Mass(0.003), \
         velocity: (1, 0, 0))), (shape: Ball(radius: 0.015), position: (0, {aside:?}, 0), moves: \
         Free(mass: Mass(0.002), velocity: (-0.5, 0.1, 0)))"
    );
    let contact = format!("friction: Isotropic(0.0), restitution: {restitution:?}");
    let mut run = Run::new(&scene(&objects, &contact, Vector3::zeros()));
    let (before, [linear, angular]) = ([0, 1].map(|i| body(&run, i)), momenta(&run));
    let energy = run.world.energy().kinetic;
    run.steps(20);
    let (after, [then, turning]) = ([0, 1].map(|i| body(&run, i)), momenta(&run));
    assert!((then - linear).norm() < 1e-12 * linear.norm(), "{then} {linear}");
    let impulse = 0.003 * (after[0].velocity - before[0].velocity);
    let normal = impulse.normalize();
    let approach = (before[0].velocity - before[1].velocity).dot(&normal);
    let parting = after[0].velocity - after[1].velocity;
    // A step resolves the normal velocity to half the depth over its length.
    let resolved = 0.5 * DEPTH * 2.0 * RADIUS / DT;
    assert!(approach < -0.5, "they collide: {approach}");
    let error = parting.dot(&normal) + restitution * approach;
    assert!(error.abs() < resolved, "{error}");
    let reduced = 1.0 / (1.0 / 0.003 + 1.0 / 0.002);
    let lost = 0.5 * reduced * (1.0 - restitution * restitution) * approach * approach;
    let error = energy - run.world.energy().kinetic - lost;
    assert!(error.abs() < reduced * approach.abs() * resolved, "{error} of {lost}");
    // The impulse acts where they are at the end of the step, as far from where they were as they
    // have moved in it.
    let moment = DT * parting.cross(&impulse).norm();
    assert!((turning - angular).norm() < 1.01 * moment + 1e-15, "{turning} {angular} {moment}");
    for body in after {
        assert!(body.angular_momentum.norm() < 1e-12 * 0.01 * impulse.norm(), "{body:?}");
    }
}

#[test]
fn two_free_balls_collide() {
    for aside in [0.0, 0.012] {
        for restitution in [0.3, 0.6, 1.0] {
            collide(aside, restitution);
        }
    }
}

/// A ball that flies at the ground and spins, and bounces with all of its normal velocity. What it
/// bears brakes its slip by the coefficient times that until it rolls, and changes its spin at the
/// lever of its radius. No energy comes back, whichever way it spins.
#[test]
fn an_oblique_bounce_turns_a_ball() {
    let (radius, mass, speed) = (0.01_f64, 0.01, 0.03_f64);
    // Velocity of the lowest point by the spin, in parts of that of the ball.
    for (mu, rolling) in [(0.1, 0.0), (0.5, 0.0), (0.1, 0.7), (0.1, -0.7), (0.1, 2.0), (0.5, 3.0)] {
        let spin = speed * rolling / radius;
        let objects = format!(
            "(shape: Plane(normal: (0, 0, 1))), (shape: Ball(radius: {radius:?}), position: (0, 0, {:?}), \
             moves: Free(mass: Mass({mass:?}), velocity: ({speed:?}, 0, -{speed:?}), spin: (0, {:?}, 0)))",
            radius + 1e-7,
            spin.to_degrees()
        );
        let contact = format!("friction: Isotropic({mu:?}), restitution: 1.0");
        let mut run = Run::new(&scene(&objects, &contact, Vector3::zeros()));
        let before = run.world.energy().kinetic;
        run.steps(3);
        let (ball, after) = (body(&run, 1), run.world.energy().kinetic);
        let slip = speed * (1.0 - rolling);
        // At its surface a ball weighs two sevenths of what it is.
        let braked = slip.signum() * f64::min(2.0 * mu * speed, 2.0 / 7.0 * slip.abs());
        let velocity = Vector3::new(speed - braked, 0.0, speed);
        let turning = Vector3::new(0.0, spin + 2.5 * braked / radius, 0.0);
        // The lever, by which slip and spin go, is that of the end of the step, shorter by half of
        // the way in it. A step resolves the normal velocity to half the depth over its length.
        let lever = 0.5 * speed * DT / radius;
        let error = lever * (speed + slip.abs()) + 0.5 * DEPTH * 2.0 * RADIUS / DT;
        assert!((ball.velocity - velocity).norm() < error, "{mu} {rolling}: {ball:?}");
        let found = ball.angular_velocity();
        assert!((found - turning).norm() * radius < 2.5 * error, "{mu} {rolling}: {ball:?}");
        let lost = mass * braked * (slip - 1.75 * braked);
        let error = mass * error * (velocity.norm() + radius * turning.norm());
        assert!((before - after - lost).abs() < error && after < before, "{mu} {rolling}: {lost}");
    }
}

/// Of a pair the second says how it bounces, else the first, else the scene.
#[test]
fn the_second_of_two_is_asked_first() {
    for (own, others, expected) in [
        ("", "", 0.75),
        (", restitution: 0.5", "", 0.5),
        (", restitution: 0.5", ", restitution: 0.25", 0.25),
    ] {
        let objects = format!(
            "(shape: Plane(normal: (0, 0, 1)){others}), (shape: Ball(radius: 0.01), position: (0, 0, \
             0.0105), moves: Free(mass: Mass(0.01), velocity: (0, 0, -1)){own})"
        );
        let contact = "friction: Isotropic(0.0), restitution: 0.75";
        let mut run = Run::new(&scene(&objects, contact, Vector3::zeros()));
        run.steps(3);
        let resolved = 0.5 * DEPTH * 2.0 * RADIUS / DT;
        assert!((body(&run, 1).velocity.z - expected).abs() < resolved, "{own} {others}");
    }
}

/// An edge falls across an edge, aside of the center of mass: the impulse is along the vertical,
/// which is across both, and spins the box.
#[test]
fn an_edge_bounces_off_an_edge() {
    let (side, aside, restitution) = (0.02, 0.003, 0.5);
    let high = side / 2.0_f64.sqrt();
    let objects = format!(
        "(shape: Cuboid(sides: ({side:?}, {side:?}, {side:?})), position: (0, {aside:?}, {:?}), turn: \
         (0, 45, 0), moves: Free(mass: Mass(0.01), velocity: (0, 0, -1))), (shape: Cuboid(sides: \
         ({side:?}, {side:?}, {side:?})), turn: (45, 0, 0))",
        2.0 * high + 4e-4
    );
    let contact = format!("friction: Isotropic(0.0), restitution: {restitution:?}");
    let mut run = Run::new(&scene(&objects, &contact, Vector3::zeros()));
    let inertia = 0.01 * side * side / 6.0;
    run.steps(2);
    let after = body(&run, 0);
    let impulse = (1.0 + restitution) / (1.0 / 0.01 + aside * aside / inertia);
    // By the edge's radius, a diameter of the hair, the tolerance of the place turns the normal.
    let error = 2e-3;
    let velocity = Vector3::new(0.0, 0.0, impulse / 0.01 - 1.0);
    assert!((after.velocity - velocity).norm() < error, "{after:?} {velocity}");
    // The other's place is in the direction of -y from the center of mass.
    let spin = Vector3::new(-aside * impulse / inertia, 0.0, 0.0);
    let found = after.angular_velocity();
    assert!((found - spin).norm() < error * spin.norm(), "{found} {spin}");
}

const BALL: &str = "(shape: Ball(radius: 0.01), position: (0, 0, 0.01), moves: Free(mass: \
                    Mass(0.01))), (shape: Plane(normal: (0, 0, 1)))";

/// On a slope a ball rolls where friction exceeds two sevenths of the slope, else it also slides.
#[test]
fn a_ball_rolls_or_slides_down_a_slope() {
    let (alpha, steps) = (20.0_f64.to_radians(), 200);
    let (sin, cos) = alpha.sin_cos();
    for (mu, rolls) in [(0.12, true), (0.08, false)] {
        let friction = format!("friction: Isotropic({mu:?})");
        let mut run = Run::new(&scene(BALL, &friction, sloping(alpha)));
        run.steps(steps);
        let ball = body(&run, 0);
        let (along, turning) = if rolls {
            (5.0 / 7.0 * G * sin, 5.0 / 7.0 * G * sin / 0.01)
        } else {
            (G * (sin - mu * cos), 2.5 * mu * G * cos / 0.01)
        };
        // The gap, of which half is the lever's, is within the depth.
        let error = DEPTH * RADIUS / 0.01 + SLIP / (along * DT);
        assert!((ball.center().x / way(along, steps) - 1.0).abs() < error, "{mu}: {ball:?}");
        let spin = ball.angular_velocity().y / (turning * DT * steps as f64);
        assert!((spin - 1.0).abs() < error, "{mu}: {spin}");
        assert!((ball.center().z - 0.01).abs() < DEPTH * 2.0 * RADIUS, "{mu}: {ball:?}");
    }
}

const BOX: &str = "(shape: Cuboid(sides: (0.02, 0.02, 0.01)), position: (0, 0, 0.005), moves: \
                   Free(mass: Mass(0.01))), (shape: Plane(normal: (0, 0, 1)))";

#[test]
fn a_box_on_a_slope_stays_for_ever_or_slides() {
    let alpha = 0.4_f64.atan();
    let mut run = Run::new(&scene(BOX, "friction: Isotropic(0.5)", sloping(alpha)));
    run.steps(1000);
    let creep = (body(&run, 0).center() - Point3::new(0.0, 0.0, 0.005)).norm();
    assert!(creep < SLIP * 1000.0 * DT + DEPTH * 2.0 * RADIUS, "{creep}");
    let force = run.world.force_on(1);
    assert!((force - 0.01 * sloping(alpha)).norm() < 1e-3 * 0.01 * G, "{force}");
    assert!((force + run.world.force_on(0)).norm() < 1e-15, "{force}");

    let mut run = Run::new(&scene(BOX, "friction: Isotropic(0.2)", sloping(alpha)));
    run.steps(100);
    let expected = way(G * (alpha.sin() - 0.2 * alpha.cos()), 100);
    let found = body(&run, 0).center().x;
    assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
}

/// A box that is higher than its friction and slope allow tips over its lower edge.
#[test]
fn a_high_box_tips_over() {
    for (slope, tips) in [(0.48_f64, false), (0.52, true)] {
        let high = BOX.replace("0.02, 0.01)", "0.02, 0.04)").replace("0.005", "0.02");
        let mut run = Run::new(&scene(&high, "friction: Isotropic(0.9)", sloping(slope.atan())));
        run.steps(300);
        let leans = body(&run, 0).pose.rotation.angle() > 0.05;
        assert_eq!(leans, tips, "{slope}: {:?}", body(&run, 0));
    }
}

/// Three equal boxes, edge on edge: what bears most bears the weight of all.
#[test]
fn a_stack_of_boxes_rests() {
    let one = |i: usize| {
        let z = 0.005 + 0.01 * i as f64;
        format!(
            "(shape: Cuboid(sides: (0.02, 0.02, 0.01)), position: (0, 0, {z:?}), moves: Free(mass: \
             Mass(0.01)))"
        )
    };
    let objects = format!("{}, {}, {}, (shape: Plane(normal: (0, 0, 1)))", one(0), one(1), one(2));
    let mut run = Run::new(&scene(&objects, "friction: Isotropic(0.4)", level()));
    run.steps(300);
    for i in 0..3 {
        let found = body(&run, i);
        let start = Point3::new(0.0, 0.0, 0.005 + 0.01 * i as f64);
        // Each may be a depth in the one below.
        let depth = (i + 1) as f64 * DEPTH * 2.0 * RADIUS;
        assert!((found.center() - start).norm() < depth + SLIP * 300.0 * DT, "{i}: {found:?}");
        let on_it = run.world.force_on(i) + Vector3::new(0.0, 0.0, -0.01 * G);
        assert!(on_it.norm() < 1e-3 * 0.01 * G, "{i}: {on_it}");
    }
    let floor = run.world.force_on(3);
    assert!((floor - 0.03 * level()).norm() < 1e-3 * 0.03 * G, "{floor}");
}

/// Dominoes that knock each other over go on from a snapshot as if they had not stopped.
#[test]
fn dominoes_go_on_from_a_snapshot() {
    let one = |i: usize| {
        let spin = if i == 0 { 700 } else { 0 };
        format!(
            "(shape: Cuboid(sides: (0.004, 0.02, 0.04)), position: ({:?}, 0, 0.02), moves: \
             Free(mass: Mass(0.003), spin: (0, {spin}, 0)))",
            0.015 * i as f64
        )
    };
    let objects = format!("{}, {}, {}, (shape: Plane(normal: (0, 0, 1)))", one(0), one(1), one(2));
    let scene = scene(&objects, "friction: Isotropic(0.4)", level());
    let mut run = Run::new(&scene);
    run.steps(80);
    let mut other = Run::new(&scene);
    other.world.restore(&run.world.snapshot()).expect("its own");
    for run in [&mut run, &mut other] {
        run.steps(200);
    }
    assert_eq!(run.world.snapshot(), other.world.snapshot());
    let leans = |i: usize| (body(&run, i).pose.rotation * Vector3::z()).x;
    assert!((0..3).all(|i| leans(i) > 0.5), "{:?}", [0, 1, 2].map(leans));
}

/// A bar that falls with one end down comes to rest on its side.
#[test]
fn a_bar_comes_to_lie_flat() {
    let objects = "(shape: Capsule(length: 0.03, radius: 0.004), position: (0, 0, 0.015), turn: (0, \
                   60, 0), moves: Free(mass: Mass(0.01))), (shape: Plane(normal: (0, 0, 1)))";
    let mut run = Run::new(&scene(objects, "friction: Isotropic(0.4)", level()));
    run.steps(400);
    let bar = body(&run, 0);
    let axis = bar.pose.rotation * Vector3::z();
    let depth = DEPTH * 2.0 * RADIUS;
    assert!((bar.center().z - 0.004).abs() < depth, "{bar:?}");
    assert!(axis.z.abs() * 0.03 < 2.0 * depth, "{axis}");
}

/// A ball and a cube from a file rest on the face of a box from a file.
#[test]
fn things_rest_on_a_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let slab = shapes::cuboid(Vector3::new(0.03, 0.02, 0.005));
    std::fs::write(folder.path().join("slab.ply"), ply(&slab)).expect("writable");
    let cube = shapes::cuboid(Vector3::repeat(0.005));
    std::fs::write(folder.path().join("cube.ply"), ply(&cube)).expect("writable");
    let objects = "(shape: Ball(radius: 0.008), position: (-0.012, 0, 0.0090), moves: Free(mass: \
                   Mass(0.01))), (shape: Mesh(file: \"cube.ply\", spacing: 0.0005), position: \
                   (0.012, 0, 0.006), turn: (0, 0, 20), moves: Free(mass: Mass(0.01))), (shape: \
                   Mesh(file: \"slab.ply\", spacing: 0.0005), position: (0, 0, -0.005))";
    let scene = scene(objects, "friction: Isotropic(0.3)", level()).seen_from(folder.path());
    let mut run = Run::new(&scene);
    run.steps(200);
    // The grid has its distances in single precision.
    let error = DEPTH * 2.0 * RADIUS + 1e-2 * f64::from(f32::EPSILON);
    for (i, height) in [(0, 0.008), (1, 0.005)] {
        let found = body(&run, i);
        assert!((found.center().z - height).abs() < error, "{found:?}");
        assert!(found.velocity.norm() < error / DT, "{found:?}");
    }
}

/// A ball that falls on hills never goes into them.
#[test]
fn a_ball_rolls_over_hills() {
    let hills = "sides: (0.12, 0.12), spacing: 0.002, amplitude: 0.01, wavelength: 0.04, seed: 5";
    let objects = format!(
        "(shape: Ball(radius: 0.005), position: (0.01, 0.01, 0.02), moves: Free(mass: Mass(0.01))), \
         (shape: HeightField({hills}))"
    );
    let mut run = Run::new(&scene(&objects, "friction: Isotropic(0.3)", level()));
    let ground =
        Terrain { sides: [0.12, 0.12], spacing: 0.002, amplitude: 0.01, wavelength: 0.04, seed: 5 };
    let field = ground.field(0.006).expect("a terrain");
    let mut touched = 0;
    for _ in 0..300 {
        touched += run.step().contact.active;
        let gap = field.value(&body(&run, 0).center()) - 0.005;
        assert!(gap > -DEPTH * 2.0 * RADIUS, "{gap}");
    }
    assert!(touched > 100, "{touched}");
}

/// What is refused: starts in each other, steps that lead through each other, and friction by the
/// axis of a fibre where there is none.
#[test]
fn what_cannot_be_told_is_refused() {
    let two = |apart: f64, speed: f64| {
        format!(
            "(shape: Cuboid(sides: (0.02, 0.02, 0.02)), position: (0, 0, {apart:?}), moves: \
             Free(mass: Mass(0.01), velocity: (0, 0, {:?}))), (shape: Ball(radius: 0.01))",
            -speed
        )
    };
    let built = |objects: &str| {
        let scene = scene(objects, "friction: Isotropic(0.3)", Vector3::zeros());
        World::build(&scene)
    };
    let error = built(&two(0.019, 0.0)).err().expect("an overlap");
    let SimError::Coupling(CouplingError::Overlap { sides, segment: None, depth }) = error else {
        panic!("{error}")
    };
    assert_eq!(sides, [0, 1].map(BodyRef::Object));
    assert!((depth - 0.001).abs() < 1e-9, "{depth}");
    assert!(error.to_string().starts_with("objects[0] starts 1.00e-3 m deep in objects[1]; move"));

    let mut world = built(&two(0.03, 11.0)).expect("apart");
    let error = world.step(DT).expect_err("11 mm toward what is 20 mm thick");
    let SimError::Coupling(CouplingError::Leap { object: 0, way, most, .. }) = error else {
        panic!("{error}")
    };
    assert!((way - 0.011).abs() < 1e-12 && (most - 0.01).abs() < 1e-12, "{way} {most}");
    let mut world = built(&two(0.06, 11.0)).expect("far apart");
    assert!(world.step(DT).is_ok());

    let cuticle = "friction: Cuticle(with: 0.1, against: 0.3, across: 0.2)";
    let text = scene(&two(0.03, 0.0), "friction: Isotropic(0.3)", level()).to_ron().expect("RON");
    let text = text.replace("Isotropic(0.3)", cuticle.trim_start_matches("friction: "));
    let error = Scene::from_ron(&text).expect_err("no axis");
    let problems = &error.problems;
    assert_eq!(problems[0].path, "objects[0]", "{error}");
    assert!(problems[0].message.contains("objects[1]"), "{error}");
}
