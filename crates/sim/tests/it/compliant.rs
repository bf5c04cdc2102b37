//! Contacts that give way.

use crate::common::Run;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Radius of the hairs, m.
const RADIUS: f64 = 3.5e-5;
/// How far what touches gives way, m/N: with the weight of a hair by twice what `depth` leaves of
/// what is rigid.
const COMPLIANCE: f64 = 30.0;

/// A short free hair that lies down a slope, as x does, with z out of it: across it would roll.
fn hair_on(slope: f64, dt: f64) -> Run {
    let gravity = 9.81 / slope.hypot(1.0) * Vector3::new(slope, 0.0, -1.0);
    Run::read(&format!(
        "(format: 1, duration: 1.0,
        fibers: [(length: 0.008, segments: 4, section: Circle(radius: {RADIUS:?}), root_joint: Free,
            root: (position: (0, 0, {RADIUS:?}), orientation: Along(direction: (1, 0, 0))))],
        objects: [(shape: Plane(normal: (0.0, 0.0, 1.0)))],
        contact: (friction: Isotropic(0.3), compliance: {COMPLIANCE:?}, residual: 1e-9, slip: 1e-9),
        environment: (gravity: ({:?}, 0, {:?})), stepper: (dt: {dt:?}))",
        gravity.x, gravity.z
    ))
}

/// What touches is pressed in, and gives way to friction, by what its force makes of the
/// compliance; then it stays, for ever and whatever the steps: what has given way once does so no
/// more.
#[test]
fn a_hair_sinks_in_and_does_not_creep() {
    for dt in [1e-3, 2.5e-4] {
        let mut run = hair_on(0.2, dt);
        run.steps(400);
        let rested = run.positions(0);
        run.steps(2000);
        let nodes = run.positions(0);
        let (mut worst, mut deepest, mut count) = (0.0_f64, 0.0_f64, 0);
        for bearing in run.world.contacts() {
            let place = bearing.at[0];
            let expected = COMPLIANCE * bearing.force;
            let expected = Vector3::new(expected.x, 0.0, expected.z);
            // A lever that tilts moves the surface. At a node it may be that of either segment.
            let beside = (0..4).filter(|&e| (f64::from(e)..=f64::from(e + 1)).contains(&place));
            let errors = beside.map(|segment| {
                let [from, to] = [0, 1].map(|i| nodes[segment as usize + i]);
                let axis = from + (to - from) * (place - f64::from(segment));
                let tilt = RADIUS * (to.z - from.z) / (to.x - from.x);
                deepest = deepest.max(RADIUS - axis.z);
                (Vector3::new(0.002 * place - axis.x - tilt, 0.0, RADIUS - axis.z) - expected)
                    .norm()
            });
            let error = errors.fold(f64::INFINITY, f64::min);
            worst = worst.max(error / expected.norm());
            count += 1;
        }
        let moved = nodes.iter().zip(&rested).map(|(now, then)| (now - then).norm());
        let crept = moved.fold(0.0, f64::max) / deepest;
        println!("{count} contacts, {deepest:.2e} m deep to {worst:.1e}; crept {crept:.1e}");
        assert!(count >= 5 && deepest > 0.02 * 2.0 * RADIUS, "{deepest:e}");
        assert!(worst < 1e-6 && crept < 1e-6, "{worst:e} {crept:e}");
    }
}

/// What gives way slides at the same friction: down a slope of 0.45, once what it stands on has
/// been pressed in, with the acceleration that its normal force leaves.
#[test]
fn friction_keeps_its_limit() {
    let (slope, dt) = (0.45_f64, 1e-3);
    let mut run = hair_on(slope, dt);
    run.steps(100);
    let speed = |run: &Run| run.world.state(0).velocities[2].x;
    let before = speed(&run);
    run.steps(100);
    let found = (speed(&run) - before) / (100.0 * dt);
    let expected = 9.81 / slope.hypot(1.0) * (slope - 0.3);
    println!("{found:.6} m/s^2 for {expected:.6}");
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    for bearing in run.world.contacts() {
        let limit = bearing.force.x / bearing.force.z + 0.3;
        assert!(limit.abs() < 1e-6, "{limit:e}");
    }
}

/// A ball that meets the ground is half a swing of a spring there and leaves: without restitution
/// it keeps what backward Euler leaves of such a swing, `(1 + (w dt)^2)^(-1/2)` a step, and all of
/// it where steps are short.
#[test]
fn a_soft_ground_throws_a_ball_back() {
    let (mass, compliance, speed) = (1e-5_f64, 1e-2, 0.1);
    let rate = (mass * compliance).sqrt().recip();
    for dt in [2e-5, 5e-6] {
        let mut run = Run::read(&format!(
            "(format: 1, duration: 1.0,
            fibers: [(length: 0.2, segments: 2, section: Circle(radius: {RADIUS:?}),
                root: (position: (5, 5, 5), orientation: Along(direction: (0, 0, -1))))],
            objects: [(shape: Plane(normal: (0.0, 0.0, 1.0))),
                (shape: Ball(radius: 0.01), position: (0, 0, 0.01001),
                    moves: Free(mass: Mass({mass:?}), velocity: (0, 0, -{speed:?})))],
            contact: (friction: Isotropic(0.3), compliance: {compliance:?}, residual: 1e-9),
            environment: (gravity: (0, 0, 0)), stepper: (dt: {dt:?}))"
        ));
        let ball = |run: &Run| run.world.body(1).expect("it is free").clone();
        let (mut touched, mut lowest) = (0, f64::INFINITY);
        while ball(&run).velocity.z < 0.0 || run.world.contacts().next().is_some() {
            run.step();
            touched += usize::from(run.world.contacts().next().is_some());
            lowest = lowest.min(ball(&run).pose.translation.z - 0.01);
        }
        let kept = ball(&run).velocity.z / speed;
        let steps = PI / (rate * dt);
        let expected = (1.0 + (rate * dt).powi(2)).powf(-0.5 * steps);
        let [swing, depth] = [touched as f64 / steps, -lowest * rate / speed];
        println!("keeps {kept:.4} for {expected:.4}; {swing:.3} of half a swing, {depth:.3} deep");
        // A step begins and ends somewhere within the first and the last.
        let share = 2.0 / steps;
        assert!((kept / expected - 1.0).abs() < share && kept < 1.0, "{kept} {expected}");
        assert!((swing - 1.0).abs() < share && (depth - 1.0).abs() < 2.0 * share, "{depth}");
    }
}

/// How far what touches has given way is told by what it bore: a run goes on from a snapshot as it
/// would have.
#[test]
fn what_has_given_way_survives_a_snapshot() {
    let [mut run, mut other] = [0, 1].map(|_| hair_on(0.2, 1e-3));
    run.steps(10);
    other.world.restore(&run.world.snapshot()).expect("of the same scene");
    for _ in 0..10 {
        run.step();
        other.step();
        assert_eq!(run.positions(0), other.positions(0));
    }
}
