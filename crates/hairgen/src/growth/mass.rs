//! How many hairs there are.

use super::disc_map::DiscMap;
use super::field::DiscField;
use super::scalp::ScalpMesh;
use crate::HairgenError;
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

/// Largest density, 1/m^2: hairs of 10 um side by side.
pub(crate) const MOST_DENSITY: f64 = 1e10;

/// Parts of the side of a triangle at most over which a density is summed.
const MOST_PARTS: f64 = 1024.0;

/// The integral of a density over the scalp, with its largest value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mass {
    whole: f64,
    most: f64,
    area: f64,
}

impl Mass {
    /// Sums over equal parts of every triangle, no larger than the grain of the density, by their
    /// middles: exact for what is linear in a triangle. Densities must be finite and not negative.
    pub(super) fn new(
        mesh: &ScalpMesh,
        map: &DiscMap,
        density: &DiscField,
    ) -> Result<Self, HairgenError> {
        let faces = (0..mesh.triangles().len()).into_par_iter();
        let of_face = |face: usize| {
            let number = u32::try_from(face).unwrap_or(u32::MAX);
            let (mean, most) = mean_over(map.corners(number), density)?;
            Ok((mean * mesh.areas()[face], most))
        };
        // Of several errors the first is told, not that of the fastest thread.
        let parts: Vec<Result<(f64, f64), HairgenError>> = faces.map(of_face).collect();
        let parts = parts.into_iter().collect::<Result<Vec<_>, _>>()?;
        let whole = parts.iter().map(|(mass, _)| mass).sum();
        let most = parts.iter().fold(0.0, |most: f64, part| most.max(part.1));
        Ok(Self { whole, most, area: mesh.area() })
    }

    /// The integral, rounded.
    pub(super) fn count(&self) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        let count = self.whole.round() as usize;
        count
    }

    /// The mean in parts of the largest value; zero where all is zero.
    pub(super) fn share(&self) -> f64 {
        if self.most > 0.0 { self.whole / (self.most * self.area) } else { 0.0 }
    }
}

/// Mean and largest value of a density over a triangle of the disc.
fn mean_over([a, b, c]: [Point2<f64>; 3], density: &DiscField) -> Result<(f64, f64), HairgenError> {
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let parts = (longest / density.grain()).ceil().clamp(1.0, MOST_PARTS);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "up to 1024")]
    let count = parts as u32;
    let (e, f): (Vector2<f64>, Vector2<f64>) = ((b - a) / parts, (c - a) / parts);
    let (mut sum, mut most) = (0.0, 0.0);
    for row in 0..count {
        for column in 0..count - row {
            // The part at this corner, and the one beyond its far side.
            let thirds: &[f64] = if row + column + 1 < count { &[1.0, 2.0] } else { &[1.0] };
            for third in thirds {
                let [x, y] = [column, row].map(|k| f64::from(k) + third / 3.0);
                let place = a + x * e + y * f;
                let value = density.checked("density (1/m^2)", &place, [0.0, MOST_DENSITY])?;
                sum += value;
                most = f64::max(most, value);
            }
        }
    }
    Ok((sum / (parts * parts), most))
}
