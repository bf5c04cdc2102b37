use crate::balance::BalancePoint;
use crate::direction::inclination;
use crate::longitudinal::Inclination;
use crate::scatterer::{Offset, Rays};
use nalgebra::Vector3;

/// Number of parts that a model tells apart: R, TT, TRT, all later orders, and what keeps the
/// balance of energy.
pub const LOBES: usize = 5;

/// How a fibre scatters light, as a path tracer needs it.
///
/// Radiance that leaves a fibre is `L_r(omega_r) = integral f(omega_i, omega_r) L_i cos theta_i d
/// omega_i`, averaged over its width; directions point away from the fibre, are of unit length, and
/// have their components in its frame `[d1 d2 d3]`; `theta` is their inclination, the angle to the
/// normal plane, positive towards the tip, `cos theta` thus the length of their first two
/// components. The thesis's `S` (6.1) is this `f`, read with the errata E7 and E15.
///
/// A path arrives at an offset from a direction; both stay, and directions to go on are asked for.
/// Which of the two is that of the light does not matter for a reciprocal model.
pub trait FiberBsdf {
    /// Prepares the scattering at one hit: `offset` is `(x . (w x d3)) / half width`, in `[-1, 1]`,
    /// with `w` the direction `from` and `x` the point that was hit, from the axis. Models of the
    /// far field ignore it.
    fn arrive(&self, offset: f64, from: &Vector3<f64>) -> Arrival;

    /// The parts of `f` between where the path arrived from and `to`, per sr, for red, green and
    /// blue.
    fn lobes(&self, arrival: &Arrival, to: &Vector3<f64>) -> [Vector3<f64>; LOBES];

    /// `f`, the sum of the lobes, and the density with which [`Self::sample`] takes `to`.
    fn evaluate(&self, arrival: &Arrival, to: &Vector3<f64>) -> Scattering;

    /// A direction to go on, drawn with numbers even in `[0, 1)`; `None` where all is absorbed.
    fn sample(&self, arrival: &Arrival, random: &mut dyn FnMut() -> f64) -> Option<ScatteredRay>;
}

/// A path that has arrived at a fibre: where from, and what a model keeps of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    pub(crate) offset: Offset,
    pub(crate) from: Vector3<f64>,
    pub(crate) inclination: Inclination,
    /// The balance of energy there, where a model keeps one.
    pub(crate) balance: BalancePoint,
    /// What is scattered of the light, the mean of the colors, where samples have that weight.
    pub(crate) albedo: f64,
    /// The rays, where a model attenuates all lobes at the inclination of `from`.
    pub(crate) rays: Rays,
    /// Chances of the lobes at the inclination of `from`, as each model uses them.
    pub(crate) chances: [f64; LOBES],
}

impl Arrival {
    /// An arrival of which nothing is prepared.
    pub(crate) fn new(offset: f64, from: &Vector3<f64>) -> Self {
        let offset = Offset::of(offset);
        let (inclination, balance) = (inclination(from), BalancePoint::default());
        let (albedo, rays) = (0.0, Rays::default());
        let chances = [0.0; LOBES];
        Self { offset, from: *from, inclination, balance, albedo, rays, chances }
    }
}

/// Light between two directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scattering {
    /// The scattering function `f`, per sr, for red, green and blue.
    pub value: Vector3<f64>,
    /// Density of samples, per sr; its integral over all directions is 1.
    pub pdf: f64,
}

/// A direction that a path takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatteredRay {
    /// The direction, of unit length, in the frame of the fibre.
    pub to: Vector3<f64>,
    /// `f cos theta / pdf`, for red, green and blue: what of the light along `to` comes back.
    pub weight: Vector3<f64>,
    /// Density with which it was drawn, per sr.
    pub pdf: f64,
}

impl Scattering {
    pub(crate) const NONE: Self = Self { value: Vector3::new(0.0, 0.0, 0.0), pdf: 0.0 };

    /// This, or nothing if a number is not finite: directions that are none scatter no light.
    pub(crate) fn or_none(self) -> Self {
        if self.pdf.is_finite() && self.value.iter().all(|v| v.is_finite()) {
            self
        } else {
            Self::NONE
        }
    }

    /// The sample of the direction `to`, whose inclination has the cosine `cos`.
    pub(crate) fn sampled(&self, to: Vector3<f64>, cos: f64) -> Option<ScatteredRay> {
        let weight = self.value * (cos / self.pdf);
        (self.pdf > 0.0).then_some(ScatteredRay { to, weight, pdf: self.pdf })
    }
}
