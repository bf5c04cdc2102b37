use crate::ScatteringError;
use crate::bessel::{scaled_bessel, scaled_bessel_0};
use crate::draw::{MOST_TRIES, semicircle};
use crate::error::check;
use crate::exponential::exponentials;
use std::f64::consts::{PI, TAU};

/// The normal distribution of `x`, rad, with the standard deviation `beta`, rad: (6.13) of the
/// thesis as printed, `M_p = g(beta; theta_h - alpha_p)`. Its integral over `theta_r` is 2, not 1
/// (erratum E8), and half of it still does not conserve energy (E9).
///
/// # Errors
/// [`ScatteringError::Parameter`] if `beta` is not positive and finite.
pub fn gaussian(beta: f64, x: f64) -> Result<f64, ScatteringError> {
    check("the width (rad)", beta, "positive and finite", beta > 0.0 && beta.is_finite())?;
    Ok(normal(beta, x))
}

pub(crate) fn normal(beta: f64, x: f64) -> f64 {
    (-0.5 * (x / beta).powi(2)).exp() / (beta * TAU.sqrt())
}

/// The longitudinal function of d'Eon et al. (2011) with the variance `v`, rad^2: `exp(-sin theta_i
/// sin theta_r / v) I0(cos theta_i cos theta_r / v) / (2 v sinh(1 / v))`. Its integral over `cos
/// theta_r d theta_r` is 1: a normal distribution on the sphere, averaged over the azimuth.
///
/// With `f = M N / cos theta_i`, which conserves energy, it is not reciprocal; [`SymmetricLobe`]
/// is.
///
/// # Errors
/// [`ScatteringError::Parameter`] if `v` is not in `[1e-8, 1e8]`.
pub fn deon(v: f64, theta_i: f64, theta_r: f64) -> Result<f64, ScatteringError> {
    check_variance(v)?;
    Ok(spherical(v, &Inclination::of(theta_i), &Inclination::of(theta_r)))
}

fn spherical(v: f64, i: &Inclination, r: &Inclination) -> f64 {
    let [exponent, argument] = spherical_exponents(v.recip(), i, r);
    exponent.exp() * scaled_bessel_0(argument) * spherical_height(v)
}

/// `exp(-a / v) I0(b / v) / (2 v sinh(1 / v))`, each with its own exponential taken out: what is
/// left in the exponent, and the argument of the Bessel function.
pub(crate) fn spherical_exponents(k: f64, i: &Inclination, r: &Inclination) -> [f64; 2] {
    let (a, b) = (i.sin * r.sin, (i.cos * r.cos).abs());
    [(b - a - 1.0) * k, b * k]
}

pub(crate) fn spherical_height(v: f64) -> f64 {
    -1.0 / (v * (-2.0 / v).exp_m1())
}

/// Refuses a variance of a lobe that no number can carry.
pub(crate) fn check_variance(v: f64) -> Result<(), ScatteringError> {
    check("the variance of a lobe (rad^2)", v, "in [1e-8, 1e8]", (1e-8..=1e8).contains(&v))
}

/// Sine and cosine of an inclination; the cosine is negative beyond the pole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Inclination {
    pub(crate) sin: f64,
    pub(crate) cos: f64,
}

impl Inclination {
    pub(crate) fn of(theta: f64) -> Self {
        let (sin, cos) = theta.sin_cos();
        Self { sin, cos }
    }

    /// The inclination `shift` before this one.
    pub(crate) fn before(&self, shift: &Self) -> Self {
        Self {
            sin: self.sin * shift.cos - self.cos * shift.sin,
            cos: self.cos * shift.cos + self.sin * shift.sin,
        }
    }
}

/// A longitudinal lobe that is reciprocal and conserves energy at once: the default of all models.
///
/// **What is asked.** Radiance from a fibre is `L_r = integral f L_i cos theta_i d omega_i`, so
/// with `f = G(theta_i, theta_r) N(dphi)` and `integral N = 1`, a fibre gives back what it receives
/// if `integral G cos^2 theta_r d theta_r = 1` for every `theta_i`, and is reciprocal if G is
/// symmetric. The function of d'Eon is symmetric, but conserves under `cos theta_r d theta_r`, the
/// measure of the sphere; the missing cosine, put on one side, is what makes today's models not
/// reciprocal.
///
/// **Without tilt.** `cos^2 theta d theta` is the measure of the sphere of one more dimension, S^3,
/// for latitudes. So what d'Eon does on the sphere is done there: a normal distribution `exp(k cos
/// psi)` around the mirrored direction, averaged over all directions but latitude, is `G = k / (pi
/// I1(k)) exp(-k sin theta_i sin theta_r) sinh(z) / z`, `z = k cos theta_i cos theta_r`, with `k =
/// 1 / v`. Symmetric, positive, of integral 1 for every `v` and `theta_i`, and for small `v` the
/// lobe of d'Eon over the cosine.
///
/// **With tilt** by `shift`, let `q(i -> r) = G(theta_i - shift, theta_r)`: it conserves energy,
/// but is not symmetric. No tilt is both: in the limit of a sharp lobe, light would be mapped from
/// `theta` to `shift - theta`, and the one falling map of the interval that keeps the measure
/// `cos^2 theta d theta` is `theta` to `-theta`. So energy must be lost to the lobe, and the least
/// is lost by the rule of Metropolis: `min(q(i -> r), q(r -> i))`, symmetric and of integral at
/// most 1. Since `exp(k T) (1 - exp(-2 k B)) / (2 k B)` falls with `B`, where `T = cos(theta_i +
/// theta_r - shift)` is common to both, that is the larger of two `B`: one formula again. What a
/// lobe loses, [`crate::FiberBsdf`]'s models give to one more lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SymmetricLobe {
    /// `1 / v`.
    concentration: f64,
    shift: Inclination,
    /// `k exp(k) / (pi I1(k))`.
    height: f64,
    shift_angle: f64,
    /// Constant of Wood's method.
    b: f64,
}

impl SymmetricLobe {
    /// A lobe of the variance `v`, rad^2, with its peak at `theta_r = shift - theta_i`, rad.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if `v` is not in `[1e-8, 1e8]` or `shift` not in `[-pi/2,
    /// pi/2]`.
    pub fn new(v: f64, shift: f64) -> Result<Self, ScatteringError> {
        check_variance(v)?;
        check("the tilt of a lobe (rad)", shift, "in [-pi/2, pi/2]", shift.abs() <= 0.5 * PI)?;
        let k = 1.0 / v;
        let b = 3.0 / (2.0 * k + (4.0 * k * k + 9.0).sqrt());
        let height = k / (PI * scaled_bessel(1, k));
        let rotation = Inclination::of(shift);
        Ok(Self { concentration: k, shift: rotation, height, shift_angle: shift, b })
    }

    /// The lobe for light from the inclination `theta_i` to `theta_r`, rad, per sr of S^3: its
    /// integral over `cos^2 theta_r d theta_r` is 1 without tilt and at most 1 with it. Symmetric.
    #[must_use]
    pub fn value(&self, theta_i: f64, theta_r: f64) -> f64 {
        self.at(&Inclination::of(theta_i), &Inclination::of(theta_r))
    }

    pub(crate) fn shift(&self) -> &Inclination {
        &self.shift
    }

    pub(crate) fn at(&self, i: &Inclination, r: &Inclination) -> f64 {
        let [off, forth, back] = self.exponents(i, r);
        self.kernel(off, forth.max(back))
    }

    /// The lobe before the rule of Metropolis, from `i` to `r`: of integral 1.
    pub(crate) fn proposal(&self, i: &Inclination, r: &Inclination) -> f64 {
        let [off, forth, _] = self.exponents(i, r);
        self.kernel(off, forth)
    }

    /// What the rule of Metropolis leaves of that, in `[0, 1]`.
    pub(crate) fn kept(&self, i: &Inclination, r: &Inclination) -> f64 {
        let [_, forth, back] = self.exponents(i, r);
        if back <= forth {
            1.0
        } else if forth > 37.0 {
            forth / back
        } else {
            let least = forth.min(0.0);
            self.kernel(least, back) / self.kernel(least, forth)
        }
    }

    /// Four lobes at once.
    pub(crate) fn all(lobes: &[Self; 4], i: &Inclination, r: &Inclination) -> [f64; 4] {
        let (mut z, mut exponents) = ([0.0; 4], [0.0; 8]);
        for (p, lobe) in lobes.iter().enumerate() {
            let [off, forth, back] = lobe.exponents(i, r);
            z[p] = forth.max(back);
            (exponents[p], exponents[4 + p]) = (off - z[p].min(0.0), -z[p].abs());
        }
        let e = exponentials(exponents);
        [0, 1, 2, 3].map(|p| lobes[p].height * e[p] * mean_exponential(z[p], e[4 + p]))
    }

    /// `exp(off) (1 - exp(-z)) / z`, but for the height.
    fn kernel(&self, off: f64, z: f64) -> f64 {
        let [peak, end] = exponentials([off - z.min(0.0), -z.abs()]);
        self.height * peak * mean_exponential(z, end)
    }

    /// `k (T - 1)`, at most zero, and `2 k B` for both ways; less that it is at most zero too, also
    /// beyond the pole, where `B` is negative. All is symmetric to the last bit.
    fn exponents(&self, i: &Inclination, r: &Inclination) -> [f64; 3] {
        let (k, shift) = (self.concentration, &self.shift);
        let (cos, sin) = (i.cos * r.cos - i.sin * r.sin, i.sin * r.cos + i.cos * r.sin);
        let off = k * (cos * shift.cos + sin * shift.sin - 1.0);
        let (forth, back) = (i.before(shift).cos * r.cos, r.before(shift).cos * i.cos);
        [off, 2.0 * k * forth, 2.0 * k * back]
    }

    /// Intervals of `theta_r`, rad, outside of which the lobe from `theta_i`, rad, is below 1e-20
    /// of its peak, cut where it has a kink, at `theta_i`, and at `-theta_i`.
    pub(crate) fn support(&self, theta_i: f64) -> [[f64; 2]; 3] {
        let peak = self.shift_angle - theta_i;
        let clip = |theta: f64| theta.clamp(-0.5 * PI, 0.5 * PI);
        // What falls over a pole comes down beside it.
        let beyond = (peak.abs() - 0.5 * PI).max(0.0);
        let half = 10.0 * self.concentration.recip().sqrt() + beyond;
        let (low, high) = (clip(clip(peak) - half), clip(clip(peak) + half));
        let cut = |theta: f64| theta.clamp(low, high);
        let (a, b) = (cut(-theta_i.abs()), cut(theta_i.abs()));
        [[low, a], [a, b], [b, high]]
    }

    /// An inclination drawn before the rule of Metropolis: Wood's method for the angle psi to the
    /// mirrored direction on S^3, then one number for the side, since latitudes of a sphere are
    /// even.
    pub(crate) fn draw(&self, i: &Inclination, random: &mut dyn FnMut() -> f64) -> Inclination {
        let x0 = (1.0 - self.b) / (1.0 + self.b);
        let mut t = 0.0;
        for _ in 0..MOST_TRIES {
            let z = 0.5 * (1.0 + semicircle(random));
            // 1 - cos psi, without a difference of near numbers.
            t = 2.0 * self.b * z / (1.0 - (1.0 - self.b) * z);
            let ratio = (1.0 - x0 + x0 * t) * (1.0 + self.b) / (2.0 * (1.0 - x0));
            // The exponent is at most 3/2.
            let fits = (self.concentration * (1.0 - x0 - t)).exp() * ratio * ratio * ratio;
            if fits >= random() {
                break;
            }
        }
        let t = t.clamp(0.0, 2.0);
        let pole = i.before(&self.shift);
        let side = 2.0 * random() - 1.0;
        let sin = -pole.sin * (1.0 - t) + pole.cos * (t * (2.0 - t)).sqrt() * side;
        let sin = sin.clamp(-1.0, 1.0);
        Inclination { sin, cos: (1.0 - sin * sin).sqrt() }
    }
}

/// `(1 - exp(-|z|)) / |z|`, where `end` is the exponential.
fn mean_exponential(z: f64, end: f64) -> f64 {
    let z = z.abs();
    if z < 1e-3 { 1.0 - z * (0.5 - z * (1.0 / 6.0 - z / 24.0)) } else { (1.0 - end) / z }
}
