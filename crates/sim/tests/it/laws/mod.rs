//! Laws of contact beside Coulomb's: how touches bounce, and what they do at rest.

mod adhesion;
mod motion;

use crate::common::Run;
use nalgebra::Vector3;
use rapunzel_sim::Scene;

/// Radius of the hairs, m.
const RADIUS: f64 = 3.5e-5;
const G: f64 = 9.81;

/// A run by backward Euler from first to last: what it does to velocities is known exactly.
fn run_of(fiber: &str, object: &str, laws: &str, gravity: f64, dt: f64) -> Run {
    Run::read(&format!(
        "(format: 1, duration: 1.0, fibers: [{fiber}], objects: [{object}],
        contact: ({laws}),
        environment: (gravity: (0.0, 0.0, {gravity:?})), stepper: (dt: {dt:?}, method: BackwardEuler))"
    ))
}

/// A free short hair that starts at a place, along a direction.
fn hair(at: &Vector3<f64>, way: &Vector3<f64>) -> String {
    format!(
        "(length: 0.008, segments: 4, section: Circle(radius: {RADIUS:?}), root_joint: Free, \
         root: (position: ({:?}, {:?}, {:?}), orientation: Along(direction: ({:?}, {:?}, {:?}))))",
        at.x, at.y, at.z, way.x, way.y, way.z
    )
}

const GROUND: &str = "(shape: Plane(normal: (0.0, 0.0, 1.0)))";

/// Weight of the hair, N.
fn weight() -> f64 {
    let run =
        run_of(&hair(&Vector3::zeros(), &Vector3::x()), "", "friction: Isotropic(0.3)", G, 1.0);
    G * run.world.assembly().fibers()[0].mass()
}

#[test]
fn laws_that_make_no_sense_are_refused() {
    for (laws, what) in [
        ("friction: Isotropic(0.3), restitution: 1.5", "restitution"),
        ("friction: Isotropic(0.3), compliance: -1.0", "compliance"),
        ("friction: Isotropic(0.3), rolling_resistance: -1e-6", "rolling_resistance"),
        ("friction: Resting(resting: 0.2, sliding: 0.3)", "sliding"),
        ("friction: Isotropic(0.3), adhesion: Line(force: -1.0, range: 1e-6)", "force"),
        ("friction: Isotropic(0.3), adhesion: Bonds(strength: 0.1, range: 0.0)", "range"),
    ] {
        let text = format!(
            "(format: 1, duration: 1.0, fibers: [{}], contact: ({laws}), stepper: (dt: 1e-3))",
            hair(&Vector3::zeros(), &Vector3::x())
        );
        let error = Scene::from_ron(&text).expect_err(laws).to_string();
        assert!(error.contains(what), "{error} for {laws}");
    }
}
