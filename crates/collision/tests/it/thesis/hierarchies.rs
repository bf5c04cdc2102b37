//! Every tree, whatever its volumes and however it was updated, finds exactly what brute force
//! does.

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rapunzel_collision::thesis::hierarchy::{
    Hierarchy, HierarchyKind, SearchResult, Variant, VolumeTree,
};
use rapunzel_collision::thesis::scenes::{self, MovingFibers};
use rapunzel_collision::thesis::volume::{Aabb, BoundingVolume, Directions, Dop, Sphere};
use rapunzel_collision::{Capsules, CollisionError, Pair};
use rapunzel_fiber::Layout;
use std::sync::LazyLock;

static DIRECTIONS: LazyLock<Directions> = LazyLock::new(|| Directions::new(12).expect("valid"));
static VARIANTS: LazyLock<[Variant; 10]> = LazyLock::new(|| Variant::all(&DIRECTIONS));

fn touch(a: &Capsules, i: usize, b: &Capsules, j: usize) -> bool {
    let (a, b) = (a.get(i), b.get(j));
    a.closest(&b).distance() <= a.radius + b.radius
}

/// All touching pairs, sorted: by brute force.
fn pairs(c: &Capsules) -> Vec<Pair> {
    let all = (0..c.len()).flat_map(|i| (i + 1..c.len()).map(move |j| (i, j)));
    let touching = all.filter(|&(i, j)| !c.adjacent(i, j) && touch(c, i, c, j));
    touching.map(|(i, j)| crate::common::pair(i, j)).collect()
}

fn sorted(found: Result<SearchResult, CollisionError>) -> Vec<Pair> {
    let mut pairs = found.expect("valid").pairs;
    pairs.sort_unstable();
    pairs
}

/// The search for all and for the first agree with `expected`.
fn finds(tree: &dyn Hierarchy, c: &Capsules, expected: &[Pair], case: &str) {
    assert_eq!(sorted(tree.all(c)), expected, "{case}");
    let first = tree.first(c).expect("valid").pairs;
    assert_eq!(first.len(), expected.len().min(1), "{case}");
    assert!(first.iter().all(|pair| expected.binary_search(pair).is_ok()), "{case}");
}

/// Every variant built at one moment finds the pairs there, and at the next after an update, after
/// another update that changes nothing, after one back, and after a rebuild.
fn all_variants_find(now: &MovingFibers, later: &MovingFibers, pairs: fn(&Capsules) -> Vec<Pair>) {
    let (now, later) = (now.capsules().expect("valid"), later.capsules().expect("valid"));
    let (expected, expected_later) = (pairs(&now), pairs(&later));
    for variant in VARIANTS.iter() {
        let name = variant.name();
        let mut tree = variant.build(&now);
        finds(&*tree, &now, &expected, &format!("{name} built"));
        tree.update(&later).expect("valid");
        finds(&*tree, &later, &expected_later, &format!("{name} updated"));
        tree.update(&later).expect("valid");
        finds(&*tree, &later, &expected_later, &format!("{name} updated again"));
        tree.update(&now).expect("valid");
        finds(&*tree, &now, &expected, &format!("{name} updated back"));
        tree.rebuild(&later);
        finds(&*tree, &later, &expected_later, &format!("{name} rebuilt"));
    }
}

/// Coordinates that often coincide: segments are points, parallel, collinear, coincide, or touch in
/// their ends; coordinates and radii are halves, so that they often touch exactly.
fn arrangement() -> impl Strategy<Value = MovingFibers> {
    prop::collection::vec(1..7_usize, 1..7).prop_flat_map(|counts| {
        let layout = Layout::new(counts);
        let x = || prop_oneof![(-3..=3_i8).prop_map(|x| 0.5 * f64::from(x)), -2.0..2.0_f64];
        let vector = || prop::array::uniform3(x()).prop_map(Vector3::from);
        let radius = prop_oneof![Just(0.25), Just(0.5), 1e-3..0.3_f64];
        let positions = prop::collection::vec(vector().prop_map(Point3::from), layout.nodes());
        let displacements = prop::collection::vec(vector(), layout.nodes());
        let radii = prop::collection::vec(radius, layout.segments());
        (positions, displacements, radii).prop_map(move |(positions, displacements, radii)| {
            MovingFibers { layout: layout.clone(), positions, displacements, radii }
        })
    })
}

/// Two segments that touch in their ends to a rounding, which depends on which is the first.
#[test]
fn touching_to_a_rounding_is_told_alike() {
    let one = [[0.0, 0.0, 1.4336539042937948], [-0.5, -1.5, 1.0]];
    let other = [[0.0, 0.0, -1.6567371324610318], [-0.5, -1.5, 0.0]];
    for (a, b) in [(one, other), (other, one)] {
        let positions: Vec<Point3<f64>> = [a, b].concat().into_iter().map(Point3::from).collect();
        let scene = MovingFibers {
            layout: Layout::new([1, 1]),
            displacements: vec![Vector3::zeros(); positions.len()],
            positions,
            radii: vec![0.5; 2],
        };
        all_variants_find(&scene, &scene, pairs);
    }
}

proptest! {
    #[test]
    fn trees_find_what_brute_force_does(scene in arrangement(), steps in 0.0..1.0_f64) {
        all_variants_find(&scene, &scene.advanced(steps), pairs);
    }

    #[test]
    fn two_trees_find_what_brute_force_does(a in arrangement(), b in arrangement()) {
        let (a, b) = (a.capsules().expect("valid"), b.capsules().expect("valid"));
        let all = (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| (i, j)));
        let touching = all.filter(|&(i, j)| touch(&a, i, &b, j));
        let expected: Vec<Pair> = touching.map(|(i, j)| crate::common::pair(i, j)).collect();
        for variant in VARIANTS.iter() {
            let (first, second) = (variant.build(&a), variant.build(&b));
            let found = sorted(first.between(&a, &*second, &b));
            prop_assert_eq!(&found, &expected, "{}", variant.name());
        }
    }

    /// Lemma 7.3.1: with fixed face normals, layered volumes are those around the segments.
    #[test]
    fn layered_boxes_are_wrapped(scene in arrangement()) {
        fn check<V: BoundingVolume + PartialEq + std::fmt::Debug>(shared: V::Shared, c: &Capsules) {
            let layered = VolumeTree::<V>::new(HierarchyKind::Layered, shared.clone(), c);
            let wrapped = VolumeTree::<V>::new(HierarchyKind::Wrapped, shared.clone(), c);
            assert_eq!(layered.volumes(), wrapped.volumes());
            for (volume, segments) in layered.volumes().iter().zip(layered.segments()) {
                assert_eq!(*volume, V::wrap(&shared, segments.iter().map(|&s| c.get(s as usize))));
            }
        }
        let capsules = scene.capsules().expect("valid");
        check::<Aabb>((), &capsules);
        check::<Dop>(DIRECTIONS.clone(), &capsules);
    }

    /// Guibas et al. 2002: layers cost at most the square root of their number.
    #[test]
    fn layered_spheres_are_not_much_larger(scene in arrangement()) {
        let capsules = scene.capsules().expect("valid");
        let root = |kind| VolumeTree::<Sphere>::new(kind, (), &capsules).volumes()[0].radius();
        let height = (capsules.len() as f64).log2().ceil();
        let (layered, wrapped) = (root(HierarchyKind::Layered), root(HierarchyKind::Wrapped));
        prop_assert!(layered <= (height + 1.0).sqrt() * wrapped * (1.0 + 1e-12));
        prop_assert!(wrapped <= layered * (1.0 + 1e-12));
    }
}

/// Pairs that touch among those whose boxes overlap, by the sweep.
fn swept(c: &Capsules) -> Vec<Pair> {
    let mut pairs = crate::common::box_pairs(c);
    pairs.retain(|&[i, j]| touch(c, i as usize, c, j as usize));
    pairs
}

#[test]
fn wavy_fibers() {
    let scene = scenes::wavy(60);
    all_variants_find(&scene, &scene.advanced(10.0), swept);
}

#[test]
fn clumped_fibers() {
    let scene = scenes::clump(60);
    all_variants_find(&scene, &scene.advanced(10.0), swept);
}

/// The models of the thesis with thicker fibers, and all of their nodes shaken by a millimeter. By
/// brute force: some fibers touch so exactly that boxes that are not enlarged just miss each other.
#[test]
fn test_models() {
    let models = [
        scenes::bundle(25, 20),
        scenes::lock(25, 40),
        scenes::cloth(10, 50),
        scenes::ball(20, 37),
        scenes::soup(120, 20),
    ];
    for mut scene in models {
        scene.radii.iter_mut().for_each(|r| *r *= 4.0);
        for (node, d) in (0..).zip(&mut scene.displacements) {
            *d = 1e-3 * Vector3::new(1.0, 1.7, 2.3).map(|rate| (rate * f64::from(node)).sin());
        }
        let later = scene.advanced(1.0);
        assert!(pairs(&later.capsules().expect("valid")).len() > 20);
        all_variants_find(&scene, &later, pairs);
    }
}

#[test]
fn fibers_that_bend_to_a_loop() {
    for spread in [0.05, 3.0] {
        let at = |bend| scenes::looping(30, 50, bend, spread);
        all_variants_find(&at(0.1), &at(0.8), swept);
    }
}

#[test]
fn the_scenes_of_peers_have_the_published_pairs() {
    for (scene, expected) in [(scenes::wavy(1000), 9827), (scenes::clump(1000), 26_181)] {
        let capsules = scene.capsules().expect("valid");
        for variant in [Variant::As, Variant::Al] {
            let found = variant.build(&capsules).all(&capsules).expect("valid");
            assert_eq!(found.pairs.len(), expected, "{}", variant.name());
        }
    }
}

#[test]
fn coinciding_and_single_segments() {
    for segments in [1, 2, 3, 40] {
        let point = MovingFibers {
            layout: Layout::new(std::iter::repeat_n(1, segments)),
            positions: vec![Point3::new(1.0, 2.0, 3.0); 2 * segments],
            displacements: vec![Vector3::zeros(); 2 * segments],
            radii: vec![1e-3; segments],
        };
        all_variants_find(&point, &point, pairs);
    }
}

/// Segments that shrink by half each make the deepest spatial trees.
#[test]
fn geometric_progressions() {
    let at = |k: i32| Point3::new(0.5_f64.powi(k), 0.0, 0.0);
    let scene = MovingFibers {
        layout: Layout::new([400]),
        positions: (0..=400).map(at).collect(),
        displacements: vec![Vector3::zeros(); 401],
        radii: (0..400).map(|k| 0.5_f64.powi(k + 3)).collect(),
    };
    all_variants_find(&scene, &scene, pairs);
}

#[test]
fn positions_so_far_that_lengths_overflow_are_searched() {
    let far = |s: f64| Point3::new(s * 1e308, -s * 1e308, s * 1e308);
    let scene = MovingFibers {
        layout: Layout::new([3, 2]),
        positions: vec![
            far(1.0),
            far(-1.0),
            far(1.0),
            Point3::origin(),
            far(1.0),
            far(0.5),
            far(-1.0),
        ],
        displacements: vec![Vector3::zeros(); 7],
        radii: vec![1.0; 5],
    };
    all_variants_find(&scene, &scene, pairs);
}

#[test]
fn trees_refuse_what_they_were_not_built_for() {
    let (few, many) = (scenes::wavy(2), scenes::wavy(3));
    let (few, many) = (few.capsules().expect("valid"), many.capsules().expect("valid"));
    let refused = Some(CollisionError::Count { what: "segments", given: 300, needed: 200 });
    for variant in VARIANTS.iter() {
        let mut tree = variant.build(&few);
        assert_eq!(tree.update(&many).err(), refused);
        assert_eq!(tree.all(&many).err(), refused);
        assert_eq!(tree.first(&many).err(), refused);
        assert_eq!(tree.between(&many, &*variant.build(&few), &few).err(), refused);
        tree.rebuild(&many);
        assert!(tree.all(&many).is_ok());
    }
    let other = Variant::Dl(Directions::new(8).expect("valid")).build(&few);
    let refused = VARIANTS[7].build(&few).between(&few, &*other, &few).expect_err("refused");
    assert_eq!(refused, CollisionError::Volumes);
    let refused = VARIANTS[0].build(&few).between(&few, &*other, &few).expect_err("refused");
    assert_eq!(refused, CollisionError::Volumes);
}

/// Levels from the root to the leaves, and volumes that shrink on the way.
#[test]
fn mean_volumes_are_by_level() {
    let scene = scenes::wavy(16);
    let capsules = scene.capsules().expect("valid");
    for variant in VARIANTS.iter() {
        let volumes = variant.build(&capsules).mean_volumes();
        assert!(volumes.len() >= 12, "{}", variant.name());
        assert!(volumes[0] > 100.0 * volumes[volumes.len() - 1], "{}", variant.name());
    }
}
