use crate::CollisionObject;
use nalgebra::Vector3;
use rapunzel_scene::Environment;

/// What is around something that moves, during one step.
pub struct Surroundings<'a> {
    /// Gravity, air and climate.
    pub environment: &'a Environment,
    /// All objects; those that move freely belong to whoever solves their contacts.
    pub objects: &'a mut [CollisionObject],
    /// Start of the step, s.
    pub start: f64,
    /// End of the step, s.
    pub end: f64,
}

impl Surroundings<'_> {
    /// Gravity at the start of the step, m/s^2, world.
    #[must_use]
    pub fn gravity(&self) -> Vector3<f64> {
        self.environment.gravity_at(self.start)
    }
}
