//! Where spatial trees divide (thesis, 7.3.3).

use crate::Capsules;
use crate::thesis::volume::Axis;
use nalgebra::{Point3, Vector3};

/// Divides at least two segments into two parts, the first part in front, and returns its size,
/// which is neither none nor all.
///
/// At the middle of the longest axis by the middles of the segments; where all are on one side, at
/// the middle of the second or third axis; where that fails, at the mean of the middles, along each
/// axis in turn; and where all middles coincide along them, by halves.
pub(super) fn divide(segments: &mut [u32], axes: &[Axis; 3], capsules: &Capsules) -> usize {
    let middle = |segment: u32| {
        let capsule = capsules.get(segment as usize);
        Point3::from(0.5 * capsule.start.coords + 0.5 * capsule.end.coords)
    };
    for axis in axes {
        let left = partition(segments, |s| axis.direction.dot(&middle(s).coords) < axis.middle);
        if (1..segments.len()).contains(&left) {
            return left;
        }
    }
    let share = 1.0 / segments.len() as f64;
    let mean: Vector3<f64> = segments.iter().map(|&s| middle(s).coords * share).sum();
    for axis in axes {
        let left = partition(segments, |s| axis.direction.dot(&(middle(s).coords - mean)) < 0.0);
        if (1..segments.len()).contains(&left) {
            return left;
        }
    }
    segments.len() / 2
}

/// Moves those that `belong` to the front and counts them.
fn partition(segments: &mut [u32], belong: impl Fn(u32) -> bool) -> usize {
    let mut front = 0;
    for i in 0..segments.len() {
        if belong(segments[i]) {
            segments.swap(i, front);
            front += 1;
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis::volume::{Aabb, BoundingVolume};
    use rapunzel_fiber::Layout;

    /// Divides fibers of one segment each.
    fn divided(segments: &[[[f64; 3]; 2]], radii: &[f64]) -> (Vec<u32>, usize) {
        let layout = Layout::new(segments.iter().map(|_| 1));
        let positions: Vec<_> = segments.iter().flatten().map(|&p| Point3::from(p)).collect();
        let capsules = Capsules::new(&layout, &positions, radii).expect("valid");
        let mut order: Vec<u32> = (0..).take(capsules.len()).collect();
        let all = || (0..capsules.len()).map(|s| capsules.get(s));
        let axes = Aabb::wrap(&(), all()).axes(&(), all());
        let left = divide(&mut order, &axes, &capsules);
        (order, left)
    }

    #[test]
    fn the_longest_axis_is_first() {
        let at = |z: f64| [[0.0, 0.0, z], [1.0, 0.0, z]];
        assert_eq!(divided(&[at(9.0), at(0.0), at(10.0)], &[0.1; 3]), (vec![1, 0, 2], 1));
    }

    /// Parallel segments side by side: the longest axis is along them, and cannot divide.
    #[test]
    fn the_next_axis_is_second() {
        let at = |y: f64| [[0.0, y, 0.0], [9.0, y, 0.0]];
        assert_eq!(divided(&[at(1.0), at(0.0)], &[0.1; 2]), (vec![1, 0], 1));
    }

    /// One segment spans the box, and the middles of all others are on one side of its own.
    #[test]
    fn the_mean_is_third() {
        let point = |x: f64| [[x, 0.0, 0.0]; 2];
        let long = [[-9.0, 0.0, 0.0], [9.0, 0.0, 0.0]];
        assert_eq!(divided(&[point(0.5), point(0.25), long], &[0.1; 3]), (vec![2, 1, 0], 1));
    }

    #[test]
    fn coinciding_segments_are_halved() {
        assert_eq!(divided(&[[[1.0; 3]; 2]; 5], &[0.1; 5]).1, 2);
    }
}
