use crate::Region;
use nalgebra::{Point3, Vector3};

/// Corrections of a segment that would leave the region.
const CORRECTIONS: usize = 4;
/// Cosine of the angle between two segments at which a hair ends.
const FOLD: f64 = 0.5;
/// Number of segments over which the clearance of the head grows.
const RISE: f64 = 3.0;

/// Lays a hair along the `aims`, points at equal distances, in segments of the length `segment`, m,
/// into the region: each segment is led to its aim, and where it would enter the head or leave the
/// hull it is turned along the surface. So all segments keep their length. Where the surfaces leave
/// no way ahead, as in the wedge between them at the hairline, it would fold: it ends there.
pub(super) fn rein(
    root: &Point3<f64>,
    aims: &[Point3<f64>],
    segment: f64,
    region: Region<'_>,
    clearance: f64,
    out: &mut Vec<Point3<f64>>,
) {
    out.clear();
    out.push(*root);
    let mut at = *root;
    let mut along = Vector3::zeros();
    for (node, aim) in aims.iter().enumerate().skip(1) {
        let clear = clearance * (node as f64 / RISE).min(1.0);
        along = (aim - at).try_normalize(0.0).unwrap_or(along);
        for _ in 0..CORRECTIONS {
            let push = push(&at, &(at + along * segment), region, clear);
            if push == Vector3::zeros() {
                break;
            }
            along = (along * segment + push).try_normalize(0.0).unwrap_or(along);
        }
        if node > 1 && along.dot(&(at - out[node - 2])) < FOLD * segment {
            break;
        }
        at += along * segment;
        out.push(at);
    }
}

/// The displacement of the end of a segment that brings it back into the region to first order, m;
/// zero if it is in the region. The head wins.
fn push(start: &Point3<f64>, end: &Point3<f64>, region: Region<'_>, clear: f64) -> Vector3<f64> {
    let [head, hull] = region.walls(end);
    let mut push = Vector3::zeros();
    if hull.value > 0.0 {
        push -= hull.gradient * hull.value;
    }
    if head.value > -clear {
        push -= head.gradient * (head.value + clear);
    } else {
        // Ends outside of the head, but not the middle: over an edge.
        let middle = nalgebra::center(start, end);
        if region.head.value(&middle) < 0.0 {
            let inside = region.head.sample(&middle);
            push -= inside.gradient * (2.0 * inside.value);
        }
    }
    push
}
