//! Loads at which rods buckle: the index of the straight rod changes there, and bent rods are
//! found beyond.

use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rapunzel_rod_static::{EndCondition, Equilibrium, Piece, Problem, Properties, State};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn piece(stiffness: [f64; 3], load: Vector3<f64>) -> Piece {
    let stiffness = Vector3::from(stiffness);
    Piece::uniform(1.0, Properties { stiffness, natural_curvature: Vector3::zeros(), load })
}

/// The straight equilibrium upright under the load per length `weight` and the thrust `thrust`.
fn upright(weight: f64, thrust: f64) -> Equilibrium {
    let load = Vector3::new(0.0, 0.0, -weight);
    let force = Vector3::new(0.0, 0.0, -thrust);
    let end = EndCondition::Free { force, moment: Vector3::zeros() };
    let problem =
        Problem::new(&Isometry3::identity(), vec![piece([1.0; 3], load)], end).expect("a problem");
    let straight = State {
        position: Point3::origin(),
        frame: Rotation3::identity(),
        force: force + load,
        moment: Vector3::zeros(),
    };
    problem.solve_near(&[(0.0, straight)]).expect("the straight rod")
}

/// Euler's column with a free end: both planes at once, at `pi^2 / 4` and at 9 times that.
#[test]
fn euler_with_a_free_end() {
    for (mode, index) in [(1.0_f64, 2), (3.0, 4), (5.0, 6)] {
        let critical = (mode * FRAC_PI_2).powi(2);
        assert_eq!(upright(0.0, 0.9999 * critical).conjugate_points(), index - 2);
        assert_eq!(upright(0.0, 1.0001 * critical).conjugate_points(), index);
    }
}

/// Greenhill 1881: the first zero of the Bessel function `J_(-1/3)`.
#[test]
fn greenhill() {
    let critical = 7.837_347_439;
    assert!(upright(0.9999 * critical, 0.0).is_stable());
    assert_eq!(upright(1.0001 * critical, 0.0).conjugate_points(), 2);
}

/// Euler's columns between held ends: a rod shortened by `d` carries the critical load up to
/// `O(d)`.
#[test]
fn euler_between_two_ends() {
    let d = 1e-4;
    let top = Point3::new(0.0, 0.0, 1.0 - d);
    let held = Isometry3::from_parts(Translation3::from(top.coords), UnitQuaternion::identity());
    for (end, critical) in
        [(EndCondition::Held(held), 4.0 * PI * PI), (EndCondition::Position(top), 20.190_728_556)]
    {
        let rod = piece([1.0, 2.0, 1.0], Vector3::zeros());
        let problem = Problem::new(&Isometry3::identity(), vec![rod], end).expect("a problem");
        let found = problem.solve().expect("a buckled rod");
        let thrust = -found.root().force.z;
        assert!(found.is_stable(), "{end:?}");
        assert!((thrust / critical - 1.0).abs() < 1e-3, "{end:?}: {thrust} for {critical}");
    }
}

/// A strip on edge leaves its plane: Prandtl and Michell 1899 for a force on the end, Prandtl for
/// its own weight.
#[test]
fn strips_buckle_sideways() {
    // The tangent along x, d1 across and level: stiff against the weight, soft sideways.
    let frame = Rotation3::from_basis_unchecked(&[-Vector3::y(), Vector3::z(), -Vector3::x()]);
    let frame = Rotation3::from_matrix_unchecked(frame.into_inner());
    let clamp = Isometry3::from_parts(
        Translation3::identity(),
        UnitQuaternion::from_rotation_matrix(&frame),
    );
    let (soft, torsion) = (0.5, 0.8);
    let unit = f64::sqrt(soft * torsion);
    let index = |weight: f64, force: f64| {
        let down = |size: f64| Vector3::new(0.0, 0.0, -size * unit);
        let end = EndCondition::Free { force: down(force), moment: Vector3::zeros() };
        let rod = piece([1e4, soft, torsion], down(weight));
        let problem = Problem::new(&clamp, vec![rod], end).expect("a problem");
        let planar = State {
            position: Point3::origin(),
            frame,
            force: down(weight + force),
            moment: Vector3::zeros(),
        };
        problem.solve_near(&[(0.0, planar)]).expect("the planar rod").conjugate_points()
    };
    let (tip, own) = (4.012_599_344, 12.853_763);
    assert_eq!([index(0.0, 0.999 * tip), index(0.0, 1.001 * tip)], [0, 1]);
    assert_eq!([index(0.999 * own, 0.0), index(1.001 * own, 0.0)], [0, 1]);
}

/// Michell 1889, Zajac 1962: a straight rod bent to a ring and joined after a twist of
/// `2 pi sqrt(3) EI / GJ` leaves its plane. The ring may turn about its tangent at the clamp; that
/// way is neutral, below and above.
#[test]
fn a_twisted_ring_leaves_its_plane() {
    for torsion in [0.75, 1.0, 1.4] {
        let critical = TAU * 3.0_f64.sqrt() / torsion;
        let index = |twist: f64| {
            let spin = |s: f64| UnitQuaternion::from_scaled_axis(Vector3::z() * (twist * s));
            let end = Isometry3::from_parts(Translation3::identity(), spin(1.0));
            let rod = piece([1.0, 1.0, torsion], Vector3::zeros());
            let problem = Problem::new(&Isometry3::identity(), vec![rod], EndCondition::Held(end));
            let ring: Vec<(f64, State)> = (0..64)
                .map(|i| {
                    let s = f64::from(i) / 64.0;
                    let (sin, cos) = (TAU * s).sin_cos();
                    let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * (TAU * s));
                    let tangent = Vector3::new(sin, 0.0, cos);
                    let state = State {
                        position: Point3::new((1.0 - cos) / TAU, 0.0, sin / TAU),
                        frame: (turn * spin(s)).to_rotation_matrix(),
                        force: Vector3::y() * (torsion * twist * TAU),
                        moment: Vector3::y() * TAU + tangent * (torsion * twist),
                    };
                    (s, state)
                })
                .collect();
            let found = problem.expect("a problem").solve_near(&ring).expect("the ring");
            assert!(
                (found.elastic_energy() - 0.5 * (TAU * TAU + torsion * twist * twist)).abs() < 1e-9
            );
            found.conjugate_points()
        };
        assert_eq!(index(0.999 * critical), 0, "torsion {torsion}");
        assert_eq!(index(1.001 * critical), 2, "torsion {torsion}");
    }
}

/// Just above the load that buckles an upright rod the stable one leans, in any plane.
#[test]
fn columns_just_above_greenhills_load_lean() {
    for excess in [1e-5, 1e-4, 1e-3, 1e-2, 0.1] {
        let weight = 7.837_347_439 * (1.0 + excess);
        for sides in [[1.0, 1.0], [1.0, 2.0]] {
            let rod = piece([sides[0], sides[1], 1.0], Vector3::new(0.0, 0.0, -weight));
            let problem = Problem::new(&Isometry3::identity(), vec![rod], EndCondition::FREE);
            let found = problem.expect("a problem").solve().expect("an equilibrium");
            assert!(found.is_stable(), "{excess} {sides:?}: {}", found.conjugate_points());
            // Of second order in the lean, whose square grows with the excess.
            let fallen = 1.0 - found.tip().position.z;
            assert!(
                (0.1..10.0).contains(&(fallen / excess.min(0.1))),
                "{excess} {sides:?}: {fallen:e}"
            );
        }
    }
}

/// Arcs between clamps almost at one place, twisted beyond what they bear in their plane.
#[test]
fn twisted_arcs_leave_their_plane() {
    for (gap, part) in [(0.01, 1.1), (0.01, 1.5), (0.1, 1.1), (0.3, 1.2), (0.0, 1.1), (0.0, 0.5)] {
        let twist = part * TAU * 3.0_f64.sqrt();
        // The tangent of the far end is that of the clamp: a closed loop.
        let spin = UnitQuaternion::from_scaled_axis(Vector3::z() * twist);
        let end = Isometry3::from_parts(Translation3::new(0.0, 0.0, gap), spin);
        let rod = piece([1.0; 3], Vector3::zeros());
        let problem = Problem::new(&Isometry3::identity(), vec![rod], EndCondition::Held(end));
        let found = problem.expect("a problem").solve();
        let found = found.unwrap_or_else(|error| panic!("{gap} {part}: {error}"));
        assert!(found.is_stable(), "{gap} {part}: {}", found.conjugate_points());
    }
}

/// An exact ring may lie in any plane: one answer, not one for each start.
#[test]
fn a_ring_is_told_once() {
    for twist in [0.0, 1.0] {
        let spin = UnitQuaternion::from_scaled_axis(Vector3::z() * twist);
        let end = Isometry3::from_parts(Translation3::identity(), spin);
        let rod = piece([1.0; 3], Vector3::zeros());
        let problem = Problem::new(&Isometry3::identity(), vec![rod], EndCondition::Held(end));
        let all = problem.expect("a problem").solutions(0);
        let ring = 0.5 * (TAU * TAU + twist * twist);
        let rings: Vec<f64> = all.iter().map(Equilibrium::energy).collect();
        let count = rings.iter().filter(|e| (*e - ring).abs() < 1e-6).count();
        assert_eq!(count, 1, "twist {twist}: {rings:?} for {ring}");
    }
}
