use super::VoxelFrame;
use nalgebra::Point3;

impl VoxelFrame {
    /// Calls `visit` with the number of each voxel that the straight way between two points (world)
    /// crosses, in order, and with the length of the way in it, m (Amanatides and Woo 1987). The
    /// way outside of the box is left out.
    pub(super) fn walk(
        &self,
        start: &Point3<f64>,
        end: &Point3<f64>,
        mut visit: impl FnMut(usize, f64),
    ) {
        let (from, to) = (self.scaled(start), self.scaled(end));
        let (way, length) = (to - from, (end - start).norm());
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        // The part of the way within the box, grown by one voxel.
        let (mut at, mut last) = (0.0_f64, 1.0_f64);
        for k in 0..3 {
            let [low, high] = [-1.0, self.counts[k] as f64 + 1.0];
            if way[k] == 0.0 {
                if from[k] < low || from[k] > high {
                    return;
                }
            } else {
                let [a, b] = [low, high].map(|wall| (wall - from[k]) / way[k]);
                at = at.max(a.min(b));
                last = last.min(a.max(b));
            }
        }
        let mut index = self.index(&(from + way * at));
        // The fraction of the way at the next wall along each axis.
        let next = |index: &[i64; 3], k: usize| {
            let wall = index[k] + i64::from(way[k] > 0.0);
            if way[k] == 0.0 { f64::INFINITY } else { (wall as f64 - from[k]) / way[k] }
        };
        while at < last {
            let walls = [0, 1, 2].map(|k| next(&index, k));
            let axis = usize::from(walls[1] < walls[0]);
            let axis = if walls[2] < walls[axis] { 2 } else { axis };
            let leave = walls[axis].clamp(at, last);
            if leave > at
                && let Some(voxel) = self.voxel(index)
            {
                visit(voxel, (leave - at) * length);
            }
            at = walls[axis].max(at);
            index[axis] += if way[axis] > 0.0 { 1 } else { -1 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The lengths in the voxels sum up to the way, and each voxel holds its part's middle.
        #[test]
        fn a_walk_leaves_nothing_out(
            start in prop::array::uniform3(prop_oneof![Just(0.5), 0.0..1.0_f64]),
            end in prop::array::uniform3(prop_oneof![Just(0.5), 0.0..1.0_f64]),
        ) {
            let low = Point3::new(-0.1, -0.1, -0.1);
            let frame = VoxelFrame::new(low, Point3::new(1.1, 1.1, 1.1), 0.125).expect("voxels");
            let (start, end) = (Point3::from(start), Point3::from(end));
            let whole = (end - start).norm();
            let mut sum = 0.0;
            let mut off = 0.0_f64;
            frame.walk(&start, &end, |voxel, length| {
                let middle = start + (end - start) * ((sum + 0.5 * length) / whole);
                off = off.max((middle - frame.center(voxel)).amax());
                sum += length;
            });
            prop_assert!((sum - whole).abs() < 1e-12, "{sum} {whole}");
            prop_assert!(off < 0.5 * 0.125 + 1e-9, "{off}");
        }
    }

    /// From far outside through the box.
    #[test]
    fn only_the_box_is_walked() {
        let frame = VoxelFrame::new(Point3::origin(), Point3::new(1.0, 1.0, 1.0), 0.1);
        let frame = frame.expect("voxels");
        let mut sum = 0.0;
        let [a, b] = [Point3::new(-50.0, 0.55, 0.55), Point3::new(80.0, 0.55, 0.55)];
        frame.walk(&a, &b, |_, length| sum += length);
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        let mut missed = true;
        frame.walk(&a, &Point3::new(-2.0, 0.5, 0.5), |_, _| missed = false);
        frame.walk(&a, &a, |_, _| missed = false);
        assert!(missed);
    }
}
