//! Where fibres are that have fallen on a ball, by their friction: the shipped scenes, smaller.

use crate::common::Run;
use nalgebra::Point3;
use rapunzel_sim::Scene;
use rapunzel_sim::scene::{Arrangement, FrictionLaw};

/// A scene that ships, with fewer fibres, as dense as they were, of fewer segments.
fn smaller(text: &str, count: usize, segments: usize) -> Scene {
    let mut scene = Scene::from_ron(text).expect("a sound scene");
    let bundle = &mut scene.fibers[0];
    if let Arrangement::Ellipse { semi_axes, count: all } = &mut bundle.arrangement {
        let share = (count as f64 / *all as f64).sqrt();
        (*semi_axes, *all) = (semi_axes.map(|axis| share * axis), count);
    }
    bundle.segments = segments;
    scene
}

/// Middles of the hairs after `time`, s.
fn middles(friction: FrictionLaw, time: f64) -> Vec<Point3<f64>> {
    let text = include_str!("../../../../scenes/contact/horizontal-bundle-on-ball.ron");
    let mut scene = smaller(text, 10, 20);
    scene.contact.as_mut().expect("a scene with contact").friction = friction;
    let mut run = Run::new(&scene);
    while run.world.time() < time {
        run.step();
    }
    (0..run.fibers()).map(|fiber| run.positions(fiber)[10]).collect()
}

/// Thesis 8.6.1: with friction all hairs stay on top of the ball, which is at z = -15 mm; without
/// it they part, and no middle is near the top any more.
#[test]
fn a_bundle_splits_without_friction_and_rests_with_it() {
    let rough = middles(FrictionLaw::Isotropic(0.3), 0.4);
    let widest = rough.iter().map(|p| p.y.abs()).fold(0.0, f64::max);
    assert!(rough.iter().all(|p| p.z > -0.017 && p.z < -0.0129), "{rough:?}");
    let smooth = middles(FrictionLaw::Isotropic(0.0), 0.4);
    let left = smooth.iter().filter(|p| p.y > 2.0 * widest).count();
    let right = smooth.iter().filter(|p| p.y < -2.0 * widest).count();
    println!("rough: within {:.1} mm; smooth: {left} left, {right} right", 1e3 * widest);
    assert_eq!(left + right, smooth.len(), "{smooth:?}");
    assert!(left.min(right) >= smooth.len() / 5, "{left} and {right}");
}
