use super::chords::chords;
use crate::FiberError;
use crate::error::positive;
use nalgebra::{Matrix3, Point3, Vector3};
use std::f64::consts::TAU;

/// A knot in a fibre along a closed curve, which is cut where it is farthest from its middle. There
/// its ends pass each other and go on straight, so that they can be pulled. The knot is that of the
/// closed curve, since no part of it is beyond the plane of the ends.
#[derive(Debug, Clone, PartialEq)]
pub struct LongKnot {
    /// Points along the closed curve, m; the last is joined to the first. They are the control
    /// points of a smooth curve that cuts each corner, half of the distance to the line through the
    /// middles of both sides: strands of a knot on a lattice stay apart.
    pub points: Vec<Point3<f64>>,
    /// Distance at which the ends pass each other, m; more than two diameters, since beside the cut
    /// half of it is left.
    pub spacing: f64,
}

/// Least number of corners of a knotted polygon.
const CORNERS: usize = 6;
/// Number of straight pieces for the arc at a corner: they deviate from the arc by a thousandth of
/// the distance that it cuts off.
const PIECES: usize = 16;

impl LongKnot {
    /// A figure-eight knot scaled by `radius`, m: the closed curve `((2 + cos 2t) cos 3t, (2 + cos
    /// 2t) sin 3t, sin 4t)`.
    #[must_use]
    pub fn figure_eight(radius: f64, spacing: f64) -> Self {
        let corners = 160;
        let point = |k: usize| {
            let t = TAU * k as f64 / corners as f64;
            let away = 2.0 + (2.0 * t).cos();
            let at = Vector3::new(away * (3.0 * t).cos(), away * (3.0 * t).sin(), (4.0 * t).sin());
            Point3::from(radius / 3.0 * at)
        };
        Self { points: (0..corners).map(point).collect(), spacing }
    }

    /// Nodes of the knot, m, for segments of the given lengths, m. It begins at the origin along z
    /// and stands out along x; its ends are equally long, the first on the z axis, the last beside
    /// it.
    ///
    /// All segments are chords of one smooth curve and have their lengths to rounding. Costs
    /// O((points + segments) log points).
    ///
    /// # Errors
    /// Refuses fewer than six points, points that are not finite or that coincide, lengths that are
    /// not positive, a curve that turns back where it is cut, segments longer than the mean
    /// distance of the points, and a fibre too short for the knot.
    pub fn nodes(&self, lengths: &[f64]) -> Result<Vec<Point3<f64>>, FiberError> {
        positive("distance of the ends of the knot (m)", self.spacing)?;
        let (corners, step) = self.corners()?;
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let whole = lengths.iter().sum::<f64>();
        let unresolved = || FiberError::Unresolved {
            segments: lengths.len(),
            needed: (whole / step).ceil().max(lengths.len() as f64 + 1.0),
        };
        if longest > step {
            return Err(unresolved());
        }
        let arc = Arc::around(&corners);
        let end = 0.5 * (whole - arc.length());
        if end.is_nan() || end <= 0.0 {
            let quantity =
                "length of each end of the knot, half of what it leaves of the fibre (m)";
            return Err(FiberError::OutOfRange { quantity, value: end, range: "(0, infinity)" });
        }
        let nodes = chords(lengths, |way| arc.at(way - end, end));
        let follows = |(ends, length): (&[Point3<f64>], &f64)| {
            ((ends[1] - ends[0]).norm() - length).abs() < 1e-9 * length
        };
        // A chord does not get longer where a curve turns back.
        if nodes.windows(2).zip(lengths).all(follows) { Ok(nodes) } else { Err(unresolved()) }
    }

    /// Corners of the open curve, from a step before the cut to a step after it, in the frame of
    /// the cut; and the step, the mean distance of the points, m.
    fn corners(&self) -> Result<(Vec<Point3<f64>>, f64), FiberError> {
        let (points, count) = (&self.points, self.points.len());
        if count < CORNERS {
            let (quantity, range) = ("number of points of the knot", "[6, infinity)");
            return Err(FiberError::OutOfRange { quantity, value: count as f64, range });
        }
        if let Some(index) = points.iter().position(|p| !p.coords.iter().all(|x| x.is_finite())) {
            return Err(FiberError::NotFinite { quantity: "point of the knot", index });
        }
        let next = |i: usize| points[(i + 1) % count];
        let gaps: Vec<f64> = (0..count).map(|i| (next(i) - points[i]).norm()).collect();
        if let Some(index) = gaps.iter().position(|gap| *gap <= 0.0) {
            return Err(FiberError::Coincident { index });
        }
        let step = gaps.iter().sum::<f64>() / count as f64;
        let middle = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / count as f64;
        let away = |p: &Point3<f64>| (p.coords - middle).norm();
        let cut =
            (0..count).fold(0, |a, b| if away(&points[b]) > away(&points[a]) { b } else { a });
        let missing = FiberError::NoDirection { quantity: "closed curve where it is cut" };
        let x = (middle - points[cut].coords).try_normalize(0.0).ok_or(missing.clone())?;
        let along = next(cut) - points[(cut + count - 1) % count];
        let z = (along - x * x.dot(&along)).try_normalize(1e-6 * along.norm()).ok_or(missing)?;
        let frame = Matrix3::from_columns(&[x, z.cross(&x), z]);
        let turned = |i: usize| frame.tr_mul(&(points[(cut + i) % count] - points[cut]));
        let mut ways = vec![0.0];
        for i in 0..count {
            ways.push(ways[i] + gaps[(cut + i) % count]);
        }
        // The curve comes back to the cut beside where it began, away from the strand that is
        // nearest. It swerves where it is less deep than the spacing: it bends more than a sphere
        // about the middle.
        let around = ways[count];
        let reach = (4.0 * self.spacing).max((2.0 * self.spacing * away(&points[cut])).sqrt());
        let others = (0..count).filter(|i| ways[*i] > reach && around - ways[*i] > reach);
        let near = others.map(turned).min_by(|a, b| a.norm().total_cmp(&b.norm()));
        let aside = if near.is_some_and(|p| p.y > 0.0) { -self.spacing } else { self.spacing };
        let mut corners = vec![Point3::new(0.0, 0.0, -step)];
        corners.extend((0..=count).map(|i| {
            let rest = (1.0 - (around - ways[i]) / reach).max(0.0);
            Point3::from(turned(i) + aside * rest * rest * (3.0 - 2.0 * rest) * Vector3::y())
        }));
        corners.push(Point3::new(0.0, aside, step));
        Ok((corners, step))
    }
}

/// A curve of short straight pieces, with the arc length at each of its points.
struct Arc {
    points: Vec<Point3<f64>>,
    ways: Vec<f64>,
}

impl Arc {
    /// The quadratic B-spline around corners, from the middle of the first side to the middle of
    /// the last.
    fn around(corners: &[Point3<f64>]) -> Self {
        let mut points = vec![corners[0].lerp(&corners[1], 0.5)];
        for corner in corners.windows(3) {
            let ends = [corner[0].lerp(&corner[1], 0.5), corner[1].lerp(&corner[2], 0.5)];
            points.extend((1..=PIECES).map(|k| {
                let t = k as f64 / PIECES as f64;
                ends[0].lerp(&corner[1], t).lerp(&corner[1].lerp(&ends[1], t), t)
            }));
        }
        let mut ways = vec![0.0];
        for ends in points.windows(2) {
            ways.push(ways[ways.len() - 1] + (ends[1] - ends[0]).norm());
        }
        Self { points, ways }
    }

    fn length(&self) -> f64 {
        self.ways[self.ways.len() - 1]
    }

    /// Point at the arc length `way`, m, straight along z before the start and after the end of the
    /// curve, whose start is moved to `start` on the z axis.
    fn at(&self, way: f64, start: f64) -> Point3<f64> {
        let (first, last) = (self.points[0], self.points[self.points.len() - 1]);
        let after = self.ways.partition_point(|w| *w <= way);
        let place = if after == 0 {
            first + way * Vector3::z()
        } else if after == self.ways.len() {
            last + (way - self.length()) * Vector3::z()
        } else {
            let (a, b) = (after - 1, after);
            let part = (way - self.ways[a]) / (self.ways[b] - self.ways[a]);
            self.points[a].lerp(&self.points[b], part)
        };
        place + (start - first.z) * Vector3::z()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eight() -> LongKnot {
        LongKnot::figure_eight(0.01, 1e-3)
    }

    #[test]
    fn segments_have_their_lengths_and_ends_pass_each_other() {
        for segments in [300, 450] {
            let lengths = vec![0.18 / segments as f64; segments];
            let nodes = eight().nodes(&lengths).expect("a knot");
            for (ends, length) in nodes.windows(2).zip(&lengths) {
                assert!(((ends[1] - ends[0]).norm() / length - 1.0).abs() < 1e-12);
            }
            let last = nodes[segments];
            assert!(nodes[0].coords.norm() < 1e-15 && nodes[1].x.abs() < 1e-15);
            assert!(last.x.abs() < 1e-12 && (last.y.abs() - 1e-3).abs() < 1e-12, "{last}");
            // Both ends are in a plane, and nothing is beyond it or beyond them.
            assert!(nodes.iter().all(|p| p.x > -1e-12 && (0.0..=last.z).contains(&p.z)));
            // Half of the spacing is left where the curve comes back beside its beginning.
            let far = |i: usize, j: usize| i.abs_diff(j) > segments / 10;
            let pairs = (0..=segments).flat_map(|i| (0..i).map(move |j| (i, j)));
            let gaps =
                pairs.filter(|(i, j)| far(*i, *j)).map(|(i, j)| (nodes[i] - nodes[j]).norm());
            assert!(gaps.fold(f64::INFINITY, f64::min) > 0.5e-3);
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let lengths = vec![6e-4; 300];
        let with = |change: &dyn Fn(&mut LongKnot)| {
            let mut knot = eight();
            change(&mut knot);
            knot.nodes(&lengths).expect_err("nonsense")
        };
        assert!(matches!(with(&|k| k.spacing = 0.0), FiberError::NotPositive { .. }));
        assert!(matches!(with(&|k| k.points.truncate(5)), FiberError::OutOfRange { .. }));
        let same = |k: &mut LongKnot| k.points[7] = k.points[6];
        assert!(matches!(with(&same), FiberError::Coincident { index: 6 }));
        let closed = |k: &mut LongKnot| k.points.push(k.points[0]);
        assert!(matches!(with(&closed), FiberError::Coincident { index: 160 }));
        assert!(matches!(
            with(&|k| k.points[3].y = f64::NAN),
            FiberError::NotFinite { index: 3, .. }
        ));
        let short = eight().nodes(&lengths[..150]);
        assert!(matches!(short, Err(FiberError::OutOfRange { .. })), "{short:?}");
        let coarse = eight().nodes(&[2e-3; 100]);
        assert!(matches!(coarse, Err(FiberError::Unresolved { .. })), "{coarse:?}");
        // Back and forth on one line: nowhere to lead the ends.
        let line = (0..8).map(|k| Point3::new(f64::from((k - 4_i32).abs()), 0.0, 0.0)).collect();
        let flat = LongKnot { points: line, spacing: 0.1 }.nodes(&lengths);
        assert!(matches!(flat, Err(FiberError::NoDirection { .. })), "{flat:?}");
    }
}
