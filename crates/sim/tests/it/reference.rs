//! The reference scene (thesis 8.6.2), whole: what is promised of every step.

use crate::common::Run;
use crate::common::books::Books;
use crate::common::topology::{Fibers, crossed};
use rapunzel_sim::Scene;

const SCENE: &str = include_str!("../../../../scenes/contact/helical-bundle-on-ball.ron");
const DIAMETER: f64 = 7e-5;

/// Every so many fibres one is looked at for crossings: of all it would take hours.
const SAMPLED: usize = 10;

fn sampled(run: &Run) -> Fibers {
    (0..run.fibers()).step_by(SAMPLED).map(|fiber| run.positions(fiber)).collect()
}

/// Among them that its segments keep their lengths, as [`Run::step`] has it.
#[test]
#[ignore = "slow: 140 s, 700 steps of 355 fibres"]
fn every_step_keeps_its_promises() {
    let mut scene = Scene::from_ron(SCENE).expect("it ships");
    scene.output.ledger = true;
    let mut books = Books::new(Run::new(&scene));
    let dt = books.run.dt;
    let mut before = sampled(&books.run);
    let (mut residual, mut slip, mut normal, mut depth) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let (steps, mut iterations) = (700, 0);
    for step in 0..steps {
        let report = books.step().contact;
        residual = residual.max(report.residual);
        slip = slip.max(report.slip_error);
        normal = normal.max(report.normal_error * dt / DIAMETER);
        depth = depth.max(report.depth / DIAMETER);
        iterations += report.iterations;
        let after = sampled(&books.run);
        assert_eq!(crossed(&before, &after, 0.5 * DIAMETER), None, "step {step}");
        before = after;
    }
    println!(
        "residual {residual:.2e}, slip {:.2} um/s, normal {normal:.4} and depth {depth:.4} diameters, \
         ledger {:.1e}, {:.1} iterations a step",
        slip * 1e6,
        books.worst,
        iterations as f64 / steps as f64
    );
    assert!(residual <= 1e-3 && slip <= 4e-5 && normal <= 0.01 && depth <= 0.02);
    assert!(books.worst <= 1e-6, "the ledger is open by {:e} of the work of a step", books.worst);
}
