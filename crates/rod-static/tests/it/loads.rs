//! Loads over many decades: what is found balances, and is a minimum where it says so.

use nalgebra::{Isometry3, Rotation3, Vector3};
use proptest::prelude::*;
use rapunzel_rod_static::{EndCondition, Equilibrium, Piece, Problem, Properties};
use std::f64::consts::FRAC_PI_2;

const STIFFNESS: [f64; 3] = [1.0, 0.7, 0.8];
/// Nodes and weights of Gauss's quadrature with three points on `[0, 1]`.
const THREE: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

fn level() -> Isometry3<f64> {
    Isometry3::new(Vector3::zeros(), Vector3::y() * FRAC_PI_2)
}

fn piece(length: f64, load: Vector3<f64>, curvature: Vector3<f64>) -> Piece {
    let stiffness = Vector3::from(STIFFNESS);
    Piece::uniform(length, Properties { stiffness, natural_curvature: curvature, load })
}

/// Arc lengths from 0 to 1 that lie close where a force of size `force` bends the rod: at its ends
/// and at `inner`.
fn arcs(force: f64, inner: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0, 1.0];
    for &at in inner.iter().chain(&[0.0, 1.0]) {
        let mut distance = 0.01 / (1.0 + force).sqrt();
        while distance < 1.0 {
            all.extend(
                [at - distance, at + distance].into_iter().filter(|s| (0.0..1.0).contains(s)),
            );
            distance = (1.04 * distance).min(distance + 0.004);
        }
        all.push(at);
    }
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// The force in the rod just beyond `s`, from the loads alone.
fn carried(
    s: f64,
    load: Vector3<f64>,
    beads: &[(f64, Vector3<f64>)],
    end: Vector3<f64>,
) -> Vector3<f64> {
    let beyond = beads.iter().filter(|(at, _)| *at > s).map(|(_, force)| force);
    end + load * (1.0 - s) + beyond.sum::<Vector3<f64>>()
}

/// What is missing, by the states at `arcs` alone, to a balance of forces and moments, summed over
/// all stretches, and in each to the section's law and to a tangent of unit length: in units of the
/// loads, of what they bend with, and in radians and lengths.
fn residual(
    found: &Equilibrium,
    arcs: &[f64],
    curvature: Vector3<f64>,
    load: Vector3<f64>,
    beads: &[(f64, Vector3<f64>)],
    end: Vector3<f64>,
) -> f64 {
    let scale = 1.0 + beads.iter().map(|(_, f)| f.norm()).sum::<f64>() + load.norm() + end.norm();
    let stiffness = Vector3::from(STIFFNESS);
    let (mut worst, mut unbalanced) = (0.0_f64, 0.0);
    for ends in arcs.windows(2) {
        let h = ends[1] - ends[0];
        let [a, b] = [ends[0], ends[1]].map(|s| found.at(s));
        let n = carried(ends[0], load, beads, end);
        // A bead on the end of a stretch pulls the next one.
        unbalanced += (a.force - n).norm() / scale;
        let (mut way, mut lever) = (Vector3::zeros(), Vector3::zeros());
        for (node, weight) in THREE {
            let at = found.at(ends[0] + h * node);
            way += at.frame * Vector3::z() * (weight * h);
            lever += (at.position - a.position).cross(&load) * (weight * h);
        }
        worst = worst.max((b.position - a.position - way).norm());
        // The moments about the beginning of the stretch.
        let beyond = n - load * h;
        let balance = b.moment - a.moment + (b.position - a.position).cross(&beyond) + lever;
        unbalanced += balance.norm() / (scale.sqrt() + curvature.norm());
        // Magnus's series with two points: of fourth order.
        let [p, q] = [-1.0, 1.0].map(|side| {
            let at = found.at(ends[0] + h * (0.5 + side * 3.0_f64.sqrt() / 6.0));
            curvature + (at.frame.inverse() * at.moment).component_div(&stiffness)
        });
        let turn = (p + q) * (0.5 * h) + p.cross(&q) * (3.0_f64.sqrt() / 12.0 * h * h);
        let turned = a.frame * Rotation3::from_scaled_axis(turn);
        worst = worst.max((turned.matrix() - b.frame.matrix()).norm());
    }
    worst.max(unbalanced)
}

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-1.0..1.0_f64)
        .prop_map(Vector3::from)
        .prop_filter("a direction", |v| v.norm() > 0.1)
        .prop_map(|v| v.normalize())
}

/// A vector whose size is spread over eight decades.
fn vector() -> impl Strategy<Value = Vector3<f64>> {
    (direction(), -2.0..6.0_f64).prop_map(|(direction, size)| direction * 10.0_f64.powf(size))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// A bead, own weight and a force on the end, each of any size and direction: a stable answer
    /// that balances to 1e-8.
    #[test]
    fn forces_of_many_decades_balance(
        bead in vector(), load in vector(), end in vector(), at in 0.01..0.99_f64,
        curvature in prop::array::uniform3(-8.0..8.0_f64),
    ) {
        let curvature = Vector3::from(curvature);
        let pieces = vec![
            piece(at, load, curvature).with_end_load(bead),
            piece(1.0 - at, load, curvature),
        ];
        let free = EndCondition::Free { force: end, moment: Vector3::zeros() };
        let problem = Problem::new(&level(), pieces, free).expect("a problem");
        let found = problem.solve().map_err(|e| TestCaseError::fail(e.to_string()))?;
        prop_assert!(found.is_stable());
        let arcs = arcs(bead.norm() + load.norm() + end.norm(), &[at]);
        let missing = residual(&found, &arcs, curvature, load, &[(at, bead)], end);
        prop_assert!(missing < 1e-8, "{missing:e}");
    }

    /// A moment of many loops winds a round rod to a circle, or with a torque to a helix.
    #[test]
    fn moments_of_many_loops_wind(moment in direction(), size in -2.0..4.0_f64) {
        let moment = moment * 10.0_f64.powf(size);
        let properties = Properties {
            stiffness: Vector3::new(1.0, 1.0, 0.8),
            natural_curvature: Vector3::zeros(),
            load: Vector3::zeros(),
        };
        let free = EndCondition::Free { force: Vector3::zeros(), moment };
        let rod = vec![Piece::uniform(1.0, properties)];
        let problem = Problem::new(&Isometry3::identity(), rod, free);
        let found = problem.expect("a problem").solve();
        let tip = found.map_err(|e| TestCaseError::fail(e.to_string()))?.tip();
        // The tangent turns about the moment, which is constant, at the rate of its size.
        let (axis, turn) = (moment.normalize(), moment.norm());
        let along = axis * axis.z;
        let (across, beside) = (Vector3::z() - along, axis.cross(&Vector3::z()));
        let exact = along + across * (turn.sin() / turn) + beside * ((1.0 - turn.cos()) / turn);
        prop_assert!((tip.position.coords - exact).norm() < 1e-8, "{} {exact}", tip.position);
    }
}

/// A pull on the end that the own weight takes over half way: the rod bends sharply far from what
/// holds or loads it, where its segments are long. From segments alone Newton's method did not
/// reach it, and all starts were tried in vain for minutes.
#[test]
fn a_bend_far_from_the_ends_is_found() {
    let load = Vector3::new(-699_639.8, 558_193.3, 58_527.8);
    let bead = Vector3::new(-515.9, -737.3, -961.7);
    let end = Vector3::new(329_512.9, -850_549.7, 157_642.6);
    let (at, curvature) = (0.957_966, Vector3::new(3.148_5, 6.703_4, 1.598_3));
    let pieces =
        vec![piece(at, load, curvature).with_end_load(bead), piece(1.0 - at, load, curvature)];
    let free = EndCondition::Free { force: end, moment: Vector3::zeros() };
    let problem = Problem::new(&level(), pieces, free).expect("a problem");
    let found = problem.solve().expect("an equilibrium");
    let arcs = arcs(load.norm() + end.norm(), &[0.5, at]);
    let missing = residual(&found, &arcs, curvature, load, &[(at, bead)], end);
    assert!(found.is_stable() && missing < 1e-8, "{missing:e}");
}
