//! A few fibres in motion, for the tests of the formats.

use super::{Frame, Strand};
use nalgebra::{Point3, Vector3};
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
        curvatures: points.map(|i| Vector3::new(wave(at(i)), 1.0 / 3.0, -2.0)).collect(),
        forces: (0..segments).map(|i| 1e-5 * Vector3::new(0.1, at(i), 1.0)).collect(),
    }
}
