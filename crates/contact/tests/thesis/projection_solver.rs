//! Alg. 6 as a solver: the same as on rigid bodies.

use crate::common::Numbers;
use crate::projection_defects::{corrected, random_touches, rods};
use nalgebra::{Matrix3, Point3, Vector2, Vector3};
use rapunzel_contact::projection::{
    self, Differences, Form, Partner, Touch, TwoProjections, project,
};
use rapunzel_contact::{Body, Contact, LimitCurve, Polygon, RigidBody, Solver, Tolerance};

fn octagon(mu: f64) -> LimitCurve {
    let corner = |i: i32| {
        let (sine, cosine) = (f64::from(i) * std::f64::consts::FRAC_PI_4).sin_cos();
        mu * Vector2::new(cosine, sine)
    };
    let corners: Vec<_> = (0..8).map(corner).collect();
    LimitCurve::Polygon(Polygon::new(&corners).expect("around the origin"))
}

/// What Alg. 6 does to the bodies by the solver: a point of each side for every contact, in their order.
fn by_solver(bodies: &mut [RigidBody], touches: &[Touch], coefficients: &[f64], set: Form) {
    let mut on_body = vec![Vec::new(); bodies.len()];
    let mut sides = Vec::new();
    for touch in touches {
        let mut side = |body: usize| {
            on_body[body].push(touch.point);
            (body, on_body[body].len() - 1)
        };
        let first = side(touch.body);
        let second = match touch.partner {
            Partner::Body(other) => Some(side(other)),
            Partner::Given(_) => None,
        };
        sides.push((first, second));
    }
    let starts: Vec<usize> =
        (0..bodies.len()).map(|i| on_body[..i].iter().map(Vec::len).sum()).collect();
    let index = |(body, place): (usize, usize)| starts[body] + place;
    let contacts: Vec<Contact> = touches
        .iter()
        .zip(coefficients)
        .zip(&sides)
        .map(|((touch, &mu), &(first, second))| {
            let normal = touch.normal.normalize();
            let t1 = (touch.tangent - normal * normal.dot(&touch.tangent)).normalize();
            let frame = Matrix3::from_columns(&[normal, t1, normal.cross(&t1)]);
            let given = match touch.partner {
                Partner::Given(velocity) => velocity,
                Partner::Body(_) => Vector3::zeros(),
            };
            Contact {
                first: index(first),
                second: second.map(index),
                frame,
                bias: Vector3::x() * touch.closing - frame.tr_mul(&given),
                friction: octagon(mu),
                adhesion: 0.0,
                compliance: 0.0,
            }
        })
        .collect();
    let points = |(body, at): (&RigidBody, &Vec<Point3<f64>>)| body.with_points(at).expect("valid");
    let mut answering: Vec<_> = bodies.iter().zip(&on_body).map(points).collect();
    let velocities: Vec<_> = bodies
        .iter()
        .zip(&on_body)
        .flat_map(|(body, at)| at.iter().map(|point| body.velocity_at(point)))
        .collect();
    let mut impulses = vec![Vector3::zeros(); contacts.len()];
    let mut solver = TwoProjections { friction_set: set, ..TwoProjections::new(Tolerance::EXACT) };
    let mut dynamic: Vec<_> = answering.iter_mut().map(|body| body as &mut dyn Body).collect();
    solver.solve(&mut dynamic, &contacts, &velocities, &mut impulses).expect("valid");
    for (((contact, impulse), touch), (first, second)) in
        contacts.iter().zip(&impulses).zip(touches).zip(sides)
    {
        let world = contact.frame * impulse;
        bodies[first.0].apply_impulse(&world, &touch.point);
        if let Some(second) = second {
            bodies[second.0].apply_impulse(&-world, &touch.point);
        }
    }
}

/// Both follow the same programs; what differs is rounding on the way to them.
#[test]
fn rigid_bodies_move_as_alg_6_moves_them() {
    let mut numbers = Numbers(0xa16);
    let mut worst = 0.0_f64;
    for (count, touching) in [(1, 1), (2, 1), (2, 3), (3, 6)] {
        for set in [Form::Corrected, Form::AsPrinted].repeat(200) {
            let start = rods(&mut numbers, count);
            let mut touches = random_touches(&mut numbers, count, touching);
            let coefficients: Vec<_> = touches.iter().map(|_| 2.0 * numbers.positive()).collect();
            for (touch, &mu) in touches.iter_mut().zip(&coefficients) {
                touch.closing = 0.1 * numbers.positive();
                touch.friction = projection::Polygon::regular(mu, 8).expect("valid");
                if let Partner::Given(velocity) = &mut touch.partner {
                    *velocity = 0.1 * numbers.vector();
                }
            }
            let form = Differences { friction_set: set, ..corrected() };
            let (mut expected, mut found) = (start.clone(), start);
            project(&mut expected, &touches, 0.0, &form).expect("solved");
            by_solver(&mut found, &touches, &coefficients, set);
            for (a, b) in expected.iter().zip(&found) {
                let turn = (a.angular_velocity() - b.angular_velocity()).norm();
                let size = a.velocity.norm() + 0.1 * a.angular_velocity().norm();
                worst = worst.max(((a.velocity - b.velocity).norm() + 0.1 * turn) / size);
            }
        }
    }
    println!("Alg. 6 and its solver differ by {worst:.1e}");
    assert!(worst < 1e-11, "{worst:e}");
}
