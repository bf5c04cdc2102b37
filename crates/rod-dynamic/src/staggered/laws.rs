//! Section laws in place of the linear one.
//!
//! A law computes the moments along one fibre at a time, so it is evaluated lane by lane, and its
//! results are kept as a quadratic model of each joint's potential about the rotation at which it
//! was evaluated. An affine law is evaluated once in a step, others in every Newton iteration.
//! Lanes without laws have linear joints in the same form, with the same bits.

use super::array::{Array, at, set, store, zeros};
use super::ends::Ends;
use crate::joint::Joint;
use crate::{Rod, SectionLaws};
use nalgebra::Vector3;
use pulp::Simd;
use pulp::bytemuck::{self, Zeroable};
use rapunzel_fiber::{SectionLaw, SectionResponse};
use rapunzel_lanes::{LANES, Lane, M3, Sym, V3};
use std::ops::Range;
use std::slice::from_ref;
use std::sync::Arc;

/// Section laws of a SIMD batch, their memory, and the joint models of the step.
pub(super) struct Laws<S: Simd> {
    /// Runs of neighbouring joints with the same law, in order, per lane; empty in linear lanes.
    runs: [Vec<Run>; LANES],
    /// 1 in lanes with laws, else 0.
    has: S::f64s,
    /// Memory vectors of the joints, run by run, per lane.
    memory: [Vec<Vector3<f64>>; LANES],
    /// Memory vectors before the step, for [`Self::undo_all`].
    backup: [Vec<Vector3<f64>>; LANES],
    /// Lengths of the joints, m (1 per joint).
    lengths: Array<S>,
    /// Rotation vectors at which the laws were evaluated, rad (3 per joint).
    turn: Array<S>,
    /// Moments of the laws at `turn`, N m (3 per joint).
    moment: Array<S>,
    /// Tangent stiffness of the laws at `turn`, N m (6 per joint).
    tangent: Array<S>,
    /// Potentials of the laws at `turn`, J (1 per joint).
    potential: Array<S>,
    /// Step size of each lane, s.
    dt: [f64; LANES],
    /// Energies of the joints before and after a step, and the energy it dissipates, J (3 per
    /// joint), for the ledger.
    books: Array<S>,
    strains: Vec<Vector3<f64>>,
    responses: Vec<SectionResponse>,
}

/// Neighbouring joints with the same law, and the range of their memory vectors.
struct Run {
    joints: Range<usize>,
    memory: Range<usize>,
    law: Arc<dyn SectionLaw>,
}

/// Rotation vectors of the joints, their natural values, and the boundary conditions.
#[derive(Clone, Copy)]
pub(super) struct Turns<'a, S: Simd> {
    pub(super) phi: &'a [S::f64s],
    pub(super) rest: &'a [S::f64s],
    pub(super) ends: &'a Ends<S>,
}

impl<S: Simd> Turns<'_, S> {
    /// Whether joint `j` of `0..=n` exists in a lane: a joint at an end only where it is clamped.
    fn is_joined(&self, j: usize, n: usize, lane: usize) -> bool {
        match j {
            0 => at(from_ref(&self.ends.root_joint), 0, lane) > 0.0,
            j if j == n => at(from_ref(&self.ends.tip_joint), 0, lane) > 0.0,
            _ => true,
        }
    }

    /// Computes the strains (1/m) of joints of one lane; zero at an end that is not clamped.
    fn strains(
        &self,
        lane: usize,
        joints: Range<usize>,
        lengths: &[S::f64s],
        out: &mut Vec<Vector3<f64>>,
    ) {
        let n = lengths.len() - 1;
        let [phi, rest, lengths] = [self.phi, self.rest, lengths].map(numbers::<S>);
        out.clear();
        out.extend(joints.map(|j| {
            if !self.is_joined(j, n, lane) {
                return Vector3::zeros();
            }
            let i = 3 * j * S::F64_LANES + lane;
            let turn = |k: usize| phi[i + k * S::F64_LANES] - rest[i + k * S::F64_LANES];
            Vector3::new(turn(0), turn(1), turn(2)) / lengths[j * S::F64_LANES + lane]
        }));
    }
}

fn numbers<S: Simd>(array: &[S::f64s]) -> &[f64] {
    bytemuck::cast_slice(array)
}

/// Groups the joints of a rod into runs with the same law.
fn runs(rod: &Rod) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for j in 0..=rod.fiber.segments() {
        let Some(law) = rod.laws.at(j) else { continue };
        match runs.last_mut() {
            Some(run) if Arc::ptr_eq(&run.law, law) => run.joints.end = j + 1,
            _ => runs.push(Run { joints: j..j + 1, memory: 0..0, law: Arc::clone(law) }),
        }
    }
    let mut start = 0;
    for run in &mut runs {
        run.memory = start..start + run.joints.len() * run.law.memory();
        start = run.memory.end;
    }
    runs
}

impl<S: Simd> Laws<S> {
    /// Laws of rods of `n` segments, `None` if all are linear.
    pub(super) fn new(n: usize, rods: &[Rod]) -> Option<Box<Self>> {
        if rods.iter().all(|rod| rod.laws == SectionLaws::Linear) {
            return None;
        }
        let mut of_lanes: [Vec<Run>; LANES] = Default::default();
        let mut lengths = zeros::<S>(n + 1);
        let mut has = S::f64s::zeroed();
        for (lane, rod) in rods.iter().enumerate() {
            of_lanes[lane] = runs(rod);
            set(std::slice::from_mut(&mut has), 0, lane, f64::from(!of_lanes[lane].is_empty()));
            for j in 0..=n {
                set(&mut lengths, j, lane, Joint::new(&rod.fiber, j).length);
            }
        }
        let blank = |lane: usize| {
            let size = of_lanes[lane].last().map_or(0, |run: &Run| run.memory.end);
            vec![Vector3::zeros(); size]
        };
        let memory: [Vec<_>; LANES] = std::array::from_fn(blank);
        Some(Box::new(Self {
            runs: of_lanes,
            has,
            backup: memory.clone(),
            memory,
            lengths,
            turn: zeros::<S>(3 * (n + 1)),
            moment: zeros::<S>(3 * (n + 1)),
            tangent: zeros::<S>(6 * (n + 1)),
            potential: zeros::<S>(n + 1),
            dt: [1.0; LANES],
            books: zeros::<S>(3 * (n + 1)),
            strains: Vec::with_capacity(n + 1),
            responses: Vec::with_capacity(n + 1),
        }))
    }

    /// Replaces the laws of one lane by those of `rod`, which must have as many memory vectors.
    pub(super) fn replace(&mut self, lane: usize, rod: &Rod) {
        self.runs[lane] = runs(rod);
    }

    /// 1 in lanes with laws, else 0.
    #[inline(always)]
    pub(super) fn has(&self, simd: S) -> Lane<S> {
        Lane::new(simd, self.has)
    }

    /// Sets the models of joint `j` in lanes without laws, from its stiffness and natural rotation.
    #[inline(always)]
    pub(super) fn set_linear(&mut self, simd: S, j: usize, stiffness: V3<S>, rest: V3<S>) {
        let has = self.has(simd);
        let zero = Lane::splat(simd, 0.0);
        let put = |array: &mut [S::f64s], i: usize, new: V3<S>| {
            let kept = V3::load(simd, array, i);
            store(array, i, has.positive().select(kept, new));
        };
        put(&mut self.turn, j, rest);
        put(&mut self.moment, j, V3([zero; 3]));
        put(&mut self.tangent, 2 * j, stiffness);
        put(&mut self.tangent, 2 * j + 1, V3([zero; 3]));
    }

    /// Moment, energy and tangent stiffness of joint `j` at the rotation vector `phi`, by its
    /// model.
    #[inline(always)]
    pub(super) fn model(&self, simd: S, j: usize, phi: V3<S>) -> (V3<S>, Lane<S>, M3<S>) {
        let strain = phi - V3::load(simd, &self.turn, j);
        let moment = V3::load(simd, &self.moment, j);
        let tangent = Sym::load(simd, &self.tangent, j);
        let added = tangent.apply(strain);
        let half = Lane::splat(simd, 0.5);
        let energy = (half * added.dot(strain)) + moment.dot(strain);
        (added + moment, energy + Lane::new(simd, self.potential[j]), tangent.full())
    }

    /// Evaluates all laws at the given rotations, for a step of `dt[lane]` seconds.
    pub(super) fn begin(&mut self, dt: &[f64; LANES], turns: Turns<'_, S>) {
        self.dt = *dt;
        self.ask(turns, |_| true);
    }

    /// Evaluates the laws that are not affine again.
    pub(super) fn renew(&mut self, turns: Turns<'_, S>) {
        self.ask(turns, |law| !law.is_affine());
    }

    /// Whether any law is not affine.
    pub(super) fn bends(&self) -> bool {
        self.runs.iter().flatten().any(|run| !run.law.is_affine())
    }

    fn ask(&mut self, turns: Turns<'_, S>, wanted: impl Fn(&dyn SectionLaw) -> bool) {
        let n = self.lengths.len() - 1;
        let lanes = S::F64_LANES;
        let (phi, lengths) = (numbers::<S>(turns.phi), numbers::<S>(&self.lengths));
        let turn = bytemuck::cast_slice_mut::<S::f64s, f64>(&mut self.turn);
        let moments = bytemuck::cast_slice_mut::<S::f64s, f64>(&mut self.moment);
        let tangents = bytemuck::cast_slice_mut::<S::f64s, f64>(&mut self.tangent);
        let potentials = bytemuck::cast_slice_mut::<S::f64s, f64>(&mut self.potential);
        for lane in 0..lanes {
            for run in self.runs[lane].iter().filter(|run| wanted(&*run.law)) {
                turns.strains(lane, run.joints.clone(), &self.lengths, &mut self.strains);
                self.responses.resize(self.strains.len(), SectionResponse::default());
                let memory = &self.memory[lane][run.memory.clone()];
                run.law.responses(memory, &self.strains, self.dt[lane], &mut self.responses);
                for (response, j) in self.responses.iter().zip(run.joints.clone()) {
                    let length = lengths[j * lanes + lane];
                    let flag = f64::from(turns.is_joined(j, n, lane));
                    let (moment, t) = (flag * response.moment, response.tangent * (flag / length));
                    let six = [t[(0, 0)], t[(1, 1)], t[(2, 2)], t[(0, 1)], t[(0, 2)], t[(1, 2)]];
                    let (three, six_at) = (3 * j * lanes + lane, 6 * j * lanes + lane);
                    for i in 0..3 {
                        turn[three + i * lanes] = phi[three + i * lanes];
                        moments[three + i * lanes] = moment[i];
                    }
                    for (i, x) in six.into_iter().enumerate() {
                        tangents[six_at + i * lanes] = x;
                    }
                    potentials[j * lanes + lane] = flag * length * response.potential;
                }
            }
        }
    }

    /// Commits a step to the given rotations in the lanes that are `done`.
    pub(super) fn commit(&mut self, done: &[bool; LANES], turns: Turns<'_, S>) {
        for lane in (0..S::F64_LANES).filter(|&lane| done[lane]) {
            self.commit_lane(lane, self.dt[lane], turns);
        }
    }

    /// Resets the memory of one lane to the natural state, then strains it at once to the given
    /// rotations.
    pub(super) fn strain_at_once(&mut self, lane: usize, turns: Turns<'_, S>) {
        self.memory[lane].fill(Vector3::zeros());
        self.commit_lane(lane, 0.0, turns);
    }

    fn commit_lane(&mut self, lane: usize, dt: f64, turns: Turns<'_, S>) {
        for run in &self.runs[lane] {
            turns.strains(lane, run.joints.clone(), &self.lengths, &mut self.strains);
            run.law.commits(&mut self.memory[lane][run.memory.clone()], &self.strains, dt);
        }
    }

    /// Elastic energy of joint `j` of one lane, J; `None` if it has no law.
    pub(super) fn stored(&self, lane: usize, j: usize, strain: &Vector3<f64>) -> Option<f64> {
        let run = self.runs[lane].iter().find(|run| run.joints.contains(&j))?;
        let length = at(&self.lengths, j, lane);
        let count = run.law.memory();
        let start = run.memory.start + count * (j - run.joints.start);
        let memory = &self.memory[lane][start..start + count];
        Some(length * run.law.stored_energy(memory, &(strain / length)))
    }

    /// Computes, for [`Self::booked`], the energies stored before and after the step and the energy
    /// that it dissipates.
    pub(super) fn book(&mut self, before: Turns<'_, S>, after: Turns<'_, S>) {
        let n = self.lengths.len() - 1;
        let mut strains = Vec::new();
        for lane in 0..S::F64_LANES {
            for run in &self.runs[lane] {
                before.strains(lane, run.joints.clone(), &self.lengths, &mut strains);
                after.strains(lane, run.joints.clone(), &self.lengths, &mut self.strains);
                let mut memory = self.memory[lane][run.memory.clone()].to_vec();
                let count = run.law.memory();
                for (i, j) in run.joints.clone().enumerate() {
                    let memory = &mut memory[count * i..count * (i + 1)];
                    let (old, new, dt) = (&strains[i], &self.strains[i], self.dt[lane]);
                    let stored = run.law.stored_energy(memory, old);
                    let dissipated = run.law.dissipated(memory, new, dt);
                    run.law.commit(memory, new, dt);
                    let stored_after = run.law.stored_energy(memory, new);
                    let length = at(&self.lengths, j, lane);
                    let size = if after.is_joined(j, n, lane) { length } else { 0.0 };
                    for (k, x) in [stored, stored_after, dissipated].into_iter().enumerate() {
                        set(&mut self.books, 3 * j + k, lane, size * x);
                    }
                }
            }
        }
    }

    /// Energies of joint `j` before and after the step passed to [`Self::book`], and the energy
    /// that the step dissipates, J.
    #[inline(always)]
    pub(super) fn booked(&self, simd: S, j: usize) -> [Lane<S>; 3] {
        V3::load(simd, &self.books, j).0
    }

    /// Number of scalars in the memory of one lane.
    pub(super) fn numbers(&self, lane: usize) -> usize {
        3 * self.memory[lane].len()
    }

    /// Appends the memory of one lane.
    pub(super) fn save(&self, lane: usize, numbers: &mut Vec<f64>) {
        numbers.extend(self.memory[lane].iter().flatten());
    }

    /// Restores the memory of one lane from the front of `numbers`, and returns the rest.
    pub(super) fn restore<'a>(&mut self, lane: usize, numbers: &'a [f64]) -> &'a [f64] {
        let (head, tail) = numbers.split_at(self.numbers(lane));
        for (vector, x) in self.memory[lane].iter_mut().zip(head.chunks_exact(3)) {
            vector.copy_from_slice(x);
        }
        tail
    }

    /// Saves the memory of all lanes, for [`Self::undo_all`].
    pub(super) fn remember(&mut self) {
        self.backup.clone_from(&self.memory);
    }

    /// Restores the memory saved by [`Self::remember`].
    pub(super) fn undo_all(&mut self) {
        self.memory.clone_from(&self.backup);
    }
}
