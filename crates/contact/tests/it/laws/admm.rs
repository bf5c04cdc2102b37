//! The solver for many contacts against the law itself and against the reference.
use crate::common::{Dense, Random, circle, contact, heap, resolve, worst};
use nalgebra::Vector3;
use rapunzel_contact::{Admm, Body, Contact, ContactError, Solver, Tolerance};

/// What it calls solved obeys the law, as found with the bodies' velocities afterwards; and it
/// solves nearly all.
#[test]
fn answers_obey_the_law() {
    let mut random = Random(30);
    let (mut solved, mut iterations) = (0, 0);
    for _ in 0..200 {
        let (mut bodies, contacts) = heap(&mut random, 0.8);
        let mut impulses = vec![Vector3::zeros(); contacts.len()];
        let tolerance = Tolerance { residual: 1e-10, iterations: 5000, ..Tolerance::EXACT };
        let mut solver = Admm::new(tolerance);
        let found = resolve(&mut bodies, &contacts, &mut impulses, &mut solver);
        if found.converged {
            (solved, iterations) = (solved + 1, iterations + found.iterations);
            let size: f64 = impulses.iter().map(Vector3::norm).sum::<f64>() + 1.0;
            let wrong = worst(&bodies, &contacts, &impulses);
            assert!(wrong < 1e-8 * size, "{wrong} {found:?}");
        }
    }
    println!("{solved} of 200 solved, {} iterations in the mean", iterations / solved.max(1));
    assert!(solved >= 195, "{solved}");
}

/// What has hardly changed since it was solved takes a few iterations of descent, not those of
/// splitting, and obeys the law as well.
#[test]
fn small_changes_cost_little() {
    let mut random = Random(32);
    let (mut cold, mut warm, mut solved) = (0, 0, 0);
    for _ in 0..200 {
        let (mut bodies, contacts) = heap(&mut random, 0.8);
        let mut impulses = vec![Vector3::zeros(); contacts.len()];
        let velocity = 1e-5;
        let tolerance =
            Tolerance { residual: 1e-5, normal: velocity, slip: velocity, iterations: 5000 };
        let mut solver = Admm::new(tolerance);
        let first = resolve(&mut bodies.clone(), &contacts, &mut impulses, &mut solver);
        bodies.iter_mut().for_each(|body| body.velocity.add_scalar_mut(10.0 * velocity));
        let second = resolve(&mut bodies, &contacts, &mut impulses, &mut solver);
        if first.converged && second.converged {
            (cold, warm) = (cold + first.iterations, warm + second.iterations);
            solved += 1;
            let wrong = worst(&bodies, &contacts, &impulses);
            // The weight of this measure is 1 kg; the solver's up to eight times a point's inertia.
            assert!(wrong < 10.0 * velocity, "{wrong} {second:?}");
            for (contact, r) in contacts.iter().zip(&impulses) {
                let normal = r.x + contact.adhesion;
                let within = contact.friction.contains(&r.yz(), normal * (1.0 + 1e-9) + 1e-12);
                assert!(normal >= 0.0 && within, "{r} leaves its cone");
            }
        }
    }
    println!("{solved} of 200 solved in {cold} iterations, and again in {warm}");
    assert!(solved >= 195, "{solved}");
    assert!(3 * warm < cold, "{warm} of {cold}");
}

/// Many parts on several threads, again and again: every solve ends, with the same bits as on one
/// thread.
#[test]
fn threads_do_not_change_a_bit() {
    let mut random = Random(33);
    let (mut bodies, mut contacts) = (Vec::new(), Vec::new());
    for _ in 0..30 {
        let before = bodies.iter().map(Body::points).sum::<usize>();
        let (own, mut between) = heap(&mut random, 0.8);
        for contact in &mut between {
            contact.first += before;
            contact.second = contact.second.map(|second| second + before);
        }
        bodies.extend(own);
        contacts.append(&mut between);
    }
    let tolerance = Tolerance { residual: 1e-10, iterations: 6, ..Tolerance::EXACT };
    let solve = || {
        let mut impulses = vec![Vector3::zeros(); contacts.len()];
        resolve(&mut bodies.clone(), &contacts, &mut impulses, &mut Admm::new(tolerance));
        impulses
    };
    let on = |threads, solves| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| (0..solves).map(|_| solve()).collect::<Vec<_>>())
    };
    let alone = &on(1, 1)[0];
    assert!(on(3, 1000).iter().all(|impulses| impulses == alone));
}

/// One contact alone: the same as the exact local solution, which knows of no iteration.
#[test]
fn one_contact_is_solved_exactly() {
    let mut random = Random(31);
    for k in 0..100 {
        let (bodies, mut contacts) = heap(&mut random, 1.0);
        contacts.truncate(1);
        contacts[0].friction = random.curve(k, 1.0);
        let solve = |solver: &mut dyn Solver| {
            let (mut bodies, mut impulses) = (bodies.clone(), vec![Vector3::zeros()]);
            let found = resolve(&mut bodies, &contacts, &mut impulses, solver);
            assert!(found.converged, "{k}: {found:?}");
            impulses[0]
        };
        let admm = solve(&mut Admm::new(Tolerance { residual: 1e-11, ..Tolerance::EXACT }));
        let exact = solve(&mut crate::common::exact());
        assert!((admm - exact).norm() < 1e-9 * (1.0 + exact.norm()), "{k}: {admm} {exact}");
    }
}

/// A warm start at the solution is recognized at the first look; memory and weight change the way
/// but not the answer; nothing touches: nothing happens.
#[test]
fn starts_and_settings_do_not_matter() {
    let ball = Dense::sphere(2.0, 0.1, &[-Vector3::z()]);
    let floor = contact(0, None, &Vector3::z(), circle(0.3));
    let solve = |settings: &dyn Fn(&mut Admm), start: Vector3<f64>| {
        let mut ball = ball.clone();
        ball.velocity.copy_from_slice(&[0.3, 0.1, -1.0, 0.0, 2.0, 0.0]);
        let mut solver = Admm::new(Tolerance { residual: 1e-12, ..Tolerance::EXACT });
        settings(&mut solver);
        let mut impulses = vec![start];
        let found = resolve(&mut [ball], std::slice::from_ref(&floor), &mut impulses, &mut solver);
        assert!(found.converged, "{found:?}");
        (impulses[0], found.iterations)
    };
    let (plain, _) = solve(&|_| {}, Vector3::zeros());
    assert!((plain.x - 2.0).abs() < 1e-11, "{plain}");
    for (memory, weight, relaxation) in [(0, 1.0, 1.0), (5, 0.3, 1.6), (12, 20.0, 1.9)] {
        let settings = |solver: &mut Admm| {
            (solver.memory, solver.weight, solver.relaxation) = (memory, weight, relaxation);
        };
        let (other, _) = solve(&settings, Vector3::zeros());
        assert!((other - plain).norm() < 1e-9, "{memory} {weight}: {other} {plain}");
    }
    let none: [Contact; 0] = [];
    let found = resolve(&mut [ball.clone()], &none, &mut [], &mut Admm::new(Tolerance::EXACT));
    assert!(found.converged && found.iterations == 0);
}

/// A particle that does not take masses, or whose answers are no numbers.
enum Faulty {
    Refuses,
    Fails,
}

impl Body for Faulty {
    fn points(&self) -> usize {
        1
    }

    fn set_weights(&mut self, _: &[f64]) -> Result<(), ContactError> {
        match self {
            Self::Refuses => Err(ContactError::Body { body: 0, why: "it is faulty".into() }),
            Self::Fails => Ok(()),
        }
    }

    fn respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        velocities[0] = match self {
            Self::Refuses => impulses[0],
            Self::Fails => Vector3::repeat(f64::NAN),
        };
    }

    fn weighted_respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        self.respond(impulses, velocities);
    }

    fn own_traces(&mut self, traces: &mut [f64]) {
        traces.fill(3.0);
    }
}

/// A body that cannot be weighed is told, and what it answers is not taken for solved.
#[test]
fn faulty_bodies_are_told() {
    let solve = |mut body: Faulty| {
        let ground = contact(0, None, &Vector3::z(), circle(0.5));
        let falls = [Vector3::new(1.0, 0.0, -1.0)];
        let tolerance = Tolerance { iterations: 50, ..Tolerance::EXACT };
        let mut impulses = [Vector3::zeros()];
        Admm::new(tolerance).solve(&mut [&mut body], &[ground], &falls, &mut impulses)
    };
    let error = solve(Faulty::Refuses).expect_err("it cannot be weighed");
    assert!(matches!(error, ContactError::Body { body: 0, .. }), "{error}");
    let report = solve(Faulty::Fails).expect("a report");
    assert!(!report.converged, "{report:?}");
    let errors = [report.residual, report.normal_error, report.slip_error];
    assert_eq!(errors, [f64::INFINITY; 3]);
}
