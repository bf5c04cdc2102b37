use crate::color::luminance;
use nalgebra::Vector3;

/// What one path found in a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmSample {
    /// Radiance that reaches the camera, W/(m^2 sr), red, green and blue.
    pub radiance: Vector3<f64>,
    /// The first surface on the path; `None` if it met none. The share of paths that met one is the
    /// coverage of the pixel.
    pub surface: Option<FirstSurface>,
}

/// The first surface that a path from the camera met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstSurface {
    /// Its albedo, in `[0, 1]`.
    pub albedo: Vector3<f64>,
    /// Its normal (world), of unit length.
    pub normal: Vector3<f64>,
    /// Its distance from where the path began, m.
    pub depth: f64,
    /// Number of the fibre; [`FilmPixel::NO_FIBER`] for what is none.
    pub fiber: u32,
}

/// Sums over the samples of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmPixel {
    pub(super) sums: PixelSums,
    pub(super) fiber: u32,
    pub(super) samples: u32,
    pub(super) covered: u32,
    pub(super) rejected: u32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PixelSums {
    pub(super) radiance: Vector3<f64>,
    /// Of the square of luminance.
    pub(super) square: f64,
    pub(super) albedo: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
    pub(super) depth: f64,
}

impl PixelSums {
    /// Numbers in it.
    pub(super) const COUNT: usize = 11;

    pub(super) fn numbers(&self) -> [f64; Self::COUNT] {
        let ([r, g, b], [a, c, d]) = (self.radiance.into(), self.albedo.into());
        let [x, y, z] = self.normal.into();
        [r, g, b, self.square, a, c, d, x, y, z, self.depth]
    }

    pub(super) fn of(numbers: [f64; Self::COUNT]) -> Self {
        let [r, g, b, square, a, c, d, x, y, z, depth] = numbers;
        let [radiance, albedo, normal] = [[r, g, b], [a, c, d], [x, y, z]].map(Vector3::from);
        Self { radiance, square, albedo, normal, depth }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.numbers().iter().all(|x| x.is_finite())
    }
}

impl FilmPixel {
    /// The number of a fibre where there is none.
    pub const NO_FIBER: u32 = u32::MAX;

    pub(super) const EMPTY: Self = Self {
        sums: PixelSums {
            radiance: Vector3::new(0.0, 0.0, 0.0),
            square: 0.0,
            albedo: Vector3::new(0.0, 0.0, 0.0),
            normal: Vector3::new(0.0, 0.0, 0.0),
            depth: 0.0,
        },
        fiber: Self::NO_FIBER,
        samples: 0,
        covered: 0,
        rejected: 0,
    };

    /// Adds a sample, or counts it as rejected if a number in it or in its sum is not finite.
    /// Sums depend on the order of the samples in their last bits.
    pub fn add(&mut self, sample: &FilmSample) {
        let mut sums = self.sums;
        sums.radiance += sample.radiance;
        sums.square += luminance(&sample.radiance).powi(2);
        if let Some(surface) = &sample.surface {
            sums.albedo += surface.albedo;
            sums.normal += surface.normal;
            sums.depth += surface.depth;
        }
        if !sums.is_finite() {
            self.rejected = self.rejected.saturating_add(1);
            return;
        }
        if self.samples == 0 {
            self.fiber = sample.surface.map_or(Self::NO_FIBER, |surface| surface.fiber);
        }
        self.sums = sums;
        // Nobody waits for 2^32 samples.
        self.samples = self.samples.saturating_add(1);
        self.covered = self.covered.saturating_add(u32::from(sample.surface.is_some()));
    }

    /// Number of samples that were added.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Number of samples that were not, since they were not finite.
    #[must_use]
    pub fn rejected(&self) -> u32 {
        self.rejected
    }

    /// Mean radiance, W/(m^2 sr); zero without samples, as all means are.
    #[must_use]
    pub fn radiance(&self) -> Vector3<f64> {
        self.sums.radiance / self.divisor()
    }

    /// Share of the samples that met a surface, in `[0, 1]`.
    #[must_use]
    pub fn coverage(&self) -> f64 {
        f64::from(self.covered) / self.divisor()
    }

    /// Mean albedo of the first surface, zero where there is none.
    #[must_use]
    pub fn albedo(&self) -> Vector3<f64> {
        self.sums.albedo / self.divisor()
    }

    /// Mean normal of the first surface (world), zero where there is none; at most of unit length.
    #[must_use]
    pub fn normal(&self) -> Vector3<f64> {
        self.sums.normal / self.divisor()
    }

    /// Mean distance of the first surface, m, over the samples that met one; `None` if none did.
    #[must_use]
    pub fn depth(&self) -> Option<f64> {
        (self.covered > 0).then(|| self.sums.depth / f64::from(self.covered))
    }

    /// Number of the fibre that the first sample met, or [`Self::NO_FIBER`].
    #[must_use]
    pub fn fiber(&self) -> u32 {
        self.fiber
    }

    /// Standard error of the luminance of [`Self::radiance`], W/(m^2 sr); `None` for fewer than two
    /// samples, which do not tell.
    #[must_use]
    pub fn standard_error(&self) -> Option<f64> {
        let (count, mean) = (f64::from(self.samples), luminance(&self.radiance()));
        let variance = (self.sums.square / count - mean * mean).max(0.0) / (count - 1.0);
        (self.samples > 1).then(|| variance.sqrt())
    }

    fn divisor(&self) -> f64 {
        f64::from(self.samples.max(1))
    }
}
