//! The line of the method in time is what it is known to be, and vanishes with the order of the
//! method.

use super::{ALL, Books, DOWN, batch, curly, swaying, thrown};
use crate::common::{chain, orders, scaled};
use nalgebra::{Isometry3, Vector3};
use rapunzel_rod_dynamic::{Air, Conditions, Drag, End, Instant, Load, Rod};

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
