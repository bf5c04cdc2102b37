//! The reference scene (thesis 8.6.2), whole: what is promised of every step.

#![expect(clippy::print_stdout, reason = "a test tells what it measured")]

mod common;

use common::Run;
use common::topology::{Fibers, crossed};
use rapunzel_sim::{Scene, World};

const SCENE: &str = include_str!("../../../scenes/contact/helical-bundle-on-ball.ron");
const DIAMETER: f64 = 7e-5;

/// Every so many fibres one is looked at for crossings: of all it would take hours.
const SAMPLED: usize = 10;

fn sampled(run: &Run) -> Fibers {
    (0..run.fibers()).step_by(SAMPLED).map(|fiber| run.positions(fiber)).collect()
}

/// Energy held, and work done since the start by kind, J.
fn books(world: &World) -> (f64, [f64; 8]) {
    let (energy, works) = (world.energy(), world.works().expect("the scene asks for it"));
    let done = [
        works.gravity,
        works.loads,
        works.drag,
        works.damping,
        works.supports,
        works.integrator,
        works.solver,
        world.contact_work().total(),
    ];
    (energy.kinetic + energy.elastic, done)
}

/// Largest error of the length of a segment, relative.
fn stretch(run: &Run) -> f64 {
    let of_fiber = |fiber: usize| {
        let own = &run.world.assembly().fibers()[fiber];
        let length = own.length() / own.segments() as f64;
        let positions = run.positions(fiber);
        let errors = positions.windows(2).map(|ends| (ends[1] - ends[0]).norm() / length - 1.0);
        errors.fold(0.0, |worst: f64, error| worst.max(error.abs()))
    };
    (0..run.fibers()).map(of_fiber).fold(0.0, f64::max)
}

#[test]
#[ignore = "slow: 140 s, 700 steps of 355 fibres"]
fn every_step_keeps_its_promises() {
    let mut scene = Scene::from_ron(SCENE).expect("it ships");
    scene.output.ledger = true;
    let mut run = Run::new(&scene);
    let mut before = sampled(&run);
    let (mut residual, mut slip, mut normal, mut depth) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let (mut open, mut longer, mut iterations) = (0.0_f64, 0.0_f64, 0);
    let steps = 700;
    for step in 0..steps {
        let (held, done) = books(&run.world);
        let report = run.step().contact;
        residual = residual.max(report.residual);
        slip = slip.max(report.slip_error);
        normal = normal.max(report.normal_error * run.dt / DIAMETER);
        depth = depth.max(report.depth / DIAMETER);
        iterations += report.iterations;
        let (now, later) = books(&run.world);
        let changes: Vec<f64> = later.iter().zip(&done).map(|(a, b)| a - b).collect();
        let moved: f64 = changes.iter().map(|x| x.abs()).sum();
        open = open.max((now - held - changes.iter().sum::<f64>()).abs() / moved);
        longer = longer.max(stretch(&run));
        let after = sampled(&run);
        assert_eq!(crossed(&before, &after, 0.5 * DIAMETER), None, "step {step}");
        before = after;
    }
    println!(
        "residual {residual:.2e}, slip {:.2} um/s, normal {normal:.4} and depth {depth:.4} diameters, \
         ledger {open:.1e}, lengths {longer:.1e}, {:.1} iterations a step",
        slip * 1e6,
        f64::from(u32::try_from(iterations).expect("few")) / f64::from(steps)
    );
    assert!(residual <= 1e-3 && slip <= 4e-5 && normal <= 0.01 && depth <= 0.02);
    assert!(open <= 1e-6, "the ledger is open by {open:e} of the work of a step");
    assert!(longer <= 1e-12, "a segment is longer by {longer:e}");
}
