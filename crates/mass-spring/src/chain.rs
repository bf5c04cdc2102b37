use crate::supports::Guide;
use crate::{NodeVectors, SpringError, System};
use nalgebra::SVector;

/// The inextensible limit: all springs keep their rest length, whatever their stiffness.
///
/// The first text cannot reach it, because its spring forces would be infinite. Here the tensions
/// are the unknowns: the RATTLE scheme, symplectic, of second order and reversible, with one
/// tridiagonal matrix for the tensions. The step is limited by the other forces, not by the
/// springs.
#[derive(Debug, Clone, Default)]
pub struct RigidChain {
    /// Tensions of the last step times half of the squared step.
    multipliers: Vec<f64>,
    dt: f64,
}

/// Relative error of the lengths that is allowed.
const TOLERANCE: f64 = 1e-13;

impl RigidChain {
    /// An integrator without tensions of a last step.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Tensions of the segments in the last step, N; negative in compression.
    #[must_use]
    pub fn tensions<const D: usize>(&self, system: &System<D>) -> Vec<f64> {
        let lengths = system.springs.rest_length.iter();
        let tension = |(lambda, length)| -2.0 * lambda * length / (self.dt * self.dt);
        self.multipliers.iter().zip(lengths).map(tension).collect()
    }

    /// Power that the tensions of the last step add to the [power](System::support_power) of
    /// supports, W.
    #[must_use]
    pub fn support_power<const D: usize>(&self, system: &System<D>) -> f64 {
        let mut forces = NodeVectors::zeros(system.nodes());
        for (s, tension) in self.tensions(system).into_iter().enumerate() {
            let edge = system.positions.get(s + 1) - system.positions.get(s);
            let pull = edge * (tension / system.springs.rest_length[s]);
            forces.add(s, &pull);
            forces.add(s + 1, &-pull);
        }
        system.driven_power(|node| forces.get(node))
    }

    /// Moves the system by `steps` steps of `dt` seconds. Springs `0, 1, ...` must connect nodes
    /// 0 and 1, 1 and 2, ..., as in a [`Rope`](crate::Rope).
    ///
    /// # Errors
    /// [`SpringError::Parameter`] for the step; [`SpringError::Count`] if the springs are no chain
    /// or nodes are tied; [`SpringError::NotConverged`] where the ends are farther apart than the
    /// chain is long; [`SpringError::BlownUp`]. After the last two the system is in the middle of a
    /// step: go back to a copy.
    pub fn advance<const D: usize>(
        &mut self,
        system: &mut System<D>,
        dt: f64,
        steps: usize,
    ) -> Result<(), SpringError> {
        crate::error::positive("the time step (s)", dt)?;
        let chained = system.springs.nodes.iter().enumerate().all(|(s, n)| *n == [s, s + 1]);
        if !chained || !system.supports.ties.is_empty() {
            let expected = "a chain: spring s from node s to s + 1, and no ties".to_owned();
            return Err(SpringError::Count { what: "springs", found: system.springs(), expected });
        }
        let weights = inverse_masses(system);
        self.dt = dt;
        self.multipliers.resize(system.springs(), 0.0);
        let mut rates = self.multipliers.clone();
        for step in 1..=steps {
            let before = system.positions.clone();
            let edges = edges(&before);
            kick(system, 0.5 * dt);
            system.positions.add_scaled(dt, &system.velocities);
            self.shorten(system, &weights, &edges)?;
            system.velocities = system.positions.clone();
            system.velocities.add_scaled(-1.0, &before);
            system.velocities.0.iter_mut().flatten().for_each(|v| *v /= dt);
            system.time += dt;
            kick(system, 0.5 * dt);
            turn(system, &weights, &mut rates);
            let all = 0..system.nodes();
            let wrong = system.positions.first_beyond(all.clone());
            if let Some(node) = wrong.or_else(|| system.velocities.first_beyond(all)) {
                return Err(SpringError::BlownUp { step, node });
            }
        }
        Ok(())
    }

    /// Position projection of RATTLE: moves nodes along the old edges until the lengths are right.
    fn shorten<const D: usize>(
        &mut self,
        system: &mut System<D>,
        weights: &NodeVectors<D>,
        old: &[SVector<f64, D>],
    ) -> Result<(), SpringError> {
        self.multipliers.fill(0.0);
        let mut worst = Vec::new();
        for _ in 0..50 {
            let new = edges(&system.positions);
            let rest = &system.springs.rest_length;
            let excess: Vec<_> =
                new.iter().zip(rest).map(|(e, l)| 0.5 * (e.norm_squared() - l * l)).collect();
            let error = |(e, l): (&f64, &f64)| e.abs() / (l * l);
            worst.push(excess.iter().zip(rest).map(error).fold(0.0, f64::max));
            if worst.last().is_some_and(|&w| w <= TOLERANCE) {
                return Ok(());
            }
            let Some(change) = solve(&new, old, weights, excess) else { break };
            for (s, &lambda) in change.iter().enumerate() {
                self.multipliers[s] += lambda;
                pull(&mut system.positions, weights, s, &(old[s] * lambda));
            }
        }
        Err(SpringError::NotConverged {
            what: "a chain with segments of the right length",
            steps: worst,
        })
    }
}

/// Changes the velocities over half a step by all forces but those of the springs.
fn kick<const D: usize>(system: &mut System<D>, dt: f64) {
    let mut springless = std::mem::take(&mut system.springs.runs);
    let a = system.accelerations(system.time, &system.positions, &system.velocities);
    std::mem::swap(&mut system.springs.runs, &mut springless);
    system.velocities.add_scaled(dt, &a);
}

/// Velocity projection of RATTLE: removes from the velocities what would change the lengths.
fn turn<const D: usize>(system: &mut System<D>, weights: &NodeVectors<D>, rates: &mut [f64]) {
    let edges = edges(&system.positions);
    for (s, edge) in edges.iter().enumerate() {
        rates[s] = edge.dot(&(system.velocities.get(s + 1) - system.velocities.get(s)));
    }
    let Some(change) = solve(&edges, &edges, weights, rates.to_vec()) else { return };
    for (s, &rate) in change.iter().enumerate() {
        pull(&mut system.velocities, weights, s, &(edges[s] * rate));
    }
}

fn pull<const D: usize>(
    columns: &mut NodeVectors<D>,
    weights: &NodeVectors<D>,
    s: usize,
    impulse: &SVector<f64, D>,
) {
    columns.add(s, &-weights.get(s).component_mul(impulse));
    columns.add(s + 1, &weights.get(s + 1).component_mul(impulse));
}

fn edges<const D: usize>(x: &NodeVectors<D>) -> Vec<SVector<f64, D>> {
    (1..x.len()).map(|k| x.get(k) - x.get(k - 1)).collect()
}

/// Inverse masses of all components, 1/kg, zero where a component is driven.
fn inverse_masses<const D: usize>(system: &System<D>) -> NodeVectors<D> {
    let mut weights = NodeVectors(std::array::from_fn(|_| system.inverse_masses.clone()));
    for &(node, guides) in &system.supports.guided {
        for axis in (0..D).filter(|&axis| guides[axis] == Guide::Driven) {
            weights.0[axis][node] = 0.0;
        }
    }
    weights
}

/// The impulses along `old` edges that take `excess` from the products with `new` ones: a
/// tridiagonal system; `None` if it is singular.
fn solve<const D: usize>(
    new: &[SVector<f64, D>],
    old: &[SVector<f64, D>],
    weights: &NodeVectors<D>,
    mut excess: Vec<f64>,
) -> Option<Vec<f64>> {
    let count = new.len();
    let product = |node: usize, a: &SVector<f64, D>, b: &SVector<f64, D>| {
        a.component_mul(&weights.get(node)).dot(b)
    };
    let mut above = vec![0.0; count];
    for s in 0..count {
        if weights.get(s).max() == 0.0 && weights.get(s + 1).max() == 0.0 {
            // Both ends are held: no impulse moves them, nor comes from them to their neighbors.
            excess[s] = 0.0;
            continue;
        }
        let mut pivot = product(s, &new[s], &old[s]) + product(s + 1, &new[s], &old[s]);
        excess[s] = -excess[s];
        if s > 0 {
            let below = -product(s, &new[s], &old[s - 1]);
            pivot -= below * above[s - 1];
            excess[s] -= below * excess[s - 1];
        }
        let least = 1e-14 * new[s].norm() * old[s].norm() * weights.largest();
        if pivot.is_nan() || pivot.abs() <= least {
            return None;
        }
        if s + 1 < count {
            above[s] = -product(s + 1, &new[s], &old[s + 1]) / pivot;
        }
        excess[s] /= pivot;
    }
    for s in (1..count).rev() {
        excess[s - 1] -= above[s - 1] * excess[s];
    }
    Some(excess)
}
