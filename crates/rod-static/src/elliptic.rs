//! Jacobi's elliptic functions and Legendre's integrals of real arguments.
//!
//! The parameter is `m = k^2`, the square of the modulus; the amplitude is an angle in radians.
//! Near `m = 1` the complement `1 - m` carries the digits, so [`Modulus`] is made of it. Values are
//! good to a few units of the last place.

use crate::carlson::{rd, rf, rj};
use std::f64::consts::{FRAC_PI_2, PI};

/// Steps of Landen's transformation; eleven take a complement of `1e-200` to the circle.
const STEPS: usize = 16;

/// A modulus with `0 <= k^2 < 1`, given by its complement and ready for evaluation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modulus {
    complement: f64,
    /// The descending moduli `k_1 > k_2 > ...` of Landen's transformation and `1 - k_i^2`.
    descent: [(f64, f64); STEPS],
    /// Number of descending moduli that are used.
    steps: usize,
    quarter: f64,
}

/// The functions sn, cn and dn of one argument.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jacobi {
    /// `sin(am u)`.
    pub sn: f64,
    /// `cos(am u)`.
    pub cn: f64,
    /// `sqrt(1 - m sn^2)`, with the sign that makes it smooth where `m > 1`.
    pub dn: f64,
}

impl Modulus {
    /// The modulus of complement `1 - m` in `(0, 1]`. `None` outside of that range.
    #[must_use]
    pub fn from_complement(complement: f64) -> Option<Self> {
        if !(complement > 0.0 && complement <= 1.0) {
            return None;
        }
        let mut descent = [(0.0, 1.0); STEPS];
        let (mut steps, mut k) = (0, 1.0);
        // Gauss's arithmetic and geometric means of 1 and k'.
        let (mut a, mut g) = (1.0, complement.sqrt());
        while k > 1e-9 && steps < STEPS {
            k = (a - g) / (a + g);
            (a, g) = (0.5 * (a + g), (a * g).sqrt());
            descent[steps] = (k, (g / a).powi(2));
            steps += 1;
        }
        Some(Self { complement, descent, steps, quarter: FRAC_PI_2 / a })
    }

    /// The complement `1 - m`.
    #[must_use]
    pub fn complement(&self) -> f64 {
        self.complement
    }

    /// The complete integral of the first kind, `K`: the quarter period of sn.
    #[must_use]
    pub fn quarter_period(&self) -> f64 {
        self.quarter
    }

    /// `(j, rest)` of `u = 2 K j + rest` with an integer `j` and `|rest| <= K`.
    #[must_use]
    pub fn reduce(&self, u: f64) -> (f64, f64) {
        let j = (u / (2.0 * self.quarter)).round();
        (j, (u - 2.0 * j * self.quarter).clamp(-self.quarter, self.quarter))
    }

    /// sn, cn and dn at `u`.
    #[must_use]
    pub fn jacobi(&self, u: f64) -> Jacobi {
        let (j, rest) = self.reduce(u);
        let Jacobi { sn, cn, dn } = self.jacobi_reduced(rest);
        let sign = if j.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
        Jacobi { sn: sign * sn, cn: sign * cn, dn }
    }

    /// sn, cn and dn for `|u| <= K`, with `cn >= 0` also where `u` is rounded to `K`: by descending
    /// Landen transformations (DLMF 22.7.2, 22.7.3) of the tangent of the amplitude.
    pub(crate) fn jacobi_reduced(&self, u: f64) -> Jacobi {
        let (mut s, mut c) = (u * FRAC_PI_2 / self.quarter).sin_cos();
        c = c.max(0.0);
        for (k, complement) in self.descent[..self.steps].iter().rev() {
            let d = (c * c + complement * s * s).sqrt();
            (s, c) = ((1.0 + k) * s, c * d);
            let norm = s.hypot(c);
            (s, c) = (s / norm, c / norm);
        }
        Jacobi { sn: s, cn: c, dn: (c * c + self.complement * s * s).sqrt() }
    }

    /// The amplitude am of `u`, radians: grows by pi over each `2 K`.
    #[must_use]
    pub fn amplitude(&self, u: f64) -> f64 {
        let (j, rest) = self.reduce(u);
        let at = self.jacobi_reduced(rest);
        j * PI + at.sn.atan2(at.cn)
    }
}

/// sn, cn and dn at `u` for any real parameter `m`; `m < 0` by the imaginary modulus, `m > 1` by
/// the reciprocal one (DLMF 22.17). `None` for arguments that are not finite.
#[must_use]
pub fn jacobi(u: f64, m: f64) -> Option<Jacobi> {
    if !(u.is_finite() && m.is_finite()) {
        return None;
    }
    if m < 0.0 {
        let scale = (1.0 - m).sqrt();
        let at = Modulus::from_complement(1.0 / (1.0 - m))?.jacobi(u * scale);
        return Some(Jacobi { sn: at.sn / (at.dn * scale), cn: at.cn / at.dn, dn: 1.0 / at.dn });
    }
    if m == 1.0 {
        let secant = 1.0 / u.cosh();
        return Some(Jacobi { sn: u.tanh(), cn: secant, dn: secant });
    }
    if m > 1.0 {
        let k = m.sqrt();
        let at = Modulus::from_complement((m - 1.0) / m)?.jacobi(u * k);
        return Some(Jacobi { sn: at.sn / k, cn: at.dn, dn: at.cn });
    }
    Some(Modulus::from_complement(1.0 - m)?.jacobi(u))
}

/// `F(phi | m)`, the incomplete integral of the first kind. `None` where it is not real or
/// infinite.
#[must_use]
pub fn first_kind(phi: f64, m: f64) -> Option<f64> {
    by_periods(phi, m, |s, c2, d2| s * rf(c2, d2, 1.0))
}

/// `E(phi | m)`, the incomplete integral of the second kind. `None` where it is not real.
#[must_use]
pub fn second_kind(phi: f64, m: f64) -> Option<f64> {
    if m == 1.0 {
        // R_F and R_D grow without bounds at the turning points; the integrand is |cos|.
        let turns = (phi / PI).round();
        return phi.is_finite().then(|| 2.0 * turns + (phi - turns * PI).sin());
    }
    by_periods(phi, m, |s, c2, d2| s * rf(c2, d2, 1.0) - m / 3.0 * s.powi(3) * rd(c2, d2, 1.0))
}

/// `D(phi | m) = (F - E) / m`, the integral of `sin^2 / sqrt(1 - m sin^2)`, without the
/// cancellation for small `m`. `None` where it is not real or infinite.
#[must_use]
pub fn kind_d(phi: f64, m: f64) -> Option<f64> {
    by_periods(phi, m, |s, c2, d2| s.powi(3) / 3.0 * rd(c2, d2, 1.0))
}

/// `Pi(n; phi | m)`, the incomplete integral of the third kind: of
/// `1 / ((1 - n sin^2) sqrt(1 - m sin^2))` (thesis (A.33)); for `n sin^2 phi > 1` its principal
/// value. Outside of `0 <= m <= 1` and for large `-n` it loses half the digits of `-n`.
/// `None` where it is not real or infinite.
#[must_use]
pub fn third_kind(n: f64, phi: f64, m: f64) -> Option<f64> {
    let direct = |n: f64, gap: f64, s: f64, c2: f64, d2: f64| {
        let s2 = s * s;
        s * rf(c2, d2, 1.0) + n / 3.0 * s * s2 * rj(c2, d2, 1.0, c2 + gap * s2)
    };
    if n >= 0.0 || !(0.0..=1.0).contains(&m) {
        return by_periods(phi, m, |s, c2, d2| direct(n, 1.0 - n, s, c2, d2));
    }
    // A negative n by a positive one, in a sum of positive terms (Abramowitz and Stegun 17.7.15).
    let (positive, gap) = ((m - n) / (1.0 - n), (1.0 - m) / (1.0 - n));
    let root = (-n / (1.0 - n) * (m - n)).sqrt();
    let rest = gap.sqrt() * (-n * (1.0 - m) / (m - n)).sqrt();
    by_periods(phi, m, |s, c2, d2| {
        let turn = (root * s * c2.sqrt()).atan2(d2.sqrt());
        let sum = rest * direct(positive, gap, s, c2, d2) + m / root * s * rf(c2, d2, 1.0) + turn;
        sum / ((1.0 - n) * (1.0 - m / n)).sqrt()
    })
}

/// An integral over `[0, phi]` from `part(sin, cos^2, 1 - m sin^2)` for amplitudes in
/// `[-pi/2, pi/2]`, continued by its periods.
fn by_periods(phi: f64, m: f64, part: impl Fn(f64, f64, f64) -> f64) -> Option<f64> {
    let turns = (phi / PI).round();
    let (s, c) = (phi - turns * PI).sin_cos();
    let delta = c * c + (1.0 - m) * s * s;
    let complete = if turns == 0.0 { 0.0 } else { 2.0 * turns * part(1.0, 0.0, 1.0 - m) };
    // Beyond the turning point of a modulus above one the root is imaginary.
    let real = delta >= 0.0 && (turns == 0.0 || m < 1.0);
    let value = complete + part(s, c * c, delta);
    (real && value.is_finite()).then_some(value)
}
