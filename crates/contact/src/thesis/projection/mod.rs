//! The thesis's Alg. 6: Moreau's time stepping by two projections of the velocities on SE(3), as
//! printed and corrected.
//!
//! With `u` the bodies' twists, `J` the contacts' normal rows `(n, r x n)`, `D` the tangential ones
//! and `v_N` what the other side demands, the corrected form is
//!
//! ```text
//! u+  = argmin 1/2 (u - u-)^T M (u - u-)         such that  J u >= v_N          (8.12), (8.69)
//! u_e = u+ + e (u+ - u-)                          lambda = (1 + e) multipliers  (8.30)
//! p   = argmin 1/2 |u_e + M^-1 D^T p|^2_M         such that  J u >= v_N,  p_a in lambda_a L_a
//! u'  = u_e + M^-1 D^T p                                                        (8.61), (8.62)
//! ```
//!
//! with `L_a` the polygon (8.48). Every difference to the print is a field of [`Differences`].

mod active_set;
mod friction;
mod group;
mod normal;
mod polygon;
mod program;
mod solver;
mod step;
mod touch;

pub use polygon::PolygonalCone;
pub use solver::TwoProjections;
pub use step::{moreau_step, project};
pub use touch::{Partner, Touch};

/// Text that a computation follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// Text of the thesis, with its printed errors.
    AsPrinted,
    /// Text as corrected by the errata.
    #[default]
    Corrected,
}

impl Form {
    pub(crate) fn is_corrected(self) -> bool {
        self == Self::Corrected
    }
}

/// Places where Alg. 6 can follow the print or its corrections, one by one;
/// `Form::AsPrinted.into()` and `Form::Corrected.into()` set all together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Differences {
    /// Line 5 and (8.12). Printed: nearest in the Euclidean norm of twists. Corrected: in the
    /// metric of the mass matrix, so that `M (u+ - u-)` is a sum of contact wrenches.
    pub metric: Form,
    /// (8.65). Printed: the six-dimensional normal is divided by its norm, while the bound (8.67)
    /// is a velocity along the normal in space. Corrected: `J = (n, r x n)`.
    pub normal: Form,
    /// Line 7 and (8.27). Printed: the impulse at a contact is the norm of
    /// `[n^T M (u+ - u-)] n`, counted twice where normals are not orthogonal, and without
    /// restitution. Corrected: `(1 + e)` times the multiplier of the projection.
    pub impulse: Form,
    /// Line 10 and (8.64). Printed: `(1 + e) u+ + e u- + u_f`. Corrected: `(1 + e) u+ - e u- + u_f`
    /// as in (8.30).
    pub restitution: Form,
    /// Lines 8 and (8.61), (8.62). Printed: `argmin u_f^T u+`, linear, so that the answer is on the
    /// limit curve and nothing ever sticks. Corrected: the least kinetic energy after friction.
    pub objective: Form,
    /// Lines 8 and (8.61), (8.62). Printed: friction works against `u+`. Corrected: against the
    /// velocity after restitution, `u_e`; the two differ where a body turns under a normal impulse,
    /// and only the latter never gains energy.
    pub friction_velocity: Form,
    /// Line 9 and (8.63). Printed: half planes across the directions of the curve, another and
    /// larger set. Corrected: the polygon (8.48), `p = D w`, `w >= 0`, `e^T S^-1 w <= lambda`.
    pub friction_set: Form,
    /// Lines 1 and 12. Printed: a body in contact feels half of the step's forces. Corrected: all.
    pub force: Form,
    /// (8.80). Printed: the angular velocity stays as the body turns. Corrected: the angular
    /// momentum does.
    pub gyroscopic: Form,
    /// (8.67). Printed: every body by itself, against the velocity that a plastic impact would give
    /// both; where a body has several contacts its partners feel other impulses than it does.
    /// Corrected: all bodies given are projected together, so momentum is kept.
    pub scope: Form,
}

impl From<Form> for Differences {
    fn from(form: Form) -> Self {
        Self {
            metric: form,
            normal: form,
            impulse: form,
            restitution: form,
            objective: form,
            friction_velocity: form,
            friction_set: form,
            force: form,
            gyroscopic: form,
            scope: form,
        }
    }
}
