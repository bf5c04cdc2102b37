//! Waving fibres rooted on a square lattice: the scenes that peers were measured on.

use super::MovingFibers;
use crate::random::SplitMix64;
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Layout;
use std::f64::consts::TAU;

const SEGMENTS: usize = 100;
const LENGTH: f64 = 0.3;
const RADIUS: f64 = 35e-6;

/// `fibers` wavy fibres of 100 segments of 3 mm, 200 per cm² everywhere.
///
/// Fibre `f` stands in column `f % side` and row `f / side` of a square lattice, `side` the least
/// that holds all, with a jitter of a quarter of the pitch. It waves in one plane with an amplitude
/// of 0.5 to 1.5 mm and a wavelength of 24 to 36 mm. All random numbers are from `SplitMix64` with
/// one seed.
#[must_use]
pub fn wavy(fibers: usize) -> MovingFibers {
    lattice(fibers, |_| 1.0)
}

/// The fibres of [`wavy`], gathered toward the tip to 3200 per cm², a volume fraction of 12 %.
#[must_use]
pub fn clump(fibers: usize) -> MovingFibers {
    lattice(fibers, |t| 1.0 - 0.75 * t)
}

/// `gather` is the distance from the axis over that at the root, for `t` in 0..=1 along the fibre.
fn lattice(fibers: usize, gather: impl Fn(f64) -> f64) -> MovingFibers {
    let mut random = SplitMix64(0x005E_ED0F_4A1B);
    let side = (fibers as f64).sqrt().ceil();
    let pitch = (1e-4_f64 / 200.0).sqrt();
    let (mut positions, mut displacements) = (Vec::new(), Vec::new());
    for f in 0..fibers {
        let (row, column) = ((f as f64 / side).floor(), f as f64 % side);
        let mut root =
            |place: f64| (place - 0.5 * (side - 1.0)) * pitch + (random.unit() - 0.5) * 0.5 * pitch;
        let (x, y) = (root(column), root(row));
        let phase = TAU * random.unit();
        let amplitude = 1e-3 * (0.5 + random.unit());
        let wavelength = 30e-3 * (0.8 + 0.4 * random.unit());
        let (sin, cos) = (TAU * random.unit()).sin_cos();
        let speed = Vector3::from_fn(|_, _| random.unit() - 0.5);
        for k in 0..=SEGMENTS {
            let z = k as f64 * (LENGTH / SEGMENTS as f64);
            let t = z / LENGTH;
            let wave = amplitude * (TAU * z / wavelength + phase).sin();
            let c = gather(t);
            positions.push(Point3::new(c * (x + wave * cos), c * (y + wave * sin), z));
            displacements.push(t * t * 100e-6 * Vector3::x() + t * 20e-6 * speed);
        }
    }
    let layout = Layout::new(std::iter::repeat_n(SEGMENTS, fibers));
    MovingFibers { layout, positions, displacements, radii: vec![RADIUS; fibers * SEGMENTS] }
}
