//! One by one or by splitting: the law, and which of them it is.
use crate::common::{Dense, Random, heap, resolve, worst};
use nalgebra::Vector3;
use rapunzel_contact::{Adaptive, Admm, Contact, Report, Solver, Tolerance};

const TOLERANCE: Tolerance =
    Tolerance { residual: 1e-8, normal: 1e-8, slip: 1e-8, iterations: 5000 };

/// Solves from no impulses, with answers that are written out or not; returns these and what an
/// independent evaluation of the law finds wrong as well.
fn solve(
    bodies: &[Dense],
    contacts: &[Contact],
    written: bool,
    solver: &mut dyn Solver,
) -> (Report, Vec<Vector3<f64>>, f64) {
    let mut impulses = vec![Vector3::zeros(); contacts.len()];
    let own = |body: Dense| if written { body.written() } else { body };
    let mut bodies: Vec<_> = bodies.iter().cloned().map(own).collect();
    let found = resolve(&mut bodies, contacts, &mut impulses, solver);
    let worst = worst(&bodies, contacts, &impulses);
    (found, impulses, worst)
}

/// What it calls solved obeys the law, and it solves what splitting does, few contacts or many.
#[test]
fn answers_obey_the_law() {
    let mut random = Random(50);
    let mut solved = 0;
    for k in 0..200 {
        let (bodies, contacts) = heap(&mut random, if k % 2 == 0 { 0.5 } else { 2.0 });
        let (found, _, worst) = solve(&bodies, &contacts, true, &mut Adaptive::new(TOLERANCE));
        let (split, ..) = solve(&bodies, &contacts, true, &mut Admm::new(TOLERANCE));
        if found.converged {
            solved += 1;
            assert!(worst < 1e-7, "{k}: {worst} {found:?}");
        }
        assert!(found.converged || !split.converged, "{k}: {found:?} {split:?}");
    }
    assert!(solved >= 190, "{solved}");
}

/// Many contacts, and bodies that have not written out how they answer, are for splitting.
#[test]
fn only_few_contacts_are_solved_one_by_one() {
    let mut random = Random(51);
    let mut sooner = 0;
    for _ in 0..20 {
        let (bodies, few) = heap(&mut random, 0.5);
        let both = |contacts: &[Contact], written: bool| {
            let mut adaptive = Adaptive::new(TOLERANCE);
            let mut splitting = Admm::new(TOLERANCE);
            let own = solve(&bodies, contacts, written, &mut adaptive);
            (own, solve(&bodies, contacts, written, &mut splitting))
        };
        let (own, split) = both(&few, true);
        sooner += usize::from(own.0.iterations < split.0.iterations);
        let (own, split) = both(&few, false);
        assert_eq!(own, split);
        let many: Vec<_> = few.iter().cycle().take(4 * few.len()).cloned().collect();
        let (own, split) = both(&many, true);
        assert_eq!(own, split);
    }
    assert!(sooner > 10, "{sooner}");
}
