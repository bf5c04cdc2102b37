//! Moving segments against surfaces.

use super::{REACH, random_segment};
use crate::geometry::random::Random;
use nalgebra::{Point3, Unit, Vector3};
use rapunzel_collision::continuous::MovingSegment;
use rapunzel_collision::field::{
    Ball, Cuboid, DistanceField, Grid, GridFrame, HalfSpace, Mesh, shapes,
};

/// A six-hundredth of the longest segment: finer is given up where one comes to lie flat.
const TOLERANCE: f64 = 5e-6;

/// Against a plane it is an end that touches first, at a time in closed form.
#[test]
fn a_plane_is_met_by_an_end() {
    let mut random = Random::new(11);
    let mut touches = 0;
    for _ in 0..20_000 {
        let normal = Unit::new_unchecked(random.unit_vector());
        let point = Point3::from(1.5e-3 * normal.into_inner());
        let plane = HalfSpace { point, normal: -normal };
        let segment = random_segment(&mut random);
        let ends = [0, 1].map(|k| [segment.before[k], segment.after[k]].map(|p| plane.value(&p)));
        let time = |[before, after]: [f64; 2]| match (before <= REACH, after <= REACH) {
            (true, _) => 0.0,
            (_, true) => (before - REACH) / (before - after),
            _ => f64::INFINITY,
        };
        let exact = time(ends[0]).min(time(ends[1]));
        let impact = segment.impact_on(&plane, REACH, TOLERANCE);
        if exact <= 1.0 {
            touches += 1;
            assert!(impact.expect("a touch was missed").time <= exact + 1e-12);
        }
        if let Some(impact) = impact {
            let axis = segment.at(impact.time, REACH);
            assert!(
                !impact.resolved
                    || plane.value(&axis.at(impact.coordinates[0])) <= REACH + TOLERANCE
            );
            let least = ends.as_flattened().iter().copied().fold(f64::INFINITY, f64::min);
            assert!(!impact.resolved || least <= REACH + TOLERANCE);
        }
    }
    assert!(touches > 2000);
}

/// Against a ball it is as against a point, at a distance more by the radius.
#[test]
fn a_ball_is_met_as_a_thick_point() {
    let mut random = Random::new(12);
    let (mut touches, mut given_up) = (0, 0);
    for _ in 0..20_000 {
        let ball = Ball { center: random.point(1e-3), radius: random.range(0.05e-3, 0.5e-3) };
        let segment = random_segment(&mut random);
        let still = MovingSegment { before: [ball.center; 2], after: [ball.center; 2] };
        let exact = segment.impact(&still, REACH + ball.radius, 1e-12);
        let impact = segment.impact_on(&ball, REACH, TOLERANCE);
        if let Some(exact) = exact {
            touches += 1;
            let impact = impact.expect("a touch was missed");
            assert!(impact.time <= exact.time + 1e-9);
            if impact.resolved {
                assert!(impact.offset.norm() <= REACH + TOLERANCE + 1e-15 || impact.time == 0.0);
            }
        } else if let Some(impact) = impact {
            given_up += usize::from(!impact.resolved);
            let near = segment.impact(&still, REACH + ball.radius + 1.001 * TOLERANCE, 1e-12);
            assert!(!impact.resolved || near.is_some());
        }
    }
    assert!(touches > 2000 && given_up * 100 < touches, "{touches}, {given_up}");
}

/// A hair at 10 m/s against a plate of 0.3 mm, thinner than it moves in a step of 1 ms.
#[test]
fn nothing_tunnels_through_a_thin_plate() {
    let half = Vector3::new(8e-3, 8e-3, 0.15e-3);
    let mesh = Mesh::new(shapes::cuboid(half)).expect("a mesh");
    let corner = Vector3::new(9e-3, 9e-3, 1e-3);
    let frame = GridFrame::new((-corner).into(), corner.into(), 0.1e-3).expect("a lattice");
    let grid = Grid::scan_in(&mesh, frame, 0.5e-3).expect("a grid");
    let mut random = Random::new(13);
    for _ in 0..500 {
        let [x, y] = [0, 1].map(|_| random.range(-5e-3, 5e-3));
        let start = Point3::new(x, y, random.range(2.2e-3, 7e-3));
        let before = [start, start + 3e-3 * random.unit_vector().xy().push(0.0)];
        let way = Vector3::new(random.range(-1e-3, 1e-3), random.range(-1e-3, 1e-3), -10e-3);
        let segment = MovingSegment { before, after: before.map(|p| p + way) };
        for impact in [
            segment.impact_on(&Cuboid { half }, REACH, TOLERANCE),
            segment.impact_on(&grid, REACH, TOLERANCE),
        ] {
            let impact = impact.expect("tunneled");
            let height = segment.at(impact.time, REACH).start.z;
            assert!(impact.resolved && height >= half.z);
            assert!(height <= half.z + REACH + TOLERANCE + 1e-9, "{height} {impact:?}");
        }
    }
}
