//! Forces that follow the rod, by Newton's method and by the two-phase integration.

use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_rod_static::{Chain, Piece, Properties};

fn straight(count: usize) -> Chain {
    let properties = Properties {
        stiffness: Vector3::new(1.0, 1.0, 0.75),
        natural_curvature: Vector3::zeros(),
        load: Vector3::zeros(),
    };
    Chain::new(&Isometry3::identity(), &[Piece::uniform(1.0, properties)], count).expect("a chain")
}

fn with_tip_follower(count: usize, force: Vector3<f64>) -> Chain {
    let mut chain = straight(count);
    let mut followers = vec![Vector3::zeros(); count + 1];
    followers[count] = force;
    chain.set_followers(&followers).expect("followers");
    chain
}

/// The tip of an upright rod under the force `across` its tip, which stays across: from the tip
/// inward this is an initial value, `theta'' = -F cos(theta - theta_tip)`, integrated finely.
fn exact(across: f64) -> Point3<f64> {
    let rate = |y: &[f64; 4]| [-y[1], across * y[0].cos(), -y[0].sin(), -y[0].cos()];
    // Angle from the tip's tangent, curvature, and position in the tip's axes; the root is at 1.
    let mut y = [0.0_f64; 4];
    let h = 1.0 / 4000.0;
    for _ in 0..4000 {
        let at = |k: &[f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
        let a = rate(&y);
        let b = rate(&at(&a, 0.5 * h));
        let c = rate(&at(&b, 0.5 * h));
        let d = rate(&at(&c, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    // From the root, whose tangent is z: turn back by the root's angle.
    let (sin, cos) = y[0].sin_cos();
    Point3::new(y[3] * sin - y[2] * cos, 0.0, -y[3] * cos - y[2] * sin)
}

/// Fig. 3.9: from a quarter over a half circle to an S and beyond, always to second order.
#[test]
fn a_force_that_stays_across_winds_the_rod() {
    for across in [0.1, 1.0, 3.0, 10.0, 20.0, 40.0, 80.0] {
        let error = |count: usize| {
            let chain = with_tip_follower(count, Vector3::x() * across);
            let rest = chain.solve().unwrap_or_else(|e| panic!("{across}: {e}"));
            (rest.shape.positions()[count] - exact(across)).norm()
        };
        let (coarse, fine) = (error(100), error(200));
        assert!((3.5..4.5).contains(&(coarse / fine)), "{across}: {coarse:e} {fine:e}");
        assert!(fine < 1e-5 * (1.0 + across), "{across}: {fine:e}");
    }
}

/// The two-phase integration of the same, to first order.
#[test]
fn two_phases_approximate_followers() {
    for across in [0.1, 1.0, 3.0, 10.0, 20.0, 40.0] {
        let error = |count: usize| {
            let chain = with_tip_follower(count, Vector3::x() * across);
            let shape = chain.two_phase(&chain.natural_shape()).expect("a shape");
            (shape.positions()[count] - exact(across)).norm()
        };
        let (coarse, fine) = (error(400), error(800));
        assert!((1.7..2.4).contains(&(coarse / fine)), "{across}: {coarse:e} {fine:e}");
        assert!(fine < 0.01 * (1.0 + across), "{across}: {fine:e}");
    }
}

/// Dead loads follow in two phases: right where the rod hardly bends, and in its natural shape's
/// axes if it does. Taken in the axes of the equilibrium they give the equilibrium back.
#[test]
fn two_phases_make_followers_of_dead_loads() {
    let mut chain = straight(800);
    let mut forces = vec![Vector3::zeros(); 801];
    forces[800] = Vector3::x();
    let mut errors = [(0.02, 0.0), (1.0, 0.0)];
    for (size, error) in &mut errors {
        forces[800] = Vector3::x() * *size;
        chain.set_forces(&forces).expect("forces");
        let rest = chain.solve().expect("a minimum");
        let off = |shape: &rapunzel_rod_static::Shape| {
            (shape.positions()[800] - rest.shape.positions()[800]).norm()
        };
        *error = off(&chain.two_phase(&chain.natural_shape()).expect("a shape"));
        let again = off(&chain.two_phase(&rest.shape).expect("a shape"));
        assert!(again < 2e-3 * *size, "{size}: {again:e}");
    }
    assert!(errors[0].1 < 1e-4 && errors[1].1 > 1e-2, "{errors:?}");
}

/// Beck 1952: a rod under a thrust that stays along its tip has no other equilibrium than the
/// straight one, at any thrust; it is Newton's method's, from a bent start, too.
#[test]
fn thrust_along_the_tip_does_not_buckle() {
    for thrust in [1.0, 5.0, 15.0] {
        let chain = with_tip_follower(50, -Vector3::z() * thrust);
        let bent: Vec<_> = (1..=50).map(|i| Vector3::y() * (0.001 * f64::from(i))).collect();
        let start = chain.turned(&chain.natural_shape(), &bent).expect("a shape");
        let rest = chain.relax(&start).unwrap_or_else(|e| panic!("{thrust}: {e}"));
        let tip = rest.shape.positions()[50];
        assert!((tip - Point3::new(0.0, 0.0, 1.0)).norm() < 1e-12, "{thrust}: {tip}");
    }
}
