//! Fibres that bend from straight to a loop.

use super::models::arc;
use super::{MovingFibers, bundle};
use crate::random::SplitMix64;
use nalgebra::{Point3, Vector3};

/// A bundle of straight parallel fibers of 30 cm, bent by `bend` in 0..=1 of a full circle: the
/// thesis's dynamic test (7.4.2) in 100 steps of it.
///
/// Every fiber is an arc of constant curvature, where the thesis solves the static rod under
/// recorded end loads. Curvatures differ by up to 5 %, and the planes in which fibers bend by up to
/// `spread`, radians: 0.05 is a bundle that stays one, pi a bundle that bursts.
#[must_use]
pub fn looping(fibers: usize, segments: usize, bend: f64, spread: f64) -> MovingFibers {
    let mut scene = bundle(fibers, segments);
    let mut random = SplitMix64(0x100B);
    for fiber in 0..fibers {
        let nodes = &mut scene.positions[scene.layout.node_range(fiber)];
        let root = nodes[0];
        let (sin, cos) = (spread * random.signed()).sin_cos();
        let side = Vector3::new(cos, sin, 0.0);
        let curvature = bend * (1.0 + 0.05 * random.signed()) * std::f64::consts::TAU / LENGTH;
        for (k, node) in nodes.iter_mut().enumerate() {
            let s = LENGTH * k as f64 / segments as f64;
            *node = Point3::new(root.x, root.y, 0.0) + arc(s, curvature, &Vector3::z(), &side);
        }
    }
    scene
}

const LENGTH: f64 = 0.3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fibers_bend_from_straight_to_a_circle_and_keep_their_length() {
        for (bend, spread) in [(0.0, 0.05), (0.5, 0.05), (1.0, 0.05), (1.0, 3.0)] {
            let scene = looping(9, 100, bend, spread);
            for fiber in 0..9 {
                let nodes = &scene.positions[scene.layout.node_range(fiber)];
                let length: f64 = nodes.windows(2).map(|p| (p[1] - p[0]).norm()).sum();
                // A chord is shorter than its arc by the square of the angle over 24.
                let angle = bend * 1.05 * std::f64::consts::TAU / 100.0;
                assert!(
                    length <= 0.3 + 1e-12 && length >= 0.3 * (1.0 - angle * angle / 24.0) - 1e-12
                );
                let reach = (nodes[100] - nodes[0]).norm();
                let expected = if bend == 0.0 {
                    0.3..0.301
                } else if bend < 1.0 {
                    0.18..0.2
                } else {
                    0.0..0.02
                };
                assert!(expected.contains(&(reach + 1e-12)), "{bend}: {reach}");
            }
        }
    }
}
