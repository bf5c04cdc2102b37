//! Lists of contact points, and what else is in order, put together.

use crate::contact_point::ContactPoint;
use nalgebra::Vector3;

/// Puts some things between those of a list, both in order, where `after` tells whether one of the
/// list comes after one of the others. Costs no more than what has to move.
pub(crate) fn merge<T: Copy>(
    list: &mut Vec<T>,
    mut others: Vec<T>,
    after: impl Fn(&T, &T) -> bool,
) {
    let (mut left, mut at) = (list.len(), list.len() + others.len());
    list.reserve_exact(others.len());
    list.extend_from_slice(&others);
    while let Some(last) = others.last() {
        at -= 1;
        if left > 0 && after(&list[left - 1], last) {
            left -= 1;
            list[at] = list[left];
        } else {
            list[at] = *last;
            others.pop();
        }
    }
}

/// Keeps what does not go.
pub(crate) fn retain_others<T>(list: &mut Vec<T>, goes: Vec<bool>) {
    // Of most lists nothing does.
    if goes.contains(&true) {
        let mut goes = goes.into_iter();
        list.retain(|_| !goes.next().unwrap_or_default());
    }
}

/// The contact points of a list together with those of another that are deeper than `depth`, in
/// place of those that oppose them or are near them, unless there is nothing to `replace` any more:
/// then only what is both goes, as fibres that cross at a small angle may need two with opposite
/// normals. Both are sorted.
pub(crate) fn merged(
    mut list: Vec<ContactPoint>,
    other: &[ContactPoint],
    depth: f64,
    replace: bool,
) -> Vec<ContactPoint> {
    let mut new: Vec<ContactPoint> =
        other.iter().filter(|point| point.gap < -depth).copied().collect();
    list.retain(|point| {
        let start = new.partition_point(|deep| deep.sides < point.sides);
        let mut of_pair = new[start..].iter_mut().take_while(|deep| deep.sides == point.sides);
        let deep = of_pair.find(|deep| {
            let [opposes, near] = [deep.opposes(point), deep.near(point)];
            if replace { opposes || near } else { opposes && near }
        });
        let Some(deep) = deep else { return true };
        deep.bonded |= point.bonded;
        if deep.impulse == Vector3::zeros() {
            deep.impulse = point.impulse;
        }
        false
    });
    merge(&mut list, new, |point, deep| point.rank() > deep.rank());
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body_ref::BodyRef;
    use proptest::prelude::*;

    /// A contact point of two fibres at a place along both, in segments, its normal up or down.
    fn point(place: f64, up: f64, gap: f64) -> ContactPoint {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is small")]
        let segment = place as u32;
        ContactPoint {
            sides: [BodyRef::Fiber(0), BodyRef::Fiber(1)],
            segments: [segment; 2],
            fractions: [place.fract(); 2],
            normal: Vector3::z() * up,
            arms: [Vector3::x(); 2],
            offsets: [Vector3::zeros(); 2],
            gap,
            ..ContactPoint::IDLE
        }
    }

    /// Fibres that cross at a small angle touch on opposite sides: one takes the other's place at
    /// first, and when both have turned up again and again, both stay. At one place there is but
    /// one.
    #[test]
    fn opposite_touches_stay_both_in_the_end() {
        let places = |new: &ContactPoint, replace: bool| -> Vec<f64> {
            let merged = merged(vec![point(3.2, 1.0, 0.0)], &[*new], 1e-6, replace);
            merged.iter().map(|point| point.at()[0]).collect()
        };
        let (beside, there) = (point(2.9, -1.0, -1e-5), point(3.25, -1.0, -1e-5));
        assert_eq!((places(&beside, true), places(&beside, false)), (vec![2.9], vec![2.9, 3.2]));
        assert_eq!((places(&there, true), places(&there, false)), (vec![3.25], vec![3.25]));
        let alike = point(3.25, 1.0, -1e-5);
        assert_eq!((places(&alike, true), places(&alike, false)), (vec![3.25], vec![3.2, 3.25]));
        let shallow = point(2.9, -1.0, -1e-7);
        assert_eq!((places(&shallow, true), places(&shallow, false)), (vec![3.2], vec![3.2]));
    }

    proptest! {
        #[test]
        fn merging_sorts(mut list in prop::collection::vec(0..20, 0..20), mut others in prop::collection::vec(0..20, 0..20)) {
            list.sort_unstable();
            others.sort_unstable();
            let mut all = [list.clone(), others.clone()].concat();
            all.sort_unstable();
            merge(&mut list, others, |a, b| a > b);
            prop_assert_eq!(list, all);
        }
    }
}
