//! Which pairs of segments are looked at for contact points, and in which order.

use super::fiber_contacts::fibers;
use super::tunnelling::{passing, travel};
use nalgebra::Point3;
use rapunzel_collision::{CapsuleContact, Capsules, Pair, squared_distances};
use rapunzel_fiber::Layout;
use rayon::prelude::*;

/// Pairs that one task takes.
pub(super) const DETECTION_CHUNK: usize = 2048;

/// Sorts pairs with their squared distances at the start, m²: returns those with gaps up to
/// `margin`, m, at the end, or at `either` end, that cannot have passed through each other, and
/// contacts of those that would. Surfaces are at least `inner` of the radii from the axes.
pub(super) fn sort(
    start: &Capsules,
    end: &Capsules,
    pairs: &[(Pair, f64)],
    margin: f64,
    (either, inner): (bool, f64),
) -> (Vec<Pair>, Vec<CapsuleContact>) {
    let way = |(a, b): (&Point3<f64>, &Point3<f64>)| (b - a).norm_squared();
    let ways = start.positions().iter().zip(end.positions()).map(way);
    // How far one can have gone relative to another, squared.
    let most = 4.0 * ways.fold(0.0, f64::max);
    let chunk = |pairs: &[(Pair, f64)]| {
        let (numbers, before): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
        let mut after = Vec::new();
        squared_distances(end, &numbers, &mut after);
        let (mut near, mut fast) = (Vec::with_capacity(pairs.len()), Vec::new());
        for (pair, (before, after)) in numbers.into_iter().zip(before.into_iter().zip(after)) {
            let [r, q] = pair.map(|segment| end.radii()[segment as usize]);
            let reach = r + q;
            // Axes that were apart by more than the way cannot have crossed.
            let far = (0.25 * (inner * reach).powi(2)).max(before);
            let crosses = most >= far && travel(start, end, pair) >= far;
            let least = if either { before.min(after) } else { after };
            // The fast distances may be off by roundings.
            let close = (reach + margin) * (1.0 + 1e-6);
            match crosses.then(|| passing(start, end, pair, inner)).flatten() {
                Some(contact) => fast.push(contact),
                None if least <= close * close => near.push(pair),
                None => (),
            }
        }
        (near, fast)
    };
    let (near, fast): (Vec<_>, Vec<_>) = pairs.par_chunks(DETECTION_CHUNK).map(chunk).unzip();
    (near.concat(), fast.concat())
}

/// Some pairs by their fibres: dealt out to their first fibres, then each of these by itself.
pub(super) fn by_fibers(layout: &Layout, pairs: Vec<Pair>) -> Vec<Pair> {
    let first = |pair: &Pair| layout.segment_fibers()[pair[0] as usize];
    let key = |pair: &Pair| [pair[1], pair[0]];
    let is_sorted = |two: &[Pair]| (first(&two[0]), key(&two[0])) <= (first(&two[1]), key(&two[1]));
    if pairs.par_windows(2).all(is_sorted) {
        return pairs;
    }
    let mut next = vec![0; layout.fibers() + 1];
    pairs.iter().for_each(|pair| next[first(pair) + 1] += 1);
    (0..layout.fibers()).for_each(|fiber| next[fiber + 1] += next[fiber]);
    let mut dealt = vec![[0; 2]; pairs.len()];
    for pair in pairs {
        let next = &mut next[first(&pair)];
        dealt[*next] = pair;
        *next += 1;
    }
    let of_fibers = dealt.par_chunk_by_mut(|a, b| first(a) == first(b));
    of_fibers.for_each(|own| own.sort_unstable_by_key(key));
    dealt
}

/// Selects from pairs of segments those whose fibres are somewhere deeper than `depth`, m, in each
/// other, or in themselves at all, or have a contact on the way; and how deep those are that are
/// left out, m.
pub(super) fn of_overlapping(
    end: &Capsules,
    mut near: Vec<Pair>,
    on_the_way: &[CapsuleContact],
    depth: f64,
) -> (Vec<Pair>, f64) {
    let fibers = |pair: &Pair| fibers(end.layout(), pair);
    let overlaps = |pairs: &[Pair]| {
        let (mut squared, mut chosen, mut deepest) = (Vec::new(), Vec::new(), 0.0);
        squared_distances(end, pairs, &mut squared);
        for (pair, squared) in pairs.iter().zip(squared) {
            let reach = pair.map(|segment| end.radii()[segment as usize]).iter().sum::<f64>();
            if squared >= reach * reach {
                continue;
            }
            let [fiber, partner] = fibers(pair);
            let deep = reach - squared.sqrt();
            // The fast distances may be off by roundings. In a bend a fibre does not overlap
            // itself.
            if deep >= depth - 1e-6 * reach || fiber == partner {
                chosen.push([fiber, partner]);
            } else {
                deepest = f64::max(deepest, deep);
            }
        }
        (chosen, deepest)
    };
    let parts: Vec<_> = near.par_chunks(DETECTION_CHUNK).map(overlaps).collect();
    let deepest = parts.iter().map(|(_, deepest)| *deepest).fold(0.0, f64::max);
    let mut chosen: Vec<_> = parts.into_iter().flat_map(|(chosen, _)| chosen).collect();
    chosen.extend(on_the_way.iter().map(|contact| fibers(&contact.pair)));
    chosen.par_sort_unstable();
    chosen.dedup();
    near.retain(|pair| chosen.binary_search(&fibers(pair)).is_ok());
    (near, deepest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn pairs_are_put_in_order_by_their_fibers(
            mut pairs in prop::collection::vec([0..12_u32, 0..12_u32], 0..60),
        ) {
            let layout = Layout::new([3, 1, 5, 3]);
            let dealt = by_fibers(&layout, pairs.clone());
            let first = |pair: &Pair| layout.segment_fibers()[pair[0] as usize];
            pairs.sort_unstable_by_key(|pair| (first(pair), pair[1], pair[0]));
            prop_assert_eq!(&dealt, &pairs);
            prop_assert_eq!(by_fibers(&layout, dealt), pairs);
        }
    }
}
