//! The tree and the candidate lists find what a sweep and brute force find.

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rapunzel_collision::thesis::scenes::{self, MovingFibers};
use rapunzel_collision::{
    Candidates, CapsuleContact, Capsules, CollisionError, Pair, Tree, Update, contacts,
};
use rapunzel_fiber::Layout;

fn sorted(mut pairs: Vec<Pair>) -> Vec<Pair> {
    pairs.sort_unstable();
    pairs
}

fn pairs(tree: &mut Tree) -> Vec<Pair> {
    let mut pairs = Vec::new();
    tree.pairs(&mut pairs);
    sorted(pairs)
}

/// Exactly the pairs of the sweep, new and after a step.
fn agrees(scene: &MovingFibers) {
    let moved = scene.advanced(1.0);
    let (start, end) = (scene.capsules().expect("valid"), moved.capsules().expect("valid"));
    let mut tree = Tree::new(&start, 0.0).expect("valid");
    assert!(pairs(&mut tree) == crate::common::box_pairs(&start));
    tree.refit(&end, 0.0).expect("the same segments");
    assert!(pairs(&mut tree) == crate::common::box_pairs(&end));
    let mut anew = Tree::new(&end, 0.0).expect("valid");
    assert!(pairs(&mut anew) == crate::common::box_pairs(&end));
}

#[test]
fn the_tree_finds_the_pairs_of_the_scenes() {
    agrees(&scenes::wavy(1000));
    agrees(&scenes::clump(1000));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let scene = scenes::clump(300);
    let capsules = scene.capsules().expect("valid");
    let moved = scene.advanced(4.0);
    let moved = moved.capsules().expect("valid");
    let search = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut tree = Tree::new(&capsules, 1e-4).expect("valid");
            let (mut first, mut second, mut touching) = (Vec::new(), Vec::new(), Vec::new());
            tree.pairs(&mut first);
            tree.refit(&moved, 1e-4).expect("the same segments");
            tree.pairs(&mut second);
            contacts(&moved, &second, 0.0, &mut touching).expect("valid");
            let mut list = Candidates::new(0.0, 1e-4).expect("valid");
            let mut listed = Vec::new();
            for capsules in [&capsules, &moved] {
                list.contacts(capsules, &mut listed).expect("the same segments");
            }
            (first, second, touching, list.pairs().to_vec(), listed)
        })
    };
    let one = search(1);
    assert!(one.2.len() > 1000 && one == search(2) && one == search(3));
}

/// Fibres of up to four segments among few distinct places, so that many segments are points,
/// parallel, collinear, coincident, or touch at their ends.
fn soup() -> impl Strategy<Value = (Layout, Vec<Point3<f64>>, Vec<f64>)> {
    let fiber = (1..=4_usize, 0..64_u64);
    let x = prop_oneof![(-3..=3_i8).prop_map(f64::from), -3.0..3.0_f64];
    prop::collection::vec(fiber, 1..60).prop_flat_map(move |fibers| {
        let layout = Layout::new(fibers.iter().map(|f| f.0));
        let points = prop::array::uniform3(x.clone()).prop_map(Point3::from);
        let radius = prop_oneof![Just(0.5), 1e-3..0.7_f64];
        let positions = prop::collection::vec(points, layout.nodes());
        let radii = prop::collection::vec(radius, layout.segments());
        (Just(layout), positions, radii)
    })
}

fn displaced(positions: &[Point3<f64>], step: &[[f64; 3]], scale: f64) -> Vec<Point3<f64>> {
    let step = step.iter().cycle();
    positions.iter().zip(step).map(|(p, d)| p + scale * Vector3::from(*d)).collect()
}

/// All contacts of all pairs that are not adjacent.
fn all_contacts(capsules: &Capsules, reach: f64) -> Vec<CapsuleContact> {
    let count = u32::try_from(capsules.len()).expect("few");
    let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j]));
    let free = |pair: &Pair| !capsules.adjacent(pair[0] as usize, pair[1] as usize);
    let mut found = Vec::new();
    contacts(capsules, &pairs.filter(free).collect::<Vec<_>>(), reach, &mut found).expect("valid");
    found
}

proptest! {
    #[test]
    fn the_tree_misses_no_pair((layout, start, radii) in soup(), step in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..50)) {
        let capsules = Capsules::new(&layout, &start, &radii).expect("valid");
        let end = displaced(&start, &step, 0.5);
        let moved = Capsules::new(&layout, &end, &radii).expect("valid");
        // Coordinates and radii are below 8, so that boxes are rounded by less than this.
        let mut wide: Vec<f64> = radii.clone();
        wide.iter_mut().for_each(|r| *r += 1e-6);
        let mut tree = Tree::new(&capsules, 0.0).expect("valid");
        for capsules in [capsules, moved] {
            tree.refit(&capsules, 0.0).expect("the same segments");
            let found = pairs(&mut tree);
            prop_assert!(found.windows(2).all(|two| two[0] != two[1]), "a pair is found twice");
            let needed = crate::common::box_pairs(&capsules);
            prop_assert!(needed.iter().all(|pair| found.binary_search(pair).is_ok()));
            let wide = Capsules::new(&layout, capsules.positions(), &wide).expect("valid");
            let allowed = crate::common::box_pairs(&wide);
            prop_assert!(found.iter().all(|pair| allowed.binary_search(pair).is_ok()));
        }
    }

    #[test]
    fn candidates_miss_no_contact(
        (layout, start, radii) in soup(),
        steps in prop::collection::vec((prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..50), prop::array::uniform3(-1.0..1.0_f64)), 1..8),
        reach in 0.0..0.2_f64,
        margin in prop_oneof![Just(0.0), 0.0..1.0_f64],
    ) {
        let mut list = Candidates::new(reach, margin).expect("valid");
        let mut positions = start;
        for (apart, together) in steps {
            // All move together, by more than the margin, and apart by less or more.
            positions = displaced(&displaced(&positions, &apart, 0.1), &[together], 1.0);
            let capsules = Capsules::new(&layout, &positions, &radii).expect("valid");
            let mut found = Vec::new();
            list.contacts(&capsules, &mut found).expect("the same segments");
            found.sort_by_key(|contact| contact.pair);
            prop_assert_eq!(found, all_contacts(&capsules, reach));
        }
    }

    #[test]
    fn candidates_miss_no_contact_on_the_way(
        (layout, start, radii) in soup(),
        steps in prop::collection::vec((prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..50), 0.0..1.0_f64), 1..6),
        reach in 0.0..0.2_f64,
        margin in prop_oneof![Just(0.0), 0.0..1.0_f64],
    ) {
        let mut list = Candidates::new(reach, margin).expect("valid");
        let mut positions = start;
        for (ways, size) in steps {
            // By more than the margin, or by less; then to nearly the same place, all of that
            // farther on, one node elsewhere, or another as well, before and after the list is made
            // anew there, or less nearly.
            let next = displaced(&positions, &ways, size);
            let near = displaced(&next, &ways, 0.2 * margin);
            let mut turned = displaced(&near, &[[1.0, -0.5, 0.2]], size);
            let beyond = turned.clone();
            let node = turned.len() / 2;
            turned[node] = positions[0] + 0.5 * (positions[0] - turned[node]);
            let other = |next: &[Point3<f64>], node: usize| {
                let mut other = next.to_vec();
                other[node] = next[node] - 0.5 * (positions[0] - next[node]);
                other
            };
            let (first, last) = (other(&turned, 0), other(&turned, turned.len() - 1));
            let less = displaced(&next, &ways, margin);
            let ends = [next.clone(), near, beyond, turned, first, last, less];
            for (k, next) in ends.iter().enumerate() {
                let [start, end] = [&positions, next].map(|p| Capsules::new(&layout, p, &radii));
                let [start, end] = [start.expect("valid"), end.expect("valid")];
                if k == 5 {
                    list.update(&end).expect("the same segments");
                }
                let found = list.on_the_way(&start, &end).expect("the same segments");
                for ([a, b], squared) in &found {
                    let apart = start.get(*a as usize).closest(&start.get(*b as usize)).distance();
                    prop_assert!((squared.sqrt() - apart).abs() < 1e-6, "{squared} for {apart}");
                }
                let mut found: Vec<_> = found.iter().map(|(pair, _)| *pair).collect();
                found.sort_unstable();
                prop_assert!(found.windows(2).all(|two| two[0] != two[1]), "a pair is found twice");
                for time in [0.0, 0.2, 0.5, 0.9, 1.0] {
                    let between: Vec<_> =
                        positions.iter().zip(next).map(|(a, b)| a + time * (b - a)).collect();
                    let capsules = Capsules::new(&layout, &between, &radii).expect("valid");
                    for contact in all_contacts(&capsules, reach) {
                        prop_assert!(found.binary_search(&contact.pair).is_ok(), "{:?}", contact);
                    }
                }
            }
            positions = next;
        }
    }
}

#[test]
fn a_list_is_kept_while_fibers_move_together() {
    let scene = scenes::wavy(100);
    let mut list = Candidates::new(0.0, 2e-4).expect("valid");
    let first = list.update(&scene.capsules().expect("valid"));
    assert_eq!(first, Ok(Update::Rebuilt));
    // A decimetre, five hundred margins.
    let mut far = scene.clone();
    far.positions.iter_mut().for_each(|p| p.x += 0.1);
    assert_eq!(list.update(&far.capsules().expect("valid")), Ok(Update::Kept));
    // Neighbours separate by up to a third of a tenth of a millimetre a step.
    let later = scene.advanced(20.0);
    assert_eq!(list.update(&later.capsules().expect("valid")), Ok(Update::Refitted));
}

#[test]
fn a_worn_tree_is_built_anew() {
    let scene = scenes::wavy(100);
    let mut list = Candidates::new(0.0, 2e-4).expect("valid");
    list.update(&scene.capsules().expect("valid")).expect("valid");
    // Every other fibre goes elsewhere: the regions tear.
    let mut torn = scene.clone();
    for fiber in (0..100).step_by(2) {
        let nodes = torn.layout.node_range(fiber);
        torn.positions[nodes].iter_mut().for_each(|p| p.x += 1.0);
    }
    assert_eq!(list.update(&torn.capsules().expect("valid")), Ok(Update::Rebuilt));
    let mut found = Vec::new();
    list.contacts(&torn.capsules().expect("valid"), &mut found).expect("valid");
    let mut tree = Tree::new(&torn.capsules().expect("valid"), 0.0).expect("valid");
    let mut expected = Vec::new();
    contacts(&torn.capsules().expect("valid"), &pairs(&mut tree), 0.0, &mut expected)
        .expect("valid");
    found.sort_by_key(|contact| contact.pair);
    assert!(!expected.is_empty() && found == expected);
}

#[test]
fn coincident_segments_all_meet() {
    let (count, two) = (300, [Point3::origin(), Point3::new(0.0, 0.0, 1.0)]);
    let layout = Layout::new(std::iter::repeat_n(1, count));
    let positions: Vec<_> = two.into_iter().cycle().take(2 * count).collect();
    let capsules = Capsules::new(&layout, &positions, &[0.1; 300]).expect("valid");
    let mut tree = Tree::new(&capsules, 0.0).expect("valid");
    assert_eq!(pairs(&mut tree).len(), count * (count - 1) / 2);
}

#[test]
fn places_that_single_precision_cannot_hold_are_searched_too() {
    let far = [1e300, -1e300, 1e300, -1e300].map(|x| Point3::new(x, 1e-300, 0.0));
    let layout = Layout::new([1, 1]);
    let capsules = Capsules::new(&layout, &far, &[1.0; 2]).expect("valid");
    let mut tree = Tree::new(&capsules, 0.0).expect("valid");
    assert_eq!(pairs(&mut tree), [[0, 1]]);
}

#[test]
fn another_number_of_segments_is_refused() {
    let (scene, other) = (scenes::wavy(4), scenes::wavy(5));
    let (small, large) = (scene.capsules().expect("valid"), other.capsules().expect("valid"));
    let expected = CollisionError::Count { what: "segments", given: 500, needed: 400 };
    assert_eq!(Tree::new(&small, 0.0).expect("valid").refit(&large, 0.0), Err(expected.clone()));
    let mut list = Candidates::new(0.0, 0.0).expect("valid");
    list.update(&small).expect("valid");
    assert_eq!(list.update(&large), Err(expected));
    // As many segments, but fewer fibres.
    let layout = Layout::new([200, 100, 100]);
    let joined = Capsules::new(&layout, &scene.positions[1..], &scene.radii).expect("valid");
    let expected = CollisionError::Count { what: "nodes", given: 403, needed: 404 };
    assert_eq!(list.update(&joined), Err(expected));
}

#[test]
fn lengths_that_are_none_are_refused() {
    let scene = scenes::wavy(2);
    let capsules = scene.capsules().expect("valid");
    let mut tree = Tree::new(&capsules, 0.0).expect("valid");
    for bad in [-1e-9, f64::NAN, f64::INFINITY] {
        let refused = |result: Result<(), CollisionError>| matches!(result, Err(CollisionError::Length { value, .. }) if value.to_bits() == bad.to_bits());
        assert!(refused(Tree::new(&capsules, bad).map(drop)));
        assert!(refused(tree.refit(&capsules, bad)));
        assert!(refused(tree.refit_swept(&capsules, &capsules, bad)));
        assert!(refused(Candidates::new(bad, 0.0).map(drop)));
        assert!(refused(Candidates::new(0.0, bad).map(drop)));
        assert!(refused(contacts(&capsules, &[], bad, &mut Vec::new())));
    }
}

proptest! {
    /// Pairs that meet at any time are among those whose swept boxes meet.
    #[test]
    fn swept_boxes_hold_what_is_between(
        (layout, start, radii) in soup(),
        step in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 1..50),
        time in 0.0..=1.0_f64,
    ) {
        let end = displaced(&start, &step, 1.0);
        let between: Vec<_> = start.iter().zip(&end).map(|(p, q)| p + time * (q - p)).collect();
        let at = |positions| Capsules::new(&layout, positions, &radii).expect("valid");
        let (start, between, end) = (at(&start), at(&between), at(&end));
        let mut tree = Tree::new(&start, 0.0).expect("valid");
        tree.refit_swept(&start, &end, 1e-12).expect("the same segments");
        let found = pairs(&mut tree);
        let needed = crate::common::box_pairs(&between);
        prop_assert!(needed.iter().all(|pair| found.binary_search(pair).is_ok()));
    }
}

/// Two bundles of several regions each: one goes far away, and comes back to the other's place.
#[test]
fn bundles_that_part_and_meet_again_are_found() {
    let one = scenes::wavy(36);
    let nodes = one.layout.nodes();
    let layout = Layout::new(std::iter::repeat_n(100, 72));
    let radii = vec![one.radii[0]; layout.segments()];
    let mut list = Candidates::new(0.0, 1e-3).expect("valid");
    for (away, update) in [(0.1, Update::Rebuilt), (1.0, Update::Kept), (0.0, Update::Refitted)] {
        let mut positions = [&one.positions[..], &one.positions[..]].concat();
        positions[nodes..].iter_mut().for_each(|p| p.y += away + 1e-5);
        let capsules = Capsules::new(&layout, &positions, &radii).expect("valid");
        let mut found = Vec::new();
        let made = list.contacts(&capsules, &mut found).expect("the same segments");
        assert!(made == update || (away == 0.0 && made == Update::Rebuilt), "{away}: {made:?}");
        found.sort_by_key(|contact| contact.pair);
        let mut tree = Tree::new(&capsules, 0.0).expect("valid");
        let mut expected = Vec::new();
        contacts(&capsules, &pairs(&mut tree), 0.0, &mut expected).expect("valid");
        assert!(found == expected, "{away}: {} of {}", found.len(), expected.len());
    }
}

fn offset() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(prop_oneof![4 => Just(0.0), 2 => Just(1.0), 1 => -1e-3..1e-3_f64])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Bundles of several regions each, which go far away from, back to and through each other.
    #[test]
    fn candidates_of_bundles_that_wander_miss_no_contact(
        offsets in prop::collection::vec(prop::array::uniform3(offset()), 2..7),
        apart in 0.0..3.0_f64,
        margin in prop_oneof![Just(0.0), 1e-5..3e-3_f64],
    ) {
        let one = scenes::wavy(9);
        let layout = Layout::new(std::iter::repeat_n(100, 27));
        let radii = vec![one.radii[0]; layout.segments()];
        let mut list = Candidates::new(0.0, margin).expect("valid");
        for (step, offsets) in (0_u8..).zip(&offsets) {
            let now = one.advanced(apart * f64::from(step));
            let positions: Vec<_> = offsets
                .iter()
                .flat_map(|offset| now.positions.iter().map(|p| p + Vector3::from(*offset)))
                .collect();
            let capsules = Capsules::new(&layout, &positions, &radii).expect("valid");
            let (mut found, mut expected) = (Vec::new(), Vec::new());
            list.contacts(&capsules, &mut found).expect("the same segments");
            contacts(&capsules, &crate::common::box_pairs(&capsules), 0.0, &mut expected).expect("valid");
            found.sort_by_key(|contact| contact.pair);
            prop_assert!(found == expected);
        }
    }
}
