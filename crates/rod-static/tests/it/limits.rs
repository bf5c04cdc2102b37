//! The closed form in and near its limits against the equations: random starts whose force,
//! moment and tangent are aligned, nearly aligned, or nothing.

use nalgebra::{Isometry3, Point3, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rapunzel_fiber::so3;
use rapunzel_rod_static::{EndCondition, Lagrange, Piece, Problem, Properties, State};

/// Nothing, something tiny, or something.
fn size() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), (-17.0..0.0_f64).prop_map(|e| 10f64.powf(e)), 0.0..4.0_f64]
}

fn signed() -> impl Strategy<Value = f64> {
    (size(), prop::bool::ANY).prop_map(|(x, negative)| if negative { -x } else { x })
}

/// A start whose tangent is z: a force along it and across it, a moment along it and across it.
fn start() -> impl Strategy<Value = State> {
    (signed(), signed(), signed(), signed(), signed(), -3.0..3.0_f64).prop_map(
        |(along, across, torque, bend, other, spin)| State {
            position: Point3::new(0.3, -0.2, 0.1),
            frame: so3::exp(&(Vector3::z() * spin)),
            force: Vector3::new(across, 0.0, 3.0 * along),
            moment: Vector3::new(bend, other, torque),
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// The rod with the same force and moment on its end, integrated by Runge-Kutta steps.
    #[test]
    fn agrees_with_integration(start in start(), torsion in 0.3..2.0_f64, twist in signed()) {
        let closed = Lagrange::new(1.0, torsion, twist, &start).expect("a rod");
        let end = closed.at(2.0);
        let properties = Properties {
            stiffness: Vector3::new(1.0, 1.0, torsion),
            natural_curvature: Vector3::new(0.0, 0.0, twist),
            load: Vector3::zeros(),
        };
        let clamp = Isometry3::from_parts(
            start.position.coords.into(),
            UnitQuaternion::from_rotation_matrix(&start.frame),
        );
        let free = EndCondition::Free { force: end.force, moment: end.moment };
        let problem = Problem::new(&clamp, vec![Piece::uniform(2.0, properties)], free);
        let found = problem.expect("a problem").solve_near(&[(0.0, start)]);
        // A rod at the point of buckling has no answer; the closed form does.
        if let Ok(found) = found {
            // What the end's moment has for rounding, the rod near the saddle has magnified.
            for s in [0.7, 2.0] {
                let (a, b) = (closed.at(s), found.at(s));
                prop_assert!((a.position - b.position).norm() < 1e-8, "{} {}", a.position, b.position);
                prop_assert!((a.frame.matrix() - b.frame.matrix()).norm() < 1e-8);
                prop_assert!((a.moment - b.moment).norm() < 1e-8);
            }
        }
    }

    /// A rod that is followed forward, turned and followed back arrives where it began; and the
    /// sum of two ways is the way in one.
    #[test]
    fn ways_add_up(start in start(), torsion in 0.3..2.0_f64, s in -3.0..3.0_f64, t in -3.0..3.0_f64) {
        let rod = Lagrange::new(1.0, torsion, 0.0, &start).expect("a rod");
        let there = rod.at(s);
        let on = Lagrange::new(1.0, torsion, 0.0, &there).expect("a rod").at(t);
        let whole = rod.at(s + t);
        prop_assert!((on.position - whole.position).norm() < 1e-9, "{} {}", on.position, whole.position);
        prop_assert!((on.frame.matrix() - whole.frame.matrix()).norm() < 1e-9);
        prop_assert!((on.moment - whole.moment).norm() < 1e-9);
    }
}

/// A straight rod along its force only twists.
#[test]
fn a_straight_rod_twists() {
    for force in [-2.0, 0.0, 3.0] {
        let start = State {
            position: Point3::origin(),
            frame: Rotation3::identity(),
            force: Vector3::z() * force,
            moment: Vector3::z() * 0.6,
        };
        let rod = Lagrange::new(2.0, 1.5, 0.1, &start).expect("a rod");
        let at = rod.at(4.0);
        assert!((at.position - Point3::new(0.0, 0.0, 4.0)).norm() < 1e-15);
        let twist = so3::exp(&(Vector3::z() * (4.0 * (0.6 / 1.5 + 0.1))));
        assert!((at.frame.matrix() - twist.matrix()).norm() < 1e-15);
        assert_eq!(rod.roots(), None);
    }
}

/// The separatrix itself, the localized helix of a long rod under tension and twist:
/// `1 - z = (2 - m^2 / 2) sech^2(sqrt(1 - m^2 / 4) s)` with `m = M / sqrt(B T)`.
#[test]
fn the_separatrix_is_localized() {
    for moment in [0.0, 0.3, 1.0, 1.7] {
        let height = 2.0 - 0.5 * moment * moment;
        let (z, sine) = (1.0 - height, f64::sqrt(height * (2.0 - height)));
        let tangent = Vector3::new(sine, 0.0, z);
        let frame = so3::exp(&(Vector3::y() * sine.atan2(z)));
        assert!((frame * Vector3::z() - tangent).norm() < 1e-15);
        // Through the antipode (moment zero) the rod bends at the rate 2; else it turns there.
        let bend = if moment > 0.0 {
            Vector3::new(moment * height / sine, 0.0, moment)
        } else {
            Vector3::new(0.0, 2.0, 0.0)
        };
        let force = Vector3::z();
        let start = State { position: Point3::origin(), frame, force, moment: bend };
        let rod = Lagrange::new(1.0, 0.8, 0.0, &start).expect("a rod");
        let rate = f64::sqrt(1.0 - 0.25 * moment * moment);
        for i in -16..=16 {
            let s = 0.5 * f64::from(i);
            let expected = 1.0 - height / (rate * s).cosh().powi(2);
            let found = (rod.at(s).frame * Vector3::z()).z;
            // Off the separatrix by a rounding error, the rod leaves it exponentially.
            let allowed = 1e-15 * (2.0 * rate * s.abs()).exp() + 1e-14;
            assert!((found - expected).abs() < allowed, "m {moment}, s {s}: {found}, {expected}");
            assert!((rod.at(s).frame * Vector3::z()).norm() - 1.0 < 1e-14);
        }
    }
}
