//! Laws of sections in place of the linear one.
//!
//! A law tells moments along one fibre at a time, so it is asked lane by lane, and its answers are kept
//! as a quadratic model of each joint's potential about the turn at which it was asked. An affine law
//! is asked once in a step, others at every trial. Lanes without laws have linear joints in the same
//! form, with the same bits.

use super::chain::store;
use super::ends::Ends;
use super::lanes::{Array, Lane, M3, Sym, V3, zeros};
use super::pack::{at, set};
use crate::joint::Joint;
use crate::{Rod, SectionLaws};
use nalgebra::Vector3;
use pulp::Simd;
use pulp::bytemuck::Zeroable;
use rapunzel_fiber::{Response, SectionLaw};
use std::ops::Range;
use std::slice::from_ref;
use std::sync::Arc;

/// The laws of a pack, what its joints remember, and the models of a step.
pub(super) struct Laws<S: Simd> {
    /// In each lane the joints in order, those with the same law together; none if they are linear.
    runs: [Vec<Run>; 8],
    /// 1 in lanes with laws.
    has: S::f64s,
    /// Most vectors that a joint of any lane remembers, and these vectors (3 each).
    slots: usize,
    pub(super) memory: Array<S>,
    /// Lengths of the joints.
    lengths: Array<S>,
    /// The models: the turn at which a law was asked (3), moment (3), tangent (6) and potential there.
    turn: Array<S>,
    moment: Array<S>,
    tangent: Array<S>,
    potential: Array<S>,
    /// Lengths of the step.
    dt: [f64; 8],
    /// Energies of the joints before and after a step, and what it dissipates (3), for the ledger.
    books: Array<S>,
    sheet: Sheet,
}

/// Neighboring joints with the same law.
struct Run {
    joints: Range<usize>,
    law: Arc<dyn SectionLaw>,
}

/// What a law is asked and answers for a run of joints.
#[derive(Default)]
struct Sheet {
    memory: Vec<Vector3<f64>>,
    strains: Vec<Vector3<f64>>,
    responses: Vec<Response>,
    dissipated: Vec<f64>,
}

/// Turns of the joints, those at rest, and the ends.
#[derive(Clone, Copy)]
pub(super) struct Turns<'a, S: Simd> {
    pub(super) phi: &'a [S::f64s],
    pub(super) rest: &'a [S::f64s],
    pub(super) ends: &'a Ends<S>,
}

impl<S: Simd> Turns<'_, S> {
    fn get(array: &[S::f64s], j: usize, lane: usize) -> Vector3<f64> {
        Vector3::from_fn(|i, _| at(array, 3 * j + i, lane))
    }

    /// Whether joint `j` of `0..=n` is there.
    fn is_joined(&self, j: usize, n: usize, lane: usize) -> bool {
        match j {
            0 => at(from_ref(&self.ends.root_joint), 0, lane) > 0.0,
            j if j == n => at(from_ref(&self.ends.tip_joint), 0, lane) > 0.0,
            _ => true,
        }
    }
}

/// The runs of a rod's joints.
fn runs(rod: &Rod) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for j in 0..=rod.fiber.segments() {
        let Some(law) = rod.laws.at(j) else { continue };
        match runs.last_mut() {
            Some(run) if Arc::ptr_eq(&run.law, law) => run.joints.end = j + 1,
            _ => runs.push(Run { joints: j..j + 1, law: Arc::clone(law) }),
        }
    }
    runs
}

impl<S: Simd> Laws<S> {
    /// The laws of rods of `n` segments, if any has one.
    pub(super) fn new(n: usize, rods: &[Rod]) -> Option<Box<Self>> {
        if rods.iter().all(|rod| rod.laws == SectionLaws::Linear) {
            return None;
        }
        let mut of_lanes: [Vec<Run>; 8] = Default::default();
        let mut lengths = zeros::<S>(n + 1);
        let mut has = S::f64s::zeroed();
        for (lane, rod) in rods.iter().enumerate() {
            of_lanes[lane] = runs(rod);
            set(std::slice::from_mut(&mut has), 0, lane, f64::from(!of_lanes[lane].is_empty()));
            for j in 0..=n {
                set(&mut lengths, j, lane, Joint::new(&rod.fiber, j).length);
            }
        }
        let slots = of_lanes.iter().flatten().map(|run| run.law.memory()).max().unwrap_or(0);
        Some(Box::new(Self {
            runs: of_lanes,
            has,
            slots,
            memory: zeros::<S>(3 * slots * (n + 1)),
            lengths,
            turn: zeros::<S>(3 * (n + 1)),
            moment: zeros::<S>(3 * (n + 1)),
            tangent: zeros::<S>(6 * (n + 1)),
            potential: zeros::<S>(n + 1),
            dt: [1.0; 8],
            books: zeros::<S>(3 * (n + 1)),
            sheet: Sheet::default(),
        }))
    }

    /// Other laws with as many memories for the joints of one lane.
    pub(super) fn replace(&mut self, lane: usize, rod: &Rod) {
        self.runs[lane] = runs(rod);
    }

    /// Flags of the lanes with laws.
    #[inline(always)]
    pub(super) fn has(&self, simd: S) -> Lane<S> {
        Lane::new(simd, self.has)
    }

    /// Sets the models of joint `j` in lanes without laws: stiffness and turn at rest.
    #[inline(always)]
    pub(super) fn set_linear(&mut self, simd: S, j: usize, stiffness: V3<S>, rest: V3<S>) {
        let has = self.has(simd);
        let zero = Lane::splat(simd, 0.0);
        let put = |array: &mut [S::f64s], i: usize, new: V3<S>| {
            let kept = V3::load(simd, array, i);
            store(array, i, kept.positive_or(has, new));
        };
        put(&mut self.turn, j, rest);
        put(&mut self.moment, j, V3([zero; 3]));
        put(&mut self.tangent, 2 * j, stiffness);
        put(&mut self.tangent, 2 * j + 1, V3([zero; 3]));
    }

    /// Moment, energy and stiffness of joint `j` at the turn `phi`, by its model.
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

    /// Asks all laws at the given turns, for a step of length `dt[lane]`.
    pub(super) fn begin(&mut self, dt: &[f64; 8], turns: Turns<'_, S>) {
        self.dt = *dt;
        self.ask(turns, |_| true);
    }

    /// Asks the laws that are not affine once more.
    pub(super) fn renew(&mut self, turns: Turns<'_, S>) {
        self.ask(turns, |law| !law.is_affine());
    }

    /// Whether any law is not affine.
    pub(super) fn bends(&self) -> bool {
        self.runs.iter().flatten().any(|run| !run.law.is_affine())
    }

    fn ask(&mut self, turns: Turns<'_, S>, wanted: impl Fn(&dyn SectionLaw) -> bool) {
        let n = self.lengths.len() - 1;
        for lane in 0..S::F64_LANES {
            for run in self.runs[lane].iter().filter(|run| wanted(&*run.law)) {
                self.sheet.fill(lane, run, self.slots, &self.memory, &self.lengths, turns);
                let Sheet { memory, strains, responses, .. } = &mut self.sheet;
                run.law.responses(memory, strains, self.dt[lane], responses);
                for (response, j) in self.sheet.responses.iter().zip(run.joints.clone()) {
                    let length = at(&self.lengths, j, lane);
                    let flag = f64::from(turns.is_joined(j, n, lane));
                    let (moment, t) = (flag * response.moment, response.tangent * (flag / length));
                    for i in 0..3 {
                        set(&mut self.turn, 3 * j + i, lane, at(turns.phi, 3 * j + i, lane));
                        set(&mut self.moment, 3 * j + i, lane, moment[i]);
                    }
                    let six = [t[(0, 0)], t[(1, 1)], t[(2, 2)], t[(0, 1)], t[(0, 2)], t[(1, 2)]];
                    for (i, x) in six.into_iter().enumerate() {
                        set(&mut self.tangent, 6 * j + i, lane, x);
                    }
                    set(&mut self.potential, j, lane, flag * length * response.potential);
                }
            }
        }
    }

    /// Takes the step to the given turns in the lanes that are `done`.
    pub(super) fn commit(&mut self, done: &[bool; 8], turns: Turns<'_, S>) {
        for lane in (0..S::F64_LANES).filter(|&lane| done[lane]) {
            self.commit_lane(lane, self.dt[lane], turns);
        }
    }

    /// Lets one lane set out from the natural state, and at once to the given turns.
    pub(super) fn strain_at_once(&mut self, lane: usize, turns: Turns<'_, S>) {
        for i in 0..self.memory.len() {
            set(&mut self.memory, i, lane, 0.0);
        }
        self.commit_lane(lane, 0.0, turns);
    }

    fn commit_lane(&mut self, lane: usize, dt: f64, turns: Turns<'_, S>) {
        for run in &self.runs[lane] {
            self.sheet.fill(lane, run, self.slots, &self.memory, &self.lengths, turns);
            let Sheet { memory, strains, dissipated, .. } = &mut self.sheet;
            run.law.commits(memory, strains, dt, dissipated);
            let count = run.law.memory();
            for (k, vector) in self.sheet.memory.iter().enumerate() {
                let slot = (run.joints.start + k / count) * self.slots + k % count;
                for i in 0..3 {
                    set(&mut self.memory, 3 * slot + i, lane, vector[i]);
                }
            }
        }
    }

    /// The energy that joint `j` of one lane stores, J, if it has a law.
    pub(super) fn stored(&self, lane: usize, j: usize, strain: &Vector3<f64>) -> Option<f64> {
        let run = self.runs[lane].iter().find(|run| run.joints.contains(&j))?;
        let length = at(&self.lengths, j, lane);
        let vector = |slot: usize| Turns::<S>::get(&self.memory, j * self.slots + slot, lane);
        let memory: Vec<_> = (0..run.law.memory()).map(vector).collect();
        Some(length * run.law.stored_energy(&memory, &(strain / length)))
    }

    /// Notes for [`Self::booked`] what the step from some turns to others stores and dissipates.
    pub(super) fn book(&mut self, before: Turns<'_, S>, after: Turns<'_, S>) {
        let n = self.lengths.len() - 1;
        for lane in 0..S::F64_LANES {
            for run in &self.runs[lane] {
                let count = run.law.memory();
                self.sheet.fill(lane, run, self.slots, &self.memory, &self.lengths, before);
                let stored = |sheet: &Sheet, i: usize| {
                    let memory = &sheet.memory[count * i..count * (i + 1)];
                    run.law.stored_energy(memory, &sheet.strains[i])
                };
                for (i, j) in run.joints.clone().enumerate() {
                    set(&mut self.books, 3 * j, lane, stored(&self.sheet, i));
                }
                self.sheet.fill(lane, run, self.slots, &self.memory, &self.lengths, after);
                let Sheet { memory, strains, dissipated, .. } = &mut self.sheet;
                run.law.commits(memory, strains, self.dt[lane], dissipated);
                for (i, j) in run.joints.clone().enumerate() {
                    set(&mut self.books, 3 * j + 1, lane, stored(&self.sheet, i));
                    set(&mut self.books, 3 * j + 2, lane, self.sheet.dissipated[i]);
                    let length = at(&self.lengths, j, lane);
                    let flag = f64::from(after.is_joined(j, n, lane));
                    for k in 0..3 {
                        let one = at(&self.books, 3 * j + k, lane);
                        set(&mut self.books, 3 * j + k, lane, flag * length * one);
                    }
                }
            }
        }
    }

    /// Energy of joint `j` before and after the step that was booked, and what it dissipates.
    #[inline(always)]
    pub(super) fn booked(&self, simd: S, j: usize) -> [Lane<S>; 3] {
        V3::load(simd, &self.books, j).0
    }
}

impl Sheet {
    /// What the joints of a run in one lane remember, and their strains.
    fn fill<S: Simd>(
        &mut self,
        lane: usize,
        run: &Run,
        slots: usize,
        memory: &[S::f64s],
        lengths: &[S::f64s],
        turns: Turns<'_, S>,
    ) {
        let (count, n) = (run.law.memory(), lengths.len() - 1);
        self.memory.clear();
        self.strains.clear();
        for j in run.joints.clone() {
            self.memory.extend((0..count).map(|s| Turns::<S>::get(memory, j * slots + s, lane)));
            let strain = if turns.is_joined(j, n, lane) {
                let turn =
                    Turns::<S>::get(turns.phi, j, lane) - Turns::<S>::get(turns.rest, j, lane);
                turn / at(lengths, j, lane)
            } else {
                Vector3::zeros()
            };
            self.strains.push(strain);
        }
        self.responses.resize(self.strains.len(), Response::default());
        self.dissipated.resize(self.strains.len(), 0.0);
    }
}
