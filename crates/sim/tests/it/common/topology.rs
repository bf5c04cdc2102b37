//! Whether fibres have passed through each other, and what knot one is.

use nalgebra::{DMatrix, Point3, Vector3};
use rapunzel_collision::continuous::MovingSegment;

/// Polylines of all fibres.
pub(crate) type Fibers = Vec<Vec<Point3<f64>>>;

/// A fibre and a segment of it.
type Segment = (usize, usize);

/// The first two segments, no neighbors, whose axes come nearer than `reach`, m, while all nodes go
/// straight from where they were to where they are. None can have crossed then.
pub(crate) fn crossed(before: &Fibers, after: &Fibers, reach: f64) -> Option<[Segment; 2]> {
    let mut segments = Vec::new();
    for (fiber, (was, is)) in before.iter().zip(after).enumerate() {
        for s in 0..was.len() - 1 {
            let moving = MovingSegment { before: [was[s], was[s + 1]], after: [is[s], is[s + 1]] };
            let corners = [was[s], was[s + 1], is[s], is[s + 1]];
            let low = corners.iter().fold(corners[0], |a, b| a.inf(b)).x - reach;
            let high = corners.iter().fold(corners[0], |a, b| a.sup(b)).x;
            segments.push((low, high, (fiber, s), moving));
        }
    }
    // Along x only those that overlap are looked at.
    segments.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (i, (_, high, first, a)) in segments.iter().enumerate() {
        for (low, _, second, b) in &segments[i + 1..] {
            if low > high {
                break;
            }
            let neighbors = first.0 == second.0 && first.1.abs_diff(second.1) <= 1;
            if !neighbors && a.impact(b, reach, 1e-6 * reach).is_some() {
                return Some([*first, *second]);
            }
        }
    }
    None
}

/// The determinant of a long knot, whose ends go on to infinity: 1 for none, 3 for a trefoil. Seen
/// along `view`, its ends must be outermost.
pub(crate) fn determinant(curve: &[Point3<f64>], view: &Vector3<f64>) -> f64 {
    let right = view.cross(&Vector3::z()).normalize();
    let up = right.cross(view).normalize();
    let flat: Vec<[f64; 3]> = curve
        .iter()
        .map(|p| [right.dot(&p.coords), up.dot(&p.coords), view.normalize().dot(&p.coords)])
        .collect();
    // Places along the curve of the lower and of the upper strand.
    let mut crossings: Vec<[f64; 2]> = Vec::new();
    for i in 0..flat.len() - 1 {
        for j in i + 2..flat.len() - 1 {
            if let Some([s, t, above]) = crossing([flat[i], flat[i + 1]], [flat[j], flat[j + 1]]) {
                let (first, second) = (i as f64 + s, j as f64 + t);
                crossings.push(if above > 0.0 { [first, second] } else { [second, first] });
            }
        }
    }
    crossings.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let count = crossings.len();
    if count < 2 {
        return 1.0;
    }
    // Arcs go from one lower strand to the next; the last one is the first, by infinity.
    let arc = |place: f64| crossings.iter().filter(|c| c[0] < place).count() % count;
    let mut rules = DMatrix::<f64>::zeros(count, count);
    for (row, [_, over]) in crossings.iter().enumerate() {
        rules[(row, arc(*over))] += 2.0;
        rules[(row, row)] -= 1.0;
        rules[(row, (row + 1) % count)] -= 1.0;
    }
    rules.remove_row(0).remove_column(0).determinant().abs().round()
}

/// Where two segments cross in the first two coordinates, and how much higher the second is there.
fn crossing([a, b]: [[f64; 3]; 2], [c, d]: [[f64; 3]; 2]) -> Option<[f64; 3]> {
    let (ab, cd, ac) =
        ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]], [c[0] - a[0], c[1] - a[1]]);
    let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let area = cross(ab, cd);
    if area == 0.0 {
        return None;
    }
    let (s, t) = (cross(ac, cd) / area, cross(ac, ab) / area);
    let within = |x: f64| (0.0..1.0).contains(&x);
    let height = |p: [f64; 3], q: [f64; 3], x: f64| p[2] + x * (q[2] - p[2]);
    (within(s) && within(t)).then(|| [s, t, height(c, d, t) - height(a, b, s)])
}
