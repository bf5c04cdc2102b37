use crate::ScatteringError;
use crate::error::check;

/// Shares of light that an interface reflects, by its polarisation, in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FresnelReflectance {
    /// Of light polarised perpendicular to the plane of incidence.
    pub s: f64,
    /// Of light polarised in the plane of incidence.
    pub p: f64,
}

impl FresnelReflectance {
    /// Fresnel's equations for light that enters a medium of index `n >= 1`: `cos_i` is the cosine
    /// of the angle of incidence and `cos_t` that of the refracted ray. Light that leaves by the
    /// same path has the same reflectance, so `F(1/n, gamma_t) = F(n, gamma_i)` in (6.8) of the
    /// thesis, and its second footnote is harmless (erratum E16).
    #[must_use]
    pub fn new(n: f64, cos_i: f64, cos_t: f64) -> Self {
        let [s, p] = fresnel_amplitudes(n, cos_i, cos_t);
        Self { s: s * s, p: p * p }
    }

    /// The same by the two indices of Bravais and the projected angles: `n'` in the term of s,
    /// `n''` in that of p, with the refracted angle always from `n'` (thesis, after (6.9), which
    /// leaves that open: erratum E3). Equal to [`Self::new`] at the angles in space; it is there to
    /// show that.
    #[must_use]
    pub fn projected(bravais: &BravaisIndices, h: f64) -> Self {
        let (cos_i, sin_t) = (cosine(h), h / bravais.perpendicular);
        let cos_t = cosine(sin_t);
        let s = quotient(cos_i, bravais.perpendicular * cos_t);
        let p = quotient(bravais.parallel * cos_i, cos_t);
        Self { s: s * s, p: p * p }
    }

    /// The mean, for unpolarised light.
    #[must_use]
    pub fn mean(&self) -> f64 {
        0.5 * (self.s + self.p)
    }
}

/// Amplitudes that belong to s and p, signed.
pub(crate) fn fresnel_amplitudes(n: f64, cos_i: f64, cos_t: f64) -> [f64; 2] {
    [quotient(cos_i, n * cos_t), quotient(n * cos_i, cos_t)]
}

fn quotient(a: f64, b: f64) -> f64 {
    // Both are zero only where light grazes a medium of index 1: nothing is reflected.
    if a + b > 0.0 { (a - b) / (a + b) } else { 0.0 }
}

/// Cosine of an angle in `[-pi/2, pi/2]` from its sine.
pub(crate) fn cosine(sine: f64) -> f64 {
    (1.0 - sine * sine).max(0.0).sqrt()
}

/// Indices of Bravais of a fibre under the inclination theta: with them the projections of rays
/// onto the normal plane obey the laws of the plane (thesis, after (6.9)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BravaisIndices {
    /// `n' = sqrt(n^2 - sin^2 theta) / cos theta`, at least `n`; grows without bound towards
    /// grazing.
    pub perpendicular: f64,
    /// `n'' = n^2 cos theta / sqrt(n^2 - sin^2 theta)`, so `n' n'' = n^2`. The thesis prints
    /// `cos^2 theta` (erratum E2).
    pub parallel: f64,
}

impl BravaisIndices {
    /// The indices of a medium of index `n` under the inclination `theta`, rad.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if `n` is not in `[1, 10]` or `theta` not inside `(-pi/2,
    /// pi/2)`, at whose ends `n'` is infinite and `n''` zero.
    pub fn new(n: f64, theta: f64) -> Result<Self, ScatteringError> {
        check_index(n)?;
        let cos = theta.cos();
        let inside = theta.abs() < std::f64::consts::FRAC_PI_2 && cos > 0.0;
        check("the inclination (rad)", theta, "inside (-pi/2, pi/2)", inside)?;
        let perpendicular = Cone::new(n, cos * cos).root / cos;
        Ok(Self { perpendicular, parallel: n * n / perpendicular })
    }
}

/// Refuses an index of refraction that no fibre has.
pub(crate) fn check_index(n: f64) -> Result<(), ScatteringError> {
    check("the index of refraction", n, "in [1, 10]", (1.0..=10.0).contains(&n))
}

/// The cone on which a smooth fibre scatters light of one inclination: all that the lobes need of
/// the inclination, without a limit to take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cone {
    pub(crate) n: f64,
    /// Cosine of the inclination outside.
    pub(crate) cos: f64,
    /// `sqrt(n^2 - sin^2 theta)`, `n` times the cosine of the inclination inside.
    root: f64,
}

impl Cone {
    /// The cone of the inclination whose squared cosine is `cos2`.
    pub(crate) fn new(n: f64, cos2: f64) -> Self {
        let cos2 = cos2.clamp(0.0, 1.0);
        Self { n, cos: cos2.sqrt(), root: (n * n - 1.0 + cos2).sqrt() }
    }

    /// `1 / n'`, from 0 at grazing to `1 / n`; 1 where the index is 1.
    pub(crate) fn inverse_index(&self) -> f64 {
        if self.root > 0.0 { self.cos / self.root } else { 1.0 }
    }

    /// Cosine of the inclination inside.
    pub(crate) fn cos_inside(&self) -> f64 {
        self.root / self.n
    }

    /// Length of a ray inside per length of its projection, `1 / cos theta_t`. The thesis prints
    /// `1 / sin theta_i` (after (6.9), erratum E1), by which a fibre in level light would be black.
    pub(crate) fn stretch(&self) -> f64 {
        self.n / self.root.max(1e-8)
    }

    /// Amplitudes of reflection for projected angles with these cosines.
    pub(crate) fn amplitudes(&self, cos_gamma_i: f64, cos_gamma_t: f64) -> [f64; 2] {
        fresnel_amplitudes(self.n, self.cos * cos_gamma_i, self.cos_inside() * cos_gamma_t)
    }

    /// Reflectance for unpolarised light at projected angles with these cosines.
    pub(crate) fn reflectance(&self, cos_gamma_i: f64, cos_gamma_t: f64) -> f64 {
        let [s, p] = self.amplitudes(cos_gamma_i, cos_gamma_t);
        0.5 * (s * s + p * p)
    }
}
