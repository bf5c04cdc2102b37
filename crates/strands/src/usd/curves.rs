//! Curves of a `BasisCurves` as points.

use crate::StrandFault;

/// The polynomials that control points are weighted with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CurveBasis {
    Linear,
    Bezier,
    Bspline,
    CatmullRom,
}

/// What is at the ends of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CurveWrap {
    Nonperiodic,
    /// The curve begins and ends at its first and last control point.
    Pinned,
    /// The curve is closed.
    Periodic,
}

/// How the curves of a prim are made of their control points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CurveKind {
    pub(super) basis: CurveBasis,
    pub(super) wrap: CurveWrap,
}

/// A control point, and the width there.
pub(super) type ControlPoint = [f64; 4];

impl CurveKind {
    /// Number of spans of a curve of `count` control points, if it can have so many.
    pub(super) fn spans(self, count: usize) -> Option<usize> {
        use CurveBasis::{Bezier, Bspline, CatmullRom, Linear};
        use CurveWrap::{Nonperiodic, Periodic, Pinned};
        match (self.basis, self.wrap) {
            (Bezier, Periodic) => (count >= 3 && count.is_multiple_of(3)).then_some(count / 3),
            (Bezier, _) => (count >= 4 && count % 3 == 1).then_some(count / 3),
            (_, Periodic) => (count >= 3).then_some(count),
            (Linear, _) | (_, Pinned) => count.checked_sub(1).filter(|&spans| spans > 0),
            (Bspline | CatmullRom, Nonperiodic) => count.checked_sub(3).filter(|&spans| spans > 0),
        }
    }

    /// Adds the points of a curve to `out`: `fine` for each span of a cubic one, and its end.
    pub(super) fn evaluate(
        self,
        controls: &[ControlPoint],
        fine: usize,
        out: &mut Vec<ControlPoint>,
    ) -> Result<(), StrandFault> {
        let spans = self.spans(controls.len()).ok_or(match controls.len() {
            0 | 1 => StrandFault::FewPoints,
            _ => StrandFault::ControlPoints,
        })?;
        if self.basis == CurveBasis::Linear {
            out.extend(controls);
            out.extend(controls.first().filter(|_| self.wrap == CurveWrap::Periodic));
            return Ok(());
        }
        for span in 0..spans {
            let ends = usize::from(span + 1 == spans);
            let four = self.around(controls, span);
            for k in 0..fine + ends {
                let weights = self.basis.weights(k as f64 / fine as f64);
                out.push([0, 1, 2, 3].map(|axis| {
                    four.iter().zip(weights).map(|(control, weight)| weight * control[axis]).sum()
                }));
            }
        }
        Ok(())
    }

    /// The four control points of a span.
    fn around(self, controls: &[ControlPoint], span: usize) -> [ControlPoint; 4] {
        let count = controls.len();
        let first = if self.basis == CurveBasis::Bezier { 3 * span } else { span };
        // Beyond the ends of a pinned curve, each end mirrors its neighbor.
        let mirrored = |end: usize, next: usize| {
            [0, 1, 2, 3].map(|axis| 2.0 * controls[end][axis] - controls[next][axis])
        };
        [0, 1, 2, 3].map(|k| match self.wrap {
            CurveWrap::Pinned if self.basis != CurveBasis::Bezier => match first + k {
                0 => mirrored(0, 1),
                place if place > count => mirrored(count - 1, count - 2),
                place => controls[place - 1],
            },
            CurveWrap::Periodic => controls[(first + k) % count],
            _ => controls[first + k],
        })
    }
}

impl CurveBasis {
    /// Weights of the four control points at a fraction of a span.
    fn weights(self, t: f64) -> [f64; 4] {
        let s = 1.0 - t;
        match self {
            Self::Bezier | Self::Linear => [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t],
            Self::Bspline => [
                s * s * s / 6.0,
                (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
                (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
                t * t * t / 6.0,
            ],
            Self::CatmullRom => [
                0.5 * t * s * (t - 1.0),
                0.5 * (3.0 * t * t * t - 5.0 * t * t + 2.0),
                0.5 * (3.0 * s * s * s - 5.0 * s * s + 2.0),
                0.5 * s * t * (s - 1.0),
            ],
        }
    }
}
