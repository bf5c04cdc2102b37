use super::VoxelFrame;
use nalgebra::{Matrix3, Point3, Vector3};

/// A box around a segment of a wisp: its center, its axes and half of its sides, in the axes of the
/// voxels and units of their sides.
struct SegmentBox {
    center: Vector3<f64>,
    axes: Matrix3<f64>,
    half: Vector3<f64>,
}

impl SegmentBox {
    /// Whether it and the voxel with this center have a point in common: no axis parts them
    /// (Gottschalk, Lin and Manocha 1996), neither of three faces each nor across two edges.
    fn meets(&self, voxel: &Vector3<f64>) -> bool {
        let off = self.center - voxel;
        let parts = |axis: &Vector3<f64>| {
            let own: f64 = (0..3).map(|k| self.half[k] * self.axes.column(k).dot(axis).abs()).sum();
            off.dot(axis).abs() > own + 0.5 * axis.abs().sum()
        };
        let unit = Matrix3::identity();
        let faces = (0..3).flat_map(|k| [self.axes.column(k).into_owned(), unit.column(k).into()]);
        let edges = (0..9).map(|n| {
            let edge: Vector3<f64> = unit.column(n / 3).into_owned();
            edge.cross(&self.axes.column(n % 3))
        });
        !faces.chain(edges).any(|axis| parts(&axis))
    }
}

impl VoxelFrame {
    /// Calls `visit` with the number of each voxel that meets the oriented box around the truncated
    /// cone between two points (world) with the larger of its `radius`es, m (thesis 5.3.4).
    pub(super) fn cover(
        &self,
        [start, end]: [&Point3<f64>; 2],
        radius: f64,
        mut visit: impl FnMut(usize),
    ) {
        let (from, to) = (self.scaled(start), self.scaled(end));
        let Some(along) = (to - from).try_normalize(0.0) else { return };
        // Any two axes across will do.
        let mut least = Vector3::zeros();
        least[along.iamin()] = 1.0;
        let first = along.cross(&least).normalize();
        let across = radius / self.spacing;
        let shape = SegmentBox {
            center: (from + to) * 0.5,
            axes: Matrix3::from_columns(&[first, along.cross(&first), along]),
            half: Vector3::new(across, across, 0.5 * (to - from).norm()),
        };
        // The voxels within its bounds.
        let reach = shape.axes.abs() * shape.half;
        let (low, high) =
            (self.index(&(shape.center - reach)), self.index(&(shape.center + reach)));
        for k in low[2]..=high[2] {
            for j in low[1]..=high[1] {
                for i in low[0]..=high[0] {
                    let center = Vector3::new(i as f64, j as f64, k as f64).add_scalar(0.5);
                    if let Some(voxel) = self.voxel([i, j, k]).filter(|_| shape.meets(&center)) {
                        visit(voxel);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Every voxel that holds a point of the box is covered, and every covered voxel is within
        /// its half diagonal of the box.
        #[test]
        fn a_box_covers_the_voxels_it_meets(
            start in prop::array::uniform3(0.2..0.8_f64),
            end in prop::array::uniform3(0.2..0.8_f64),
            radius in 0.001..0.15_f64,
            inside in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let frame = VoxelFrame::new(Point3::origin(), Point3::new(1.0, 1.0, 1.0), 0.1);
            let frame = frame.expect("voxels");
            let (start, end) = (Point3::from(start), Point3::from(end));
            let mut covered = Vec::new();
            frame.cover([&start, &end], radius, |voxel| covered.push(voxel));
            // A point within the cylinder is in the box.
            let along = end - start;
            let any = Vector3::from(inside);
            let across = any.cross(&along).normalize() * (radius * inside[0].abs());
            let point = start + along * (0.5 + 0.5 * inside[1]) + across;
            let voxel = frame.voxel(frame.index(&frame.scaled(&point)));
            prop_assert!(voxel.is_none_or(|voxel| covered.contains(&voxel)));
            for voxel in covered {
                let off = frame.center(voxel) - start;
                let part = (off.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                let distance = (off - along * part).norm();
                prop_assert!(distance <= 2.0_f64.sqrt() * radius + 0.1 * 0.75_f64.sqrt() + 1e-9);
            }
        }
    }
}
