use nalgebra::Vector3;

/// How a curve runs through the nodes of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveForm {
    /// A cubic spline with continuous curvature, a uniform B-spline.
    Cubic,
    /// Straight from node to node; the tubes of neighbours are open at a bend.
    Linear,
}

/// A piece of a curve: `((c3 t + c2) t + c1) t + c0` for `t` in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CurvePiece {
    c: [Vector3<f64>; 4],
}

impl CurvePiece {
    /// Control points of a piece.
    pub(super) fn points(form: CurveForm) -> usize {
        match form {
            CurveForm::Cubic => 4,
            CurveForm::Linear => 2,
        }
    }

    /// A piece by its control points: the first of these, as many as [`Self::points`].
    #[inline(always)]
    pub(super) fn new(form: CurveForm, control: &[Vector3<f64>; 4]) -> Self {
        let [a, b, c, d] = control;
        match form {
            CurveForm::Cubic => {
                // The uniform B-spline by powers.
                let c0 = (a + 4.0 * b + c) / 6.0;
                let (c1, c2) = (0.5 * (c - a), 0.5 * (a + c) - b);
                Self { c: [c0, c1, c2, (d - a + 3.0 * (b - c)) / 6.0] }
            }
            CurveForm::Linear => Self { c: [*a, b - a, Vector3::zeros(), Vector3::zeros()] },
        }
    }

    /// The same piece from another origin.
    #[inline(always)]
    pub(super) fn from(&self, origin: &Vector3<f64>) -> Self {
        let [c0, c1, c2, c3] = self.c;
        Self { c: [c0 - origin, c1, c2, c3] }
    }

    #[inline(always)]
    pub(super) fn at(&self, t: f64) -> Vector3<f64> {
        let [c0, c1, c2, c3] = &self.c;
        ((c3 * t + c2) * t + c1) * t + c0
    }

    /// The derivative.
    #[inline(always)]
    pub(super) fn slope(&self, t: f64) -> Vector3<f64> {
        let [_, c1, c2, c3] = &self.c;
        (c3 * (3.0 * t) + c2 * 2.0) * t + c1
    }

    /// The second derivative.
    #[inline(always)]
    pub(super) fn bend(&self, t: f64) -> Vector3<f64> {
        self.c[3] * (6.0 * t) + self.c[2] * 2.0
    }

    /// How far the curve is at most, m, from the parabola through the ends and the middle of a part
    /// of the length `part`: the third derivative times the maximum of `a (a - 1/2) (a - 1) / 6`.
    #[inline(always)]
    pub(super) fn off_parabola(&self, part: f64) -> f64 {
        0.008_02 * 6.0 * self.c[3].norm() * part.powi(3)
    }

    /// How far the curve is from its chords, m, if it is cut into so many equal parts: at most an
    /// eighth of the second derivative, which is largest at an end.
    #[inline(always)]
    pub(super) fn sagitta(&self, parts: u32) -> f64 {
        let bend = self.bend(0.0).norm().max(self.bend(1.0).norm());
        bend / (8.0 * f64::from(parts * parts))
    }
}
