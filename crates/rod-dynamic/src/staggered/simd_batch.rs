//! Fibres that move together, one in each SIMD lane, and the problem of their step.

use super::array::{Array, fit, set, store, zeros};
use super::chain::RotationChain;
use super::ends::{Ends, Held};
use super::factor::WeightedFactor;
use super::history::KinematicHistory;
use super::laws::{Laws, Turns};
use super::model::BatchModel;
use super::outset::{Before, Outset};
use super::point_places::PressedPlaces;
use super::scheme::{Scheme, Stage, StepProblem};
use super::workspace::BatchWorkspace;
use crate::Rod;
use pulp::Simd;
use pulp::bytemuck::Zeroable;
use rapunzel_lanes::{LANES, Lane, V3};

/// Model and state of up to eight fibres with equally many segments, one per lane.
pub(super) struct SimdBatch<S: Simd> {
    pub(super) chain: RotationChain<S>,
    /// Number of lanes that have a fibre of their own; those behind are spare.
    pub(super) fibers: usize,
    /// Methods of the lanes in the step under way, and in the next one.
    pub(super) schemes: [Scheme; LANES],
    pub(super) next_schemes: [Scheme; LANES],
    /// Whether the last step wrote accelerations: only where a method depends on them.
    pub(super) knows_accelerations: bool,
    /// Method of fibres that bear nothing, where they do not all have one method for ever.
    pub(super) flight: Option<Scheme>,
    /// Kelvin-Voigt retardation time of each lane, s.
    pub(super) damping: S::f64s,
    /// Rotation vectors of the joints at the start of the step, rad (3 per joint).
    pub(super) phi: Array<S>,
    pub(super) nodes: KinematicHistory<S>,
    /// Of d1 and d2 of each segment; of d3 and, in the first of three components, of the spin where
    /// that is a coordinate.
    pub(super) directors: KinematicHistory<S>,
    pub(super) joints: KinematicHistory<S>,
    /// Impulses on the nodes at the start of the step, N s (3 per node), empty until set.
    pub(super) impulses: Array<S>,
    /// Moments of impulses on the segments at the start of the step, N m s (3 per segment), empty
    /// without.
    pub(super) moments: Array<S>,
    /// Where these may be other than zero.
    pub(super) pressed: PressedPlaces,
    /// Impulses on the root and the tip that their supports take up, N s.
    pub(super) absorbed: [[S::f64s; 3]; 2],
    /// Additional forces on the nodes, N (3 per node), empty until set.
    pub(super) node_forces: Array<S>,
    /// Stiffness of springs that hold nodes, N/m (1 per node), and the places that they pull to, m
    /// (3 per node), empty until set.
    pub(super) springs: [Array<S>; 2],
    /// Forces of joints on the nodes at the end of the step, N (3 per node), empty until set.
    pub(super) joint_forces: Array<S>,
    /// What these have changed by since the last linearisation, N (3 per node), empty until set.
    pub(super) joint_changes: Array<S>,
    /// Moments of joints on the segments at the end of the step, N m (3 per segment), empty until
    /// set.
    pub(super) joint_moments: Array<S>,
    /// Gravity, force per length and wind (3 each), drag across the fibre, and drag across less
    /// drag along it.
    pub(super) fields: [S::f64s; 11],
    pub(super) held: [Held; LANES],
    pub(super) any_damping: bool,
    /// State that an attempt changes, as it was at the start of the step.
    pub(super) before: Before<S>,
    /// Problem that a step in several calls solves.
    pub(super) problem: StepProblem,
    /// Step sizes of the last attempt, s, for later queries to its factors.
    pub(super) last_dt: [f64; LANES],
    /// Factors with masses added at points, if they have been asked for.
    pub(super) weighted: Option<WeightedFactor<S>>,
    /// The chain's own empty workspace while the chain uses a borrowed one.
    pub(super) borrowed: Option<Box<BatchWorkspace<S>>>,
    /// Whether the chain owns the storage that a step needs from call to call.
    pub(super) keeps: bool,
    /// Whether the batch holds a workspace from call to call: what a step has written there stays.
    pub(super) holds: bool,
    /// State of the ends at the start of the step, for the ledger.
    pub(super) outset: Outset<S>,
}

impl<S: Simd> SimdBatch<S> {
    /// Batch of at least one rod, all with the same number of segments. Spare lanes repeat the last
    /// rod.
    pub(super) fn new(simd: S, rods: &[Rod], scheme: Scheme, flight: Option<Scheme>) -> Self {
        let n = rods[0].fiber.segments();
        let any_damping = rods.iter().any(|rod| rod.damping_time > 0.0);
        let memory = scheme.remembers() || flight.is_some();
        let spins = !scheme.remembers() || flight.is_some();
        let mut pack = Self {
            chain: RotationChain::new(simd, BatchModel::of(rods), spins),
            fibers: rods.len(),
            schemes: [scheme; LANES],
            next_schemes: [scheme; LANES],
            knows_accelerations: true,
            flight,
            damping: S::f64s::zeroed(),
            phi: zeros::<S>(3 * (n + 1)),
            nodes: KinematicHistory::new(n + 1, memory),
            directors: KinematicHistory::new(2 * n, memory),
            joints: KinematicHistory::new(
                if any_damping { n + 1 } else { 0 },
                memory && any_damping,
            ),
            impulses: zeros::<S>(0),
            moments: zeros::<S>(0),
            pressed: PressedPlaces::default(),
            absorbed: [[S::f64s::zeroed(); 3]; 2],
            node_forces: zeros::<S>(0),
            springs: [zeros::<S>(0), zeros::<S>(0)],
            joint_forces: zeros::<S>(0),
            joint_changes: zeros::<S>(0),
            joint_moments: zeros::<S>(0),
            fields: [S::f64s::zeroed(); 11],
            held: [Held::CLAMPED; LANES],
            before: Before {
                q: zeros::<S>(4 * n),
                force: zeros::<S>(3 * n),
                phi: zeros::<S>(0),
                ends: Ends::new(),
            },
            problem: StepProblem::Step,
            last_dt: [1.0; LANES],
            weighted: None,
            borrowed: None,
            keeps: false,
            holds: false,
            outset: Outset::new(),
            any_damping,
        };
        for lane in 0..S::F64_LANES {
            let damping = rods[lane.min(rods.len() - 1)].damping_time;
            set(std::slice::from_mut(&mut pack.damping), 0, lane, damping);
        }
        pack.chain.laws = Laws::new(n, rods);
        pack
    }

    /// Resets the section laws of one lane to the natural state, then strains them at once to the
    /// present rotations.
    pub(super) fn strain_laws_at_once(&mut self, lane: usize) {
        let RotationChain { model, laws, ends, .. } = &mut self.chain;
        let turns = Turns { phi: &self.phi, rest: &model.rest, ends };
        laws.iter_mut().for_each(|laws| laws.strain_at_once(lane, turns));
    }

    #[inline(always)]
    pub(super) fn flags(&self, flags: &[bool; LANES]) -> Lane<S> {
        let numbers = flags.map(f64::from);
        Lane::load(self.chain.simd, &numbers, 0)
    }

    #[inline(always)]
    pub(super) fn stage(&self, dt: &[f64; LANES], problem: StepProblem) -> Stage<S> {
        let dt = Lane::load(self.chain.simd, dt, 0);
        Scheme::stage(&self.schemes, dt, problem)
    }

    /// Writes the coefficients of the step's equations into the chain.
    #[inline(always)]
    pub(super) fn prepare(&mut self, stage: &Stage<S>) {
        let simd = self.chain.simd;
        let n = self.chain.n;
        let one = Lane::splat(simd, 1.0);
        let zero = Lane::splat(simd, 0.0);
        let fields = &self.fields;
        let gravity = V3::load(simd, fields, 0);
        let distributed = V3::load(simd, fields, 1);
        let wind = V3::load(simd, fields, 2);
        let (across, excess) = (Lane::new(simd, self.fields[9]), Lane::new(simd, self.fields[10]));
        // Nodes: mass coefficient mu = m c1 + drag cv, its inverse w, and the known force b.
        for a in 0..=n {
            let mut rates = self.nodes.rates(&self.chain, stage, a);
            let mass = Lane::new(simd, self.chain.model.mass[a]);
            let before = rates.v;
            rates.v += self.jump(a);
            let (du, vc) = stage.predict(rates);
            let (length, tangent) = self.reach(&self.chain.room.d_start, a);
            let outside = self.chain.outside(a).unwrap_or(one);
            let drag = across * length * outside;
            let inertial = mass * stage.c1;
            let (spring, pull) = self.spring(a, self.chain.vec(&self.chain.start, a));
            let mu = drag.mul_add(stage.cv, inertial) + spring;
            // Drag along the fibre is smaller than across it: the difference is taken from the
            // velocity at the start of the step, where it is stable for being the smaller part:
            // before all impulses, which also bear what else would move the fibre.
            let slip = tangent.dot(before - wind) * excess * length.recip();
            let b = du.scale(inertial)
                + gravity.scale(mass * outside)
                + distributed.scale(length * outside)
                + (wind - vc).scale(drag)
                + tangent.scale(slip * outside)
                + pull
                + self.chain.vec_or_zero(&self.node_forces, a)
                + self.chain.vec_or_zero(&self.joint_forces, a);
            let held = match a {
                0 => one - Lane::new(simd, self.chain.ends.root_free),
                a if a == n => Lane::new(simd, self.chain.ends.tip_held),
                _ => zero,
            };
            self.chain.room.mu[a] =
                if stage.problem == StepProblem::Rest { zero } else { mu }.value;
            let mut w = held.positive().select(zero, mu.recip());
            if let (Some(both), true) = (&mut self.chain.supports, a == 0 || a == n) {
                let support = &mut both[usize::from(a == n)];
                support.set_mobility(mu, false);
                w = Lane::new(simd, support.shifts).positive().select(zero, w);
            }
            self.chain.kept.w[a] = w.value;
            store(&mut self.chain.room.b, a, b);
        }
        // Segments: torques of joints, and of impulses beside the axis, c1 dt a x P.
        let torques = self.moments.len().max(self.joint_moments.len());
        fit::<S>(&mut self.chain.room.torque, torques);
        for e in 0..torques / 3 {
            let pressed = self.chain.vec_or_zero(&self.moments, e).scale(stage.c1 * stage.dt);
            let torque = pressed + self.chain.vec_or_zero(&self.joint_moments, e);
            store(&mut self.chain.room.torque, e, torque);
        }
        if self.chain.spins {
            self.prepare_spins(stage);
        } else {
            self.prepare_directors(stage);
        }
        // Joints: damping turns stiffness K into K (1 + tau cv), and the rotation without moment
        // into (rest + tau rate) / (1 + tau cv).
        let damping = Lane::new(simd, self.damping);
        let factor = damping.mul_add(stage.cv, one);
        for j in 0..=n {
            let [mut stiffness, mut target] = self.chain.bending(j);
            if self.any_damping {
                let (_, vc) = stage.predict(self.joints.rates(&self.chain, stage, j));
                let phi = self.chain.vec(&self.phi, j);
                let rate = phi.scale(stage.cv) - vc;
                target = rate.mul_add(damping, target).scale(factor.recip());
                stiffness = stiffness.scale(factor);
            }
            if j == 0 {
                stiffness = stiffness.scale(Lane::new(simd, self.chain.ends.root_joint));
            } else if j == n {
                stiffness = stiffness.scale(Lane::new(simd, self.chain.ends.tip_joint));
            }
            store(&mut self.chain.room.k, j, stiffness);
            store(&mut self.chain.room.target, j, target);
            if let Some(laws) = &mut self.chain.laws {
                laws.set_linear(simd, j, stiffness, target);
            }
        }
    }

    /// Writes the inertia vectors of d1 and d2, `p = I c1 (d + du)`.
    #[inline(always)]
    fn prepare_directors(&mut self, stage: &Stage<S>) {
        let simd = self.chain.simd;
        for i in 0..2 * self.chain.n {
            let (du, _) = stage.predict(self.directors.rates(&self.chain, stage, i));
            let (e, k) = (i / 2, i % 2);
            let d = self.chain.vec(&self.chain.room.d_start, 3 * e + k);
            let inertia = Lane::new(simd, self.chain.model.inertia[i]) * stage.c1;
            let p = if stage.problem == StepProblem::Rest { V3::splat(simd, 0.0) } else { d + du };
            store(&mut self.chain.room.p, i, p.scale(inertia));
        }
    }

    /// Evaluates the section laws for the step, about the joint rotations at its start.
    pub(super) fn begin_laws(&mut self) {
        let RotationChain { laws, room, ends, .. } = &mut self.chain;
        let turns = Turns { phi: &self.phi, rest: &room.target, ends };
        laws.iter_mut().for_each(|laws| laws.begin(&self.last_dt, turns));
    }

    /// Length of rod that node `a` stands for, m, and the sum of the adjoining half segments as
    /// vectors along the tangents in `directors`.
    #[inline(always)]
    pub(super) fn reach(&self, directors: &[S::f64s], a: usize) -> (Lane<S>, V3<S>) {
        let half = Lane::splat(self.chain.simd, 0.5);
        let mut length = half.lift(0.0);
        let mut tangent = V3::splat(self.chain.simd, 0.0);
        for e in [a.wrapping_sub(1), a] {
            if e < self.chain.n {
                let h = self.chain.one(&self.chain.model.h, e);
                length = h.mul_add(half, length);
                tangent = self.chain.vec(directors, 3 * e + 2).mul_add(h * half, tangent);
            }
        }
        (length, tangent)
    }

    /// Stiffness of the spring that holds node `a`, N/m, and its force on the node at a place, N.
    #[inline(always)]
    pub(super) fn spring(&self, a: usize, place: V3<S>) -> (Lane<S>, V3<S>) {
        let [stiffness, places] = &self.springs;
        if stiffness.is_empty() {
            let none = Lane::splat(self.chain.simd, 0.0);
            return (none, V3::splat(self.chain.simd, 0.0));
        }
        let stiffness = self.chain.one(stiffness, a);
        (stiffness, (self.chain.vec(places, a) - place).scale(stiffness))
    }

    /// Jump of the velocity of node `a` by its impulse, m/s, world.
    #[inline(always)]
    pub(super) fn jump(&self, a: usize) -> V3<S> {
        let impulse = self.chain.vec_or_zero(&self.impulses, a);
        impulse.scale(Lane::new(self.chain.simd, self.chain.model.mass[a]).recip())
    }

    /// Turns the segments to the rotations that the motion of directors and nodes predicts: a start
    /// for Newton's method from which the forces are already of the right size.
    #[inline(always)]
    pub(super) fn look_ahead(&mut self, stage: &Stage<S>, wanted: &[bool; LANES]) {
        let wanted = self.flags(wanted);
        let half = Lane::splat(self.chain.simd, 0.5);
        for e in 0..self.chain.n {
            let ahead = |track: &KinematicHistory<S>, i: usize| {
                stage.predict(track.rates(&self.chain, stage, i)).0
            };
            let rate = self.chain.one(&self.chain.model.h, e).recip();
            let chord = (ahead(&self.nodes, e + 1) - ahead(&self.nodes, e)).scale(rate);
            if self.chain.spins {
                self.spin_ahead(stage, e, chord, wanted);
                continue;
            }
            let d = |k: usize| self.chain.vec(&self.chain.room.d_start, 3 * e + k);
            let turn = d(0).cross(ahead(&self.directors, 2 * e))
                + d(1).cross(ahead(&self.directors, 2 * e + 1))
                + d(2).cross(chord);
            self.chain.turn(e, turn.scale(half), wanted);
        }
    }

    #[inline(always)]
    pub(super) fn take_over(&mut self, stage: &Stage<S>, wanted: &[bool; LANES]) {
        let n = self.chain.n;
        let done = self.flags(wanted);
        let next_remembers = self.next_schemes.iter().any(Scheme::remembers);
        self.knows_accelerations = stage.remembers || next_remembers;
        let how = (done, next_remembers);
        // Nodes: velocity after the impulse, then rates and position at the end of the step.
        for a in 0..=n {
            let new = self.chain.vec(&self.chain.kept.r, a);
            let old = self.chain.vec(&self.chain.start, a);
            let v = self.chain.vec(&self.nodes.v, a);
            let after = done.positive().select(v + self.jump(a), v);
            store(&mut self.nodes.v, a, after);
            self.nodes.commit(&self.chain, stage, a, new - old, how);
            if stage.problem != StepProblem::Start {
                store(&mut self.chain.start, a, done.positive().select(new, old));
            }
        }
        // Directors d1 and d2, or d3 and spins.
        for i in 0..2 * n {
            let at = 3 * (i / 2) + i % 2;
            let u = if self.chain.spins {
                self.spin_ways(i / 2)[i % 2]
            } else {
                self.chain.vec(&self.chain.room.d, at)
                    - self.chain.vec(&self.chain.room.d_start, at)
            };
            self.directors.commit(&self.chain, stage, i, u, how);
        }
        // Section laws and joints.
        if let Some(laws) = &mut self.chain.laws
            && stage.problem != StepProblem::Start
        {
            let turns = Turns {
                phi: &self.chain.room.phi,
                rest: &self.chain.model.rest,
                ends: &self.chain.ends,
            };
            laws.commit(wanted, turns);
        }
        for j in 0..=n {
            let new = self.chain.vec(&self.chain.room.phi, j);
            let old = self.chain.vec(&self.phi, j);
            if self.any_damping {
                self.joints.commit(&self.chain, stage, j, new - old, how);
            }
            if stage.problem != StepProblem::Start {
                store(&mut self.phi, j, done.positive().select(new, old));
            }
        }
    }
}
