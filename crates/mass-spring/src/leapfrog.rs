use crate::columns::BEYOND;
use crate::force::add_run;
use crate::supports::Guide;
use crate::{Columns, SpringError, System};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// The leapfrog: symplectic, of second order, reversible, one evaluation of forces per step.
///
/// Positions go half a step, velocities a whole one, positions half a step; the halves between two
/// steps of one call are done as one. Node drag is averaged over the step, dampers use the velocity
/// before it. Stable below the [limit](System::stability_limit). As the texts do; they leave the
/// velocities half a step behind.
#[derive(Debug, Clone, Default)]
pub struct Leapfrog<const D: usize> {
    /// Forces of springs, bends and loads; zero between calls.
    forces: Columns<D>,
}

impl<const D: usize> Leapfrog<D> {
    /// Without memory yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Moves the system by `steps` steps of `dt` seconds each: the sub-steps of the texts.
    ///
    /// Every step goes through the system once: nodes move as soon as the last of their springs has
    /// been seen, so that nothing comes from memory twice.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] for the step; [`SpringError::BlownUp`], and then the system is not
    /// finite: go back to a copy.
    pub fn advance(
        &mut self,
        system: &mut System<D>,
        dt: f64,
        steps: usize,
    ) -> Result<(), SpringError> {
        crate::error::positive("the time step (s)", dt)?;
        if self.forces.len() != system.nodes() {
            self.forces = Columns::zeros(system.nodes());
        }
        let forces = &mut self.forces;
        let result = Arch::new().dispatch(Advance { system, forces, dt, steps });
        if result.is_err() {
            self.forces.clear();
        }
        result
    }
}

struct Advance<'a, const D: usize> {
    system: &'a mut System<D>,
    forces: &'a mut Columns<D>,
    dt: f64,
    steps: usize,
}

/// What a node does in a step once its forces are known.
#[derive(Clone, Copy)]
struct Kick<const D: usize> {
    dt: f64,
    /// Time by which positions move then.
    drift: f64,
    /// Part of the velocity that the drag leaves, and what divides the rest.
    keep: f64,
    share: f64,
    /// Acceleration of gravity and wind.
    common: [f64; D],
}

impl<const D: usize> WithSimd for Advance<'_, D> {
    type Output = Result<(), SpringError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let Self { system, forces, dt, steps } = self;
        system.positions.add_scaled(0.5 * dt, &system.velocities);
        for step in 1..=steps {
            let air = system.wind.at(system.time + 0.5 * dt) * system.drag;
            let half = 0.5 * dt * system.drag;
            let kick = Kick {
                dt,
                drift: if step < steps { dt } else { 0.5 * dt },
                keep: 1.0 - half,
                share: 1.0 / (1.0 + half),
                common: std::array::from_fn(|axis| system.gravity[axis] + air[axis]),
            };
            let sound = one_step(system, forces, &kick);
            system.time += dt;
            if !sound {
                let velocities = system.velocities.first_beyond();
                let node = velocities.or_else(|| system.positions.first_beyond()).unwrap_or(0);
                return Err(SpringError::BlownUp { step, node });
            }
        }
        Ok(())
    }
}

/// Whether the numbers are still sound.
#[inline(always)]
fn one_step<const D: usize>(
    system: &mut System<D>,
    forces: &mut Columns<D>,
    kick: &Kick<D>,
) -> bool {
    for (&node, load) in &system.loads {
        forces.add(node, load);
    }
    system.bends.iter().for_each(|bend| bend.add_forces(&system.positions, forces));
    let mut sound = true;
    let mut done = 0;
    for k in 0..system.springs.runs.len() {
        let run = system.springs.runs[k];
        add_run(&system.springs, &run, &system.positions, &system.velocities, forces);
        let frontier = run.frontier.min(system.nodes());
        if frontier > done {
            sound &= move_free(system, forces, kick, done..frontier);
            done = frontier;
        }
    }
    sound &= move_free(system, forces, kick, done..system.nodes());
    sound & move_guided(system, forces, kick)
}

/// Moves the free nodes among some.
#[inline(always)]
fn move_free<const D: usize>(
    system: &mut System<D>,
    forces: &mut Columns<D>,
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

/// Moves one component of neighbors; the highest bit of the result is set if it is beyond all
/// bounds.
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

/// Moves the nodes on supports, once all forces are known, and says whether they are still sound.
#[inline(always)]
fn move_guided<const D: usize>(
    system: &mut System<D>,
    forces: &mut Columns<D>,
    kick: &Kick<D>,
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
    for &(node, guides) in &supports.guided {
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
