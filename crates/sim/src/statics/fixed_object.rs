//! Objects that rods at rest touch.

use super::axis_gap::AxisGap;
use crate::SimError;
use crate::objects::{Sizes, build_object};
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::field::Soup;
use rapunzel_coupling::{Field, extents};
use rapunzel_export::surface::Placed;
use rapunzel_scene::case::Case;
use rapunzel_scene::{Object, ObjectShape};

/// Part of its extent by which nothing may pass through an object on one step.
const PIERCED: f64 = 0.25;
/// Step of differences of a field's gradient, in the radius of the rod.
const FIELD_STEP: f64 = 1e-3;

/// An object as rods see it.
pub(super) struct FixedObject {
    pub(super) field: Field,
    pub(super) pose: Isometry3<f64>,
    /// Axis and radius of a round one, world frame.
    pub(super) round: Option<Capsule>,
    /// Whether its field is that of a plane.
    flat: bool,
    /// Its smallest extent, m; infinite for the ground.
    pub(super) extent: f64,
}

impl FixedObject {
    pub(super) fn new(object: &Object, index: usize, sizes: &Sizes) -> Result<Self, SimError> {
        let built = build_object(object, index, sizes)?;
        let pose = built.pose(0.0);
        let round = match object.shape {
            ObjectShape::Ball { radius } => Some((0.0, radius)),
            ObjectShape::Capsule { length, radius } => Some((length, radius)),
            _ => None,
        };
        let round = round.map(|(length, radius)| {
            let end = Point3::new(0.0, 0.0, 0.5 * length);
            Capsule { start: pose * -end, end: pose * end, radius }
        });
        let endless = object.shape.is_endless();
        let sides = extents(built.surface()).map(|[low, high]| high - low);
        let extent = sides.into_iter().fold(f64::INFINITY, f64::min);
        Ok(Self {
            field: built.field().clone(),
            pose,
            round,
            flat: matches!(object.shape, ObjectShape::Plane { .. }),
            extent: if endless { f64::INFINITY } else { extent },
        })
    }

    /// Distance of a point from the surface, m, with its gradient and second derivatives, 1/m.
    pub(super) fn distance(
        &self,
        at: &Point3<f64>,
        radius: f64,
    ) -> (f64, Vector3<f64>, Matrix3<f64>) {
        if let Some(round) = &self.round {
            let gap = AxisGap::of(&point(at), round);
            let derivative = gap.derivatives.fixed_rows::<3>(0).into_owned();
            let curvature = gap.curvature.fixed_view::<3, 3>(0, 0).into_owned();
            return (gap.distance - round.radius, derivative, curvature);
        }
        let own = self.pose.inverse_transform_point(at);
        let sample = self.field.sample(&own);
        let mut curvature = Matrix3::zeros();
        if !self.flat && sample.value < 2.0 * radius {
            let step = FIELD_STEP * radius;
            for k in 0..3 {
                let by = Vector3::ith(k, step);
                let [low, high] = [own - by, own + by].map(|at| self.field.sample(&at).gradient);
                curvature.set_column(k, &((high - low) / (2.0 * step)));
            }
            curvature = 0.5 * (curvature + curvature.transpose());
        }
        let turn = self.pose.rotation.to_rotation_matrix();
        let curvature = turn.matrix() * curvature * turn.matrix().transpose();
        (sample.value, self.pose * sample.gradient, curvature)
    }

    /// Whether it has an other side, and no axis.
    pub(super) fn is_pierceable(&self) -> bool {
        self.extent.is_finite() && self.round.is_none()
    }

    /// Whether a point that moves straight goes deep into it.
    pub(super) fn is_pierced(&self, from: &Point3<f64>, to: &Point3<f64>) -> bool {
        let deep = -PIERCED * self.extent;
        let parts = ((to - from).norm() / (PIERCED * self.extent)).ceil().clamp(1.0, 1000.0);
        let mut part = 1.0;
        while part <= parts {
            let at = from + (to - from) * (part / parts);
            if self.field.value(&self.pose.inverse_transform_point(&at)) < deep {
                return true;
            }
            part += 1.0;
        }
        false
    }
}

/// The lengths of rods, for what they touch.
pub(super) fn sizes(alone: &[Case]) -> Sizes {
    Sizes {
        longest: alone.iter().map(|rod| rod.length).fold(0.0, f64::max),
        thickest: alone.iter().map(|rod| rod.matter().thickest()).fold(0.0, f64::max),
        roundest: None,
    }
}

/// The surfaces of the objects of a case, for its picture; without the ground, which would be most
/// of it.
pub(super) fn surfaces(case: &Case) -> Result<Vec<Placed>, SimError> {
    let sizes = sizes(&case.alone());
    let shown = case.objects.iter().enumerate().filter(|(_, one)| !one.shape.is_endless());
    let placed = shown.map(|(i, object)| {
        let built = build_object(object, i, &sizes)?;
        let (pose, Soup { vertices, triangles }) = (built.pose(0.0), built.surface());
        let vertices = vertices.iter().map(|at| pose * at).collect();
        Ok(Placed { pose, surface: Soup { vertices, triangles: triangles.clone() } })
    });
    placed.collect()
}

/// A point as a capsule.
pub(super) fn point(at: &Point3<f64>) -> Capsule {
    Capsule { start: *at, end: *at, radius: 0.0 }
}
