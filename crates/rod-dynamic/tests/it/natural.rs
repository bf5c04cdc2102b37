//! The natural shape that lets a fibre rest in a given one.

use nalgebra::{DVector, Isometry3, MatrixXx6, Point3, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rapunzel_fiber::{Fiber, Material, NodeProperties, Section, so3};
use rapunzel_rod_dynamic::{
    End, Instant, Load, Rod, RodIntegrator, RodState, Staggered, Steady, equilibrium, fitted,
    fitted_end_load, natural_curvatures,
};
use rapunzel_rod_static::{Chain, Piece, Properties};

const GRAVITY: Vector3<f64> = Vector3::new(0.0, -9.81, 0.0);

/// A hair of 35 um radius with a length of segment of its own each.
fn hair(length: f64, segments: usize) -> Fiber {
    let material = Material { density: 1300.0, youngs_modulus: 3.8e9, shear_modulus: 0.9e9 };
    let section = Section::Ellipse { a: 40e-6, b: 30e-6 };
    let node = NodeProperties::new(section, &material);
    let weights: Vec<f64> = (0..segments).map(|i| 1.0 + 0.3 * (i as f64 * 1.7).sin()).collect();
    let total: f64 = weights.iter().sum();
    let lengths = weights.iter().map(|w| length * w / total).collect();
    Fiber::new(Isometry3::identity(), lengths, vec![node; segments + 1]).expect("a fibre")
}

/// A smooth curve of frames: bent and twisted by `wave`, rad, over the length.
fn style(fiber: &Fiber, wave: [f64; 3]) -> RodState {
    let n = fiber.segments();
    let mut state = Staggered::new(Rod::new(fiber.clone())).expect("a rod").state();
    let mut frame = Rotation3::from_euler_angles(0.3, -0.2, 0.1);
    let mut at = Point3::new(0.01, 0.02, 0.03);
    for e in 0..n {
        let t = e as f64 / n as f64;
        let turn = Vector3::new(wave[0] * (3.0 * t).cos(), wave[1] * (1.0 - t), wave[2] * t);
        frame *= so3::exp(&(turn / n as f64));
        state.frames[e] = frame;
        state.positions[e] = at;
        at += frame * Vector3::z() * fiber.segment_lengths()[e];
    }
    state.positions[n] = at;
    state
}

fn clamped(state: &RodState) -> Instant {
    let rotation = UnitQuaternion::from_rotation_matrix(&state.frames[0]);
    Instant::clamped(Isometry3::from_parts(state.positions[0].into(), rotation), GRAVITY)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Handed to the dynamics, nothing moves: 0.1 s, every node less than 1e-6 of the length.
    #[test]
    fn a_style_rests(
        wave in prop::array::uniform3(-2.0..2.0_f64),
        pull in prop::array::uniform3(-1e-6..1e-6_f64),
        couple in prop::array::uniform3(-1e-9..1e-9_f64),
        length in 0.02..0.12_f64,
        segments in 2..40_usize,
    ) {
        let fiber = hair(length, segments);
        let state = style(&fiber, wave);
        let tip = End::Loaded { force: Load::World(pull.into()), moment: Load::Follower(couple.into()) };
        let conditions = Instant { tip, ..clamped(&state) };
        let kappas = natural_curvatures(&fiber, &state, &conditions, &[]).expect("a held root");
        let fiber = fiber.with_node_curvatures(&kappas).expect("finite");
        let mut rod = Staggered::new(Rod::damped(fiber, 1e-3)).expect("a rod");
        rod.set_state(&state).expect("fits");
        for _ in 0..100 {
            rod.step(1e-3, &Steady(conditions)).expect("a step");
        }
        for (a, b) in rod.state().positions.iter().zip(&state.positions) {
            prop_assert!((a - b).norm() < 1e-6 * length, "{} m", (a - b).norm());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_load_that_bent_a_fibre_is_found(
        force in prop::array::uniform3(-3.0..3.0_f64),
        couple in prop::array::uniform3(-2.0..2.0_f64),
        segments in 8..40_usize,
    ) {
        assert_found(force, couple, segments);
    }
}

/// Loads in which two directions have a ten thousandth of the effect of the others, or less.
#[test]
fn loads_are_found_that_a_fibre_hardly_feels() {
    let cases = [
        (
            [-1.8173152887, 2.1688848843, -0.1754669241],
            [-0.3228873235, -0.6491767783, -1.4328927655],
            18,
        ),
        (
            [0.8310139814, 0.7801884242, -2.8929515162],
            [1.5068217487, -1.8587561071, 0.3455779967],
            11,
        ),
        (
            [-2.4619146328, -0.2822597225, -1.1627026372],
            [-1.6825893639, 1.7486949395, -0.7239374224],
            8,
        ),
    ];
    for (force, couple, segments) in cases {
        assert!(assert_found(force, couple, segments), "{force:?}");
    }
}

/// Curvatures at all joints by the roots of their lengths: squares add up to the integral of that
/// of the curvature.
fn weighted(fiber: &Fiber, curvatures: &[Vector3<f64>]) -> DVector<f64> {
    let h = fiber.segment_lengths();
    let length = |e: usize| if e == 0 { 0.5 * h[0] } else { 0.5 * (h[e - 1] + h[e]) };
    let row = |k: usize, _| length(k / 3).sqrt() * curvatures[k / 3][k % 3];
    DVector::from_fn(3 * h.len(), row)
}

/// A naturally straight fibre is bent by a dead force, in units of `B / L^2`, and a following
/// couple, `B / L`; false if it has no equilibrium. The load found leaves no more to natural
/// curvature than this one, `e`, which is as far as the equilibrium goes, and rounding: the effects
/// `A` of both differ by no more, and loads by that over the least singular value of `A`.
fn assert_found(force: [f64; 3], couple: [f64; 3], segments: usize) -> bool {
    let fiber = hair(0.06, segments);
    let (length, stiffness) = (fiber.length(), fiber.nodes()[0].stiffness.x);
    let units = [stiffness / length.powi(2), stiffness / length];
    let clamp = Instant::clamped(Isometry3::identity(), Vector3::zeros());
    let loaded = |[force, moment]: [Vector3<f64>; 2]| {
        let (force, moment) = (Load::World(force * units[0]), Load::Follower(moment * units[1]));
        Instant { tip: End::Loaded { force, moment }, ..clamp }
    };
    let given = [force, couple].map(Vector3::from);
    let straight = Staggered::new(Rod::new(fiber.clone())).expect("a rod").state();
    let bent = equilibrium(&Rod::new(fiber.clone()), &loaded(given), &straight);
    // A couple may have no equilibrium.
    let Ok((state, _)) = bent else { return false };
    // Linear in loads that do not follow what natural curvature turns.
    let left = |[force, moment]: [Vector3<f64>; 2]| {
        let mut dead = loaded([force, Vector3::zeros()]);
        if let End::Loaded { moment: own, .. } = &mut dead.tip {
            *own = Load::World(state.frames[segments - 1] * moment * units[1]);
        }
        let curvatures = natural_curvatures(&fiber, &state, &dead, &[]);
        weighted(&fiber, &curvatures.expect("finite"))
    };
    let found = fitted_end_load(&fiber, &state, &clamp, &[]).expect("a load");
    let End::Loaded { force: Load::World(f), moment: Load::Follower(m) } = found else {
        panic!("a dead force and a following couple");
    };
    let found = [f / units[0], m / units[1]];
    let none = [Vector3::zeros(); 2];
    let drawn = left(none);
    let mut effects = MatrixXx6::zeros(drawn.len());
    for k in 0..6 {
        let mut unit = none;
        unit[k / 3][k % 3] = 1.0;
        effects.set_column(k, &(&drawn - left(unit)));
    }
    let values = effects.singular_values();
    let (least, largest) = (values.min(), values.max());
    let (size, off) = (given[0].norm() + given[1].norm(), [0, 1].map(|k| found[k] - given[k]));
    // Each effect is a difference of curvatures of some hundred operations.
    let rounding = 1e2 * f64::EPSILON * (drawn.norm() + largest * size);
    let most = left(given).norm() + rounding;
    assert!(most < 1e-9 * drawn.norm(), "{most} of {}", drawn.norm());
    assert!(left(found).norm() <= most, "{} {most}", left(found).norm());
    let off = off[0].norm().hypot(off[1].norm());
    assert!(off <= most / least, "{off} {most} {least} {largest}");
    true
}

/// A load without an effect is none: a force along a straight fibre.
#[test]
fn a_straight_fibre_needs_no_load() {
    let fiber = hair(0.06, 12);
    let state = Staggered::new(Rod::new(fiber.clone())).expect("a rod").state();
    let conditions = Instant::clamped(Isometry3::identity(), Vector3::zeros());
    let End::Loaded { force, moment } =
        fitted_end_load(&fiber, &state, &conditions, &[]).expect("a load")
    else {
        panic!("a load");
    };
    assert!(force.components().norm() < 1e-20 && moment.components().norm() < 1e-20);
}

/// Forces on the nodes, as of contacts, are carried too, and a stable shape is kept as it is.
#[test]
fn forces_on_nodes_are_carried() {
    let fiber = hair(0.1, 40);
    let state = style(&fiber, [1.5, 0.7, 0.4]);
    let forces: Vec<_> = (0..=40)
        .map(|i| Vector3::new(f64::from(i).sin(), f64::from(i).cos(), 0.3) * 2e-7)
        .collect();
    let rest = fitted(&fiber, &state, &clamped(&state), &forces, f64::INFINITY).expect("a fibre");
    assert!(rest.is_exact(), "{} m", rest.moved);
    // Without them it moves.
    let kappas: Vec<_> = rest.fiber.nodes().iter().map(|n| n.natural_curvature).collect();
    let without = natural_curvatures(&fiber, &state, &clamped(&state), &[]).expect("a held root");
    assert!(kappas.iter().zip(&without).any(|(a, b)| (a - b).norm() > 0.1));
}

/// A long hair that stands upright is an equilibrium of any straight hair, but above Greenhill's
/// length it does not stay: it is given a stable shape, and the move is told.
#[test]
fn what_cannot_stand_falls_and_is_told() {
    let fiber = hair(0.3, 60);
    let mut state = style(&fiber, [0.0; 3]);
    let up = so3::between(&Vector3::z(), &Vector3::y()).expect("a rotation");
    let mut at = Point3::origin();
    for e in 0..60 {
        state.frames[e] = up;
        state.positions[e] = at;
        at += Vector3::y() * fiber.segment_lengths()[e];
    }
    state.positions[60] = at;
    let rest = fitted(&fiber, &state, &clamped(&state), &[], f64::INFINITY).expect("a fibre");
    assert!(!rest.is_exact() && rest.moved > 0.1, "{} m", rest.moved);
    let short = hair(0.02, 20);
    let mut state = style(&short, [0.0; 3]);
    let mut at = Point3::origin();
    for e in 0..20 {
        state.frames[e] = up;
        state.positions[e] = at;
        at += Vector3::y() * short.segment_lengths()[e];
    }
    state.positions[20] = at;
    let rest = fitted(&short, &state, &clamped(&state), &[], f64::INFINITY).expect("a fibre");
    assert!(rest.is_exact(), "{} m", rest.moved);
}

/// Loads may change the curvature by no more than is said, however curved the shape is, and the
/// shape follows.
#[test]
fn the_change_of_curvature_is_bounded() {
    let fiber = hair(0.1, 40);
    let state = style(&fiber, [6.0, 3.0, 0.0]);
    let rest = fitted(&fiber, &state, &clamped(&state), &[], 30.0).expect("a fibre");
    let unloaded = Instant { gravity: Vector3::zeros(), ..clamped(&state) };
    let drawn = natural_curvatures(&fiber, &state, &unloaded, &[]).expect("a held root");
    let nodes = rest.fiber.nodes().iter().zip(&drawn);
    let changes = nodes.map(|(node, drawn)| (node.natural_curvature - drawn).norm());
    let largest = changes.fold(0.0, f64::max);
    assert!((largest - 30.0).abs() < 1e-9 && rest.moved > 1e-3, "{largest} 1/m, {} m", rest.moved);
    assert!(drawn.iter().any(|drawn| drawn.norm() > 60.0));
    // What asks for less is not changed.
    let rest = fitted(&fiber, &state, &clamped(&state), &[], 1e4).expect("a fibre");
    let free = natural_curvatures(&fiber, &state, &clamped(&state), &[]).expect("a held root");
    assert!(rest.fiber.nodes().iter().zip(free).all(|(n, free)| n.natural_curvature == free));
}

/// The chain of `rod-static`, with the natural curvature between the nodes, rests where the style
/// is, to second order in the length of the segments.
#[test]
fn statics_agree_to_the_order_of_the_segments() {
    let apart = |segments: usize| {
        let node = hair(0.1, 2).nodes()[0];
        let lengths = vec![0.1 / segments as f64; segments];
        let fiber = Fiber::new(Isometry3::identity(), lengths, vec![node; segments + 1]);
        let fiber = fiber.expect("a fibre");
        let mut state = style(&fiber, [1.5, 0.7, 0.4]);
        // Frames at the middles of the segments of one smooth curve.
        let mut frame = Rotation3::identity();
        let mut at = Point3::origin();
        let steps = 64;
        let dt = 1.0 / (segments * steps) as f64;
        for k in 0..segments * steps {
            let t = (k as f64 + 0.5) * dt;
            let turn = Vector3::new(1.5 * (3.0 * t).cos(), 0.7 * (1.0 - t), 0.4 * t);
            if k % steps == steps / 2 {
                state.frames[k / steps] = frame;
                state.positions[k / steps] = at;
                at += frame * Vector3::z() * (0.1 / segments as f64);
            }
            frame *= so3::exp(&(turn * dt));
        }
        state.positions[segments] = at;
        let conditions = Instant::clamped(Isometry3::identity(), GRAVITY);
        let kappas = natural_curvatures(&fiber, &state, &conditions, &[]).expect("a held root");
        let pieces: Vec<_> = (0..segments)
            .map(|e| {
                let properties = Properties {
                    stiffness: node.stiffness,
                    natural_curvature: 0.5 * (kappas[e] + kappas[e + 1]),
                    load: GRAVITY * node.linear_density,
                };
                Piece::uniform(0.1 / segments as f64, properties)
            })
            .collect();
        let chain = Chain::new(&Isometry3::identity(), &pieces, segments).expect("a chain");
        let rest = chain.solve().expect("an equilibrium");
        let places = rest.shape.positions().iter().zip(&state.positions);
        places.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    };
    let [coarse, fine] = [apart(20), apart(40)];
    let order = (coarse / fine).log2();
    assert!((1.6..2.6).contains(&order), "order {order}: {coarse:e} m, {fine:e} m");
}

#[test]
fn what_has_no_natural_shape_is_refused() {
    let fiber = hair(0.1, 4);
    let state = style(&fiber, [1.0, 0.0, 0.0]);
    let free = Instant { root: End::FREE, ..clamped(&state) };
    natural_curvatures(&fiber, &state, &free, &[]).expect_err("a free root");
    let pinned = Instant { tip: End::pinned(Point3::origin()), ..clamped(&state) };
    natural_curvatures(&fiber, &state, &pinned, &[]).expect_err("a held tip");
    natural_curvatures(&fiber, &state, &clamped(&state), &[Vector3::zeros()])
        .expect_err("one of 5");
    let endless = Instant { gravity: Vector3::repeat(f64::INFINITY), ..clamped(&state) };
    natural_curvatures(&fiber, &state, &endless, &[]).expect_err("no number");
    fitted(&fiber, &state, &clamped(&state), &[], f64::NAN).expect_err("no bound");
}
