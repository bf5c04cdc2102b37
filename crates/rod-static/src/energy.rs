//! The energy of a [`Chain`] as a function of its shape, for other minimisers.

use crate::StaticError;
use crate::chain::Chain;
use crate::segment::{Blocks, turn};
use crate::shape::Shape;
use crate::trial::TrialShape;
use nalgebra::Vector3;

impl Chain {
    /// Elastic energy, J.
    #[must_use]
    pub fn elastic_energy(&self, shape: &Shape) -> f64 {
        let turns = shape.frames.windows(2).map(|ends| turn(&ends[0], &ends[1]));
        turns.zip(&self.segments).map(|(turn, segment)| segment.elastic(&turn)).sum()
    }

    /// Work of the dead forces if the nodes move from the world's origin to their positions, J.
    #[must_use]
    pub fn work(&self, shape: &Shape) -> f64 {
        self.forces.iter().zip(&shape.positions).map(|(f, at)| f.dot(&at.coords)).sum()
    }

    /// Energy of a shape, J: elastic energy, energy of the dead forces (minus force times position,
    /// from the world's origin), and energy of the springs of the targets (3.130).
    ///
    /// # Errors
    /// A shape of another number of nodes.
    pub fn energy(&self, shape: &Shape) -> Result<f64, StaticError> {
        self.check(shape)?;
        let springs = self.targets.iter().filter(|target| !target.is_held()).map(|target| {
            let gap = shape.positions[target.node] - target.place;
            0.5 * target.stiffness * gap.norm_squared()
        });
        Ok(self.elastic_energy(shape) - self.work(shape) + springs.sum::<f64>())
    }

    /// Derivatives of [`Chain::energy`] by the rotations of the nodes behind the clamp, N m:
    /// rotation vectors in the nodes' own axes. Exact, with the adjoint: the force in a segment is
    /// the sum of all beyond. They vanish in equilibrium where nothing is held.
    ///
    /// # Errors
    /// A shape of another number of nodes.
    pub fn gradient(&self, shape: &Shape) -> Result<Vec<Vector3<f64>>, StaticError> {
        let blocks = self.blocks(shape)?;
        let next = |i: usize| blocks.get(i + 1).map_or_else(Vector3::zeros, |b| b.gradient[0]);
        Ok((0..blocks.len()).map(|i| blocks[i].gradient[1] + next(i)).collect())
    }

    /// The Hessian of [`Chain::energy`] along the geodesics `R exp(t b)` of all nodes behind the
    /// clamp, times the rotations `by`, N m.
    ///
    /// # Errors
    /// A shape or rotations of another number of nodes.
    pub fn hessian_product(
        &self,
        shape: &Shape,
        by: &[Vector3<f64>],
    ) -> Result<Vec<Vector3<f64>>, StaticError> {
        let blocks = self.blocks(shape)?;
        self.check_free(by)?;
        let mut product: Vec<Vector3<f64>> = (0..blocks.len())
            .map(|i| {
                let mut sum = blocks[i].behind * by[i];
                if i > 0 {
                    sum += blocks[i].mixed * by[i - 1];
                }
                if let Some(next) = blocks.get(i + 1) {
                    sum += next.before * by[i] + next.mixed.tr_mul(&by[i + 1]);
                }
                sum
            })
            .collect();
        let springs = self.targets.iter().filter(|target| !target.is_held());
        for target in springs {
            let motions = &self.trial(shape).motions(self)[..target.node];
            let pull = target.stiffness * crate::newton::moved(motions, by);
            for (s, motion) in motions.iter().enumerate() {
                product[s] += motion[1].tr_mul(&pull);
                if s > 0 {
                    product[s - 1] += motion[0].tr_mul(&pull);
                }
            }
        }
        Ok(product)
    }

    pub(crate) fn trial(&self, shape: &Shape) -> TrialShape {
        TrialShape::new(self, shape.frames.clone(), &self.carried(&shape.frames, 0.0, &[]))
    }

    fn blocks(&self, shape: &Shape) -> Result<Vec<Blocks>, StaticError> {
        self.check(shape)?;
        let trial = self.trial(shape);
        let mut pulls = vec![Vector3::zeros(); self.targets.len()];
        self.stretch_springs(&trial, &mut pulls);
        Ok(trial.blocks(self, &self.carried(&shape.frames, 0.0, &pulls)))
    }
}
