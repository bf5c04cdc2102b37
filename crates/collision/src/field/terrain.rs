//! Terrains that are made, not measured.

use super::HeightField;
use crate::CollisionError;
use crate::random::SplitMix64;
use std::f64::consts::TAU;

/// How many waves are laid over each other.
const WAVES: usize = 7;

/// Smooth hills and hollows: a sum of plane waves of random direction and phase, the same for the
/// same seed.
///
/// `h(x, y) = amplitude / 7 sum_k cos(tau (x cos a_k + y sin a_k) / wavelength_k + b_k)`, with
/// wavelengths spread between three quarters and five quarters of the mean, about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terrain {
    /// Length along x and y, m; the origin is in the middle.
    pub sides: [f64; 2],
    /// Distance of the heights, m.
    pub spacing: f64,
    /// Bound of the heights, up and down, m; the most that there are is about two thirds of it.
    pub amplitude: f64,
    /// Mean distance from crest to crest, m.
    pub wavelength: f64,
    /// Seed of directions and phases.
    pub seed: u64,
}

impl Terrain {
    /// The terrain as a field that is a distance up to `band`, m. Costs seven cosines a height.
    ///
    /// # Errors
    /// [`CollisionError::Heights`] for lengths that are not positive and finite, a spacing above a
    /// quarter of the wavelength, which the terrain would fall through, and more than 10^8 heights.
    pub fn field(&self, band: f64) -> Result<HeightField, CollisionError> {
        let Self { sides, spacing, amplitude, wavelength, seed } = *self;
        let refuse = |problem| Err(CollisionError::Heights { problem });
        let lengths = [sides[0], sides[1], spacing, wavelength];
        if !lengths.iter().all(|&x| x > 0.0 && x.is_finite()) || !amplitude.is_finite() {
            return refuse("all lengths must be finite, and sides, spacing, wavelength positive");
        }
        if spacing > 0.25 * wavelength {
            return refuse("the spacing must be at most a quarter of the wavelength");
        }
        let counts = sides.map(|side| (side / spacing).ceil() + 1.0);
        if counts[0] * counts[1] > 1e8 {
            return refuse("there are more than 10^8; take a larger spacing");
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "just checked")]
        let [columns, rows] = counts.map(|count| count as usize);
        let mut random = SplitMix64(seed);
        let waves: [_; WAVES] = std::array::from_fn(|_| {
            let (sin, cos) = (TAU * random.unit()).sin_cos();
            let number = TAU / (wavelength * (1.0 + 0.25 * random.signed()));
            (number * cos, number * sin, TAU * random.unit())
        });
        let origin = [columns, rows].map(|count| -0.5 * spacing * (count - 1) as f64);
        let height = |k: usize| {
            let x = origin[0] + spacing * (k % columns) as f64;
            let y = origin[1] + spacing * (k / columns) as f64;
            let sum: f64 = waves.iter().map(|(a, b, phase)| (a * x + b * y + phase).cos()).sum();
            amplitude / WAVES as f64 * sum
        };
        let heights = (0..columns * rows).map(height).collect();
        HeightField::new(origin, spacing, columns, heights, band)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::DistanceField;
    use nalgebra::Point3;

    const HILLS: Terrain =
        Terrain { sides: [0.4, 0.3], spacing: 0.002, amplitude: 0.03, wavelength: 0.1, seed: 3 };

    #[test]
    fn a_terrain_has_hills_and_hollows_within_its_bounds_and_is_its_seed() {
        let field = HILLS.field(0.004).expect("sound");
        let surface = field.surface();
        assert_eq!(surface.vertices.len(), 201 * 151);
        assert_eq!(surface.triangles.len(), 2 * 200 * 150);
        let heights = || surface.vertices.iter().map(|p| p.z);
        let (low, high) = (heights().fold(0.0, f64::min), heights().fold(0.0, f64::max));
        assert!((-0.03..-0.008).contains(&low) && (0.008..0.03).contains(&high), "{low} {high}");
        for p in surface.vertices.iter().step_by(97) {
            assert!(field.value(p).abs() < 1e-12);
            assert!(field.value(&Point3::new(p.x, p.y, p.z + 0.001)) > 0.0);
        }
        assert_eq!(HILLS.field(0.004), Ok(field.clone()));
        assert_ne!(Terrain { seed: 4, ..HILLS }.field(0.004), Ok(field));
    }

    #[test]
    fn what_is_no_terrain_is_refused() {
        for bad in [
            Terrain { spacing: 0.03, ..HILLS },
            Terrain { spacing: 1e-9, ..HILLS },
            Terrain { sides: [0.4, 0.0], ..HILLS },
            Terrain { wavelength: f64::NAN, ..HILLS },
            Terrain { amplitude: f64::INFINITY, ..HILLS },
        ] {
            assert!(matches!(bad.field(0.004), Err(CollisionError::Heights { .. })), "{bad:?}");
        }
    }
}
