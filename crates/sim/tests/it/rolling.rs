//! Free fibres roll where they stick, and slip where they do not.

use crate::common::Run;

const G: f64 = 9.81;

/// A straight free fibre along y on a plane, `mu` between them, in a field of gravity that leans by
/// `slope` (its tangent) along x; `start` is what it starts with.
fn on_slope(section: &str, radius: f64, mu: &str, slope: f64, start: &str, dt: f64) -> Run {
    let (sin, cos) = slope.atan().sin_cos();
    Run::read(&format!(
        "(format: 1, duration: 10.0, fibers: [(length: 0.03, segments: 6,
            section: {section}, root_joint: Free, {start}
            material: Elastic(density: 1200, youngs_modulus: 4e9, shear_modulus: 1.5e9),
            root: (position: (0, 0, {radius:?}), orientation: Along(direction: (0, 1, 0))))],
        objects: [(shape: Plane(normal: (0, 0, 1)))],
        environment: (gravity: ({:?}, 0, {:?})),
        contact: (friction: {mu}, residual: 1e-6, slip: 1e-8), stepper: (dt: {dt:?}))",
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
    for (radius, dt) in [(1e-3, 1e-3), (4e-5, 1e-3)] {
        for slope in [0.05, 0.5, 0.88, 0.92, 1.5] {
            let section = format!("Circle(radius: {radius:?})");
            let friction = format!("Isotropic({mu:?})");
            let mut run = on_slope(&section, radius, &friction, slope, "", dt);
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
    let mut run = on_slope(&section, radius, "Isotropic(0.3)", 0.0, start, 1e-3);
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
