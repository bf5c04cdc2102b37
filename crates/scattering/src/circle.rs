use crate::refraction::{Cone, check_index, cosine};
use crate::{BravaisIndices, ScatteringError};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Rays through a smooth dielectric circle under one inclination, in the normal plane (thesis
/// 6.3.2). Offsets `h` in `[-1, 1]` are sines of the projected angle of incidence; the order `p` is
/// the number of segments inside: 0 is R, 1 TT, 2 TRT.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CirclePaths {
    cone: Cone,
    inverse_index: f64,
}

/// A ray that leaves the circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AzimuthRoot {
    /// Offset of the ray, in `[-1, 1]`.
    pub h: f64,
    /// Density of rays `D = |d dphi / d h|^-1`, per rad; infinite at a caustic.
    pub density: f64,
}

/// A caustic of the circle: an azimuth at which rays of an order turn round (a glint for TRT).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Caustic {
    /// Offset of the ray, in `[0, 1]`; that at `-h` is the mirror image.
    pub h: f64,
    /// Change of azimuth there, rad, in `(-pi, pi]`.
    pub azimuth: f64,
}

impl CirclePaths {
    /// Paths in a medium of index `n` under the inclination `theta`, rad.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if `n` is not in `[1, 10]` or `theta` not inside `(-pi/2,
    /// pi/2)`.
    pub fn new(n: f64, theta: f64) -> Result<Self, ScatteringError> {
        check_index(n)?;
        BravaisIndices::new(n, theta)?;
        Ok(Self::of(Cone::new(n, theta.cos().powi(2))))
    }

    pub(crate) fn of(cone: Cone) -> Self {
        Self { cone, inverse_index: cone.inverse_index() }
    }

    /// Change of azimuth of the ray at the offset `h` (thesis (6.4)), rad, not taken modulo `2 pi`:
    /// `2 p asin(h / n') - 2 asin h + p pi`. Zero is straight back to the light.
    #[must_use]
    pub fn azimuth(&self, p: u32, h: f64) -> f64 {
        let (p, h) = (f64::from(p), h.clamp(-1.0, 1.0));
        2.0 * p * (h * self.inverse_index).asin() - 2.0 * h.asin() + p * PI
    }

    /// Derivative of [`Self::azimuth`] by `h`, rad; minus infinity at `|h| = 1`, but for orders
    /// whose ray does not turn there.
    #[must_use]
    pub fn azimuth_slope(&self, p: u32, h: f64) -> f64 {
        let a = self.inverse_index;
        2.0 * f64::from(p) * a / cosine(h * a) - 2.0 / cosine(h)
    }

    /// Length of one segment inside, in radii of the fibre: `2 cos gamma_t / cos theta_t` (thesis
    /// (6.9) with the erratum E1).
    #[must_use]
    pub fn segment(&self, h: f64) -> f64 {
        2.0 * cosine(h * self.inverse_index) * self.cone.stretch()
    }

    /// How far the ray of order `p` moves along the fibre inside it, in radii, away from the light
    /// (thesis (6.21); its sign is that of `-theta_i`, erratum E14).
    #[must_use]
    pub fn axial_advance(&self, p: u32, h: f64) -> f64 {
        f64::from(p) * self.segment(h) * cosine(self.cone.cos_inside())
    }

    /// The caustic of an order, if it has one: `h^2 = (p^2 - n'^2) / (p^2 - 1)`, for TRT thus
    /// `(4 - n'^2) / 3` (thesis, before (6.5)). None for R and TT, nor where `n' >= p`.
    #[must_use]
    pub fn caustic(&self, p: u32) -> Option<Caustic> {
        let (p2, n2) = (f64::from(p).powi(2), self.inverse_index.powi(-2));
        let h = ((p2 - n2) / (p2 - 1.0)).sqrt();
        (p > 1 && h > 0.0).then(|| Caustic { h, azimuth: wrapped(self.azimuth(p, h)) })
    }

    /// All rays of order `p` that leave at the change of azimuth `azimuth`, rad, modulo `2 pi`, by
    /// rising offset: the roots of (6.11). The thesis counts one for R and TT and one or three for
    /// TRT; at `n' = 1.55` there is one for R, none or one for TT, and three, one or none for TRT
    /// (erratum E12). Costs some 50 evaluations a root.
    #[must_use]
    pub fn roots(&self, p: u32, azimuth: f64) -> Vec<AzimuthRoot> {
        // Between caustics the azimuth is monotonous: one root or none a piece and turn.
        let turn = self.caustic(p).map(|c| c.h);
        let ends: Vec<f64> = turn.map_or(vec![-FRAC_PI_2, FRAC_PI_2], |h| {
            vec![-FRAC_PI_2, -h.asin(), h.asin(), FRAC_PI_2]
        });
        let of = |gamma: f64| self.azimuth(p, gamma.sin());
        let mut roots = Vec::new();
        for (a, b) in ends.iter().zip(&ends[1..]) {
            let (from, to) = (of(*a), of(*b));
            let (low, high) = (from.min(to), from.max(to));
            let mut target = azimuth + ((low - azimuth) / TAU).ceil() * TAU;
            while target <= high {
                let gamma = bisect(|gamma| (of(gamma) - target) * (to - from).signum(), *a, *b);
                let h = gamma.sin();
                roots.push(AzimuthRoot { h, density: 1.0 / self.azimuth_slope(p, h).abs() });
                target += TAU;
            }
        }
        roots.sort_by(|a, b| a.h.total_cmp(&b.h));
        // A border of two pieces is a root of both.
        roots.dedup_by(|a, b| a.h == b.h);
        roots
    }

    /// Changes of azimuth of R, TT and TRT at the offset `h`, rad.
    pub(crate) fn azimuths(&self, h: f64) -> [f64; 3] {
        let (i, t) = (2.0 * h.clamp(-1.0, 1.0).asin(), 2.0 * (h * self.inverse_index).asin());
        [-i, t - i + PI, 2.0 * t - i]
    }

    /// Cosines of the projected angles outside and inside at the offset `h`.
    pub(crate) fn cosines(&self, h: f64) -> [f64; 2] {
        [cosine(h), cosine(h * self.inverse_index)]
    }

    pub(crate) fn cone(&self) -> &Cone {
        &self.cone
    }
}

/// The root of a function that rises from `a` to `b`, to the last bit.
fn bisect(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    loop {
        let middle = 0.5 * (a + b);
        if middle <= a || middle >= b {
            return middle;
        }
        if f(middle) < 0.0 { a = middle } else { b = middle }
    }
}

/// An angle modulo `2 pi`, in `[-pi, pi]`.
pub(crate) fn wrapped(angle: f64) -> f64 {
    let turns = angle * TAU.recip();
    // A cast is faster than a call of `round`; angles are a few turns.
    #[expect(clippy::cast_possible_truncation, reason = "few turns")]
    let whole = (turns + 0.5_f64.copysign(turns)) as i64 as f64;
    angle - TAU * whole
}
