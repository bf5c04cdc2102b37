//! Alg. 6 as a solver, and as one of the ways in which rigid bodies answer what touches them.

use super::common::Numbers;
use super::projection_defects::{corrected, random_touches, rods};
use rapunzel_contact::thesis::Response;
use rapunzel_contact::thesis::projection::{
    Differences, Form, Partner, PolygonalCone, Touch, TwoProjections,
};
use rapunzel_contact::{Admm, ContactError, GaussSeidel, RigidBody, Tolerance};

/// How far two answers are apart, in parts of the velocities.
fn apart(a: &[RigidBody], b: &[RigidBody]) -> f64 {
    let one = |(a, b): (&RigidBody, &RigidBody)| {
        let turn = (a.angular_velocity() - b.angular_velocity()).norm();
        let size = a.velocity.norm() + 0.1 * a.angular_velocity().norm();
        ((a.velocity - b.velocity).norm() + 0.1 * turn) / size
    };
    a.iter().zip(b).map(one).fold(0.0, f64::max)
}

fn answer(
    bodies: &[RigidBody],
    touches: &[Touch],
    response: &mut dyn Response,
) -> Result<Vec<RigidBody>, ContactError> {
    let mut bodies = bodies.to_vec();
    response.collide(&mut bodies, touches, 0.0)?;
    Ok(bodies)
}

/// Rods and how they touch, some something that moves, with gaps that may close.
fn random(numbers: &mut Numbers, count: usize, touching: usize) -> (Vec<RigidBody>, Vec<Touch>) {
    let start = rods(numbers, count);
    let mut touches = random_touches(numbers, count, touching);
    for touch in &mut touches {
        touch.closing = 0.1 * numbers.positive();
        touch.friction = PolygonalCone::regular(2.0 * numbers.positive(), 8).expect("valid");
        if let Partner::Given(velocity) = &mut touch.partner {
            *velocity = 0.1 * numbers.vector();
        }
    }
    (start, touches)
}

const SIZES: [(usize, usize); 4] = [(1, 1), (2, 1), (2, 3), (3, 6)];

/// Both follow the same programs; what differs is rounding on the way to them.
#[test]
fn rigid_bodies_move_as_alg_6_moves_them() {
    let mut numbers = Numbers(0xa16);
    let mut worst = 0.0_f64;
    for (count, touching) in SIZES {
        for friction_set in [Form::Corrected, Form::AsPrinted].repeat(200) {
            let (start, touches) = random(&mut numbers, count, touching);
            let mut form = Differences { friction_set, ..corrected() };
            let mut solver =
                TwoProjections { friction_set, ..TwoProjections::new(Tolerance::EXACT) };
            let expected = answer(&start, &touches, &mut form).expect("solved");
            let found = answer(&start, &touches, &mut solver).expect("solved");
            worst = worst.max(apart(&expected, &found));
        }
    }
    println!("Alg. 6 and its solver differ by {worst:.1e}");
    assert!(worst < 1e-11, "{worst:e}");
}

/// Without friction there is one answer, which all find but the printed one.
#[test]
fn smooth_bodies_move_in_one_way() {
    let mut numbers = Numbers(0x51de);
    let (mut worst, mut printed) = ([0.0_f64; 3], 0.0_f64);
    for (count, touching) in SIZES {
        for _ in 0..100 {
            let (start, mut touches) = random(&mut numbers, count, touching);
            for touch in &mut touches {
                touch.friction = PolygonalCone::regular(0.0, 8).expect("valid");
            }
            let expected = answer(&start, &touches, &mut corrected()).expect("solved");
            let mut all = (
                GaussSeidel::new(Tolerance::EXACT),
                Admm::new(Tolerance::EXACT),
                TwoProjections::new(Tolerance::EXACT),
            );
            let others: [&mut dyn Response; 3] = [&mut all.0, &mut all.1, &mut all.2];
            for (worst, other) in worst.iter_mut().zip(others) {
                let found = answer(&start, &touches, other).expect("solved");
                *worst = worst.max(apart(&expected, &found));
            }
            if let Ok(found) = answer(&start, &touches, &mut Differences::from(Form::AsPrinted)) {
                printed = printed.max(apart(&expected, &found));
            }
        }
    }
    println!("Gauss-Seidel, splitting, two projections: {worst:?}; as printed {printed:.1e}");
    assert!(worst.iter().all(|worst| *worst < 1e-9), "{worst:?}");
    assert!(printed > 0.1, "{printed}");
}
