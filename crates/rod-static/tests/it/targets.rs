//! Ends that are known to be reached: the closed form makes them and checks what is found.

use crate::common::Random;
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;
use rapunzel_rod_static::{EndCondition, Equilibrium, Lagrange, Piece, Problem, Properties, State};

const TORSION: f64 = 0.75;

/// A straight rod of length and stiffness one without load.
fn problem(end: EndCondition) -> Problem {
    let piece = Piece::uniform(
        1.0,
        Properties {
            stiffness: Vector3::new(1.0, 1.0, TORSION),
            natural_curvature: Vector3::zeros(),
            load: Vector3::zeros(),
        },
    );
    Problem::new(&Isometry3::identity(), vec![piece], end).expect("a problem")
}

/// The tip that the closed form leads to from the root of an equilibrium.
fn tip_of(root: &State) -> State {
    Lagrange::new(1.0, TORSION, 0.0, root).expect("a rod").at(1.0)
}

/// A tip under a random force up to 20 and a random moment up to 5.
fn target(random: &mut Random) -> State {
    let force = random.direction() * (20.0 * random.unit());
    let moment = random.direction() * (5.0 * random.unit());
    tip_of(&State { position: Point3::origin(), frame: Rotation3::identity(), force, moment })
}

fn held(tip: &State) -> EndCondition {
    EndCondition::Held(Isometry3::from_parts(
        Translation3::from(tip.position.coords),
        UnitQuaternion::from_rotation_matrix(&tip.frame),
    ))
}

/// The worse of the two errors, of the position and of the frame, in units of what is allowed.
fn error(found: &Equilibrium, tip: &State) -> f64 {
    let own = found.tip();
    let closed = tip_of(&found.root());
    let of = |a: &State| {
        let turn = so3::log(&(a.frame * tip.frame.inverse())).norm();
        ((a.position - tip.position).norm() / 1e-9).max(turn / 1e-8)
    };
    of(&own).max(of(&closed))
}

/// Tries `count` random targets; at least 99.5 % are found, none of them wrong.
fn try_targets(count: u32, seed: u64) {
    let mut random = Random::new(seed);
    let mut solved = 0;
    for i in 0..count {
        let tip = target(&mut random);
        if let Ok(found) = problem(held(&tip)).solve() {
            let error = error(&found, &tip);
            assert!(error < 1.0, "target {i}: {error} times what is allowed");
            solved += 1;
            assert!(found.is_stable(), "target {i}");
        }
    }
    assert!(f64::from(solved) >= 0.995 * f64::from(count), "{solved} of {count} solved");
}

#[test]
fn random_clamps_are_reached() {
    try_targets(100, 1);
}

#[test]
#[ignore = "slow: 10 s, a thousand targets"]
fn a_thousand_random_clamps_are_reached() {
    try_targets(1000, 2);
}

/// A ball joint carries no moment, a bearing none about its axis; both are where they should be.
#[test]
fn random_joints_and_bearings_are_reached() {
    let mut random = Random::new(3);
    let mut unsolved = 0;
    for i in 0..50 {
        let tip = target(&mut random);
        let tangent = tip.frame * Vector3::z();
        match problem(EndCondition::Position(tip.position)).solve() {
            Ok(found) => {
                let at = found.tip();
                assert!((at.position - tip.position).norm() < 1e-9, "target {i}");
                assert!(at.moment.norm() < 1e-6, "target {i}: {}", at.moment);
                let closed = tip_of(&found.root());
                assert!((closed.position - tip.position).norm() < 1e-9, "target {i}");
            }
            Err(_) => unsolved += 1,
        }
        match problem(EndCondition::Tangent(tip.position, Unit::new_normalize(tangent))).solve() {
            Ok(found) => {
                let at = found.tip();
                let own = at.frame * Vector3::z();
                assert!((at.position - tip.position).norm() < 1e-9, "target {i}");
                assert!((own - tangent).norm() < 1e-8, "target {i}");
                assert!(at.moment.dot(&own).abs() < 1e-6, "target {i}");
            }
            Err(_) => unsolved += 1,
        }
    }
    assert!(unsolved == 0, "{unsolved} unsolved");
}

/// Curved, heavy rods of elliptic section: the targets are the tips of free rods with a random
/// force and moment on the end.
#[test]
fn random_clamps_of_curved_heavy_rods_are_reached() {
    let mut random = Random::new(4);
    let (count, mut solved) = (100, 0);
    for i in 0..count {
        let natural_curvature = random.direction() * (8.0 * random.unit());
        let properties = Properties {
            stiffness: Vector3::new(1.0, 0.3 + 0.7 * random.unit(), 0.6),
            natural_curvature,
            load: random.direction() * (20.0 * random.unit()),
        };
        let problem = |end| {
            let piece = Piece::uniform(1.0, properties);
            Problem::new(&Isometry3::identity(), vec![piece], end).expect("a problem")
        };
        let force = random.direction() * (10.0 * random.unit());
        let moment = random.direction() * (3.0 * random.unit());
        let Ok(free) = problem(EndCondition::Free { force, moment }).solve() else { continue };
        let tip = free.tip();
        if let Ok(found) = problem(held(&tip)).solve() {
            let at = found.tip();
            assert!((at.position - tip.position).norm() < 1e-9, "target {i}");
            assert!(so3::log(&(at.frame * tip.frame.inverse())).norm() < 1e-8, "target {i}");
            solved += 1;
        }
    }
    assert!(solved >= count - 1, "{solved} of {count} solved");
}
