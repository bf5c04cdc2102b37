use super::motion::NodePose;
use super::stage::rebuild_frames;
use crate::{Energy, Rod, RodError, RodState};
use nalgebra::{Point3, Rotation3, Vector3};
use rapunzel_fiber::so3;

/// Corrections of curvatures that are recomputed from frames. Each leaves `sin^2(k h / 2)` of a
/// wave of wave number k: four suffice for all that a mesh resolves.
const FITS: usize = 4;

/// Values and time derivatives at a node, material frame, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NodeState {
    pub(super) v: Vector3<f64>,
    pub(super) omega: Vector3<f64>,
    pub(super) kappa: Vector3<f64>,
    pub(super) dv: Vector3<f64>,
    pub(super) domega: Vector3<f64>,
    pub(super) dkappa: Vector3<f64>,
    /// Internal force at the stage of the last step.
    pub(super) n: Vector3<f64>,
}

/// State that the integrator carries from step to step, SI.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BoxState {
    pub(super) time: f64,
    pub(super) root: NodePose,
    /// Derivative of the root's position that the scheme carries, m/s, world.
    pub(super) root_velocity: Vector3<f64>,
    /// Derivative of the root's rotation that the scheme carries, rad/s, material frame.
    pub(super) root_rate: Vector3<f64>,
    /// Whether the time derivatives are those of a previous step.
    pub(super) started: bool,
    pub(super) nodes: Vec<NodeState>,
}

impl BoxState {
    /// Copies `other`, which has as many nodes, without allocation.
    pub(super) fn copy_from(&mut self, other: &Self) {
        let mut nodes = std::mem::take(&mut self.nodes);
        nodes.clone_from(&other.nodes);
        *self = Self { nodes, ..*other };
    }

    /// Unloaded shape at rest at time 0.
    pub(super) fn rest(rod: &Rod) -> Self {
        let o = Vector3::zeros();
        let root = rod.fiber.root();
        Self {
            time: 0.0,
            root: NodePose {
                position: root.translation.vector,
                frame: root.rotation.to_rotation_matrix(),
            },
            root_velocity: o,
            root_rate: o,
            started: false,
            nodes: rod
                .fiber
                .nodes()
                .iter()
                .map(|p| NodeState {
                    v: o,
                    omega: o,
                    kappa: p.natural_curvature,
                    dv: o,
                    domega: o,
                    dkappa: o,
                    n: o,
                })
                .collect(),
        }
    }

    /// Calls `put(segment, middle frame, frame of the next node, position of the next node)` from
    /// root to tip. Segments are straight along their middle frame, so they keep their length.
    pub(super) fn walk(
        &self,
        rod: &Rod,
        mut put: impl FnMut(usize, Rotation3<f64>, Rotation3<f64>, Vector3<f64>),
    ) {
        let lengths = rod.fiber.segment_lengths();
        let mut position = self.root.position;
        rebuild_frames(
            self.root.frame,
            self.nodes
                .windows(2)
                .zip(lengths)
                .map(|(x, h)| so3::exp(&(0.25 * *h * (x[0].kappa + x[1].kappa)))),
            |i, _, middle, frame| {
                position += lengths[i] * (middle * Vector3::z());
                put(i, middle, frame, position);
            },
        );
    }

    /// Pose of the tip.
    pub(super) fn tip(&self, rod: &Rod) -> NodePose {
        let mut tip = self.root;
        self.walk(rod, |_, _, frame, position| tip = NodePose { position, frame });
        tip
    }

    fn middles(&self, rod: &Rod) -> Vec<Rotation3<f64>> {
        let mut middles = Vec::with_capacity(rod.fiber.segments());
        self.walk(rod, |_, middle, _, _| middles.push(middle));
        middles
    }

    /// Largest difference (Frobenius norm) between the frames of the segments and `frames`.
    fn misfit(&self, rod: &Rod, frames: &[Rotation3<f64>]) -> f64 {
        let middles = self.middles(rod);
        let gaps = middles.iter().zip(frames).map(|(a, b)| (a.matrix() - b.matrix()).norm());
        gaps.fold(0.0, f64::max)
    }

    pub(super) fn read(&self, rod: &Rod) -> RodState {
        let mut state = RodState {
            time: self.time,
            positions: vec![Point3::from(self.root.position)],
            velocities: vec![self.root.frame * self.nodes[0].v],
            frames: Vec::new(),
            angular_velocities: Vec::new(),
            forces: Vec::new(),
            curvatures: self.nodes.iter().map(|x| x.kappa).collect(),
        };
        self.walk(rod, |i, middle, frame, position| {
            let (a, b) = (&self.nodes[i], &self.nodes[i + 1]);
            state.positions.push(Point3::from(position));
            state.velocities.push(frame * b.v);
            state.frames.push(middle);
            state.angular_velocities.push(0.5 * (a.omega + b.omega));
            state.forces.push(middle * (0.5 * (a.n + b.n)));
        });
        state
    }

    /// The state for which [`BoxState::read`] returns `state`, up to forces and time derivatives.
    pub(super) fn from_read(state: &RodState, rod: &Rod) -> Result<Self, RodError> {
        check(state, rod.fiber.segments())?;
        let h = rod.fiber.segment_lengths();
        let mut new = Self::rest(rod);
        new.time = state.time;
        new.root.position = state.positions[0].coords;
        let adopt = |new: &mut Self, kappa: &[Vector3<f64>]| {
            new.nodes.iter_mut().zip(kappa).for_each(|(x, k)| x.kappa = *k);
            let half = so3::exp(&(-0.25 * h[0] * (kappa[0] + kappa[1])));
            let frame = state.frames[0] * half;
            new.root.frame = so3::quaternion(&frame).to_rotation_matrix();
        };
        // Curvatures at nodes follow from the frames only up to an alternating part; those given
        // decide it where they fit the frames, and are recomputed where they do not.
        adopt(&mut new, &state.curvatures);
        if new.misfit(rod, &state.frames) > 1e-8 && h.len() > 1 {
            let target = bends(&state.frames, h);
            let mut kappa = extended(&target);
            for _ in 0..FITS {
                adopt(&mut new, &kappa);
                let found = bends(&new.middles(rod), h);
                let missing: Vec<_> = target.iter().zip(&found).map(|(t, f)| t - f).collect();
                kappa.iter_mut().zip(extended(&missing)).for_each(|(k, m)| *k += m);
            }
            adopt(&mut new, &kappa);
        }
        let omega = nodal(&state.angular_velocities);
        for (x, omega) in new.nodes.iter_mut().zip(omega) {
            x.omega = omega;
        }
        new.nodes[0].v = new.root.frame.inverse() * state.velocities[0];
        let mut frames = Vec::new();
        new.walk(rod, |_, _, frame, _| frames.push(frame));
        for i in 0..h.len() {
            new.nodes[i + 1].v = frames[i].inverse() * state.velocities[i + 1];
        }
        Ok(new)
    }

    /// Kinetic and elastic energy of the segment means, and the potential of gravity.
    pub(super) fn energy(&self, rod: &Rod, gravity: &Vector3<f64>) -> Energy {
        let fiber = &rod.fiber;
        let mut energy = Energy::default();
        let mut last = self.root.position;
        self.walk(rod, |i, _, _, position| {
            let (a, b) = (&self.nodes[i], &self.nodes[i + 1]);
            let (p, q) = (&fiber.nodes()[i], &fiber.nodes()[i + 1]);
            let (h, mass) = (fiber.segment_lengths()[i], fiber.segment_mass(i));
            let omega = 0.5 * (a.omega + b.omega);
            let strain = 0.5 * (a.kappa + b.kappa - p.natural_curvature - q.natural_curvature);
            let inertia = 0.5 * (p.rotary_inertia + q.rotary_inertia);
            let stiffness = 0.5 * (p.stiffness + q.stiffness);
            energy.kinetic += 0.5 * mass * (0.5 * (a.v + b.v)).norm_squared()
                + 0.5 * h * omega.dot(&inertia.component_mul(&omega));
            energy.elastic += 0.5 * h * strain.dot(&stiffness.component_mul(&strain));
            energy.gravitational -= mass * gravity.dot(&(0.5 * (last + position)));
            last = position;
        });
        energy
    }

    /// Appends the whole state as numbers.
    pub(super) fn save(&self, numbers: &mut Vec<f64>) {
        numbers.push(self.time);
        numbers.push(f64::from(u8::from(self.started)));
        numbers.extend(self.root.frame.matrix().iter());
        for v in [&self.root.position, &self.root_velocity, &self.root_rate] {
            numbers.extend(v.iter());
        }
        for x in &self.nodes {
            for v in [&x.v, &x.omega, &x.kappa, &x.dv, &x.domega, &x.dkappa, &x.n] {
                numbers.extend(v.iter());
            }
        }
    }

    /// Number of scalars that [`BoxState::save`] appends.
    pub(super) fn saved_len(&self) -> usize {
        20 + 21 * self.nodes.len()
    }

    /// Restores the state from the [`BoxState::saved_len`] numbers of [`BoxState::save`].
    pub(super) fn restore(&mut self, numbers: &[f64]) {
        let vector = |i: usize| Vector3::new(numbers[i], numbers[i + 1], numbers[i + 2]);
        self.time = numbers[0];
        self.started = numbers[1] != 0.0;
        let frame = nalgebra::Matrix3::from_column_slice(&numbers[2..11]);
        self.root.frame = Rotation3::from_matrix_unchecked(frame);
        self.root.position = vector(11);
        self.root_velocity = vector(14);
        self.root_rate = vector(17);
        for (j, x) in self.nodes.iter_mut().enumerate() {
            let at = |k: usize| vector(20 + 21 * j + 3 * k);
            *x = NodeState {
                v: at(0),
                omega: at(1),
                kappa: at(2),
                dv: at(3),
                domega: at(4),
                dkappa: at(5),
                n: at(6),
            };
        }
    }
}

fn check(state: &RodState, segments: usize) -> Result<(), RodError> {
    let lengths = [
        ("positions", segments + 1, state.positions.len()),
        ("velocities", segments + 1, state.velocities.len()),
        ("frames", segments, state.frames.len()),
        ("angular velocities", segments, state.angular_velocities.len()),
        ("curvatures", segments + 1, state.curvatures.len()),
    ];
    for (what, expected, found) in lengths {
        if expected != found {
            return Err(RodError::Length { what, expected, found });
        }
    }
    let vectors = state.velocities.iter().chain(&state.angular_velocities).chain(&state.curvatures);
    let finite = state.time.is_finite()
        && state.positions[0].iter().all(|x| x.is_finite())
        && state.frames.iter().all(|f| f.matrix().iter().all(|x| x.is_finite()))
        && vectors.flat_map(|v| v.iter()).all(|x| x.is_finite());
    if finite {
        Ok(())
    } else {
        Err(RodError::Invalid { what: "rod state", why: "every number must be finite" })
    }
}

/// Curvatures at the inner nodes as differences of frames at the midpoints of segments: means of
/// what the scheme has there, `(kappa_(j-1) + 2 kappa_j + kappa_(j+1)) / 4`.
fn bends(frames: &[Rotation3<f64>], h: &[f64]) -> Vec<Vector3<f64>> {
    let bend = |(m, h): (&[Rotation3<f64>], &[f64])| {
        so3::log(&(m[0].inverse() * m[1])) / (0.5 * (h[0] + h[1]))
    };
    frames.windows(2).zip(h.windows(2)).map(bend).collect()
}

/// Values at inner nodes, continued on straight lines to the ends.
fn extended(inner: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let last = inner.len() - 1;
    let beyond = |end: usize, next: usize| 2.0 * inner[end] - inner[next];
    let mut all = vec![beyond(0, 1.min(last))];
    all.extend_from_slice(inner);
    all.push(beyond(last, last.saturating_sub(1)));
    all
}

/// The least rough values at the nodes whose means over the segments are `means`.
fn nodal(means: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    // x_0 = 0 gives one solution; all others differ by an alternating part (-1)^j a.
    let mut x = vec![Vector3::zeros()];
    for (j, mean) in means.iter().enumerate() {
        x.push(2.0 * mean - x[j]);
    }
    let mut sum = Vector3::zeros();
    for j in 0..means.len() {
        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
        sum += sign * (x[j + 1] - x[j]);
    }
    let a = sum / (2.0 * means.len() as f64);
    for (j, x) in x.iter_mut().enumerate() {
        *x += if j % 2 == 0 { a } else { -a };
    }
    x
}
