//! Every step's ledger closes to rounding.

use super::{ALL, Books, CLOSES, DOWN, SOLVED, batch, curly, lines, swaying, thrown, wind};
use crate::common::{GRAVITY, planar_clamp, scaled};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Air, Conditions, Drag, End, Instant, Load, Rod, RodStepReport, StaggeredBatch, Steady,
    StepError,
};

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

/// Impulses on the nodes of a rod of twelve segments in a step, N s.
fn impulses(step: usize) -> Vec<Vector3<f64>> {
    let impulse = |a: usize| Vector3::new((a + step) as f64, 1.0, a as f64).map(f64::sin);
    (0..=12).map(|a| 0.01 * impulse(a)).collect()
}

/// Impulses at the start of steps, also on a root that is moved, which takes them up.
#[test]
fn impulses_are_in_the_ledger() {
    let rod = Rod::damped(curly(12), 0.02);
    let conditions = |t: f64| Instant { air: Some(wind(t)), ..Instant::clamped(swaying(t), DOWN) };
    for rho in ALL {
        let mut books = Books::new(batch(&rod, rho));
        for step in 0..60 {
            let impulses = impulses(step);
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

/// Impulses beside the axis too: their moments turn the segments, and work along that is of
/// contacts.
#[test]
fn moments_are_in_the_ledger() {
    let rod = Rod::damped(curly(12), 0.02);
    let conditions = |t: f64| Instant { air: Some(wind(t)), ..Instant::clamped(swaying(t), DOWN) };
    for rho in ALL {
        let mut books = Books::new(batch(&rod, rho));
        books.arm = Vector3::new(0.0, 0.02, -0.01);
        let mut without = Books::new(batch(&rod, rho));
        let mut apart = 0.0_f64;
        for step in 0..60 {
            let impulses = impulses(step);
            let [with, none] = [&mut books, &mut without]
                .map(|books| books.step(0.01, &conditions, &impulses).contacts);
            apart = apart.max((with - none).abs());
        }
        books.check(&format!("moments, {rho:?}"));
        assert!(apart > 1e-3 * books.scale, "moments do work: {apart:e}");
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
                // A step with impulses is not halved: some are too long.
                Err(StepError::NotConverged { .. }) => break,
                taken => prop_assert!(taken.is_ok(), "{:?}", taken.err()),
            }
        }
        prop_assert!(books.worst < CLOSES, "closes to {:e}", books.worst);
        prop_assert!(books.solver < SOLVED, "the solver leaves {:e}", books.solver);
        prop_assert!(books.off < 1e-10, "energies are off by {:e}", books.off);
    }
}
