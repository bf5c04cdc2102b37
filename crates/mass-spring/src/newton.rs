//! Minimisation of an energy: a step of the implicit integrator and an equilibrium are both minima.

use crate::gradients::solve;
use crate::tangent::Tangent;
use crate::{NodeVectors, SpringError, System};

/// Curvature of the energy, relative to that of the stiffest spring, below which a direction counts
/// as neutral.
const NEUTRAL: f64 = 1e-9;
/// A number without small multiples of `pi`: phases of a push that no symmetry shares.
const GENERIC: f64 = 2.399_963_229_728_653;
/// Trial distances along directions of negative curvature, in mean rest lengths.
const FALLS: [f64; 4] = [0.01, 0.03, 0.1, 0.3];

/// `inertia |x - target|^2 / 2` in the metric of the masses, plus the energy of springs, bends,
/// gravity and loads, plus `damping mu (d . change)^2 / 2` for every damper, where `d` is its
/// direction at the start and `change` that of the distance of its nodes since.
pub(crate) struct Energies<'a, const D: usize> {
    pub(crate) system: &'a System<D>,
    pub(crate) inertia: f64,
    pub(crate) target: NodeVectors<D>,
    /// The inverse of the time step, or zero.
    pub(crate) damping: f64,
}

/// Parameters of the minimisation.
pub(crate) struct LineSearch {
    /// Name of what is sought, for the error message.
    pub(crate) what: &'static str,
    /// The iteration ends when a step moves no component by more than this, m.
    pub(crate) tolerance: f64,
    /// Largest relative residual of the linear equations.
    pub(crate) linear: f64,
    /// Additional inertia to begin with, 1/s^2; it vanishes as the minimum comes near.
    pub(crate) caution: f64,
    /// Largest number of steps.
    pub(crate) most: usize,
}

impl<const D: usize> Energies<'_, D> {
    fn value(&self, x: &NodeVectors<D>) -> f64 {
        let system = self.system;
        let mut sum = system.elastic_energy(x);
        let mut away = x.clone();
        away.add_scaled(-1.0, &self.target);
        for axis in 0..D {
            for (node, &mass) in system.masses.iter().enumerate() {
                let (a, g) = (away.0[axis][node], system.gravity[axis]);
                sum += mass * (0.5 * self.inertia * a * a - g * x.0[axis][node]);
            }
        }
        sum -= system.loads.iter().map(|(&node, f)| f.dot(&x.get(node))).sum::<f64>();
        self.dampers(x, |_, stiffness, stretch| sum += 0.5 * stiffness * stretch * stretch);
        sum
    }

    /// Forces at the positions `x`: minus the gradient of the energy, N.
    fn forces(&self, x: &NodeVectors<D>) -> NodeVectors<D> {
        let system = self.system;
        let mut forces = system.internal_forces(x, &NodeVectors::zeros(system.nodes()));
        for axis in 0..D {
            for (node, &mass) in system.masses.iter().enumerate() {
                let away = self.target.0[axis][node] - x.0[axis][node];
                forces.0[axis][node] += mass * (self.inertia * away + system.gravity[axis]);
            }
        }
        system.loads.iter().for_each(|(&node, load)| forces.add(node, load));
        self.dampers(x, |s, stiffness, stretch| {
            let [i, j] = system.springs.nodes[s];
            let d = system.positions.get(j) - system.positions.get(i);
            let force = d * (stiffness * stretch / d.norm().max(f64::MIN_POSITIVE));
            forces.add(i, &force);
            forces.add(j, &-force);
        });
        system.supports.project(&mut forces);
        forces
    }

    /// Calls `visit` for every damper with its damping constant times `damping`, and its elongation
    /// since the start.
    fn dampers(&self, x: &NodeVectors<D>, mut visit: impl FnMut(usize, f64, f64)) {
        let springs = &self.system.springs;
        if !springs.damped || self.damping == 0.0 {
            return;
        }
        let start = &self.system.positions;
        for (s, &[i, j]) in springs.nodes.iter().enumerate() {
            let before = start.get(j) - start.get(i);
            let change = x.get(j) - x.get(i) - before;
            let along = change.dot(&before) / before.norm().max(f64::MIN_POSITIVE);
            visit(s, self.damping * springs.damping[s], along);
        }
    }

    /// The minimum of the energy near `x`, by Newton's method with a line search, and the number of
    /// its steps. Where the matrix is not positive definite, its convex part is used.
    pub(crate) fn least(
        &self,
        mut x: NodeVectors<D>,
        search: &LineSearch,
    ) -> Result<(NodeVectors<D>, usize), SpringError> {
        let stiffest = self.system.stiffest();
        let mut caution = search.caution;
        let mut steps = Vec::new();
        let mut value = self.value(&x);
        for _ in 0..search.most {
            let forces = self.forces(&x);
            let tangent = |convex| {
                Tangent::new(self.system, &x, self.inertia + caution, self.damping, convex)
            };
            let step = solve(&tangent(false), &forces, search.linear)
                .or_else(|_| solve(&tangent(true), &forces, search.linear));
            let Ok(step) = step else {
                // Even the convex part is singular: it needs inertia.
                caution = (10.0 * caution).max(1e-6 * stiffest);
                continue;
            };
            let slope = -forces.dot(&step);
            let (mut fraction, mut best) = (1.0, None);
            while best.is_none() && fraction > 1e-6 {
                let mut next = x.clone();
                next.add_scaled(fraction, &step);
                let next_value = self.value(&next);
                // Where it is flat, rounding hides the descent.
                let flat = 1e-13 * value.abs();
                if next_value <= value + 1e-4 * fraction * slope + flat {
                    best = Some((next, next_value));
                } else {
                    fraction *= 0.5;
                }
            }
            let size = step.largest();
            steps.push(size);
            let Some((next, next_value)) = best else {
                if size <= search.tolerance {
                    return Ok((x, steps.len()));
                }
                caution = (10.0 * caution).max(1e-6 * stiffest);
                continue;
            };
            (x, value) = (next, next_value);
            if fraction == 1.0 {
                if size <= search.tolerance && caution <= 1e-3 * self.inertia + 1e-11 * stiffest {
                    return Ok((x, steps.len()));
                }
                caution = if caution > 1e-13 * stiffest { 0.1 * caution } else { 0.0 };
            } else {
                caution = (4.0 * caution).max(1e-4 * stiffest);
            }
        }
        Err(SpringError::NotConverged { what: search.what, steps })
    }
}

impl<const D: usize> Energies<'_, D> {
    /// Positions of less energy near the equilibrium `x`, if it is a saddle: along the negative
    /// curvature that a push without any symmetry finds. A neutral equilibrium counts as stable.
    pub(crate) fn below(&self, x: &NodeVectors<D>, linear: f64) -> Option<NodeVectors<D>> {
        let system = self.system;
        let tangent = Tangent::new(system, x, NEUTRAL * system.stiffest(), self.damping, false);
        let mut push = NodeVectors::zeros(system.nodes());
        for (axis, column) in push.0.iter_mut().enumerate() {
            for (node, push) in column.iter_mut().enumerate() {
                *push = (1.0 + GENERIC * (node * D + axis) as f64).sin();
            }
        }
        system.supports.project(&mut push);
        let way = solve(&tangent, &push, linear).err()?;
        let unit = system.size() / way.largest();
        let along = FALLS.into_iter().flat_map(|size| [size, -size]).map(|size| {
            let mut to = x.clone();
            to.add_scaled(size * unit, &way);
            (self.value(&to), to)
        });
        let (value, lowest) = along.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (value < self.value(x)).then_some(lowest)
    }
}

impl<const D: usize> System<D> {
    /// Largest ratio of a spring's stiffness to the mass of a node, 1/s^2.
    pub(crate) fn stiffest(&self) -> f64 {
        let springs = self.springs.nodes.iter().zip(&self.springs.stiffness);
        let ratio = |(nodes, k): (&[usize; 2], &f64)| {
            nodes.map(|node| k * self.inverse_masses[node]).into_iter().fold(0.0, f64::max)
        };
        springs.map(ratio).fold(f64::MIN_POSITIVE, f64::max)
    }
}
