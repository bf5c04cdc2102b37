use crate::supports::Guide;
use crate::{NodeVectors, SpringError, StepTooLong, System};

/// Ratio of the largest stable step to that of the leapfrog, which reaches to 2 on both axes of the
/// complex plane. The region of the classical method reaches to 2.785 on the real axis and 2.828 on
/// the imaginary.
const REACH: f64 = 2.785 / 2.0;

impl<const D: usize> System<D> {
    /// Warning if a step of [`runge_kutta`] is above its stability limit, else `None`.
    #[must_use]
    pub fn warn_of_runge_kutta_step(&self, dt: f64) -> Option<StepTooLong> {
        let limit = REACH * self.stability_limit();
        (dt >= limit).then_some(StepTooLong { dt, limit, method: "Runge-Kutta method" })
    }

    /// Accelerations at given positions and velocities at time `t`, m/s^2 (world), projected onto
    /// the motions that the supports allow.
    pub(crate) fn accelerations(
        &self,
        t: f64,
        x: &NodeVectors<D>,
        v: &NodeVectors<D>,
    ) -> NodeVectors<D> {
        let mut result = self.internal_forces(x, v);
        for (&node, load) in &self.loads {
            result.add(node, load);
        }
        let common = self.gravity + self.wind.at(t) * self.drag;
        for axis in 0..D {
            let column = &mut result.0[axis];
            for (node, a) in column.iter_mut().enumerate() {
                *a = *a * self.inverse_masses[node] + common[axis] - self.drag * v.0[axis][node];
            }
        }
        for &(node, guides) in &self.supports.guided {
            for axis in (0..D).filter(|&axis| guides[axis] == Guide::Driven) {
                result.0[axis][node] = 0.0;
            }
        }
        for tie in &self.supports.ties {
            let column = &mut result.0[tie.axis];
            let mass = |node: &usize| self.masses[*node];
            let force: f64 = tie.nodes.iter().map(|node| mass(node) * column[*node]).sum();
            let total: f64 = tie.nodes.iter().map(mass).sum();
            tie.nodes.iter().for_each(|&node| column[node] = force / total);
        }
        result
    }
}

/// The classical Runge-Kutta method of fourth order: four evaluations of forces per step.
///
/// Without damping stable below `sqrt(2)` times the limit of the leapfrog, but it loses energy.
///
/// # Errors
/// [`SpringError::Parameter`] for the step; [`SpringError::BlownUp`], and then the system is as it
/// was before that step.
pub fn runge_kutta<const D: usize>(
    system: &mut System<D>,
    dt: f64,
    steps: usize,
) -> Result<(), SpringError> {
    crate::error::positive("the time step (s)", dt)?;
    for step in 1..=steps {
        let (t, x, v) = (system.time, system.positions.clone(), system.velocities.clone());
        let (mut new_x, mut new_v) = (x.clone(), v.clone());
        let (mut at_x, mut at_v) = (x.clone(), v.clone());
        let stages = [(0.0, 0.5, 1.0), (0.5, 0.5, 2.0), (0.5, 1.0, 2.0), (1.0, 0.0, 1.0)];
        for (here, next, weight) in stages {
            let a = system.accelerations(t + here * dt, &at_x, &at_v);
            new_x.add_scaled(weight * dt / 6.0, &at_v);
            new_v.add_scaled(weight * dt / 6.0, &a);
            let velocity = at_v;
            (at_x, at_v) = (x.clone(), v.clone());
            at_x.add_scaled(next * dt, &velocity);
            at_v.add_scaled(next * dt, &a);
        }
        let all = 0..system.nodes();
        let wrong = new_x.first_beyond(all.clone()).or_else(|| new_v.first_beyond(all));
        if let Some(node) = wrong {
            return Err(SpringError::BlownUp { step, node });
        }
        (system.positions, system.velocities) = (new_x, new_v);
        system.time += dt;
    }
    Ok(())
}
