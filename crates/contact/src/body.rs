use crate::{ContactError, DelassusBlocks};
use nalgebra::Vector3;

/// Something that moves, or several such things, as a contact solver sees it: points that answer
/// impulses with velocities.
///
/// The answer is linear, symmetric and positive semidefinite: with `H` the map from the state to
/// the velocities of the points and `A` the inertia of a step, impulses `p` on the points change
/// their velocities by `H A^-1 H^T p`. Vectors are in the world frame.
pub trait Body: Send {
    /// Number of points.
    fn points(&self) -> usize;

    /// Adds a mass (kg, not negative) at every point, in place of those added before, for
    /// [`Body::weighted_respond`].
    ///
    /// # Errors
    /// [`ContactError::Body`] if that cannot be solved.
    fn set_weights(&mut self, weights: &[f64]) -> Result<(), ContactError>;

    /// Writes the changes of the points' velocities, m/s, world, that `impulses`, N s, world,
    /// cause.
    fn respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]);

    /// Writes the changes of the points' velocities, m/s, world, that `impulses` cause with the
    /// added masses `M` of [`Body::set_weights`]: `H (A + H^T M H)^-1 H^T p`.
    fn weighted_respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]);

    /// Takes the masses of [`Body::set_weights`] away: no answer with them is asked for until
    /// others have been set. Of use to who needs much memory for them.
    fn forget_weights(&mut self) {}

    /// Writes the trace of every point's answer to an impulse on itself, 1/kg.
    fn own_traces(&mut self, traces: &mut [f64]);

    /// Its mass, kg, if it is one body that nothing but contacts holds; then errors of impulses at
    /// its contacts are judged by the heaviest that moves with it ([`crate::FreeMasses`]).
    fn free_mass(&self) -> Option<f64> {
        None
    }

    /// Delassus operator of all points, without added masses, as dense blocks where these are at
    /// hand: by groups of points that do not answer each other, the points of each group and their
    /// blocks. `None` where it would have to be asked for.
    fn dense_delassus(&self) -> Option<Vec<(&[usize], &DelassusBlocks)>> {
        None
    }
}
