//! Two discretisations, one rod: the staggered rod and the box scheme agree within their errors.

use crate::common::{chain, planar_clamp, scaled};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::Fiber;
use rapunzel_rod_dynamic::{
    Air, BoxIntegrator, BoxOptions, Drag, End, Instant, Load, Rod, RodIntegrator, Staggered,
};

/// How something comes on between rest and time 1: slowly, and slowly up to its end.
fn rise(t: f64) -> f64 {
    0.5 * (1.0 - (std::f64::consts::PI * t.clamp(0.0, 1.0)).cos())
}

struct Scene {
    name: &'static str,
    curl: Vector3<f64>,
    damping_time: f64,
    conditions: fn(f64) -> Instant,
}

/// A fall from the clamp, as every scene has it but for what it changes.
fn fall(t: f64) -> Instant {
    Instant::clamped(planar_clamp(0.3), Vector3::new(0.0, -1.0, 0.2) * rise(t))
}

/// The pose of the straight rod's tip after a motion inward and a turn.
fn driven_tip(curl: Vector3<f64>, t: f64) -> Isometry3<f64> {
    let fiber = curled(40, curl);
    let (positions, frames) = fiber.rest_shape();
    let shift = Vector3::new(-0.1, 0.05, 0.05) * rise(t);
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.2, 0.1, 0.4) * rise(t));
    Isometry3::from_parts(
        Translation3::from(positions[40].coords + shift),
        turn * UnitQuaternion::from_rotation_matrix(&frames[40]),
    )
}

fn curled(segments: usize, curl: Vector3<f64>) -> Fiber {
    chain(segments, |_| {
        let mut node = scaled(0.1, 0.08);
        node.natural_curvature = curl;
        node
    })
    .with_root(planar_clamp(0.3))
}

const SCENES: [Scene; 9] = [
    Scene {
        name: "planar fall",
        curl: Vector3::new(0.0, 0.0, 0.0),
        damping_time: 0.0,
        conditions: |t| Instant { gravity: -Vector3::y() * rise(t), ..fall(t) },
    },
    Scene {
        name: "curly fall",
        curl: Vector3::new(1.0, 0.5, 2.0),
        damping_time: 0.0,
        conditions: fall,
    },
    Scene {
        name: "moving root",
        curl: Vector3::new(1.0, 0.5, 2.0),
        damping_time: 0.0,
        conditions: |t| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.5, 0.3, 0.2) * rise(t));
            let root = planar_clamp(0.3);
            let moved = Translation3::from(Vector3::new(0.1, 0.2, -0.1) * rise(t));
            Instant {
                root: End::Held(Isometry3::from_parts(moved, turn * root.rotation)),
                ..fall(t)
            }
        },
    },
    Scene {
        name: "driven tip",
        curl: Vector3::new(1.0, 0.5, 2.0),
        damping_time: 0.02,
        conditions: |t| Instant {
            tip: End::Held(driven_tip(Vector3::new(1.0, 0.5, 2.0), t)),
            ..fall(t)
        },
    },
    Scene {
        name: "pinned tip",
        curl: Vector3::new(1.0, 0.5, 2.0),
        damping_time: 0.02,
        conditions: |t| {
            let tip = driven_tip(Vector3::new(1.0, 0.5, 2.0), t).translation.vector;
            Instant {
                tip: End::Pinned { position: Point3::from(tip), moment: Load::ZERO },
                ..fall(t)
            }
        },
    },
    Scene {
        name: "follower force",
        curl: Vector3::new(0.0, 0.0, 0.0),
        damping_time: 0.0,
        conditions: |t| {
            let force = Load::Follower(Vector3::new(0.1, 0.1, 0.2) * rise(t));
            Instant { tip: End::Loaded { force, moment: Load::ZERO }, ..fall(t) }
        },
    },
    Scene {
        name: "world force and moment",
        curl: Vector3::new(0.5, 0.0, 1.0),
        damping_time: 0.0,
        conditions: |t| {
            let force = Load::World(Vector3::new(0.1, 0.1, 0.2) * rise(t));
            let moment = Load::World(Vector3::new(0.05, 0.0, 0.05) * rise(t));
            Instant { tip: End::Loaded { force, moment }, ..fall(t) }
        },
    },
    Scene {
        name: "drag",
        curl: Vector3::new(1.0, 0.5, 2.0),
        damping_time: 0.0,
        conditions: |t| {
            let drag = Drag { normal: 0.6, tangential: 0.3 };
            Instant {
                air: Some(Air { wind: Vector3::new(0.3, 0.2, 0.5) * rise(t), drag }),
                ..fall(t)
            }
        },
    },
    Scene {
        name: "damping",
        curl: Vector3::new(1.0, 0.5, 2.0),
        damping_time: 0.2,
        conditions: fall,
    },
];

/// The tip and the middle at time 1.2.
fn points(
    mut rod: impl RodIntegrator,
    segments: usize,
    steps: usize,
    scene: &Scene,
) -> [Vector3<f64>; 2] {
    for _ in 0..steps {
        let report = rod.step(1.2 / steps as f64, &scene.conditions).expect(scene.name);
        assert_eq!(report.halvings, 0, "{}: the steps are those asked for", scene.name);
    }
    let positions = rod.state().positions;
    [positions[segments].coords, positions[segments / 2].coords]
}

/// Demands that the two differ by less than their errors.
fn agree(scene: &Scene) {
    let rod = |segments| Rod::damped(curled(segments, scene.curl), scene.damping_time);
    let staggered =
        |n, steps| points(Staggered::with_rho_inf(rod(n), 0.5).expect("valid"), n, steps, scene);
    let boxed = |n, steps| {
        let options = BoxOptions::with_damping(0.8).expect("in range");
        points(BoxIntegrator::new(rod(n), options).expect("valid"), n, steps, scene)
    };
    let (coarse, fine) = (staggered(20, 80), staggered(40, 160));
    let (box_coarse, box_fine) = (boxed(20, 80), boxed(40, 160));
    for i in 0..2 {
        // Second order: the fine result is off by a third of what the coarse one is from it, and
        // by a fifth more for what is left of higher order.
        let errors = ((coarse[i] - fine[i]).norm() + (box_coarse[i] - box_fine[i]).norm()) / 3.0;
        let difference = (fine[i] - box_fine[i]).norm();
        assert!(difference < 1.2 * errors, "{}: {difference:e} of {errors:e}", scene.name);
    }
}

#[test]
fn staggered_rod_and_box_scheme_agree() {
    for scene in &SCENES {
        agree(scene);
    }
}

/// A follower load turns with the end of the rod, not with the middle of its last segment, which
/// is half a segment of curvature away.
#[test]
fn follower_loads_follow_the_tip_of_a_curled_rod() {
    agree(&Scene {
        name: "follower force",
        curl: Vector3::new(0.5, 0.0, 1.0),
        damping_time: 0.0,
        conditions: |t| {
            let force = Load::Follower(Vector3::new(0.1, 0.1, 0.2) * rise(t));
            Instant { tip: End::Loaded { force, moment: Load::ZERO }, ..fall(t) }
        },
    });
}
