//! Boxes of any orientation.

use super::principal_axes::principal_axes;
use super::{Axis, BoundingVolume, enlarged_radius, rounding};
use crate::Capsule;
use nalgebra::{Matrix3, Point3, Vector3};

/// An oriented bounding box (thesis, 7.3.7.3).
///
/// A leaf lies along its segment; the box above two leaves has a side on the plane and a side of
/// the triangle of the two segments (Freeman and Shapira 1975); all others are along the principal
/// axes of the ends of their segments or of the corners of the two boxes that they merge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obb {
    center: Point3<f64>,
    /// Its unit axes, as columns (world).
    axes: Matrix3<f64>,
    /// Half of its lengths, m.
    half: Vector3<f64>,
}

impl Obb {
    /// The middle of the box (world), m.
    #[must_use]
    pub fn center(&self) -> Point3<f64> {
        self.center
    }

    /// Half of its lengths along its axes, m.
    #[must_use]
    pub fn half_lengths(&self) -> Vector3<f64> {
        self.half
    }

    /// The smallest box along `axes` around what has these middles and reaches along them, and the
    /// six places of what touches its faces.
    fn along(
        axes: Matrix3<f64>,
        extents: impl Iterator<Item = [Vector3<f64>; 2]>,
    ) -> (Self, [u32; 6]) {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        let mut touching = [0; 6];
        for (place, [middle, reach]) in (0..).zip(extents) {
            for d in 0..3 {
                if middle[d] - reach[d] < low[d] {
                    low[d] = middle[d] - reach[d];
                    touching[d] = place;
                }
                if middle[d] + reach[d] > high[d] {
                    high[d] = middle[d] + reach[d];
                    touching[3 + d] = place;
                }
            }
        }
        let center = Point3::from(axes * (0.5 * low + 0.5 * high));
        let half = 0.5 * high - 0.5 * low;
        let slack = rounding(&center, half.max());
        (Self { center, axes, half: half.add_scalar(slack) }, touching)
    }

    /// Its middle and its reach along `axes`, m.
    fn extent(&self, axes: &Matrix3<f64>) -> [Vector3<f64>; 2] {
        let turned = axes.transpose();
        [turned * self.center.coords, (turned * self.axes).abs() * self.half]
    }

    fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|i| {
            let sign = |d: usize| if i >> d & 1 == 0 { -1.0 } else { 1.0 };
            let local = Vector3::new(sign(0), sign(1), sign(2)).component_mul(&self.half);
            self.center + self.axes * local
        })
    }
}

/// Middle and reach of a capsule along `axes`, m.
fn extent(capsule: &Capsule, axes: &Matrix3<f64>) -> [Vector3<f64>; 2] {
    let [a, b] = [capsule.start, capsule.end].map(|p| axes.transpose() * p.coords);
    let half = (0.5 * b - 0.5 * a).abs();
    [0.5 * a + 0.5 * b, half.add_scalar(enlarged_radius(capsule))]
}

/// Axes of a right-handed frame: the first along `first`, the second in the half plane of `second`;
/// any that are orthogonal where these are no directions.
fn frame(first: &Vector3<f64>, second: &Vector3<f64>) -> Matrix3<f64> {
    let x = unit(first).unwrap_or_else(Vector3::x);
    let least = Vector3::ith(x.iamin(), 1.0);
    let z = unit(second).and_then(|s| {
        let normal = x.cross(&s);
        // Less than this and the direction is mostly rounding.
        if normal.norm() > 1e-6 { unit(&normal) } else { None }
    });
    let z = z.or_else(|| unit(&x.cross(&least))).unwrap_or_else(Vector3::z);
    Matrix3::from_columns(&[x, z.cross(&x), z])
}

/// The direction of `v`, unless its length vanishes or overflows.
fn unit(v: &Vector3<f64>) -> Option<Vector3<f64>> {
    let norm = v.norm();
    (norm > 1e-100 && norm.is_finite()).then(|| v / norm)
}

impl BoundingVolume for Obb {
    type Shared = ();

    fn of_capsule((): &(), capsule: &Capsule) -> Self {
        let axes = frame(&(capsule.end - capsule.start), &Vector3::zeros());
        Self::along(axes, std::iter::once(extent(capsule, &axes))).0
    }

    /// The smallest of the boxes that lie on the plane of both segments and along one of the lines
    /// through two of their ends. Where both share a node, as neighbors do, that is the smallest
    /// rectangle around their triangle, thickened; the ends of two fibers have no plane, and the
    /// box is just a good one.
    fn of_pair((): &(), first: &Capsule, second: &Capsule) -> Self {
        let [a, b] = [first, second].map(|c| c.end - c.start);
        let across = second.start - first.end;
        let lines = [a, b, across, second.end - first.start, second.start - first.start];
        let normal = a.cross(&b);
        let around = |axes: Matrix3<f64>| {
            Self::along(axes, [first, second].map(|c| extent(c, &axes)).into_iter()).0
        };
        // In the plane: across the normal.
        let boxes = lines.map(|line| around(frame(&line, &normal.cross(&line))));
        let smaller =
            |best: Self, next: Self| if next.volume() < best.volume() { next } else { best };
        boxes.into_iter().fold(boxes[0], smaller)
    }

    fn span((): &(), capsules: impl Iterator<Item = Capsule> + Clone) -> (Self, Vec<u32>) {
        let ends: Vec<_> = capsules.clone().flat_map(|c| [c.start, c.end]).collect();
        let axes = principal_axes(&ends);
        let leaves = capsules.map(|c| Self::of_capsule(&(), &c).extent(&axes));
        let (all, touching) = Self::along(axes, leaves);
        let mut basis = touching.to_vec();
        basis.sort_unstable();
        basis.dedup();
        (all, basis)
    }

    /// The axes stay, and the basis determines the faces.
    fn respan(&self, (): &(), basis: impl Iterator<Item = Capsule> + Clone) -> Self {
        let leaves = basis.map(|c| Self::of_capsule(&(), &c).extent(&self.axes));
        Self::along(self.axes, leaves).0
    }

    fn merge(&self, other: &Self) -> Self {
        let mut corners = [Point3::origin(); 16];
        corners[..8].copy_from_slice(&self.corners());
        corners[8..].copy_from_slice(&other.corners());
        let axes = principal_axes(&corners);
        Self::along(axes, [self, other].map(|b| b.extent(&axes)).into_iter()).0
    }

    /// The separating-axis test (Gottschalk et al. 1996): three face normals each and the nine
    /// cross products of edges. A sum that is slightly too large stands for the rounding of cross
    /// products of edges that are nearly parallel.
    fn overlaps(&self, other: &Self) -> bool {
        let relative = self.axes.transpose() * other.axes;
        let reach = relative.abs().add_scalar(super::VOLUME_ROUNDING);
        let t = self.axes.transpose() * (other.center - self.center);
        let (a, b) = (&self.half, &other.half);
        for i in 0..3 {
            if t[i].abs() > a[i] + (reach.row(i) * b)[0] {
                return false;
            }
        }
        for j in 0..3 {
            if relative.column(j).dot(&t).abs() > reach.column(j).dot(a) + b[j] {
                return false;
            }
        }
        let slack = rounding(&self.center, a.max()) + rounding(&other.center, b.max());
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            for j in 0..3 {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                let ra = a[i1] * reach[(i2, j)] + a[i2] * reach[(i1, j)];
                let rb = b[j1] * reach[(i, j2)] + b[j2] * reach[(i, j1)];
                let distance = (t[i2] * relative[(i1, j)] - t[i1] * relative[(i2, j)]).abs();
                if distance > ra + rb + slack {
                    return false;
                }
            }
        }
        true
    }

    fn contains(&self, other: &Self) -> bool {
        let middle = self.axes.transpose() * (other.center - self.center);
        let reach = (self.axes.transpose() * other.axes).abs() * other.half;
        (0..3).all(|d| middle[d].abs() + reach[d] <= self.half[d])
    }

    fn volume(&self) -> f64 {
        8.0 * self.half.product()
    }

    fn axes(&self, (): &(), _: impl Iterator<Item = Capsule> + Clone) -> [Axis; 3] {
        let mut axes = [0, 1, 2].map(|d| {
            let direction = self.axes.column(d).into_owned();
            let middle = direction.dot(&self.center.coords);
            Axis { direction, middle, length: 2.0 * self.half[d] }
        });
        axes.sort_by(|a, b| b.length.total_cmp(&a.length));
        axes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn capsule(start: [f64; 3], end: [f64; 3]) -> Capsule {
        Capsule { start: start.into(), end: end.into(), radius: 1e-3 }
    }

    /// A 3-4-5 triangle is in half of a rectangle of 3 by 4; the one along the longest side is as
    /// large, 5 by 2.4; both are thickened by the diameter.
    #[test]
    fn two_neighbors_are_in_a_flat_box() {
        let first = capsule([0.0, 0.0, 7.0], [3.0, 0.0, 7.0]);
        let second = capsule([3.0, 0.0, 7.0], [3.0, 4.0, 7.0]);
        let volume = Obb::of_pair(&(), &first, &second).volume();
        assert!(volume <= 3.002 * 4.002 * 0.002 * (1.0 + 1e-9), "{volume}");
        let second = capsule([3.0, 0.0, 7.0], [1.0, 0.1, 7.0]);
        let pair = Obb::of_pair(&(), &first, &second);
        assert!(pair.volume() <= 3.002 * 0.102 * 0.002 * (1.0 + 1e-9), "{}", pair.volume());
    }

    /// Boxes of one orientation overlap as their intervals do.
    #[test]
    fn crossed_boxes_are_separated_by_edges() {
        let first = capsule([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        let s = 0.002 + 1e-6;
        for (gap, expected) in [(s, false), (0.002, true)] {
            let second = capsule([0.0, -1.0, gap], [0.0, 1.0, gap]);
            let [a, b] = [first, second].map(|c| Obb::of_capsule(&(), &c));
            assert_eq!(a.overlaps(&b), expected, "{gap}");
        }
    }
}
