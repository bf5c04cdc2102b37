//! Where the energy of the staggered rod goes: every step's ledger closes to rounding, its lines
//! are what they say, and what the method in time takes vanishes with the order of the method.

use crate::common::{GRAVITY, chain, orders, planar_clamp, scaled};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Air, Conditions, Drag, End, Instant, Ledger, Load, Rod, RodState, RodStepReport,
    StaggeredBatch, Steady, StepError,
};

/// The error of a ledger in parts of the work of its step: rounding of the inertia of places, over
/// the squared step.
const CLOSES: f64 = 1e-9;
/// The solver's part of it: Newton's method leaves 1e-13 rad of turns that are 1e-6 rad in the
/// first steps of what starts from rest.
const SOLVED: f64 = 1e-7;

/// `None` for backward Euler.
type Rho = Option<f64>;
const ALL: [Rho; 4] = [None, Some(0.0), Some(0.3), Some(0.8)];

fn batch(rod: &Rod, rho: Rho) -> StaggeredBatch {
    let rods = vec![rod.clone()];
    let batch = match rho {
        None => StaggeredBatch::backward_euler(rods),
        Some(rho) => StaggeredBatch::new(rods, rho),
    };
    let mut batch = batch.expect("a valid rod");
    batch.keep_ledgers(true);
    batch
}

/// All of a ledger's lines.
fn lines(ledger: &Ledger) -> [f64; 10] {
    let Ledger { kinetic, elastic, gravity, loads, drag, .. } = *ledger;
    let Ledger { damping, supports, contacts, integrator, solver, .. } = *ledger;
    [kinetic, elastic, gravity, loads, drag, damping, supports, contacts, integrator, solver]
}

/// Steps with impulses on the nodes, and how well their ledgers close.
struct Books {
    batch: StaggeredBatch,
    sum: Ledger,
    /// Largest gap in a step, largest difference from the energies of the states, and largest part
    /// of the solver, in parts of the work of the step.
    worst: f64,
    off: f64,
    solver: f64,
    scale: f64,
}

impl Books {
    fn new(batch: StaggeredBatch) -> Self {
        Self { batch, sum: Ledger::default(), worst: 0.0, off: 0.0, solver: 0.0, scale: 0.0 }
    }

    fn energies(&self) -> [f64; 2] {
        let energy = self.batch.energy(0, &Vector3::zeros());
        [energy.kinetic, energy.elastic]
    }

    fn step(&mut self, dt: f64, conditions: &dyn Conditions, impulses: &[Vector3<f64>]) -> Ledger {
        self.try_step(dt, conditions, impulses).expect("a step")
    }

    fn try_step(
        &mut self,
        dt: f64,
        conditions: &dyn Conditions,
        impulses: &[Vector3<f64>],
    ) -> Result<Ledger, StepError> {
        let before = self.energies();
        let mut reports = [RodStepReport::default()];
        if impulses.is_empty() {
            self.batch.step(dt, &[conditions], &mut reports)?;
        } else {
            self.batch.predict(dt, &[conditions], &[], &mut reports)?;
            self.batch.correct(impulses, &mut reports)?;
            self.batch.accept();
        }
        let after = self.energies();
        let ledger = self.batch.ledger(0).expect("it is kept");
        let scale: f64 = lines(&ledger).iter().map(|x| x.abs()).sum();
        // Energies that hardly change are known to rounding only.
        let scale = scale + 1e-3 * (after[0] + after[1]);
        let gap = (ledger.gain() - ledger.work()).abs() / scale;
        self.worst = self.worst.max(gap);
        self.solver = self.solver.max(ledger.solver.abs() / scale);
        let off = |k: usize, gain: f64| (after[k] - before[k] - gain).abs() / scale;
        self.off = self.off.max(off(0, ledger.kinetic)).max(off(1, ledger.elastic));
        self.sum += ledger;
        self.scale = self.scale.max(scale);
        Ok(ledger)
    }

    fn check(&self, what: &str) {
        let [worst, off, solver] = [self.worst, self.off, self.solver];
        println!("{what}: closes to {worst:.1e}, energies to {off:.1e}, solver {solver:.1e}");
        assert!(worst < CLOSES, "{what}: closes to {worst:e}");
        assert!(off < 1e-10, "{what}: energies are off by {off:e}");
        assert!(solver < SOLVED, "{what}: the solver leaves {solver:e}");
    }
}

fn curly(segments: usize) -> Fiber {
    chain(segments, |s| {
        let mut node = scaled(0.1 - 0.04 * s, 0.08);
        node.linear_density = 1.3 - 0.6 * s;
        node.rotary_inertia = Vector3::new(1.0, 1.5, 2.5) * 1e-3;
        node.natural_curvature = Vector3::new(2.0, 1.0, 3.0);
        node
    })
}

/// The state of a rod that is thrown, turning.
fn thrown(batch: &StaggeredBatch) -> RodState {
    let mut state = batch.state(0);
    let spin = Vector3::new(1.0, 2.0, -1.5);
    for (v, r) in state.velocities.iter_mut().zip(&state.positions) {
        *v = Vector3::new(0.3, -0.2, 0.5) + spin.cross(&r.coords);
    }
    for (omega, frame) in state.angular_velocities.iter_mut().zip(&state.frames) {
        *omega = frame.inverse() * spin;
    }
    state
}

const DOWN: Vector3<f64> = Vector3::new(0.1, -1.0, 0.2);

/// A root that sways and turns, and stands still at the start.
fn swaying(t: f64) -> Isometry3<f64> {
    let way = Vector3::new(0.1, 0.05, -0.2) * (1.0 - (3.0 * t).cos());
    let turn = Vector3::new(0.3, -0.2, 0.4) * (1.0 - (2.0 * t).cos());
    Isometry3::new(way, turn)
}

fn wind(t: f64) -> Air {
    let drag = Drag { normal: 0.3, tangential: 0.1 };
    Air { wind: Vector3::new(0.5, 0.2, -0.4) * (0.5 + (0.7 * t).sin()), drag }
}

#[test]
fn ledgers_of_free_clamped_and_loaded_rods_close() {
    let free = |_| Instant { root: End::FREE, ..Instant::clamped(Isometry3::identity(), DOWN) };
    let clamped = |t: f64| Instant::clamped(swaying(t), DOWN);
    let airy = |t: f64| Instant { air: Some(wind(t)), ..clamped(t) };
    let loaded = |t: f64| Instant {
        root: End::Pinned {
            position: Point3::from(swaying(t).translation.vector),
            moment: Load::World(Vector3::new(0.01, 0.02, -0.01)),
        },
        tip: End::Loaded {
            force: Load::Follower(Vector3::new(0.1, 0.2, 0.1)),
            moment: Load::Follower(Vector3::new(0.0, 0.02, 0.01)),
        },
        distributed: Vector3::new(0.1, 0.0, 0.3),
        ..airy(t)
    };
    let tip = batch(&Rod::new(curly(20)), None).state(0).tip(&curly(20));
    let both = |t: f64| Instant {
        tip: End::Held(swaying(t) * Translation3::new(0.05 * t.sin(), 0.0, 0.0) * tip),
        ..airy(t)
    };
    // The tip is let go in the middle.
    let released = move |t: f64| if t < 1.0 { both(t) } else { airy(t) };
    let cases: [(&str, f64, &dyn Conditions); 6] = [
        ("free", 0.0, &free),
        ("moved root", 0.0, &clamped),
        ("damping, drag and wind", 0.02, &airy),
        ("loads", 0.02, &loaded),
        ("both ends", 0.02, &both),
        ("released", 0.02, &released),
    ];
    for (name, damping_time, conditions) in cases {
        for rho in ALL {
            let rod = Rod::damped(curly(20), damping_time);
            let mut batch = batch(&rod, rho);
            if name == "free" {
                batch.set_state(0, &thrown(&batch)).expect("fits");
            }
            batch.set_node_forces(0, &[Vector3::new(1e-3, 0.0, 2e-3); 21]).expect("fits");
            let mut books = Books::new(batch);
            for _ in 0..100 {
                let ledger = books.step(0.02, conditions, &[]);
                assert!(ledger.damping <= 0.0, "{name}: viscosity gives {:e}", ledger.damping);
                if name == "free" {
                    assert!(ledger.supports == 0.0 && ledger.drag == 0.0, "{ledger:?}");
                }
            }
            books.check(&format!("{name}, {rho:?}"));
        }
    }
}

/// Impulses at the start of steps, also on a root that is moved, which takes them up.
#[test]
fn impulses_are_in_the_ledger() {
    let rod = Rod::damped(curly(12), 0.02);
    let conditions = |t: f64| Instant { air: Some(wind(t)), ..Instant::clamped(swaying(t), DOWN) };
    for rho in ALL {
        let mut books = Books::new(batch(&rod, rho));
        for step in 0..60 {
            let impulse = |a: usize| Vector3::new((a + step) as f64, 1.0, a as f64).map(f64::sin);
            let impulses: Vec<_> = (0..=12).map(|a| 0.01 * impulse(a)).collect();
            let mut mean = vec![Vector3::zeros(); 13];
            let before: Vec<_> = (0..13).map(|a| books.batch.node(0, a).0).collect();
            let ledger = books.step(0.01, &conditions, &impulses);
            for a in 0..13 {
                mean[a] = (books.batch.node(0, a).0 - before[a]) / 0.01;
            }
            let work: f64 = impulses.iter().zip(&mean).map(|(p, v)| p.dot(v)).sum();
            assert!((ledger.contacts - work).abs() < 1e-12 * work.abs().max(1e-3), "{work}");
        }
        books.check(&format!("impulses, {rho:?}"));
    }
}

/// Side by side each fibre has its own ledger, which also closes over the parts of a step that is
/// halved, as a hair of 1 um does that whips.
#[test]
fn ledgers_of_halved_steps_close() {
    let rods = [35e-6, 1e-6, 1e-4].map(|radius| {
        let fiber = Fiber::uniform(0.3, 20, Section::Circle { radius }, &Material::HAIR);
        Rod::new(fiber.expect("valid").with_root(planar_clamp(0.0)))
    });
    let mut batch = StaggeredBatch::new(rods.to_vec(), 0.8).expect("valid rods");
    batch.keep_ledgers(true);
    let hold = Steady(Instant::clamped(planar_clamp(0.0), GRAVITY));
    let mut halvings = 0;
    for _ in 0..60 {
        let held = |batch: &StaggeredBatch, fiber: usize| {
            let energy = batch.energy(fiber, &GRAVITY);
            [energy.kinetic + energy.elastic, energy.gravitational]
        };
        let before = [0, 1, 2].map(|fiber| held(&batch, fiber));
        let mut reports = [RodStepReport::default(); 3];
        batch.step(1.0 / 30.0, &[&hold, &hold, &hold], &mut reports).expect("a step");
        for (fiber, before) in before.iter().enumerate() {
            let after = held(&batch, fiber);
            let ledger = batch.ledger(fiber).expect("it is kept");
            let moved: f64 = lines(&ledger).iter().map(|x| x.abs()).sum();
            for gap in [
                after[0] - before[0] - ledger.gain(),
                after[1] - before[1] + ledger.gravity,
                ledger.gain() - ledger.work(),
            ] {
                assert!(gap.abs() < CLOSES * moved, "fibre {fiber}: {gap:e} of {ledger:?}");
            }
        }
        halvings += reports.iter().map(|report| report.halvings).sum::<usize>();
    }
    assert!(halvings > 0, "a step is halved");
}

/// A straight rod that falls free without turning: backward Euler loses half the mass times the
/// squared change of velocity, the other method nothing.
#[test]
fn the_integrators_line_of_a_free_fall_is_known() {
    let fiber = chain(10, |_| scaled(1.0, 1.0));
    let fall =
        |_: f64| Instant { root: End::FREE, ..Instant::clamped(Isometry3::identity(), DOWN) };
    for rho in ALL {
        let mut books = Books::new(batch(&Rod::new(fiber.clone()), rho));
        let dt = 0.01;
        let expected =
            if rho.is_none() { -0.5 * fiber.mass() * (dt * DOWN).norm_squared() } else { 0.0 };
        for _ in 0..20 {
            let ledger = books.step(dt, &fall, &[]);
            let off = (ledger.integrator - expected).abs();
            assert!(off < 1e-12 * ledger.gravity, "{rho:?}: {ledger:?}");
        }
        books.check(&format!("free fall, {rho:?}"));
    }
}

/// Near a straight rod that hangs down the potential of a step is convex: backward Euler loses
/// energy in every step, by its own line, and viscosity and still air take what is theirs.
#[test]
fn backward_euler_only_loses_near_a_minimum() {
    let down = Isometry3::rotation(Vector3::x() * std::f64::consts::FRAC_PI_2);
    let fiber = chain(10, |_| scaled(0.1, 0.1)).with_root(down);
    let hang = |t: f64| {
        let drag = Drag { normal: 0.1, tangential: 0.1 };
        let air = Air { wind: Vector3::zeros(), drag };
        let tip = Load::World(if t < 0.5 { Vector3::x() * 0.05 } else { Vector3::zeros() });
        let tip = End::Loaded { force: tip, moment: Load::ZERO };
        Instant { tip, air: Some(air), ..Instant::clamped(down, Vector3::y() * -1.0) }
    };
    let mut books = Books::new(batch(&Rod::damped(fiber, 0.05), None));
    for _ in 0..300 {
        let ledger = books.step(0.01, &hang, &[]);
        let small = 1e-10 * books.scale;
        assert!(ledger.integrator <= small, "the integrator gives {:e}", ledger.integrator);
        assert!(ledger.drag <= 0.0 && ledger.damping <= 0.0, "{ledger:?}");
        assert!(ledger.supports.abs() <= small, "what rests does no work: {ledger:?}");
    }
    books.check("hanging");
    assert!(books.sum.integrator < 0.0 && books.sum.drag < 0.0 && books.sum.damping < 0.0);
}

/// What the integrator leaves over a fixed time vanishes with the step as the method says, with a
/// free rod and with one to which everything happens. Drag that is less along the rod is left out:
/// the method has its difference explicit, of first order.
#[test]
fn the_integrators_line_vanishes_with_the_order_of_the_method() {
    let free = |_: f64| Instant {
        root: End::FREE,
        ..Instant::clamped(Isometry3::identity(), Vector3::zeros())
    };
    let full = |t: f64| Instant {
        air: Some(Air {
            wind: Vector3::new(0.5, 0.2, -0.4),
            drag: Drag { normal: 0.3, tangential: 0.3 },
        }),
        ..Instant::clamped(swaying(t), DOWN)
    };
    let cases: [(&str, f64, &dyn Conditions); 2] = [("free", 0.0, &free), ("full", 0.05, &full)];
    for (name, damping_time, conditions) in cases {
        for (rho, expected) in [(None, 1.0), (Some(0.3), 2.0)] {
            let steps = [100_u32, 200, 400];
            let left: Vec<f64> = steps
                .iter()
                .map(|&count| {
                    let mut batch = batch(&Rod::damped(curly(10), damping_time), rho);
                    if name == "free" {
                        batch.set_state(0, &thrown(&batch)).expect("fits");
                    }
                    let mut books = Books::new(batch);
                    (0..count).for_each(|_| {
                        books.step(0.5 / f64::from(count), conditions, &[]);
                    });
                    books.check(&format!("{name}, {rho:?}, {count} steps"));
                    books.sum.integrator.abs()
                })
                .collect();
            let lengths = steps.map(|count| 0.5 / f64::from(count));
            let found = orders(&lengths, &left);
            println!("{name}, {rho:?}: integrator {left:?}, orders {found:.2?}");
            assert!(
                found.iter().all(|order| *order > 0.85 * expected),
                "{name} {rho:?}: {found:?}"
            );
        }
    }
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]
    /// Of any rod, however it is held, loaded and pushed.
    #[test]
    fn any_ledger_closes(
        lengths in prop::collection::vec(0.2..1.0_f64, 2..=10),
        (curl, turn, sway, push) in (vector(6.0), vector(2.0), vector(1.0), vector(0.05)),
        (bend, damping_time) in (0.02..0.5_f64, prop_oneof![Just(0.0), 0.0..0.1_f64]),
        (rho, root, tip) in (prop_oneof![Just(None), (0.0..0.5_f64).prop_map(Some)], 0..3_u8, 0..4_u8),
        (normal, share, dt) in (0.0..0.5_f64, 0.0..=1.0_f64, 0.002..0.03_f64),
    ) {
        let total: f64 = lengths.iter().sum();
        let nodes = (0..=lengths.len()).map(|j| {
            let s = j as f64 / lengths.len() as f64;
            let mut node = scaled(bend * (1.0 - 0.5 * s), 0.8 * bend);
            node.stiffness.y *= 1.5;
            node.rotary_inertia = Vector3::new(1.0, 1.5, 2.5) * 1e-3;
            node.natural_curvature = curl * s;
            node
        });
        let start = Isometry3::new(Vector3::zeros(), turn);
        let fiber = Fiber::new(start, lengths.iter().map(|l| l / total).collect(), nodes.collect());
        let rod = Rod::damped(fiber.expect("valid parts"), damping_time);
        let mut books = Books::new(batch(&rod, rho));
        let last = books.batch.state(0).tip(&rod.fiber);
        let conditions = |t: f64| {
            let moved = Translation3::from(sway * t * t)
                * start
                * UnitQuaternion::from_scaled_axis(sway.yzx() * t * t);
            let moment = Load::Follower(0.1 * push);
            Instant {
                root: match root {
                    0 => End::Held(moved),
                    1 => End::Pinned { position: moved.translation.vector.into(), moment },
                    _ => End::Loaded { force: Load::World(push), moment },
                },
                tip: match tip {
                    0 if root < 2 => End::Held(last),
                    1 if root < 2 => End::pinned(last.translation.vector.into()),
                    2 => End::FREE,
                    _ => End::Loaded { force: Load::Follower(push), moment },
                },
                air: Some(Air { wind: sway.zxy(), drag: Drag { normal, tangential: share * normal } }),
                distributed: push.yxz(),
                ..Instant::clamped(start, turn)
            }
        };
        // The tip must stay within reach of the root.
        let reach = (last.translation.vector - start.translation.vector).norm();
        prop_assume!(tip > 1 || root == 2 || reach < 0.7);
        for step in 0..12 {
            let impulses = vec![0.05 * push; if step % 3 == 1 { lengths.len() + 1 } else { 0 }];
            match books.try_step(dt, &conditions, &impulses) {
                // A step that is predicted is not halved: some are too long.
                Err(StepError::NotConverged { .. }) => break,
                taken => prop_assert!(taken.is_ok(), "{:?}", taken.err()),
            }
        }
        prop_assert!(books.worst < CLOSES, "closes to {:e}", books.worst);
        prop_assert!(books.solver < SOLVED, "the solver leaves {:e}", books.solver);
        prop_assert!(books.off < 1e-10, "energies are off by {:e}", books.off);
    }
}
