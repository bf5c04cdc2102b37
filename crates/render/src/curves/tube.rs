use super::piece::CurvePiece;
use crate::Ray;
use nalgebra::{Point3, Vector3};

/// Iterations after which a ray that only grazes is given up.
const MOST_ITERATIONS: u32 = 16;
/// Change of the parameter that ends the iterations: it is squared by every one, so what is left
/// then is a rounding.
const CONVERGED: f64 = 1e-7;
/// Overlap of pieces, in their parameter: a hit at a joint belongs to both rather than to none.
const OVERLAP: f64 = 1e-6;

/// Where a ray comes into a tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveHit {
    /// From the origin of the ray, m.
    pub distance: f64,
    /// The piece, by its first control point.
    pub(super) piece: u32,
    /// Where on it, in `[0, 1]`.
    pub(super) parameter: f64,
}

/// A point on a tube and what is around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TubePoint {
    /// The point (world), m.
    pub position: Point3<f64>,
    /// Normal of the section there (world), of unit length, outward.
    pub normal: Vector3<f64>,
    /// Axes d1 and d2 of the section and the tangent d3 (world).
    pub frame: [Vector3<f64>; 3],
    /// Radius, m; of an ellipse that of the circle of its area.
    pub radius: f64,
    /// Offset of the point from the axis, across the ray, over half of the width, in `[-1, 1]`, as
    /// `FiberBsdf::arrive` wants it.
    pub offset: f64,
    /// Index of the fibre.
    pub fiber: usize,
    /// Place along the fibre, in nodes from the first.
    pub node: f64,
}

/// A piece of a tube: its curve, from the origin of a ray, and its section.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tube {
    pub(super) curve: CurvePiece,
    /// Radii at both ends, m.
    pub(super) radii: [f64; 2],
    /// First axes of the section at both ends; none if it is round.
    pub(super) axes: Option<[Vector3<f64>; 2]>,
    /// Semi-axes of the section over the radius.
    pub(super) aspect: [f64; 2],
}

impl Tube {
    /// The largest distance of a point of the section from the curve, m.
    #[inline(always)]
    pub(super) fn widest(&self) -> f64 {
        let [a, b] = self.aspect;
        self.radii[0].max(self.radii[1]) * a.max(b)
    }

    #[inline(always)]
    pub(super) fn radius(&self, t: f64) -> f64 {
        self.radii[0] + t * (self.radii[1] - self.radii[0])
    }

    /// The axes of the section where the curve has the slope `slope`: d1, d2.
    #[inline(always)]
    fn turned_axes(
        &self,
        t: f64,
        [first, last]: &[Vector3<f64>; 2],
        tangent: &Vector3<f64>,
    ) -> [Vector3<f64>; 2] {
        let axis = first + t * (last - first);
        let d1 = axis - tangent * tangent.dot(&axis);
        let length = d1.norm();
        // An axis along the fibre is none: any will do.
        let d1 = if length > 1e-6 { d1 / length } else { across(tangent)[0] };
        [d1, tangent.cross(&d1)]
    }

    /// The frame at `t`: d1, d2, d3; d1 is any normal of a round section.
    pub(super) fn frame(&self, t: f64) -> [Vector3<f64>; 3] {
        let d3 = self.curve.slope(t).normalize();
        let [d1, d2] = match &self.axes {
            Some(axes) => self.turned_axes(t, axes, &d3),
            None => across(&d3),
        };
        [d1, d2, d3]
    }

    /// What is at a distance, m, of a ray from whose origin the curve counts.
    pub(super) fn point(
        &self,
        ray: &Ray,
        distance: f64,
        t: f64,
        fiber: usize,
        node: f64,
    ) -> TubePoint {
        let frame = self.frame(t);
        let [d1, d2, d3] = frame;
        let from = distance * ray.direction - self.curve.at(t);
        let radius = self.radius(t);
        let [a, b] = self.aspect;
        let (x, y) = (from.dot(&d1) / (a * a), from.dot(&d2) / (b * b));
        let normal = (d1 * x + d2 * y).normalize();
        // Across the fibre as the ray sees it: as wide as the section is along it.
        let side = d3.cross(&ray.direction);
        let (u, v) = (side.dot(&d1), side.dot(&d2));
        let half_width = radius * (u * u * (a * a) + v * v * (b * b)).sqrt();
        let offset = from.dot(&side) / half_width;
        let offset = if offset.is_finite() { offset.clamp(-1.0, 1.0) } else { 0.0 };
        let position = ray.origin + distance * ray.direction;
        TubePoint { position, normal, frame, radius, offset, fiber, node }
    }

    /// Coordinates of `v` across the curve, in which the section is a circle of its radius.
    #[inline(always)]
    pub(super) fn flat(&self, axes: &[Vector3<f64>; 2], v: &Vector3<f64>) -> [f64; 2] {
        let [a, b] = self.aspect;
        [axes[0].dot(v) / a, axes[1].dot(v) / b]
    }
}

/// Two unit vectors that are normal to a third and to each other (Duff et al. 2017).
#[inline(always)]
pub(crate) fn across(n: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let sign = 1.0_f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [
        Vector3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vector3::new(b, sign + n.y * n.y * a, -n.y),
    ]
}

/// Distance, m, and parameter at which a ray from the origin comes into a tube, looked for from the
/// parameter `t` on.
///
/// At a parameter the tube is taken for the cylinder around its tangent; where the ray comes into
/// that, the parameter of the nearest point of the curve is the next (Reshetov and Luebke 2018,
/// with cylinders for cones). At the fixed point the hit lies in the normal plane and on the
/// section, exactly.
#[inline(always)]
pub(super) fn enter(tube: &Tube, direction: &Vector3<f64>, t: f64) -> Option<[f64; 2]> {
    // From the point of the ray beside the curve: what is small stays exact from afar.
    let beside = tube.curve.at(t).dot(direction);
    let curve = tube.curve.from(&(beside * direction));
    let mut t = t;
    let mut misses = 0;
    for _ in 0..MOST_ITERATIONS {
        let (c, slope) = (curve.at(t), curve.slope(t));
        let (squared, radius) = (slope.norm_squared(), tube.radius(t));
        let (d, q) = (direction.dot(&slope), -c.dot(&slope));
        // The cylinder: a s^2 + 2 b s + c = 0.
        let (a, b, c0) = match &tube.axes {
            None => {
                let inverse = 1.0 / squared;
                let a = 1.0 - d * d * inverse;
                (a, -c.dot(direction) - q * d * inverse, c.norm_squared() - q * q * inverse)
            }
            Some(axes) => {
                let axes = tube.turned_axes(t, axes, &(slope / squared.sqrt()));
                let ([dx, dy], [x, y]) = (tube.flat(&axes, direction), tube.flat(&axes, &-c));
                (dx * dx + dy * dy, x * dx + y * dy, x * x + y * y)
            }
        };
        let discriminant = b * b - a * (c0 - radius * radius);
        // Along the curve nothing comes in, and a curve without a direction has no tube.
        if a < 1e-12 || a.is_nan() {
            return None;
        }
        let s = (-b - discriminant.max(0.0).sqrt()) / a;
        let from = direction * s - c;
        let step = (q + s * d) / (squared - from.dot(&curve.bend(t)));
        if step.abs() < CONVERGED {
            t += step;
            let inside = (-OVERLAP..=1.0 + OVERLAP).contains(&t);
            return (discriminant > 0.0 && inside).then_some([beside + s, t]);
        }
        // A ray that passes by twice, and not narrowly, does not come in.
        if discriminant < -1e-3 * a * radius * radius && step.abs() < 0.1 {
            misses += 1;
            if misses == 2 {
                return None;
            }
        }
        t = (t + step.clamp(-0.5, 0.5)).clamp(-0.5, 1.5);
    }
    None
}
