//! A whole step: swept boxes, then continuous detection. What discrete detection tunnels through is
//! found.

use nalgebra::Vector3;
use rapunzel_collision::continuous::impacts;
use rapunzel_collision::thesis::scenes;
use rapunzel_collision::{Capsules, CollisionError, Pair, Tree};

/// Every second fibre flies sideways at 10 m/s for 1 ms, through a dozen of the others.
#[test]
fn no_fiber_tunnels_through_a_bundle() {
    let scene = scenes::wavy(36);
    let mut positions = scene.positions.clone();
    for fiber in (0..36).step_by(2) {
        for p in &mut positions[scene.layout.node_range(fiber)] {
            *p += Vector3::new(0.6, 0.8, 0.0) * 10.0 * 1e-3;
        }
    }
    let start = scene.capsules().expect("valid");
    let end = Capsules::new(&scene.layout, &positions, &scene.radii).expect("valid");
    let mut tree = Tree::new(&start, 0.0).expect("valid");
    let mut pairs = Vec::new();
    tree.refit_swept(&start, &end, 0.0).expect("the same segments");
    tree.pairs(&mut pairs);
    pairs.sort_unstable();
    let mut found = Vec::new();
    impacts([&start, &end], &pairs, 0.0, 1e-8, &mut found).expect("the same segments");

    let count = u32::try_from(start.len()).expect("few");
    let free = |pair: &Pair| !start.adjacent(pair[0] as usize, pair[1] as usize);
    let all: Vec<Pair> =
        (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j])).filter(free).collect();
    let mut expected = Vec::new();
    impacts([&start, &end], &all, 0.0, 1e-8, &mut expected).expect("the same segments");
    assert!(found == expected);

    // Nearly all of these are apart before and after.
    let tunneled = found.iter().filter(|([i, j], _)| {
        [&start, &end].iter().all(|frame| {
            let (a, b) = (frame.get(*i as usize), frame.get(*j as usize));
            a.closest(&b).distance() > a.radius + b.radius
        })
    });
    let tunneled = tunneled.count();
    assert!(tunneled > 1000 && tunneled > found.len() * 9 / 10, "{tunneled} of {}", found.len());
}

#[test]
fn the_end_of_a_step_must_have_the_same_fibers() {
    let (scene, other) = (scenes::wavy(2), scenes::wavy(3));
    let (start, end) = (scene.capsules().expect("valid"), other.capsules().expect("valid"));
    let refused = impacts([&start, &end], &[], 0.0, 1e-8, &mut Vec::new());
    let expected = CollisionError::Count { what: "segments", given: 300, needed: 200 };
    assert_eq!(refused, Err(expected));
}
