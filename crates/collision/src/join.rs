//! Lists that were made in parts.

use rayon::prelude::*;

/// Joins parts to one list, in place of what it held. All threads copy: long lists take as long to
/// copy as to make.
pub(crate) fn join<T: Copy + Send + Sync>(parts: Vec<Vec<T>>, all: &mut Vec<T>) {
    let Some(&any) = parts.iter().flatten().next() else { return all.clear() };
    let total = parts.iter().map(Vec::len).sum();
    all.truncate(total);
    all.reserve_exact(total - all.len());
    all.resize(total, any);
    let mut rest = &mut all[..];
    let mut room = |part: &Vec<T>| {
        let (own, behind) = std::mem::take(&mut rest).split_at_mut(part.len());
        rest = behind;
        own
    };
    let rooms: Vec<_> = parts.iter().map(&mut room).collect();
    rooms.into_par_iter().zip(&parts).for_each(|(room, part)| room.copy_from_slice(part));
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn parts_follow_each_other(
            parts in prop::collection::vec(prop::collection::vec(0..9, 0..5), 0..9),
            mut all in prop::collection::vec(0..9, 0..30),
        ) {
            let expected = parts.concat();
            join(parts, &mut all);
            prop_assert_eq!(all, expected);
        }
    }
}
