use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// How a contact that is pressed answers, its normal impulse eliminated by `u_n = 0`: friction `x`
/// causes the slip `schur x` and needs the normal impulse `pull x`.
pub(super) struct PressedResponse {
    /// Element of the normal, and those beside it, 1/kg.
    normal: f64,
    coupling: Vector2<f64>,
    /// Schur complement of the response after elimination of the normal, 1/kg.
    pub(super) schur: Matrix2<f64>,
    /// Normal impulse per friction.
    pub(super) pull: Vector2<f64>,
}

/// What a contact that is pressed does without friction.
pub(super) struct PressedContact {
    /// Slip, m/s.
    pub(super) slip: Vector2<f64>,
    /// Normal impulse, N s.
    pub(super) load: f64,
}

impl PressedResponse {
    /// Elimination of the normal from the response `w`, 1/kg, in the contact's frame.
    pub(super) fn new(w: &Matrix3<f64>) -> Self {
        let (normal, coupling) = (w.m11, Vector2::new(w.m12, w.m13));
        let pull = -coupling / normal;
        let tangential = Matrix2::new(w.m22, w.m23, w.m23, w.m33);
        Self { normal, coupling, schur: tangential + coupling * pull.transpose(), pull }
    }

    /// The contact with a free velocity, m/s, in its frame.
    pub(super) fn at(&self, free: &Vector3<f64>) -> PressedContact {
        let load = -free.x / self.normal;
        PressedContact { slip: free.yz() + self.coupling * load, load }
    }
}
