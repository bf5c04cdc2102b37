use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// A contact that is pressed, its normal impulse eliminated by `u_n = 0`: friction `x` causes the
/// slip `schur x + slip` and needs the normal impulse `load + pull x`.
pub(super) struct PressedContact {
    /// Schur complement of the response after elimination of the normal, 1/kg.
    pub(super) schur: Matrix2<f64>,
    /// Slip without friction, m/s.
    pub(super) slip: Vector2<f64>,
    /// Normal impulse without friction, N s.
    pub(super) load: f64,
    /// Normal impulse per friction.
    pub(super) pull: Vector2<f64>,
}

impl PressedContact {
    /// Elimination of the normal from the response `w`, 1/kg, and the free velocity, m/s, in the
    /// contact's frame.
    pub(super) fn new(w: &Matrix3<f64>, free: &Vector3<f64>) -> Self {
        let coupling = Vector2::new(w.m12, w.m13);
        let pull = -coupling / w.m11;
        let load = -free.x / w.m11;
        let tangential = Matrix2::new(w.m22, w.m23, w.m23, w.m33);
        Self {
            schur: tangential + coupling * pull.transpose(),
            slip: free.yz() + coupling * load,
            load,
            pull,
        }
    }

    /// Normal impulse that keeps the gap as it is while the friction acts, N s.
    pub(super) fn normal_impulse(&self, friction: &Vector2<f64>) -> f64 {
        self.load + self.pull.dot(friction)
    }
}
