//! Heads and hulls that are balls, and pores on them.

use nalgebra::{Point2, Point3, Unit, Vector3};
use rapunzel_collision::field::Ball;
use rapunzel_hairgen::{GuideOptions, Pore, PreGuide, Region, dips_by_height, grow_pre_guides};

pub(crate) const HEAD: Ball = Ball { center: Point3::new(0.0, 0.0, 0.0), radius: 0.09 };
pub(crate) const HULL: Ball = Ball { center: Point3::new(0.0, 0.0, 0.0), radius: 0.115 };
pub(crate) const BALLS: Region<'_> = Region { head: &HEAD, hull: &HULL };

/// About evenly spread pores on the upper part of the head, from the top down (Fibonacci's
/// spiral), whose hair leaves the top at `tilt` (rad) from the normal.
pub(crate) fn pores(count: usize, tilt: f64, length: f64) -> Vec<Pore> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let pore = |i: usize| {
        // Down to a polar angle of 100 degrees.
        let height = 1.0 - 1.17 * (i as f64 + 0.5) / count as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let across = (1.0 - height * height).sqrt();
        let normal = Vector3::new(across * cos, height, across * sin);
        let south = Vector3::new(height * cos, -across, height * sin);
        let direction = normal * tilt.cos() + south * tilt.sin();
        let polar = height.acos() / std::f64::consts::FRAC_PI_2;
        Pore {
            position: Point3::from(normal * HEAD.radius),
            normal: Unit::new_normalize(normal),
            direction: Unit::new_normalize(direction),
            length,
            disc: Point2::new(polar * cos, polar * sin) * 0.9,
        }
    };
    (0..count).map(pore).collect()
}

/// The same pores, whose hair all turns to one side.
pub(crate) fn sideways(count: usize, tilt: f64, length: f64) -> Vec<Pore> {
    let mut pores = pores(count, tilt, length);
    for pore in &mut pores {
        let normal = pore.normal.into_inner();
        let side = Vector3::x() - normal * normal.x;
        let direction = normal * tilt.cos() + side.normalize() * tilt.sin();
        pore.direction = Unit::new_normalize(direction);
    }
    pores
}

/// Pre-guides at about one in a square centimeter.
pub(crate) fn pre_guides(tilt: f64, length: f64, options: &GuideOptions) -> Vec<PreGuide> {
    let pores = pores(300, tilt, length);
    let heights: Vec<f64> = pores.iter().map(|pore| pore.position.y).collect();
    let dips = dips_by_height(&heights, 0.1, 0.6);
    grow_pre_guides(&pores, &dips, BALLS, options).expect("pre-guides")
}
