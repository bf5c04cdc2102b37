//! Many pairs of segments over a step.

use super::{Impact, MovingSegment};
use crate::capsules::{count, length};
use crate::{Capsules, CollisionError, Pair};
use rayon::prelude::*;

/// Pairs that one thread looks at a time.
const IMPACT_CHUNK: usize = 1024;

/// The impacts of all `pairs` whose gap falls to `margin`, m, within the step from `start` to
/// `end`, in the order of the pairs; `impacts` is emptied first.
///
/// All nodes move on straight lines; the radii are those at the start. `tolerance` is that of
/// [`MovingSegment::impact`], as are the fractions of the impacts. All pairs that need to be given
/// are those of a tree after [`crate::Tree::refit_swept`]. Cost: 0.3 us a pair that passes at a
/// distance.
///
/// # Errors
/// [`CollisionError::Count`] if there are not as many segments and nodes at the end as at the
/// start, [`CollisionError::Length`] if the margin or the tolerance is negative or not finite.
///
/// # Panics
/// If a pair names a segment that does not exist, as indexing does.
pub fn impacts(
    [start, end]: [&Capsules; 2],
    pairs: &[Pair],
    margin: f64,
    tolerance: f64,
    impacts: &mut Vec<(Pair, Impact<2>)>,
) -> Result<(), CollisionError> {
    length("margin", margin)?;
    length("tolerance", tolerance)?;
    count("segments", end.len(), start.len())?;
    count("nodes", end.positions().len(), start.positions().len())?;
    let impact = |&pair: &Pair| {
        let [i, j] = pair.map(|s| s as usize);
        let [a, b] = [i, j].map(|s| MovingSegment::between(&start.get(s), &end.get(s)));
        let reach = start.radii()[i] + start.radii()[j] + margin;
        a.impact(&b, reach, tolerance).map(|impact| (pair, impact))
    };
    let chunks = pairs.par_chunks(IMPACT_CHUNK);
    let found: Vec<Vec<_>> =
        chunks.map(|pairs| pairs.iter().filter_map(impact).collect()).collect();
    impacts.clear();
    found.iter().for_each(|found| impacts.extend_from_slice(found));
    Ok(())
}
