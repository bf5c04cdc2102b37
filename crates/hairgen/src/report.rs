use crate::{HairCurves, Region};
use rayon::prelude::*;

/// How well hairs keep to the region, as the fields of head and hull tell it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct HairReport {
    /// Numbers of the hairs that found no place.
    pub without_place: Vec<usize>,
    /// Number of segments.
    pub segments: usize,
    /// Number of segments of which the far end or the middle is in the head.
    pub in_head: usize,
    /// Length of all hairs, m.
    pub length: f64,
    /// Length of the segments of which the middle is outside of the hull by more than the
    /// tolerance, m.
    pub outside: f64,
}

impl HairReport {
    /// The report of `curves` with the given tolerance of the hull, m.
    #[must_use]
    pub fn of(curves: &HairCurves, region: Region<'_>, tolerance: f64) -> Self {
        let all: Vec<_> = curves.iter().collect();
        let parts: Vec<Self> = all
            .par_iter()
            .map(|curve| {
                let mut part = Self::default();
                for ends in curve.windows(2) {
                    let middle = nalgebra::center(&ends[0], &ends[1]);
                    let length = (ends[1] - ends[0]).norm();
                    let [head, hull] = region.depths(&middle);
                    part.segments += 1;
                    part.in_head += usize::from(head.max(-region.head.value(&ends[1])) > 0.0);
                    part.length += length;
                    part.outside += if hull > tolerance { length } else { 0.0 };
                }
                part
            })
            .collect();
        let mut report = Self::default();
        for (number, part) in parts.iter().enumerate() {
            if part.segments == 0 {
                report.without_place.push(number);
            }
            report.segments += part.segments;
            report.in_head += part.in_head;
            report.length += part.length;
            report.outside += part.outside;
        }
        report
    }
}
