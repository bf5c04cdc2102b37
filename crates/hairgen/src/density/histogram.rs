use super::VoxelFrame;
use crate::Region;
use nalgebra::Point3;
use rayon::prelude::*;

/// How evenly hair fills the region (thesis Fig. 5.6).
#[derive(Debug, Clone, PartialEq)]
pub struct DensityHistogram {
    /// Number of admissible voxels that so many segments cross, from none on. A voxel is admissible
    /// if its center is.
    pub voxels: Vec<usize>,
}

impl DensityHistogram {
    /// The histogram of the segments of `curves` (world), m, in the voxels of `frame` whose centers
    /// lie between head and hull.
    #[must_use]
    pub fn of<'c>(
        curves: impl Iterator<Item = &'c [Point3<f64>]>,
        region: Region<'_>,
        frame: VoxelFrame,
    ) -> Self {
        let mut segments = vec![0_usize; frame.voxel_count()];
        for ends in curves.flat_map(|curve| curve.windows(2)) {
            frame.walk(&ends[0], &ends[1], |voxel, _| segments[voxel] += 1);
        }
        let admissible: Vec<bool> = (0..segments.len())
            .into_par_iter()
            .map(|voxel| region.depths(&frame.center(voxel)).iter().all(|depth| *depth < 0.0))
            .collect();
        let mut voxels = Vec::new();
        for (count, _) in segments.iter().zip(admissible).filter(|(_, admissible)| *admissible) {
            if voxels.len() <= *count {
                voxels.resize(count + 1, 0);
            }
            voxels[*count] += 1;
        }
        Self { voxels }
    }

    /// Gini's coefficient of the segments of the voxels: 0 if all have as many, toward 1 if few
    /// have all; 0 without any.
    #[must_use]
    pub fn gini(&self) -> f64 {
        let all: f64 = self.voxels.iter().map(|voxels| *voxels as f64).sum();
        // Twice the area under the curve of Lorenz, in units of all voxels and all segments.
        let (mut sum, mut area) = (0.0, 0.0);
        for (count, voxels) in self.voxels.iter().enumerate() {
            let (voxels, before) = (*voxels as f64, sum);
            sum += voxels * count as f64;
            area += voxels * (before + sum);
        }
        if sum > 0.0 { 1.0 - area / (all * sum) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gini_is_that_of_known_distributions() {
        let gini = |voxels: &[usize]| DensityHistogram { voxels: voxels.to_vec() }.gini();
        assert_eq!(gini(&[]), 0.0);
        assert_eq!(gini(&[5]), 0.0);
        // All have three; one of four has all; one, two, three: 2 / 9.
        assert!(gini(&[0, 0, 0, 7]).abs() < 1e-15);
        assert!((gini(&[3, 1]) - 0.75).abs() < 1e-15);
        assert!((gini(&[0, 1, 1, 1]) - 2.0 / 9.0).abs() < 1e-15);
    }
}
