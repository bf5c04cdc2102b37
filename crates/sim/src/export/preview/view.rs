use nalgebra::{Point3, Vector3};

/// An orthographic view of everything in a box.
pub(super) struct View {
    /// Upper left near corner of the box in the coordinates of the view.
    origin: Vector3<f64>,
    right: Vector3<f64>,
    down: Vector3<f64>,
    away: Vector3<f64>,
    /// Distance along `away` over which fibres fade, m.
    depth: f64,
    /// Width and height, m; neither zero nor much smaller than the other.
    pub(super) size: [f64; 2],
    /// Unit vector half-way between the directions to the eye and to the light.
    pub(super) half_way: Vector3<f64>,
}

impl View {
    /// The view of the box around `points`, balls of the given radius (m), along its shorter
    /// horizontal side with z up, or from above where the box is flat. `None` without points.
    pub(super) fn of<'a>(
        points: impl Iterator<Item = &'a Point3<f64>>,
        radius: f64,
    ) -> Option<Self> {
        let bounds = points.fold(None, |bounds: Option<[Point3<f64>; 2]>, p| {
            Some(bounds.map_or([*p; 2], |[low, high]| [low.inf(p), high.sup(p)]))
        })?;
        // A nanometre keeps a single point of no size from being shown infinitely large.
        let around = Vector3::repeat(radius.max(1e-9));
        let [low, high] = [bounds[0] - around, bounds[1] + around];
        let box_size = high - low;
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        // Looking down only where that clearly shows more: hair hangs.
        let (right, down, away) = if box_size.z < 0.2 * box_size.x.min(box_size.y) {
            (x, -y, -z)
        } else if box_size.x < box_size.y {
            (y, -z, -x)
        } else {
            (x, -z, y)
        };
        let extent = |axis: &Vector3<f64>| axis.dot(&box_size).abs();
        let largest = extent(&right).max(extent(&down));
        // Room at the edges, and no picture narrower than a third of its height.
        let padded = |axis| (1.08 * extent(axis)).max(largest / 3.0);
        let size = [padded(&right), padded(&down)];
        let middle = nalgebra::center(&low, &high).coords;
        // A flat scene has no haze.
        let depth = extent(&away).max(0.2 * largest);
        let origin = Vector3::new(
            right.dot(&middle) - 0.5 * size[0],
            down.dot(&middle) - 0.5 * size[1],
            away.dot(&middle) - 0.5 * extent(&away),
        );
        let half_way = (-2.0 * away - down - 0.5 * right).normalize();
        Some(Self { origin, right, down, away, depth, size, half_way })
    }

    /// Position in the picture, m from its upper left corner: right, down.
    pub(super) fn project(&self, p: &Point3<f64>) -> [f64; 2] {
        [self.right.dot(&p.coords) - self.origin.x, self.down.dot(&p.coords) - self.origin.y]
    }

    /// 0 at the near side of the box, up to 1 at the far side of a deep one.
    pub(super) fn depth(&self, p: &Point3<f64>) -> f64 {
        ((self.away.dot(&p.coords) - self.origin.z) / self.depth).clamp(0.0, 1.0)
    }
}
