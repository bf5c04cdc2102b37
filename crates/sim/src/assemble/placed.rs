//! Fibres whose start is given in the world: along a curve, as a solved case, around an object.

use crate::SimError;
use crate::curve::{CurveTable, open_curve};
use crate::scene::{Bundle, Initial, Scene};
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::generate::{OpenCurve, Wound, root_pose};
use rapunzel_fiber::{Fiber, FiberError, so3};
use rapunzel_rod_dynamic::RodState;

/// A fibre, and where it lies at the start.
pub(super) struct Laid {
    pub(super) fiber: Fiber,
    /// Its state, at rest; `None` for the natural one.
    pub(super) state: Option<RodState>,
    /// Pose of its tip, if it is known more exactly than by the state.
    pub(super) tip: Option<Isometry3<f64>>,
}

/// The fibre of a bundle, which is `natural` but for its root, where its start puts it, and its
/// state there, at rest; `None` for starts that do not say where the root is. `radius` is that of
/// the fibre, m.
///
/// # Errors
/// [`SimError`] of the file, and of a curve that the fibre does not fit.
pub(super) fn placed(
    scene: &Scene,
    bundle: &Bundle,
    natural: &Fiber,
    radius: f64,
    index: usize,
) -> Result<Option<Laid>, SimError> {
    let invalid = |source: FiberError| SimError::Fiber { bundle: index, source };
    let lengths = natural.segment_lengths();
    let (nodes, twist) = match &bundle.initial {
        Initial::Solved { file } => {
            let table = CurveTable::read(file, 1.0, index)?;
            let (fiber, state) =
                in_frames(natural, &table, Vector3::zeros(), 0.0).map_err(invalid)?;
            return Ok(Some(Laid { fiber, state: Some(state), tip: table.last() }));
        }
        Initial::Curve { file, scale, twist } => {
            let (at, twist) = (Vector3::from(bundle.root.position), twist.to_radians());
            if file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) {
                let table = CurveTable::read(file, *scale, index)?;
                let away = at - table.positions[0].coords;
                let (fiber, state) = in_frames(natural, &table, away, twist).map_err(invalid)?;
                return Ok(Some(Laid { fiber, state: Some(state), tip: None }));
            }
            let points = open_curve(file, *scale, index)?;
            let nodes = OpenCurve { points }.nodes(lengths).map_err(invalid)?;
            let away = at - nodes[0].coords;
            (nodes.into_iter().map(|node| node + away).collect::<Vec<_>>(), twist)
        }
        Initial::Wrapped { object, turns, pitch, handedness, lead, angle, along } => {
            let Some(around) = scene.objects.get(*object) else { return Ok(None) };
            let bar = around.shape.radius().unwrap_or_default();
            let wound = Wound {
                radius: bar + radius,
                turns: *turns,
                pitch: *pitch,
                handedness: *handedness,
                lead: *lead,
            };
            let nodes = wound.nodes(lengths).map_err(invalid)?;
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle.to_radians());
            let place = around.start() * Translation3::new(0.0, 0.0, *along) * turn;
            (nodes.iter().map(|node| place * node).collect(), 0.0)
        }
        _ => return Ok(None),
    };
    let root = root_pose(nodes[0], &(nodes[1] - nodes[0])).map_err(invalid)?;
    let fiber = natural.clone().with_root(root);
    let own: Vec<_> = nodes.iter().map(|node| root.inverse_transform_point(node)).collect();
    let mut state = untwisted(&fiber, &own);
    if twist != 0.0 {
        twist_evenly(&fiber, &mut state, twist);
    }
    Ok(Some(Laid { fiber, state: Some(state), tip: None }))
}

/// The fibre and its state in the frames of a table, moved by `away`, m, and twisted by an angle,
/// rad.
fn in_frames(
    natural: &Fiber,
    table: &CurveTable,
    away: Vector3<f64>,
    twist: f64,
) -> Result<(Fiber, RodState), FiberError> {
    let (found, wanted) = (table.length(), natural.length());
    if (found / wanted - 1.0).abs() > 0.01 {
        return Err(FiberError::CurveLength { found, wanted });
    }
    let position = table.positions[0] + away;
    let root = Isometry3::from_parts(Translation3::from(position.coords), table.frames[0]);
    let fiber = natural.clone().with_root(root);
    let (mut way, mut place) = (0.0, position);
    let mut positions = vec![place];
    let mut frames = Vec::new();
    for length in fiber.segment_lengths() {
        let frame = table.frame((way + 0.5 * length) * found / wanted).to_rotation_matrix();
        way += length;
        place += *length * (frame * Vector3::z());
        positions.push(place);
        frames.push(frame);
    }
    let mut state = at_rest(&fiber, positions, frames);
    // At the ends the curvature is that of the table.
    let last = fiber.segments();
    (state.curvatures[0], state.curvatures[last]) = table.curvatures;
    if twist != 0.0 {
        twist_evenly(&fiber, &mut state, twist);
    }
    Ok((fiber, state))
}

/// A state at rest with these nodes and frames.
fn at_rest(fiber: &Fiber, positions: Vec<Point3<f64>>, frames: Vec<Rotation3<f64>>) -> RodState {
    let segments = fiber.segments();
    RodState {
        time: 0.0,
        positions,
        velocities: vec![Vector3::zeros(); segments + 1],
        curvatures: curvatures(fiber, &frames),
        frames,
        angular_velocities: vec![Vector3::zeros(); segments],
        forces: vec![Vector3::zeros(); segments],
    }
}

/// Curvatures at the inner nodes, 1/m; zero at the ends.
fn curvatures(fiber: &Fiber, frames: &[Rotation3<f64>]) -> Vec<Vector3<f64>> {
    let mut curvatures = vec![Vector3::zeros(); frames.len() + 1];
    for (i, pair) in frames.windows(2).enumerate() {
        let between = 0.5 * (fiber.segment_lengths()[i] + fiber.segment_lengths()[i + 1]);
        curvatures[i + 1] = so3::log(&(pair[0].inverse() * pair[1])) / between;
    }
    curvatures
}

/// Turns the sections about the tangents by angles that grow evenly to `twist`, rad, at the tip.
fn twist_evenly(fiber: &Fiber, state: &mut RodState, twist: f64) {
    let mut way = 0.0;
    for (frame, length) in state.frames.iter_mut().zip(fiber.segment_lengths()) {
        let angle = twist * (way + 0.5 * length) / fiber.length();
        *frame *= Rotation3::from_axis_angle(&Vector3::z_axis(), angle);
        way += length;
    }
    let ends = [0, fiber.segments()].map(|node| state.curvatures[node]);
    let rate = twist / fiber.length() * Vector3::z();
    state.curvatures = curvatures(fiber, &state.frames);
    for (node, own) in [0, fiber.segments()].into_iter().zip(ends) {
        state.curvatures[node] = own + rate;
    }
}

/// A state at rest along `nodes`, m, in the root's frame, which is carried along without a twist.
pub(super) fn untwisted(fiber: &Fiber, nodes: &[Point3<f64>]) -> RodState {
    let root = fiber.root();
    let positions = nodes.iter().map(|node| root * node).collect();
    let mut frame = root.rotation.to_rotation_matrix();
    let frames: Vec<_> = nodes
        .windows(2)
        .map(|ends| {
            let tangent = root.rotation * (ends[1] - ends[0]);
            // There is none only for a fibre that turns back on itself.
            let turn = so3::between(&(frame * Vector3::z()), &tangent);
            frame = turn.unwrap_or_default() * frame;
            frame
        })
        .collect();
    at_rest(fiber, positions, frames)
}
