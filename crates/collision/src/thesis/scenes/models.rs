//! Models like those of the thesis's performance tests (figure 7.7), in any size. Their shapes are
//! ours, because the thesis shows only pictures; so are radii that it does not give. Nothing moves.

use super::MovingFibers;
use crate::random::SplitMix64;
use nalgebra::{Point3, Rotation3, Unit, Vector2, Vector3};
use rapunzel_fiber::Layout;
use std::f64::consts::{PI, TAU};

const LENGTH: f64 = 0.3;
const HAIR: f64 = 35e-6;

/// A straight bundle of slightly wavy hair of 30 cm and 70 um: Tress I (100 fibers of 2000
/// segments) and Tress II (500 of 2000).
///
/// Roots stand on a square lattice of 325 per cm², the thesis's density; toward the tip the bundle
/// is a third as wide. Each fiber waves by up to 0.6 mm, once in 3 to 6 cm.
#[must_use]
pub fn bundle(fibers: usize, segments: usize) -> MovingFibers {
    let mut random = SplitMix64(0x7_2E55);
    let curves = lattice(fibers).map(|root| {
        let (phase, amplitude) = (TAU * random.unit(), 0.6e-3 * random.unit());
        let wavelength = 0.03 + 0.03 * random.unit();
        let (sin, cos) = (TAU * random.unit()).sin_cos();
        move |t: f64| {
            let wave = amplitude * (TAU * t * LENGTH / wavelength + phase).sin();
            let p = (root + wave * Vector2::new(cos, sin)) * (1.0 - t * 2.0 / 3.0);
            Point3::new(p.x, p.y, t * LENGTH)
        }
    });
    sampled(curves, segments, HAIR)
}

/// A curl: the roots of [`bundle`], gathered to half of their width within the first third, on
/// ten turns of a helix with a radius of 1 cm; Locke has 2500 fibers of 100 segments.
#[must_use]
pub fn lock(fibers: usize, segments: usize) -> MovingFibers {
    let mut random = SplitMix64(0x10CE);
    let curves = lattice(fibers).map(|root| {
        let lag = 0.02 * random.signed();
        let stray = 0.2e-3 * random.in_ball();
        move |t: f64| {
            let onset = (3.0 * t).min(1.0);
            let (sin, cos) = (TAU * 10.0 * (t + lag * t)).sin_cos();
            let p = root * (1.0 - 0.5 * onset) + 0.01 * onset * Vector2::new(cos, sin);
            Point3::new(p.x, p.y, 0.5 * t * LENGTH) + t * stray
        }
    });
    sampled(curves, segments, HAIR)
}

/// A plain weave of warp and weft, half of the fibers each, 2 mm apart and 1 mm thick, that touch
/// at every crossing; Tuch has 500 fibers of 2600 segments.
#[must_use]
pub fn cloth(fibers: usize, segments: usize) -> MovingFibers {
    let (pitch, radius) = (2e-3, 0.5e-3);
    let warp = fibers.div_ceil(2);
    let curves = (0..fibers).map(|f| {
        let (own, others) = if f < warp { (f, fibers - warp) } else { (f - warp, warp) };
        // At its crossing with fiber j, a warp fiber is above where own + j is even, and weft
        // below.
        let side = if (f < warp) == own.is_multiple_of(2) { 1.0 } else { -1.0 };
        let place = own as f64 * pitch;
        move |t: f64| {
            let along = (others as f64 * t - 0.5) * pitch;
            let z = 0.95 * radius * side * (PI * along / pitch).cos();
            if f < warp { Point3::new(place, along, z) } else { Point3::new(along, place, z) }
        }
    });
    sampled(curves, segments, radius)
}

/// Circles of 1 mm thick fibers of all sizes and in all planes through the middle of a ball with a
/// radius of 1 cm; Haarball has 700 fibers of 37 segments.
#[must_use]
pub fn ball(fibers: usize, segments: usize) -> MovingFibers {
    let mut random = SplitMix64(0xBA11);
    let curves = (0..fibers).map(|_| {
        let axis = Unit::new_unchecked(random.direction());
        let start = axis.cross(&random.direction()) * 0.01;
        move |t: f64| Point3::from(Rotation3::from_axis_angle(&axis, 0.95 * TAU * t) * start)
    });
    sampled(curves, segments, 0.5e-3)
}

/// Filament soup: arcs of 30 cm and 2 mm, anywhere in the unit cube, with any direction and a
/// curvature up to 10 per m; the thesis's has 10 000 fibers of 100 segments.
#[must_use]
pub fn soup(fibers: usize, segments: usize) -> MovingFibers {
    let mut random = SplitMix64(0x50_0B);
    let curves = (0..fibers).map(|_| {
        let start = Point3::from(Vector3::from_fn(|_, _| random.unit()));
        let tangent = random.direction();
        let bend = tangent.cross(&random.direction()).normalize();
        let curvature = 10.0 * random.unit();
        // What leaves the cube comes back in as if its faces were mirrors.
        let mirrored = |x: f64| (x - 2.0 * (0.5 * x).round()).abs();
        move |t: f64| {
            let p = start + arc(t * LENGTH, curvature, &tangent, &bend);
            p.map(mirrored)
        }
    });
    sampled(curves, segments, 1e-3)
}

/// Places on a square lattice of 325 per cm² around the origin, row by row and back, m.
fn lattice(count: usize) -> impl Iterator<Item = Vector2<f64>> {
    let pitch = (1e-4_f64 / 325.0).sqrt();
    let side = (1..).find(|s| s * s >= count).unwrap_or(1);
    (0..count).map(move |f| {
        let (row, place) = (f / side, f % side);
        let column = if row.is_multiple_of(2) { place } else { side - 1 - place };
        let center = 0.5 * (side as f64 - 1.0);
        Vector2::new(column as f64 - center, row as f64 - center) * pitch
    })
}

/// Fibers along curves over 0..=1, all of one radius, m.
fn sampled<C: Fn(f64) -> Point3<f64>>(
    curves: impl Iterator<Item = C>,
    segments: usize,
    radius: f64,
) -> MovingFibers {
    let at = |curve: C| {
        (0..=segments).map(move |k| curve(k as f64 / segments as f64)).collect::<Vec<_>>()
    };
    let fibers: Vec<_> = curves.map(at).collect();
    let layout = Layout::new(fibers.iter().map(|_| segments));
    let radii = vec![radius; layout.segments()];
    let displacements = vec![Vector3::zeros(); layout.nodes()];
    MovingFibers { positions: fibers.into_iter().flatten().collect(), layout, displacements, radii }
}

/// The way to the point at arc length `s`, m, on an arc that starts along `tangent` and bends
/// toward `side` with `curvature`, 1/m, which may be zero.
pub(super) fn arc(
    s: f64,
    curvature: f64,
    tangent: &Vector3<f64>,
    side: &Vector3<f64>,
) -> Vector3<f64> {
    let half = 0.5 * curvature * s;
    let chord = if half.abs() < 1e-9 { s } else { s * half.sin() / half };
    chord * (half.cos() * tangent + half.sin() * side)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(fibers: usize, segments: usize) -> [MovingFibers; 5] {
        [bundle, lock, cloth, ball, soup].map(|model| model(fibers, segments))
    }

    #[test]
    fn models_are_valid_and_repeat() {
        for (a, b) in all(7, 30).into_iter().zip(all(7, 30)) {
            assert_eq!(a, b);
            assert_eq!(a.capsules().expect("valid").len(), 210);
        }
    }

    /// Warp and weft touch, at least at their crossings, and lie over and under in turn.
    #[test]
    fn cloth_is_woven() {
        let scene = cloth(8, 64);
        let capsules = scene.capsules().expect("valid");
        for warp in 0..4 {
            for weft in 4..8 {
                let segments = |f: usize| scene.layout.segment_range(f);
                let mut closest = segments(warp)
                    .flat_map(|i| segments(weft).map(move |j| (i, j)))
                    .map(|(i, j)| capsules.get(i).closest(&capsules.get(j)));
                let first = closest.next().expect("segments");
                let least =
                    closest.fold(first, |a, b| if b.distance() < a.distance() { b } else { a });
                assert!((0.85e-3..=1e-3).contains(&least.distance()), "{}", least.distance());
                let above = (warp + weft) % 2 == 0;
                assert_eq!(least.offset.z < 0.0, above, "{warp} {weft}");
            }
        }
    }

    #[test]
    fn soup_stays_in_its_cube() {
        let scene = soup(300, 20);
        assert!(scene.positions.iter().all(|p| p.iter().all(|x| (0.0..=1.0).contains(x))));
    }

    #[test]
    fn places_are_as_dense_as_hair() {
        let places: Vec<_> = lattice(100).collect();
        let pitch = (places[1] - places[0]).norm();
        assert!((1e-4 / pitch.powi(2) - 325.0).abs() < 1e-9);
        // The next row starts where the last ends.
        assert!(((places[10] - places[9]).norm() - pitch).abs() < 1e-15);
    }
}
