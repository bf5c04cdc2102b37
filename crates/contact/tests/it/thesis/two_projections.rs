//! Alg. 6 as a solver among the others: what it promises of bodies of any kind, and what it
//! reports.
use crate::common::{Dense, Random, circle, contact, exact, heap, resolve};
use nalgebra::{DMatrix, Vector3};
use rapunzel_contact::thesis::projection::TwoProjections;
use rapunzel_contact::{Body, Contact, ContactError, Solver, Tolerance, report};

const TOLERANCE: Tolerance = Tolerance { residual: 1e-9, normal: 1e-9, slip: 1e-9, iterations: 1 };

fn own_traces(body: &mut Dense) -> Vec<f64> {
    let mut traces = vec![0.0; body.points()];
    body.own_traces(&mut traces);
    traces
}

/// One contact of a particle, whose normal and tangents do not answer each other: the law itself.
#[test]
fn one_contact_of_a_particle_is_solved_exactly() {
    let mut random = Random(60);
    for _ in 0..500 {
        let mut particle = [Dense::particle(0.5 + random.unit())];
        particle[0].velocity.copy_from(&random.vector());
        let mut ground = contact(0, None, &random.direction(), circle(0.0));
        ground.friction = random.curve(3, 1.0);
        ground.adhesion = 0.2 * random.unit();
        ground.compliance = random.unit();
        ground.bias = random.vector();
        let solve = |solver: &mut dyn Solver, start: Vector3<f64>| {
            let mut impulses = [start];
            let found = resolve(
                &mut particle.clone(),
                std::slice::from_ref(&ground),
                &mut impulses,
                solver,
            );
            assert!(found.converged, "{found:?} {ground:?}");
            impulses[0]
        };
        let mut projections = TwoProjections::new(TOLERANCE);
        let expected = solve(&mut exact(), Vector3::zeros());
        for start in [Vector3::zeros(), random.vector()] {
            let found = solve(&mut projections, start);
            assert!((found - expected).norm() < 1e-11, "{found} {expected} {ground:?}");
        }
    }
}

/// In a heap it is not the law, but what it does promise holds, and its report is what an
/// independent evaluation finds.
#[test]
fn a_heap_is_kept_apart_within_friction_and_gains_nothing() {
    let mut random = Random(61);
    let (mut solved, mut off) = (0, 0.0_f64);
    for _ in 0..200 {
        let (mut bodies, mut contacts) = heap(&mut random, 0.8);
        for contact in &mut contacts {
            (contact.bias, contact.adhesion) = (Vector3::zeros(), 0.0);
        }
        let energy = |bodies: &[Dense]| bodies.iter().map(Dense::kinetic_energy).sum::<f64>();
        let before = energy(&bodies);
        let mut impulses = vec![Vector3::zeros(); contacts.len()];
        let mut solver = TwoProjections::new(TOLERANCE);
        let found = resolve(&mut bodies, &contacts, &mut impulses, &mut solver);
        let size = 1.0 + impulses.iter().map(Vector3::norm).sum::<f64>();
        assert!(energy(&bodies) < before * (1.0 + 1e-12), "{} {before}", energy(&bodies));
        let velocities: Vec<_> = bodies.iter().flat_map(Dense::velocities).collect();
        for (contact, r) in contacts.iter().zip(&impulses) {
            let u = contact.relative(&velocities) + r * contact.compliance;
            assert!(u.x > -1e-9 * size, "{u}");
            let outside = (r.yz() - contact.friction.project(&r.yz(), r.x)).norm();
            assert!(r.x >= 0.0 && outside < 1e-9 * size, "{outside:e} {contact:?}");
        }
        let traces: Vec<_> = bodies.iter_mut().flat_map(own_traces).collect();
        let law = report(contacts.len(), |i| {
            let (contact, r) = (&contacts[i], impulses[i]);
            let trace = traces[contact.first] + contact.second.map_or(0.0, |i| traces[i]);
            let weight = 3.0 / (trace + 3.0 * contact.compliance);
            (contact, contact.relative(&velocities) + r * contact.compliance, r, weight)
        });
        assert!((found.residual - law.residual).abs() < 1e-9, "{found:?} {law:?}");
        assert!((found.normal_error - law.normal_error).abs() < 1e-9 * size, "{found:?} {law:?}");
        assert!((found.slip_error - law.slip_error).abs() < 1e-9 * size, "{found:?} {law:?}");
        off = off.max(found.normal_error).max(found.slip_error);
        assert_eq!(found.iterations, 1);
        solved += usize::from(found.converged);
    }
    println!("{solved} of 200 heaps solved by one pass, others off by up to {off} m/s");
    assert!(solved < 200 && off > 0.1);
}

/// What slips is resisted by the corner that is nearest to straight against it: half a sector off
/// at most.
#[test]
fn smooth_curves_are_met_at_the_nearest_corner() {
    let mut random = Random(62);
    let ground = contact(0, None, &Vector3::z(), circle(0.5));
    for corners in [8, 64] {
        let mut worst = 0.0_f64;
        for _ in 0..200 {
            let slip = random.direction();
            let mut particle = [Dense::particle(1.0)];
            particle[0].velocity.copy_from_slice(&[9.0 * slip.x, 9.0 * slip.y, -1.0]);
            let solve = |solver: &mut dyn Solver| {
                let mut impulses = [Vector3::zeros()];
                let ground = std::slice::from_ref(&ground);
                resolve(&mut particle.clone(), ground, &mut impulses, solver);
                impulses[0]
            };
            let mut solver = TwoProjections { corners, ..TwoProjections::new(TOLERANCE) };
            let (found, expected) = (solve(&mut solver), solve(&mut exact()));
            assert!(found.yz().norm() <= 0.5 + 1e-14, "{found}");
            worst = worst.max((found - expected).norm());
        }
        let half = std::f64::consts::PI / f64::from(u32::try_from(corners).expect("few"));
        assert!(worst < 0.5 * half && worst > 0.25 * half, "{corners}: {worst}");
    }
}

/// Between walls that crush it there are no impulses to be found: those given stay.
#[test]
fn what_cannot_be_kept_apart_is_told() {
    let walls = [1.0, -1.0].map(|side| Contact {
        bias: -Vector3::x(),
        ..contact(0, None, &(Vector3::z() * side), circle(0.3))
    });
    let mut impulses = [Vector3::new(0.1, 0.0, 0.0); 2];
    let given = impulses;
    let mut solver = TwoProjections::new(TOLERANCE);
    let found = resolve(&mut [Dense::particle(1.0)], &walls, &mut impulses, &mut solver);
    assert!(!found.converged && found.normal_error > 0.9, "{found:?}");
    assert_eq!(impulses, given);
    let none: [Contact; 0] = [];
    let found = resolve(&mut [Dense::particle(1.0)], &none, &mut [], &mut solver);
    assert!(found.converged, "{found:?}");
}

#[test]
fn nonsense_is_refused() {
    let good = contact(0, None, &Vector3::z(), circle(0.3));
    let refused = |body: &mut Dense, contact: &Contact, v: f64, corners: usize| {
        let mut solver = TwoProjections { corners, ..TwoProjections::new(TOLERANCE) };
        let (velocities, mut impulses) = ([Vector3::repeat(v)], [Vector3::zeros()]);
        let bodies: &mut [&mut dyn Body] = &mut [body];
        solver.solve(bodies, std::slice::from_ref(contact), &velocities, &mut impulses)
    };
    let mut body = Dense::particle(1.0);
    assert!(refused(&mut body, &good, -1.0, 8).is_ok());
    let error = refused(&mut body, &Contact { first: 7, ..good.clone() }, -1.0, 8);
    assert!(matches!(error, Err(ContactError::Contact { contact: 0, .. })), "{error:?}");
    for (v, corners) in [(f64::NAN, 8), (-1.0, 2)] {
        let error = refused(&mut body, &good, v, corners);
        assert!(matches!(error, Err(ContactError::Invalid { .. })), "{error:?}");
    }
    let mut broken = Dense::new(DMatrix::from_element(3, 3, f64::NAN), DMatrix::identity(3, 3));
    let error = refused(&mut broken, &good, -1.0, 8);
    assert!(matches!(error, Err(ContactError::Invalid { .. })), "{error:?}");
}
