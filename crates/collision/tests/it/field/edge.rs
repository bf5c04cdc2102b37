//! A fiber laid across an edge of a box is found from any position.

use crate::geometry::random::Random;
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::field::{ContactSearch, Cuboid, DistanceField, Grid, Mesh, Posed, shapes};

const HALF: [f64; 3] = [4e-3, 5e-3, 6e-3];
const SEARCH: ContactSearch = ContactSearch { margin: 5e-6, spacing: 0.3e-3, tolerance: 1e-6 };
const RADIUS: f64 = 35e-6;

/// A segment of 3 mm that leans on an edge of the box, within a few radii, at a random angle.
fn across(random: &mut Random) -> Capsule {
    let half = Vector3::from(HALF);
    let axis = if random.once_in(3) { 0 } else { 1 + usize::from(random.once_in(2)) };
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut point = Vector3::zeros();
    point[axis] = random.range(-0.9, 0.9) * half[axis];
    (point[u], point[v]) = (half[u], half[v]);
    // Perpendicular to an outward direction between those of the two faces.
    let tilt = random.range(0.0, std::f64::consts::FRAC_PI_2);
    let (mut outward, mut along) = (Vector3::zeros(), Vector3::zeros());
    (outward[u], outward[v]) = tilt.sin_cos();
    along[axis] = 1.0;
    let direction = (random.range(-1.0, 1.0) * along + outward.cross(&along)).normalize();
    let meeting = point + random.range(-2.0, 3.0) * RADIUS * outward;
    let start = meeting - random.range(0.1e-3, 2.9e-3) * direction;
    Capsule { start: start.into(), end: (start + 3e-3 * direction).into(), radius: RADIUS }
}

/// The gap of a convex surface: along the axis it is convex.
fn gap(field: &impl DistanceField, capsule: &Capsule) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let (s, t) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if field.value(&capsule.at(s)) <= field.value(&capsule.at(t)) { high = t } else { low = s }
    }
    field.value(&capsule.at(low)) - capsule.radius
}

/// Of `count` fibers none must be missed by a field that is off by at most `error` from a box. Its
/// own surface is what must be met: it is asked at many points of the fiber.
fn lay(field: &impl DistanceField, count: usize, error: f64, seed: u64) {
    let mut random = Random::new(seed);
    let exact = Cuboid { half: HALF.into() };
    let densely = |capsule: &Capsule| {
        let value = |k: u32| field.value(&capsule.at(f64::from(k) / 128.0));
        (0..=128).map(value).fold(f64::INFINITY, f64::min) - RADIUS
    };
    let mut contacts = Vec::new();
    let (mut touches, mut alarms) = (0, 0);
    for _ in 0..count {
        let capsule = across(&mut random);
        let gap = gap(&exact, &capsule);
        contacts.clear();
        SEARCH.contacts(field, &capsule, &mut contacts);
        if gap <= SEARCH.margin - error || densely(&capsule) <= SEARCH.margin {
            touches += 1;
            assert!(!contacts.is_empty(), "missed at a gap of {gap:e}: {capsule:?}");
        }
        let deepest = contacts.iter().map(|c| c.gap).fold(f64::INFINITY, f64::min);
        if !contacts.is_empty() {
            alarms += usize::from(gap > SEARCH.margin);
            let tolerance = SEARCH.tolerance + error;
            assert!((deepest - gap).abs() <= tolerance, "{deepest:e} for {gap:e}: {capsule:?}");
            assert!(gap <= SEARCH.margin + tolerance);
        }
    }
    assert!(touches > count / 4 && touches < count, "{touches} of {count} touch");
    println!("{count} fibers, {touches} touch, {alarms} false alarms");
}

/// The scanned box: near its edges the interpolant is off by up to the bound for any surface.
fn scanned() -> Grid {
    let mesh = Mesh::new(shapes::cuboid(HALF.into())).expect("a mesh");
    Grid::scan(&mesh, 100e-6, 0.5e-3).expect("a grid")
}

#[test]
fn no_fiber_across_an_edge_is_missed() {
    lay(&Cuboid { half: HALF.into() }, 20_000, 0.0, 1);
    let grid = scanned();
    lay(&grid, 20_000, grid.error(), 2);
}

#[test]
#[ignore = "slow: 20 s, a million fibers across an edge, exact and scanned"]
fn of_a_million_fibers_across_an_edge_none_is_missed() {
    lay(&Cuboid { half: HALF.into() }, 1_000_000, 0.0, 3);
    let grid = scanned();
    lay(&grid, 1_000_000, grid.error(), 4);
}

/// The same in another frame.
#[test]
fn a_moved_box_is_met_where_it_is() {
    let pose = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.3, 0.2, 0.1));
    let field = Posed { pose, field: Cuboid { half: HALF.into() } };
    let mut random = Random::new(5);
    for _ in 0..1000 {
        let capsule = across(&mut random);
        let move_to = |p: Point3<f64>| pose * p;
        let moved = Capsule { start: move_to(capsule.start), end: move_to(capsule.end), ..capsule };
        let (mut here, mut there) = (Vec::new(), Vec::new());
        SEARCH.contacts(&field.field, &capsule, &mut here);
        SEARCH.contacts(&field, &moved, &mut there);
        let gap = gap(&field.field, &capsule);
        if (gap - SEARCH.margin).abs() > 2.0 * SEARCH.tolerance {
            assert_eq!(here.is_empty(), there.is_empty());
        }
        for contact in there {
            assert!((contact.normal.norm() - 1.0).abs() <= 1e-12);
        }
    }
}
