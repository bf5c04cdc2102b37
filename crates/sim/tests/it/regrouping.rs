//! Hairs that touch something move side by side with others that do.

use crate::common::Run;
use nalgebra::Point3;

/// Hairs in a row, every ninth of which falls onto a ball.
fn row() -> Run {
    let objects: String = (0..5)
        .map(|i| {
            let x = 3e-3 * f64::from(9 * i);
            format!("(shape: Ball(radius: 1e-3), position: ({x}, 0.02, -0.0012)),")
        })
        .collect();
    let fibers: String = (0..45)
        .map(|i| {
            let x = 3e-3 * f64::from(i);
            format!(
                "(length: 0.03, segments: 10, section: Circle(radius: 3.5e-5),
                root: (position: ({x}, 0, 0), orientation: Along(direction: (0, 1, 0)))),"
            )
        })
        .collect();
    Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [{fibers}], objects: [{objects}],
        environment: (viscosity: 1.8e-5), contact: (friction: Isotropic(0.3)), stepper: (dt: 1e-3))"
    ))
}

fn places(run: &Run) -> Vec<Vec<Point3<f64>>> {
    (0..run.fibers()).map(|fiber| run.positions(fiber)).collect()
}

/// Five hairs of as many groups lie on something. A run that is resumed, on another number of
/// threads too, has the same bits, and where a hair is in a row does not matter to where it goes.
#[test]
fn hairs_that_lie_on_something_move_as_they_did_where_they_are_moved_together() {
    let pool = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let mut run = row();
    let (mut most, mut snapshots) = (0, Vec::new());
    for _ in 0..8 {
        snapshots.push(run.world.snapshot());
        for _ in 0..20 {
            most = most.max(run.step().contact.active);
        }
    }
    assert!(most >= 5, "{most} contacts");
    let end = places(&run);
    for (part, snapshot) in snapshots.iter().enumerate().skip(3) {
        let mut again = row();
        again.world.restore(snapshot).expect("the same hairs");
        pool(2).expect("threads").install(|| again.steps(20 * (8 - part)));
        assert_eq!(places(&again), end, "from step {}", 20 * part);
    }
    // Where they hang free, and where they lie, all are alike.
    let height = |fiber: usize| end[fiber][10].z;
    for fiber in 0..45 {
        let like = height(if fiber % 9 == 0 { 9 } else { 1 });
        assert!((height(fiber) - like).abs() < 1e-6, "{fiber}: {} {like}", height(fiber));
    }
    assert!(height(9) - height(1) > 1e-4, "{} {}", height(9), height(1));
}
