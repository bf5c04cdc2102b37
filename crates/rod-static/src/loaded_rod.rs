//! A rod with forces on its nodes and in the middles of its segments.

use crate::chain::{Chain, TipHold};
use crate::riccati::{OnRod, RootSupport};
use crate::segment::{Blocks, turn};
use crate::state::State;
use nalgebra::{Isometry3, Matrix3, Point3, UnitQuaternion, Vector3};

/// A rod of an assembly under its own loads and the forces of contacts and supports.
#[derive(Debug, Clone)]
pub(crate) struct LoadedRod<'a> {
    chain: &'a Chain,
    root: RootSupport,
    frames: &'a [UnitQuaternion<f64>],
    turns: Vec<Vector3<f64>>,
    /// Forces of contacts and supports, N, world frame.
    forces: &'a OnRod<Vector3<f64>>,
    /// Forces in the segments behind their middles, N, world frame.
    carried: Vec<Vector3<f64>>,
}

/// Positions of the nodes of a chain and of the middles of its segments, m, world frame.
pub(crate) fn places(
    chain: &Chain,
    frames: &[UnitQuaternion<f64>],
    root: &Point3<f64>,
) -> OnRod<Point3<f64>> {
    let mut places = OnRod::filled(root, chain.segments.len());
    for (i, segment) in chain.segments.iter().enumerate() {
        let turn = turn(&frames[i], &frames[i + 1]);
        places.middles[i] = places.nodes[i] + frames[i] * segment.half_chord(&turn);
        places.nodes[i + 1] = places.nodes[i] + frames[i] * segment.chord(&turn);
    }
    places
}

impl<'a> LoadedRod<'a> {
    pub(crate) fn new(
        chain: &'a Chain,
        root: RootSupport,
        frames: &'a [UnitQuaternion<f64>],
        forces: &'a OnRod<Vector3<f64>>,
    ) -> Self {
        let count = chain.segments.len();
        let mut carried = vec![Vector3::zeros(); count];
        let mut beyond = Vector3::zeros();
        for i in (0..count).rev() {
            beyond += chain.forces[i + 1] + forces.nodes[i + 1];
            carried[i] = beyond;
            beyond += forces.middles[i];
        }
        let turns = frames.windows(2).map(|ends| turn(&ends[0], &ends[1])).collect();
        Self { chain, root, frames, turns, forces, carried }
    }

    /// Gradients and Hessians of the segments.
    pub(crate) fn blocks(&self) -> Vec<Blocks> {
        let block = |i: usize| {
            let frame = &self.frames[i];
            let local = |force: &Vector3<f64>| frame.inverse_transform_vector(force);
            let push = &self.forces.middles[i];
            let push = (*push != Vector3::zeros()).then(|| local(push));
            let segment = &self.chain.segments[i];
            segment.blocks_pushed(&self.turns[i], &local(&self.carried[i]), push.as_ref())
        };
        (0..self.turns.len()).map(block).collect()
    }

    /// Derivatives of the ends and of the middles of the segments by the variations of their
    /// frames, world frame.
    pub(crate) fn motions(&self) -> [Vec<[Matrix3<f64>; 2]>; 2] {
        let all = self.chain.segments.iter().zip(&self.turns).zip(self.frames);
        let all = all.map(|((segment, turn), frame)| {
            let frame = frame.to_rotation_matrix();
            let world = |motion: [Matrix3<f64>; 2]| motion.map(|own| frame.matrix() * own);
            (world(segment.motion(turn)), world(segment.half_motion(turn)))
        });
        let (ends, middles) = all.unzip();
        [ends, middles]
    }

    /// Moments (N m, in the nodes' own axes) on all nodes, and the force on the root, N, that
    /// nothing balances; none where supports hold.
    pub(crate) fn residual(&self, blocks: &[Blocks]) -> (Vec<Vector3<f64>>, Vector3<f64>) {
        let count = blocks.len();
        let mut moments = vec![Vector3::zeros(); count + 1];
        for (i, block) in blocks.iter().enumerate() {
            moments[i] -= block.gradient[0];
            moments[i + 1] -= block.gradient[1];
        }
        if self.root == RootSupport::Clamped {
            moments[0] = Vector3::zeros();
        }
        if self.chain.tip == TipHold::Held {
            moments[count] = Vector3::zeros();
        }
        let free = self.root == RootSupport::Free;
        let whole =
            self.carried[0] + self.forces.middles[0] + self.forces.nodes[0] + self.chain.forces[0];
        (moments, if free { whole } else { Vector3::zeros() })
    }

    /// Energy of the rod and its own loads, J.
    pub(crate) fn energy(
        chain: &Chain,
        frames: &[UnitQuaternion<f64>],
        places: &OnRod<Point3<f64>>,
    ) -> f64 {
        let turns = frames.windows(2).map(|ends| turn(&ends[0], &ends[1]));
        let elastic = turns.zip(&chain.segments).map(|(turn, segment)| segment.elastic(&turn));
        let work = chain.forces.iter().zip(&places.nodes).map(|(f, at)| f.dot(&at.coords));
        elastic.sum::<f64>() - work.sum::<f64>()
    }

    /// States of the nodes, as [`Chain::states`] has them for the rod's own loads; the forces of
    /// contacts and supports jump where they act, and one on a node counts as beyond it.
    pub(crate) fn states(&self, root: &Point3<f64>) -> Vec<State> {
        let places = places(self.chain, self.frames, root);
        let blocks = self.blocks();
        let count = blocks.len();
        let mut chain = self.chain.clone();
        chain.clamp = Isometry3::from_parts(root.coords.into(), self.frames[0]);
        chain.targets.clear();
        let own = chain.carried(self.frames, 0.0, &[]);
        let mut beyond = vec![Vector3::zeros(); count + 1];
        beyond[count] = self.forces.nodes[count];
        for i in (0..count).rev() {
            let node = if i > 0 { self.forces.nodes[i] } else { Vector3::zeros() };
            beyond[i] = beyond[i + 1] + self.forces.middles[i] + node;
        }
        let state = |i: usize| {
            let moment = if i == 0 { -blocks[0].gradient[0] } else { blocks[i - 1].gradient[1] };
            let frame = self.frames[i];
            State {
                position: places.nodes[i],
                frame: frame.to_rotation_matrix(),
                force: Chain::force_at(&own, i) + beyond[i],
                moment: frame * moment,
            }
        };
        (0..=count).map(state).collect()
    }
}
