//! What fibres lie on and bump into, and each other.

use crate::TimeInterval;
use crate::free_body::FreeBody;
use nalgebra::{Isometry3, Point3, Rotation3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::field::{DistanceField, Soup};
use rapunzel_contact::{ContactError, RigidBody};
use rapunzel_rod_dynamic::Energy;
use rapunzel_scene::FrictionLaw;
use std::sync::Arc;

/// A distance field that objects share with whoever else asks it.
pub type Field = Arc<dyn DistanceField + Send + Sync>;

/// What an object is like, in its own frame.
#[derive(Clone)]
pub struct ObjectGeometry {
    /// Distance to the surface.
    pub field: Field,
    /// Capsules that touch other objects: the edges, or a round shape itself.
    pub edge_capsules: Vec<Capsule>,
    /// What is shown of the surface.
    pub surface: Soup,
    /// Whether the object reaches on beyond what is shown of it.
    pub endless: bool,
}

/// A surface and what moves it.
pub struct CollisionObject {
    pub(crate) geometry: ObjectGeometry,
    /// Corners of the box around the surface, in the object's frame.
    corners: [Point3<f64>; 8],
    /// Smallest extent, m; infinite for what has no end.
    pub(crate) size: f64,
    /// Friction of what lies on the object; `None` for the scene's.
    pub(crate) friction: Option<FrictionLaw>,
    /// Restitution of what bounces off the object; `None` for the scene's.
    pub(crate) restitution: Option<f64>,
    pub(crate) motion: ObjectMotion,
}

/// What moves an object.
pub enum ObjectMotion {
    /// A motion that is given: the pose at a time, s.
    Kinematic(Box<dyn Fn(f64) -> Isometry3<f64> + Send + Sync>),
    /// Gravity and contacts.
    Dynamic(Box<FreeBody>),
}

/// Where an object is before and after a step.
pub(crate) struct MovingObject {
    /// Poses at the start and at the end of the step, world.
    pub(crate) poses: [Isometry3<f64>; 2],
    /// Rotations of these poses.
    pub(crate) turns: [Rotation3<f64>; 2],
    /// Mean angular velocity of a given motion, rad/s, world.
    pub(crate) spin: Vector3<f64>,
    /// Length of the step, s.
    pub(crate) length: f64,
}

impl MovingObject {
    pub(crate) fn new(object: &CollisionObject, step: TimeInterval) -> Self {
        let poses = object.poses(step);
        let spin = if poses[0] == poses[1] { Vector3::zeros() } else { object.led_spin(step) };
        let turns = poses.map(|pose| pose.rotation.to_rotation_matrix());
        Self { poses, turns, spin, length: step.length }
    }
}

impl CollisionObject {
    /// An object; `friction` and `restitution` stand in for the scene's where they are given.
    #[must_use]
    pub fn new(
        geometry: ObjectGeometry,
        motion: ObjectMotion,
        friction: Option<FrictionLaw>,
        restitution: Option<f64>,
    ) -> Self {
        let ends = extents(&geometry.surface);
        let corners = std::array::from_fn(|c| Point3::from([0, 1, 2].map(|k| ends[k][c >> k & 1])));
        let least = ends.iter().map(|[low, high]| high - low).fold(f64::INFINITY, f64::min);
        let size = if geometry.endless { f64::INFINITY } else { least };
        Self { geometry, corners, size, friction, restitution, motion }
    }

    /// The distance field, in the object's frame.
    #[must_use]
    pub fn field(&self) -> &Field {
        &self.geometry.field
    }

    /// What is shown of the surface, in the object's frame.
    #[must_use]
    pub fn surface(&self) -> &Soup {
        &self.geometry.surface
    }

    /// The pose at the time `t` (s) of an object with a given motion, or between steps of a free
    /// one.
    #[must_use]
    pub fn pose(&self, t: f64) -> Isometry3<f64> {
        match &self.motion {
            ObjectMotion::Kinematic(pose) => pose(t),
            ObjectMotion::Dynamic(body) => body.poses()[0],
        }
    }

    /// The rigid body, if gravity and contacts move the object.
    #[must_use]
    pub fn body(&self) -> Option<&RigidBody> {
        self.free_body().map(FreeBody::body)
    }

    /// Gives a kinematic object another motion, the pose at a time (s); false, and nothing done,
    /// for one that moves freely.
    pub fn lead(&mut self, pose: Box<dyn Fn(f64) -> Isometry3<f64> + Send + Sync>) -> bool {
        let is_led = !self.is_free();
        if is_led {
            self.motion = ObjectMotion::Kinematic(pose);
        }
        is_led
    }

    /// Energy of a free body, J, in a gravity, m/s^2; `None` for a given motion.
    #[must_use]
    pub fn energy(&self, gravity: &Vector3<f64>) -> Option<Energy> {
        self.free_body().map(|body| body.energy(gravity))
    }

    /// The object held where it is at a time, s. Copies its surface.
    #[must_use]
    pub fn held(&self, t: f64) -> Self {
        let pose = self.pose(t);
        Self {
            geometry: self.geometry.clone(),
            motion: ObjectMotion::Kinematic(Box::new(move |_| pose)),
            ..*self
        }
    }

    /// Appends all numbers that change.
    pub fn save(&self, numbers: &mut Vec<f64>) {
        if let ObjectMotion::Dynamic(body) = &self.motion {
            body.save(numbers);
        }
    }

    /// Goes back to saved numbers and returns the rest of them; `None` if there are too few.
    pub fn restore<'a>(&mut self, numbers: &'a [f64]) -> Option<&'a [f64]> {
        match &mut self.motion {
            ObjectMotion::Kinematic(_) => Some(numbers),
            ObjectMotion::Dynamic(body) => body.restore(numbers),
        }
    }

    pub(crate) fn free_body(&self) -> Option<&FreeBody> {
        match &self.motion {
            ObjectMotion::Kinematic(_) => None,
            ObjectMotion::Dynamic(body) => Some(body),
        }
    }

    pub(crate) fn is_free(&self) -> bool {
        matches!(self.motion, ObjectMotion::Dynamic(_))
    }

    /// Poses of the object at the start and at the end of a step.
    #[must_use]
    pub fn poses(&self, step: TimeInterval) -> [Isometry3<f64>; 2] {
        match &self.motion {
            ObjectMotion::Kinematic(pose) => [pose(step.start), pose(step.start + step.length)],
            ObjectMotion::Dynamic(body) => body.poses(),
        }
    }

    /// Mean angular velocity over a step of an object with a given motion, rad/s; zero for one that
    /// moves freely.
    pub(crate) fn led_spin(&self, step: TimeInterval) -> Vector3<f64> {
        if self.is_free() {
            return Vector3::zeros();
        }
        let [start, end] = self.poses(step);
        start.rotation.rotation_to(&end.rotation).scaled_axis() / step.length
    }

    /// Poses of the object at the start and at the end of a step, if nothing is in its way.
    pub(crate) fn free_poses(
        &self,
        step: TimeInterval,
        gravity: &Vector3<f64>,
    ) -> Result<[Isometry3<f64>; 2], ContactError> {
        match &self.motion {
            ObjectMotion::Kinematic(_) => Ok(self.poses(step)),
            ObjectMotion::Dynamic(body) => body.fall(step.length, gravity),
        }
    }

    /// The longest way, m, of a point of its surface from one pose to another.
    pub(crate) fn way(&self, poses: &[Isometry3<f64>; 2]) -> f64 {
        longest_way(&self.corners, poses)
    }

    /// The longest way, m, of a point of the edge capsules from one pose to another: a round shape
    /// turns in itself.
    pub(crate) fn way_of_skeleton(&self, poses: &[Isometry3<f64>; 2]) -> f64 {
        match self.geometry.edge_capsules[..] {
            [Capsule { start, end, .. }] => longest_way(&[start, end], poses),
            _ => self.way(poses),
        }
    }

    /// Center and radius, m, of a ball around it at a pose; the radius is infinite for what has no
    /// end.
    pub(crate) fn ball(&self, pose: &Isometry3<f64>) -> (Point3<f64>, f64) {
        let [low, high] = [&self.corners[0], &self.corners[7]];
        let radius = if self.size.is_finite() { 0.5 * (high - low).norm() } else { f64::INFINITY };
        (pose * nalgebra::center(low, high), radius)
    }
}

fn longest_way(corners: &[Point3<f64>], [start, end]: &[Isometry3<f64>; 2]) -> f64 {
    // The way is a convex function of the place: at a corner it is longest.
    let ways = corners.iter().map(|corner| (end * corner - start * corner).norm());
    ways.fold(0.0, f64::max)
}

/// The least and the largest coordinate of a surface along each axis, m.
pub fn extents(surface: &Soup) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|k| {
        let along = surface.vertices.iter().map(|p| p[k]);
        [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
    })
}
