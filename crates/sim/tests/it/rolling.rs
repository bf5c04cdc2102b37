//! Free fibres roll where they stick, and slip where they do not.

use crate::common::Run;
use std::f64::consts::TAU;

const G: f64 = 9.81;

/// Tolerances far below what is looked for.
const TIGHT: &str = "residual: 1e-6, slip: 1e-8";

/// A straight free fibre along y on a plane, `laws` between them, in a field of gravity that leans
/// by `slope` (its tangent) along x; `start` is what it starts with.
fn on_slope(section: &str, radius: f64, laws: &str, slope: f64, start: &str, dt: f64) -> Run {
    let (sin, cos) = slope.atan().sin_cos();
    Run::read(&format!(
        "(format: 1, duration: 10.0, fibers: [(length: 0.03, segments: 6,
            section: {section}, root_joint: Free, {start}
            material: Elastic(density: 1200, youngs_modulus: 4e9, shear_modulus: 1.5e9),
            root: (position: (0, 0, {radius:?}), orientation: Along(direction: (0, 1, 0))))],
        objects: [(shape: Plane(normal: (0, 0, 1)))],
        environment: (gravity: ({:?}, 0, {:?})),
        contact: ({laws}), stepper: (dt: {dt:?}))",
        G * sin,
        -G * cos
    ))
}

/// Velocity along x, m/s, and angular velocity about y, rad/s, in the middle of a fibre.
fn motion(run: &Run) -> [f64; 2] {
    let state = run.world.state(0);
    let spin = state.frames[3] * state.angular_velocities[3];
    [0.5 * (state.velocities[3].x + state.velocities[4].x), spin.y]
}

/// A solid cylinder rolls down with two thirds of what gravity pulls, up to a slope of three times
/// the coefficient, and slips beyond, spun by friction. Backward Euler is exact for velocities
/// under constant forces; the bound is what the residual leaves.
#[test]
fn a_solid_cylinder_rolls_down() {
    let mu = 0.3;
    let scales = "Cuticle(with: 0.19, against: 0.38, across: 0.3)";
    for (radius, friction) in [(1e-3, "Isotropic(0.3)"), (4e-5, "Isotropic(0.3)"), (4e-5, scales)] {
        for slope in [0.05, 0.5, 0.88, 0.92, 1.5] {
            let section = format!("Circle(radius: {radius:?})");
            let dt = 1e-3;
            let laws = format!("friction: {friction}, {TIGHT}");
            let mut run = on_slope(&section, radius, &laws, slope, "", dt);
            let steps = 50;
            run.steps(steps);
            let time = dt * steps as f64;
            let (sin, cos) = slope.atan().sin_cos();
            let [expected, spin] = if slope < 3.0 * mu {
                let rolling = 2.0 / 3.0 * G * sin * time;
                [rolling, rolling / radius]
            } else {
                [G * (sin - mu * cos) * time, 2.0 * mu * G * cos * time / radius]
            };
            let [velocity, spinning] = motion(&run);
            println!(
                "{radius} {slope}: {velocity:.6} for {expected:.6} m/s, {spinning:.3} for {spin:.3} rad/s"
            );
            assert!((velocity - expected).abs() < 1e-4 * G * time, "{velocity} for {expected}");
            assert!((spinning - spin).abs() < 1e-4 * G * time / radius, "{spinning} for {spin}");
        }
    }
}

/// Thrown across its axis a cylinder slips until it rolls, with two thirds of its velocity: angular
/// momentum about the ground stays.
#[test]
fn a_cylinder_that_is_thrown_rolls_on() {
    let radius = 4e-5;
    let section = format!("Circle(radius: {radius:?})");
    let start = "velocity: (0.3, 0, 0),";
    let laws = format!("friction: Isotropic(0.3), {TIGHT}");
    let mut run = on_slope(&section, radius, &laws, 0.0, start, 1e-3);
    // Friction needs v / (3 mu g), 34 ms, to make it roll.
    run.steps(60);
    let [velocity, spin] = motion(&run);
    println!("{velocity:.6} m/s, {:.6} m/s", spin * radius);
    assert!((velocity - 0.2).abs() < 1e-5 && (spin * radius - 0.2).abs() < 1e-5);
    // What rolls loses nothing.
    let energy = run.world.energy().total();
    run.steps(60);
    let lost = 1.0 - run.world.energy().total() / energy;
    assert!(lost.abs() < 1e-6, "{lost}");
}

/// A cylinder with a rolling resistance of `b` rolls down with 2/3 g (sin - b / r cos), and rests
/// on slopes up to `b / r`. That the resistance is of the step before costs it two steps.
#[test]
fn rolling_resistance_holds_a_cylinder_or_brakes_it() {
    let dt = 1e-3;
    for radius in [1e-3, 4e-5] {
        let section = format!("Circle(radius: {radius:?})");
        for (resistance, slope) in [(0.02, 0.05), (0.02, 0.5), (0.1, 0.05), (0.1, 0.09)] {
            let resisting = format!("rolling_resistance: {:?}", resistance * radius);
            let laws = format!("friction: Isotropic(0.3), {resisting}, {TIGHT}");
            let mut run = on_slope(&section, radius, &laws, slope, "", dt);
            run.steps(100);
            let (sin, cos) = f64::atan(slope).sin_cos();
            let braked = 2.0 / 3.0 * G * resistance * cos;
            let expected = (2.0 / 3.0 * G * sin - braked).max(0.0) * 0.1;
            let [velocity, spin] = motion(&run);
            println!("{radius} {resistance} {slope}: {velocity:.3e} for {expected:.3e} m/s");
            let bound = if expected > 0.0 { 2.0 * dt * braked } else { 1e-7 };
            assert!((velocity - expected).abs() <= bound, "{velocity} for {expected}");
            assert!((spin * radius - expected).abs() <= bound, "{spin}");
        }
    }
}

/// On level ground what rolls comes to rest after `v / (2/3 g b / r)` and stays; its energy goes to
/// rolling.
#[test]
fn what_rolls_comes_to_rest() {
    let radius = 4e-5;
    let resisting = format!("rolling_resistance: {:?}", 0.02 * radius);
    let laws = format!("friction: Isotropic(0.3), {resisting}, {TIGHT}");
    let (section, start) = (format!("Circle(radius: {radius:?})"), "velocity: (0.03, 0, 0),");
    let mut run = on_slope(&section, radius, &laws, 0.0, start, 1e-3);
    // It rolls with 2/3 of its velocity after 3.4 ms.
    run.steps(50);
    let brake = 2.0 / 3.0 * G * 0.02;
    let expected = 0.02 - brake * 0.05;
    let [velocity, _] = motion(&run);
    println!("{velocity:.5} for {expected:.5} m/s");
    assert!((velocity - expected).abs() < 4e-3 * brake, "{velocity} for {expected}");
    run.steps(350);
    let [velocity, spin] = motion(&run);
    println!("{velocity:.1e} m/s, {:.1e} m/s", spin * radius);
    assert!(velocity.abs() < 1e-7 && (spin * radius).abs() < 1e-7);
}

/// Perimeter of an ellipse, m: the trapezoidal rule, which converges geometrically.
fn perimeter(a: f64, b: f64) -> f64 {
    let steps = 256;
    let speed = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / steps as f64).sin_cos();
        (a * sin).hypot(b * cos)
    };
    (0..steps).map(speed).sum::<f64>() * TAU / steps as f64
}

/// An elliptic cylinder on a slope touches it where its surface is: its axis goes by the perimeter
/// in a turn, at the height of the section above the slope, and has in the end what gravity has
/// given it, but for what backward Euler takes, which halves with the step.
#[test]
fn an_ellipse_rolls_by_its_perimeter() {
    // Up to (a^2 - b^2) / (2 a b), 0.095, it would rest, and where it is fast it would hop.
    let (a, b, slope) = (1.1e-3, 1e-3, 0.12);
    let section = format!("Ellipse(a: {a:?}, b: {b:?})");
    let mut lost = Vec::new();
    for dt in [5e-4, 2.5e-4] {
        let mut run = on_slope(&section, b, "friction: Isotropic(1.0)", slope, "", dt);
        let start = run.world.state(0).positions[3].x;
        let energy = run.world.energy();
        let (mut turned, mut way) = (0.0, 0.0);
        while turned < TAU {
            run.steps(1);
            let state = run.world.state(0);
            let frame = state.frames[3].matrix();
            let (up1, up2) = (frame.column(0).z, frame.column(1).z);
            let height = (a * up1).hypot(b * up2);
            let apart = state.positions[3].z - height;
            // A step may leave 0.02 diameters of depth, and what turns in it opens a gap.
            assert!(apart.abs() < 0.04 * a, "{apart} at {turned}");
            way = state.positions[3].x - start;
            turned += motion(&run)[1] * dt;
        }
        let expected = perimeter(a, b) * turned / TAU;
        let now = run.world.energy();
        let given = energy.gravitational - now.gravitational;
        lost.push(1.0 - (now.kinetic - energy.kinetic) / given);
        println!(
            "{way:.5e} for {expected:.5e} m in {turned:.4}; {:.2e} lost",
            lost[lost.len() - 1]
        );
        assert!((way / expected - 1.0).abs() < 0.01, "{way} for {expected}");
    }
    assert!(lost[1] > 0.0 && lost[1] < 0.6 * lost[0] && lost[0] < 0.1, "{lost:?}");
}

/// Pushed a little an elliptic cylinder rocks, and lies flat in the end.
#[test]
fn an_ellipse_comes_to_lie_flat() {
    let (a, b) = (1.5e-3, 1e-3);
    let section = format!("Ellipse(a: {a:?}, b: {b:?})");
    let start = "velocity: (0.02, 0, 0),";
    let mut run = on_slope(&section, b, "friction: Isotropic(1.0)", 0.0, start, 1e-3);
    run.steps(20);
    let tilted = run.world.state(0).frames[3].matrix().column(0).z.abs();
    assert!(tilted > 0.05, "{tilted}");
    run.steps(3000);
    let state = run.world.state(0);
    let flat = state.frames[3].matrix().column(0).z;
    println!("{flat:.2e}, {:.6e} m", state.positions[3].z);
    assert!(flat.abs() < 1e-3, "{flat}");
    assert!((state.positions[3].z - b).abs() < 0.02 * 2.0 * b);
}

/// False twist: between two plates that move past each other a fibre stays where it is and spins
/// by their velocity over its radius, in contacts that give way a little.
#[test]
fn a_fiber_between_two_plates_takes_their_turns() {
    let (radius, speed) = (4e-5, 0.1);
    let plate = |normal: f64, height: f64, speed: f64, sinking: f64| {
        format!(
            "(shape: Plane(normal: (0, 0, {normal:?})), position: (0, 0, {height:?}),
                motion: Translate(velocity: ({speed:?}, 0, {sinking:?}), until: 1.0))"
        )
    };
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [(length: 0.01, segments: 5,
            section: Circle(radius: {radius:?}), root_joint: Free,
            root: (position: (0, 0, {radius:?}), orientation: Along(direction: (0, 1, 0))))],
        objects: [{}, {}],
        environment: (gravity: (0, 0, 0)),
        contact: (friction: Isotropic(0.3), compliance: 10.0, residual: 1e-6, slip: 1e-8),
        stepper: (dt: 1e-3))",
        plate(1.0, 0.0, -speed, 0.0),
        plate(-1.0, 2.0 * radius, speed, -1e-5),
    ));
    run.steps(100);
    let [velocity, spin] = motion(&run);
    println!("{:.6} of the velocity of the plates, {velocity:.1e} m/s", spin * radius / speed);
    // What presses sinks in by half of 1 um, which is taken from the lever.
    assert!((spin * radius / speed - 1.0).abs() < 0.02, "{spin}");
    assert!(velocity.abs() < 1e-4 * speed, "{velocity}");
    for spin in run.world.state(0).angular_velocities {
        assert!((spin.z.abs() * radius / speed - 1.0).abs() < 0.02, "{spin}");
    }
}
