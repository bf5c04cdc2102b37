use super::coefficients::Coefficients;
use super::motion::{HeldMotion, NodePose};
use super::stage::Trial;
use super::state::BoxState;
use super::units::Units;
use nalgebra::Vector3;
use rapunzel_fiber::so3;

/// Turns the solution at the stage into the state at the end of the step.
#[derive(Debug)]
pub(super) struct StageUpdate {
    pub(super) k: Coefficients,
    pub(super) dt: f64,
    pub(super) units: Units,
    pub(super) root_motion: Option<HeldMotion>,
    pub(super) root_is_held: bool,
}

impl StageUpdate {
    pub(super) fn apply(&self, solution: &Trial, state: &mut BoxState) {
        let u = &self.units;
        let started = state.started;
        self.root(solution, state);
        for (s, x) in state.nodes.iter_mut().zip(&solution.x) {
            self.extrapolate(started, &mut s.v, &mut s.dv, u.speed() * x.v);
            self.extrapolate(started, &mut s.omega, &mut s.domega, x.omega / u.time);
            self.extrapolate(started, &mut s.kappa, &mut s.dkappa, x.kappa / u.length);
            s.n = u.force() * x.n;
        }
        state.started = true;
    }

    /// Extrapolates a value and its derivative to the end of the step, from the value at the stage.
    fn extrapolate(
        &self,
        started: bool,
        value: &mut Vector3<f64>,
        derivative: &mut Vector3<f64>,
        stage: Vector3<f64>,
    ) {
        let change = (stage - *value) / self.k.stage();
        *derivative = self.derivative(started, change, derivative);
        *value += change;
    }

    fn derivative(&self, started: bool, change: Vector3<f64>, old: &Vector3<f64>) -> Vector3<f64> {
        let slope = change / self.dt;
        // A first step knows no old derivative; its mean slope is one of the first order, which
        // is all that the second order of the following steps needs.
        if started { slope.zip_map(old, |s, o| self.k.derivative(s, o)) } else { slope }
    }

    fn root(&self, solution: &Trial, state: &mut BoxState) {
        let u = &self.units;
        let x = &solution.x[0];
        let c = self.k.rate(self.dt);
        let d = self.k.memory();
        let started = state.started;
        // c (y_stage - y_0) + d y'_0 = rate at the stage, for position and rotation alike.
        let change =
            |rate: Vector3<f64>, old: &Vector3<f64>| (rate - d * old) / (c * self.k.stage());
        let velocity = solution.frames[0] * x.v * u.speed();
        let shift = change(velocity, &state.root_velocity);
        let turn = change(x.omega / u.time, &state.root_rate);
        state.root_velocity = self.derivative(started, shift, &state.root_velocity);
        state.root_rate = self.derivative(started, turn, &state.root_rate);
        let end: Option<NodePose> = self.root_motion.map(|m| m.end);
        state.root.position = end.map_or(state.root.position + shift, |e| e.position);
        state.root.frame = match end {
            Some(pose) if self.root_is_held => pose.frame,
            _ => so3::quaternion(&(state.root.frame * so3::exp(&turn))).to_rotation_matrix(),
        };
    }
}
