//! Loads at which equilibria of the linearised staggered rod lose their stability.

#![allow(clippy::type_complexity, reason = "tables of cases")]

use crate::common::{chain, planar_clamp, scaled};
use nalgebra::{DVector, Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::{NodeProperties, so3};
use rapunzel_rod_dynamic::{
    End, Instant, Load, Rod, RodIntegrator, RodState, Staggered, equilibrium, linearize,
};
use std::f64::consts::{PI, TAU};

/// Negative eigenvalues are told from motions that cost no energy at this part of the largest.
/// The softest mode has `(pi/N)^2 / 4` of it, so a load is found to 1e-8.
const UNSTABLE: f64 = -1e-12;

fn rod(segments: usize, node: NodeProperties) -> Rod {
    Rod::new(chain(segments, |_| node).with_root(planar_clamp(0.0)))
}

/// The natural shape with the force `force` in the last segment.
fn natural(rod: &Rod, force: Vector3<f64>) -> RodState {
    let mut state = Staggered::new(rod.clone()).expect("a valid rod").state();
    if let Some(last) = state.forces.last_mut() {
        *last = force;
    }
    state
}

fn still(root: End, tip: End) -> Instant {
    Instant { root, tip, ..Instant::clamped(Isometry3::identity(), Vector3::zeros()) }
}

fn pushed(force: Vector3<f64>) -> End {
    End::Loaded { force: Load::World(force), moment: Load::ZERO }
}

fn is_stable(rod: &Rod, conditions: &Instant, state: &RodState) -> bool {
    let linear = linearize(rod, conditions, state).expect("an equilibrium");
    linear.smallest_stiffness().expect("one") > UNSTABLE
}

/// The load between `low` and `high` from which `stable` no longer holds, to 1e-6.
fn threshold(mut low: f64, mut high: f64, stable: impl Fn(f64) -> bool) -> f64 {
    assert!(stable(low) && !stable(high), "no threshold between {low} and {high}");
    while high - low > 1e-6 * high {
        let middle = 0.5 * (low + high);
        if stable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

fn meets(name: &str, found: f64, exact: f64, tolerance: f64) {
    let error = (found / exact - 1.0).abs();
    assert!(error < tolerance, "{name}: {found} for {exact}, off by {error:e}");
}

/// S4. A straight rod's axial load is a force on a free tip, and a prescribed one on a held tip.
#[test]
fn euler_loads() {
    let rod = rod(100, scaled(1.0, 1.0));
    let clamp = End::Held(*rod.fiber.root());
    let point = Point3::new(1.0, 0.0, 0.0);
    let clamped_tip = End::Held(Translation3::from(point.coords) * rod.fiber.root());
    let hinge = End::Pinned { position: Point3::origin(), moment: Load::ZERO };
    for (name, root, tip, exact) in [
        ("clamped, free", clamp, None, PI * PI / 4.0),
        ("pinned", hinge, Some(End::Pinned { position: point, moment: Load::ZERO }), PI * PI),
        (
            "clamped, pinned",
            clamp,
            Some(End::Pinned { position: point, moment: Load::ZERO }),
            20.190_729,
        ),
        ("clamped", clamp, Some(clamped_tip), 4.0 * PI * PI),
    ] {
        let found = threshold(0.5 * exact, 1.5 * exact, |load| {
            let force = -load * Vector3::x();
            let conditions = still(root, tip.unwrap_or_else(|| pushed(force)));
            is_stable(&rod, &conditions, &natural(&rod, force))
        });
        meets(name, found, exact, 1e-3);
    }
}

/// S6: an upright rod buckles under its weight.
#[test]
fn greenhill_height() {
    let rod = rod(60, scaled(1.0, 1.0));
    let found = threshold(5.0, 10.0, |weight| {
        let conditions = Instant::clamped(*rod.fiber.root(), -weight * Vector3::x());
        is_stable(&rod, &conditions, &natural(&rod, Vector3::zeros()))
    });
    meets("Greenhill", found, 7.837_347_439, 2e-3);
}

/// S10: a rod between clamps that only twist it: `tan(x) = x`, `M L / B = 2 x`.
#[test]
fn greenhill_torque() {
    let torsion = 10.0;
    let rod = rod(80, scaled(1.0, torsion));
    let root = *rod.fiber.root();
    let found = torsion
        * threshold(0.5, 1.5, |twist| {
            let turned =
                |s: f64| root.rotation * UnitQuaternion::from_scaled_axis(Vector3::z() * s * twist);
            let mut state = natural(&rod, Vector3::zeros());
            for (e, frame) in state.frames.iter_mut().enumerate() {
                *frame = turned((e as f64 + 0.5) / 80.0).to_rotation_matrix();
            }
            let tip = Isometry3::from_parts(Translation3::new(1.0, 0.0, 0.0), turned(1.0));
            is_stable(&rod, &still(End::Held(root), End::Held(tip)), &state)
        });
    meets("torque", found, 8.986_818_916, 2e-3);
}

/// S9 (Michell 1889, Zajac 1962): a naturally straight rod, closed to a ring with its ends welded
/// after a twist. Holding both ends in one pose takes away no more than the ring's rigid motions.
/// The ring can turn about its clamp's tangent for nothing, so stiffness starts at zero.
#[test]
fn twisted_ring() {
    let (n, torsion) = (100, 2.0 / 3.0);
    let rod = Rod::new(chain(n, |_| scaled(1.0, torsion)));
    let h = 1.0 / n as f64;
    let found = threshold(14.0, 18.0, |twist| {
        let frame =
            |s: f64| so3::exp(&(TAU * s * Vector3::y())) * so3::exp(&(twist * s * Vector3::z()));
        let mut state = natural(&rod, Vector3::zeros());
        for (e, f) in state.frames.iter_mut().enumerate() {
            *f = frame((e as f64 + 0.5) * h);
        }
        let turn = |s: f64| so3::log(&(frame(s - 0.5 * h).inverse() * frame(s + 0.5 * h)));
        // Twist pulls the ring out of its plane: a force along its axis holds it.
        let moment = |s: f64| {
            let m = Vector3::new(1.0, 1.0, torsion).component_mul(&turn(s)) / h;
            frame(s + 0.5 * h) * so3::right_jacobian_inverse(&turn(s)).tr_mul(&m)
        };
        let tangent = frame(1.5 * h) * Vector3::z();
        let inward = tangent.cross(&Vector3::y());
        let force = -(moment(2.0 * h) - moment(h)).dot(&inward) / h;
        state.forces[n - 1] = force * Vector3::y();
        // Half a joint on each side of the weld, turned so that it has the whole joint's moment;
        // the two ends then meet but for O(h^3).
        let half = |frame: Rotation3<f64>, side: f64| {
            let m = frame.inverse() * moment(0.0);
            let softness = 0.5 * h * Vector3::new(1.0, 1.0, 1.0 / torsion);
            let mut phi = 0.5 * turn(0.0);
            for _ in 0..30 {
                phi = softness.component_mul(&so3::right_jacobian(&(side * phi)).tr_mul(&m));
            }
            let rotation =
                UnitQuaternion::from_rotation_matrix(&(frame * so3::exp(&(-side * phi))));
            End::Held(Isometry3::from_parts(Translation3::identity(), rotation))
        };
        let ends = still(half(state.frames[0], 1.0), half(state.frames[n - 1], -1.0));
        // The ends miss each other by so little that turning about the clamp costs 1e-9; the
        // mode that leaves the plane loses 1e-7 with 1e-4 of the twist.
        let linear = linearize(&rod, &ends, &state).expect("an equilibrium");
        linear.smallest_stiffness().expect("one") > -1e-7
    });
    meets("ring", found, TAU * 3f64.sqrt() / torsion, 5e-3);
}

/// S7 and S8: a strip clamped at one end topples sideways under an end load or its weight. In its
/// stiff plane it bends as a rod does that is stiff all round.
#[test]
fn strips_topple() {
    let (stiff, flat, torsion) = (1e4_f64, 1.0, 2.0_f64);
    let mut node = scaled(stiff, stiff);
    let solid = rod(60, node);
    node.stiffness = Vector3::new(stiff, flat, torsion);
    let strip = rod(60, node);
    let scale = (flat * torsion).sqrt();
    let loads: [(&str, fn(f64) -> Instant, f64); 2] = [
        (
            "end load",
            |load| still(End::Held(planar_clamp(0.0)), pushed(-load * Vector3::y())),
            4.012_599_344,
        ),
        (
            "own weight",
            |load| Instant::clamped(planar_clamp(0.0), -load * Vector3::y()),
            12.853_763,
        ),
    ];
    for (name, conditions, exact) in loads {
        let found = threshold(0.8 * exact * scale, 1.2 * exact * scale, |load| {
            let start = natural(&solid, Vector3::zeros());
            let (bent, _) = equilibrium(&solid, &conditions(load), &start).expect("an equilibrium");
            is_stable(&strip, &conditions(load), &bent)
        });
        meets(name, found / scale, exact, 5e-3);
    }
}

/// D4 (Beck 1952): a tangential end load never buckles a clamped rod, but makes it flutter.
#[test]
fn beck_column_flutters() {
    let n = 40;
    let rod = rod(n, scaled(1.0, 1e3));
    let state = natural(&rod, Vector3::zeros());
    let lowest = |load: f64| {
        let force = Load::Follower(-load * Vector3::z());
        let tip = End::Loaded { force, moment: Load::ZERO };
        let linear = linearize(&rod, &still(End::Held(*rod.fiber.root()), tip), &state);
        linear.and_then(|l| l.characteristic_exponents(4)).expect("exponents")
    };
    // Growth sets in like the square root of the load above the threshold.
    let found = threshold(15.0, 25.0, |load| lowest(load)[0].re < 1e-2);
    meets("flutter load", found, 20.050_953_619, 5e-3);
    meets("flutter frequency", lowest(found)[0].im, 11.015_558, 5e-3);
}

/// S13 (Love, ch. 19): a helical wire of length 1 under a force along its axis:
/// `1 / k = l R^2 (cos^2 p / C + sin^2 p / B)`.
#[test]
fn helical_spring() {
    let (turns, pitch, bending, torsion) = (2.0, 0.3_f64, 1.0, 0.7);
    let n = 200;
    let rate = TAU * turns;
    let radius = pitch.cos() / rate;
    let (curvature, twist) = (rate * pitch.cos(), rate * pitch.sin());
    let rod = Rod::new(chain(n, |_| {
        let mut node = scaled(bending, torsion);
        node.natural_curvature = Vector3::new(0.0, curvature, twist);
        node
    }));
    let root = *rod.fiber.root();
    let state = natural(&rod, Vector3::zeros());
    let linear = linearize(&rod, &still(End::Held(root), End::FREE), &state).expect("at rest");
    // The Darboux vector is the rate times the axis; the axis is R off toward the normal.
    let axis = Vector3::new(0.0, curvature, twist) / rate;
    let normal = axis.cross(&Vector3::z()).normalize();
    let tip = state.positions[n].coords;
    let inward = Vector3::x() * radius;
    let inward = if normal.x > 0.0 { inward } else { -inward };
    let from_tip = inward - tip;
    let arm = from_tip - axis * axis.dot(&from_tip);
    let mut forces = vec![Vector3::zeros(); n + 1];
    forces[n] = axis;
    let mut moments = vec![Vector3::zeros(); n];
    moments[n - 1] = arm.cross(&axis);
    let load = linear.load(&forces, &moments).expect("one each");
    let answer: DVector<f64> = linear.stiffness().clone().lu().solve(&load).expect("stiff");
    // The arm to the axis is fixed to the last segment, which leaves half of it rigid.
    let length = 1.0 - 0.5 / n as f64;
    let softness = pitch.cos().powi(2) / torsion + pitch.sin().powi(2) / bending;
    let exact = length * radius.powi(2) * softness;
    meets("spring", answer.dot(&load), exact, 1e-3);
}
