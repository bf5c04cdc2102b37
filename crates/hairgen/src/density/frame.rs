use crate::HairgenError;
use nalgebra::{Point3, Vector3};

/// Most voxels of a frame: 1 GiB of densities.
const MOST_VOXELS: f64 = 134_217_728.0;

/// A box in cubic voxels, at rest in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoxelFrame {
    pub(super) low: Point3<f64>,
    pub(super) spacing: f64,
    pub(super) counts: [usize; 3],
}

impl VoxelFrame {
    /// Voxels with sides of `spacing`, m, that begin at `low` and reach at least to `high` (world),
    /// m.
    ///
    /// # Errors
    /// Numbers that are not finite, a spacing that is not positive, an empty box, and one of more
    /// than 2^27 voxels.
    pub fn new(low: Point3<f64>, high: Point3<f64>, spacing: f64) -> Result<Self, HairgenError> {
        let refuse = |problem| Err(HairgenError::Voxels { problem });
        let size = high - low;
        if !(spacing > 0.0 && spacing.is_finite()) {
            return refuse("the spacing must be positive and finite");
        }
        if !(size.min() > 0.0 && size.iter().chain(&low.coords).all(|x| x.is_finite())) {
            return refuse("the box must be finite, and its high corner above its low one");
        }
        let counts = (size / spacing).map(f64::ceil);
        if counts.product() > MOST_VOXELS {
            return refuse("there are more than 2^27; take a larger spacing");
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "just checked")]
        let counts = [0, 1, 2].map(|k| counts[k] as usize);
        Ok(Self { low, spacing, counts })
    }

    /// Length of the side of a voxel, m.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Number of voxels.
    #[must_use]
    pub fn voxel_count(&self) -> usize {
        self.counts.iter().product()
    }

    /// Center of the voxel with this number (world), m.
    #[must_use]
    pub fn center(&self, voxel: usize) -> Point3<f64> {
        let [nx, ny, _] = self.counts;
        let index = [voxel % nx, voxel / nx % ny, voxel / (nx * ny)];
        self.low + Vector3::from(index.map(|i| (i as f64 + 0.5) * self.spacing))
    }

    /// A point in the axes of the voxels, in units of their sides.
    pub(super) fn scaled(&self, point: &Point3<f64>) -> Vector3<f64> {
        (point - self.low) / self.spacing
    }

    /// The number of the voxel at these indices; `None` outside of the box.
    pub(super) fn voxel(&self, index: [i64; 3]) -> Option<usize> {
        let mut voxel = 0;
        for k in [2, 1, 0] {
            let i = usize::try_from(index[k]).ok().filter(|i| *i < self.counts[k])?;
            voxel = voxel * self.counts[k] + i;
        }
        Some(voxel)
    }

    /// The indices of the voxel that holds a scaled point, moved into or next to the box.
    pub(super) fn index(&self, scaled: &Vector3<f64>) -> [i64; 3] {
        #[expect(clippy::cast_possible_truncation, reason = "between -2 and 2^27")]
        let floor = |k: usize| scaled[k].floor().clamp(-2.0, self.counts[k] as f64 + 1.0) as i64;
        [0, 1, 2].map(floor)
    }

    /// Value and derivatives by a point (world) of what `at` gives at the centers of the voxels,
    /// interpolated trilinearly. `at` is also asked for voxels outside of the box.
    pub(super) fn interpolate<T>(
        &self,
        point: &Point3<f64>,
        at: impl Fn([i64; 3]) -> T,
    ) -> (T, [T; 3])
    where
        T: Copy + std::ops::Add<Output = T> + std::ops::Sub<Output = T>,
        T: std::ops::Mul<f64, Output = T>,
    {
        let centered = self.scaled(point).add_scalar(-0.5);
        let [i, j, k] = self.index(&centered);
        let base = Vector3::new(i as f64, j as f64, k as f64);
        let part = (centered - base).map(|x| x.clamp(0.0, 1.0));
        let corner = |n: i64| at([i + (n & 1), j + (n >> 1 & 1), k + (n >> 2)]);
        let mix = |low: T, high: T, part: f64| low * (1.0 - part) + high * part;
        let corners: [T; 8] = [0, 1, 2, 3, 4, 5, 6, 7].map(corner);
        let [c0, c1, c2, c3, c4, c5, c6, c7] = corners;
        // Along x, then y, then z.
        let lines = [(c0, c1), (c2, c3), (c4, c5), (c6, c7)].map(|(a, b)| mix(a, b, part.x));
        let slopes = [(c0, c1), (c2, c3), (c4, c5), (c6, c7)].map(|(a, b)| b - a);
        let faces = [mix(lines[0], lines[1], part.y), mix(lines[2], lines[3], part.y)];
        let by_x =
            mix(mix(slopes[0], slopes[1], part.y), mix(slopes[2], slopes[3], part.y), part.z);
        let by_y = mix(lines[1] - lines[0], lines[3] - lines[2], part.z);
        let by_z = faces[1] - faces[0];
        let inverse = self.spacing.recip();
        (mix(faces[0], faces[1], part.z), [by_x * inverse, by_y * inverse, by_z * inverse])
    }
}
