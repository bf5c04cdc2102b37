use crate::columns::BEYOND;
use crate::force::add_run;
use crate::supports::Guide;
use crate::{NodeVectors, SpringError, System};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// The leapfrog: symplectic, of second order, reversible, one evaluation of forces per step.
///
/// Positions go half a step, velocities a whole one, positions half a step; the halves between two
/// steps of one call are done as one. Node drag is averaged over the step, dampers use the velocity
/// before it. Stable below the [limit](System::stability_limit). The texts use the same method, but
/// leave the velocities half a step behind.
#[derive(Debug, Clone, Default)]
pub struct Leapfrog<const D: usize> {
    /// Forces of springs, bends and loads; zero between calls.
    forces: NodeVectors<D>,
}

impl<const D: usize> Leapfrog<D> {
    /// An integrator whose force array is not allocated yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Moves the system by `steps` steps of `dt` seconds each: the sub-steps of the texts.
    ///
    /// Every step goes through the system once, and nodes move as soon as the last of their springs
    /// has been seen; so the next steps can follow while the numbers are still in the cache.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] for the step; [`SpringError::BlownUp`], and then the system is
    /// not finite: go back to a copy.
    pub fn advance(
        &mut self,
        system: &mut System<D>,
        dt: f64,
        steps: usize,
    ) -> Result<(), SpringError> {
        crate::error::positive("the time step (s)", dt)?;
        if self.forces.len() != system.nodes() {
            self.forces = NodeVectors::zeros(system.nodes());
        }
        let forces = &mut self.forces;
        let result = Arch::new().dispatch(LeapfrogKernel { system, forces, dt, steps });
        if result.is_err() {
            self.forces.clear();
        }
        result
    }
}

struct LeapfrogKernel<'a, const D: usize> {
    system: &'a mut System<D>,
    forces: &'a mut NodeVectors<D>,
    dt: f64,
    steps: usize,
}

/// Number of steps of one call that follow each other through the system, a few runs of springs
/// apart, so that its numbers come from memory once for all of them.
const DEPTH: usize = 4;

/// Progress of a step through the system.
struct Front<const D: usize> {
    kick: Kick<D>,
    /// Index of the next run of springs.
    run: usize,
    /// Number of nodes that have moved.
    done: usize,
    /// The first node beyond all bounds, if there is one.
    fault: Option<usize>,
}

/// Coefficients of the motion of a node in a step, once its forces are known.
struct Kick<const D: usize> {
    dt: f64,
    /// Time by which positions move with the new velocity, s.
    drift: f64,
    /// Factor of the old velocity, reduced by half of the drag.
    keep: f64,
    /// Factor of the new velocity, reduced by the other half of the drag.
    share: f64,
    /// Acceleration by gravity and wind, m/s^2.
    common: [f64; D],
}

impl<const D: usize> WithSimd for LeapfrogKernel<'_, D> {
    type Output = Result<(), SpringError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { system, forces, dt, steps } = self;
        system.positions.add_scaled(0.5 * dt, &system.velocities);
        // Ties and bends wait for all nodes.
        let tied = !system.supports.ties.is_empty();
        let depth = if tied || !system.bends.is_empty() { 1 } else { DEPTH };
        let mut begun = 0;
        while begun < steps {
            let together = depth.min(steps - begun);
            let mut fronts: Vec<_> = (begun + 1..=begun + together)
                .map(|step| {
                    let drift = if step < steps { dt } else { 0.5 * dt };
                    let kick = Kick::new(system, dt, drift);
                    system.time += dt;
                    Front { kick, run: 0, done: 0, fault: None }
                })
                .collect();
            system.bends.iter().for_each(|bend| bend.add_forces(&system.positions, forces));
            go_together(system, forces, &mut fronts, tied);
            let faults = fronts.iter().zip(begun + 1..);
            if let Some((node, step)) = faults.filter_map(|(f, step)| Some((f.fault?, step))).next()
            {
                return Err(SpringError::BlownUp { step, node });
            }
            begun += together;
        }
        Ok(())
    }
}

impl<const D: usize> Kick<D> {
    fn new(system: &System<D>, dt: f64, drift: f64) -> Self {
        let air = system.wind.at(system.time + 0.5 * dt) * system.drag;
        let half = 0.5 * dt * system.drag;
        Self {
            dt,
            drift,
            keep: 1.0 - half,
            share: 1.0 / (1.0 + half),
            common: std::array::from_fn(|axis| system.gravity[axis] + air[axis]),
        }
    }
}

/// Takes several steps that follow each other through the system.
#[inline(always)]
fn go_together<const D: usize>(
    system: &mut System<D>,
    forces: &mut NodeVectors<D>,
    fronts: &mut [Front<D>],
    tied: bool,
) {
    let nodes = system.nodes();
    while fronts.last().is_some_and(|last| last.done < nodes) {
        for k in 0..fronts.len() {
            let bound = if k == 0 { nodes } else { fronts[k - 1].done };
            while fronts[k].go(system, forces, bound, tied) && k > 0 {}
        }
    }
}

impl<const D: usize> Front<D> {
    /// Takes the next run of springs and moves the nodes whose last spring it has. Does nothing,
    /// and reports so, where the step is over or needs nodes from `bound` on.
    #[inline(always)]
    fn go(
        &mut self,
        system: &mut System<D>,
        forces: &mut NodeVectors<D>,
        bound: usize,
        tied: bool,
    ) -> bool {
        let nodes = system.nodes();
        let run = system.springs.runs.get(self.run).copied();
        let (end, frontier) = match run {
            Some(run) if tied => (run.end(), 0),
            Some(run) => (run.end(), run.frontier.min(nodes)),
            None => (nodes, nodes),
        };
        if self.done == nodes || end.max(frontier) > bound {
            return false;
        }
        if let Some(run) = run {
            add_run(&system.springs, &run, &system.positions, &system.velocities, forces);
            self.run += 1;
        }
        if frontier > self.done {
            let range = self.done..frontier;
            self.done = frontier;
            for (&node, load) in system.loads.range(range.clone()) {
                forces.add(node, load);
            }
            let sound = move_free(system, forces, &self.kick, range.clone())
                & move_guided(system, forces, &self.kick, range.clone());
            if !sound && self.fault.is_none() {
                self.fault = system.velocities.first_beyond(range);
            }
        }
        true
    }
}

/// Moves the free nodes in a range.
#[inline(always)]
fn move_free<const D: usize>(
    system: &mut System<D>,
    forces: &mut NodeVectors<D>,
    kick: &Kick<D>,
    nodes: Range<usize>,
) -> bool {
    let mut bits = 0;
    let from = system.supports.free.partition_point(|free| free.end <= nodes.start);
    for free in &system.supports.free[from..] {
        if free.start >= nodes.end {
            break;
        }
        let range = free.start.max(nodes.start)..free.end.min(nodes.end);
        let inverse_masses = &system.inverse_masses[range.clone()];
        for axis in 0..D {
            bits |= move_column(
                &mut system.positions.0[axis][range.clone()],
                &mut system.velocities.0[axis][range.clone()],
                &mut forces.0[axis][range.clone()],
                inverse_masses,
                kick,
                kick.common[axis],
            );
        }
    }
    bits >> 63 == 0
}

/// Moves one component of neighboring nodes; the highest bit of the result is set if one is beyond
/// all bounds.
#[inline(always)]
fn move_column<const D: usize>(
    x: &mut [f64],
    v: &mut [f64],
    forces: &mut [f64],
    inverse_masses: &[f64],
    kick: &Kick<D>,
    common: f64,
) -> u64 {
    const EXPONENT: u64 = 0x7ff << 52;
    const CARRY: u64 = (1 << 63) - (BEYOND.to_bits() & EXPONENT);
    let count = x.len();
    let (v, forces, inverse_masses) =
        (&mut v[..count], &mut forces[..count], &inverse_masses[..count]);
    let mut bits = 0;
    for n in 0..count {
        let acceleration = forces[n] * inverse_masses[n] + common;
        let velocity = (v[n] * kick.keep + kick.dt * acceleration) * kick.share;
        v[n] = velocity;
        x[n] += kick.drift * velocity;
        forces[n] = 0.0;
        // The exponent of what is too large, infinite or not a number carries into the sign.
        bits |= (velocity.to_bits() & EXPONENT) + CARRY;
    }
    bits
}

/// Moves the nodes on supports in a range, and returns whether they are within bounds. Tied nodes
/// need the forces of their whole tie.
#[inline(always)]
fn move_guided<const D: usize>(
    system: &mut System<D>,
    forces: &mut NodeVectors<D>,
    kick: &Kick<D>,
    nodes: Range<usize>,
) -> bool {
    let mut sound = true;
    let kicked = |velocity: f64, acceleration: f64, axis: usize| {
        (velocity * kick.keep + kick.dt * (acceleration + kick.common[axis])) * kick.share
    };
    let supports = &system.supports;
    for tie in &supports.ties {
        let Some(&first) = tie.nodes.first() else { continue };
        if supports.guide(first, tie.axis) == Guide::Driven {
            continue;
        }
        let force: f64 = tie.nodes.iter().map(|&node| forces.0[tie.axis][node]).sum();
        let mass: f64 = tie.nodes.iter().map(|&node| system.masses[node]).sum();
        let v = &mut system.velocities.0[tie.axis];
        let velocity = kicked(v[first], force / mass, tie.axis);
        tie.nodes.iter().for_each(|&node| v[node] = velocity);
    }
    let from = supports.guided.partition_point(|(node, _)| *node < nodes.start);
    for &(node, guides) in &supports.guided[from..] {
        if node >= nodes.end {
            break;
        }
        for axis in 0..D {
            let v = &mut system.velocities.0[axis][node];
            if guides[axis] == Guide::Free {
                *v = kicked(*v, forces.0[axis][node] * system.inverse_masses[node], axis);
            }
            system.positions.0[axis][node] += kick.drift * *v;
            forces.0[axis][node] = 0.0;
            sound &= v.abs() < BEYOND;
        }
    }
    sound
}
