use nalgebra::{SMatrix, SVector};

/// A block tridiagonal system: row `j` has `lower[j]` (unused for j = 0), `diagonal[j]` and
/// `upper[j]` (unused for the last).
#[derive(Debug, Clone, Default)]
pub(super) struct Tridiagonal<const D: usize> {
    pub(super) lower: Vec<SMatrix<f64, D, D>>,
    pub(super) diagonal: Vec<SMatrix<f64, D, D>>,
    pub(super) upper: Vec<SMatrix<f64, D, D>>,
}

impl<const D: usize> Tridiagonal<D> {
    /// Solves for `right`, in place, by block elimination in O(rows); the index of the row whose
    /// block is singular if one is. Uses up the blocks.
    pub(super) fn solve(&mut self, right: &mut [SVector<f64, D>]) -> Result<(), usize> {
        for j in 0..right.len() {
            if j > 0 {
                let (factor, above) = (self.lower[j], self.upper[j - 1]);
                self.diagonal[j] -= factor * above;
                right[j] -= factor * right[j - 1];
            }
            let inverse = self.diagonal[j].try_inverse().ok_or(j)?;
            self.upper[j] = inverse * self.upper[j];
            right[j] = inverse * right[j];
        }
        for j in (0..right.len().saturating_sub(1)).rev() {
            right[j] -= self.upper[j] * right[j + 1];
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_solution_solves(numbers in prop::collection::vec(-1.0..1.0_f64, 5 * 30)) {
            let block = |k: usize| {
                SMatrix::<f64, 3, 3>::from_column_slice(&numbers[k * 9..k * 9 + 9])
            };
            let (blocks, rows) = (15, 5);
            prop_assume!(numbers.len() >= blocks * 9 + rows * 3);
            let system = Tridiagonal {
                lower: (0..rows).map(block).collect(),
                diagonal: (0..rows).map(|j| block(5 + j) + 6.0 * SMatrix::identity()).collect(),
                upper: (0..rows).map(|j| block(10 + j)).collect(),
            };
            let right: Vec<SVector<f64, 3>> = (0..rows)
                .map(|j| SVector::from_column_slice(&numbers[135 + 3 * j..138 + 3 * j]))
                .collect();
            let mut x = right.clone();
            system.clone().solve(&mut x).expect("dominant");
            for j in 0..rows {
                let mut left = system.diagonal[j] * x[j];
                if j > 0 { left += system.lower[j] * x[j - 1]; }
                if j + 1 < rows { left += system.upper[j] * x[j + 1]; }
                prop_assert!((left - right[j]).norm() < 1e-13);
            }
        }
    }

    #[test]
    fn a_singular_block_is_named() {
        let mut system = Tridiagonal::<3> {
            lower: vec![SMatrix::zeros(); 2],
            diagonal: vec![SMatrix::identity(), SMatrix::zeros()],
            upper: vec![SMatrix::zeros(); 2],
        };
        assert_eq!(system.solve(&mut [SVector::zeros(); 2]), Err(1));
    }
}
