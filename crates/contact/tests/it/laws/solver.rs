//! Block Gauss-Seidel on many contacts, its report, and what it refuses.
use crate::common::{Dense, Random, act, circle, contact, exact, resolve, to, worst};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rapunzel_contact::{
    Body, Contact, ContactError, DelassusBlocks, GaussSeidel, Report, Solver, Violation, report,
};

/// A net of particles that press each other and the ground, with all kinds of curves.
fn net(random: &mut Random) -> (Vec<Dense>, Vec<Contact>) {
    let count = 12;
    let bodies: Vec<_> = (0..count)
        .map(|_| {
            let mut body = Dense::particle(0.5 + random.unit());
            body.velocity.copy_from(&random.vector());
            body
        })
        .collect();
    let contacts = (0..18)
        .map(|k| {
            let (first, second) = (k % count, (k * 5 + 1) % (count + 2));
            let second = (second < count && second != first).then_some(second);
            let mut c = contact(first, second, &random.direction(), random.curve(k, 1.0));
            c.adhesion = if k % 3 == 0 { 0.1 * random.unit() } else { 0.0 };
            c.compliance = if k % 2 == 0 { 0.01 } else { 0.0 };
            c.bias = 0.1 * random.vector();
            c
        })
        .collect();
    (bodies, contacts)
}

/// What the report says is what an independent evaluation of the law finds.
#[test]
fn reports_are_what_the_law_says() {
    let mut random = Random(20);
    let mut sweeps = 0;
    for _ in 0..100 {
        let (mut bodies, contacts) = net(&mut random);
        let mut impulses = vec![Vector3::zeros(); contacts.len()];
        let mut solver = to(1e-10, 1e-10, 20_000);
        let found = resolve(&mut bodies, &contacts, &mut impulses, &mut solver);
        assert!(found.converged, "{found:?}");
        sweeps = sweeps.max(found.iterations);
        for (c, r) in contacts.iter().zip(&impulses) {
            let second = c.second.map_or_else(Vector3::zeros, |i| bodies[i].velocities()[0]);
            let v = bodies[c.first].velocities()[0] - second;
            let u = c.frame.tr_mul(&v) + c.bias + r * c.compliance;
            let violation = Violation::new(c, &u, r, 1.0);
            assert!(violation.normal < 2e-10 && violation.slip < 2e-10, "{violation:?}");
        }
    }
    println!("nets of 18 contacts: at most {sweeps} sweeps to 1e-10");
}

#[test]
fn relaxation_and_warm_starts_find_the_same() {
    let mut random = Random(21);
    let (bodies, contacts) = net(&mut random);
    let solve = |relaxation: f64, start: Vec<Vector3<f64>>| {
        let mut impulses = start;
        let mut solver = GaussSeidel { relaxation, ..to(1e-11, 1e-11, 5000) };
        let report = resolve(&mut bodies.clone(), &contacts, &mut impulses, &mut solver);
        assert!(report.converged, "{relaxation} {report:?}");
        (impulses, report)
    };
    let (plain, _) = solve(1.0, vec![Vector3::zeros(); 18]);
    for relaxation in [0.7, 1.3] {
        let (other, _) = solve(relaxation, vec![Vector3::zeros(); 18]);
        for (a, b) in plain.iter().zip(&other) {
            assert!((a - b).norm() < 1e-9, "{relaxation}: {a} {b}");
        }
    }
    let (again, report) = solve(1.0, plain.clone());
    assert_eq!((again, report.iterations), (plain, 0));
}

/// Particles that know how they answer, in another order than that of their points.
struct WrittenOut(Vec<(Vec<usize>, DelassusBlocks)>);

impl WrittenOut {
    fn new(particles: &[Dense]) -> Self {
        let answers = |particle: &Dense| DelassusBlocks::new(&particle.mobility).expect("square");
        let one = |(i, particle)| (vec![i], answers(particle));
        Self(particles.iter().enumerate().map(one).rev().collect())
    }
}

impl Body for WrittenOut {
    fn points(&self) -> usize {
        self.0.len()
    }

    fn set_weights(&mut self, _: &[f64]) -> Result<(), ContactError> {
        unreachable!("nobody asks")
    }

    fn respond(&mut self, _: &[Vector3<f64>], _: &mut [Vector3<f64>]) {
        unreachable!("it is written out")
    }

    fn weighted_respond(&mut self, _: &[Vector3<f64>], _: &mut [Vector3<f64>]) {
        unreachable!("nobody asks")
    }

    fn own_traces(&mut self, _: &mut [f64]) {
        unreachable!("nobody asks")
    }

    fn dense_delassus(&self) -> Option<Vec<(&[usize], &DelassusBlocks)>> {
        Some(self.0.iter().map(|(points, answers)| (&points[..], answers)).collect())
    }
}

#[test]
fn answers_that_are_written_out_are_not_asked_for() {
    let mut random = Random(23);
    for _ in 0..20 {
        let (mut particles, contacts) = net(&mut random);
        let velocities: Vec<_> = particles.iter().flat_map(Dense::velocities).collect();
        let mut written = WrittenOut::new(&particles);
        let mut of_asked = vec![Vector3::zeros(); contacts.len()];
        let mut of_written = of_asked.clone();
        let asked = resolve(&mut particles, &contacts, &mut of_asked, &mut exact());
        let mut bodies: [&mut dyn Body; 1] = [&mut written];
        let found = exact().solve(&mut bodies, &contacts, &velocities, &mut of_written);
        let found = found.expect("valid");
        assert!(asked.converged && found.converged, "{found:?}");
        for (a, b) in of_asked.iter().zip(&of_written) {
            assert!((a - b).norm() < 1e-9, "{a} {b}");
        }
    }
}

#[test]
fn answers_that_do_not_fit_are_refused() {
    let contacts = [contact(0, None, &Vector3::z(), circle(0.3))];
    let of_points = |count: usize| DelassusBlocks::new(&DMatrix::identity(3 * count, 3 * count));
    let wrong = [(vec![1], 1), (vec![0], 2), (vec![0, 0], 2)];
    for (points, count) in wrong {
        let mut body = WrittenOut(vec![(points, of_points(count).expect("square"))]);
        let (v, mut r) = ([Vector3::zeros()], [Vector3::zeros()]);
        let error = exact().solve(&mut [&mut body], &contacts, &v, &mut r).expect_err("refused");
        assert!(matches!(error, ContactError::Body { body: 0, .. }), "{error}");
    }
    for (rows, columns) in [(2, 3), (3, 2), (4, 4), (6, 3)] {
        let error = DelassusBlocks::new(&DMatrix::zeros(rows, columns)).expect_err("refused");
        assert!(matches!(error, ContactError::Length { .. }), "{error}");
    }
    let error = DelassusBlocks::new(&DMatrix::from_element(3, 3, f64::NAN)).expect_err("refused");
    assert!(matches!(error, ContactError::Invalid { .. }), "{error}");
}

#[test]
fn answers_side_by_side_are_those_of_their_matrix() {
    for count in [0, 1, 8, 9] {
        // Whole numbers of so few digits are exact in single precision too.
        let entry = |i: usize, j: usize| (3 * i * j + i + 2 * j) as f64;
        let matrix = DMatrix::from_fn(3 * count, 3 * count, entry);
        for answers in [DelassusBlocks::new(&matrix), DelassusBlocks::rounded(&matrix)] {
            let answers = answers.expect("square");
            assert_eq!(answers.points(), count);
            for (row, column) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
                let block = matrix.fixed_view::<3, 3>(3 * row, 3 * column);
                assert_eq!(answers.block(row, column), block);
            }
        }
    }
    let far = DMatrix::from_element(3, 3, 1e39);
    assert!(DelassusBlocks::new(&far).is_ok() && DelassusBlocks::rounded(&far).is_err());
}

/// Single precision moves points by a ten-millionth of what impulses do to them, of the order of
/// one here.
#[test]
fn rounded_answers_serve_as_far_as_their_digits_go() {
    let mut random = Random(29);
    for _ in 0..20 {
        let (mut particles, contacts) = net(&mut random);
        let velocities: Vec<_> = particles.iter().flat_map(Dense::velocities).collect();
        let rounded =
            |particle: &Dense| DelassusBlocks::rounded(&particle.mobility).expect("square");
        let one = |(i, particle)| (vec![i], rounded(particle));
        let mut written = WrittenOut(particles.iter().enumerate().map(one).collect());
        let mut impulses = vec![Vector3::zeros(); contacts.len()];
        let mut solver = to(1e-5, 1e-6, 5000);
        let found = solver.solve(&mut [&mut written], &contacts, &velocities, &mut impulses);
        assert!(found.expect("valid").converged);
        act(&mut particles, &contacts, &impulses);
        let error = worst(&particles, &contacts, &impulses);
        assert!(error < 3e-6, "{error}");
    }
}

/// What is wrong in one place costs nothing in others, and changes nothing there.
#[test]
fn contacts_that_are_right_are_passed_over() {
    let count = 50;
    let mut bodies = vec![Dense::particle(2.0); count];
    bodies.iter_mut().for_each(|body| body.velocity[2] = -1.0);
    let contacts: Vec<_> =
        (0..count).map(|i| contact(i, None, &Vector3::z(), circle(0.3))).collect();
    let pressed = |wrong: usize| {
        let mut impulses = vec![Vector3::new(2.0, 0.0, 0.0); count];
        impulses[..wrong].fill(Vector3::zeros());
        impulses
    };
    // As many solves as there are contacts are an iteration, and a part of one counts as one.
    for (wrong, iterations) in [(0, 0), (1, 1), (count, 1)] {
        let mut impulses = pressed(wrong);
        let found = resolve(&mut bodies.clone(), &contacts, &mut impulses, &mut exact());
        assert!(found.converged && found.iterations == iterations, "{wrong}: {found:?}");
        assert_eq!(impulses, pressed(0));
    }
}

#[test]
fn a_search_that_ends_early_says_so() {
    let mut random = Random(22);
    let (mut bodies, contacts) = net(&mut random);
    let mut impulses = vec![Vector3::zeros(); contacts.len()];
    let mut solver = to(1e-12, 1e-12, 2);
    let found = resolve(&mut bodies, &contacts, &mut impulses, &mut solver);
    assert!(!found.converged && found.iterations == 2 && found.residual > 1e-12);
}

#[test]
fn residuals_measure_each_part_of_the_law() {
    let c = contact(0, None, &Vector3::z(), circle(0.5));
    let of = |u: [f64; 3], r: [f64; 3]| Violation::new(&c, &u.into(), &r.into(), 2.0);
    // Open, stuck, sliding.
    for (u, r) in [
        ([1.0, 5.0, 2.0], [0.0; 3]),
        ([0.0; 3], [1.0, 0.3, -0.4]),
        ([0.0, 3.0, -4.0], [2.0, -0.6, 0.8]),
    ] {
        let Violation { impulse, normal, slip } = of(u, r);
        assert!(impulse < 1e-15 && normal < 1e-15 && slip < 1e-15, "{u:?}");
    }
    assert_eq!(of([-0.1, 0.0, 0.0], [0.0; 3]).normal, 0.1);
    assert_eq!(of([0.1, 0.0, 0.0], [9.0, 0.0, 0.0]).normal, 0.1);
    assert!((of([0.0, 1e-3, 0.0], [9.0, 0.0, 0.0]).slip - 1e-3).abs() < 1e-15);
    // Friction that drives the slip allows none; that at its limit allows what it is not straight
    // against, which the natural map tells.
    assert!((of([0.0, 1e-3, 0.0], [2.0, 1.0, 0.0]).slip - 1e-3).abs() < 1e-15);
    let (sin, cos) = 0.1_f64.sin_cos();
    let askew = of([0.0, 1e-3 * cos, 1e-3 * sin], [2.0, -1.0, 0.0]);
    assert!(askew.slip < 1e-3 * sin * sin && askew.impulse > 0.9 * 2e-3 * sin, "{askew:?}");
    // De Saxcé's term: without it a slider that lifts would pass.
    assert!(of([0.5 * 5.0, 3.0, -4.0], [2.0, -0.6, 0.8]).impulse > 1.0);

    let none = report::<&Contact, f64>(0, |_| unreachable!());
    assert_eq!(none, Report::default());
    let wrong = report(1, |_| (&c, -Vector3::x(), Vector3::zeros(), 2.0));
    assert_eq!((wrong.residual, wrong.normal_error), (1.0, 1.0));
}

/// Two points of one body touch each other: no impulse can move a rigid body against itself.
#[test]
fn a_body_may_touch_itself() {
    let offsets = [Vector3::x(), Vector3::x()];
    let mut rigid = [Dense::rigid(1.0, &Matrix3::identity(), &offsets)];
    rigid[0].velocity[2] = -1.0;
    let contacts = [contact(0, Some(1), &Vector3::z(), circle(0.3))];
    let mut impulses = [Vector3::zeros()];
    let report = resolve(&mut rigid, &contacts, &mut impulses, &mut exact());
    assert!(report.converged && impulses[0].norm() < 1e-9, "{report:?} {impulses:?}");

    // A gap that cannot be closed is told of.
    let overlapping = [Contact { bias: -Vector3::x(), ..contacts[0].clone() }];
    let mut solver = to(1e-12, 1e-12, 10);
    let report = resolve(&mut rigid, &overlapping, &mut impulses, &mut solver);
    assert!(!report.converged && report.normal_error == 1.0, "{report:?}");
    assert_eq!(impulses[0], Vector3::zeros());
}

#[test]
fn nonsense_is_refused_with_what_and_where() {
    let good = contact(0, None, &Vector3::z(), circle(0.3));
    let refused =
        |contacts: &[Contact], velocities: usize, impulses: usize, solver: GaussSeidel| {
            let mut body = Dense::particle(1.0);
            let mut bodies: [&mut dyn Body; 1] = [&mut body];
            let velocities = vec![Vector3::zeros(); velocities];
            let mut impulses = vec![Vector3::zeros(); impulses];
            let mut solver = solver;
            solver.solve(&mut bodies, contacts, &velocities, &mut impulses).expect_err("refused")
        };
    let bad = [
        Contact { first: 7, ..good.clone() },
        Contact { second: Some(3), ..good.clone() },
        Contact { second: Some(0), ..good.clone() },
        Contact { frame: good.frame * 1.1, ..good.clone() },
        Contact { frame: -good.frame, ..good.clone() },
        Contact { frame: good.frame * f64::NAN, ..good.clone() },
        Contact { bias: Vector3::repeat(f64::INFINITY), ..good.clone() },
        Contact { adhesion: -1.0, ..good.clone() },
        Contact { compliance: f64::NAN, ..good.clone() },
        Contact { friction: circle(-0.1), ..good.clone() },
    ];
    for bad in bad {
        let error = refused(&[good.clone(), bad.clone()], 1, 2, exact());
        assert!(matches!(error, ContactError::Contact { contact: 1, .. }), "{bad:?}: {error}");
    }
    let one = std::slice::from_ref(&good);
    assert!(matches!(refused(one, 2, 1, exact()), ContactError::Length { expected: 1, .. }));
    assert!(matches!(refused(one, 1, 3, exact()), ContactError::Length { found: 3, .. }));
    let mut body = Dense::particle(1.0);
    for (v, r) in [(f64::NAN, 0.0), (0.0, f64::INFINITY)] {
        let (v, mut r) = ([Vector3::repeat(v)], [Vector3::repeat(r)]);
        let error = exact().solve(&mut [&mut body], one, &v, &mut r).expect_err("refused");
        assert!(matches!(error, ContactError::Invalid { .. }), "{error}");
    }
    body.mobility.fill(f64::NAN);
    let mut broken = Dense::new(body.mobility, body.jacobian);
    let (v, mut r) = ([Vector3::zeros()], [Vector3::zeros()]);
    let error = exact().solve(&mut [&mut broken], one, &v, &mut r).expect_err("refused");
    assert!(matches!(error, ContactError::Body { body: 0, .. }), "{error}");
    for relaxation in [0.0, 2.0, f64::NAN] {
        let solver = GaussSeidel { relaxation, ..exact() };
        assert!(matches!(refused(one, 1, 1, solver), ContactError::Invalid { .. }));
    }
}
