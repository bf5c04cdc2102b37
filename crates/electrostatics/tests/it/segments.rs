//! Charged fibres against exact forces.

use crate::common::{hair, relative};
use nalgebra::{Point3, Vector3};
use rapunzel_electrostatics::{
    Accuracy, COULOMB_CONSTANT, ChargedFibers, Direct, Electrostatics, ElectrostaticsError, Method,
    units,
};
use rapunzel_fiber::Layout;

/// Charges of a constant line density.
fn charges(layout: &Layout, nodes: &[Point3<f64>], density: f64) -> Vec<f64> {
    let charge = |segment: usize| {
        let [a, b] = layout.segment_nodes(segment);
        density * (nodes[b] - nodes[a]).norm()
    };
    (0..layout.segments()).map(charge).collect()
}

fn solve(
    fibers: &[Vec<Point3<f64>>],
    density: f64,
    radius: f64,
    tolerance: f64,
) -> Result<Electrostatics, ElectrostaticsError> {
    let layout = Layout::new(fibers.iter().map(|fiber| fiber.len() - 1));
    let nodes = fibers.concat();
    let charges = charges(&layout, &nodes, density);
    let radii = vec![radius; fibers.len()];
    let accuracy = Accuracy::Tolerance(tolerance);
    let fibers = ChargedFibers { layout: &layout, charges: &charges, radii: &radii, accuracy };
    fibers.forces(&nodes)
}

fn straight(x: f64, length: f64, segments: u32) -> Vec<Point3<f64>> {
    (0..=segments)
        .map(|i| Point3::new(x, 0.0, length * f64::from(i) / f64::from(segments)))
        .collect()
}

/// T1, T2: the force between two parallel lines. T3: along them, as nodal loads. T14: the
/// deflection that it gives two clamped fibres, in the limit of long fibres.
#[test]
fn parallel_lines_repel_by_the_closed_form() {
    let (density, d, length) = (2.6e-11, 0.01, 0.1);
    let factor = COULOMB_CONSTANT * density * density;
    for segments in [1, 7, 200] {
        let pair = [straight(0.0, length, segments), straight(d, length, segments)];
        let result = solve(&pair, density, 40e-6, 1e-9).expect("valid");
        let forces = &result.forces[segments as usize + 1..];
        let total: Vector3<f64> = forces.iter().sum();
        let exact = 2.0 * factor / d * (length.hypot(d) - d);
        assert!((total.x / exact - 1.0).abs() < 1e-9, "{segments}: {}", total.x / exact - 1.0);
        if segments < 200 {
            continue;
        }
        let profile = |s: f64| factor / d * (s / s.hypot(d) + (length - s) / (length - s).hypot(d));
        let h = length / f64::from(segments);
        // A nodal load is a mean over two segments; at the ends the profile bends within d.
        for i in 15..=185 {
            let s = h * i as f64;
            let force = forces[i].x / h;
            assert!((force / profile(s) - 1.0).abs() < 1e-4, "{i}: {force}, not {}", profile(s));
        }
        // Tip deflection times EI by the unit-load theorem: sum of f s^2 (3L - s)/6.
        let moment = |s: f64| s * s * (3.0 * length - s) / 6.0;
        let loads: f64 = forces.iter().enumerate().map(|(i, f)| f.x * moment(h * i as f64)).sum();
        let steps = 100_000;
        let at = |k: i32| length * (f64::from(k) + 0.5) / f64::from(steps);
        let integral: f64 = (0..steps).map(|k| profile(at(k)) * moment(at(k))).sum();
        let exact = integral * length / f64::from(steps);
        assert!((loads / exact - 1.0).abs() < 1e-4, "{}", loads / exact);
    }
    // L = 10 cm, d = 1 cm, the thesis's charge, EI = 8.04 dyn cm^2: 1.843e-4 cm for L >> d.
    let density = units::THESIS_LINE_DENSITY;
    let deflection = COULOMB_CONSTANT * density * density * 0.1f64.powi(4) / (4.0 * d * 8.04e-9);
    assert!((deflection / 1.843e-6 - 1.0).abs() < 1e-3, "{deflection} m");
}

/// T1, T3 for parallel fibres as dense as hair, whose segments are all parallel to their neighbors.
/// A nodal load is the mean over two segments of the field of lines, the second difference of its
/// second integral.
#[test]
fn dense_parallel_fibers_repel_by_the_closed_form() {
    let (density, length, segments, tolerance) = (2.6e-11, 0.06, 30, 1e-8);
    let places: Vec<_> =
        (0..36).map(|k| 0.7e-3 * Vector3::new((k % 6) as f64, (k / 6) as f64, 0.0)).collect();
    let line = straight(0.0, length, segments);
    let fibers: Vec<Vec<_>> =
        places.iter().map(|place| line.iter().map(|x| x + place).collect()).collect();
    let result = solve(&fibers, density, 40e-6, tolerance).expect("valid");
    assert!(result.certificate.order.is_some(), "there is a far field");
    let step = length / f64::from(segments);
    let load = |r: Vector3<f64>, i: usize| -> Vector3<f64> {
        let d = r.norm();
        let part = |s: f64| 0.5 * (s * s.hypot(d) + d * d * (s / d).asinh());
        let integral = |s: f64| part(s) + part(length - s);
        let s = step * i as f64;
        let second = integral(s - step) - 2.0 * integral(s) + integral(s + step);
        COULOMB_CONSTANT * density * density * second / (step * d * d) * r
    };
    let (mut found, mut exact) = (Vec::new(), Vec::new());
    for (k, place) in places.iter().enumerate() {
        for i in 1..segments as usize {
            let force = result.forces[k * line.len() + i];
            found.push(Vector3::new(force.x, force.y, 0.0));
            let others = places.iter().enumerate().filter(|(j, _)| *j != k);
            exact.push(others.map(|(_, other)| load(place - other, i)).sum());
        }
    }
    let error = relative(&found, &exact);
    assert!(error < tolerance, "{error:e}, {:?}", result.certificate);
}

/// T6: a charged torus widens by `lambda^2/R (ln(8R/a) - 1)` a length.
#[test]
fn a_torus_repels_itself() {
    let (radius, a, density) = (0.05, 50e-6, 1e-11);
    let n = 240;
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let ring: Vec<_> = (0..=n)
        .map(|i| Point3::new(radius * angle(i).cos(), radius * angle(i).sin(), 0.0))
        .collect();
    let result = solve(&[ring], density, a, 1e-7).expect("valid");
    let h = radius * std::f64::consts::TAU / f64::from(n);
    let exact = COULOMB_CONSTANT * density * density / radius * ((8.0 * radius / a).ln() - 1.0);
    for i in [31, 100, 163] {
        // The tension of the self-energies is a part of it.
        let x = Vector3::new(angle(i).cos(), angle(i).sin(), 0.0);
        let force = result.forces[i as usize].dot(&x) / h;
        assert!((force / exact - 1.0).abs() < 2e-3, "{force}, not {exact}");
    }
}

/// T18, T19: no net force or moment, and forces are the negative gradient of the energy, also where
/// fibres cross closely and with a coarse rule.
#[test]
fn forces_are_a_gradient_without_net_force_or_moment() {
    let fibers = hair(12, 21, 3);
    let layout = Layout::new(fibers.iter().map(|fiber| fiber.len() - 1));
    let nodes = fibers.concat();
    let charges = charges(&layout, &nodes, 2.6e-11);
    let radii = vec![40e-6; fibers.len()];
    let accuracy = Accuracy::Tolerance(1e-11);
    let fibers = ChargedFibers { layout: &layout, charges: &charges, radii: &radii, accuracy };
    let result = fibers.forces(&nodes).expect("valid");
    assert!(result.certificate.order.is_some(), "there is a far field");
    let scale: f64 = result.forces.iter().map(Vector3::norm).sum();
    let total: Vector3<f64> = result.forces.iter().sum();
    assert!(total.norm() < 1e-10 * scale, "{total}");
    let moments = nodes.iter().zip(&result.forces).map(|(x, f)| x.coords.cross(f));
    let moment: Vector3<f64> = moments.sum();
    assert!(moment.norm() < 1e-10 * scale * 0.3, "{moment}");
    for node in [0, 7, 20, 100, 251] {
        for direction in [Vector3::x(), Vector3::new(0.3, -0.5, 0.8)] {
            let step = 2e-6;
            let energy = |step: f64| {
                let mut moved = nodes.clone();
                moved[node] += step * direction;
                fibers.forces(&moved).expect("valid").energy
            };
            // Fourth order.
            let [a, b] = [energy(step) - energy(-step), energy(2.0 * step) - energy(-2.0 * step)];
            let slope = (8.0 * a - b) / (12.0 * step);
            let force = result.forces[node];
            let error = (slope + force.dot(&direction)).abs();
            assert!(error < 1e-6 * force.norm(), "{node}: {slope}, not {}", force.dot(&direction));
        }
    }
    let v: Vec<_> = (0..nodes.len()).map(|i| Vector3::new((i as f64).sin(), 0.2, 0.0)).collect();
    let w: Vec<_> = (0..nodes.len()).map(|i| Vector3::new(0.1, (i as f64).cos(), 0.3)).collect();
    let [hv, hw] = [&v, &w].map(|v| fibers.hessian_product(&nodes, v).expect("valid"));
    let dot = |a: &[Vector3<f64>], b: &[Vector3<f64>]| -> f64 {
        a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
    };
    let [vw, wv] = [dot(&hv, &w), dot(&hw, &v)];
    let size = (dot(&hv, &hv) * dot(&w, &w)).sqrt();
    assert!((vw - wv).abs() < 1e-5 * size, "the Hessian is symmetric: {vw}, {wv}");
}

/// T16: two charged rigid strings that hang from hinges side by side lean by the angle at which the
/// moment of their repulsion is that of their weight. The moments of the nodal forces are those of
/// a double integral, and for distant hinges the angle is that of parallel strings, T1.
#[test]
fn hanging_strings_lean_by_their_repulsion() {
    let (length, weight, density) = (0.1, 6.5e-5, 1e-9);
    let string = |hinge: f64, lean: f64, count: u32| -> Vec<Point3<f64>> {
        let place = |i: u32| {
            let s = length * f64::from(i) / f64::from(count);
            Point3::new(hinge + s * lean.sin(), 0.0, -s * lean.cos())
        };
        (0..=count).map(place).collect()
    };
    let moment = |d: f64, lean: f64| -> f64 {
        let pair = [string(0.0, -lean, 40), string(d, lean, 40)];
        let nodes = &pair[1];
        let forces = solve(&pair, density, 40e-6, 1e-8).expect("valid").forces;
        let arms = nodes.iter().map(|x| x - nodes[0]);
        // The forces of a string on itself have no moment.
        arms.zip(&forces[41..]).map(|(arm, f)| arm.z * f.x - arm.x * f.z).sum()
    };
    let integral = |d: f64, lean: f64| -> f64 {
        let n = 400;
        let s = |i: u32| length * (f64::from(i) + 0.5) / f64::from(n);
        let (sine, cosine) = lean.sin_cos();
        let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (s(i), s(j))));
        let term = |(u, v): (f64, f64)| {
            let r = Vector3::new(d + (u + v) * sine, 0.0, (v - u) * cosine);
            let f = r / r.norm().powi(3);
            -u * cosine * f.x - u * sine * f.z
        };
        let step = length / f64::from(n);
        COULOMB_CONSTANT * density * density * step * step * pairs.map(term).sum::<f64>()
    };
    for (d, lean) in [(0.02, 0.05), (0.05, 0.3), (0.01, 0.8)] {
        let (found, exact) = (moment(d, lean), integral(d, lean));
        assert!((found / exact - 1.0).abs() < 1e-4, "{found} N m, not {exact}");
    }
    // Equilibrium: -moment = w L^2/2 sin(lean).
    let d = 0.05;
    let [mut low, mut high] = [0.0, 1.0];
    for _ in 0..30 {
        let lean = 0.5 * (low + high);
        let rises = -moment(d, lean) > 0.5 * weight * length * length * lean.sin();
        if rises { low = lean } else { high = lean }
    }
    // Parallel strings at the distance of their middles: tan(lean) = f/w.
    let distance = d + length * low.sin();
    let factor = COULOMB_CONSTANT * density * density;
    let repulsion = 2.0 * factor / distance * (length.hypot(distance) - distance) / length;
    assert!((low.tan() / (repulsion / weight) - 1.0).abs() < 0.1, "{low}");
}

/// T17: the thesis's tress. The mean field on its charges is 13.5 kV/m, at 12 cm it is 0.86 kV/m;
/// segments and 100 points to the centimeter agree on the field of the tress.
#[test]
fn the_tress_has_the_field_that_the_thesis_states() {
    let fibers = hair(300, 101, 2);
    let nodes = fibers.concat();
    let fine = hair(300, 991, 2).concat();
    let density = units::THESIS_LINE_DENSITY.abs();
    let charge = vec![density * 0.3 / 991.0; fine.len()];
    let targets: Vec<_> = fine.iter().copied().step_by(997).collect();
    let fields = Direct.fields(&fine, &charge, &targets).expect("valid");
    let mean = fields.fields.iter().map(Vector3::norm).sum::<f64>() / targets.len() as f64;
    assert!((mean - 13.5e3).abs() < 0.7e3, "{mean} V/m");
    let middle = nodes.iter().skip(50).step_by(101).map(|x| x.coords).sum::<Vector3<f64>>() / 300.0;
    let outside = [Point3::from(middle + Vector3::new(0.0, 0.12 + 0.0049, 0.0))];
    let far = Direct.fields(&fine, &charge, &outside).expect("valid").fields[0].norm();
    assert!((far - 860.0).abs() < 30.0, "{far} V/m");
}

/// Results have equal bits with one thread, two and three.
#[test]
fn threads_change_no_bit() {
    let fibers = hair(200, 61, 5);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| solve(&fibers, 2.6e-11, 40e-6, 1e-3).expect("valid"))
    };
    let one = run(1);
    assert!(one.certificate.order.is_some(), "there is a far field");
    assert!(one == run(2) && one == run(3));
}

/// Requested tolerances are met by all nodal forces.
#[test]
fn tolerances_are_met_by_segments() {
    let fibers = hair(60, 41, 4);
    let exact = solve(&fibers, 2.6e-11, 40e-6, 1e-10).expect("valid");
    for tolerance in [1e-3, 1e-5, 1e-7] {
        let result = solve(&fibers, 2.6e-11, 40e-6, tolerance).expect("valid");
        let error = relative(&result.forces, &exact.forces);
        assert!(error < tolerance, "{error} > {tolerance}");
    }
}

/// T20: no fibres, one segment, fibres that intersect, and nonsense.
#[test]
fn degenerate_fibers_are_answered() {
    let none = solve(&[], 1e-11, 40e-6, 1e-4).expect("defined");
    assert!(none.energy == 0.0 && none.forces.is_empty());
    let one = solve(&[straight(0.0, 0.01, 1)], 1e-11, 40e-6, 1e-4).expect("defined");
    assert!(
        one.forces[1].z > 0.0 && (one.forces[0] + one.forces[1]).norm() < 1e-12 * one.forces[1].z
    );
    let cross = [straight(0.0, 0.01, 3), straight(0.0, 0.01, 3)];
    let cross = solve(&cross, 1e-11, 40e-6, 1e-4).expect("defined");
    assert!(cross.forces.iter().all(|f| f.iter().all(|x| x.is_finite())));
    let point = vec![Point3::origin(); 2];
    let result = solve(&[point], 1e-11, 40e-6, 1e-4);
    assert!(matches!(result, Err(ElectrostaticsError::Setting { .. })));
    let nowhere = vec![Point3::origin(), Point3::new(0.0, f64::NAN, 0.0)];
    let result = solve(&[nowhere], 1e-11, 40e-6, 1e-4);
    assert!(result.is_err());
}
