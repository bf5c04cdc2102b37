//! A real hairstyle, where the data is: no pair of the sweep is missed.

use nalgebra::Point3;
use rapunzel_collision::{Candidates, Capsules, Tree, contacts};
use rapunzel_fiber::Layout;

/// Strands of equal segment counts in Cem Yuksel's format with default segments and thickness, m.
fn strands(bytes: &[u8]) -> (Layout, Vec<Point3<f64>>, f64) {
    let word = |at: usize| -> [u8; 4] { bytes[at..at + 4].try_into().expect("four bytes") };
    let number = |at: usize| u32::from_le_bytes(word(at)) as usize;
    let single = |at: usize| f64::from(f32::from_le_bytes(word(at)));
    assert!(&bytes[..4] == b"HAIR" && number(12) == 2, "points alone after the header");
    let layout = Layout::new(std::iter::repeat_n(number(16), number(4)));
    let coordinate = |k: usize| single(128 + 4 * k);
    let point = |p: usize| Point3::from([0, 1, 2].map(|d| coordinate(3 * p + d)));
    (layout, (0..number(8)).map(point).collect(), 0.5 * single(20))
}

#[test]
fn no_pair_of_a_ponytail_is_missed() {
    let Some(folder) = rapunzel_oracles::data("strands_ponytail") else { return };
    let bytes = std::fs::read(folder.join("ponytail.hair")).expect("readable");
    let (layout, positions, radius) = strands(&bytes);
    assert_eq!((layout.fibers(), layout.segments()), (4933, 73_995));
    let radii = vec![radius; layout.segments()];
    let capsules = Capsules::new(&layout, &positions, &radii).expect("valid");
    let mut found = Vec::new();
    Tree::new(&capsules, 0.0).expect("valid").pairs(&mut found);
    found.sort_unstable();
    let expected = crate::common::box_pairs(&capsules);
    assert!(expected.len() > 190_000, "{}", expected.len());
    assert!(expected.iter().all(|pair| found.binary_search(pair).is_ok()));
    // Boxes are rounded outward by a unit in the last place of a coordinate below 0.5 m.
    let wide: Vec<_> = radii.iter().map(|r| r + 3e-8).collect();
    let wide = Capsules::new(&layout, &positions, &wide).expect("valid");
    let allowed = crate::common::box_pairs(&wide);
    assert!(found.iter().all(|pair| allowed.binary_search(pair).is_ok()));
    let (mut touching, mut listed) = (Vec::new(), Vec::new());
    contacts(&capsules, &expected, 0.0, &mut touching).expect("valid");
    let mut list = Candidates::new(0.0, 1e-3).expect("valid");
    list.contacts(&capsules, &mut listed).expect("valid");
    listed.sort_by_key(|contact| contact.pair);
    assert!(!touching.is_empty() && listed == touching);
}
