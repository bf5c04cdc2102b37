//! Where the energy of the staggered rod goes: every step's ledger closes to rounding, its lines
//! are what they say, and what the method in time takes vanishes with the order of the method.

mod closes;
mod integrator;

use crate::common::{chain, couples, node_points, scaled, set_out_and_solve};
use nalgebra::{Isometry3, Vector3};
use rapunzel_fiber::Fiber;
use rapunzel_rod_dynamic::{
    Air, Conditions, Drag, Impulses, Ledger, Rod, RodState, RodStepReport, StaggeredBatch,
    StepError,
};

/// The error of a ledger in parts of the work of its step: rounding of the inertia of places, over
/// the squared step.
const CLOSES: f64 = 1e-9;
/// The solver's part of it: Newton's method leaves 1e-13 rad of turns that are 1e-6 rad in the
/// first steps of what starts from rest.
const SOLVED: f64 = 1e-7;

/// `None` for backward Euler.
type Rho = Option<f64>;
const ALL: [Rho; 4] = [None, Some(0.0), Some(0.3), Some(0.8)];

fn batch(rod: &Rod, rho: Rho) -> StaggeredBatch {
    let rods = vec![rod.clone()];
    let batch = match rho {
        None => StaggeredBatch::backward_euler(rods),
        Some(rho) => StaggeredBatch::new(rods, rho),
    };
    let mut batch = batch.expect("a valid rod");
    batch.keep_ledgers(true);
    batch
}

/// All of a ledger's lines.
fn lines(ledger: &Ledger) -> [f64; 10] {
    let Ledger { kinetic, elastic, gravity, loads, drag, .. } = *ledger;
    let Ledger { damping, supports, contacts, integrator, solver, .. } = *ledger;
    [kinetic, elastic, gravity, loads, drag, damping, supports, contacts, integrator, solver]
}

/// Steps with impulses on the nodes, and how well their ledgers close.
struct Books {
    batch: StaggeredBatch,
    sum: Ledger,
    /// Largest gap in a step, largest difference from the energies of the states, and largest part
    /// of the solver, in parts of the work of the step.
    worst: f64,
    off: f64,
    solver: f64,
    scale: f64,
    /// Arm of the impulses beside the axis, m.
    arm: Vector3<f64>,
}

impl Books {
    fn new(batch: StaggeredBatch) -> Self {
        let (sum, arm) = (Ledger::default(), Vector3::zeros());
        Self { batch, sum, worst: 0.0, off: 0.0, solver: 0.0, scale: 0.0, arm }
    }

    fn energies(&self) -> [f64; 2] {
        let energy = self.batch.energy(0, &Vector3::zeros());
        [energy.kinetic, energy.elastic]
    }

    fn step(&mut self, dt: f64, conditions: &dyn Conditions, impulses: &[Vector3<f64>]) -> Ledger {
        self.try_step(dt, conditions, impulses).expect("a step")
    }

    fn try_step(
        &mut self,
        dt: f64,
        conditions: &dyn Conditions,
        impulses: &[Vector3<f64>],
    ) -> Result<Ledger, StepError> {
        let before = self.energies();
        let mut reports = [RodStepReport::default()];
        if impulses.is_empty() {
            self.batch.step(dt, &[conditions], &mut reports)?;
        } else {
            // Beside them moments that turn the segments, as far as what they weigh lets them.
            let turned = |pair: &[Vector3<f64>]| self.arm.cross(&(pair[0] + pair[1]));
            let moments = impulses.windows(2).map(turned);
            let segments = impulses.len() - 1;
            let points = [node_points(1, segments), couples(segments)].concat();
            let both: Vec<_> = impulses.iter().copied().chain(moments).collect();
            let all = Impulses { points: &points, impulses: &both };
            set_out_and_solve(&mut self.batch, dt, &[conditions], all)?;
            self.batch.accept();
        }
        let after = self.energies();
        let ledger = self.batch.ledger(0).expect("it is kept");
        let scale: f64 = lines(&ledger).iter().map(|x| x.abs()).sum();
        // Energies that hardly change are known to rounding only.
        let scale = scale + 1e-3 * (after[0] + after[1]);
        let gap = (ledger.gain() - ledger.work()).abs() / scale;
        self.worst = self.worst.max(gap);
        self.solver = self.solver.max(ledger.solver.abs() / scale);
        let off = |k: usize, gain: f64| (after[k] - before[k] - gain).abs() / scale;
        self.off = self.off.max(off(0, ledger.kinetic)).max(off(1, ledger.elastic));
        self.sum += ledger;
        self.scale = self.scale.max(scale);
        Ok(ledger)
    }

    fn check(&self, what: &str) {
        let [worst, off, solver] = [self.worst, self.off, self.solver];
        println!("{what}: closes to {worst:.1e}, energies to {off:.1e}, solver {solver:.1e}");
        assert!(worst < CLOSES, "{what}: closes to {worst:e}");
        assert!(off < 1e-10, "{what}: energies are off by {off:e}");
        assert!(solver < SOLVED, "{what}: the solver leaves {solver:e}");
    }
}

fn curly(segments: usize) -> Fiber {
    chain(segments, |s| {
        let mut node = scaled(0.1 - 0.04 * s, 0.08);
        node.linear_density = 1.3 - 0.6 * s;
        node.rotary_inertia = Vector3::new(1.0, 1.5, 2.5) * 1e-3;
        node.natural_curvature = Vector3::new(2.0, 1.0, 3.0);
        node
    })
}

/// The state of a rod that is thrown, turning.
fn thrown(batch: &StaggeredBatch) -> RodState {
    let mut state = batch.state(0);
    let spin = Vector3::new(1.0, 2.0, -1.5);
    for (v, r) in state.velocities.iter_mut().zip(&state.positions) {
        *v = Vector3::new(0.3, -0.2, 0.5) + spin.cross(&r.coords);
    }
    for (omega, frame) in state.angular_velocities.iter_mut().zip(&state.frames) {
        *omega = frame.inverse() * spin;
    }
    state
}

const DOWN: Vector3<f64> = Vector3::new(0.1, -1.0, 0.2);

/// A root that sways and turns, and stands still at the start.
fn swaying(t: f64) -> Isometry3<f64> {
    let way = Vector3::new(0.1, 0.05, -0.2) * (1.0 - (3.0 * t).cos());
    let turn = Vector3::new(0.3, -0.2, 0.4) * (1.0 - (2.0 * t).cos());
    Isometry3::new(way, turn)
}

fn wind(t: f64) -> Air {
    let drag = Drag { normal: 0.3, tangential: 0.1 };
    Air { wind: Vector3::new(0.5, 0.2, -0.4) * (0.5 + (0.7 * t).sin()), drag }
}
