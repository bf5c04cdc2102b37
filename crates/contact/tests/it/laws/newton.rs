//! Newton's method for few contacts.
use crate::common::{Dense, Random, heap, resolve, worst};
use nalgebra::Vector3;
use rapunzel_contact::{Body, Contact, Report, SemismoothNewton, Solver, Tolerance};

const TOLERANCE: Tolerance =
    Tolerance { residual: 1e-8, normal: 1e-8, slip: 1e-8, iterations: 5000 };

/// Solves from no impulses; returns what is reported and what an independent evaluation of the law
/// finds wrong.
fn solve(bodies: &[Dense], contacts: &[Contact], solver: &mut dyn Solver) -> (Report, f64) {
    let mut impulses = vec![Vector3::zeros(); contacts.len()];
    let mut bodies: Vec<_> = bodies.iter().cloned().map(Dense::written).collect();
    let found = resolve(&mut bodies, contacts, &mut impulses, solver);
    (found, worst(&bodies, contacts, &impulses))
}

/// From no impulses at all it ends in a few iterations, whatever friction is, of nine heaps in ten,
/// and what it calls solved obeys the law to many more digits than asked for.
#[test]
fn it_ends_in_a_few_iterations() {
    let mut random = Random(50);
    let (mut solved, mut iterations) = (0, 0);
    for k in 0..200 {
        let (bodies, contacts) = heap(&mut random, if k % 2 == 0 { 0.3 } else { 1.0 });
        let mut newton = SemismoothNewton { tolerance: Tolerance { iterations: 20, ..TOLERANCE } };
        let (found, worst) = solve(&bodies, &contacts, &mut newton);
        if found.converged {
            (solved, iterations) = (solved + 1, iterations + found.iterations);
            assert!(worst < 1e-10, "{k}: {worst} {found:?}");
        }
    }
    println!("{solved} of 200 heaps solved, in {iterations} iterations");
    assert!(solved >= 180 && iterations < 10 * solved, "{solved} {iterations}");
}

/// Two bodies that are one by their contacts, which share what they bear in many ways: the boxes
/// of a stack touch each other at four corners each, of which three would do.
#[test]
fn contacts_that_share_what_they_bear_are_solved() {
    let corners = |z: f64| {
        [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].map(|(x, y)| Vector3::new(x, y, z))
    };
    for masses in [[1.0, 1.0], [1.0, 1e4], [1e4, 1.0]] {
        let cube = |mass: f64| {
            let inertia = nalgebra::Matrix3::from_diagonal_element(mass * 2.0 / 3.0);
            let offsets = [corners(-1.0), corners(1.0)].concat();
            let mut cube = Dense::rigid(mass, &inertia, &offsets);
            cube.velocity[0] = 0.01;
            cube.velocity[2] = -1.0;
            cube
        };
        let mut bodies = masses.map(cube);
        let touch = |first: usize, second: Option<usize>| {
            crate::common::contact(first, second, &Vector3::z(), crate::common::circle(0.3))
        };
        // Of the lower cube points 0 to 7, of the upper 8 to 15.
        let contacts: Vec<_> = (0..4)
            .map(|k| touch(k, None))
            .chain((0..4).map(|k| touch(8 + k, Some(4 + k))))
            .collect();
        let mut impulses = vec![Vector3::zeros(); 8];
        let mut newton =
            SemismoothNewton { tolerance: Tolerance { iterations: 30, ..Tolerance::EXACT } };
        let found = resolve(&mut bodies, &contacts, &mut impulses, &mut newton);
        assert!(found.converged, "{masses:?}: {found:?}");
        // It stops all, as friction holds a hundredth of what the ground takes; the residual may
        // be 1e-12 of that, and act on the lighter of the two.
        let falls = masses[0] + masses[1];
        let bound = 1e-12 * falls / masses[0].min(masses[1]);
        for body in &bodies {
            assert!(body.velocity.norm() < bound, "{masses:?}: {}", body.velocity);
        }
        let floor: f64 = impulses[..4].iter().map(|impulse| impulse.x).sum();
        assert!((floor / falls - 1.0).abs() < 1e-12, "{masses:?}: {floor} for {falls}");
    }
}

/// Nothing to solve, nothing that moves, and impulses that do not fit.
#[test]
fn what_makes_no_sense_is_told() {
    let mut newton = SemismoothNewton { tolerance: TOLERANCE };
    assert!(newton.solve(&mut [], &[], &[], &mut []).expect("nothing").converged);
    let mut fixed = Dense::particle(f64::INFINITY);
    let ground = crate::common::contact(0, None, &Vector3::z(), crate::common::circle(0.3));
    let mut bodies: [&mut dyn Body; 1] = [&mut fixed];
    let falls = [Vector3::new(0.0, 0.0, -1.0)];
    let mut impulses = [Vector3::zeros()];
    let found = newton.solve(&mut bodies, std::slice::from_ref(&ground), &falls, &mut impulses);
    assert!(!found.expect("it makes sense").converged);
    assert!(impulses[0].iter().all(|x| x.is_finite()));
    newton.solve(&mut bodies, &[ground], &falls, &mut []).expect_err("an impulse is missing");
}
