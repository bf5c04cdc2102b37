//! Points where capsules touch or nearly do.

use super::batch::{Axes, BATCH, PairBatch};
use crate::capsules::length;
use crate::join::join;
use crate::{Capsules, CollisionError, Pair};
use nalgebra::{Unit, Vector3};
use pulp::{Arch, NullaryFnOnce};
use rapunzel_fiber::Layout;
use rayon::prelude::*;

/// Pairs that one thread looks at a time.
const CONTACT_CHUNK: usize = 4096;
/// Pairs whose contacts are looked at while they are at hand.
const FEW_PAIRS: usize = 4 * BATCH;

/// Two capsules that touch, or come close, at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CapsuleContact {
    /// The segments, the smaller index first.
    pub pair: Pair,
    /// Where along the axes of the two segments, each in 0..=1.
    pub fractions: [f64; 2],
    /// Direction from the first axis to the second (world).
    pub normal: Unit<Vector3<f64>>,
    /// Distance of the two surfaces, m; negative where they overlap.
    pub gap: f64,
}

impl CapsuleContact {
    /// Arc lengths of the point on both fibres, m, from those of all nodes (see
    /// [`node_arc_lengths`]).
    ///
    /// # Panics
    /// If a segment or node does not exist, as indexing does.
    #[must_use]
    pub fn arc_lengths(&self, layout: &Layout, nodes: &[f64]) -> [f64; 2] {
        [0, 1].map(|side| {
            let [a, b] = layout.segment_nodes(self.pair[side] as usize);
            nodes[a] + self.fractions[side] * (nodes[b] - nodes[a])
        })
    }
}

/// Arc length of every node from the root of its fibre, m.
#[must_use]
pub fn node_arc_lengths(capsules: &Capsules) -> Vec<f64> {
    let (layout, positions) = (capsules.layout(), capsules.positions());
    let mut lengths = vec![0.0; layout.nodes()];
    for [a, b] in (0..layout.segments()).map(|s| layout.segment_nodes(s)) {
        lengths[b] = lengths[a] + (positions[b] - positions[a]).norm();
    }
    lengths
}

/// All contacts with a gap of at most `reach`, m, among `pairs`; `contacts` is emptied first.
///
/// A pair touches where its axes are closest. Where these enclose less than 15 degrees, the ends of
/// where they lie side by side follow as contacts of their own, if they are elsewhere and in reach
/// too: a single point would jump from end to end. Contacts come in the order of the pairs,
/// whatever the number of threads.
///
/// # Errors
/// [`CollisionError::Length`] if the reach is negative or not finite.
///
/// # Panics
/// If a pair names a segment that does not exist, as indexing does.
pub fn contacts(
    capsules: &Capsules,
    pairs: &[Pair],
    reach: f64,
    contacts: &mut Vec<CapsuleContact>,
) -> Result<(), CollisionError> {
    length("reach", reach)?;
    let chunk = |pairs: &[Pair]| {
        let mut found = Vec::new();
        Arch::new().dispatch(Find { capsules, pairs, reach, found: &mut found });
        found
    };
    join(pairs.par_chunks(CONTACT_CHUNK).map(chunk).collect(), contacts);
    Ok(())
}

/// As [`contacts`], of pairs that come in groups, those in a row that are of the `same`: what has
/// been found of each, if anything, is given to `chosen`, which puts those behind a list that stay,
/// while they are at hand.
///
/// # Errors
/// [`CollisionError::Length`] if the reach is negative or not finite.
///
/// # Panics
/// If a pair names a segment that does not exist, as indexing does.
pub fn contacts_of_groups(
    capsules: &Capsules,
    pairs: &[Pair],
    reach: f64,
    same: impl Fn(&Pair, &Pair) -> bool + Sync,
    chosen: impl Fn(&[CapsuleContact], &mut Vec<CapsuleContact>) + Sync,
    contacts: &mut Vec<CapsuleContact>,
) -> Result<(), CollisionError> {
    length("reach", reach)?;
    let part = |pairs: &[Pair]| {
        let (mut found, mut stay) = (Vec::new(), Vec::new());
        for pairs in whole_groups(pairs, FEW_PAIRS, &same) {
            found.clear();
            Arch::new().dispatch(Find { capsules, pairs, reach, found: &mut found });
            let groups = found.chunk_by(|a, b| same(&a.pair, &b.pair));
            groups.for_each(|group| chosen(group, &mut stay));
        }
        stay
    };
    let parts: Vec<_> = whole_groups(pairs, CONTACT_CHUNK, &same).collect();
    join(parts.into_par_iter().map(part).collect(), contacts);
    Ok(())
}

/// Some groups together, of at least so many pairs.
fn whole_groups(
    pairs: &[Pair],
    count: usize,
    same: impl Fn(&Pair, &Pair) -> bool,
) -> impl Iterator<Item = &[Pair]> {
    let mut rest = pairs;
    std::iter::from_fn(move || {
        let last = rest.len().min(count).checked_sub(1)?;
        let in_group = rest[last..].windows(2).take_while(|two| same(&two[0], &two[1]));
        let (some, behind) = rest.split_at(last + 1 + in_group.count());
        rest = behind;
        Some(some)
    })
}

/// Puts the contacts of some pairs behind those found before.
struct Find<'a> {
    capsules: &'a Capsules<'a>,
    pairs: &'a [Pair],
    reach: f64,
    found: &'a mut Vec<CapsuleContact>,
}

impl NullaryFnOnce for Find<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { capsules, pairs, reach, found } = self;
        let (mut batch, mut radius) = (PairBatch::default(), [0.0; BATCH]);
        for pairs in pairs.chunks(BATCH) {
            batch.gather(capsules, pairs);
            batch.measure();
            for (radius, [first, _]) in radius.iter_mut().zip(pairs) {
                *radius = capsules.radii()[*first as usize];
            }
            batch.find_ends(&radius);
            for (k, &pair) in pairs.iter().enumerate() {
                let apart = pair.map(|s| capsules.radii()[s as usize]).iter().sum();
                // Squares may be off by roundings; the exact gap decides.
                let far = (apart + reach) * (1.0 + 1e-6);
                let [start, end] = &batch.ends;
                for places in [&batch.closest, start, end] {
                    if places.squared[k] <= far * far {
                        let fractions = places.fractions.each_ref().map(|along| along[k]);
                        let contact = contact(pair, &batch.axes(k), fractions, apart);
                        if contact.gap <= reach {
                            found.push(contact);
                        }
                    }
                }
            }
        }
    }
}

/// That of two axes at some place, whose surfaces are nearer by some lengths, m.
fn contact(pair: Pair, axes: &Axes, fractions: [f64; 2], apart: f64) -> CapsuleContact {
    let offset = Vector3::from(axes.offset(fractions));
    CapsuleContact { pair, fractions, normal: direction(offset, axes), gap: offset.norm() - apart }
}

/// Direction of `offset`; where that is zero, a direction across both axes.
fn direction(offset: Vector3<f64>, axes: &Axes) -> Unit<Vector3<f64>> {
    let unit = |v| Unit::try_new(v, f64::MIN_POSITIVE);
    let across = |d: Vector3<f64>| d.cross(&Vector3::ith(d.iamin(), 1.0));
    let other = || {
        let [d1, d2] = [axes.first, axes.second].map(Vector3::from);
        [d1.cross(&d2), across(d1), across(d2)].into_iter().find_map(unit)
    };
    unit(offset).or_else(other).unwrap_or_else(Vector3::z_axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Capsule;
    use nalgebra::{Point3, point};
    use proptest::prelude::*;

    const RADIUS: f64 = 0.1;

    /// Contacts of two fibres of one segment each.
    fn touch(points: [Point3<f64>; 4], reach: f64) -> Vec<CapsuleContact> {
        let layout = Layout::new([1, 1]);
        let capsules = Capsules::new(&layout, &points, &[RADIUS; 2]).expect("valid");
        let mut found = Vec::new();
        contacts(&capsules, &[[0, 1]], reach, &mut found).expect("a reach");
        found
    }

    #[test]
    fn crossed_fibers_touch_in_one_point() {
        let crossed = |z| {
            [
                point![-1.0, 0.0, 0.0],
                point![1.0, 0.0, 0.0],
                point![0.5, -1.0, z],
                point![0.5, 3.0, z],
            ]
        };
        let [contact] = touch(crossed(0.15), 0.0)[..] else { panic!("one contact") };
        assert_eq!((contact.pair, contact.fractions), ([0, 1], [0.75, 0.25]));
        assert_eq!(contact.normal, Vector3::z_axis());
        assert!((contact.gap + 0.05).abs() < 1e-15);
        assert_eq!(touch(crossed(0.25), 0.0), []);
        assert_eq!(touch(crossed(0.25), 0.06).len(), 1);
    }

    #[test]
    fn parallel_fibers_touch_at_both_ends_of_their_overlap() {
        for slope in [0.0, 1e-9, -1e-9, 0.01] {
            let points = [
                point![0.0, 0.0, 0.0],
                point![2.0, 0.0, 0.0],
                point![0.5, 0.19, 0.0],
                point![3.0, 0.19 + slope, 0.0],
            ];
            let mut found = touch(points, 0.01);
            found.sort_by(|a, b| a.fractions[0].total_cmp(&b.fractions[0]));
            let [root, tip] = found[..] else { panic!("two contacts with a slope of {slope}") };
            assert!((root.fractions[0] - 0.25).abs() < 1e-3 && root.fractions[1].abs() < 1e-3);
            assert!((tip.fractions[0] - 1.0).abs() < 1e-3 && (tip.fractions[1] - 0.6).abs() < 1e-3);
        }
    }

    /// Of two groups that no part of the work holds whole the first contact of each stays, and of
    /// all that stay the order is that of the pairs.
    #[test]
    fn groups_are_chosen_from_whole() {
        let layout = Layout::new([1, 1, 1]);
        let z = |x: f64, z: f64| point![x, 0.0, z];
        let across = |x: f64| [point![x, -1.0, 0.15], point![x, 1.0, 0.15]];
        let points = [[z(-1.0, 0.0), z(1.0, 0.0)], across(0.5), across(-0.5)].concat();
        let capsules = Capsules::new(&layout, &points, &[RADIUS; 3]).expect("valid");
        let sizes = [3 * CONTACT_CHUNK / 2, 1, 2 * CONTACT_CHUNK];
        let pairs: Vec<Pair> = [[0, 1], [0, 2], [0, 1]]
            .into_iter()
            .zip(sizes)
            .flat_map(|(pair, size)| std::iter::repeat_n(pair, size))
            .collect();
        let mut found = Vec::new();
        let first = |group: &[CapsuleContact], stay: &mut Vec<CapsuleContact>| {
            assert!(sizes.contains(&group.len()), "{}", group.len());
            stay.push(group[0]);
        };
        contacts_of_groups(&capsules, &pairs, 0.0, |a, b| a == b, first, &mut found)
            .expect("a reach");
        let pairs: Vec<_> = found.iter().map(|contact| contact.pair).collect();
        assert_eq!(pairs, [[0, 1], [0, 2], [0, 1]]);
        contacts_of_groups(&capsules, &[], 0.0, |a, b| a == b, first, &mut found).expect("none");
        assert_eq!(found, []);
    }

    #[test]
    fn arc_lengths_run_from_the_root() {
        let layout = Layout::new([2, 1]);
        let z = |z| point![0.0, 0.0, z];
        let points = [z(0.0), z(2.0), z(5.0), point![-1.0, 0.05, 4.0], point![1.0, 0.05, 4.0]];
        let capsules = Capsules::new(&layout, &points, &[RADIUS; 3]).expect("valid");
        let mut found = Vec::new();
        contacts(&capsules, &[[0, 2], [1, 2]], 0.0, &mut found).expect("a reach");
        let nodes = node_arc_lengths(&capsules);
        assert_eq!(nodes, [0.0, 2.0, 5.0, 0.0, 2.0]);
        let [contact] = found[..] else { panic!("one contact") };
        let [s, t] = contact.arc_lengths(&layout, &nodes);
        assert!((s - 4.0).abs() < 1e-12 && (t - 1.0).abs() < 1e-12);
    }

    proptest! {
        /// Also where axes coincide, cross, or are points.
        #[test]
        fn normals_are_units_and_gaps_are_those_of_the_points(
            x in prop::array::uniform4(prop::array::uniform3(prop_oneof![(-1..=1_i8).prop_map(f64::from), -1.0..1.0]))
        ) {
            let points = x.map(Point3::from);
            for contact in touch(points, 10.0) {
                prop_assert!((contact.normal.norm() - 1.0).abs() < 1e-14);
                let [s, t] = contact.fractions;
                let a = Capsule { start: points[0], end: points[1], radius: RADIUS };
                let b = Capsule { start: points[2], end: points[3], radius: RADIUS };
                let offset = b.at(t) - a.at(s);
                prop_assert!((offset.norm() - 2.0 * RADIUS - contact.gap).abs() < 1e-14);
                prop_assert!((offset - offset.norm() * contact.normal.into_inner()).norm() < 1e-14);
            }
        }

        /// Of many pairs at a time, nearly parallel or not, contacts are those of each.
        #[test]
        fn contacts_of_many_pairs_are_those_of_each(
            x in prop::collection::vec(prop::array::uniform3(prop_oneof![(-1..=1_i8).prop_map(f64::from), -1.0..1.0]), 4..40),
        ) {
            let count = x.len() / 2;
            let layout = Layout::new(std::iter::repeat_n(1, count));
            let points: Vec<_> = x[..2 * count].iter().copied().map(Point3::from).collect();
            let radii = vec![RADIUS; count];
            let capsules = Capsules::new(&layout, &points, &radii).expect("valid");
            let pairs: Vec<Pair> = (0..u32::try_from(count).expect("few"))
                .flat_map(|j| (0..j).map(move |i| [i, j]))
                .collect();
            let of = |pairs: &[Pair]| {
                let mut found = Vec::new();
                contacts(&capsules, pairs, 0.5, &mut found).expect("a reach");
                found
            };
            let each: Vec<_> = pairs.chunks(1).flat_map(of).collect();
            prop_assert_eq!(of(&pairs), each);
        }

        #[test]
        fn every_pair_in_reach_is_reported(
            x in prop::array::uniform4(prop::array::uniform3(prop_oneof![(-1..=1_i8).prop_map(f64::from), -1.0..1.0])),
            reach in 0.0..0.5,
        ) {
            let points = x.map(Point3::from);
            let a = Capsule { start: points[0], end: points[1], radius: RADIUS };
            let b = Capsule { start: points[2], end: points[3], radius: RADIUS };
            let near = a.closest(&b).distance() - 2.0 * RADIUS <= reach;
            prop_assert_eq!(!touch(points, reach).is_empty(), near);
        }
    }
}
