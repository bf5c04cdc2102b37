//! Roots that are moved to the nearest point of a scalp.

use crate::common::{files, frame, read};
use nalgebra::Point3;
use proptest::prelude::*;
use rapunzel_collision::field::{Soup, SurfaceTree, shapes};
use rapunzel_strands::StrandsError;

/// Nearest point of all triangles, by trying each.
fn nearest(soup: &Soup, point: &Point3<f64>) -> f64 {
    let distance = |triangle: &[u32; 3]| {
        let alone = Soup { vertices: soup.vertices.clone(), triangles: vec![*triangle] };
        SurfaceTree::new(&alone).expect("a triangle").nearest(point).distance
    };
    soup.triangles.iter().map(distance).fold(f64::INFINITY, f64::min)
}

proptest! {
    /// Strands are moved as they are, onto the scalp.
    #[test]
    fn strands_keep_their_shape(frame in frame()) {
        let soup = shapes::sphere(0.1, 3);
        let scalp = SurfaceTree::new(&soup).expect("a surface");
        let before = read(&files(&frame)[0].2).strands;
        let mut after = before.clone();
        let moved = after.snap(&scalp, f64::INFINITY).expect("a distance");
        prop_assert!(moved.far.is_empty() && moved.mean <= moved.largest);
        let mut largest = 0.0_f64;
        for k in 0..before.len() {
            let (old, new) = (before.strand(k), after.strand(k));
            prop_assert!(nearest(&soup, &new[0]) < 1e-15);
            let way = new[0] - old[0];
            largest = largest.max(way.norm());
            prop_assert!((way.norm() - nearest(&soup, &old[0])).abs() < 1e-15);
            prop_assert!(old.iter().zip(new).all(|(a, b)| (b - a - way).norm() < 1e-15));
        }
        prop_assert_eq!(moved.largest, largest);
        // Nothing is left to be done.
        let again = after.snap(&scalp, f64::INFINITY).expect("a distance");
        prop_assert!(again.largest < 1e-15);
    }
}

#[test]
fn strands_far_from_the_scalp_stay_and_are_listed() {
    let text = "v 0 0.11 0\nv 0 0.2 0\nv 0.5 0 0\nv 0.6 0 0\nl 1 2\nl 3 4\n";
    let before = read(text.as_bytes()).strands;
    let scalp = SurfaceTree::new(&shapes::sphere(0.1, 3)).expect("a surface");
    let mut after = before.clone();
    let moved = after.snap(&scalp, 0.02).expect("a distance");
    assert_eq!(moved.far, [1]);
    assert_eq!(after.strand(1), before.strand(1));
    assert!((moved.largest - 0.01).abs() < 1e-3 && moved.mean == moved.largest);
    for most in [-1.0, f64::NAN] {
        assert!(matches!(after.snap(&scalp, most), Err(StrandsError::Option { .. })));
    }
}
