//! Fields in closed form, and fields made of others.

use super::{DistanceField, Sample};
use crate::Capsule;
use nalgebra::{Isometry3, Point3, Unit, Vector3};

/// All points behind a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// A point of the plane (world), m.
    pub point: Point3<f64>,
    /// Outward normal (world).
    pub normal: Unit<Vector3<f64>>,
}

impl DistanceField for HalfSpace {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let normal = self.normal.into_inner();
        Sample { value: normal.dot(&(point - self.point)), gradient: normal }
    }

    fn least_between(&self, start: &Point3<f64>, end: &Point3<f64>) -> f64 {
        self.value(start).min(self.value(end))
    }
}

/// A ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Center (world), m.
    pub center: Point3<f64>,
    /// Radius, m, at least 0.
    pub radius: f64,
}

impl DistanceField for Ball {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        around(&(point - self.center), self.radius)
    }

    fn value(&self, point: &Point3<f64>) -> f64 {
        (point - self.center).norm() - self.radius
    }

    fn least_between(&self, start: &Point3<f64>, end: &Point3<f64>) -> f64 {
        Capsule { start: *start, end: *end, radius: self.radius }.value(&self.center)
    }
}

/// The distance from the axis, less the radius.
impl DistanceField for Capsule {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let axis = self.end - self.start;
        let length = axis.norm_squared();
        let along = axis.dot(&(point - self.start));
        let fraction = if length > 0.0 { (along / length).clamp(0.0, 1.0) } else { 0.0 };
        around(&(point - self.at(fraction)), self.radius)
    }

    fn least_between(&self, start: &Point3<f64>, end: &Point3<f64>) -> f64 {
        self.closest(&Self { start: *start, end: *end, radius: 0.0 }).distance() - self.radius
    }
}

/// The field of a ball around the origin.
fn around(offset: &Vector3<f64>, radius: f64) -> Sample {
    let gradient = offset.try_normalize(0.0).unwrap_or_default();
    Sample { value: offset.norm() - radius, gradient }
}

/// A box around the origin, with faces normal to the axes; [`Posed`] puts it elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cuboid {
    /// Half of the lengths of the sides, m, at least 0.
    pub half: Vector3<f64>,
}

impl DistanceField for Cuboid {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let beyond = point.coords.abs() - self.half;
        let signs = point.coords.map(|x| 1.0_f64.copysign(x));
        let outside = beyond.sup(&Vector3::zeros());
        let value = outside.norm();
        if value > 0.0 {
            return Sample { value, gradient: outside.component_mul(&signs) / value };
        }
        let axis = beyond.imax();
        let mut gradient = Vector3::zeros();
        gradient[axis] = signs[axis];
        Sample { value: beyond[axis], gradient }
    }

    /// Beyond one of its faces.
    fn least_between(&self, start: &Point3<f64>, end: &Point3<f64>) -> f64 {
        let (low, high) = start.inf_sup(end);
        // Of an interval the point nearest to zero.
        let beyond = |d: usize| low[d].max(-high[d]).max(0.0) - self.half[d];
        beyond(0).max(beyond(1)).max(beyond(2))
    }
}

/// A field that has been moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Posed<F> {
    /// From the frame of the field to the world.
    pub pose: Isometry3<f64>,
    /// The field in its own frame.
    pub field: F,
}

impl<F: DistanceField> DistanceField for Posed<F> {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let Sample { value, gradient } =
            self.field.sample(&self.pose.inverse_transform_point(point));
        Sample { value, gradient: self.pose * gradient }
    }

    fn least_between(&self, start: &Point3<f64>, end: &Point3<f64>) -> f64 {
        let [start, end] = [start, end].map(|point| self.pose.inverse_transform_point(point));
        self.field.least_between(&start, &end)
    }

    fn lipschitz(&self) -> f64 {
        self.field.lipschitz()
    }

    fn error(&self) -> f64 {
        self.field.error()
    }

    fn band(&self) -> f64 {
        self.field.band()
    }
}

/// A level set of a field as the surface: outside of the given one for a positive level.
///
/// Its value is the distance from the level set where that is at a distance `level` from the given
/// surface all over: outside of a convex corner, but not of a concave one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelSet<F> {
    /// The field whose level set is meant.
    pub field: F,
    /// Which value of it is the surface, m, less than its band in size.
    pub level: f64,
}

impl<F: DistanceField> DistanceField for LevelSet<F> {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let Sample { value, gradient } = self.field.sample(point);
        Sample { value: value - self.level, gradient }
    }

    fn least_between(&self, start: &Point3<f64>, end: &Point3<f64>) -> f64 {
        self.field.least_between(start, end) - self.level
    }

    fn lipschitz(&self) -> f64 {
        self.field.lipschitz()
    }

    fn error(&self) -> f64 {
        self.field.error()
    }

    fn band(&self) -> f64 {
        self.field.band() - self.level.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point3<f64>> {
        let x = prop_oneof![(-2..=2_i8).prop_map(f64::from), -2.0..2.0_f64];
        prop::array::uniform3(x).prop_map(Point3::from)
    }

    fn fields() -> Vec<Box<dyn DistanceField>> {
        let pose = Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.5, 0.4, -1.0));
        let cuboid = Cuboid { half: Vector3::new(0.3, 0.6, 0.9) };
        let plane = HalfSpace {
            point: Point3::new(0.1, 0.2, 0.3),
            normal: Unit::new_normalize(Vector3::new(1.0, 2.0, 3.0)),
        };
        let capsule =
            Capsule { start: Point3::origin(), end: Point3::new(1.0, 0.5, 0.2), radius: 0.3 };
        vec![
            Box::new(plane),
            Box::new(Ball { center: Point3::new(0.5, 0.0, 0.0), radius: 0.7 }),
            Box::new(capsule),
            Box::new(cuboid),
            Box::new(Posed { pose, field: cuboid }),
            Box::new(LevelSet { field: capsule, level: 0.2 }),
        ]
    }

    proptest! {
        /// What is told of a way holds for all of its points; of round shapes and planes it is the
        /// least.
        #[test]
        fn no_value_on_a_way_is_less_than_its_bound(p in point(), q in point()) {
            for (field, exact) in fields().iter().zip([true, true, true, false, false, true]) {
                let values = (0..=1000).map(|i| field.value(&p.lerp(&q, f64::from(i) / 1000.0)));
                let (least, bound) = (values.fold(f64::INFINITY, f64::min), field.least_between(&p, &q));
                prop_assert!(bound <= least + 1e-12);
                prop_assert!(!exact || bound >= least - 0.5e-3 * (p - q).norm() - 1e-12);
            }
        }

        /// Going down the gradient by the value leads to the surface, from outside; values are
        /// 1-Lipschitz, and the gradient is a unit vector or zero.
        #[test]
        fn values_are_distances(p in point(), q in point()) {
            for field in fields() {
                let Sample { value, gradient } = field.sample(&p);
                prop_assert!(((value - field.value(&q)).abs()) <= (p - q).norm() + 1e-12);
                prop_assert!(gradient == Vector3::zeros() || (gradient.norm() - 1.0).abs() <= 1e-12);
                if value > 0.0 {
                    prop_assert!(field.value(&(p - value * gradient)).abs() <= 1e-12);
                }
            }
        }
    }

    #[test]
    fn the_inside_is_negative() {
        let cuboid = Cuboid { half: Vector3::new(0.3, 0.6, 0.9) };
        let sample = cuboid.sample(&Point3::new(-0.2, 0.1, 0.0));
        assert!((sample.value + 0.1).abs() <= 1e-15);
        assert_eq!(sample.gradient, -Vector3::x());
        let ball = Ball { center: Point3::origin(), radius: 2.0 };
        let center = Sample { value: -2.0, gradient: Vector3::zeros() };
        assert_eq!(ball.sample(&Point3::origin()), center);
    }
}
