//! How loads of joints move them, kept from when it was last taken.

use super::network::{GroupLoads, Link, Network};
use nalgebra::{DMatrix, DVector, Dyn, LU, Matrix3, Matrix6};
use rapunzel_linalg::{LinalgError, SparseSystem};

/// Largest number of unknowns of joints that are solved without regard to zeros.
const DENSE: usize = 120;
/// Largest residual of a solution in parts of the sizes that it is made of.
const LARGEST_RESIDUAL: f64 = 1e-8;

/// The system of all joints at one linearisation, factorised. Later ones are solved with it too, in
/// passes that each leave as much of the error as it has changed by.
pub(super) struct JointMatrix {
    terms: MatrixTerms,
    /// By cluster.
    factors: Vec<ClusterFactors>,
}

/// What the system is made of.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MatrixTerms {
    /// Length of the step, s.
    pub(super) dt: f64,
    /// By group and lane, the change of ways of its points by loads, m or rad per N or N m.
    pub(super) responses: Vec<Vec<DMatrix<f64>>>,
    /// By link, the second derivatives of the energies of junctions, N m.
    pub(super) hessians: Vec<Option<Matrix6<f64>>>,
}

enum ClusterFactors {
    Dense(LU<f64, Dyn, Dyn>),
    Sparse(SparseSystem),
}

impl JointMatrix {
    /// Factorises the system.
    ///
    /// # Errors
    /// [`LinalgError`] where joints hold what cannot move.
    pub(super) fn new(network: &Network, terms: MatrixTerms) -> Result<Self, LinalgError> {
        let factors = network.clusters.iter().map(|(members, size)| {
            let entries = entries(network, members, &terms);
            factorized(*size, &entries)
        });
        Ok(Self { factors: factors.collect::<Result<_, _>>()?, terms })
    }

    /// What it is made of.
    pub(super) fn terms(&self) -> &MatrixTerms {
        &self.terms
    }

    /// Changes of the unknowns, by cluster, that take away residuals.
    ///
    /// # Errors
    /// [`LinalgError`] where joints hold what cannot move.
    pub(super) fn solve(
        &self,
        residuals: &[DVector<f64>],
    ) -> Result<Vec<DVector<f64>>, LinalgError> {
        let each = self.factors.iter().zip(residuals);
        each.map(|(factors, right)| factors.solve(right)).collect()
    }
}

impl ClusterFactors {
    fn solve(&self, right: &DVector<f64>) -> Result<DVector<f64>, LinalgError> {
        match self {
            Self::Dense(factors) => factors.solve(right).ok_or(LinalgError::Singular),
            Self::Sparse(system) => {
                let columns = DMatrix::from_column_slice(right.len(), 1, right.as_slice());
                Ok(system.solve(&columns)?.column(0).into_owned())
            }
        }
    }
}

impl MatrixTerms {
    /// Terms of a network in which nothing is known, with the sizes of those that are.
    fn unknown(network: &Network) -> Self {
        let of_group = |group: &GroupLoads| {
            let counts = group.counts().into_iter();
            counts.map(|count| DMatrix::zeros(3 * count, 3 * count)).collect()
        };
        let responses = network.groups.iter().map(of_group).collect();
        let hessian = |link: &Link| link.junction.is_some().then(Matrix6::zeros);
        let hessians = network.links.iter().map(hessian).collect();
        Self { dt: 0.0, responses, hessians }
    }

    /// All numbers, as many for all networks of these joints.
    pub(super) fn numbers(network: &Network, known: Option<&JointMatrix>) -> Vec<f64> {
        let unknown;
        let terms = match known {
            Some(matrix) => &matrix.terms,
            None => {
                unknown = Self::unknown(network);
                &unknown
            }
        };
        let mut numbers = vec![terms.dt];
        numbers.extend(terms.responses.iter().flatten().flat_map(DMatrix::iter));
        numbers.extend(terms.hessians.iter().flatten().flat_map(|hessian| hessian.iter()));
        numbers
    }

    /// The terms with these numbers, as many as [`Self::numbers`] tells; none if they tell none.
    pub(super) fn of_numbers(network: &Network, numbers: &[f64]) -> Option<Self> {
        let mut terms = Self::unknown(network);
        let (dt, rest) = numbers.split_first()?;
        terms.dt = *dt;
        let own = terms.responses.iter_mut().flatten().flat_map(DMatrix::iter_mut);
        let hessians = terms.hessians.iter_mut().flatten().flat_map(Matrix6::iter_mut);
        own.chain(hessians).zip(rest).for_each(|(own, saved)| *own = *saved);
        (*dt > 0.0).then_some(terms)
    }
}

/// Entries of the system of a cluster: rows say that nodes meet and that moments are those of the
/// junctions, columns are forces times the length of a segment, and moments.
fn entries(network: &Network, members: &[usize], terms: &MatrixTerms) -> Vec<(usize, usize, f64)> {
    let mut entries = Vec::new();
    for &member in members {
        let link = &network.links[member];
        let mut put = |row: usize, column: usize, block: &Matrix3<f64>| {
            for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                entries.push((row + i, column + j, block[(i, j)]));
            }
        };
        for (side, sign) in link.sides.iter().zip([1.0, -1.0]) {
            let weight = sign / link.length;
            network.respond(side.group, side.force, &terms.responses, |column, block| {
                put(link.first, column, &(weight * block));
            });
        }
        let Some(hessian) = &terms.hessians[member] else { continue };
        for (i, side) in link.sides.iter().enumerate() {
            if side.moment.is_none() {
                continue;
            }
            let row = link.first + 3 + 3 * i;
            put(row, row, &Matrix3::identity());
            for (j, by) in link.sides.iter().enumerate() {
                let Some(other) = by.moment else { continue };
                let hessian = hessian.fixed_view::<3, 3>(3 * i, 3 * j).into_owned();
                network.respond(by.group, other, &terms.responses, |column, block| {
                    put(row, column, &(hessian * block));
                });
            }
        }
    }
    entries
}

/// Factors of a system that is small, or else sparse.
fn factorized(size: usize, entries: &[(usize, usize, f64)]) -> Result<ClusterFactors, LinalgError> {
    if size > DENSE {
        return Ok(ClusterFactors::Sparse(SparseSystem::new(size, entries)?));
    }
    let mut matrix = DMatrix::zeros(size, size);
    entries.iter().for_each(|&(row, column, value)| matrix[(row, column)] += value);
    let factors = matrix.clone().lu();
    // Whether it has an inverse shows where it answers what some unknowns give.
    let some = DVector::from_fn(size, |i, _| if i % 2 == 0 { 1.0 } else { -0.5 });
    let right = &matrix * &some;
    let solution = factors.solve(&right).ok_or(LinalgError::Singular)?;
    let scale = right.amax() + matrix.amax() * solution.amax();
    let residual = (right - matrix * &solution).amax();
    if residual <= LARGEST_RESIDUAL * scale {
        Ok(ClusterFactors::Dense(factors))
    } else {
        Err(LinalgError::Singular)
    }
}
