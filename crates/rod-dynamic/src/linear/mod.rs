//! Small motions about an equilibrium of the staggered rod: `M q'' + K q = 0`.
//!
//! The coordinates `q` are rotation increments of the segments, `R -> exp(hat(q_e)) R` in the
//! world, before them the displacement of a free root. Inextensibility gives the nodes:
//! `dr_a = dr_0 + sum_(e < a) h_e q_e x d3_e`. A tip that is held adds three linear constraints,
//! and all matrices are then in an orthonormal basis of the increments these leave free.
//!
//! `K` is the exact derivative of the staggered rod's torques and `M` its mass, so results differ
//! from those of the continuous rod by `O(h^2)`: extrapolation from two meshes gives six digits.
//! Matrices are dense: memory `O(N^2)`, time `O(N^3)`; one second for 150 segments.

mod assembly;
mod joint;
mod modes;

pub use modes::Mode;

use crate::{End, Instant, Load, Rod, RodError, RodState};
use assembly::LinearAssembly;
use nalgebra::{DMatrix, DVector, Vector3};

/// Largest torque of a state that counts as an equilibrium, as a fraction of the stiffness per rad.
const BALANCED: f64 = 1e-6;
/// Constraints weaker than this fraction of the strongest are dropped: a straight rod's ends cannot
/// approach to first order.
const RANK: f64 = 1e-9;

/// Stiffness and mass of a rod near an equilibrium. See [`linearize`].
#[derive(Debug, Clone)]
pub struct Linearization {
    stiffness: DMatrix<f64>,
    mass: DMatrix<f64>,
    /// Increments of the whole chain (rows) of each reduced coordinate (columns).
    basis: DMatrix<f64>,
    /// Displacements of the nodes (three rows each) per increment of the whole chain.
    displacement: DMatrix<f64>,
    root_free: bool,
    symmetric: bool,
}

/// Linearises `rod` under `conditions` about `state`, which must be an equilibrium.
///
/// Of the state, only the frames are used, and where the tip is held the force in the last segment:
/// the loads determine the other forces. A straight rod between two held ends is in equilibrium
/// under any axial force, which the state prescribes. Damping, drag, wind and velocities are left
/// out.
///
/// # Errors
/// [`RodError::Length`] for frames or forces that do not fit the rod, [`RodError::Invalid`] for a
/// rod of one segment, numbers that are not finite, a free root with a held tip, a supported end,
/// or a state whose torques do not balance.
pub fn linearize(
    rod: &Rod,
    conditions: &Instant,
    state: &RodState,
) -> Result<Linearization, RodError> {
    let n = rod.fiber.segments();
    let invalid = |what, why| Err(RodError::Invalid { what, why });
    for (what, found) in [("frames", state.frames.len()), ("forces", state.forces.len())] {
        if found != n {
            return Err(RodError::Length { what, expected: n, found });
        }
    }
    if n < 2 {
        return invalid("rod", "needs at least two segments");
    }
    if [conditions.root, conditions.tip].iter().any(|end| matches!(end, End::Supported(_))) {
        return invalid("end", "the linear analysis knows ends that are held whole or free only");
    }
    if conditions.inside != 0.0 {
        return invalid("nozzle", "the linear analysis knows none");
    }
    let root_free = matches!(conditions.root, End::Loaded { .. });
    let tip_held = !matches!(conditions.tip, End::Loaded { .. });
    if root_free && tip_held {
        return invalid("root", "a free root with a held tip: reverse the rod");
    }
    let chain = LinearAssembly::new(&rod.fiber, conditions, state);
    // Stiffness matrix, and whether the torques of the state balance.
    let stiffness = chain.stiffness();
    if !stiffness.iter().all(|x| x.is_finite()) {
        return invalid("state or conditions", "all numbers must be finite");
    }
    let imbalance = chain.imbalance();
    if imbalance.is_nan() || imbalance > BALANCED * stiffness.amax() {
        return invalid("state", "torques do not balance: it must be an equilibrium");
    }
    // Mass matrix, and a basis of the increments that a held tip leaves free.
    let displacement = chain.displacement();
    let mass = chain.mass(&displacement);
    let basis = if tip_held {
        free_increments(&displacement.rows(3 * n, 3).into_owned())
    } else {
        DMatrix::identity(mass.nrows(), mass.nrows())
    };
    Ok(Linearization {
        stiffness: basis.transpose() * stiffness * &basis,
        mass: basis.transpose() * mass * &basis,
        basis,
        displacement,
        root_free,
        symmetric: has_potential(&conditions.root) && has_potential(&conditions.tip),
    })
}

impl Linearization {
    /// The stiffness `K`, N m/rad (N/m for a free root's displacement): `-K q` are the torques.
    /// Symmetric unless moments or follower forces act on an end.
    #[must_use]
    pub fn stiffness(&self) -> &DMatrix<f64> {
        &self.stiffness
    }

    /// The mass `M`, kg m^2 (kg for a free root's displacement): symmetric, positive definite.
    #[must_use]
    pub fn mass(&self) -> &DMatrix<f64> {
        &self.mass
    }

    /// Work of `forces` (N, one a node) and `moments` (N m, one a segment), world components, per
    /// unit of each coordinate: the right-hand side `f` of `K q = f`.
    ///
    /// # Errors
    /// [`RodError::Length`] unless there is a force for each node and a moment for each segment.
    pub fn load(
        &self,
        forces: &[Vector3<f64>],
        moments: &[Vector3<f64>],
    ) -> Result<DVector<f64>, RodError> {
        let nodes = self.displacement.nrows() / 3;
        for (what, expected, found) in
            [("forces", nodes, forces.len()), ("moments", nodes - 1, moments.len())]
        {
            if found != expected {
                return Err(RodError::Length { what, expected, found });
            }
        }
        let flat = |v: &[Vector3<f64>]| {
            DVector::from_iterator(3 * v.len(), v.iter().flat_map(|x| [x.x, x.y, x.z]))
        };
        let mut work = self.displacement.transpose() * flat(forces);
        let first = if self.root_free { 3 } else { 0 };
        let mut rows = work.rows_mut(first, 3 * moments.len());
        rows += flat(moments);
        Ok(self.basis.transpose() * work)
    }

    /// The smallest eigenvalue of the stiffness (of its symmetric part) over its largest entry.
    ///
    /// Negative means unstable, if the loads have a potential. A motion that costs no energy, as of
    /// a free rod, gives zero to about `1e-15`. Cost: `O(N^3)`.
    ///
    /// # Errors
    /// [`RodError::Vibration`] where the iteration for the eigenvalues does not converge.
    pub fn smallest_stiffness(&self) -> Result<f64, RodError> {
        let symmetric = 0.5 * (&self.stiffness + self.stiffness.transpose());
        Ok(rapunzel_linalg::smallest_eigenvalue(&symmetric)? / self.stiffness.amax())
    }
}

/// Whether an end's load is the derivative of an energy.
fn has_potential(end: &End) -> bool {
    let none = |load: &Load| *load.components() == Vector3::zeros();
    match end {
        End::Loaded { force, moment } => {
            none(moment) && (matches!(force, Load::World(_)) || none(force))
        }
        _ => true,
    }
}

/// An orthonormal basis of the increments that `constraints` (rows) leave free.
fn free_increments(constraints: &DMatrix<f64>) -> DMatrix<f64> {
    let svd = constraints.transpose().svd(true, false);
    let size = constraints.ncols();
    let rank = svd.rank(RANK * svd.singular_values.max());
    // Householder reflections that take the constrained directions to the first unit vectors take
    // the free ones to the others.
    let mut padded = DMatrix::zeros(size, size);
    if let Some(u) = svd.u {
        padded.columns_mut(0, rank).copy_from(&u.columns(0, rank));
    }
    padded.qr().q().columns(rank, size - rank).into_owned()
}
