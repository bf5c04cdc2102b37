//! Points that are spread over the scalp at random and yet evenly.

use super::elimination::eliminate;
use super::scalp::ScalpMesh;
use super::surface_point::SurfacePoint;
use nalgebra::Point3;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Points at random from which one of those that stay is chosen.
const CANDIDATES: usize = 4;

/// `count` points of the surface in such an order that the first ones, however many, are spread
/// evenly: blue noise. They are chosen from four times as many, by removal of the most crowded;
/// then half of those left are removed, and so on, which gives the order from its end. Cost:
/// `n log n`; the same seed gives the same bits.
pub(super) fn progressive(mesh: &ScalpMesh, count: usize, seed: u64) -> Vec<SurfacePoint> {
    if count == 0 {
        return Vec::new();
    }
    let mut left = candidates(mesh, CANDIDATES * count, seed);
    let mut backward = Vec::with_capacity(count);
    let mut keep = count;
    loop {
        let places: Vec<Point3<f64>> = left.iter().map(|point| mesh.position(point)).collect();
        let removed = eliminate(&places, keep, mesh.area());
        let mut stays = vec![true; left.len()];
        for &point in &removed {
            stays[point as usize] = false;
        }
        if left.len() <= count {
            backward.extend(removed.iter().map(|&point| left[point as usize]));
        }
        let mut stays = stays.iter();
        left.retain(|_| stays.next() == Some(&true));
        if keep <= 1 {
            break;
        }
        keep = left.len() / 2;
    }
    backward.extend(left);
    backward.reverse();
    backward
}

/// Points at random, each in one of as many parts of equal area in the order of the faces.
fn candidates(mesh: &ScalpMesh, count: usize, seed: u64) -> Vec<SurfacePoint> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut unit = || (random.next_u64() >> 11) as f64 * (-53_f64).exp2();
    let part = mesh.area() / count as f64;
    let last = mesh.areas().len() - 1;
    let (mut face, mut before) = (0, 0.0);
    let point = |k: usize| {
        let target = (k as f64 + unit()) * part;
        while face < last && before + mesh.areas()[face] < target {
            before += mesh.areas()[face];
            face += 1;
        }
        // Folded over the diagonal where it falls into the other half of the parallelogram.
        let (u, v) = (unit(), unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        (face, [(1.0 - u - v).max(0.0), u, v])
    };
    let points = (0..count).map(point);
    let number = |(face, weights)| Some(SurfacePoint::new(u32::try_from(face).ok()?, weights));
    points.filter_map(number).collect()
}
