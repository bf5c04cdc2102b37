//! Restitution: contact.md's tests 11 to 14 and, for rigid rods, 16.
use crate::common::{Dense, G, Random, act, circle, contact, exact, resolve, to};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rapunzel_contact::thesis::projection::TwoProjections;
use rapunzel_contact::{
    Body, Contact, ImpactReport, Solver, Tolerance, Violation, impact, impact_in_turn,
    solve_contact,
};

#[derive(Debug, Clone, Copy)]
enum Law {
    Together,
    InTurn,
}

fn collide(
    bodies: &mut [Dense],
    contacts: &[Contact],
    restitution: &[f64],
    law: Law,
    solver: &mut dyn Solver,
) -> ImpactReport {
    let velocities: Vec<_> = bodies.iter().flat_map(Dense::velocities).collect();
    let mut dynamic: Vec<&mut dyn Body> = bodies.iter_mut().map(|b| b as &mut dyn Body).collect();
    let hit = match law {
        Law::Together => impact(&mut dynamic, contacts, restitution, &velocities, solver),
        Law::InTurn => impact_in_turn(&mut dynamic, contacts, restitution, &velocities, 1000),
    };
    let hit = hit.expect("valid");
    act(bodies, contacts, &hit.impulses);
    let after = bodies.iter().flat_map(Dense::velocities);
    let size = 1.0 + hit.impulses.iter().map(Vector3::norm).sum::<f64>();
    for (v, w) in after.zip(&hit.velocities) {
        assert!((v - w).norm() < 1e-12 * size, "the velocities are those that the impulses cause");
    }
    hit
}

/// Flights are exact, steps end at impacts; an approach slower than gravity in a step is a rest.
#[test]
fn a_ball_bounces_to_rest() {
    let (dt, e) = (1e-4, 0.5);
    let contacts = [contact(0, None, &Vector3::z(), circle(0.3))];
    let (mut z, mut v, mut t) = (0.1_f64, 0.0_f64, 0.0);
    let mut peaks = Vec::new();
    let mut left = dt;
    loop {
        // Time until the ground, by the root that does not cancel.
        let root = (v * v + 2.0 * G * z.max(0.0)).sqrt();
        let until = (v + root) / G;
        if until > left {
            if v > 0.0 && v <= G * left {
                peaks.push(z + v * v / (2.0 * G));
            }
            z += v * left - 0.5 * G * left * left;
            v -= G * left;
            t += left;
            left = dt;
            continue;
        }
        if v > 0.0 && v <= G * until {
            peaks.push(z + v * v / (2.0 * G));
        }
        t += until;
        left -= until;
        (z, v) = (0.0, -root);
        if root < G * dt {
            break;
        }
        let mut ball = [Dense::sphere(0.1, 0.01, &[-Vector3::z()])];
        ball[0].velocity[2] = v;
        collide(&mut ball, &contacts, &[e], Law::Together, &mut exact());
        v = ball[0].velocity[2];
    }
    assert!((t - 0.42835).abs() < 2.0 * dt, "{t}");
    for (n, peak) in peaks.iter().enumerate() {
        let expected = 0.1 * e.powi(2 * (i32::try_from(n).expect("few") + 1));
        assert!((peak - expected).abs() < 1e-12, "{n}: {peak}");
    }
    assert!(peaks.len() > 8);
}

#[test]
fn a_cradle_obeys_both_laws() {
    let balls = [[-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0]];
    let contacts = [
        contact(2, Some(1), &Vector3::x(), circle(0.0)),
        contact(4, Some(3), &Vector3::x(), circle(0.0)),
    ];
    for (law, expected) in
        [(Law::InTurn, [0.0, 0.0, 1.0]), (Law::Together, [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0])]
    {
        let mut bodies =
            balls.map(|sides| Dense::sphere(0.2, 0.01, &sides.map(|s| Vector3::x() * s)));
        bodies[0].velocity[0] = 1.0;
        let hit = collide(&mut bodies, &contacts, &[1.0; 2], law, &mut exact());
        for (body, expected) in bodies.iter().zip(expected) {
            assert!((body.velocity[0] - expected).abs() < 1e-12, "{law:?}");
        }
        let energy: f64 = bodies.iter().map(Dense::kinetic_energy).sum();
        assert!((energy - 0.1).abs() < 1e-13 && hit.energy.abs() < 1e-13, "{law:?}");
        assert_eq!(hit.share, 1.0);
        assert!(hit.report.converged);
    }
}

/// Random bodies, points, normals, coefficients: one set of contacts per seed.
fn random_set(random: &mut Random) -> (Vec<Dense>, Vec<Contact>, Vec<f64>) {
    let count = 1 + random.below(3);
    let contacts_count = 1 + random.below(5);
    let mut bodies = Vec::new();
    let mut starts = Vec::new();
    let mut points = 0;
    for _ in 0..count {
        let inertia = Matrix3::from_diagonal(
            &(Vector3::repeat(0.2) + Vector3::from_fn(|_, _| random.unit())),
        );
        let offsets: Vec<_> = (0..contacts_count).map(|_| random.vector()).collect();
        let mut body = Dense::rigid(0.1 + random.unit(), &inertia, &offsets);
        body.velocity.iter_mut().for_each(|v| *v = random.signed());
        starts.push(points);
        points += offsets.len();
        bodies.push(body);
    }
    let contacts = (0..contacts_count)
        .map(|k| {
            let first = random.below(count);
            let second = random.below(count + 1);
            let second = (second < count && second != first).then(|| starts[second] + k);
            let mut c = contact(starts[first] + k, second, &random.direction(), circle(0.0));
            c.friction = random.curve(k, 2.0);
            c
        })
        .collect();
    let restitution = (0..contacts_count).map(|_| random.unit()).collect();
    (bodies, contacts, restitution)
}

#[test]
fn impacts_never_gain_energy() {
    let sets = 100_000;
    let mut random = Random(13);
    let (mut capped, mut loose, mut jammed, mut worst) = (0, 0, 0, f64::NEG_INFINITY);
    for set in 0..sets {
        let (mut bodies, contacts, restitution) = random_set(&mut random);
        let before: f64 = bodies.iter().map(Dense::kinetic_energy).sum();
        let law = if set % 4 == 0 { Law::InTurn } else { Law::Together };
        let mut solver = to(1e-9, 1e-9, 200);
        let hit = collide(&mut bodies, &contacts, &restitution, law, &mut solver);
        let after: f64 = bodies.iter().map(Dense::kinetic_energy).sum();
        let gain = after / before - 1.0;
        assert!(gain <= 1e-12, "{set}: {gain:e} {hit:?}");
        // The energy that is told is the work of the impulses. Those that jam are a hundred times
        // the momenta, and their work is the difference of terms as large as their squares.
        let squares: f64 = hit.impulses.iter().map(Vector3::norm_squared).sum();
        let error = (after - before - hit.energy).abs();
        assert!(error < 1e-12 * before + 1e-15 * squares, "{set} {law:?}: {error:e} {hit:?}");
        jammed += usize::from(error > 1e-12 * before);
        capped += usize::from(hit.share < 1.0);
        loose += usize::from(!hit.report.converged);
        worst = worst.max(gain);
    }
    println!(
        "{sets} sets: {capped} capped, {loose} not converged, {jammed} jammed, \
         gain at most {worst:.1e}"
    );
    assert!(200 * jammed < sets, "few jam so that it matters: {jammed}");
    assert!(capped > 0, "some would have gained energy");
}

/// Two projections are not the law, yet gain nothing either.
#[test]
fn impacts_by_two_projections_never_gain_energy() {
    let mut random = Random(17);
    let mut worst = f64::NEG_INFINITY;
    for set in 0..10_000 {
        let (mut bodies, contacts, restitution) = random_set(&mut random);
        let before: f64 = bodies.iter().map(Dense::kinetic_energy).sum();
        let mut solver = TwoProjections::new(Tolerance::EXACT);
        collide(&mut bodies, &contacts, &restitution, Law::Together, &mut solver);
        let gain = bodies.iter().map(Dense::kinetic_energy).sum::<f64>() / before - 1.0;
        assert!(gain <= 1e-12, "{set}: {gain:e}");
        worst = worst.max(gain);
    }
    println!("two projections gain at most {worst:.1e}");
}

/// Kane and Levinson: the end of a double pendulum strikes a plane. Newton's law with Coulomb's, as
/// printed in many books, gains energy.
#[test]
fn a_double_pendulum_gains_nothing() {
    let (a, b) = (20_f64.to_radians(), 30_f64.to_radians());
    let cross = 0.5 * (a - b).cos();
    let mass = DMatrix::from_row_slice(2, 2, &[4.0 / 3.0, cross, cross, 1.0 / 3.0]);
    // x across, z up, the pendulum hanging.
    let jacobian = DMatrix::from_row_slice(3, 2, &[a.cos(), b.cos(), 0.0, 0.0, a.sin(), b.sin()]);
    let pendulum = Dense::new(mass.try_inverse().expect("regular"), jacobian);
    let mut gains = 0.0_f64;
    for mu in [0.1, 0.3, 0.5, 0.8] {
        for e in [0.3, 0.5, 0.7, 0.9, 1.0] {
            let contacts = [contact(0, None, &Vector3::z(), circle(mu))];
            let mut bodies = [pendulum.clone()];
            bodies[0].velocity.copy_from_slice(&[-0.1, -0.2]);
            let before = bodies[0].kinetic_energy();
            let u = contacts[0].frame.tr_mul(&bodies[0].velocities()[0]);
            let world = &pendulum.jacobian * &pendulum.mobility * pendulum.jacobian.transpose();
            let frame = contacts[0].frame;
            let w = frame.transpose() * world.fixed_view::<3, 3>(0, 0) * frame;
            let printed = solve_contact(&contacts[0], &w, &(u + Vector3::x() * (e * u.x)));
            let change = printed.dot(&(u + 0.5 * w * printed));
            gains = gains.max(change / before);

            let hit = collide(&mut bodies, &contacts, &[e], Law::Together, &mut exact());
            let after = bodies[0].kinetic_energy();
            assert!(after <= before * (1.0 + 1e-14), "{mu} {e}: {before} {after}");
            assert_eq!(change > 0.0, hit.share < 1.0, "{mu} {e}");
            let normal = frame.tr_mul(&bodies[0].velocities()[0]).x;
            assert!(normal > -1e-14 && normal < -e * u.x + 1e-14);
        }
    }
    println!("double pendulum: Newton's law alone gains {:.1} % of the energy", 100.0 * gains);
    assert!(gains > 0.01);
}

/// A rod that slides on its lower end: above mu = 4/3 at tan = 2 there is no continuous motion, yet
/// a step has a solution for every mu.
#[test]
fn painleves_rod_has_an_impulse_for_every_friction() {
    let angle = 2_f64.atan();
    assert!((angle.to_degrees() - 63.43).abs() < 0.01);
    let axis = Vector3::new(angle.cos(), 0.0, angle.sin());
    let rod = Dense::rod(1.0, 2.0, &axis, &[-1.0]);
    let mut critical = f64::INFINITY;
    for k in 0..2000 {
        let mu = 0.01 * f64::from(k);
        let contacts = [contact(0, None, &Vector3::z(), circle(mu))];
        let frame = contacts[0].frame;
        let world = &rod.jacobian * &rod.mobility * rod.jacobian.transpose();
        let w = frame.transpose() * world.fixed_view::<3, 3>(0, 0) * frame;
        if w.m11 - mu * w.m12.hypot(w.m13) <= 0.0 {
            critical = critical.min(mu);
        }
        for speed in [-1.0, 1.0] {
            let mut bodies = [rod.clone()];
            bodies[0].velocity[0] = speed;
            bodies[0].push(&[0.0, 0.0, -G * 1e-3, 0.0, 0.0, 0.0]);
            let mut impulses = [Vector3::zeros()];
            let report = resolve(&mut bodies, &contacts, &mut impulses, &mut exact());
            assert!(report.converged, "{mu} {speed}: {report:?}");
            assert!(impulses[0].iter().all(|x| x.is_finite()) && impulses[0].x >= 0.0);
            let u = frame.tr_mul(&bodies[0].velocities()[0]);
            let violation = Violation::new(&contacts[0], &u, &impulses[0], 3.0 / w.trace());
            assert!(violation.normal < 1e-12 && violation.slip < 1e-12, "{mu}: {violation:?}");
        }
    }
    assert!((critical - 4.0 / 3.0).abs() < 0.01, "{critical}");
}

#[test]
fn collisions_keep_both_momenta() {
    let mut random = Random(16);
    for law in [Law::Together, Law::InTurn] {
        for _ in 0..200 {
            let axes = [random.direction(), random.direction()];
            let places = [random.signed(), random.signed()];
            let inertia =
                |axis: &Vector3<f64>| (Matrix3::identity() - axis * axis.transpose() * 0.9) * 0.2;
            let mut rods =
                [0, 1].map(|i| Dense::rigid(0.5, &inertia(&axes[i]), &[axes[i] * places[i]]));
            for rod in &mut rods {
                rod.velocity.iter_mut().for_each(|v| *v = random.signed());
            }
            // The rods touch at the origin.
            let centers = [0, 1].map(|i| -axes[i] * places[i]);
            let momenta = |rods: &[Dense; 2]| {
                let mut linear = Vector3::zeros();
                let mut angular = Vector3::zeros();
                for (rod, center) in rods.iter().zip(&centers) {
                    let mass = rod.mobility.clone().try_inverse().expect("regular");
                    let p = mass * &rod.velocity;
                    let own = Vector3::new(p[0], p[1], p[2]);
                    linear += own;
                    angular += Vector3::new(p[3], p[4], p[5]) + center.cross(&own);
                }
                (linear, angular)
            };
            let before = momenta(&rods);
            let contacts = [contact(0, Some(1), &axes[0].cross(&axes[1]), random.curve(2, 1.0))];
            collide(&mut rods, &contacts, &[0.5], law, &mut exact());
            let after = momenta(&rods);
            assert!((after.0 - before.0).norm() < 1e-12 * (1.0 + before.0.norm()));
            assert!((after.1 - before.1).norm() < 1e-12 * (1.0 + before.1.norm()));
        }
    }
}

#[test]
fn impacts_refuse_bad_restitution() {
    let contacts = [contact(0, None, &Vector3::z(), circle(0.3))];
    for restitution in [&[-0.1][..], &[1.1], &[f64::NAN], &[]] {
        let mut ball = Dense::particle(1.0);
        let mut bodies: [&mut dyn Body; 1] = [&mut ball];
        let v = [Vector3::zeros()];
        assert!(impact(&mut bodies, &contacts, restitution, &v, &mut exact()).is_err());
        assert!(impact_in_turn(&mut bodies, &contacts, restitution, &v, 9).is_err());
    }
}
