//! Fibres that are closed to rings.

use super::MATTER;
use crate::common::Run;
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::so3;
use rapunzel_rod_dynamic::RodState;
use std::f64::consts::{PI, TAU};

/// Radius of the rings, m, and of their sections.
const RADIUS: f64 = 0.1;
const SECTION: f64 = 5e-4;
const DENSITY: f64 = 1000.0;
/// Bending and torsion stiffness, N m^2.
const BENDING: f64 = 1e7 * PI / 4.0 * SECTION * SECTION * SECTION * SECTION;
const TORSION: f64 = 4e6 * PI / 2.0 * SECTION * SECTION * SECTION * SECTION;

/// A naturally straight fibre of so many segments, closed to a ring with so many turns of twist.
fn ring(segments: usize, turns: f64, dt: f64) -> Run {
    Run::read(&format!(
        "(format: 1, duration: 100.0, fibers: [(length: {:?}, segments: {segments}, {MATTER},
            initial: Helix(radius: {RADIUS:?}, pitch: 0.0), root_joint: Free,
            closed: (turns: {turns:?}))],
          environment: (gravity: (0, 0, 0)), stepper: (dt: {dt:?}))",
        TAU * RADIUS
    ))
}

/// Period of the in-plane vibration of a ring with two waves, s (Love 1927, article 293).
fn period() -> f64 {
    let area = PI * SECTION * SECTION;
    let unit = (BENDING / (DENSITY * area * RADIUS.powi(4))).sqrt();
    TAU / (6.0 / 5.0_f64.sqrt() * unit)
}

fn middle(state: &RodState) -> Point3<f64> {
    let n = state.frames.len();
    let sum: Vector3<f64> = state.positions[..n].iter().map(|p| p.coords).sum();
    (sum / n as f64).into()
}

/// Linking number of the axis and d1: the writhe of the polygon (Klenin and Langowski 2000) and the
/// turns of d1 against a frame that is carried along without a twist.
fn link(state: &RodState) -> f64 {
    let n = state.frames.len();
    let mut points = state.positions[..n].to_vec();
    points.push(points[0]);
    let mut writhe = 0.0;
    for i in 0..n {
        for j in 0..i {
            let [a, b, c, d] = [points[i], points[i + 1], points[j], points[j + 1]];
            let r = [c - a, d - a, d - b, c - b];
            let normals: Vec<_> = (0..4).map(|k| r[k].cross(&r[(k + 1) % 4])).collect();
            if normals.iter().any(|normal| normal.norm() < 1e-14) {
                continue;
            }
            let angle = |k: usize| {
                let [a, b] = [&normals[k], &normals[(k + 1) % 4]];
                0.5 * PI - a.cross(b).norm().atan2(a.dot(b))
            };
            let area: f64 = (0..4).map(angle).sum();
            let sign = (d - c).cross(&(b - a)).dot(&(c - a));
            writhe += area * sign.signum() / TAU;
        }
    }
    let mut twist = 0.0;
    for e in 0..n {
        let [a, b] = [e, (e + 1) % n].map(|e| state.frames[e]);
        let [t, u] = [a * Vector3::z(), b * Vector3::z()];
        let carried = so3::between(&t, &u).expect("no fold") * (a * Vector3::x());
        let d1 = b * Vector3::x();
        let mut angle = carried.cross(&d1).dot(&u).atan2(carried.dot(&d1));
        // The junction of fractional turns is not between the frames, but nearly as within.
        if e == n - 1 {
            angle -= TAU * ((angle - twist / e as f64) / TAU).round();
        }
        twist += angle;
    }
    writhe + twist / TAU
}

/// A ring of a straight fibre is in balance, with or without twist.
#[test]
fn a_circle_is_in_balance() {
    for turns in [0.0, 1.0, 1.5] {
        let mut run = ring(40, turns, 1e-3);
        let before = run.positions(0);
        run.steps(100);
        let after = run.positions(0);
        let off = super::apart(&before, &after);
        println!("{turns} turns: moved {off:e} m");
        assert!(off < 1e-10 * RADIUS, "{turns} turns: {off:e}");
    }
}

/// A ring that is thrown about keeps its linking number, closed to rounding.
#[test]
fn a_ring_keeps_its_linking_number() {
    let mut run = ring(40, 1.0, 2e-3);
    let mut state = run.world.state(0);
    let middle = middle(&state);
    let axis = (state.positions[10] - middle).cross(&(state.positions[0] - middle)).normalize();
    for (a, v) in state.velocities.iter_mut().enumerate() {
        let angle = TAU * (a % 40) as f64 / 40.0;
        *v = 0.02 * (2.0 * angle).cos() * axis;
    }
    run.world.set_state(0, &state).expect("a state");
    let start = link(&run.world.state(0));
    assert!((start - 1.0).abs() < 1e-9, "{start}");
    let (mut worst, mut open) = (0.0_f64, 0.0_f64);
    for _ in 0..100 {
        run.steps(100);
        let state = run.world.state(0);
        worst = worst.max((link(&state) - start).abs());
        open = open.max((state.positions[40] - state.positions[0]).norm());
    }
    println!("link off by {worst:e}, open by {open:e} m");
    assert!(worst < 1e-9 && open < 1e-14, "{worst:e} {open:e}");
}

/// Period of the vibration with two waves, by the crossings of the radius of a node, s.
fn measured_period(segments: usize, dt: f64) -> f64 {
    let mut run = ring(segments, 0.0, dt);
    let mut state = run.world.state(0);
    let center = middle(&state);
    let normal = (state.positions[0] - center).cross(&(state.positions[1] - center)).normalize();
    let half = PI / segments as f64;
    let sideways = half.tan() / (2.0 * half).tan();
    let speed = 1e-4;
    let count = state.positions.len();
    let velocities: Vec<_> = (0..count)
        .map(|a| {
            let angle = TAU * a as f64 / segments as f64;
            let out = (state.positions[a] - center).normalize();
            let along = normal.cross(&out);
            speed * ((2.0 * angle).cos() * out - sideways * (2.0 * angle).sin() * along)
        })
        .collect();
    for e in 0..segments {
        let t = state.frames[e] * Vector3::z();
        let h = (state.positions[e + 1] - state.positions[e]).norm();
        let spin = t.cross(&((velocities[e + 1] - velocities[e]) / h));
        state.angular_velocities[e] = state.frames[e].inverse() * spin;
    }
    state.velocities = velocities;
    let radius = (state.positions[0] - center).norm();
    run.world.set_state(0, &state).expect("a state");
    // It starts through the circle: count two whole periods by the crossings outward.
    let (mut last, mut crossings) = (0.0, Vec::new());
    let mut time = 0.0;
    while crossings.len() < 4 {
        run.step();
        time += dt;
        let out = (run.positions(0)[0] - center).norm() - radius;
        if last * out < 0.0 {
            crossings.push(time - dt * out / (out - last));
        }
        last = out;
    }
    crossings[3] - crossings[1]
}

/// The vibration of a ring in its plane with two waves has the period of theory, with an error that
/// falls with the square of the segments.
#[test]
fn a_ring_vibrates_as_theory_says() {
    let exact = period();
    let errors: Vec<f64> =
        [20, 40].iter().map(|&n| measured_period(n, exact / 800.0) / exact - 1.0).collect();
    println!("errors {errors:?}");
    assert!(errors[1].abs() < 0.01, "{errors:?}");
    let ratio = errors[0] / errors[1];
    assert!((3.0..5.0).contains(&ratio), "{errors:?}");
}

/// Largest distance from the plane of the ring after some time, over that of the start, of a ring
/// with this twist, in parts of what theory allows (Michell 1889, Zajac 1962).
fn growth(part: f64, segments: usize) -> f64 {
    let turns = part * 3.0_f64.sqrt() * BENDING / TORSION;
    let dt = period() / 40.0;
    let mut run = ring(segments, turns, dt);
    let mut state = run.world.state(0);
    let center = middle(&state);
    let normal = (state.positions[0] - center).cross(&(state.positions[1] - center)).normalize();
    let count = state.positions.len();
    for a in 0..count {
        let angle = TAU * a as f64 / segments as f64;
        state.velocities[a] = 1e-6 * (2.0 * angle).cos() * normal;
    }
    run.world.set_state(0, &state).expect("a state");
    let height = |run: &Run| {
        let each = run.positions(0).into_iter().map(|p| (p - center).dot(&normal).abs());
        each.fold(0.0, f64::max)
    };
    let mut early = 0.0_f64;
    for _ in 0..400 {
        run.step();
        early = early.max(height(&run));
    }
    run.steps(1200);
    let mut late = 0.0_f64;
    for _ in 0..400 {
        run.step();
        late = late.max(height(&run));
    }
    late / early
}

/// Beyond a twist of `2 pi sqrt(3) EI / GJ` a ring leaves its plane, below it does not.
#[test]
fn a_twisted_ring_buckles_where_theory_says() {
    let [below, beyond] = [0.995, 1.005].map(|part| growth(part, 160));
    println!("below {below}, beyond {beyond}");
    assert!(below < 2.0, "{below}");
    assert!(beyond > 10.0, "{beyond}");
}
