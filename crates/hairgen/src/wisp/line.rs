use nalgebra::{Point3, Rotation3, Vector3};
use rapunzel_fiber::so3;

/// Length of the straight ways between points, m.
pub(super) fn length(points: &[Point3<f64>]) -> f64 {
    points.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum()
}

/// `segments + 1` points at equal distances along the straight ways between `points`, from the
/// first on over the arc length `length`, m, or up to the last.
pub(super) fn resample(
    points: &[Point3<f64>],
    length: f64,
    segments: usize,
    out: &mut Vec<Point3<f64>>,
) {
    out.clear();
    let (mut segment, mut before) = (0, 0.0);
    for node in 0..=segments {
        let at = length * node as f64 / segments as f64;
        let point = loop {
            let Some(ends) = points.get(segment..segment + 2) else {
                break points[points.len() - 1];
            };
            let way = ends[1] - ends[0];
            let size = way.norm();
            if at <= before + size && size > 0.0 {
                break ends[0] + way * ((at - before) / size);
            }
            before += size;
            segment += 1;
        };
        out.push(point);
    }
}

/// A guide's center line at equal distances with a frame at each point: d3 the tangent, turned from
/// point to point by the smallest rotation (parallel transport).
#[derive(Debug, Clone)]
pub(super) struct GuideLine {
    pub(super) points: Vec<Point3<f64>>,
    pub(super) frames: Vec<Rotation3<f64>>,
}

impl GuideLine {
    pub(super) fn new(curve: &[Point3<f64>], segments: usize) -> Self {
        let mut points = Vec::with_capacity(segments + 1);
        resample(curve, length(curve), segments, &mut points);
        let mut frames: Vec<Rotation3<f64>> = Vec::with_capacity(segments + 1);
        let mut last = Vector3::z();
        let mut frame = Rotation3::identity();
        for node in 0..=segments {
            // The tangent of a node is along the chord between its neighbors.
            let [before, behind] = [node.saturating_sub(1), (node + 1).min(segments)];
            let tangent = (points[behind] - points[before]).try_normalize(0.0).unwrap_or(last);
            // A curve that turns back on itself has no smallest rotation; the axes across stay.
            frame = so3::between(&last, &tangent).unwrap_or_else(Rotation3::identity) * frame;
            frames.push(frame);
            last = tangent;
        }
        Self { points, frames }
    }
}
