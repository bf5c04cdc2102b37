//! An elastic rod over a drum, for tests and for the chapter of validation. H. Singh, Planar
//! equilibria of an elastic rod wrapped around a circular capstan, J. Elast. 151 (2022): its loads
//! differ without friction too, and with friction their ratio is not Euler's.

use nalgebra::Vector3;
use rapunzel_rod_dynamic::RodState;
use std::f64::consts::PI;

/// Of the drum with the fibre, up to its axis, m; of a segment, m; stiffness is 1 N m^2.
pub(crate) const RADIUS: f64 = 0.1;
pub(crate) const SEGMENT: f64 = 0.005;
/// What bends a rod about the drum, N: `B / 2 R^2`. Loads are in parts of it.
const BENDING: f64 = 0.5 / (RADIUS * RADIUS);

/// How a rod rests whose tip bears a load.
pub(crate) struct Rest {
    pub(crate) load: f64,
    /// Of the force on its root to the load.
    pub(crate) ratio: f64,
    /// Angle between the forces at its ends.
    turn: f64,
    /// Angles between rod and force at tip and root.
    ends: [f64; 2],
}

/// Length of a step, s, and steps with each load.
pub(crate) const DT: f64 = 0.02;
const STEPS: u32 = 100;
/// Steps in which a rod comes to rest.
const SETTLING: u32 = 60;

/// A straight rod that lies level on a drum which turns toward its tip. Its root is held in a ball
/// joint, three radii beside the axis, its tip bears loads downward, one after the other, nine
/// radii on the other side: lightly loaded it is a seesaw, else it goes about a quarter of the
/// drum.
///
/// A thin ribbon, bent about its weak axis: free to spin, a round rod is free to leave the plane.
/// The place where it touches is known only to where gaps differ by a thousandth of its
/// radius.
pub(crate) fn scene(mu: f64, loads: &[f64]) -> String {
    let thin = 1e-5_f64;
    let flat = [thin / 3.0, 3.0 * thin];
    let modulus = 4.0 / (PI * flat[0].powi(3) * flat[1]);
    let density = 0.01 / (PI * thin * thin);
    // The middles of chords are on the drum, the axis on average at its radius.
    let drum = RADIUS / (1.0 + (SEGMENT / RADIUS).powi(2) / 12.0) - flat[0];
    let [behind, before] = [3.0 * RADIUS, 9.0 * RADIUS];
    let hold = DT * f64::from(STEPS);
    let mut points = vec![(0.0, 0.0)];
    for (i, load) in (0_u32..).zip(loads) {
        points.extend([0.5, 1.0].map(|part| (hold * (f64::from(i) + part), load * BENDING)));
    }
    format!(
        "(format: 1, duration: 100.0, fibers: [(length: {:?}, segments: {},
            section: Ellipse(a: {:?}, b: {:?}), material: Elastic(density: {density:?},
            youngs_modulus: {modulus:?}, shear_modulus: {modulus:?}),
            root: (position: ({:?}, 0, {:?}), orientation: Along(direction: (1, 0, 0))),
            root_joint: Ball(),
            tip: Loaded(force: (value: (0, 0, -1), profile: Linear(points: {points:?}))))],
        objects: [(shape: Capsule(length: 1.0, radius: {drum:?}), turn: (90, 0, 0),
            motion: Rotate(axis: (0, 1, 0), rate: 5.0, until: 100.0))],
        contact: (friction: Isotropic({mu:?}), residual: 1e-6, slip: 1e-6),
        environment: (gravity: (0, 0, 0), viscosity: 0.1), stepper: (dt: {DT:?}))",
        before + behind,
        ((before + behind) / SEGMENT).round(),
        flat[0],
        flat[1],
        -behind,
        drum + flat[0] + 1e-6,
    )
}

/// How the rod of [`scene`] rests with each of the loads; `next` takes a step and tells the state.
pub(crate) fn rests<E>(
    loads: &[f64],
    mut next: impl FnMut() -> Result<RodState, E>,
) -> Result<Vec<Rest>, E> {
    let down = -Vector3::z();
    let mut rests = Vec::new();
    for &load in loads {
        let [mut pull, mut tip, mut root] = [Vector3::zeros(); 3];
        for step in 0..STEPS {
            let state = next()?;
            if step < SETTLING {
                continue;
            }
            // Within the depth that is allowed the place of a single contact goes to and fro.
            pull += state.forces[0] / f64::from(STEPS - SETTLING);
            root += state.frames[0] * Vector3::z();
            tip += state.frames[state.frames.len() - 1] * Vector3::z();
        }
        let ends = [tip.angle(&down), root.angle(&pull)];
        let ratio = pull.norm() / (load * BENDING);
        rests.push(Rest { load, ratio, turn: pull.angle(&down), ends });
    }
    Ok(rests)
}

/// The ratio that a rod at rest has by the balance of material forces: along what does not touch,
/// and where contacts push but do not rub, `T + B kappa^2 / 2` stays what it is, with the tension
/// `T`. Of a leg with force `F` it is `F cos` of the angle between force and rod at its end, and if
/// it leaves the drum with `kappa` it has turned from the force's direction by the angle with `F
/// (cos end - cos angle) = B kappa^2 / 2`.
///
/// Either the legs turn by all of the angle between the forces, and the rod touches at a point; or
/// by less, with the drum's curvature, and between them it lies on the drum. Where a leg leaves it,
/// shear `F sin angle` ends in a point force that rubs too, and in between tension grows as Euler's
/// formula says.
///
/// Returns the ratio, and the curvature on the drum in parts of the drum's.
pub(crate) fn expected(rest: &Rest, mu: f64) -> [f64; 2] {
    let [low, high] = rest.ends;
    let wound = (low.cos() - 1.0 / rest.load).max(-1.0).acos();
    let legs = |turned: f64| {
        let other = wound.min(rest.turn - turned);
        let bent = rest.load * (low.cos() - other.cos());
        (other, bent, bent / (high.cos() - turned.cos()))
    };
    // How much more the root pulls than friction holds when its leg turns by an angle.
    let excess = |turned: f64| {
        let (other, _, force) = legs(turned);
        let held = rest.load * (other.cos() + mu * other.sin());
        force * (turned.cos() - mu * turned.sin())
            - held * (mu * (rest.turn - turned - other)).exp()
    };
    let [mut least, mut most] = [high, rest.turn - low];
    for _ in 0..60 {
        let middle = 0.5 * (least + most);
        *(if excess(middle) > 0.0 { &mut least } else { &mut most }) = middle;
    }
    let (_, bent, force) = legs(least);
    [force / rest.load, bent.sqrt()]
}
