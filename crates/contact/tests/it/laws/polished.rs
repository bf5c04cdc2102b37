//! Splitting and then one by one: the law, and what becomes of problems that one of them cannot
//! solve.
use crate::common::{Dense, Random, heap, resolve, to, worst};
use nalgebra::Vector3;
use rapunzel_contact::{Admm, Contact, GaussSeidel, Polished, Report, Solver, Tolerance};

/// Solves from no impulses, with answers that are written out; returns these and what an
/// independent evaluation of the law finds wrong as well.
fn solve(
    bodies: &[Dense],
    contacts: &[Contact],
    solver: &mut dyn Solver,
) -> (Report, Vec<Vector3<f64>>, f64) {
    let mut impulses = vec![Vector3::zeros(); contacts.len()];
    let mut bodies: Vec<_> = bodies.iter().cloned().map(Dense::written).collect();
    let found = resolve(&mut bodies, contacts, &mut impulses, solver);
    let worst = worst(&bodies, contacts, &impulses);
    (found, impulses, worst)
}

const TOLERANCE: Tolerance =
    Tolerance { residual: 1e-8, normal: 1e-8, slip: 1e-8, iterations: 5000 };

/// Whatever friction is, what it calls solved obeys the law; and it solves what splitting does.
#[test]
fn answers_obey_the_law() {
    let mut random = Random(40);
    let (mut solved, mut stalled) = (0, 0);
    for k in 0..200 {
        let (bodies, contacts) = heap(&mut random, if k % 2 == 0 { 0.5 } else { 2.0 });
        let (found, _, worst) = solve(&bodies, &contacts, &mut Polished::new(TOLERANCE));
        let (split, ..) = solve(&bodies, &contacts, &mut Admm::new(TOLERANCE));
        let mut one_by_one = GaussSeidel { patience: 20, ..to(1e-8, 1e-8, 5000) };
        let (turned, ..) = solve(&bodies, &contacts, &mut one_by_one);
        if found.converged {
            solved += 1;
            assert!(worst < 1e-7, "{k}: {worst} {found:?}");
        }
        stalled += usize::from(!turned.converged && turned.iterations < 5000);
        assert!(found.converged || !split.converged, "{k}: {found:?} {split:?} {turned:?}");
    }
    println!("{solved} of 200 heaps solved; alone, Gauss-Seidel gave up on {stalled}");
    assert!(solved >= 190 && stalled > 0, "{solved} {stalled}");
}

/// Where one by one has led nowhere splitting goes on alone, until it is told that another problem
/// comes.
#[test]
fn what_leads_nowhere_is_not_tried_again_before_it_is_told() {
    let mut random = Random(41);
    let (easy, few) = heap(&mut random, 0.3);
    let mut solver = Polished::new(TOLERANCE);
    let (fresh, first, _) = solve(&easy, &few, &mut solver);
    let (split, of_splitting, _) = solve(&easy, &few, &mut Admm::new(TOLERANCE));
    assert!(fresh.converged && split.converged && first != of_splitting);
    let stalled = (0..50).any(|_| {
        let (bodies, contacts) = heap(&mut random, 2.0);
        solve(&bodies, &contacts, &mut solver);
        solve(&easy, &few, &mut solver).1 == of_splitting
    });
    assert!(stalled);
    assert_eq!(solve(&easy, &few, &mut solver).0, split);
    solver.forget();
    let (again, impulses, _) = solve(&easy, &few, &mut solver);
    assert_eq!((again, impulses), (fresh, first));
}

/// What is not written out would have to be asked for: splitting does without.
#[test]
fn answers_that_are_not_written_out_are_not_asked_for() {
    let mut random = Random(42);
    let (bodies, contacts) = heap(&mut random, 0.3);
    let mut of_polished = vec![Vector3::zeros(); contacts.len()];
    let mut of_splitting = of_polished.clone();
    let mut polished = Polished::new(TOLERANCE);
    let found = resolve(&mut bodies.clone(), &contacts, &mut of_polished, &mut polished);
    let mut splitting = Admm::new(TOLERANCE);
    let split = resolve(&mut bodies.clone(), &contacts, &mut of_splitting, &mut splitting);
    assert!(found.converged);
    assert_eq!((found, of_polished), (split, of_splitting));
}
