use crate::PathRandom;
use crate::curves::across;
use nalgebra::{Matrix3, Point3, Vector3};
use rapunzel_scattering::{Arrival, FiberBsdf};
use std::f64::consts::{FRAC_1_PI, TAU};

/// Where a path meets something.
pub(crate) struct PathVertex<'a> {
    /// The point (world), m.
    pub(crate) position: Point3<f64>,
    /// Normal (world), of unit length.
    pub(crate) normal: Vector3<f64>,
    /// Distance, m, within which a ray that goes on from here meets nothing.
    pub(crate) clearance: f64,
    /// Index of the fibre.
    pub(crate) fiber: Option<usize>,
    pub(crate) scatterer: VertexScattering<'a>,
}

/// How light is scattered there.
pub(crate) enum VertexScattering<'a> {
    /// By a fibre, whose frame has the columns d1, d2, d3 (world).
    Fiber {
        bsdf: &'a (dyn FiberBsdf + Send + Sync),
        arrival: Arrival,
        frame: Matrix3<f64>,
        albedo: Vector3<f64>,
    },
    /// By a matte surface (Lambert), seen from the side of its normal.
    Matte { face: Vector3<f64>, normal: Vector3<f64>, albedo: Vector3<f64> },
}

/// A direction in which a path goes on.
pub(crate) struct Onward {
    /// The direction (world), of unit length.
    pub(crate) direction: Vector3<f64>,
    /// What of the light along it comes back.
    pub(crate) weight: Vector3<f64>,
    /// Density with which it was drawn, per sr.
    pub(crate) pdf: f64,
}

impl VertexScattering<'_> {
    pub(crate) fn albedo(&self) -> Vector3<f64> {
        match self {
            Self::Fiber { albedo, .. } | Self::Matte { albedo, .. } => *albedo,
        }
    }

    /// What of the radiance along a direction comes back, per sr, cosine included, and the density
    /// with which [`Self::sample`] draws it.
    #[inline]
    pub(crate) fn evaluate(&self, direction: &Vector3<f64>) -> (Vector3<f64>, f64) {
        match self {
            Self::Fiber { bsdf, arrival, frame, .. } => {
                let to = frame.tr_mul(direction);
                let scattering = bsdf.evaluate(arrival, &to);
                (scattering.value * to.xy().norm(), scattering.pdf)
            }
            Self::Matte { face, normal, albedo } => {
                let cosine = normal.dot(direction);
                // Beneath the face there is no light, whatever a smooth normal says.
                if cosine <= 0.0 || face.dot(direction) <= 0.0 {
                    return (Vector3::zeros(), cosine.max(0.0) * FRAC_1_PI);
                }
                (albedo * (cosine * FRAC_1_PI), cosine * FRAC_1_PI)
            }
        }
    }

    /// A direction in which the path goes on; `None` where all is absorbed.
    #[inline]
    pub(crate) fn sample(&self, random: &mut PathRandom) -> Option<Onward> {
        match self {
            Self::Fiber { bsdf, arrival, frame, .. } => {
                let ray = bsdf.sample(arrival, &mut || random.number())?;
                let direction = (frame * ray.to).normalize();
                Some(Onward { direction, weight: ray.weight, pdf: ray.pdf })
            }
            Self::Matte { face, normal, albedo } => {
                // By the cosine: a point of the disc, lifted to the sphere (Malley).
                let [u, v] = random.pair();
                let (radius, (sin, cos)) = (u.sqrt(), (TAU * v).sin_cos());
                let [x, y] = across(normal);
                let cosine = (1.0 - u).sqrt();
                let flat = x * (radius * cos) + y * (radius * sin);
                let direction = (flat + normal * cosine).normalize();
                let above = cosine > 0.0 && face.dot(&direction) > 0.0;
                above.then_some(Onward { direction, weight: *albedo, pdf: cosine * FRAC_1_PI })
            }
        }
    }
}
