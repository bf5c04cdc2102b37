use crate::StaticError;
use crate::chain::Chain;
use crate::shape::Shape;
use nalgebra::{UnitQuaternion, Vector3};

impl Chain {
    /// Pai's two phases: forces and curvatures are integrated by Euler's method from the tip to the
    /// clamp, then frames from the clamp to the tip (3.128, 3.129, both corrected in sign). A fast
    /// approximation, of first order, without iteration.
    ///
    /// All forces are treated as following ones: the dead ones in the axes that the nodes have in
    /// `reference`. That is good for small loads, or with a nearby shape as reference; with the
    /// equilibrium itself as reference the result is that equilibrium. Targets are left out.
    ///
    /// # Errors
    /// A reference of another number of nodes.
    pub fn two_phase(&self, reference: &Shape) -> Result<Shape, StaticError> {
        self.check(reference)?;
        let count = self.segments.len();
        let load = |node: usize| {
            reference.frames[node].inverse_transform_vector(&self.forces[node])
                + self.followers[node]
        };
        // First phase, from tip to clamp: moment and force in the material frame, and the
        // rotations.
        let mut force = load(count);
        let mut moment = self.tip_couple;
        let mut turns = vec![Vector3::zeros(); count];
        for (i, segment) in self.segments.iter().enumerate().rev() {
            let (length, strain) = (segment.length, moment.component_div(&segment.stiffness));
            let curvature = segment.natural_curvature + strain;
            turns[i] = curvature * length;
            moment += (curvature.cross(&moment) + Vector3::z().cross(&force)) * length;
            force += curvature.cross(&force) * length + load(i);
        }
        // Second phase, from clamp to tip: frames.
        let mut frames = vec![self.clamp.rotation];
        for (i, turn) in turns.iter().enumerate() {
            frames.push(frames[i] * UnitQuaternion::from_scaled_axis(*turn));
        }
        Ok(self.shape(frames))
    }
}
