use crate::circle::wrapped;
use crate::exponential::transmitted;
use crate::refraction::{Cone, check_index, cosine};
use crate::{BravaisIndices, Caustic, ScatteringError};
use nalgebra::{Vector2, Vector3};
use rapunzel_fiber::Section;
use std::f64::consts::FRAC_PI_2;

/// Rays through a smooth dielectric ellipse under one inclination, traced in the normal plane with
/// the index `n'`, which the law of Bravais allows for every cylinder. This stands in the place of
/// (6.12), whose TRT has up to six times too much or too little energy (erratum E11).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EllipsePaths {
    outline: EllipseOutline,
    cone: Cone,
}

/// What becomes of one ray, for R, TT and TRT each: what leaves an ellipse that does not absorb.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracedRay {
    /// Change of azimuth, rad, in `[-pi, pi]`; where nothing leaves, that of the ray inside.
    pub azimuth: [f64; 3],
    /// Share of the light of the ray, zero under total reflection.
    pub share: [f64; 3],
    /// Length of the path inside, in radii of the circle of equal area.
    pub length: [f64; 3],
    /// Share of all later orders together.
    pub later: f64,
}

impl EllipsePaths {
    /// Paths through the `section` of a fibre in a medium of index `n` under the inclination
    /// `theta`, rad. Only the shape of the section counts, not its size.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if `n` is not in `[1, 10]` or `theta` not inside `(-pi/2,
    /// pi/2)`; [`ScatteringError::Section`] if an axis is not positive and finite.
    pub fn new(n: f64, theta: f64, section: &Section) -> Result<Self, ScatteringError> {
        check_index(n)?;
        BravaisIndices::new(n, theta)?;
        Ok(Self { outline: EllipseOutline::of(section)?, cone: Cone::new(n, theta.cos().powi(2)) })
    }

    /// Traces the ray from the azimuth `phi`, rad from d1 towards d2, at the offset `h` in `[-1,
    /// 1]` as a part of half the width that the light sees, to the side of `w x d3` with `w` the
    /// direction to the light. No allocation; about 0.1 us.
    #[must_use]
    pub fn trace(&self, phi: f64, h: f64) -> TracedRay {
        self.outline.trace(&self.cone, Vector2::new(phi.cos(), phi.sin()), h)
    }

    /// The caustics of TRT in light from the azimuth `phi`, rad, on both sides, by rising offset.
    /// Offsets where TRT is dark have none. Costs some 5000 rays.
    #[must_use]
    pub fn caustics(&self, phi: f64) -> Vec<Caustic> {
        const SAMPLES: u32 = 4096;
        let turn = |s: f64, from: f64| {
            let ray = self.trace(phi, s.sin());
            let azimuth = from + wrapped(ray.azimuth[2] - from);
            if ray.share[2] > 0.0 { Some(azimuth) } else { None }
        };
        let at = |k: u32| (2.0 * f64::from(k) / f64::from(SAMPLES) - 1.0) * FRAC_PI_2;
        let mut caustics = Vec::new();
        for k in 1..SAMPLES {
            let (low, middle, high) = (at(k - 1), at(k), at(k + 1));
            let Some(center) = turn(middle, 0.0) else { continue };
            let (Some(a), Some(b)) = (turn(low, center), turn(high, center)) else { continue };
            let sign = if center >= a && center > b { 1.0 } else { -1.0 };
            if (center - a) * sign < 0.0 || (center - b) * sign <= 0.0 {
                continue;
            }
            let s = peak(|s| sign * turn(s, center).unwrap_or(center), low, high);
            let azimuth = wrapped(turn(s, center).unwrap_or(center));
            caustics.push(Caustic { h: s.sin(), azimuth });
        }
        caustics
    }
}

/// Where a function with one maximum between `a` and `b` has it: the interval is cut by thirds to
/// about the square root of rounding, below which its values do not differ.
fn peak(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    while b - a > 1e-9 {
        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if f(c) < f(d) { a = c } else { b = d }
    }
    0.5 * (a + b)
}

/// An ellipse of the area of the unit circle, with its axes along d1 and d2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EllipseOutline {
    axes: Vector2<f64>,
    /// Squared reciprocals of the axes.
    form: Vector2<f64>,
}

impl EllipseOutline {
    pub(crate) fn of(section: &Section) -> Result<Self, ScatteringError> {
        section.validate()?;
        let (a, b) = section.semi_axes();
        let ratio = (a / b).sqrt();
        crate::error::check(
            "a ratio of axes",
            a / b,
            "in [1/16, 16]",
            (0.25..=4.0).contains(&ratio),
        )?;
        let axes = Vector2::new(ratio, ratio.recip());
        Ok(Self { axes, form: axes.map(|x| 1.0 / (x * x)) })
    }

    /// Half the width that light from the azimuth with this direction sees.
    fn half_width(&self, to_light: &Vector2<f64>) -> f64 {
        Vector2::new(to_light.y * self.axes.x, to_light.x * self.axes.y).norm()
    }

    fn normal(&self, at: &Vector2<f64>) -> Vector2<f64> {
        at.component_mul(&self.form).normalize()
    }

    /// The ray in light from the direction `to_light`, of unit length.
    pub(crate) fn trace(&self, cone: &Cone, to_light: Vector2<f64>, h: f64) -> TracedRay {
        let side = Vector2::new(to_light.y, -to_light.x)
            * (h.clamp(-1.0, 1.0) * self.half_width(&to_light));
        // First hit: the farther root of |side + t to_light| in the norm of the ellipse.
        let dot = |a: &Vector2<f64>, b: &Vector2<f64>| a.component_mul(b).dot(&self.form);
        let (qa, qb) = (dot(&to_light, &to_light), dot(&side, &to_light));
        let mut at = side
            + to_light * (((qb * qb - qa * (dot(&side, &side) - 1.0)).max(0.0).sqrt() - qb) / qa);
        // Snell with n' (Bravais), Fresnel in space.
        let normal = self.normal(&at);
        let cos_i = to_light.dot(&normal).clamp(0.0, 1.0);
        let eta = cone.inverse_index();
        let cos_t = cosine(eta * cosine(cos_i));
        let reflected = cone.reflectance(cos_i, cos_t);
        let mut inside = -to_light * eta + normal * (eta * cos_i - cos_t);
        let mut ray = TracedRay {
            azimuth: [change(&to_light, &(normal * (2.0 * cos_i) - to_light)), 0.0, 0.0],
            share: [reflected, 0.0, 0.0],
            length: [0.0; 3],
            later: 1.0 - reflected,
        };
        for order in 1..3 {
            let chord = -2.0 * dot(&at, &inside) / dot(&inside, &inside);
            at += inside * chord;
            ray.length[order] = ray.length[order - 1] + chord * inside.norm() * cone.stretch();
            let normal = self.normal(&at);
            let cos_t = inside.dot(&normal).clamp(0.0, 1.0);
            let sin_out = cosine(cos_t) / eta.max(1e-12);
            let leaves = sin_out < 1.0;
            let mut out = inside;
            if leaves {
                let cos_out = cosine(sin_out);
                let passed = ray.later * (1.0 - cone.reflectance(cos_out, cos_t));
                ray.share[order] = passed;
                ray.later -= passed;
                out = (inside - normal * cos_t) / eta + normal * cos_out;
            }
            ray.azimuth[order] = change(&to_light, &out);
            inside -= normal * (2.0 * cos_t);
        }
        ray
    }
}

impl TracedRay {
    /// What of each order leaves where the absorption is `sigma` per radius: `A exp(-sigma l)`. The
    /// later orders are taken to go on as from TT to TRT.
    pub(crate) fn absorbed(&self, sigma: &Vector3<f64>) -> [Vector3<f64>; 4] {
        let [_, first, second] = self.length;
        let (tt, trt) = (transmitted(sigma, first), transmitted(sigma, second));
        let third = transmitted(sigma, 2.0 * second - first);
        let [_, a, b] = self.share;
        [Vector3::repeat(self.share[0]), tt * a, trt * b, third * self.later]
    }
}

/// Angle from one direction to another in the plane, rad, in `[-pi, pi]`.
fn change(from: &Vector2<f64>, to: &Vector2<f64>) -> f64 {
    from.perp(to).atan2(from.dot(to))
}

/// Index that stands for an ellipse in TRT (thesis (6.12)): `a` is the ratio of the axis towards
/// `phi_h = 0` to the other (the thesis says eccentricity, erratum E10), `phi_h` the half angle of
/// both azimuths, rad. Kept to show its error (E11); [`EllipsePaths`] is right.
///
/// # Errors
/// [`ScatteringError::Parameter`] if `n` is not in `[1, 10]` or `a` not in `[1/16, 16]`.
pub fn equivalent_index(n: f64, a: f64, phi_h: f64) -> Result<f64, ScatteringError> {
    check_index(n)?;
    crate::error::check("a ratio of axes", a, "in [1/16, 16]", (0.0625..=16.0).contains(&a))?;
    let of = |a2: f64| 2.0 * (n - 1.0) * a2 - n + 2.0;
    let (n1, n2) = (of(a * a), of(1.0 / (a * a)));
    Ok(0.5 * ((n1 + n2) + (2.0 * phi_h).cos() * (n1 - n2)))
}
