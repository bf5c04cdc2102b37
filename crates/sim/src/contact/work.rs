use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Work that contacts have done on fibres and free objects, J: impulses times the mean velocities of
/// the steps in which they acted, which backward Euler ends with. A rebound so does work, and the
/// integrator takes more than that: half the mass times the squared change of velocity.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ContactWork {
    /// Of friction against the slip, not positive but for the solver's tolerance.
    pub friction: f64,
    /// Of what acts along the normals against the opening of contacts: gaps that close by the end of
    /// a step or are repaired, restitution, adhesion.
    pub normal: f64,
    /// Of objects that are led: all of their impulses times the velocities of their surfaces.
    pub led: f64,
}

impl AddAssign for ContactWork {
    fn add_assign(&mut self, other: Self) {
        self.friction += other.friction;
        self.normal += other.normal;
        self.led += other.led;
    }
}
