//! Fibres at rest.

use nalgebra::{Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, NodeProperties};
use rapunzel_rod_dynamic::{Energy, RodState};
use rapunzel_rod_static::{Chain, Piece, Properties, Shape, StaticError};
use std::sync::Arc;

/// Numbers of a node that determine what follows: its frame, and the electric force on it.
const NUMBERS: usize = 7;

/// A fibre that lies at rest under its weight, other dead forces, and electric ones.
#[derive(Debug, Clone)]
pub(crate) struct RestingRod {
    chain: Chain,
    shape: Shape,
    /// Masses of the nodes, kg.
    masses: Vec<f64>,
    /// Other dead forces on the nodes (world), N.
    pub(crate) loads: Vec<Vector3<f64>>,
    /// Electric forces on the nodes (world) that it lies at rest with, N.
    pub(crate) electric: Vec<Vector3<f64>>,
    /// Charges of its segments, C.
    pub(crate) charges: Vec<f64>,
}

impl RestingRod {
    /// A fibre in its natural shape, without charge.
    pub(crate) fn new(fiber: &Fiber) -> Result<Self, StaticError> {
        let nodes = fiber.segments() + 1;
        let chain = chain(fiber, fiber.nodes())?;
        Ok(Self {
            shape: chain.natural_shape(),
            chain,
            masses: masses(fiber, fiber.nodes()),
            loads: vec![Vector3::zeros(); nodes],
            electric: vec![Vector3::zeros(); nodes],
            charges: vec![0.0; nodes - 1],
        })
    }

    /// Makes the fibre of another matter, given at its nodes; it keeps its shape until it settles.
    pub(crate) fn set_matter(
        &mut self,
        fiber: &Fiber,
        mut matter: Vec<NodeProperties>,
    ) -> Result<(), StaticError> {
        for (node, own) in matter.iter_mut().zip(fiber.nodes()) {
            node.natural_curvature = own.natural_curvature;
        }
        self.chain = chain(fiber, &matter)?;
        self.masses = masses(fiber, &matter);
        Ok(())
    }

    /// Comes to rest from the shape it has under gravity (m/s^2), its loads and its electric
    /// forces. Returns the iterations.
    pub(crate) fn settle(&mut self, gravity: &Vector3<f64>) -> Result<usize, StaticError> {
        let other = self.loads.iter().zip(&self.electric);
        let forces = self.masses.iter().zip(other).map(|(mass, (f, e))| *mass * gravity + f + e);
        self.chain.set_forces(&forces.collect::<Vec<_>>())?;
        let rest = self.chain.relax(&self.shape)?;
        self.shape = rest.shape;
        Ok(rest.iterations)
    }

    /// Positions of the nodes, m, world.
    pub(crate) fn positions(&self) -> &[Point3<f64>] {
        self.shape.positions()
    }

    /// Shape of the fibre, to go back to.
    pub(crate) fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Goes back to where it lay.
    pub(crate) fn lie(&mut self, shape: Shape) {
        self.shape = shape;
    }

    /// Mass of the fibre, kg.
    pub(crate) fn mass(&self) -> f64 {
        self.masses.iter().sum()
    }

    /// State of the fibre, at rest.
    pub(crate) fn state(&self) -> RodState {
        let frames = self.shape.frames();
        let count = frames.len();
        let middle = |ends: &[UnitQuaternion<f64>]| {
            let turn = (ends[0].inverse() * ends[1]).scaled_axis();
            (ends[0] * UnitQuaternion::from_scaled_axis(0.5 * turn)).to_rotation_matrix()
        };
        let curvatures = self.chain.curvatures(&self.shape);
        let last = count - 1;
        let at_node = |i: usize| 0.5 * (curvatures[i.max(1) - 1] + curvatures[i.min(last - 1)]);
        let mut forces = self.chain.forces()[1..].to_vec();
        for i in (1..last).rev() {
            let beyond = forces[i];
            forces[i - 1] += beyond;
        }
        RodState {
            time: 0.0,
            positions: self.positions().to_vec(),
            velocities: vec![Vector3::zeros(); count],
            frames: frames.windows(2).map(middle).collect::<Vec<Rotation3<f64>>>(),
            angular_velocities: vec![Vector3::zeros(); last],
            forces,
            curvatures: (0..count).map(at_node).collect(),
        }
    }

    /// Energy of bending and torsion, and in gravity (m/s^2), J.
    pub(crate) fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        let places = self.masses.iter().zip(self.positions());
        Energy {
            kinetic: 0.0,
            elastic: self.chain.elastic_energy(&self.shape),
            gravitational: -places.map(|(mass, x)| mass * gravity.dot(&x.coords)).sum::<f64>(),
        }
    }

    /// Energy of the fibre but for the electric one, J: the energy of bending and torsion, of
    /// gravity and of the loads.
    pub(crate) fn mechanical_energy(&self, gravity: &Vector3<f64>) -> f64 {
        let Energy { elastic, gravitational, .. } = self.energy(gravity);
        let loads = self.loads.iter().zip(self.positions());
        elastic + gravitational - loads.map(|(load, x)| load.dot(&x.coords)).sum::<f64>()
    }

    /// Appends all numbers that change.
    pub(crate) fn save(&self, numbers: &mut Vec<f64>) {
        for (frame, force) in self.shape.frames().iter().zip(&self.electric) {
            numbers.extend(frame.coords.iter().chain(force.iter()));
        }
        numbers.extend(&self.charges);
    }

    /// How many numbers [`save`](Self::save) writes.
    pub(crate) fn saved(&self) -> usize {
        NUMBERS * self.electric.len() + self.charges.len()
    }

    /// Goes back to as many saved numbers.
    pub(crate) fn restore(&mut self, numbers: &[f64]) -> Result<(), StaticError> {
        let (nodes, charges) = numbers.split_at(NUMBERS * self.electric.len());
        let mut frames = Vec::with_capacity(self.electric.len());
        for (node, force) in nodes.chunks(NUMBERS).zip(&mut self.electric) {
            let [i, j, k, w, x, y, z] = [0, 1, 2, 3, 4, 5, 6].map(|c| node[c]);
            // Normalized already: the bits are to stay.
            frames.push(UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k)));
            *force = Vector3::new(x, y, z);
        }
        self.shape = self.chain.shape_of(frames)?;
        self.charges.copy_from_slice(charges);
        Ok(())
    }
}

/// The chain of a fibre whose nodes have the given properties.
fn chain(fiber: &Fiber, nodes: &[NodeProperties]) -> Result<Chain, StaticError> {
    let segments = fiber.segments();
    let length = fiber.length();
    let nodes: Arc<[NodeProperties]> = nodes.into();
    // A piece is asked at its ends too.
    let at = move |s: f64| {
        #[expect(clippy::cast_possible_truncation, reason = "between 0 and the segments")]
        let k = ((s / length * segments as f64) as usize).min(segments - 1);
        let [a, b] = [&nodes[k], &nodes[k + 1]];
        Properties {
            stiffness: 0.5 * (a.stiffness + b.stiffness),
            natural_curvature: 0.5 * (a.natural_curvature + b.natural_curvature),
            load: Vector3::zeros(),
        }
    };
    Chain::new(fiber.root(), &[Piece::varying(length, at)], segments)
}

/// Masses of the nodes of a fibre whose nodes have the given properties, kg: half of the segments
/// on both sides.
fn masses(fiber: &Fiber, nodes: &[NodeProperties]) -> Vec<f64> {
    let lengths = fiber.segment_lengths();
    let half = |segment: Option<usize>| {
        segment.filter(|s| *s < lengths.len()).map_or(0.0, |s| {
            let density = 0.5 * (nodes[s].linear_density + nodes[s + 1].linear_density);
            0.5 * lengths[s] * density
        })
    };
    (0..=lengths.len()).map(|node| half(node.checked_sub(1)) + half(Some(node))).collect()
}
