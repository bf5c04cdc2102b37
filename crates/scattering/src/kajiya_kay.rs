use crate::direction::{inclination, turned};
use crate::draw::semicircle;
use crate::error::check;
use crate::longitudinal::Inclination;
use crate::{Arrival, FiberBsdf, LOBES, ScatteredRay, Scattering, ScatteringError};
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

/// The model of Kajiya and Kay (1989), for comparison: a diffuse part and a highlight on the
/// mirrored cone, the same all round the fibre. Both are scaled to what they scatter in level
/// light, and the highlight has no cosine of one side, so that it is reciprocal and gains no
/// energy.
///
/// Its lobes are the highlight, then the diffuse part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KajiyaKay {
    diffuse: Vector3<f64>,
    highlight: Vector3<f64>,
    exponent: f64,
}

impl KajiyaKay {
    /// The shares `diffuse` and `specular` of light, for red, green and blue, each at least 0 and
    /// together at most 1, and the exponent of the highlight, `cos^exponent(theta_i + theta_r)`.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if a share or the exponent, in `[0, 1e4]`, is outside its
    /// range.
    pub fn new(
        diffuse: Vector3<f64>,
        specular: Vector3<f64>,
        exponent: f64,
    ) -> Result<Self, ScatteringError> {
        for (a, b) in diffuse.iter().zip(&specular) {
            check("a diffuse share", *a, "at least 0", *a >= 0.0)?;
            check("a specular share", *b, "at least 0", *b >= 0.0)?;
            check("the sum of both shares", a + b, "at most 1", a + b <= 1.0)?;
        }
        check("the exponent", exponent, "in [0, 10000]", (0.0..=1e4).contains(&exponent))?;
        // Integral of cos^m over half a turn, m = exponent + 2, by the trapezoidal rule, which is
        // exact to rounding for so smooth a function with no slope at its ends.
        let nodes = 4096;
        let of = |k: u32| (PI * (f64::from(k) / f64::from(nodes) - 0.5)).cos().powf(exponent + 2.0);
        let integral = (1..nodes).map(of).sum::<f64>() * PI / f64::from(nodes);
        Ok(Self { diffuse: diffuse / (PI * PI), highlight: specular / (TAU * integral), exponent })
    }
}

impl FiberBsdf for KajiyaKay {
    fn arrive(&self, offset: f64, from: &Vector3<f64>) -> Arrival {
        Arrival::new(offset, from)
    }

    fn lobes(&self, arrival: &Arrival, to: &Vector3<f64>) -> [Vector3<f64>; LOBES] {
        let (i, r) = (arrival.inclination, inclination(to));
        let aligned = (i.cos * r.cos - i.sin * r.sin).max(0.0).powf(self.exponent);
        let mut lobes = [Vector3::zeros(); LOBES];
        (lobes[0], lobes[1]) = (self.highlight * aligned, self.diffuse);
        lobes
    }

    fn evaluate(&self, arrival: &Arrival, to: &Vector3<f64>) -> Scattering {
        let value = self.lobes(arrival, to).iter().sum();
        Scattering { value, pdf: inclination(to).cos / (PI * PI) }.or_none()
    }

    fn sample(&self, arrival: &Arrival, random: &mut dyn FnMut() -> f64) -> Option<ScatteredRay> {
        let sin = semicircle(random).clamp(-1.0, 1.0);
        let r = Inclination { sin, cos: (1.0 - sin * sin).sqrt() };
        let to = turned(&arrival.from, TAU * random(), &r);
        self.evaluate(arrival, &to).sampled(to, r.cos)
    }
}
