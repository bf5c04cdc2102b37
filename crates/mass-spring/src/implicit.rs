use crate::newton::{Energies, LineSearch};
use crate::{NodeVectors, SpringError, System};

/// The implicit Euler method: of first order, damps what it cannot resolve, stable for any step.
///
/// A step minimises an energy, so it exists for springs of any stiffness, and no step can gain
/// energy while supports and wind rest. Dampers act along the springs as they lie at the start of
/// the step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImplicitEuler {
    /// Largest part of the mean rest length by which the last iteration of Newton's method may move
    /// a node; positive.
    pub tolerance: f64,
}

impl Default for ImplicitEuler {
    fn default() -> Self {
        Self { tolerance: 1e-4 }
    }
}

/// Largest relative residual of the linear equations: Newton's method contracts by it.
const LINEAR: f64 = 3e-2;

impl ImplicitEuler {
    /// Moves the system by one step of `dt` seconds and returns the iterations of Newton's method.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] for the step or the tolerance, [`SpringError::NotConverged`]; the
    /// system is then as it was.
    pub fn step<const D: usize>(
        &self,
        system: &mut System<D>,
        dt: f64,
    ) -> Result<usize, SpringError> {
        crate::error::positive("the time step (s)", dt)?;
        crate::error::positive("the tolerance of Newton's method", self.tolerance)?;
        let rate = 1.0 / dt;
        let inertia = rate * (rate + system.drag);
        let air = system.wind.at(system.time + dt);
        let mut start = system.positions.clone();
        start.add_scaled(dt, &system.velocities);
        // Where inertia and drag alone would take the nodes.
        let mut target = start.clone();
        for axis in 0..D {
            let columns = system.positions.0[axis].iter().zip(&start.0[axis]);
            for (to, (from, free)) in target.0[axis].iter_mut().zip(columns) {
                *to = rate * (rate * free + system.drag * (from + dt * air[axis])) / inertia;
            }
        }
        let energies = Energies { system, inertia, target, damping: rate };
        let search = LineSearch {
            what: "the end of an implicit step",
            tolerance: self.tolerance * system.size(),
            linear: LINEAR,
            caution: 0.0,
            most: 300,
        };
        let (positions, iterations) = energies.least(start, &search)?;
        let mut velocities = positions.clone();
        velocities.add_scaled(-1.0, &system.positions);
        velocities.0.iter_mut().flatten().for_each(|v| *v *= rate);
        // Those of supports are given, not found; rounding must not creep into them.
        system.set_velocities(&velocities)?;
        system.positions = positions;
        system.time += dt;
        Ok(iterations)
    }
}

impl<const D: usize> System<D> {
    /// Moves the nodes to a stable equilibrium near their present positions, at rest: a minimum of
    /// the energy, up to `tolerance`, a fraction of the mean rest length. A saddle that is met, as
    /// from a symmetric start, is left. Wind acts through the drag.
    ///
    /// # Errors
    /// [`SpringError::Parameter`]; [`SpringError::NotConverged`], also where there is no
    /// equilibrium. In both cases the system is as it was.
    pub fn find_equilibrium(&mut self, tolerance: f64) -> Result<(), SpringError> {
        crate::error::positive("the tolerance of an equilibrium", tolerance)?;
        let mut calm = self.clone();
        calm.gravity += self.wind.at(self.time) * self.drag;
        let start = calm.positions.clone();
        let energies =
            Energies { system: &calm, inertia: 0.0, target: start.clone(), damping: 0.0 };
        let search = LineSearch {
            what: "the equilibrium",
            tolerance: tolerance * self.size(),
            linear: 1e-9,
            caution: 1e-2 * self.stiffest(),
            most: 2000,
        };
        let (mut found, mut steps) = energies.least(start, &search)?;
        while let Some(below) = energies.below(&found, search.linear) {
            let (next, more) = energies.least(below, &search)?;
            steps += more;
            if steps > search.most {
                return Err(SpringError::NotConverged { what: search.what, steps: Vec::new() });
            }
            found = next;
        }
        self.positions = found;
        self.velocities = NodeVectors::zeros(self.nodes());
        Ok(())
    }
}
