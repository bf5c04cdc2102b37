//! Waves on the rope: their speed, and how they come back.

use nalgebra::{Point2, Vector2};
use rapunzel_mass_spring::{Element, Leapfrog, NodeVectors, Rope, System};
use std::f64::consts::{PI, TAU};

const NODES: usize = 401;
const SPACING: f64 = 0.05;
const FREQUENCY: f64 = 5.0;
const STRETCH: f64 = 1.5;
/// Nodes from end to end of the pulse.
const WIDTH: f64 = 80.0;

/// A stretched rope along x with a pulse of a given direction that runs to the right at `speed`.
/// The far end is fixed, or free to move across the rope.
fn pulse(speed: f64, across: Vector2<f64>, free: bool) -> System<2> {
    let rope = Rope { nodes: NODES, element: Element::unit(FREQUENCY), ..Rope::of_the_text(1.0) };
    let mut system = rope.build(Point2::origin(), Vector2::x()).expect("a rope");
    let height = 1e-4;
    let shape = |k: f64| {
        let s = (k - 100.0) / WIDTH;
        if s.abs() < 0.5 { height * (PI * s).cos().powi(2) } else { 0.0 }
    };
    let slope = |k: f64| 0.5 * (shape(k + 1e-3) - shape(k - 1e-3)) / 1e-3 / (SPACING * STRETCH);
    let at = |k: usize| Vector2::new(k as f64 * SPACING * STRETCH, 0.0) + across * shape(k as f64);
    let moving = |k: usize| across * (-speed * slope(k as f64));
    system
        .set_positions(&NodeVectors::of(&(0..NODES).map(at).collect::<Vec<_>>()))
        .expect("finite");
    if free {
        system.hold_axis(NODES - 1, 0, 0.0).expect("there");
    } else {
        system.pin(NODES - 1).expect("there");
    }
    let velocities: Vec<_> = (0..NODES).map(moving).collect();
    system.set_velocities(&NodeVectors::of(&velocities)).expect("finite");
    system
}

/// Place of the highest point, by a parabola through its neighbors, and its height with its sign.
fn crest(system: &System<2>, across: &Vector2<f64>) -> (f64, f64) {
    let rest = |k: usize| Vector2::new(k as f64 * SPACING * STRETCH, 0.0);
    let height = |k: usize| (system.position(k).coords - rest(k)).dot(across);
    let top = (1..NODES - 1).max_by(|&a, &b| height(a).abs().total_cmp(&height(b).abs()));
    let top = top.expect("nodes");
    let [a, b, c] = [height(top - 1), height(top), height(top + 1)];
    let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
    ((top as f64 + shift) * SPACING * STRETCH, b)
}

fn omega0() -> f64 {
    TAU * FREQUENCY
}

#[test]
fn waves_run_at_the_speed_of_the_theory() {
    // Long waves across: sqrt(tension by mass per length); along: sqrt(k / m) times the spacing.
    let spacing = SPACING * STRETCH;
    let across = omega0() * spacing * (1.0 - 1.0 / STRETCH).sqrt();
    let along = omega0() * spacing;
    for (speed, direction) in [(across, Vector2::y()), (along, Vector2::x())] {
        let mut system = pulse(speed, direction, false);
        let (start, _) = crest(&system, &direction);
        let time = 150.0 * spacing / speed;
        Leapfrog::new().advance(&mut system, time / 5000.0, 5000).expect("stable");
        let (end, height) = crest(&system, &direction);
        let found = (end - start) / time;
        assert!((found / speed - 1.0).abs() < 0.01, "{found} m/s instead of {speed}");
        assert!((height / 1e-4 - 1.0).abs() < 0.02, "the pulse keeps its height: {height}");
    }
}

#[test]
fn a_wave_comes_back_inverted_from_a_fixed_end_and_upright_from_a_free_one() {
    let spacing = SPACING * STRETCH;
    let speed = omega0() * spacing * (1.0 - 1.0 / STRETCH).sqrt();
    for (free, sign) in [(false, -1.0), (true, 1.0)] {
        let mut system = pulse(speed, Vector2::y(), free);
        // 300 nodes to the end, and half of that back.
        let time = 450.0 * spacing / speed;
        Leapfrog::new().advance(&mut system, time / 8000.0, 8000).expect("stable");
        let (place, height) = crest(&system, &Vector2::y());
        let expected = 250.0 * spacing;
        assert!((place - expected).abs() < 0.01 * 450.0 * spacing, "free {free}: at {place} m");
        assert!((height / (sign * 1e-4) - 1.0).abs() < 0.03, "free {free}: height {height}");
    }
}

#[test]
fn a_rope_with_bending_stiffness_bends_as_a_beam() {
    // A cantilever under its own weight: w L^4 / (8 B) at the tip for many segments, plus terms of
    // the order of the squared spacing. Springs so stiff that they do not count.
    let tip = |nodes: usize| {
        let (length, stiffness, weight) = (1.0, 1.0, 1e-3);
        let spacing = length / (nodes - 1) as f64;
        let element = Element { mass: spacing, ..Element::unit(100.0 * (nodes as f64)) };
        let rope = Rope { nodes, spacing, element, bending_stiffness: stiffness, rigid: false };
        let mut system = rope.build(Point2::origin(), Vector2::x()).expect("a rope");
        // Clamped: the second node keeps the direction.
        system.pin(1).expect("there");
        system.set_gravity(Vector2::new(0.0, -weight)).expect("finite");
        system.find_equilibrium(1e-11).expect("a beam");
        -system.position(nodes - 1).y * 8.0 * stiffness / weight
    };
    let [coarse, fine] = [21, 41].map(tip);
    // The error is of first order, because the clamp takes a segment; without that of second.
    let limit = 2.0 * fine - coarse;
    assert!((limit - 1.0).abs() < 5e-3, "{coarse}, {fine}, {limit}");
}
