use nalgebra::{Point3, Rotation3, Vector2, Vector3};

/// An orthographic view of everything in a box.
pub(super) struct View {
    /// Upper left near corner of the box in the coordinates of the view.
    origin: Vector3<f64>,
    right: Vector3<f64>,
    down: Vector3<f64>,
    away: Vector3<f64>,
    /// Distance along `away` over which fibres fade, m.
    depth: f64,
    /// Width and height of the view, m; neither zero nor much smaller than the other.
    pub(super) size: [f64; 2],
    /// Unit vector half-way between the directions to the eye and to the light.
    pub(super) half_way: Vector3<f64>,
}

/// Rotation of the eye about the vertical, degrees.
const TURN: f64 = 25.0;
const RISE: f64 = 15.0;
/// Least elevation of the eye over surfaces, degrees: hills would hide what lies on them.
const RISE_OVER_SURFACES: f64 = 30.0;
/// Ratio of depth to width below which a scene is viewed squarely.
const FLAT: f64 = 0.25;

impl View {
    /// The view of everything in `points`, balls of the given radius (m), with z up: across the
    /// longer horizontal side of the box around them, from a little to the right where the box is
    /// deep and a little above where it is also low, and from straight above where it is flat. Over
    /// surfaces it is from higher above. `None` without points.
    pub(super) fn of(
        points: impl Iterator<Item = Point3<f64>> + Clone,
        radius: f64,
        over_surfaces: bool,
    ) -> Option<Self> {
        // A nanometre keeps a single point of no size from being shown infinitely large.
        let around = radius.max(1e-9);
        let extent = |axis: &Vector3<f64>| {
            let along = points.clone().map(|p| axis.dot(&p.coords));
            along.fold(None, |range: Option<[f64; 2]>, x| {
                let [low, high] = range.unwrap_or([x + around, x - around]);
                Some([low.min(x - around), high.max(x + around)])
            })
        };
        let length = |axis| extent(axis).map(|[low, high]| high - low);
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
        let [across, deep, high] = [length(&x)?, length(&y)?, length(&z)?];
        let (right, away) = if across < deep { (y, -x) } else { (x, y) };
        let [narrow, wide] = [across.min(deep), across.max(deep)];
        // Looking down only where that clearly shows more: hair hangs.
        let (turn, rise) = match narrow {
            _ if high < 0.2 * narrow => (0.0, 90.0),
            _ if over_surfaces => (TURN, RISE_OVER_SURFACES),
            _ if narrow < FLAT * wide => (0.0, 0.0),
            _ => (TURN, if high < wide { RISE } else { 0.0 }),
        };
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), f64::to_radians(turn));
        let (right, level) = (turn * right, turn * away);
        let (sin, cos) = f64::to_radians(rise).sin_cos();
        let (away, down) = (cos * level - sin * z, -cos * z - sin * level);
        let [left, top, near] = [extent(&right)?, extent(&down)?, extent(&away)?];
        let [width, height, depth] = [left, top, near].map(|[low, high]| high - low);
        let largest = width.max(height);
        // Room at the edges, and no picture narrower than a third of its height.
        let size = [width, height].map(|length| (1.08 * length).max(largest / 3.0));
        let origin = Vector3::new(
            0.5 * (left[0] + left[1] - size[0]),
            0.5 * (top[0] + top[1] - size[1]),
            near[0],
        );
        // A flat scene has no haze.
        let depth = depth.max(0.2 * largest);
        let half_way = (-2.0 * away - down - 0.5 * right).normalize();
        Some(Self { origin, right, down, away, depth, size, half_way })
    }

    /// Position of a point in the picture, m from its upper left corner: right, down.
    pub(super) fn project(&self, p: &Point3<f64>) -> [f64; 2] {
        [self.right.dot(&p.coords) - self.origin.x, self.down.dot(&p.coords) - self.origin.y]
    }

    /// Coordinates of a point, m: right and down from the upper left corner of the picture, and
    /// away from the near side of the box.
    pub(super) fn coordinates(&self, p: &Point3<f64>) -> Vector3<f64> {
        let [x, y] = self.project(p);
        Vector3::new(x, y, self.away.dot(&p.coords) - self.origin.z)
    }

    /// The point of the near side of the box, or `before` it, m, that is at a position in the
    /// picture, and the direction of sight.
    pub(super) fn ray(&self, [x, y]: [f64; 2], before: f64) -> (Point3<f64>, Vector3<f64>) {
        let across = self.right * (self.origin.x + x) + self.down * (self.origin.y + y);
        (Point3::from(across + self.away * (self.origin.z - before)), self.away)
    }

    /// Components of a vector across the view: right, down.
    pub(super) fn across(&self, v: &Vector3<f64>) -> Vector2<f64> {
        Vector2::new(self.right.dot(v), self.down.dot(v))
    }

    /// Haze before what is so far behind the near side of the box, m: 0 there, and up to 1 at the
    /// far side of a deep one.
    pub(super) fn haze(&self, depth: f64) -> f64 {
        (depth / self.depth).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_flat_is_seen_squarely_and_what_is_deep_is_turned() {
        let away = |size: [f64; 3]| {
            let corners = [Point3::origin(), Point3::from(size)];
            View::of(corners.iter().copied(), 1e-6, false).expect("points").away
        };
        for (size, expected) in [
            ([3.0, 0.1, 1.0], Vector3::y()),
            ([0.1, 3.0, 1.0], -Vector3::x()),
            ([3.0, 2.0, 0.1], -Vector3::z()),
        ] {
            assert!((away(size) - expected).norm() < 1e-12, "{size:?}: {}", away(size));
        }
        let (low, hanging) = (away([3.0, 2.0, 1.0]), away([1.0, 1.0, 3.0]));
        assert!(low.z < -0.1 && low.x < -0.1 && low.y > 0.5, "{low}");
        assert!(hanging.z == 0.0 && hanging.x < -0.1 && hanging.y > 0.5, "{hanging}");
    }
}
