use super::measures::HeadMeasures;
use nalgebra::{Point3, Unit, Vector3};

/// Measures of the head that the parts are drawn for, m.
const DRAWN: HeadMeasures = HeadMeasures { length: 0.195, breadth: 0.155, height: 0.225 };

/// Radius of the fillets between parts, m.
const FILLET: f64 = 9e-3;

/// Height at which the neck is cut off, m.
const NECK: f64 = -0.155;

/// Centers and semi-axes of the ellipsoids that make the head, m: cranium, face, jaw, chin, nose,
/// neck, and an ear that stands on both sides.
const PARTS: [[[f64; 3]; 2]; 7] = [
    [[0.0, 0.022, 0.0], [0.0775, 0.082, 0.0975]],
    [[0.0, -0.043, 0.045], [0.062, 0.078, 0.048]],
    [[0.0, -0.075, 0.040], [0.056, 0.042, 0.046]],
    [[0.0, -0.102, 0.075], [0.024, 0.020, 0.020]],
    [[0.0, -0.046, 0.090], [0.013, 0.024, 0.021]],
    [[0.0, -0.150, -0.012], [0.055, 0.130, 0.058]],
    [[0.077, -0.026, -0.008], [0.009, 0.031, 0.018]],
];

/// The head as the level set of a blend of ellipsoids.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HeadShape {
    /// Ratio of the measures to those that the parts are drawn for.
    scale: Vector3<f64>,
}

impl HeadShape {
    pub(super) fn new(measures: HeadMeasures) -> Self {
        Self {
            scale: Vector3::new(
                measures.breadth / DRAWN.breadth,
                measures.height / DRAWN.height,
                measures.length / DRAWN.length,
            ),
        }
    }

    /// Ratio of the measures to those of the drawn head.
    pub(super) fn scale(&self) -> Vector3<f64> {
        self.scale
    }

    /// Negative inside, positive outside, about the distance near the surface, in meters of the
    /// head as drawn.
    fn level(&self, point: &Point3<f64>) -> f64 {
        let drawn = point.coords.component_div(&self.scale);
        // Both ears in one: they stand on the side of the point.
        let mirrored = Vector3::new(drawn.x.abs(), drawn.y, drawn.z);
        let mut sum = 0.0;
        for (part, [center, axes]) in PARTS.iter().enumerate() {
            let at = if part + 1 == PARTS.len() { mirrored } else { drawn };
            let (axes, offset) = (Vector3::from(*axes), at - Vector3::from(*center));
            let relative = offset.component_div(&axes).norm();
            let slope = offset.component_div(&axes.component_mul(&axes)).norm();
            let distance =
                if slope > 0.0 { relative * (relative - 1.0) / slope } else { -axes.min() };
            sum += (-distance / FILLET).exp();
        }
        // The logarithm of the sum of exponentials: a minimum with fillets.
        (-FILLET * sum.ln()).max(NECK - drawn.y)
    }

    /// The outermost place of the surface on a ray from a point inside, head frame.
    pub(super) fn reach(&self, from: &Point3<f64>, direction: &Unit<Vector3<f64>>) -> Point3<f64> {
        let step = 2e-3 * self.scale.min();
        let mut outside = 0.5 * self.scale.max();
        let at = |t: f64| from + direction.into_inner() * t;
        // From afar inward by half of the level, which far away is about the distance, until a
        // step ends inside.
        let mut length = step;
        while outside > length {
            let level = self.level(&at(outside - length));
            if level <= 0.0 {
                break;
            }
            outside -= length;
            length = (0.5 * level * self.scale.min()).max(step);
        }
        let step = length;
        let (mut low, mut high) = ((outside - step).max(0.0), outside);
        // 40 halvings of 2 mm are less than the rounding of a coordinate.
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if self.level(&at(middle)) > 0.0 { high = middle } else { low = middle }
        }
        at(0.5 * (low + high))
    }
}
