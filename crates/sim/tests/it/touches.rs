use crate::common::Run;
use nalgebra::{Point3, Vector3};
use rapunzel_sim::ContactForce;

const G: f64 = 9.81;

/// What a body of springs gains in momentum in a step is what the ground gives, less its weight.
#[test]
fn the_ground_gives_a_body_of_springs_its_momentum() {
    let (mass, dt) = (0.01, 4e-3);
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, stepper: (dt: {dt:?}),
        mass_spring: (
            model: Ball(radius: 0.3, fineness: 1), position: (0.0, 0.0, 0.33),
            mass: {mass:?}, frequency: 15.0, damping_ratio: 0.05, substeps: 8,
            contacts: (radius: 0.01, friction: 0.5, restitution: 0.2, ground: 0.0),
        ))"
    ));
    let nodes = run.world.nodes();
    let momentum = |run: &Run| -> Vector3<f64> {
        (0..nodes).map(|node| mass * run.world.node(0, Some(node)).1).sum()
    };
    let weight = Vector3::new(0.0, 0.0, -G * mass * nodes as f64);
    let (mut touched, mut before) = (0, momentum(&run));
    for _ in 0..60 {
        run.step();
        let touches: Vec<ContactForce> = run.world.touches().collect();
        let after = momentum(&run);
        let given: Vector3<f64> = touches.iter().map(|touch| touch.force).sum();
        let off = (after - before) - dt * (given + weight);
        // Rounding: the springs pull at nodes with a thousand times the weight of one.
        assert!(off.norm() < 1e-12 * nodes as f64 * mass * 1e3, "{off:?}");
        for touch in &touches {
            assert!(touch.place.z.abs() < 1e-12 && touch.force.z > 0.0, "{touch:?}");
        }
        touched += touches.len();
        before = after;
    }
    assert!(touched > 10, "{touched}");
}

/// A ball at rest presses on the ground with its weight, where it touches it.
#[test]
fn a_ball_rests_on_the_ground_where_it_touches_it() {
    let (mass, radius) = (1e-3, 0.01);
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, stepper: (dt: 1e-3),
        fibers: [(length: 0.2, segments: 2, section: Circle(radius: 3.5e-5),
            root: (position: (5, 5, 5), orientation: Along(direction: (0, 0, -1))))],
        objects: [(shape: Plane(normal: (0.0, 0.0, 1.0))),
            (shape: Ball(radius: {radius:?}), position: (0.2, 0.1, {radius:?}),
                moves: Free(mass: Mass({mass:?})))],
        contact: (friction: Isotropic(0.3), residual: 1e-9))"
    ));
    for _ in 0..40 {
        run.step();
    }
    let touches: Vec<ContactForce> = run.world.touches().collect();
    let [touch] = touches.as_slice() else { panic!("{touches:?}") };
    let force = touch.force - Vector3::new(0.0, 0.0, mass * G);
    assert!(force.norm() < 1e-6 * mass * G, "{touch:?}");
    // It lies as deep as the solver leaves it, in thousandths of the diameter of a hair.
    let place = touch.place.coords - Vector3::new(0.2, 0.1, 0.0);
    assert!(place.norm() < 7e-5, "{touch:?}");
}

/// Distance of a place from a segment, m.
fn apart(place: &Point3<f64>, a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    let along = b - a;
    let at = ((place - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (place - (a + at * along)).norm()
}

/// A hand tears a hair at a ball with nine hundred times the weight of the hair.
#[test]
fn a_torn_hair_takes_shorter_steps_and_does_not_cross_a_ball() {
    let radius = 0.004;
    let mut run = Run::read(&format!(
        "(format: 1, duration: 0.1, stepper: (dt: 1e-3),
        fibers: [(length: 0.1, segments: 20, section: Circle(radius: 4e-5), damping_time: 1e-3,
            arrangement: EllipseAtDensity(semi_axes: (0.005, 0.005), density: 4e4))],
        objects: [(shape: Ball(radius: {radius:?}), position: (0.012, 0.0, -0.07))],
        contact: (friction: Isotropic(0.3)), environment: (viscosity: 1.8e-5),
        grips: [(fiber: 0, node: 18, stiffness: 1.85e-2, damping: 1e-5, most: 6e-3,
            path: [(time: 0.0, position: (0.09, 0.0, -0.07))])])"
    ));
    let ball = Point3::new(0.012, 0.0, -0.07);
    let (mut halvings, mut touches) = (0, 0);
    let (mut nearest, mut fastest) = (f64::INFINITY, 0.0_f64);
    for _ in 0..100 {
        halvings += run.step().halvings;
        touches += run.world.touches().count();
        for fiber in 0..run.fibers() {
            let state = run.world.state(fiber);
            let pairs = state.positions.windows(2);
            nearest = pairs.map(|pair| apart(&ball, &pair[0], &pair[1])).fold(nearest, f64::min);
            fastest = state.velocities.iter().map(|v| v.norm()).fold(fastest, f64::max);
        }
    }
    // It is torn by more than the size of the ball in a step, touches it, and stays out of it.
    assert!(nearest > radius && touches > 0, "{nearest} m, {touches} touches");
    assert!(fastest * 1e-3 > 2.0 * radius && halvings > 0, "{fastest} m/s, {halvings} halvings");
}
