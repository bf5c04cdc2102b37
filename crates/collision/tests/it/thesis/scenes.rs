//! The scenes that peers were measured on are reproduced to the pair.

use rapunzel_collision::thesis::scenes::{self, MovingFibers};

/// Pairs of boxes, and how many of these are capsules that touch.
fn count(scene: &MovingFibers) -> (usize, usize) {
    let capsules = scene.capsules().expect("a valid scene");
    let pairs = crate::common::box_pairs(&capsules);
    let touch = |&&[i, j]: &&[u32; 2]| {
        let (a, b) = (capsules.get(i as usize), capsules.get(j as usize));
        a.closest(&b).distance() <= a.radius + b.radius
    };
    (pairs.len(), pairs.iter().filter(touch).count())
}

#[test]
fn wavy_fibers_make_the_published_pairs() {
    let scene = scenes::wavy(1000);
    assert_eq!(count(&scene), (100_503, 9_827));
    assert_eq!(count(&scene.advanced(1.0)).0, 100_352);
}

#[test]
fn clumped_fibers_make_the_published_pairs() {
    let scene = scenes::clump(1000);
    assert_eq!(count(&scene), (154_908, 26_181));
    assert_eq!(count(&scene.advanced(1.0)).0, 154_938);
}
