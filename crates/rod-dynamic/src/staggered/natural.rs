//! The inverse of the static problem: which natural shape a fibre must have to rest in a given one.

use super::equilibrium::{EquilibriumError, at_rest, settled};
use super::stability::is_minimum;
use crate::joint::Joint;
use crate::{End, Instant, Load, Rod, RodError, RodState};
use nalgebra::{DVector, Isometry3, MatrixXx6, Vector3, Vector6};
use rapunzel_fiber::{Fiber, so3};

/// A fibre that rests in a shape under its loads.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedFiber {
    /// The fibre with its natural curvature.
    pub fiber: Fiber,
    /// Its stable equilibrium, at rest.
    pub state: RodState,
    /// Largest distance of a node from the shape that was asked for, m.
    pub moved: f64,
}

/// Most turns of a load that follows the end.
const MOST_TURNS: usize = 60;
/// Motion of a node, relative to the length of the fibre, up to which the shape is the one that
/// was asked for: rounding.
const SAME: f64 = 1e-9;
/// Effect of a load, relative to the largest one's, that is none: effects are differences of
/// curvatures, and rounding where a fibre turns some hundred times within its length.
const NO_EFFECT: f64 = 1e-12;

impl FittedFiber {
    /// Whether the shape is the one that was asked for, not a stable one nearby.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.moved <= SAME * self.fiber.length()
    }
}

/// Natural curvatures of the nodes, 1/m, material frame, for which `state` is an equilibrium under
/// `conditions` and `node_forces` (N, world, one per node, or none).
///
/// In closed form, to rounding: the moments follow from the shape and the loads beyond, so
/// `kappa0 = kappa - K^-1 m` at every joint. Velocities of `state` and drag are left out. Cost: one
/// pass over the segments.
///
/// # Errors
/// [`RodError::Length`] of arrays that do not fit, [`RodError::Invalid`] unless the root is held
/// and the tip is loaded or free, and of numbers that are not finite.
pub fn natural_curvatures(
    fiber: &Fiber,
    state: &RodState,
    conditions: &Instant,
    node_forces: &[Vector3<f64>],
) -> Result<Vec<Vector3<f64>>, RodError> {
    let n = fiber.segments();
    let counts = [("frames", n, state.frames.len()), ("node forces", n + 1, node_forces.len())];
    for (what, expected, found) in counts {
        if found != expected && !(what == "node forces" && found == 0) {
            return Err(RodError::Length { what, expected, found });
        }
    }
    let refuse = |what, why| Err(RodError::Invalid { what, why });
    let End::Held(clamp) = conditions.root else {
        return refuse("root", "must be held, or no moments follow from the shape");
    };
    let End::Loaded { force, moment } = conditions.tip else {
        return refuse("tip", "must be free or loaded, or its reaction is not known");
    };
    let mut curvatures = vec![Vector3::zeros(); n + 1];
    // Loads that follow the end have the frame of the last node, half a segment of natural
    // curvature beyond that of the last segment: what is sought turns its own load a little.
    for _ in 0..MOST_TURNS {
        let before = curvatures[n];
        let turn = 0.5 * fiber.segment_lengths()[n - 1] * before;
        let tip_frame = state.frames[n - 1] * so3::exp(&turn);
        let world = |load: Load| match load {
            Load::World(v) => v,
            Load::Follower(v) => tip_frame * v,
        };
        balance(
            fiber,
            state,
            conditions,
            node_forces,
            &clamp,
            [world(force), world(moment)],
            &mut curvatures,
        );
        let change = (curvatures[n] - before).norm();
        if change <= f64::EPSILON * before.norm() || !change.is_finite() {
            break;
        }
    }
    if curvatures.iter().any(|kappa| !kappa.iter().all(|x| x.is_finite())) {
        return refuse("state and loads", "must be finite");
    }
    Ok(curvatures)
}

/// The [`natural_curvatures`] as far as they are at most `most`, 1/m, off the curvatures that the
/// shape of `state` has without any load; what is more is cut to that, and the shape is no
/// equilibrium then.
///
/// # Errors
/// Those of [`natural_curvatures`], and a bound that is negative or not a number.
pub fn bounded_natural_curvatures(
    fiber: &Fiber,
    state: &RodState,
    conditions: &Instant,
    node_forces: &[Vector3<f64>],
    most: f64,
) -> Result<Vec<Vector3<f64>>, RodError> {
    bounded(fiber, state, conditions, node_forces, most).map(|(curvatures, _)| curvatures)
}

/// The [`bounded_natural_curvatures`], and whether none of them was cut.
fn bounded(
    fiber: &Fiber,
    state: &RodState,
    conditions: &Instant,
    node_forces: &[Vector3<f64>],
    most: f64,
) -> Result<(Vec<Vector3<f64>>, bool), RodError> {
    if most.is_nan() || most < 0.0 {
        let what = "largest change of curvature";
        return Err(RodError::Invalid { what, why: "must not be negative" });
    }
    let mut curvatures = natural_curvatures(fiber, state, conditions, node_forces)?;
    let mut whole = true;
    if most < f64::INFINITY {
        let unloaded = Instant {
            tip: End::FREE,
            gravity: Vector3::zeros(),
            distributed: Vector3::zeros(),
            ..*conditions
        };
        let drawn = natural_curvatures(fiber, state, &unloaded, &[])?;
        for (natural, drawn) in curvatures.iter_mut().zip(drawn) {
            let change = *natural - drawn;
            if change.norm() > most {
                *natural = drawn + change.cap_magnitude(most);
                whole = false;
            }
        }
    }
    Ok((curvatures, whole))
}

/// Natural curvatures for a force (N) and a moment (N m) on the end, world.
fn balance(
    fiber: &Fiber,
    state: &RodState,
    conditions: &Instant,
    node_forces: &[Vector3<f64>],
    clamp: &Isometry3<f64>,
    [force, moment]: [Vector3<f64>; 2],
    curvatures: &mut [Vector3<f64>],
) {
    let (n, h) = (fiber.segments(), fiber.segment_lengths());
    // Force and moment that all beyond the segment exert on it, world.
    let (mut beyond, mut torque) = (force, moment);
    for e in (0..n).rev() {
        beyond += conditions.node_load(fiber, node_forces, e + 1);
        // Balance of moments of the segment about its start.
        let frame = &state.frames[e];
        torque += (frame * Vector3::z() * h[e]).cross(&beyond);
        // The joint before bears it: `J^T` takes the moment to the derivative of its energy by the
        // rotation vector `phi`, `K (phi - phi0)`.
        let before = if e > 0 { state.frames[e - 1] } else { clamp.rotation.to_rotation_matrix() };
        let phi = so3::log(&(before.inverse() * frame));
        let moment = frame.inverse() * torque;
        let joint = Joint::new(fiber, e);
        let strain = (so3::right_jacobian(&phi).tr_mul(&moment)).component_div(&joint.stiffness);
        curvatures[e] = (phi - strain) / joint.length;
    }
    // The joint at the root lies between the first two nodes.
    curvatures[n] = curvatures[n - 1];
    curvatures[0] = (curvatures[0] - 0.25 * curvatures[1]) / 0.75;
    if n == 1 {
        curvatures[0] = 0.75 * curvatures[0] + 0.25 * curvatures[1];
        curvatures[1] = curvatures[0];
    }
}

/// The load on the tip that bears as much of a shape as it can: a dead force (N, world) and a
/// following couple (N m, material frame) for which the [`natural_curvatures`] that are left are
/// least, by the integral of their squares over the length. The tip of `conditions` does not count.
///
/// A naturally straight fibre without weight that such loads bend gets just these back (thesis
/// 5.3.3). Of several loads with the same effect, as a force along a straight fibre has, the least
/// is returned, in units of the bending stiffness and the length. Cost: seven passes over the
/// segments.
///
/// # Errors
/// Those of [`natural_curvatures`].
pub fn fitted_end_load(
    fiber: &Fiber,
    state: &RodState,
    conditions: &Instant,
    node_forces: &[Vector3<f64>],
) -> Result<End, RodError> {
    let free = Instant { tip: End::FREE, ..*conditions };
    let left = natural_curvatures(fiber, state, &free, node_forces)?;
    // Natural curvatures are linear in loads: a unit of each tells its share.
    let weightless = Instant { gravity: Vector3::zeros(), distributed: Vector3::zeros(), ..free };
    let drawn = natural_curvatures(fiber, state, &weightless, &[])?;
    let length = fiber.length();
    let stiffness = fiber.nodes()[0].stiffness.x;
    let units = [stiffness / length.powi(2), stiffness / length];
    let world = |v: Vector3<f64>| Load::World(v);
    // A row for each component at each joint, a column for each load: normal equations would square
    // the condition of what loads a straight or short fibre hardly feels.
    let weights = (0..fiber.segments()).map(|e| Joint::new(fiber, e).length.sqrt());
    let weights: Vec<f64> = weights.collect();
    let row =
        |row: usize, curvatures: &[Vector3<f64>]| weights[row / 3] * curvatures[row / 3][row % 3];
    let rows = 3 * fiber.segments();
    let right = DVector::from_fn(rows, |k, _| row(k, &left));
    let mut matrix = MatrixXx6::zeros(rows);
    for k in 0..6 {
        let mut unit = [Vector3::zeros(); 2];
        unit[k / 3][k % 3] = units[k / 3];
        let [force, moment] = unit.map(world);
        let loaded = Instant { tip: End::Loaded { force, moment }, ..weightless };
        let bent = natural_curvatures(fiber, state, &loaded, &[])?;
        matrix.set_column(k, &DVector::from_fn(rows, |k, _| row(k, &drawn) - row(k, &bent)));
    }
    let parts = matrix.svd(true, true);
    let scale = parts.singular_values.max();
    let loads: Vector6<f64> = parts.solve(&right, NO_EFFECT * scale).unwrap_or_default();
    let force = loads.fixed_rows::<3>(0) * units[0];
    let moment = loads.fixed_rows::<3>(3) * units[1];
    let moment = state.frames[fiber.segments() - 1].inverse() * moment;
    Ok(End::Loaded { force: Load::World(force), moment: Load::Follower(moment) })
}

/// The fibre whose natural curvature lets it rest in the shape of `state`, or in a stable one near
/// it.
///
/// Loads change curvatures by at most `most` (1/m), as with [`bounded_natural_curvatures`]: where
/// that does not do, or the equilibrium is not stable, the fibre falls to one that is. `moved`
/// tells how far that leads. Cost: two passes over the segments where the shape is stable under
/// dead loads as it is, else those of an [`equilibrium`](super::equilibrium()).
///
/// # Errors
/// Those of [`bounded_natural_curvatures`], and of [`equilibrium`](super::equilibrium()).
pub fn fitted(
    fiber: &Fiber,
    state: &RodState,
    conditions: &Instant,
    node_forces: &[Vector3<f64>],
    most: f64,
) -> Result<FittedFiber, EquilibriumError> {
    let (curvatures, whole) = bounded(fiber, state, conditions, node_forces, most)?;
    let invalid = |_| RodError::Invalid { what: "natural curvature", why: "must be finite" };
    let fiber = fiber.clone().with_node_curvatures(&curvatures).map_err(invalid)?;
    if whole && is_minimum(&fiber, state, conditions, node_forces) {
        return Ok(FittedFiber { fiber, state: at_rest(state), moved: 0.0 });
    }
    let rod = Rod::new(fiber);
    let (rest, _) = settled(&rod, conditions, node_forces, state)?;
    let places = rest.positions.iter().zip(&state.positions);
    let moved = places.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    Ok(FittedFiber { fiber: rod.fiber, state: rest, moved })
}
