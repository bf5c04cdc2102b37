use crate::check::{check, unit};
use crate::color::luminance;
use crate::size::pixel_count;
use crate::{PathRandom, RenderError};
use nalgebra::{Rotation3, Unit, Vector3};
use std::f64::consts::{PI, TAU};

/// Radiance of the sky by latitude and longitude, constant over each pixel, as panoramas have it.
///
/// Row 0 ends at the zenith, the last row at the nadir. The middle of a row lies above the `x` axis
/// of the world (its `y` axis if `x` is upright), turned by the rotation, and columns run to the
/// right as seen from inside. Directions are drawn in proportion to luminance, a pixel by its solid
/// angle and even within, by two binary searches. It takes 20 bytes a pixel.
#[derive(Debug, Clone)]
pub struct SkyMap {
    width: usize,
    height: usize,
    /// Red, green and blue, row by row from the top.
    pixels: Vec<[f32; 3]>,
    /// To the middle of a row, to the left of it, and upward.
    axes: [Vector3<f64>; 3],
    /// Luminance times solid angle of all rows up to the end of each.
    rows: Vec<f64>,
    /// Luminance of all pixels of a row up to the end of each.
    columns: Vec<f64>,
}

impl SkyMap {
    /// A map of `width` times `height` pixels, row by row, W/(m^2 sr), with `up` (world, of any
    /// length) upright and turned around it by `rotation`, rad, counterclockwise as seen from
    /// above.
    ///
    /// # Errors
    /// [`RenderError::PictureSize`] if there are no pixels or more than 2^28;
    /// [`RenderError::SkyMap`] if their number does not match, one is negative or not finite, or
    /// all are black; [`RenderError::Parameter`] if `up` or `rotation` is none.
    pub fn new(
        width: u32,
        height: u32,
        pixels: Vec<[f32; 3]>,
        up: &Vector3<f64>,
        rotation: f64,
    ) -> Result<Self, RenderError> {
        let count = pixel_count([width, height])?;
        let axes = axes(up, rotation)?;
        let (width, height) = (width as usize, height as usize);
        let bad = |problem: String| RenderError::SkyMap { problem };
        if pixels.len() != count {
            let given = pixels.len();
            return Err(bad(format!("{given} pixels are given for {width} x {height}")));
        }
        let is_bad = |p: &[f32; 3]| p.iter().any(|x| !x.is_finite() || *x < 0.0);
        if let Some(k) = pixels.iter().position(is_bad) {
            let (row, column, light) = (k / width, k % width, pixels[k]);
            let what = format!("the pixel in row {row}, column {column} is {light:?}");
            return Err(bad(format!("{what}; light is finite and not negative: mend the map")));
        }
        let mut columns = Vec::with_capacity(count);
        let (mut rows, mut sum) = (Vec::with_capacity(height), 0.0);
        for (k, row) in pixels.chunks_exact(width).enumerate() {
            let mut in_row = 0.0;
            for pixel in row {
                in_row += luminance(&light(pixel));
                columns.push(in_row);
            }
            sum += in_row * pixel_angle(k, width, height);
            rows.push(sum);
        }
        if sum > 0.0 {
            Ok(Self { width, height, pixels, axes, rows, columns })
        } else {
            Err(bad("it is black everywhere; leave the sky out".to_owned()))
        }
    }

    /// Radiance from a direction, and the density with which it is drawn, per sr.
    pub(super) fn seen(&self, direction: &Vector3<f64>) -> (Vector3<f64>, f64) {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        let column = cell(0.5 - y.atan2(x) / TAU, self.width);
        let row = cell(z.clamp(-1.0, 1.0).acos() / PI, self.height);
        let light = light(&self.pixels[row * self.width + column]);
        (light, luminance(&light) / self.rows[self.height - 1])
    }

    pub(super) fn draw(&self, random: &mut PathRandom) -> Vector3<f64> {
        let row = chosen(&self.rows, random.number());
        let column = chosen(&self.columns[row * self.width..][..self.width], random.number());
        let [across, down] = random.pair();
        let azimuth = TAU * (0.5 - (column as f64 + across) / self.width as f64);
        let [top, bottom] = [row, row + 1].map(|k| polar(k, self.height).cos());
        let cosine = top + (bottom - top) * down;
        let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
        let [middle, left, up] = &self.axes;
        middle * (sine * azimuth.cos()) + left * (sine * azimuth.sin()) + up * cosine
    }
}

/// To the middle of a row, to the left of it, and upward.
fn axes(up: &Vector3<f64>, rotation: f64) -> Result<[Vector3<f64>; 3], RenderError> {
    check("the rotation of the sky (rad)", rotation, "finite", rotation.is_finite())?;
    let up = unit("the largest component of the up of the sky", up)?;
    let level = |axis: Vector3<f64>| (axis - up * up.dot(&axis)).try_normalize(1e-6);
    let ahead = level(Vector3::x()).or_else(|| level(Vector3::y())).unwrap_or_else(Vector3::y);
    let middle = Rotation3::from_axis_angle(&Unit::new_unchecked(up), rotation) * ahead;
    Ok([middle, up.cross(&middle), up])
}

fn light(pixel: &[f32; 3]) -> Vector3<f64> {
    Vector3::from(pixel.map(f64::from))
}

/// Angle between the zenith and the upper edge of a row, rad.
fn polar(row: usize, height: usize) -> f64 {
    row as f64 * PI / height as f64
}

/// Solid angle of a pixel of a row, sr.
fn pixel_angle(row: usize, width: usize, height: usize) -> f64 {
    let half = 0.5 * PI / height as f64;
    2.0 * half.sin() * (polar(row, height) + half).sin() * TAU / width as f64
}

/// The cell of a number in `[0, 1]`.
#[expect(clippy::cast_possible_truncation, reason = "a cast saturates, and the cell is clamped")]
fn cell(x: f64, cells: usize) -> usize {
    ((x * cells as f64) as usize).min(cells - 1)
}

/// The index whose part of a rising sum a number `u` in `[0, 1)` falls into; one that adds nothing
/// is never chosen.
fn chosen(sums: &[f64], u: f64) -> usize {
    let total = sums.last().map_or(0.0, |sum| *sum);
    sums.partition_point(|sum| *sum <= u * total).min(sums.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_adds_nothing_is_never_chosen() {
        let of = |u: f64| chosen(&[0.0, 1.0, 1.0, 4.0, 4.0], u);
        assert_eq!([0.0, 0.24, 0.25, 0.999].map(of), [1, 1, 3, 3]);
    }
}
