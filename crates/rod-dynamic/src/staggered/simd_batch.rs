//! A pack of fibres that move together, one in each SIMD lane, and one attempt at a step.

use super::array::{Array, at, set, store, zeros};
use super::chain::RotationChain;
use super::ends::{EndKind, Ends, Held};
use super::factor::WeightedFactor;
use super::history::KinematicHistory;
use super::joint_geometry::keep_directors;
use super::laws::{Laws, Turns};
use super::model::BatchModel;
use super::outset::Outset;
use super::scheme::{Scheme, Stage, StepProblem};
use super::search::SearchOutcome;
use super::workspace::BatchWorkspace;
use crate::{End, Instant, Load, Rod};
use nalgebra::Vector3;
use pulp::bytemuck::Zeroable;
use pulp::{NullaryFnOnce, Simd};
use rapunzel_fiber::so3;
use rapunzel_lanes::{LANES, Lane, V3};

/// Model and state of up to eight fibres with equally many segments.
pub(super) struct SimdBatch<S: Simd> {
    pub(super) chain: RotationChain<S>,
    pub(super) scheme: Scheme,
    /// Kelvin-Voigt time.
    pub(super) damping: S::f64s,
    /// Positions (3) and joint rotation vectors (3) at the start of the step. Rotations live in
    /// the chain.
    pub(super) r: Array<S>,
    pub(super) phi: Array<S>,
    pub(super) nodes: KinematicHistory<S>,
    pub(super) directors: KinematicHistory<S>,
    pub(super) joints: KinematicHistory<S>,
    /// Impulses on the nodes at the start of the step (3), if any have been set.
    pub(super) impulses: Array<S>,
    /// Those on the root and the tip that what holds them takes up.
    pub(super) absorbed: [[S::f64s; 3]; 2],
    /// Forces on the nodes from outside (3), if any have been set.
    pub(super) node_forces: Array<S>,
    /// Gravity, uniform force per length, wind (3 each), drag across and excess of it over that
    /// along.
    pub(super) fields: [S::f64s; 11],
    pub(super) held: [Held; LANES],
    pub(super) any_damping: bool,
    /// What an attempt changes, as it was when the step set out.
    pub(super) before: Before<S>,
    /// Lengths of the last attempt, for what follows from its factors.
    pub(super) last_dt: [f64; LANES],
    /// With masses added at points, if that has been asked for.
    pub(super) weighted: Option<WeightedFactor<S>>,
    /// What the chain has in place of the room that it has borrowed.
    pub(super) borrowed: Option<Box<BatchWorkspace<S>>>,
    /// Whether the chain keeps what a step needs from call to call.
    pub(super) keeps: bool,
    /// For the ledger of a step.
    pub(super) outset: Outset<S>,
}

/// What an attempt at a step changes.
pub(super) struct Before<S: Simd> {
    /// Rotations (4), and forces (3) of the segments.
    pub(super) q: Array<S>,
    pub(super) force: Array<S>,
    /// Rotation vectors of the joints (3), if they have been measured, as where a motion starts.
    pub(super) phi: Array<S>,
    pub(super) ends: Ends<S>,
}

impl<S: Simd> SimdBatch<S> {
    /// At least one rod, all with the same number of segments. Spare lanes repeat the last rod.
    pub(super) fn new(simd: S, rods: &[Rod], scheme: Scheme) -> Self {
        let n = rods[0].fiber.segments();
        let any_damping = rods.iter().any(|rod| rod.damping_time > 0.0);
        let memory = scheme.has_memory();
        let mut pack = Self {
            chain: RotationChain::new(simd, BatchModel::of(rods)),
            scheme,
            damping: S::f64s::zeroed(),
            r: zeros::<S>(3 * (n + 1)),
            phi: zeros::<S>(3 * (n + 1)),
            nodes: KinematicHistory::new(n + 1, memory),
            directors: KinematicHistory::new(2 * n, memory),
            joints: KinematicHistory::new(
                if any_damping { n + 1 } else { 0 },
                memory && any_damping,
            ),
            impulses: zeros::<S>(0),
            absorbed: [[S::f64s::zeroed(); 3]; 2],
            node_forces: zeros::<S>(0),
            fields: [S::f64s::zeroed(); 11],
            held: [Held::CLAMPED; LANES],
            before: Before {
                q: zeros::<S>(4 * n),
                force: zeros::<S>(3 * n),
                phi: zeros::<S>(0),
                ends: Ends::new(),
            },
            last_dt: [1.0; LANES],
            weighted: None,
            borrowed: None,
            keeps: false,
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

    /// Solves a problem with steps of length `dt[lane]` in the lanes that are wanted, without
    /// committing it.
    pub(super) fn attempt(
        &mut self,
        dt: &[f64; LANES],
        wanted: &[bool; LANES],
        problem: StepProblem,
        out: &mut [SearchOutcome; LANES],
    ) {
        struct Attempt<'a, S: Simd>(
            &'a mut SimdBatch<S>,
            &'a [f64; LANES],
            &'a [bool; LANES],
            StepProblem,
            &'a mut [SearchOutcome; LANES],
        );
        impl<S: Simd> NullaryFnOnce for Attempt<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let Self(pack, dt, wanted, problem, out) = self;
                let stage = pack.stage(dt, problem);
                if problem == StepProblem::Step {
                    pack.look_ahead(&stage, wanted);
                }
                pack.prepare(&stage);
                pack.begin_laws();
                pack.chain.newton(wanted, &pack.held, problem == StepProblem::Rest, out);
            }
        }
        self.last_dt = *dt;
        self.chain.simd.vectorize(Attempt(self, dt, wanted, problem, out));
    }

    /// Makes the present rotations the start of a step, in the lanes that are wanted.
    pub(super) fn set_out(&mut self, wanted: &[bool; LANES]) {
        struct SetOut<'a, S: Simd>(&'a mut SimdBatch<S>, &'a [bool; LANES]);
        impl<S: Simd> NullaryFnOnce for SetOut<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let wanted = self.0.flags(self.1);
                let RotationChain { room, q, .. } = &mut self.0.chain;
                keep_directors(&mut room.d_start, q, wanted);
            }
        }
        self.chain.simd.vectorize(SetOut(self, wanted));
    }

    /// Takes the rotation vectors of the joints from the present rotations, in the lanes that are
    /// wanted: the damping of the first step starts from them.
    pub(super) fn measure(&mut self, wanted: &[bool; LANES]) {
        struct Measure<'a, S: Simd>(&'a mut SimdBatch<S>, &'a [bool; LANES]);
        impl<S: Simd> NullaryFnOnce for Measure<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let Self(pack, lanes) = self;
                let wanted = pack.flags(lanes);
                pack.before.phi = pack.phi.clone();
                pack.chain.measure_joints();
                for j in 0..=pack.chain.n {
                    let (new, old) =
                        (pack.chain.vec(&pack.chain.room.phi, j), pack.chain.vec(&pack.phi, j));
                    store(&mut pack.phi, j, wanted.positive().select(new, old));
                }
                for lane in (0..S::F64_LANES).filter(|&lane| lanes[lane]) {
                    pack.strain_laws_at_once(lane);
                }
            }
        }
        self.chain.simd.vectorize(Measure(self, wanted));
    }

    /// Lets the laws of one lane set out from the natural state, and at once to the present turns.
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

    /// Makes the last attempt the state, in the lanes that are `done`.
    pub(super) fn commit(&mut self, dt: &[f64; LANES], done: &[bool; LANES], problem: StepProblem) {
        struct Commit<'a, S: Simd>(
            &'a mut SimdBatch<S>,
            &'a [f64; LANES],
            &'a [bool; LANES],
            StepProblem,
        );
        impl<S: Simd> NullaryFnOnce for Commit<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let Self(pack, dt, done, problem) = self;
                let stage = pack.stage(dt, problem);
                pack.take_over(&stage, done);
            }
        }
        self.chain.simd.vectorize(Commit(self, dt, done, problem));
    }

    #[inline(always)]
    pub(super) fn stage(&self, dt: &[f64; LANES], problem: StepProblem) -> Stage<S> {
        let dt = Lane::load(self.chain.simd, dt, 0);
        self.scheme.stage(dt, problem)
    }

    /// Writes the problem of the step into the chain.
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
        for a in 0..=n {
            let mut rates = self.nodes.rates(&self.chain, a);
            let mass = Lane::new(simd, self.chain.model.mass[a]);
            let before = rates.v;
            rates.v += self.jump(a);
            let (du, vc) = self.scheme.predict(stage, rates);
            let (length, tangent) = self.reach(&self.chain.room.d_start, a);
            let drag = across * length;
            let inertial = mass * stage.c1;
            let mu = drag.mul_add(stage.cv, inertial);
            // Drag along the fibre is smaller than across it: the difference is taken from the
            // velocity at the start of the step, where it is stable for being the smaller part:
            // before all impulses, which also bear what else would move the fibre.
            let slip = tangent.dot(before - wind) * excess * length.recip();
            let b = du.scale(inertial)
                + gravity.scale(mass)
                + distributed.scale(length)
                + (wind - vc).scale(drag)
                + tangent.scale(slip)
                + self.chain.vec_or_zero(&self.node_forces, a);
            let held = match a {
                0 => one - Lane::new(simd, self.chain.ends.root_free),
                a if a == n => Lane::new(simd, self.chain.ends.tip_held),
                _ => zero,
            };
            self.chain.room.mu[a] =
                if stage.problem == StepProblem::Rest { zero } else { mu }.value;
            self.chain.kept.w[a] = held.positive().select(zero, mu.recip()).value;
            store(&mut self.chain.room.b, a, b);
        }
        self.chain.room.start.copy_from_slice(&self.r);
        for i in 0..2 * n {
            let (du, _) = self.scheme.predict(stage, self.directors.rates(&self.chain, i));
            let (e, k) = (i / 2, i % 2);
            let d = self.chain.vec(&self.chain.room.d_start, 3 * e + k);
            let inertia = Lane::new(simd, self.chain.model.inertia[i]) * stage.c1;
            let p = if stage.problem == StepProblem::Rest { V3::splat(simd, 0.0) } else { d + du };
            store(&mut self.chain.room.p, i, p.scale(inertia));
        }
        let damping = Lane::new(simd, self.damping);
        let factor = damping.mul_add(stage.cv, one);
        for j in 0..=n {
            let mut stiffness = self.chain.vec(&self.chain.model.stiffness, j);
            let mut target = self.chain.vec(&self.chain.model.rest, j);
            if self.any_damping {
                let (_, vc) = self.scheme.predict(stage, self.joints.rates(&self.chain, j));
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

    /// Asks the laws for the step of the last length, about the turns from which it sets out.
    pub(super) fn begin_laws(&mut self) {
        let RotationChain { laws, room, ends, .. } = &mut self.chain;
        let turns = Turns { phi: &self.phi, rest: &room.target, ends };
        laws.iter_mut().for_each(|laws| laws.begin(&self.last_dt, turns));
    }

    /// The length of rod that node `a` stands for, and that length along the tangent of
    /// `directors`.
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

    /// How much the impulse on a node changes its velocity.
    #[inline(always)]
    pub(super) fn jump(&self, a: usize) -> V3<S> {
        let impulse = self.chain.vec_or_zero(&self.impulses, a);
        impulse.scale(Lane::new(self.chain.simd, self.chain.model.mass[a]).recip())
    }

    /// Turns the segments to where their directors' and nodes' motion leads: a start for Newton's
    /// method from which the forces are already of the right size.
    #[inline(always)]
    pub(super) fn look_ahead(&mut self, stage: &Stage<S>, wanted: &[bool; LANES]) {
        let wanted = self.flags(wanted);
        let half = Lane::splat(self.chain.simd, 0.5);
        for e in 0..self.chain.n {
            let ahead = |track: &KinematicHistory<S>, i: usize| {
                self.scheme.predict(stage, track.rates(&self.chain, i)).0
            };
            let chord = ahead(&self.nodes, e + 1) - ahead(&self.nodes, e);
            let d = |k: usize| self.chain.vec(&self.chain.room.d_start, 3 * e + k);
            let turn = d(0).cross(ahead(&self.directors, 2 * e))
                + d(1).cross(ahead(&self.directors, 2 * e + 1))
                + d(2).cross(chord.scale(self.chain.one(&self.chain.model.h, e).recip()));
            self.chain.turn(e, turn.scale(half), wanted);
        }
    }

    #[inline(always)]
    fn take_over(&mut self, stage: &Stage<S>, wanted: &[bool; LANES]) {
        let n = self.chain.n;
        let done = self.flags(wanted);
        for a in 0..=n {
            let new = self.chain.vec(&self.chain.kept.r, a);
            let old = self.chain.vec(&self.r, a);
            let v = self.chain.vec(&self.nodes.v, a);
            let after = done.positive().select(v + self.jump(a), v);
            store(&mut self.nodes.v, a, after);
            self.nodes.commit(&self.chain, self.scheme, stage, a, new - old, done);
            if stage.problem != StepProblem::Start {
                store(&mut self.r, a, done.positive().select(new, old));
            }
        }
        for i in 0..2 * n {
            let at = 3 * (i / 2) + i % 2;
            let u = self.chain.vec(&self.chain.room.d, at)
                - self.chain.vec(&self.chain.room.d_start, at);
            self.directors.commit(&self.chain, self.scheme, stage, i, u, done);
        }
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
                self.joints.commit(&self.chain, self.scheme, stage, j, new - old, done);
            }
            if stage.problem != StepProblem::Start {
                store(&mut self.phi, j, done.positive().select(new, old));
            }
        }
    }

    /// Sets what acts on one lane at the end of its step.
    pub(super) fn set_conditions(&mut self, lane: usize, now: &Instant) {
        let (air, drag) = now.air.map_or_else(Default::default, |a| {
            (a.wind, [a.drag.normal, a.drag.normal - a.drag.tangential])
        });
        let numbers = now.gravity.iter().chain(&now.distributed).chain(&air).chain(&drag);
        for (i, x) in numbers.enumerate() {
            set(&mut self.fields, i, lane, *x);
        }
        let n = self.chain.n;
        // A follower load turns with the end, half a segment from the frame of the last segment.
        let mut now = *now;
        now.root = ahead(&now.root, &-self.vector(&self.chain.model.rest, 0, lane));
        now.tip = ahead(&now.tip, &self.vector(&self.chain.model.rest, n, lane));
        let reaction = [0, 1, 2].map(|i| at(&self.chain.force, 3 * (self.chain.n - 1) + i, lane));
        self.held[lane] = self.chain.ends.set(lane, &now, reaction);
        self.chain.ends.any_root_free = self.held.iter().any(|h| h.root == EndKind::Loaded);
        self.chain.ends.any_tip_joint = self.held.iter().any(|h| h.tip == EndKind::Held);
        self.chain.ends.any_circulatory = self.held.iter().any(|h| !h.conservative);
    }

    /// Every array that a lane's future depends on, beside what laws remember.
    pub(super) fn arrays(&self) -> [&[S::f64s]; 18] {
        let [a, b, c] = self.nodes.arrays();
        let [d, e, f] = self.directors.arrays();
        let [g, h, i] = self.joints.arrays();
        let RotationChain { q, force, ends, .. } = &self.chain;
        let flags = [&ends.root_free, &ends.root_joint, &ends.tip_held, &ends.tip_joint];
        let [j, k, l, m] = flags.map(std::slice::from_ref);
        [a, b, c, d, e, f, g, h, i, j, k, l, m, &self.r, &self.phi, q, force, &ends.tip_reaction]
    }

    /// The same, to be written.
    pub(super) fn arrays_mut(&mut self) -> [&mut [S::f64s]; 18] {
        let [a, b, c] = self.nodes.arrays_mut();
        let [d, e, f] = self.directors.arrays_mut();
        let [g, h, i] = self.joints.arrays_mut();
        let RotationChain { q, force, ends, .. } = &mut self.chain;
        let Ends { root_free, root_joint, tip_held, tip_joint, tip_reaction, .. } = ends;
        let [j, k, l, m] = [root_free, root_joint, tip_held, tip_joint].map(std::slice::from_mut);
        let (r, phi) = (&mut self.r, &mut self.phi);
        [a, b, c, d, e, f, g, h, i, j, k, l, m, r, phi, q, force, tip_reaction]
    }
}

/// The end with its follower loads in the frame of the segment next to it, from which the frame of
/// the end is turned by `turn` where no moment bends it further.
fn ahead(end: &End, turn: &Vector3<f64>) -> End {
    let moved = |load: &Load| match load {
        Load::Follower(v) => Load::Follower(so3::exp(turn) * v),
        Load::World(_) => *load,
    };
    match end {
        End::Loaded { force, moment } => End::Loaded { force: moved(force), moment: moved(moment) },
        _ => *end,
    }
}
