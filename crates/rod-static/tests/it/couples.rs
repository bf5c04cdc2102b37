//! A couple that follows the end, and the derivatives of equilibria by the loads on the end.

use nalgebra::{Isometry3, Point3, Vector3};
use proptest::prelude::*;
use rapunzel_rod_static::{
    Chain, Lagrange, Piece, Properties, Rest, ShapeDerivatives, ShapeResponse, StaticError, Target,
};

const STIFFNESS: Vector3<f64> = Vector3::new(1.0, 1.0, 0.75);

fn straight(count: usize, force: Vector3<f64>, couple: Vector3<f64>) -> Chain {
    let properties = Properties {
        stiffness: STIFFNESS,
        natural_curvature: Vector3::zeros(),
        load: Vector3::zeros(),
    };
    let piece = Piece::uniform(1.0, properties).with_end_load(force);
    let mut chain = Chain::new(&Isometry3::identity(), &[piece], count).expect("a chain");
    chain.set_tip_couple(&couple).expect("a couple");
    chain
}

/// A couple across the end bends to the arc of a circle, one along it twists: exactly, as segments
/// of constant curvature can.
#[test]
fn a_couple_alone_gives_its_curvature() {
    for couple in [Vector3::x() * 0.3, Vector3::y() * -5.0, Vector3::z() * 12.0] {
        let chain = straight(20, Vector3::zeros(), couple);
        let rest = chain.solve().unwrap_or_else(|e| panic!("{couple}: {e}"));
        let curvature = couple.component_div(&STIFFNESS);
        for found in chain.curvatures(&rest.shape) {
            assert!((found - curvature).norm() < 1e-12 * curvature.norm(), "{couple}: {found}");
        }
        let (axis, angle) = (curvature.normalize(), curvature.norm());
        let [sin, cos] = [angle.sin(), angle.cos()];
        let across = axis.cross(&Vector3::z());
        let arc = across * ((1.0 - cos) / angle) + Vector3::z() * (sin / angle);
        let tip = if across.norm() > 0.5 { arc } else { Vector3::z() };
        assert!((rest.shape.positions()[20].coords - tip).norm() < 1e-12, "{couple}");
        let end = chain.states(&rest)[20];
        assert!((end.frame.inverse() * end.moment - couple).norm() < 1e-12 * angle, "{couple}");
        // Pai's two phases take the couple too.
        let phases = chain.two_phase(&rest.shape).expect("a shape");
        assert!((phases.positions()[20].coords - tip).norm() < 1e-12, "{couple}");
    }
}

/// Lagrange's rod, from the end's state back to the clamp, to second order: helices without a
/// force, and all else.
#[test]
fn force_and_couple_make_the_rod_of_lagrange() {
    let cases = [
        ([0.0, 0.0, 0.0], [3.0, 0.0, 4.0]),
        ([0.0, 0.0, 0.0], [-1.0, 6.0, -2.0]),
        ([2.0, 0.5, -3.0], [0.7, -1.5, 1.0]),
        ([-5.0, 4.0, 8.0], [2.0, 2.0, -3.0]),
    ];
    for (force, couple) in cases {
        let (force, couple) = (Vector3::from(force), Vector3::from(couple));
        let error = |count: usize| {
            let chain = straight(count, force, couple);
            let rest = chain.solve().unwrap_or_else(|e| panic!("{force} {couple}: {e}"));
            let mut end = chain.states(&rest)[count];
            end.force = force;
            end.moment = end.frame * couple;
            let exact = Lagrange::new(STIFFNESS.x, STIFFNESS.z, 0.0, &end).expect("a rod");
            exact.at(-1.0).position.coords.norm()
        };
        let (coarse, fine) = (error(60), error(120));
        assert!(fine < 2e-3, "{force} {couple}: {fine:e}");
        assert!((3.7..4.3).contains(&(coarse / fine)), "{force} {couple}: {coarse:e} {fine:e}");
    }
}

/// A functional of a shape: positions and curvatures squared, tangents times a direction.
struct Functional {
    place: Point3<f64>,
    direction: Vector3<f64>,
    curvature: Vector3<f64>,
}

impl Functional {
    fn value(&self, chain: &Chain, rest: &Rest) -> f64 {
        let shape = &rest.shape;
        let positions = shape.positions().iter().map(|at| (at - self.place).norm_squared());
        let tangents =
            shape.frames().iter().map(|frame| (frame * Vector3::z()).dot(&self.direction));
        let bends = chain.curvatures(shape);
        let bends = bends.iter().map(|bend| (bend - self.curvature).norm_squared());
        positions.sum::<f64>() + tangents.sum::<f64>() + 0.1 * bends.sum::<f64>()
    }

    /// The change of the value by a change of the shape.
    fn change(&self, chain: &Chain, rest: &Rest, response: &ShapeResponse) -> f64 {
        let by = self.derivatives(chain, rest);
        let sum = |by: &[Vector3<f64>], change: &[Vector3<f64>]| {
            by.iter().zip(change).map(|(by, change)| by.dot(change)).sum::<f64>()
        };
        sum(&by.positions, &response.positions)
            + sum(&by.tangents, &response.tangents)
            + sum(&by.curvatures, &response.curvatures)
    }

    fn derivatives(&self, chain: &Chain, rest: &Rest) -> ShapeDerivatives {
        let bends = chain.curvatures(&rest.shape);
        ShapeDerivatives {
            positions: rest.shape.positions().iter().map(|at| (at - self.place) * 2.0).collect(),
            tangents: vec![self.direction; bends.len() + 1],
            curvatures: bends.iter().map(|bend| (bend - self.curvature) * 0.2).collect(),
        }
    }
}

/// The equilibrium of a curved rod with a load of its own under the given loads on its end.
fn loaded(targets: &[Target], force: Vector3<f64>, couple: Vector3<f64>) -> Chain {
    let piece = Piece::varying(1.2, |s| Properties {
        stiffness: Vector3::new(1.0 + s, 0.8, 0.9 - 0.2 * s),
        natural_curvature: Vector3::new(1.0, -s, 0.5),
        load: Vector3::new(0.3, 0.2, -1.0),
    });
    let clamp = Isometry3::new(Vector3::new(0.1, 0.2, -0.3), Vector3::new(0.4, -0.8, 0.3));
    let mut chain = Chain::new(&clamp, &[piece.with_end_load(force)], 16).expect("a chain");
    chain.set_tip_couple(&couple).expect("a couple");
    chain.set_targets(targets).expect("targets");
    chain
}

/// The largest difference between the adjoint's derivatives and extrapolated central differences of
/// equilibria, relative to the largest derivative, or to 0.1.
fn derivative_error(
    targets: &[Target],
    functional: &Functional,
    force: Vector3<f64>,
    couple: Vector3<f64>,
) -> f64 {
    let chain = loaded(targets, force, couple);
    let rest = chain.solve().expect("an equilibrium");
    let by = functional.derivatives(&chain, &rest);
    let by = chain.by_rotations(&rest.shape, &by).expect("derivatives");
    let exact = chain.end_load_derivatives(&rest, &by).expect("derivatives");
    let responses = chain.end_load_responses(&rest).expect("responses");
    for (response, adjoint) in responses.iter().zip(exact.force.iter().chain(&exact.couple)) {
        let forward = functional.change(&chain, &rest, response);
        assert!((forward - adjoint).abs() < 1e-9 * (1.0 + adjoint.abs()), "{forward} {adjoint}");
    }
    let value = |axis: usize, h: f64| {
        let mut loads = [force, couple];
        loads[axis / 3][axis % 3] += h;
        let chain = loaded(targets, loads[0], loads[1]);
        functional.value(&chain, &chain.relax_nearby(&rest.shape).expect("an equilibrium"))
    };
    let error = |axis: usize| {
        let slope = |h: f64| (value(axis, h) - value(axis, -h)) / (2.0 * h);
        let difference = (4.0 * slope(1e-3) - slope(2e-3)) / 3.0;
        ([exact.force, exact.couple][axis / 3][axis % 3] - difference).abs()
    };
    let size = exact.force.norm().max(exact.couple.norm()).max(0.1);
    (0..6).map(error).fold(0.0, f64::max) / size
}

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    let x = prop_oneof![Just(0.0), -1.0..1.0_f64];
    prop::array::uniform3(x).prop_map(move |v| Vector3::from(v) * size)
}

proptest! {
    /// Loads for which the equilibrium exists; a couple that follows may leave none.
    #[test]
    fn the_adjoint_gives_the_derivatives_by_the_end_loads(
        force in vector(1.0),
        couple in vector(0.8),
        place in vector(2.0),
        direction in vector(1.0),
        curvature in vector(3.0),
    ) {
        let functional = Functional { place: place.into(), direction, curvature };
        let error = derivative_error(&[], &functional, force, couple);
        prop_assert!(error < 1e-6, "{error:e}");
    }
}

/// Springs and held nodes take their part of the loads.
#[test]
fn the_adjoint_knows_the_targets() {
    let functional = Functional {
        place: Point3::new(0.3, -0.2, 0.4),
        direction: Vector3::new(1.0, 2.0, -0.5),
        curvature: Vector3::new(0.5, 1.0, -1.0),
    };
    let (force, couple) = (Vector3::new(0.5, -0.8, 0.3), Vector3::new(0.6, 0.3, -0.4));
    let middle = loaded(&[], force, couple).solve().expect("an equilibrium").shape.positions()[8];
    let place = middle + Vector3::new(0.02, 0.03, -0.05);
    for target in [Target::pulled(8, place, 20.0), Target::held(8, place)] {
        let error = derivative_error(&[target], &functional, force, couple);
        assert!(error < 1e-8, "{target:?}: {error:e}");
    }
}

#[test]
fn what_has_no_derivatives_is_refused() {
    let mut chain = straight(4, Vector3::x(), Vector3::y());
    let nan = Vector3::new(0.0, f64::NAN, 0.0);
    assert!(matches!(chain.set_tip_couple(&nan), Err(StaticError::NotFinite { .. })));
    let rest = chain.solve().expect("an equilibrium");
    let short = ShapeDerivatives::zeros(3);
    assert!(matches!(
        chain.by_rotations(&rest.shape, &short),
        Err(StaticError::WrongCount { nodes: 5, .. })
    ));
    let by = vec![Vector3::x(); 4];
    assert!(chain.end_load_derivatives(&rest, &by[1..]).is_err());
    chain.set_followers(&[Vector3::x(); 5]).expect("followers");
    let refused = chain.end_load_responses(&rest);
    assert!(matches!(refused, Err(StaticError::NoDerivative { .. })), "{refused:?}");
    let refused = chain.end_load_derivatives(&rest, &by);
    assert!(matches!(refused, Err(StaticError::NoDerivative { .. })), "{refused:?}");
}

/// Newton's method from nearby finds what the whole search finds, and a chain of warm starts does
/// not drift.
#[test]
fn warm_starts_stay_rotations() {
    let chain = loaded(&[], Vector3::new(0.5, -0.8, 0.3), Vector3::new(0.6, 0.3, -0.4));
    let rest = chain.solve().expect("an equilibrium").shape;
    let mut shape = rest.clone();
    for i in 0..200_u32 {
        let next = if i % 2 == 0 { chain.relax(&shape) } else { chain.relax_nearby(&shape) };
        shape = next.expect("an equilibrium").shape;
    }
    for (frame, first) in shape.frames().iter().zip(rest.frames()) {
        assert!((frame.into_inner().norm() - 1.0).abs() < 1e-14);
        assert!(frame.angle_to(first) < 1e-12);
    }
    // From a shape on the other side of the clamp there is nothing nearby.
    let far = vec![Vector3::new(0.0, 3.0, 1.0); 16];
    let far = chain.turned(&chain.natural_shape(), &far).expect("a shape");
    let strong = loaded(&[], Vector3::new(0.0, 0.0, 900.0), Vector3::zeros());
    assert!(matches!(strong.relax_nearby(&far), Err(StaticError::NotConverged { .. })));
}
