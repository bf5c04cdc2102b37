//! A few fibres and objects in motion, for the tests of the formats.

use super::surface::Placed;
use super::{Frame, Strand};
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_collision::field::shapes;
use rapunzel_fiber::so3;

/// Frame `index` of three strands with 5, 8 and 11 segments whose numbers fill all bits.
pub(super) fn frame(index: usize) -> Frame {
    let time = index as f64 / 30.0;
    let strands = [5, 8, 11].map(|segments| strand(segments, time)).to_vec();
    Frame { index, time, strands }
}

fn strand(segments: usize, time: f64) -> Strand {
    let at = |i: usize| 0.3 * i as f64 / segments as f64;
    let wave = |s: f64| (7.0 * s + 3.0 * time).sin();
    let points = 0..=segments;
    Strand {
        points: points
            .clone()
            .map(|i| Point3::new(0.05 * wave(at(i)), 0.01 * time, at(i)))
            .collect(),
        radii: points.clone().map(|i| 40e-6 - 1e-5 * at(i)).collect(),
        velocities: points.clone().map(|i| Vector3::new(wave(at(i) + 1.0), 0.01, 0.0)).collect(),
        frames: (0..segments).map(|i| so3::exp(&Vector3::new(0.1, at(i), time))).collect(),
        curvatures: points.clone().map(|i| Vector3::new(wave(at(i)), 1.0 / 3.0, -2.0)).collect(),
        contact_forces: points.clone().map(|i| 1e-6 * Vector3::new(at(i), 0.1, time)).collect(),
        charges: points.map(|i| 1e-12 * wave(at(i))).collect(),
        forces: (0..segments).map(|i| 1e-5 * Vector3::new(0.1, at(i), 1.0)).collect(),
    }
}

/// A box at rest and a ball that moves and rotates, at a time, s.
pub(super) fn objects(time: f64) -> Vec<Placed> {
    let shapes = [shapes::cuboid(Vector3::new(0.1, 1.0 / 3.0, 2.0)), shapes::sphere(0.7, 2)];
    let still = Isometry3::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(1.0, 2.0, 0.5));
    let moved = Isometry3::new(Vector3::new(time, 0.0, 1.0 / 3.0), 3.0 * time * Vector3::z());
    let place = |(mut surface, pose): (rapunzel_collision::field::Soup, Isometry3<f64>)| {
        surface.vertices.iter_mut().for_each(|p| *p = pose * *p);
        Placed { pose, surface }
    };
    shapes.into_iter().zip([still, moved]).map(place).collect()
}
