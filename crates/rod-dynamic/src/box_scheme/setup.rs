use super::coefficients::Coefficients;
use super::ends::{MixedLoad, StageEnd};
use super::motion::{HeldMotion, Moving, NodePose};
use super::span::{Side, Span};
use super::stage::{RootFrame, Segment, StageEquations};
use super::state::{BoxState, NodeState};
use super::units::{Units, largest};
use super::unknowns::{NodeLaw, Scales, Unknowns};
use super::update::StageUpdate;
use crate::{End, Load, Rod};
use nalgebra::{Rotation3, Vector3};
use rapunzel_fiber::so3;

/// Share of a held tip's distance from its support that is made up in one step. Below 1, so that
/// the correction is damped at every `rho_infinity`.
const DRIFT_GAIN: f64 = 0.5;
/// Rounding errors of a sum of a few terms, relative to the largest.
const SETUP_ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Least scale of the residuals, for a rod without any load, in units of the solver.
const LEAST_LOAD: f64 = 1e-12;

/// Turns a state and the conditions of a step into the equations of the step.
#[derive(Debug)]
pub(super) struct Setup<'a> {
    rod: &'a Rod,
    state: &'a BoxState,
    node_forces: &'a [Vector3<f64>],
    span: &'a Span,
    k: Coefficients,
    dt: f64,
    tolerance: f64,
    acceleration: f64,
    units: Units,
    root_motion: Option<HeldMotion>,
    /// Pose of the tip at the start of the step.
    tip_now: NodePose,
}

impl<'a> Setup<'a> {
    pub(super) fn new(
        rod: &'a Rod,
        state: &'a BoxState,
        node_forces: &'a [Vector3<f64>],
        span: &'a Span,
        k: Coefficients,
        dt: f64,
        tolerance: f64,
    ) -> Self {
        let acceleration = acceleration(rod, node_forces, span);
        let units = Units::of(&rod.fiber, acceleration);
        let root_motion = span.root_motion(&state.root, units.length);
        Self {
            rod,
            state,
            node_forces,
            span,
            k,
            dt,
            tolerance,
            acceleration,
            units,
            root_motion,
            tip_now: state.tip(rod),
        }
    }

    /// Writes the equations of the step into `stage`.
    pub(super) fn fill(&self, stage: &mut StageEquations) {
        stage.c = self.k.rate(self.dt) * self.units.time;
        self.fill_nodes(stage);
        self.fill_segments(stage);
        let units = &self.units;
        let zero = Vector3::zeros();
        (stage.drag, stage.wind) = self.span.stage.air.map_or((zero, zero), |air| {
            let d = air.drag;
            let drag = Vector3::new(d.normal, d.normal, d.tangential) / units.drag();
            (drag, air.wind / units.speed())
        });
        let moving = self.root_motion.map(|m| self.in_units(m.at(self.k.stage())));
        (stage.root, stage.root_frame) = match (self.span.end(Side::Root), moving) {
            (End::Loaded { force, moment }, _) => {
                (self.loaded(&force, &moment, &self.node_forces[0]), self.free_root())
            }
            (End::Held(_), Some(m)) => (
                StageEnd::Held { velocity: m.velocity, angular_velocity: m.angular_velocity },
                RootFrame::Fixed(m.frame),
            ),
            (end, m) => {
                let velocity = m.map_or(zero, |m| m.velocity);
                (StageEnd::Pinned { velocity, moment: self.pin_moment(&end) }, self.free_root())
            }
        };
        stage.tip = self.tip();
        stage.scales = self.scales(stage);
    }

    /// Writes the starting point of Newton's method, the old state.
    pub(super) fn start(&self, x: &mut [Unknowns]) {
        let u = &self.units;
        for (x, s) in x.iter_mut().zip(&self.state.nodes) {
            *x = Unknowns {
                v: s.v / u.speed(),
                omega: s.omega * u.time,
                kappa: s.kappa * u.length,
                n: s.n / u.force(),
            };
        }
    }

    /// The map from the solution at the stage to the state at the end of the step.
    pub(super) fn update(&self) -> StageUpdate {
        StageUpdate {
            k: self.k,
            dt: self.dt,
            units: self.units,
            root_motion: self.root_motion,
            root_is_held: matches!(self.span.end(Side::Root), End::Held(_)),
        }
    }

    fn fill_nodes(&self, stage: &mut StageEquations) {
        let Units { length, time, .. } = self.units;
        let (c, d) = (stage.c, self.k.memory() * time);
        let tau = self.rod.damping_time / time;
        for ((law, s), p) in
            stage.nodes.iter_mut().zip(&self.state.nodes).zip(self.rod.fiber.nodes())
        {
            let stiffness = p.stiffness / self.units.stiffness();
            let b_kappa = length * (d * s.dkappa - c * s.kappa);
            let unloaded = length * p.natural_curvature;
            *law = NodeLaw {
                b_v: (d * s.dv - c * s.v) / self.units.speed(),
                b_omega: time * (d * s.domega - c * s.omega),
                b_kappa,
                stiffness: (1.0 + tau * c) * stiffness,
                offset: stiffness.component_mul(&(tau * b_kappa - unloaded)),
            };
        }
    }

    /// Scales of the residuals: the loads and internal forces that act, but not finer than rounding
    /// lets the largest terms cancel.
    fn scales(&self, stage: &StageEquations) -> Scales {
        let u = &self.units;
        let nodes = &self.state.nodes;
        let c = stage.c;
        let v = largest(nodes.iter().map(|s| s.v)) / u.speed();
        let omega = largest(nodes.iter().map(|s| s.omega)) * u.time;
        let kappa = largest(nodes.iter().map(|s| s.kappa)) * u.length;
        let n = largest(nodes.iter().map(|s| s.n)) / u.force();
        let laws = || stage.nodes.iter().zip(nodes);
        let moment = largest(laws().map(|(law, s)| law.moment(&(u.length * s.kappa))));
        let terms = largest(laws().map(|(law, s)| law.stiffness.component_mul(&s.kappa)));
        let finest = stage.segments.iter().map(|s| s.h).fold(f64::INFINITY, f64::min);
        let rounding = SETUP_ROUNDING / self.tolerance;
        // A support that moves otherwise than the end did accelerates the rod.
        let jolt = |end: &StageEnd, x: &NodeState, frame: Rotation3<f64>| match end {
            StageEnd::Held { velocity, .. } | StageEnd::Pinned { velocity, .. } => {
                c * (velocity - frame * x.v / u.speed()).norm()
            }
            StageEnd::Loaded { .. } => 0.0,
        };
        let last = nodes.len() - 1;
        let jolts = jolt(&stage.root, &nodes[0], self.state.root.frame)
            + jolt(&stage.tip, &nodes[last], self.tip_now.frame);
        let load = LEAST_LOAD
            + self.acceleration / u.acceleration()
            + n
            + moment
            + omega * (omega + v)
            + jolts;
        let rate = load / c + omega;
        Scales {
            segment: [
                load + rounding * c * v,
                load + rounding * u.length * terms / finest,
                rate + rounding * c * kappa,
                rate,
            ],
            end_velocity: load / c + v + omega,
            end_load: load + rounding * u.length * terms,
        }
    }

    fn fill_segments(&self, stage: &mut StageEquations) {
        let fiber = &self.rod.fiber;
        let (nodes, lengths) = (fiber.nodes(), fiber.segment_lengths());
        let last = lengths.len() - 1;
        let instant = &self.span.stage;
        for (i, segment) in stage.segments.iter_mut().enumerate() {
            let (h, a, b) = (lengths[i], &nodes[i], &nodes[i + 1]);
            let rho = 0.5 * (a.linear_density + b.linear_density);
            let inertia = 0.5 * (a.rotary_inertia + b.rotary_inertia);
            let mut force = rho * instant.gravity + instant.distributed;
            // The force on an inner node is spread over its two segments so that its moment about
            // the node vanishes; those on the end nodes join the loads of the ends.
            if i > 0 {
                force += self.node_forces[i] * (lengths[i - 1] / ((lengths[i - 1] + h) * h));
            }
            if i < last {
                force += self.node_forces[i + 1] * (lengths[i + 1] / ((lengths[i + 1] + h) * h));
            }
            *segment = Segment {
                h: h / self.units.length,
                rho: rho / self.units.line_density,
                inertia: inertia / self.units.inertia(),
                force: force / self.units.force_per_length(),
            };
        }
    }

    /// Converts rates per step to the units of the solver.
    fn in_units(&self, m: Moving) -> Moving {
        let per_step = self.units.time / self.dt;
        Moving {
            velocity: m.velocity * (per_step / self.units.length),
            angular_velocity: m.angular_velocity * per_step,
            ..m
        }
    }

    fn free_root(&self) -> RootFrame {
        let b = self.k.memory() * self.units.time * self.state.root_rate;
        RootFrame::Free { start: self.state.root.frame, b }
    }

    fn loaded(&self, force: &Load, moment: &Load, node_force: &Vector3<f64>) -> StageEnd {
        let mut force = MixedLoad::new(force, self.units.force());
        force.world += node_force / self.units.force();
        StageEnd::Loaded { force, moment: MixedLoad::new(moment, self.units.moment()) }
    }

    fn pin_moment(&self, end: &End) -> MixedLoad {
        let moment = if let End::Pinned { moment, .. } = end { moment } else { &Load::ZERO };
        MixedLoad::new(moment, self.units.moment())
    }

    /// Boundary condition of the tip. The scheme prescribes a held tip's velocity, and its pose
    /// follows from the curvatures; the distance between tip and support, which truncation errors
    /// feed, is reduced in every step by a share of itself.
    fn tip(&self) -> StageEnd {
        let end = self.span.end(Side::Tip);
        if let End::Loaded { force, moment } = &end {
            return self.loaded(force, moment, &self.node_forces[self.node_forces.len() - 1]);
        }
        let now = self.tip_now;
        let (moving, gap, turn) = self.span.tip_motion(&now).map_or_else(
            || (Moving::still(now.frame), Vector3::zeros(), Vector3::zeros()),
            |(motion, start)| {
                let turn = so3::log(&(now.frame.inverse() * start.frame));
                (motion.at(self.k.stage()), start.position - now.position, turn)
            },
        );
        let moving = self.in_units(Moving {
            velocity: moving.velocity + DRIFT_GAIN * gap,
            angular_velocity: moving.angular_velocity + DRIFT_GAIN * turn,
            ..moving
        });
        match end {
            End::Held(_) => StageEnd::Held {
                velocity: moving.velocity,
                angular_velocity: moving.angular_velocity,
            },
            end => {
                let moment = self.pin_moment(&end);
                StageEnd::Pinned { velocity: moving.velocity, moment }
            }
        }
    }
}

/// Largest acceleration that the given loads cause, m/s^2, to choose units by.
fn acceleration(rod: &Rod, node_forces: &[Vector3<f64>], span: &Span) -> f64 {
    let mass = rod.fiber.mass();
    let pull = |side| match span.end(side) {
        End::Loaded { force, moment } => {
            force.components().norm() + moment.components().norm() / rod.fiber.length()
        }
        End::Pinned { moment, .. } => moment.components().norm() / rod.fiber.length(),
        End::Held(_) | End::Supported(_) => 0.0,
    };
    let line = span.stage.distributed.norm() * rod.fiber.length();
    let forces = line + largest(node_forces.iter().copied()) + pull(Side::Root) + pull(Side::Tip);
    span.stage.gravity.norm() + forces / mass
}
