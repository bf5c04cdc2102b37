//! Bounding volumes of strands, to look at.

use nalgebra::{Point3, Vector3};
use rapunzel_export::Strand;

/// Segments of a group, and groups of one of the next level.
const GROUP: usize = 16;

/// Boxes (world, m, two corners each) around strands with their thickness, along the strands as in
/// the topological hierarchy of the thesis (section 7.3): at level 0 of each segment, at level 1 of
/// up to sixteen that follow each other in a strand, at level 2 of up to sixteen of these, and so
/// on; from the level on at which a box holds a whole strand, one box of everything.
#[must_use]
pub fn bounding_boxes(strands: &[Strand], level: usize) -> Vec<[Point3<f64>; 2]> {
    let longest = strands.iter().map(|strand| strand.points.len().saturating_sub(1)).max();
    let power = u32::try_from(level).ok().and_then(|level| GROUP.checked_pow(level));
    let group = power.filter(|group| level == 0 || Some(group / GROUP) < longest);
    let of = |strand: &Strand| {
        let grown = |k: usize| {
            let around = Vector3::repeat(strand.radii.get(k).copied().unwrap_or_default());
            [strand.points[k] - around, strand.points[k] + around]
        };
        let segments = strand.points.len().saturating_sub(1);
        let group = group.unwrap_or(segments).max(1);
        let starts = (0..segments).step_by(group);
        let of_group = |start: usize| {
            let ends = start + 1..=(start + group).min(segments);
            ends.fold(grown(start), |hull, k| around(hull, grown(k)))
        };
        starts.map(of_group).collect::<Vec<_>>()
    };
    let boxes = strands.iter().flat_map(of);
    if group.is_some() { boxes.collect() } else { boxes.reduce(around).into_iter().collect() }
}

/// The box around two.
fn around(a: [Point3<f64>; 2], b: [Point3<f64>; 2]) -> [Point3<f64>; 2] {
    [a[0].inf(&b[0]), a[1].sup(&b[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style;

    fn strands() -> Vec<Strand> {
        let strand = |k: u32| {
            let t = f64::from(k);
            let points: Vec<_> = (0..40)
                .map(|n| Point3::new(0.01 * t, (0.3 * t + 0.1 * f64::from(n)).sin(), 0.02 * t))
                .collect();
            style::strand(&points)
        };
        (0..50).map(strand).collect()
    }

    #[test]
    fn boxes_hold_all_strands_at_every_level_and_are_fewer_from_level_to_level() {
        let strands = strands();
        let mut before = usize::MAX;
        for level in 0..5 {
            let boxes = bounding_boxes(&strands, level);
            assert!(boxes.len() < before || boxes.len() == 1, "{level}: {}", boxes.len());
            before = boxes.len();
            for point in strands.iter().flat_map(|strand| &strand.points) {
                let holds = |[low, high]: &[Point3<f64>; 2]| {
                    (0..3).all(|k| low[k] <= point[k] && point[k] <= high[k])
                };
                assert!(boxes.iter().any(holds), "{level} {point}");
            }
        }
        assert_eq!(before, 1);
        assert_eq!(bounding_boxes(&strands, 0).len(), 50 * 39);
    }

    #[test]
    fn nothing_has_no_boxes() {
        assert!([0, 1, 9].iter().all(|level| bounding_boxes(&[], *level).is_empty()));
    }
}
