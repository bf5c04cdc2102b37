use crate::CirclePaths;
use crate::refraction::{Cone, cosine};
use nalgebra::{Matrix2, Vector3};

/// What is done about the polarisation of light inside a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Polarization {
    /// The reflectance is averaged over s and p at every hit, as the thesis ((6.7), (6.8)) and
    /// all renderers do.
    #[default]
    Averaged,
    /// Amplitudes of s and p are kept apart from hit to hit, turned from one plane of incidence
    /// into the next, and averaged when light leaves: for a smooth circle in level light 8.7 % less
    /// TRT (n = 1.55).
    Tracked,
}

/// Shares of light in the orders of a fibre that does not absorb: R, TT, TRT and all later ones;
/// they add to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrderShares {
    /// R, TT and TRT.
    pub first: [f64; 3],
    /// All orders from the third on.
    pub later: f64,
    /// Share of the light of an order that the next has, from the third on.
    pub ratio: f64,
}

impl OrderShares {
    /// Shares at the offset `h` of a circle (thesis (6.7), (6.8)).
    #[must_use]
    pub fn new(paths: &CirclePaths, h: f64, polarization: Polarization) -> Self {
        Self::at(paths.cone(), h, paths.cosines(h), polarization)
    }

    pub(crate) fn at(
        cone: &Cone,
        h: f64,
        [cos_i, cos_t]: [f64; 2],
        polarization: Polarization,
    ) -> Self {
        match polarization {
            Polarization::Averaged => {
                let f = cone.reflectance(cos_i, cos_t);
                let (t, later) = ((1.0 - f) * (1.0 - f), (1.0 - f) * f * f);
                Self { first: [f, t, t * f], later, ratio: f }
            }
            Polarization::Tracked => tracked(cone, h, cos_i, cos_t),
        }
    }

    /// What of each order leaves a fibre where one segment transmits `t`, in `[0, 1]`: `A T^p`
    /// (thesis (6.9)), the later orders as a geometric series.
    #[must_use]
    pub fn absorbed(&self, t: &Vector3<f64>) -> [Vector3<f64>; 4] {
        let [r, tt, trt] = self.first;
        let later = |t: f64| {
            let lost = 1.0 - self.ratio;
            self.later * (t * t * t) * if lost > 0.0 { lost / (1.0 - self.ratio * t) } else { 1.0 }
        };
        [Vector3::repeat(r), t * tt, t.component_mul(t) * trt, t.map(later)]
    }

    /// Share of the single order `p`, without absorption. With tracked polarisation those beyond
    /// the third are taken as a geometric series, whose sum is right.
    #[must_use]
    pub fn order(&self, p: u32) -> f64 {
        match p {
            0..3 => self.first[p as usize],
            _ => self.later * (1.0 - self.ratio) * self.ratio.powf(f64::from(p) - 3.0),
        }
    }
}

/// Jones's calculus: in at the first hit, round to the plane of the next, reflected there, and so
/// on.
///
/// With `k` the direction inside, a segment meets both its ends under the same angle `gamma_t` on
/// opposite sides, so the planes of incidence are turned by one angle `chi` at every hit: `cos chi
/// = (s^2 c^2 - g^2) / (s^2 c^2 + g^2)`, `sin chi = -2 s g c / (s^2 c^2 + g^2)`, with `s = sin
/// theta_t`, `g = sin gamma_t`, `c = cos gamma_t`.
fn tracked(cone: &Cone, h: f64, cos_i: f64, cos_t: f64) -> OrderShares {
    let [s, p] = cone.amplitudes(cos_i, cos_t);
    let (s_c, g) = (cosine(cone.cos_inside()) * cos_t, h * cone.inverse_index());
    let norm = s_c * s_c + g * g;
    let turn = if norm > 0.0 {
        let (cos, sin) = ((s_c * s_c - g * g) / norm, -2.0 * s_c * g / norm);
        Matrix2::new(cos, sin, -sin, cos)
    } else {
        Matrix2::identity()
    };
    let through = Matrix2::new(cosine(s), 0.0, 0.0, cosine(p));
    let reflected = turn * Matrix2::new(s, 0.0, 0.0, p);
    let mut inside = turn * through;
    let mut leaves = || {
        let share = 0.5 * (through * inside).norm_squared();
        inside = reflected * inside;
        share
    };
    let first = [0.5 * (s * s + p * p), leaves(), leaves()];
    let third = leaves();
    let later = (1.0 - first.iter().sum::<f64>()).max(third);
    let ratio = if later > 0.0 { 1.0 - third / later } else { 0.0 };
    OrderShares { first, later, ratio }
}
