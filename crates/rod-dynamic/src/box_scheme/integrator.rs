use super::coefficients::Coefficients;
use super::ends::StageEnd;
use super::newton::Newton;
use super::setup::Setup;
use super::span::Span;
use super::stage::{RootFrame, Segment, StageEquations};
use super::state::BoxState;
use super::unknowns::{NodeLaw, Scales};
use crate::{
    Conditions, Energy, Rod, RodError, RodIntegrator, RodState, RodStepReport, SectionLaws,
    StepError,
};
use nalgebra::Vector3;

/// A step is halved at most this often.
const HALVINGS: usize = 12;

/// Options of the box scheme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoxOptions {
    /// Weights of the time integration.
    pub coefficients: Coefficients,
    /// Newton's method stops at this residual, relative to the magnitude of the terms.
    pub tolerance: f64,
    /// Newton's method gives up, and the step is halved, after this many iterations.
    pub max_iterations: usize,
}

impl BoxOptions {
    /// The default options with the second-order weights of the given damping.
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless `0 <= rho_infinity <= 1`.
    pub fn with_damping(rho_infinity: f64) -> Result<Self, RodError> {
        Ok(Self { coefficients: Coefficients::second_order(rho_infinity)?, ..Self::default() })
    }
}

impl Default for BoxOptions {
    /// Second order with `rho_infinity` 0.8, residual 1e-10, 25 iterations.
    fn default() -> Self {
        let coefficients =
            Coefficients::second_order(0.8).expect("0.8 is a spectral radius within [0, 1]");
        Self { coefficients, tolerance: 1e-10, max_iterations: 25 }
    }
}

/// The box scheme in space with the generalised-alpha method in time, for one rod.
///
/// See the [module's documentation](crate::box_scheme) for the method.
#[derive(Debug, Clone)]
pub struct BoxIntegrator {
    rod: Rod,
    options: BoxOptions,
    state: BoxState,
    /// The state before the current step, to go back to.
    backup: BoxState,
    node_forces: Vec<Vector3<f64>>,
    stage: StageEquations,
    newton: Newton,
}

impl BoxIntegrator {
    /// The rod at time 0 in its unloaded shape, at rest.
    ///
    /// # Errors
    /// [`RodError::Invalid`] for a damping time that is negative or not finite, laws that are not
    /// linear, or options that make no sense.
    pub fn new(rod: Rod, options: BoxOptions) -> Result<Self, RodError> {
        let invalid = |what, why| Err(RodError::Invalid { what, why });
        if !(rod.damping_time >= 0.0 && rod.damping_time.is_finite()) {
            return invalid("damping_time", "must be finite and not negative (s)");
        }
        if rod.laws != SectionLaws::Linear {
            return invalid(
                "laws",
                "the box scheme has the linear one only; use the staggered rod",
            );
        }
        if !(options.tolerance > 0.0 && options.tolerance < 1.0) {
            return invalid("tolerance", "must lie between 0 and 1");
        }
        if options.max_iterations == 0 {
            return invalid("max_iterations", "must be at least 1");
        }
        let segments = rod.fiber.segments();
        let state = BoxState::rest(&rod);
        let o = Vector3::zeros();
        let law = NodeLaw { b_v: o, b_omega: o, b_kappa: o, stiffness: o, offset: o };
        let held = StageEnd::Held { velocity: o, angular_velocity: o };
        let stage = StageEquations {
            c: 0.0,
            nodes: vec![law; segments + 1],
            segments: vec![Segment { h: 0.0, rho: 0.0, inertia: o, force: o }; segments],
            drag: o,
            wind: o,
            root: held,
            tip: held,
            root_frame: RootFrame::Fixed(state.root.frame),
            scales: Scales { segment: [1.0; 4], end_velocity: 1.0, end_load: 1.0 },
        };
        Ok(Self {
            backup: state.clone(),
            node_forces: vec![o; segments + 1],
            newton: Newton::new(segments),
            rod,
            options,
            state,
            stage,
        })
    }

    /// The options of the integrator.
    #[must_use]
    pub fn options(&self) -> &BoxOptions {
        &self.options
    }

    /// Advances to time `end` in one step, or in two halves where that fails.
    fn advance(
        &mut self,
        end: f64,
        halvings: usize,
        conditions: &dyn Conditions,
        report: &mut RodStepReport,
    ) -> Result<(), StepError> {
        let (start, dt) = (self.state.time, end - self.state.time);
        if self.attempt(end, conditions, report)? {
            return Ok(());
        }
        if halvings == HALVINGS {
            let residuals = self.newton.history.clone();
            return Err(StepError::NotConverged { fiber: 0, time: start, dt, residuals });
        }
        report.halvings += 1;
        self.advance(start + 0.5 * dt, halvings + 1, conditions, report)?;
        self.advance(end, halvings + 1, conditions, report)
    }

    /// One step to time `end`; false, with the state as it was, when Newton's method fails.
    fn attempt(
        &mut self,
        end: f64,
        conditions: &dyn Conditions,
        report: &mut RodStepReport,
    ) -> Result<bool, StepError> {
        // Without derivatives to start from, the first step is one that needs none.
        let memory = self.options.coefficients.memory() != 0.0;
        let k = if memory && !self.state.started {
            Coefficients::MIDPOINT
        } else {
            self.options.coefficients
        };
        let dt = end - self.state.time;
        let span = Span::sample(conditions, self.state.time, dt, &k)?;
        let tolerance = self.options.tolerance;
        let setup = Setup::new(&self.rod, &self.state, &self.node_forces, &span, k, dt, tolerance);
        setup.fill(&mut self.stage);
        setup.start(&mut self.newton.trial.x);
        let (iterations, converged) =
            self.newton.solve(&self.stage, tolerance, self.options.max_iterations);
        report.iterations += iterations;
        report.residual = self.newton.trial.merit.sqrt();
        if converged {
            let update = setup.update();
            update.apply(&self.newton.trial, &mut self.state);
            self.state.time = end;
        }
        Ok(converged)
    }
}

impl RodIntegrator for BoxIntegrator {
    fn rod(&self) -> &Rod {
        &self.rod
    }

    fn time(&self) -> f64 {
        self.state.time
    }

    /// Current state of the rod. Forces are those at the stage of the last step, and zero before
    /// the first step.
    fn state(&self) -> RodState {
        self.state.read(&self.rod)
    }

    /// Restarts from `state`. The root's frame and the curvatures are taken over where they agree
    /// with the frames, and recomputed from the frames where they do not.
    fn set_state(&mut self, state: &RodState) -> Result<(), RodError> {
        self.state = BoxState::from_read(state, &self.rod)?;
        Ok(())
    }

    fn set_node_forces(&mut self, forces: &[Vector3<f64>]) -> Result<(), RodError> {
        let (expected, found) = (self.node_forces.len(), forces.len());
        if expected != found {
            return Err(RodError::Length { what: "node forces", expected, found });
        }
        if !forces.iter().flat_map(|f| f.iter()).all(|x| x.is_finite()) {
            let why = "every number must be finite (N)";
            return Err(RodError::Invalid { what: "node forces", why });
        }
        self.node_forces.copy_from_slice(forces);
        Ok(())
    }

    fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        self.state.energy(&self.rod, gravity)
    }

    fn step(&mut self, dt: f64, conditions: &dyn Conditions) -> Result<RodStepReport, StepError> {
        let end = self.state.time + dt;
        if !(dt > 0.0 && end.is_finite() && end > self.state.time) {
            return Err(StepError::TimeStep(dt));
        }
        self.backup.copy_from(&self.state);
        let mut report = RodStepReport::default();
        let result = self.advance(end, 0, conditions, &mut report);
        if let Err(error) = result {
            self.state.copy_from(&self.backup);
            return Err(error);
        }
        Ok(report)
    }

    fn save(&self, numbers: &mut Vec<f64>) {
        self.state.save(numbers);
        numbers.extend(self.node_forces.iter().flat_map(|f| f.iter()));
    }

    fn restore(&mut self, numbers: &[f64]) -> Result<(), RodError> {
        let state = self.state.saved_len();
        let (expected, found) = (state + 3 * self.node_forces.len(), numbers.len());
        if expected != found {
            return Err(RodError::Length { what: "saved numbers", expected, found });
        }
        self.state.restore(&numbers[..state]);
        for (force, x) in self.node_forces.iter_mut().zip(numbers[state..].chunks_exact(3)) {
            force.copy_from_slice(x);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Air, Drag, End, Instant, Load, Steady};
    use nalgebra::{Isometry3, Point3};
    use rapunzel_fiber::{Fiber, Material, NodeProperties, Section};

    /// A wavy, moving, damped state of an uneven rod under every kind of load.
    fn waving(root: End, tip: End) -> BoxIntegrator {
        let material = Material::HAIR;
        let section = |j: usize| Section::Ellipse { a: 1e-3 * (2.0 - 0.1 * j as f64), b: 1e-3 };
        let nodes = (0..=8).map(|j| NodeProperties::new(section(j), &material)).collect();
        let lengths = (0..8).map(|i| 0.03 + 0.002 * f64::from(i)).collect();
        let fiber = Fiber::new(Isometry3::identity(), lengths, nodes).expect("valid");
        let rod = Rod::damped(fiber, 1e-3);
        let mut integrator = BoxIntegrator::new(rod, BoxOptions::default()).expect("valid");
        let wave = |j: usize, k: f64| {
            let s = j as f64 / 8.0;
            Vector3::new((k + 3.0 * s).sin(), (2.0 * k - 5.0 * s).cos(), (k * k + s).sin())
        };
        integrator.state.started = true;
        integrator.state.root_rate = wave(0, 0.3);
        for (j, x) in integrator.state.nodes.iter_mut().enumerate() {
            x.v = wave(j, 1.0);
            x.omega = 2.0 * wave(j, 2.0);
            x.kappa = 9.0 * wave(j, 3.0);
            (x.dv, x.domega, x.dkappa) = (wave(j, 4.0), wave(j, 5.0), wave(j, 6.0));
            x.n = 0.02 * wave(j, 7.0);
        }
        integrator.node_forces.iter_mut().enumerate().for_each(|(j, f)| *f = wave(j, 8.0) * 1e-3);
        let instant = Instant {
            gravity: Vector3::new(1.0, -9.0, 3.0),
            distributed: Vector3::new(0.02, 0.01, 0.0),
            root,
            tip,
            air: Some(Air {
                wind: Vector3::new(1.0, 2.0, 0.5),
                drag: Drag { normal: 0.03, tangential: 0.01 },
            }),
            inside: 0.0,
        };
        let k = integrator.options.coefficients;
        let span = Span::sample(&Steady(instant), 0.0, 0.02, &k).expect("finite");
        let BoxIntegrator { rod, state, node_forces, stage, newton, .. } = &mut integrator;
        let setup = Setup::new(rod, state, node_forces, &span, k, 0.02, 1e-10);
        setup.fill(stage);
        setup.start(&mut newton.trial.x);
        integrator
    }

    /// All residuals as one list.
    fn residuals(trial: &super::super::stage::Trial) -> Vec<f64> {
        let [root, tip] = &trial.ends;
        trial.residuals.iter().flatten().chain(root).chain(tip).copied().collect()
    }

    /// The Newton increment solves the linearised equations: along it every residual falls at the
    /// rate of its own value. This holds only with an exact Jacobian and an exact elimination.
    #[test]
    fn residuals_vanish_linearly_along_the_newton_step() {
        let push = |world: bool| {
            let (f, m) = (Vector3::new(0.1, 0.2, -0.1), Vector3::new(0.01, -0.02, 0.005));
            if world {
                End::Loaded { force: Load::World(f), moment: Load::World(m) }
            } else {
                End::Loaded { force: Load::Follower(f), moment: Load::Follower(m) }
            }
        };
        let held = End::Held(Isometry3::translation(0.01, 0.0, 0.0));
        let pinned = |moment: fn(Vector3<f64>) -> Load| End::Pinned {
            position: Point3::new(0.0, 0.01, 0.0),
            moment: moment(Vector3::new(-0.01, 0.02, 0.015)),
        };
        let (turned, twisted) = (pinned(Load::World), pinned(Load::Follower));
        for root in [held, turned, twisted, push(true), push(false)] {
            for tip in [push(true), push(false), held, turned, twisted] {
                let mut integrator = waving(root, tip);
                let BoxIntegrator { stage, newton, .. } = &mut integrator;
                stage.evaluate(&mut newton.trial);
                let increments = newton.increments(stage);
                let at = |mu: f64| {
                    let mut trial = newton.trial.clone();
                    trial.x.iter_mut().zip(&increments).for_each(|(x, d)| *x = x.plus(mu, d));
                    stage.evaluate(&mut trial);
                    residuals(&trial)
                };
                let size = residuals(&newton.trial).iter().fold(0.0_f64, |m, f| m.max(f.abs()));
                let eps = 1e-6;
                let (plus, minus) = (at(eps), at(-eps));
                for (r, f) in residuals(&newton.trial).iter().enumerate() {
                    let slope = (plus[r] - minus[r]) / (2.0 * eps);
                    assert!(
                        (slope + f).abs() < 1e-7 * size,
                        "{root:?} {tip:?} row {r}: {slope} {f}"
                    );
                }
            }
        }
    }
}
