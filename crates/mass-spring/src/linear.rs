use crate::supports::Guide;
use crate::tangent::Tangent;
use crate::{SpringError, System};
use nalgebra::{DMatrix, DVector};
use rapunzel_linalg::{Modes, eigen};

/// Small motions about a state: `M s'' + D s' + K s = F`, as in the third text.
///
/// Rows and columns are `D node + axis`. The diagonal of K is the sum of its row over the
/// neighbors, not negligible as the text says (errata, section 9), and K holds for small
/// displacements only.
#[derive(Debug, Clone)]
pub struct Linearized {
    /// The diagonal of M, kg.
    pub masses: DVector<f64>,
    /// Damping matrix D: dampers and drag, N s/m.
    pub damping: DMatrix<f64>,
    /// Stiffness matrix K: second derivatives of the energy, N/m.
    pub stiffness: DMatrix<f64>,
    /// Basis of the motions that the supports allow (columns), orthonormal in the metric of M.
    free: DMatrix<f64>,
}

/// Largest number of components for which dense matrices are built.
const MOST_COMPONENTS: usize = 6000;

impl<const D: usize> System<D> {
    /// The matrices of small motions about the present state. They are dense: for systems of up to
    /// 6000 components.
    ///
    /// # Errors
    /// [`SpringError::Count`] for larger ones.
    pub fn linearized(&self) -> Result<Linearized, SpringError> {
        let count = D * self.nodes();
        if count > MOST_COMPONENTS {
            let expected = format!("at most {MOST_COMPONENTS}, because the matrices are dense");
            return Err(SpringError::Count { what: "components", found: count, expected });
        }
        let assembled = |tangent: &Tangent<D>| {
            let mut matrix = DMatrix::zeros(count, count);
            tangent.blocks(|row, column, block| {
                let mut part = matrix.fixed_view_mut::<D, D>(D * row, D * column);
                part += block;
            });
            matrix
        };
        let stiffness = assembled(&Tangent::new(self, &self.positions, 0.0, 0.0, false));
        // Dampers are what a unit of damping adds.
        let damping = assembled(&Tangent::new(self, &self.positions, self.drag, 1.0, false))
            - assembled(&Tangent::new(self, &self.positions, 0.0, 0.0, false));
        let masses = DVector::from_fn(count, |row, _| self.masses[row / D]);
        Ok(Linearized { masses, damping, stiffness, free: self.free_motions(count) })
    }

    fn free_motions(&self, count: usize) -> DMatrix<f64> {
        let mut columns: Vec<Vec<(usize, f64)>> = Vec::new();
        for row in 0..count {
            let (node, axis) = (row / D, row % D);
            if self.supports.guide(node, axis) == Guide::Free {
                columns.push(vec![(row, 1.0 / self.masses[node].sqrt())]);
            }
        }
        for tie in &self.supports.ties {
            let first = tie.nodes.first().map(|&node| self.supports.guide(node, tie.axis));
            if first.is_some_and(|guide| guide != Guide::Driven) {
                let mass: f64 = tie.nodes.iter().map(|&node| self.masses[node]).sum();
                let row = |&node: &usize| (D * node + tie.axis, 1.0 / mass.sqrt());
                columns.push(tie.nodes.iter().map(row).collect());
            }
        }
        let mut free = DMatrix::zeros(count, columns.len());
        for (column, entries) in columns.iter().enumerate() {
            entries.iter().for_each(|&(row, value)| free[(row, column)] = value);
        }
        free
    }
}

impl Linearized {
    /// Modes of the motions that the supports allow: shapes are displacements with M-norm 1. Costs
    /// the eigenvalues of a dense matrix.
    ///
    /// # Errors
    /// [`SpringError::Vibration`] where the iteration for the eigenvalues does not converge.
    pub fn modes(&self) -> Result<Modes, SpringError> {
        let Modes { squares, shapes } =
            eigen(&(self.free.transpose() * &self.stiffness * &self.free))?;
        Ok(Modes { squares, shapes: &self.free * shapes })
    }
}
