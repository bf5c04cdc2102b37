//! Conductors against exact images, capacities and limits.

use nalgebra::{Point3, Vector3};
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::{DistanceField, Mesh, Sample, shapes};
use rapunzel_electrostatics::{
    Accuracy, COULOMB_CONSTANT, ChargedFibers, Condition, ConductingSphere, ConductingSurface,
    Direct, ElectrostaticsError, Method, thesis_repulsion,
};
use rapunzel_fiber::Layout;

const EXACT: Accuracy = Accuracy::Tolerance(1e-6);

/// The force on a charge q at the distance r from a sphere with the total charge `total`.
fn exact_force(q: f64, total: f64, radius: f64, r: f64) -> f64 {
    let image = q * radius.powi(3) * (2.0 * r * r - radius * radius)
        / (r * (r * r - radius * radius).powi(2));
    COULOMB_CONSTANT * q / (r * r) * (total - image)
}

/// T10: the image formula, attraction of an uncharged sphere, no force at the golden ratio, and a
/// surface at the potential that was asked for.
#[test]
fn a_sphere_has_its_images() {
    let (radius, q) = (0.09, 2e-12);
    let center = Point3::new(0.1, 0.2, -0.3);
    let force = |r: f64, condition: Condition| {
        let sphere = ConductingSphere { center, radius, condition };
        let at = center + Vector3::new(0.0, 0.6, 0.8) * r;
        let (points, charges) = sphere.images(&[at], &[q]).expect("outside");
        let fields = Direct.fields(&points, &charges, &[at]).expect("valid");
        (q * fields.fields[0].dot(&Vector3::new(0.0, 0.6, 0.8)), points, charges, at)
    };
    for (r, total) in [(0.1, 0.0), (0.2, 3e-12), (0.0905, 5e-12), (1.0, -1e-12)] {
        let exact = exact_force(q, total, radius, r);
        let force = force(r, Condition::Charge(total)).0;
        assert!((force / exact - 1.0).abs() < 1e-10, "{force} N, not {exact}");
    }
    assert!(force(0.12, Condition::Charge(0.0)).0 < 0.0);
    let golden = radius * 0.5 * (1.0 + 5f64.sqrt());
    let scale = COULOMB_CONSTANT * q * q / golden.powi(2);
    assert!(force(golden, Condition::Charge(q)).0.abs() < 1e-12 * scale);
    let (_, mut points, mut charges, at) = force(0.13, Condition::Potential(70.0));
    points.push(at);
    charges.push(q);
    let surface = crate::common::sphere(20, 1).into_iter().map(|x| center + radius * x.coords);
    let surface: Vec<_> = surface.collect();
    for potential in Direct.fields(&points, &charges, &surface).expect("valid").potentials {
        assert!((potential - 70.0).abs() < 1e-9, "{potential} V");
    }
    let sphere = ConductingSphere { center, radius, condition: Condition::Charge(0.0) };
    let result = sphere.images(&[center], &[q]);
    assert!(matches!(result, Err(ElectrostaticsError::Inside { index: 0, .. })));
}

/// T11: a line over a conducting plane, here a very large sphere, is drawn by `lambda^2/h`.
#[test]
fn a_line_is_drawn_to_a_plane() {
    let (h, radius, step) = (0.01, 1e5, 0.5e-3);
    let center = Point3::new(0.0, 0.0, -radius);
    let sphere = ConductingSphere { center, radius, condition: Condition::Potential(0.0) };
    let line: Vec<_> =
        (-20_000..=20_000).map(|i| Point3::new(f64::from(i) * step, 0.0, h)).collect();
    let charges = vec![1e-11 * step; line.len()];
    let (points, images) = sphere.images(&line, &charges).expect("outside");
    let field = Direct.fields(&points, &images, &[line[20_000]]).expect("valid").fields[0].z;
    let exact = -COULOMB_CONSTANT * 1e-11 / h;
    assert!((field / exact - 1.0).abs() < 2e-5, "{}", field / exact - 1.0);
}

/// T10, T12: boundary elements converge to capacity and force of a sphere as the square of the
/// triangles' size, and give the capacity of a long ellipsoid.
#[test]
fn boundary_elements_converge() {
    let (radius, q, r) = (0.09, 2e-12, 0.2);
    let at = Point3::new(0.0, 0.0, r);
    let mut errors = Vec::new();
    for n in [4, 8] {
        let mesh = Mesh::new(shapes::sphere(radius, n)).expect("closed");
        let surface = ConductingSurface::new(&mesh).expect("small");
        let capacity = (surface.capacity() * COULOMB_CONSTANT / radius - 1.0).abs();
        let outer = Direct.fields(&[at], &[q], surface.centers()).expect("valid");
        let charges = surface.charges(&outer.potentials, Condition::Charge(3e-12)).expect("valid");
        assert!((charges.iter().sum::<f64>() - 3e-12).abs() < 1e-22);
        let field = Direct.fields(surface.centers(), &charges, &[at]).expect("valid").fields[0].z;
        let exact = exact_force(q, 3e-12, radius, r);
        errors.push([capacity, (q * field / exact - 1.0).abs()]);
    }
    for k in 0..2 {
        assert!(errors[1][k] < 0.35 * errors[0][k], "{errors:?}");
        assert!(errors[1][k] < 2e-2, "{errors:?}");
    }
    let mut soup = shapes::sphere(1.0, 8);
    let (length, thick) = (2.0, 0.1);
    soup.vertices.iter_mut().for_each(|x| {
        *x = Point3::new(x.x * thick, x.y * thick, x.z * 0.5 * length);
    });
    let mesh = Mesh::new(soup).expect("closed");
    let capacity = ConductingSurface::new(&mesh).expect("small").capacity() * COULOMB_CONSTANT;
    // A prolate ellipsoid exactly: c / atanh(c / (L/2)), c the distance of the focus.
    let focus = (0.25 * length * length - thick * thick).sqrt();
    let exact = focus / (focus / (0.5 * length)).atanh();
    assert!((capacity / exact - 1.0).abs() < 2e-2, "{capacity}, not {exact}");
}

/// T10 through the multipole method: capacity and force of a sphere, also on charges as close to it
/// as its triangles are large.
#[test]
fn boundary_elements_use_the_multipole_method() {
    check_sphere(16, 2048);
}

#[test]
#[ignore = "slow: 20 s, more triangles than one would factorize"]
fn boundary_elements_have_no_limit() {
    check_sphere(36, 10_000);
}

fn check_sphere(n: i32, least: usize) {
    let (radius, q) = (0.09, 2e-12);
    let mesh = Mesh::new(shapes::sphere(radius, n)).expect("closed");
    let surface = ConductingSurface::new(&mesh).expect("converges");
    let count = surface.centers().len();
    assert!(count >= least, "{count}");
    let capacity = surface.capacity() * COULOMB_CONSTANT / radius;
    let size = radius * (4.0 * std::f64::consts::PI / count as f64).sqrt();
    assert!((capacity - 1.0).abs() < (size / radius).powi(2), "{capacity}");
    let direction = Vector3::new(0.48, 0.6, 0.64);
    for gap in [20.0, 8.0, 2.0, 1.0] {
        let r = radius + gap * size;
        let at = [Point3::from(r * direction)];
        let outer = surface.potentials(&at, &[q], EXACT).expect("outside");
        let charges = surface.charges(&outer, Condition::Charge(3e-12)).expect("converges");
        let fields = surface.fields(&charges, &at, EXACT).expect("outside");
        let force = q * fields.fields[0].dot(&direction);
        let exact = exact_force(q, 3e-12, radius, r);
        // Of the triangles' size over the distance, and over the radius, by their second powers:
        // charge that is constant on a triangle. On the triangle itself a third of the pull may be
        // missing.
        let tolerance = 1.0 / (gap * gap + 2.0) + (size / radius).powi(2);
        // Repulsion and image may cancel each other.
        let scale = exact.abs().max(COULOMB_CONSTANT * q * 3e-12 / (r * r));
        assert!((force - exact).abs() < tolerance * scale, "{gap}: {force} N, not {exact}");
    }
}

/// T13: a conducting needle of length L and radius a that stands on a plane in the field E is drawn
/// by `E^2 L^2 (ln(L/a) - 1/2)/(4 (ln(2L/a) - 1)^2)` (Gaussian units; Felici): half of an ellipsoid
/// with its mirror image.
#[test]
fn a_needle_is_lifted() {
    let (length, thick, field) = (1.0, 0.1, 1e4);
    let mut soup = shapes::sphere(1.0, 12);
    soup.vertices.iter_mut().for_each(|x| *x = Point3::new(x.x * thick, x.y * thick, x.z * length));
    let mesh = Mesh::new(soup).expect("closed");
    let surface = ConductingSurface::new(&mesh).expect("converges");
    let outer: Vec<_> = surface.centers().iter().map(|x| -field * x.z).collect();
    let charges = surface.charges(&outer, Condition::Potential(0.0)).expect("converges");
    // The pull of the surface's own field, 2 pi k sigma^2 along the normal.
    let pull = |(triangle, charge): (&[u32; 3], &f64)| {
        let [a, b, c] = triangle.map(|vertex| mesh.vertices()[vertex as usize]);
        let double = (b - a).cross(&(c - a));
        let upper = a.z + b.z + c.z > 0.0;
        let density = 2.0 * charge / double.norm();
        let force = std::f64::consts::TAU * COULOMB_CONSTANT * density * density * 0.5 * double.z;
        if upper { force } else { 0.0 }
    };
    let force: f64 = mesh.triangles().iter().zip(&charges).map(pull).sum();
    let ratio = (length / thick).ln();
    let exact = field * field * length * length / COULOMB_CONSTANT * (ratio - 0.5)
        / (4.0 * (ratio + 2f64.ln() - 1.0).powi(2));
    // The formula is of first order in (a/L)^2 ln(L/a).
    assert!((force / exact - 1.0).abs() < 0.1, "{}", force / exact);
}

/// The field is the gradient of the potential, and the charges of triangles are in the potential
/// energy that they feel: also next to them.
#[test]
fn triangles_feel_what_they_do() {
    let mesh = Mesh::new(shapes::sphere(0.09, 4)).expect("closed");
    let surface = ConductingSurface::new(&mesh).expect("converges");
    let charges: Vec<_> = (0..surface.centers().len()).map(|i| 1e-12 * (i as f64).sin()).collect();
    for at in
        [Point3::new(0.0, 0.03, 0.092), Point3::new(0.05, 0.08, 0.01), Point3::new(0.3, 0.0, 0.1)]
    {
        let fields = surface.fields(&charges, &[at], EXACT).expect("outside");
        let felt = surface.potentials(&[at], &[1.0], EXACT).expect("outside");
        let energy: f64 = felt.iter().zip(&charges).map(|(v, q)| v * q).sum();
        assert!((fields.potentials[0] - energy).abs() < 1e-12 * energy.abs(), "{energy}");
        let step = 1e-7;
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let potential = |t: f64| {
                surface.fields(&charges, &[at + t * axis], EXACT).expect("outside").potentials[0]
            };
            let slope = (potential(step) - potential(-step)) / (2.0 * step);
            let error = (slope + fields.fields[0].dot(&axis)).abs();
            assert!(error < 1e-6 * fields.fields[0].norm(), "{slope} at {at}");
        }
    }
}

/// Charges for which direct sums are taken.
const FEW: usize = 1000;

/// The charges of fibres beside a conductor are those of Gauss's points on their segments, in
/// direct sums of all pairs, and energy and forces belong together.
#[test]
fn fibers_feel_the_conductor_beside_them() {
    let mesh = Mesh::new(shapes::sphere(0.09, 8)).expect("closed");
    let surface = ConductingSurface::new(&mesh).expect("converges");
    // So many that expansions are used.
    let fibers = 220;
    let roots = crate::common::sphere(fibers, 5);
    let layout = Layout::new(vec![20; fibers]);
    let node = |k: usize| Point3::from((0.0905 + 1e-3 * (k % 21) as f64) * roots[k / 21].coords);
    let nodes: Vec<_> = (0..21 * fibers).map(node).collect();
    let charges: Vec<_> = (0..20 * fibers).map(|k| 1e-13 * (1.0 + (k as f64).sin())).collect();
    let radii = vec![40e-6; fibers];
    let forces = |tolerance: f64, nodes: &[Point3<f64>], condition: Condition| {
        let accuracy = Accuracy::Tolerance(tolerance);
        let fibers = ChargedFibers { layout: &layout, charges: &charges, radii: &radii, accuracy };
        let alone = fibers.forces(nodes).expect("valid");
        let beside = fibers.forces_beside(nodes, &surface, condition).expect("outside");
        let forces = beside.forces.iter().zip(alone.forces).map(|(f, g)| f - g);
        (beside.energy - alone.energy, forces.collect::<Vec<_>>(), beside.certificate)
    };
    // Gauss's two points err by (half length/distance)^4/135: 5e-4 for the root of each fibre, 1 mm
    // above the edges of triangles, and a tenth of it for all.
    let points = |k: usize| {
        let [a, b] = layout.segment_nodes(k).map(|node| nodes[node]);
        [0.211_324_865_405_187, 0.788_675_134_594_813].map(|t| a + t * (b - a))
    };
    let places: Vec<_> = (0..charges.len()).flat_map(points).collect();
    let halves: Vec<_> = charges.iter().flat_map(|q| [0.5 * q; 2]).collect();
    // Of so few charges at a time direct sums are taken.
    let mut potentials = vec![0.0; surface.centers().len()];
    for (places, halves) in places.chunks(FEW).zip(halves.chunks(FEW)) {
        let found = surface.potentials(places, halves, EXACT).expect("outside");
        potentials.iter_mut().zip(found).for_each(|(sum, v)| *sum += v);
    }
    for condition in [Condition::Charge(2e-11), Condition::Potential(-300.0)] {
        let induced = surface.charges(&potentials, condition).expect("converges");
        let fields = |places| surface.fields(&induced, places, EXACT).expect("outside").fields;
        let fields: Vec<_> = places.chunks(FEW).flat_map(fields).collect();
        let mut exact = vec![Vector3::zeros(); nodes.len()];
        for (k, field) in fields.iter().enumerate() {
            let [a, b] = layout.segment_nodes(k / 2);
            let part = [0.211_324_865_405_187, 0.788_675_134_594_813][k % 2];
            exact[a] += (1.0 - part) * halves[k] * field;
            exact[b] += part * halves[k] * field;
        }
        for tolerance in [1e-3, 1e-6] {
            let (_, found, certificate) = forces(tolerance, &nodes, condition);
            let error = crate::common::relative(&found, &exact);
            assert!(error < tolerance + 1e-4, "{tolerance}: {error:e}, {certificate:?}");
        }
        // All fibres are moved outward: the energy falls by what the forces do.
        let step = 1e-6;
        let moved = |sign: f64| -> Vec<_> {
            nodes.iter().map(|x| x + sign * step * x.coords.normalize()).collect()
        };
        let energy = |sign: f64| forces(1e-6, &moved(sign), condition).0;
        let work: f64 = exact.iter().zip(&nodes).map(|(f, x)| f.dot(&x.coords.normalize())).sum();
        let slope = (energy(-1.0) - energy(1.0)) / (2.0 * step);
        assert!((slope / work - 1.0).abs() < 1e-3, "{slope} N, not {work} N");
    }
    let inside: Vec<_> = nodes.iter().map(|x| 0.8 * x).collect();
    let accuracy = EXACT;
    let fibers = ChargedFibers { layout: &layout, charges: &charges, radii: &radii, accuracy };
    let result = fibers.forces_beside(&inside, &surface, Condition::Charge(0.0));
    assert!(matches!(result, Err(ElectrostaticsError::Inside { .. })), "{result:?}");
}

/// Points inside are refused, with a depth that they have at least; roots on the surface are not.
#[test]
fn points_inside_are_refused() {
    let mesh = Mesh::new(shapes::sphere(0.09, 8)).expect("closed");
    let surface = ConductingSurface::new(&mesh).expect("converges");
    let points = [Point3::new(0.0, 0.0, 0.0901), Point3::new(0.0, 0.05, 0.0)];
    let charges = vec![0.0; surface.centers().len()];
    for result in [
        surface.check_outside(&points),
        surface.potentials(&points, &[0.0; 2], EXACT).map(|_| ()),
        surface.fields(&charges, &points, EXACT).map(|_| ()),
    ] {
        let Err(ElectrostaticsError::Inside { index: 1, depth }) = result else {
            panic!("the second point is inside: {result:?}");
        };
        assert!(depth > 5e-3 && depth < 0.041, "{depth} m");
    }
    assert!(surface.check_outside(&[mesh.vertices()[3]]).is_ok(), "a root");
}

struct Ball;

impl DistanceField for Ball {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        Sample { value: point.coords.norm() - 0.09, gradient: point.coords.normalize() }
    }
}

/// (4.13) repels outside, is too strong by the square of r/d, and refuses points inside.
#[test]
fn the_theses_head_repels_too_much() {
    let at = [Point3::new(0.0, 0.091, 0.0)];
    let force = thesis_repulsion(&Ball, 2e-12, &at, &[1e-12]).expect("outside")[0];
    let coulomb = COULOMB_CONSTANT * 2e-24 / (0.091 * 0.091);
    assert!((force.y / coulomb / 8281.0 - 1.0).abs() < 1e-9 && force.x == 0.0);
    let inside = thesis_repulsion(&Ball, 2e-12, &[Point3::new(0.0, 0.05, 0.0)], &[1e-12]);
    assert!(matches!(inside, Err(ElectrostaticsError::Inside { .. })));
}

/// A head that is open or inside out is refused before there is a conductor.
#[test]
fn bad_heads_are_refused() {
    let mut open = shapes::sphere(0.09, 4);
    open.triangles.pop();
    assert!(matches!(Mesh::new(open), Err(CollisionError::Edge { .. })));
    let mut inverted = shapes::sphere(0.09, 4);
    inverted.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    assert!(matches!(Mesh::new(inverted), Err(CollisionError::InsideOut)));
    let mesh = Mesh::new(shapes::sphere(0.09, 4)).expect("closed");
    let surface = ConductingSurface::new(&mesh).expect("small");
    let mut potentials = vec![0.0; surface.centers().len()];
    let result = surface.charges(&potentials[1..], Condition::Potential(1.0));
    assert!(matches!(result, Err(ElectrostaticsError::Count { .. })));
    potentials[3] = f64::NAN;
    assert!(surface.charges(&potentials, Condition::Potential(1.0)).is_err());
}
