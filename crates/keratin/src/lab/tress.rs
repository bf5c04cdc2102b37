//! The radial volume of a tress: the volume that its hairs occupy.

use nalgebra::{Point3, Vector2};

/// The volume of a tress that hangs along z, m^3: each of `slices` slices between the top and the
/// bottom counts as a disc with the second moment of the nodes in it, `2 pi <|r - <r>|^2> dz`.
///
/// The result for an evenly filled cylinder or cone is its volume. Slices with fewer than two
/// nodes count as empty. The thesis speaks of the body of hair (2.3.4) and gives no formula: this
/// one is ours.
#[must_use]
pub fn radial_volume(fibers: &[Vec<Point3<f64>>], slices: usize) -> f64 {
    let nodes = || fibers.iter().flatten();
    let [low, high] =
        nodes().fold([f64::MAX, f64::MIN], |[low, high], p| [low.min(p.z), high.max(p.z)]);
    let height = (high - low) / slices as f64;
    if height.is_nan() || height <= 0.0 {
        return 0.0;
    }
    let mut sums = vec![(0.0, Vector2::zeros(), 0.0); slices];
    for p in nodes() {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to slices")]
        let slice = (((p.z - low) / height) as usize).min(slices - 1);
        let (count, sum, squares) = &mut sums[slice];
        *count += 1.0;
        *sum += p.coords.xy();
        *squares += p.coords.xy().norm_squared();
    }
    let area = |(count, sum, squares): &(f64, Vector2<f64>, f64)| {
        if *count < 2.0 {
            return 0.0;
        }
        let spread = squares / count - (sum / *count).norm_squared();
        2.0 * std::f64::consts::PI * spread.max(0.0)
    };
    sums.iter().map(area).sum::<f64>() * height
}
