use crate::Region;
use nalgebra::Point3;

/// Halvings of half a segment: to less than 1e-12 of it.
const HALVINGS: usize = 40;

/// The part of a hair along `points` (world), m, that stays in the region (thesis 5.3.5).
///
/// It ends where the hair leaves the hull for more than `outside`, m of arc length, and at once
/// where it enters the head. Crossings of the hull are interpolated linearly between the nodes and
/// the middles of the segments, those of the head are found by halving; trips between these points
/// are not seen. The root, which lies on the scalp, may be within the error of either surface. One
/// point is left where the hair enters the head at its root, and none of no points.
#[must_use]
pub fn cut(points: &[Point3<f64>], region: Region<'_>, outside: f64) -> Vec<Point3<f64>> {
    let mut kept = Vec::with_capacity(points.len());
    let Some(root) = points.first() else { return kept };
    kept.push(*root);
    let mut before = region.depths(root).map(|depth| depth.min(0.0));
    // Since the hair left the hull: how many points were kept, where it was, and the way since.
    let mut left: Option<(usize, Point3<f64>, f64)> = None;
    for ends in points.windows(2) {
        let middle = nalgebra::center(&ends[0], &ends[1]);
        for [from, to] in [[ends[0], middle], [middle, ends[1]]] {
            let after = region.depths(&to);
            if after[0] > 0.0 {
                return ended(kept, entry(from, to, region));
            }
            // Where the half crosses the hull.
            let part = before[1] / (before[1] - after[1]);
            let crossing =
                from + (to - from) * if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
            if after[1] > 0.0 {
                let start = if before[1] > 0.0 { from } else { crossing };
                let (count, exit, way) = left.unwrap_or((kept.len(), start, 0.0));
                left = Some((count, exit, way + (to - start).norm()));
            } else if let Some((count, exit, way)) = left {
                left = Some((count, exit, way + (crossing - from).norm()));
            }
            if let Some((count, exit, way)) = left
                && way > outside
            {
                kept.truncate(count);
                return ended(kept, exit);
            }
            if after[1] <= 0.0 {
                left = None;
            }
            before = after;
        }
        kept.push(ends[1]);
    }
    kept
}

/// Where the way from a point outside of the head to one inside enters it, by halving, from
/// outside: the point returned is not in the head, if the first one is not.
fn entry(mut outside: Point3<f64>, mut inside: Point3<f64>, region: Region<'_>) -> Point3<f64> {
    for _ in 0..HALVINGS {
        let middle = nalgebra::center(&outside, &inside);
        if region.head.value(&middle) < 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    outside
}

/// The points kept and the end behind them.
fn ended(mut kept: Vec<Point3<f64>>, end: Point3<f64>) -> Vec<Point3<f64>> {
    if kept.last() != Some(&end) {
        kept.push(end);
    }
    kept
}
