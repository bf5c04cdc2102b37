use crate::circle::CirclePaths;
use crate::direction::flat;
use crate::ellipse::EllipseOutline;
use crate::exponential::transmitted;
use crate::longitudinal::{Inclination, SymmetricLobe};
use crate::refraction::{Cone, cosine};
use crate::roughness::Logistic;
use crate::{FiberOptics, OrderShares, Polarization, ScatteringError};
use nalgebra::{Vector2, Vector3};
use rapunzel_fiber::Section;
use std::f64::consts::{FRAC_PI_2, PI};

/// The outline of a fibre, of the area of the unit circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum FiberOutline {
    Circle,
    Ellipse(EllipseOutline),
}

impl FiberOutline {
    pub(crate) fn of(section: &Section) -> Result<Self, ScatteringError> {
        section.validate()?;
        match section {
            Section::Circle { .. } => Ok(Self::Circle),
            Section::Ellipse { .. } => EllipseOutline::of(section).map(Self::Ellipse),
        }
    }
}

/// An offset, with what of its projected angle of incidence all inclinations share.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Offset {
    pub(crate) h: f64,
    cos: f64,
    /// Twice the angle, rad.
    turn: f64,
}

impl Offset {
    pub(crate) fn of(h: f64) -> Self {
        let h = h.clamp(-1.0, 1.0);
        Self { h, cos: cosine(h), turn: 2.0 * h.asin() }
    }
}

/// What becomes of a ray at one offset.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Rays {
    /// Changes of azimuth of R, TT and TRT, rad.
    pub(crate) azimuth: [f64; 3],
    /// What leaves of R, TT, TRT and later orders, for red, green and blue.
    pub(crate) energy: [Vector3<f64>; 4],
}

/// A fibre, prepared: its lobes without what keeps their balance.
#[derive(Debug, Clone)]
pub(crate) struct Scatterer {
    pub(crate) optics: FiberOptics,
    pub(crate) outline: FiberOutline,
    pub(crate) lobes: [SymmetricLobe; 4],
    pub(crate) azimuthal: Logistic,
}

impl Scatterer {
    pub(crate) fn new(optics: FiberOptics, outline: FiberOutline) -> Result<Self, ScatteringError> {
        optics.validate()?;
        if outline != FiberOutline::Circle && optics.polarization == Polarization::Tracked {
            return Err(ScatteringError::TrackedEllipse);
        }
        let ([r, tt, trt], v) = (optics.tilt.shift, optics.variance);
        let lobe = SymmetricLobe::new;
        let lobes = [lobe(v[0], r)?, lobe(v[1], tt)?, lobe(v[2], trt)?, lobe(v[3], 0.0)?];
        let azimuthal = Logistic::new(optics.azimuthal_scale);
        Ok(Self { optics, outline, lobes, azimuthal })
    }

    /// The cone of the inclination whose squared cosine is `cos2`.
    pub(crate) fn cone(&self, cos2: f64) -> Cone {
        Cone::new(self.optics.refractive_index, cos2)
    }

    /// The rays at the offset `h` to light from the direction `from`, on the cone.
    pub(crate) fn rays(&self, cone: Cone, from: &Vector3<f64>, h: &Offset) -> Rays {
        let sigma = &self.optics.absorption;
        match &self.outline {
            FiberOutline::Circle => {
                let sin_t = h.h * cone.inverse_index();
                let (cos_t, turn) = (cosine(sin_t), 2.0 * sin_t.asin());
                let shares = OrderShares::at(&cone, h.h, [h.cos, cos_t], self.optics.polarization);
                let energy = shares.absorbed(&transmitted(sigma, 2.0 * cos_t * cone.stretch()));
                Rays { azimuth: [-h.turn, turn - h.turn + PI, 2.0 * turn - h.turn], energy }
            }
            FiberOutline::Ellipse(ellipse) => {
                let ray = ellipse.trace(&cone, flat(from), h.h);
                Rays { azimuth: ray.azimuth, energy: ray.absorbed(sigma) }
            }
        }
    }

    /// Hands over where each lobe leaves of light from `theta_i`, rad: its index, the inclination,
    /// and the lobe times the measure `cos^2 theta_r d theta_r`, at the nodes of a quadrature.
    pub(crate) fn over_ends(
        &self,
        theta_i: f64,
        rule: &[[f64; 2]],
        mut take: impl FnMut(usize, &Inclination, f64),
    ) {
        let theta_i = theta_i.clamp(-FRAC_PI_2, FRAC_PI_2);
        let i = Inclination::of(theta_i);
        for (p, lobe) in self.lobes.iter().enumerate() {
            for [low, high] in lobe.support(theta_i).into_iter().filter(|[low, high]| low < high) {
                for [x, weight] in rule {
                    let r = Inclination::of(low + 0.5 * (1.0 + x) * (high - low));
                    let measure = 0.5 * weight * (high - low) * r.cos * r.cos;
                    take(p, &r, measure * lobe.at(&i, &r));
                }
            }
        }
    }

    /// What leaves in each order, with the absorption and without it.
    pub(crate) fn energies(&self, cone: Cone, phi: f64, h: f64) -> [[Vector3<f64>; 4]; 2] {
        match &self.outline {
            FiberOutline::Circle => {
                let paths = CirclePaths::of(cone);
                let shares = OrderShares::new(&paths, h, self.optics.polarization);
                let t = transmitted(&self.optics.absorption, paths.segment(h));
                [shares.absorbed(&t), shares.absorbed(&Vector3::repeat(1.0))]
            }
            FiberOutline::Ellipse(ellipse) => {
                let ray = ellipse.trace(&cone, Vector2::new(phi.cos(), phi.sin()), h);
                [ray.absorbed(&self.optics.absorption), ray.absorbed(&Vector3::zeros())]
            }
        }
    }
}

/// Squared cosine of `theta_d = (theta_r - theta_i) / 2`, the inclination at which a lobe between
/// both is attenuated: symmetric, as reciprocity needs (thesis (6.3)).
pub(crate) fn cos2_half_difference(i: &Inclination, r: &Inclination) -> f64 {
    (0.5 * (1.0 + i.cos * r.cos + i.sin * r.sin)).clamp(0.0, 1.0)
}

/// `tan(|theta| / 2)`, in `[0, 1]`: an index of tables over inclinations that is nearly even in
/// the angle and costs no trigonometric function.
pub(crate) fn half_tangent(cos2: f64) -> f64 {
    (1.0 - cos2).max(0.0).sqrt() / (1.0 + cos2.sqrt())
}
