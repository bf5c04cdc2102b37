//! Branches that leave another one at a bifurcation, against closed forms.

use nalgebra::{Isometry3, Vector3};
use rapunzel_rod_static::elliptic::{first_kind, second_kind};
use rapunzel_rod_static::{
    BranchEnd, EndCondition, LimitKind, ParameterSweep, Piece, Problem, Properties, StaticError,
};
use std::f64::consts::FRAC_PI_2;

/// An upright column of length 1 with these bending stiffnesses, under a load on its top.
fn column(bending: [f64; 2]) -> impl Fn(f64) -> Result<Problem, StaticError> {
    move |load: f64| {
        let stiffness = Vector3::new(bending[0], bending[1], 1.0);
        let zero = Vector3::zeros();
        let rod = Properties { stiffness, natural_curvature: zero, load: zero };
        let end = EndCondition::Free { force: Vector3::new(0.0, 0.0, -load), moment: zero };
        Problem::new(&Isometry3::identity(), vec![Piece::uniform(1.0, rod)], end)
    }
}

/// How far the top is aside and how high, by the elastica of bending stiffness 1: the modulus is
/// that whose quarter period is the root of the load.
fn elastica(load: f64) -> [f64; 2] {
    let period = |k: f64| first_kind(FRAC_PI_2, k * k).expect("a modulus");
    let (mut low, mut high) = (0.0, 1.0 - 1e-12);
    for _ in 0..200 {
        let k = 0.5 * (low + high);
        if period(k) < load.sqrt() { low = k } else { high = k }
    }
    let height = 2.0 * second_kind(FRAC_PI_2, low * low).expect("a modulus") - period(low);
    [2.0 * low / load.sqrt(), height / load.sqrt()]
}

/// Past its critical load a column goes aside as the elastica: a branch to each side, on which the
/// load grows from the first point on and the column is stable, whether it may buckle in one plane
/// or in any.
#[test]
fn a_column_goes_on_bent() {
    for bending in [[1.0, 2.0], [1.0, 1.0]] {
        let problem = column(bending);
        let start = problem(0.0).and_then(|rod| rod.solve()).expect("a straight column");
        let sweep = ParameterSweep { problem: &problem, from: 0.0, to: 6.0, steps: 12 };
        let ends = [false, true].map(|against| {
            let branch = sweep.follow_other(&start, 0, against).expect("a branch");
            assert_eq!(branch.ended, BranchEnd::Reached);
            let limit = &branch.limits[0];
            assert_eq!((branch.limits.len(), limit.kind), (1, LimitKind::Bifurcation));
            let first = branch.switched.expect("another branch");
            assert!(branch.points[..first].iter().all(|one| one.parameter < limit.parameter));
            let mut before = limit.parameter;
            for point in &branch.points[first..] {
                assert!(point.parameter > before, "{before} {}", point.parameter);
                before = point.parameter;
                let top = point.equilibrium.at(1.0).position;
                let [aside, height] = elastica(point.parameter);
                let found = [top.x.hypot(top.y), top.z];
                assert!((found[0] - aside).abs() < 1e-8, "{before}: {} {aside}", found[0]);
                assert!((found[1] - height).abs() < 1e-8, "{before}: {} {height}", found[1]);
                assert!(point.equilibrium.is_stable(), "{bending:?} {before}");
            }
            branch.points[branch.points.len() - 1].equilibrium.at(1.0).position
        });
        // To the two sides of one plane.
        let [one, other] = ends.map(|end| end.coords.xy().normalize());
        assert!((one + other).norm() < 1e-6, "{one} {other}");
    }
}

#[test]
fn a_bifurcation_that_is_not_met_is_told() {
    let problem = column([1.0, 2.0]);
    let start = problem(0.0).and_then(|rod| rod.solve()).expect("a straight column");
    let sweep = ParameterSweep { problem: &problem, from: 0.0, to: 2.0, steps: 5 };
    let found = sweep.follow_other(&start, 0, false).map(|_| ());
    assert_eq!(found, Err(StaticError::NoBifurcation { asked: 0, met: 0 }));
}
