use crate::chain::{Chain, turn_by};
use crate::segment::{Blocks, turn};
use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};

/// A shape of a [`Chain`] with the quantities that the search for the equilibrium needs.
#[derive(Debug, Clone)]
pub(crate) struct TrialShape {
    pub(crate) frames: Vec<UnitQuaternion<f64>>,
    turns: Vec<Vector3<f64>>,
    /// Energy of the chain, of the dead forces from the clamp on, and of the springs.
    pub(crate) energy: f64,
    /// Vectors from the targets' places to their nodes, m, world frame.
    pub(crate) gaps: Vec<Vector3<f64>>,
}

impl TrialShape {
    /// Computes the quantities of the shape with the given frames; `dead` are the sums of the dead
    /// forces beyond, N, world frame.
    pub(crate) fn new(
        chain: &Chain,
        frames: Vec<UnitQuaternion<f64>>,
        dead: &[Vector3<f64>],
    ) -> Self {
        let mut at = Point3::from(chain.clamp.translation.vector);
        let mut trial = Self {
            turns: Vec::with_capacity(dead.len()),
            energy: 0.0,
            gaps: chain.targets.iter().map(|target| at - target.place).collect(),
            frames,
        };
        for (i, segment) in chain.segments.iter().enumerate() {
            let turn = turn(&trial.frames[i], &trial.frames[i + 1]);
            let chord = trial.frames[i] * segment.chord(&turn);
            trial.energy += segment.elastic(&turn) - dead[i].dot(&chord);
            trial.turns.push(turn);
            at += chord;
            for (gap, target) in trial.gaps.iter_mut().zip(&chain.targets) {
                if target.node == i + 1 {
                    *gap = at - target.place;
                    if !target.is_held() {
                        trial.energy += 0.5 * target.stiffness * gap.norm_squared();
                    }
                }
            }
        }
        trial
    }

    /// This shape after the variations `step`, times `part`, of the nodes behind the clamp.
    pub(crate) fn moved(
        &self,
        chain: &Chain,
        dead: &[Vector3<f64>],
        step: &[Vector3<f64>],
        part: f64,
    ) -> Self {
        let mut frames = self.frames.clone();
        turn_by(&mut frames, step, part);
        Self::new(chain, frames, dead)
    }

    /// Sum of the distances between the held nodes and their places, m.
    pub(crate) fn missed(&self, chain: &Chain) -> f64 {
        let held = self.gaps.iter().zip(&chain.targets).filter(|(_, target)| target.is_held());
        held.map(|(gap, _)| gap.norm()).sum()
    }

    /// Gradients and Hessians of the segments that carry the given forces, world frame.
    pub(crate) fn blocks(&self, chain: &Chain, carried: &[Vector3<f64>]) -> Vec<Blocks> {
        let segments = chain.segments.iter().zip(&self.turns).zip(&self.frames).zip(carried);
        segments
            .map(|(((segment, turn), frame), force)| {
                segment.blocks(turn, &frame.inverse_transform_vector(force))
            })
            .collect()
    }

    /// Derivatives of the ends of the segments by the variations of their frames, world frame.
    pub(crate) fn motions(&self, chain: &Chain) -> Vec<[Matrix3<f64>; 2]> {
        let segments = chain.segments.iter().zip(&self.turns).zip(&self.frames);
        segments
            .map(|((segment, turn), frame)| {
                let frame = frame.to_rotation_matrix();
                segment.motion(turn).map(|motion| frame.matrix() * motion)
            })
            .collect()
    }
}
