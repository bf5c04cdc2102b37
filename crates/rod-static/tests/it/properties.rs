//! What must hold for any rod: rigid motion, scaling, reversal, balance; and refusals.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rapunzel_rod_static::{
    EndCondition, Equilibrium, Piece, Problem, Properties, State, StaticError,
};

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-1.0..1.0_f64).prop_map(move |v| Vector3::from(v) * size)
}

fn pose() -> impl Strategy<Value = Isometry3<f64>> {
    (vector(3.0), vector(2.0)).prop_map(|(translation, turn)| Isometry3::new(translation, turn))
}

/// A curved, anisotropic, tapered rod with a weight and a mass in its middle, in units `length` and
/// `stiffness`, its loads in the frame `frame`.
fn pieces(
    curvature: Vector3<f64>,
    load: Vector3<f64>,
    length: f64,
    stiffness: f64,
    frame: UnitQuaternion<f64>,
) -> Vec<Piece> {
    let force = stiffness / (length * length);
    let properties = move |s: f64| Properties {
        stiffness: Vector3::new(1.0, 0.7, 0.8) * stiffness * (1.0 - 0.3 * s / length),
        natural_curvature: curvature / length,
        load: frame * load * (force / length),
    };
    let mass = frame * load * (0.3 * force);
    vec![
        Piece::varying(0.4 * length, properties).with_end_load(mass),
        Piece::varying(0.6 * length, properties),
    ]
}

fn solve(clamp: &Isometry3<f64>, pieces: Vec<Piece>, end: EndCondition) -> Equilibrium {
    let problem = Problem::new(clamp, pieces, end).expect("a problem");
    problem.solve().expect("an equilibrium")
}

/// The pose of a state.
fn pose_of(state: &State) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::from(state.position.coords),
        UnitQuaternion::from_rotation_matrix(&state.frame),
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// A moved and scaled input gives the moved and scaled rod.
    #[test]
    fn rigid_motion_and_scaling(
        curvature in vector(3.0),
        load in vector(6.0),
        moved in pose(),
        length in 0.01..10.0_f64,
        stiffness in 1e-6..1e3_f64,
    ) {
        let unit = pieces(curvature, load, 1.0, 1.0, UnitQuaternion::identity());
        let plain = solve(&Isometry3::identity(), unit, EndCondition::FREE);
        let scaled = pieces(curvature, load, length, stiffness, moved.rotation);
        let other = solve(&moved, scaled, EndCondition::FREE);
        for s in [0.0, 0.2, 0.4, 0.77, 1.0] {
            let (a, b) = (plain.at(s), other.at(s * length));
            let position = moved * Point3::from(a.position.coords * length);
            prop_assert!((position - b.position).norm() < 1e-9 * length);
            let moment = moved.rotation * a.moment * (stiffness / length);
            prop_assert!((moment - b.moment).norm() < 1e-8 * stiffness / length);
        }
        let energy = other.elastic_energy() * length / stiffness;
        prop_assert!((energy - plain.elastic_energy()).abs() < 1e-9);
        prop_assert!((other.root().force - moved.rotation * load * (1.3 * stiffness / length.powi(2))).norm() < 1e-9 * stiffness / length.powi(2));
    }

    /// The rod held where another one ends carries the same, and so does it from the other end.
    #[test]
    fn held_and_reversed(curvature in vector(2.0), load in vector(4.0), force in vector(3.0)) {
        let rod = || pieces(curvature, load, 1.0, 1.0, UnitQuaternion::identity());
        let end = EndCondition::Free { force, moment: Vector3::zeros() };
        let free = solve(&Isometry3::identity(), rod(), end);
        let held = Problem::new(&Isometry3::identity(), rod(), EndCondition::Held(pose_of(&free.tip())));
        let held = held.expect("a problem").solve_from(&free).expect("the same equilibrium");
        prop_assert!((held.root().force - free.root().force).norm() < 1e-7);
        prop_assert!((held.tip().moment - free.tip().moment).norm() < 1e-7);
        prop_assert!(held.conjugate_points() <= free.conjugate_points());
        // Backward the tangent is -d3: turned about d1, and so are the curvatures.
        let turn = Rotation3::from_matrix_unchecked(Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)));
        let properties = move |s: f64| Properties {
            stiffness: Vector3::new(1.0, 0.7, 0.8) * (1.0 - 0.3 * (1.0 - s)),
            natural_curvature: -(turn * curvature),
            load,
        };
        let back = vec![
            Piece::varying(0.6, properties).with_end_load(0.3 * load),
            Piece::varying(0.4, properties),
        ];
        let backward = |state: &State| State {
            frame: state.frame * turn,
            force: -state.force,
            moment: -state.moment,
            ..*state
        };
        let guess: Vec<_> = (0..=10).map(|i| {
            let s = f64::from(i) / 10.0;
            (s, backward(&held.at(1.0 - s)))
        }).collect();
        let start = pose_of(&backward(&held.tip()));
        let end = EndCondition::Held(pose_of(&backward(&held.root())));
        let reversed = Problem::new(&start, back, end).expect("a problem").solve_near(&guess);
        let reversed = reversed.expect("the same equilibrium");
        prop_assert!((reversed.tip().moment + held.root().moment).norm() < 1e-7);
        prop_assert!((reversed.energy() - held.energy()).abs() < 1e-8);
        prop_assert_eq!(reversed.conjugate_points(), held.conjugate_points());
    }

    /// Without loads `m + r x n` is the same all along.
    #[test]
    fn moments_balance(curvature in vector(4.0), force in vector(10.0), moment in vector(3.0)) {
        let rod = pieces(curvature, Vector3::zeros(), 1.0, 1.0, UnitQuaternion::identity());
        let found = solve(&Isometry3::identity(), rod, EndCondition::Free { force, moment });
        let total = |s: f64| {
            let at = found.at(s);
            at.moment + at.position.coords.cross(&at.force)
        };
        for s in [0.1, 0.37, 0.4, 0.9, 1.0] {
            prop_assert!((total(s) - total(0.0)).norm() < 1e-9);
        }
    }
}

#[test]
fn nonsense_is_refused() {
    let good = Properties {
        stiffness: Vector3::new(1.0, 1.0, 1.0),
        natural_curvature: Vector3::zeros(),
        load: Vector3::zeros(),
    };
    let refused = |pieces: Vec<Piece>, end: EndCondition| {
        Problem::new(&Isometry3::identity(), pieces, end).expect_err("refused")
    };
    assert_eq!(refused(vec![], EndCondition::FREE), StaticError::NoPieces);
    for length in [0.0, -1.0, f64::NAN] {
        let error = refused(vec![Piece::uniform(length, good)], EndCondition::FREE);
        assert!(matches!(error, StaticError::NotPositive { .. }), "{error}");
    }
    let stiffness = Vector3::new(1.0, -1.0, 1.0);
    let error =
        refused(vec![Piece::uniform(1.0, Properties { stiffness, ..good })], EndCondition::FREE);
    assert!(matches!(error, StaticError::NotPositive { .. }), "{error}");
    let load = Vector3::new(0.0, f64::INFINITY, 0.0);
    let error = refused(vec![Piece::uniform(1.0, Properties { load, ..good })], EndCondition::FREE);
    assert!(matches!(error, StaticError::NotFinite { .. }), "{error}");
    let far = EndCondition::Position(Point3::new(0.0, 2.0, 0.0));
    let error = refused(vec![Piece::uniform(1.0, good)], far);
    assert_eq!(error, StaticError::OutOfReach { distance: 2.0, length: 1.0 });
}
