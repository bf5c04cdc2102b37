//! Rods with viscoelastic sections against the exact answers of linear viscoelasticity.

use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use rapunzel_fiber::{Fiber, NodeProperties, SectionLaw, so3};
use rapunzel_keratin::lab::oscillation::Oscillation;
use rapunzel_keratin::lab::pendulum::{self, Bob};
use rapunzel_keratin::law::{Creep, MaxwellElement, MaxwellModel, Relaxation, Viscoelastic};
use rapunzel_keratin::{Climate, Hair};
use rapunzel_rod_dynamic::{
    Conditions, End, Instant, Load, Rod, RodIntegrator, RodState, RodStepReport, SectionLaws,
    Staggered, StaggeredBatch, Steady, equilibrium,
};
use std::f64::consts::TAU;
use std::sync::Arc;

const LENGTH: f64 = 0.02;
const SEGMENTS: usize = 20;

fn node() -> NodeProperties {
    let hair = Hair::with_diameters(70e-6, 70e-6).expect("diameters");
    hair.node(&Climate::STANDARD).expect("measured")
}

fn straight() -> Fiber {
    let lengths = vec![LENGTH / SEGMENTS as f64; SEGMENTS];
    Fiber::new(Isometry3::identity(), lengths, vec![node(); SEGMENTS + 1]).expect("a fibre")
}

/// The rod whose stiffness at once is that of the fibre, and which relaxes by `g`.
fn relaxing(fiber: Fiber, g: &Relaxation, damping_time: f64) -> Rod {
    let stiffness = fiber.nodes()[0].stiffness / g.glassy();
    let law = Viscoelastic::new(stiffness, g, damping_time).expect("a law");
    Rod { laws: SectionLaws::Same(Arc::new(law)), ..Rod::new(fiber) }
}

/// A solid with two relaxation times, s.
fn solid() -> Relaxation {
    let branches =
        [(0.5, 3.0), (0.3, 40.0)].map(|(modulus, time)| MaxwellElement { modulus, time });
    Relaxation::new(0.2, branches.to_vec()).expect("a model")
}

/// The elastic equilibrium of the fibre, weightless, with a force across its tip, in parts of
/// `E I / L^2`; and what acts on it.
fn pulled(fiber: &Fiber, part: f64) -> (Instant, RodState) {
    let mut conditions = Instant::clamped(*fiber.root(), Vector3::zeros());
    let force = part * node().stiffness.x / LENGTH.powi(2);
    conditions.tip = End::Loaded { force: Load::World(force * Vector3::x()), moment: Load::ZERO };
    let rod = Rod::new(fiber.clone());
    let rest = Staggered::new(rod.clone()).expect("a rod").state();
    let (bent, _) = equilibrium(&rod, &conditions, &rest).expect("an equilibrium");
    (conditions, bent)
}

/// Runs a rod, by backward Euler, whose inertia is soon forgotten, and reads it at each step.
fn run<T>(
    rod: Rod,
    start: &RodState,
    conditions: &dyn Conditions,
    [dt, steps]: [f64; 2],
    read: impl Fn(&RodState) -> T,
) -> Vec<(f64, T)> {
    let mut batch = StaggeredBatch::backward_euler(vec![rod]).expect("a rod");
    batch.set_state(0, start).expect("its state");
    let mut readings = vec![(0.0, read(start))];
    while (readings.len() as f64) <= steps {
        let mut reports = [RodStepReport::default()];
        batch.step(dt, &[conditions], &mut reports).expect("a step");
        readings.push((batch.time(), read(&batch.state(0))));
    }
    readings
}

#[test]
fn a_cantilever_creeps_by_the_correspondence_principle() {
    let (fiber, g) = (straight(), solid());
    // To a deflection of a thousandth of the length.
    let (pulled, start) = pulled(&fiber, 3e-3);
    let tip = |state: &RodState| state.positions[SEGMENTS].x;
    let dt = 0.1;
    let rod = relaxing(fiber, &g, 0.0);
    let readings = run(rod, &start, &Steady(pulled), [dt, 600.0], tip);
    let creep = Creep::from(&g);
    for (t, x) in &readings {
        // In proportion to J(t), but for a part of the square of the deflection, up to 5e-3, and of
        // that of the step over the shortest relaxation time.
        let expected = readings[0].1 * creep.at(*t) / creep.at(0.0);
        let allowed = (x / LENGTH).powi(2) + (dt / 3.0).powi(2) / 3.0;
        assert!((x / expected - 1.0).abs() < allowed, "{t}: {x} {expected}");
    }
}

#[test]
fn a_rod_that_is_held_relaxes() {
    let (fiber, g) = (straight(), solid());
    let (mut held, bent) = pulled(&fiber, 1.0);
    held.tip = End::Held(bent.tip(&fiber));
    let rod = Rod::new(fiber.clone());
    let (start, _) = equilibrium(&rod, &held, &bent).expect("an equilibrium");
    let force = |state: &RodState| state.forces[SEGMENTS / 2];
    let rod = relaxing(fiber, &g, 0.0);
    let readings = run(rod, &start, &Steady(held), [0.5, 200.0], force);
    // Nothing moves: any step is exact, and so is any deflection. At the start no force is known.
    let first = readings[1];
    for (t, force) in &readings[1..] {
        let expected = first.1 * (g.at(*t) / g.at(first.0));
        assert!((force - expected).norm() < 1e-6 * first.1.norm(), "{t}: {force} {expected}");
    }
}

/// The root of `s^2 + w^2 (G(s) + tau s)` near `i w`, with `G(s)` Carson's transform of a
/// relaxation function whose value at once is 1: real part and imaginary part, by Newton's method
/// on both.
fn exact_root(g: &Relaxation, tau: f64, w: f64) -> [f64; 2] {
    let value = |[re, im]: [f64; 2]| {
        let mut sum = [g.equilibrium() + tau * re, tau * im];
        for MaxwellElement { modulus, time } in g.branches() {
            // m s T / (1 + s T) = m (1 - 1 / (1 + s T)).
            let (a, b) = (1.0 + re * time, im * time);
            let square = a * a + b * b;
            sum[0] += modulus * (1.0 - a / square);
            sum[1] += modulus * b / square;
        }
        [re * re - im * im + w * w * sum[0], 2.0 * re * im + w * w * sum[1]]
    };
    let mut s = [0.0, w];
    for _ in 0..60 {
        let f = value(s);
        // Cauchy and Riemann give the other column.
        let h = 1e-6 * w;
        let there = value([s[0] + h, s[1]]);
        let slope = [(there[0] - f[0]) / h, (there[1] - f[1]) / h];
        let norm = slope[0] * slope[0] + slope[1] * slope[1];
        s[0] -= (f[0] * slope[0] + f[1] * slope[1]) / norm;
        s[1] -= (f[1] * slope[0] - f[0] * slope[1]) / norm;
    }
    s
}

/// Laws that lose much and little at 1 rad/s: a relaxation function, 1 at once, and a damping time.
fn lossy() -> [(Relaxation, f64); 3] {
    let of = |equilibrium, branches: &[(f64, f64)]| {
        let branches = branches.iter().map(|&(modulus, time)| MaxwellElement { modulus, time });
        Relaxation::new(equilibrium, branches.collect()).expect("a model")
    };
    [
        (of(1.0, &[]), 0.05),
        (of(0.7, &[(0.2, 0.5), (0.1, 5.0)]), 0.0),
        (of(0.0, &[(0.6, 200.0), (0.4, 12.0)]), 0.01),
    ]
}

/// Moves a rod and reads it.
fn record(
    rod: Rod,
    start: &RodState,
    [dt, end]: [f64; 2],
    read: impl Fn(&RodState) -> f64,
) -> Vec<(f64, f64)> {
    let conditions = Steady(Instant::clamped(*rod.fiber.root(), Vector3::zeros()));
    let mut moving = Staggered::new(rod).expect("a rod");
    moving.set_state(start).expect("its state");
    let mut record = Vec::new();
    while moving.time() < end {
        moving.step(dt, &conditions).expect("a step");
        record.push((moving.time(), read(&moving.state())));
    }
    record
}

#[test]
fn free_torsion_decays_as_the_law_says() {
    let (length, segments, period) = (0.05, 8, 1.0);
    let inertia = node().stiffness.z / length * (period / TAU).powi(2);
    for (g, tau) in lossy() {
        // Times in units of 1 / w.
        let scaled = Relaxation::new(
            g.equilibrium(),
            g.branches()
                .iter()
                .map(|b| MaxwellElement { time: b.time * period / TAU, ..*b })
                .collect(),
        )
        .expect("a model");
        let fiber = pendulum::fiber(node(), length, segments, Bob { mass: 1e-4, inertia })
            .expect("a fibre");
        let rod = relaxing(fiber, &scaled, tau * period / TAU);
        let mut start = Staggered::new(rod.clone()).expect("a rod").state();
        let arcs = rod.fiber.arc_lengths();
        for (i, frame) in start.frames.iter_mut().enumerate() {
            let middle = 0.5 * (arcs[i] + arcs[i + 1]) / length;
            *frame *= so3::exp(&(0.5 * middle * Vector3::z()));
        }
        let angle = |state: &RodState| so3::log(&state.frames[segments]).z;
        let readings = record(rod, &start, [period / 300.0, 9.0 * period], angle);
        // What relaxes slowly lets the middle drift for a while; the middle of neighbouring
        // extremes is it.
        let found = swing(&readings);
        let [re, im] = exact_root(&g, tau, 1.0);
        let expected = -TAU * re / im;
        assert!((found.log_decrement / expected - 1.0).abs() < 0.02, "{found:?} {expected}");
        assert!((found.period * im / period - 1.0).abs() < 0.01, "{found:?} {im}");
    }
}

/// Period and decrement from the turning points, each against the mean of its two neighbours: a
/// middle that drifts slowly does not count.
fn swing(record: &[(f64, f64)]) -> Oscillation {
    let turns: Vec<(f64, f64)> = record
        .windows(3)
        .filter(|w| (w[1].1 - w[0].1) * (w[2].1 - w[1].1) <= 0.0)
        .map(|w| {
            let (h, s0, s1) = (w[1].0 - w[0].0, w[1].1 - w[0].1, w[2].1 - w[1].1);
            let shift = 0.5 * (s0 + s1) / (s0 - s1);
            (w[1].0 + shift * h, w[1].1 + 0.25 * (s0 + s1) * shift)
        })
        .collect();
    let sizes: Vec<f64> =
        turns.windows(3).map(|w| (w[1].1 - 0.5 * (w[0].1 + w[2].1)).abs()).collect();
    let (first, last) = (2, sizes.len() - 1);
    let halves = (last - first) as f64;
    Oscillation {
        period: 2.0 * (turns[last + 1].0 - turns[first + 1].0) / halves,
        log_decrement: 2.0 * (sizes[first] / sizes[last]).ln() / halves,
    }
}

#[test]
fn free_bending_decays_as_the_law_says() {
    let fiber = straight();
    let w = (1.875_104_069 / LENGTH).powi(2) * (node().stiffness.x / node().linear_density).sqrt();
    let period = TAU / w;
    for (g, tau) in lossy() {
        let scaled = Relaxation::new(
            g.equilibrium(),
            g.branches().iter().map(|b| MaxwellElement { time: b.time / w, ..*b }).collect(),
        )
        .expect("a model");
        let (_, start) = pulled(&fiber, 0.05);
        let rod = relaxing(fiber.clone(), &scaled, tau / w);
        let tip = |state: &RodState| state.positions[SEGMENTS].x;
        let readings = record(rod, &start, [period / 300.0, 9.0 * period], tip);
        // Higher modes are gone after two periods.
        let found = swing(&readings[600..]);
        let [re, im] = exact_root(&g, tau, 1.0);
        let expected = -TAU * re / im;
        assert!((found.log_decrement / expected - 1.0).abs() < 0.02, "{found:?} {expected}");
    }
}

#[test]
fn what_a_step_dissipates_is_its_work_less_what_it_stores() {
    // Over five decades of the step, against the same element in one dimension.
    for dt in [1e-6, 1e-3, 0.02, 0.04, 0.3, 2.0, 50.0] {
        for (q, rise) in [(0.0, 1.0), (0.7, 0.0), (0.4, -0.9), (-1.3, -0.2)] {
            let g = Relaxation::new(0.3, vec![MaxwellElement { modulus: 2.0, time: 1.0 }])
                .expect("one");
            let law = Viscoelastic::new(Vector3::repeat(1.0), &g, 0.0).expect("a law");
            let mut strand = MaxwellModel::new(&g);
            strand.strain_to(q, 0.0);
            let before = strand.stored_energy();
            let step = strand.strain_to(q + rise, dt);
            let mut memory = vec![Vector3::zeros(); law.memory()];
            law.commit(&mut memory, &(q * Vector3::x()), 0.0);
            let lost = law.dissipated(&memory, &((q + rise) * Vector3::x()), dt);
            let expected = step.work - (strand.stored_energy() - before);
            // Of the strand's work a step of a thousandth of its time leaves ten digits.
            assert!((lost - expected).abs() < 3e-10, "{dt}: {lost} {expected}");
            assert!(lost >= 0.0);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]
    /// Whatever its law and shape, an unloaded rod only loses energy, and the law only takes.
    #[test]
    fn a_passive_law_creates_no_energy(
        branches in prop::collection::vec((0.01..2.0_f64, -4.0..2.0_f64), 0..4),
        (equilibrium, tau) in (0.05..1.0_f64, prop_oneof![Just(0.0), 1e-5..1e-2_f64]),
        curl in prop::array::uniform3(-80.0..80.0_f64),
        steps in prop::collection::vec(-4.0..0.0_f64, 20),
    ) {
        let branches = branches.into_iter()
            .map(|(modulus, decade)| MaxwellElement { modulus, time: 10_f64.powf(decade) });
        let g = Relaxation::new(equilibrium, branches.collect()).expect("a model");
        let rod = relaxing(straight(), &g, tau);
        let curled = straight().with_natural_curvature(|_| Vector3::from(curl)).expect("a curl");
        let start = Staggered::new(Rod::new(curled)).expect("a rod").state();
        let mut batch = StaggeredBatch::backward_euler(vec![rod]).expect("a rod");
        batch.set_state(0, &start).expect("its state");
        batch.keep_ledgers(true);
        let free = Steady(Instant::clamped(*straight().root(), Vector3::zeros()));
        let first = batch.energy(0, &Vector3::zeros()).total();
        let mut last = first;
        for decade in steps {
            let mut reports = [RodStepReport::default()];
            batch.step(10_f64.powf(decade), &[&free], &mut reports).expect("a step");
            let energy = batch.energy(0, &Vector3::zeros()).total();
            let ledger = batch.ledger(0).expect("kept");
            prop_assert!(energy <= last + 1e-11 * first, "{energy} {last} {first}");
            prop_assert!(ledger.damping <= 1e-15 * first, "{ledger:?}");
            prop_assert!((ledger.gain() - ledger.work()).abs() <= 1e-10 * first, "{ledger:?}");
            last = energy;
        }
    }
}
