//! Ends whose freedoms are held, sprung or free one by one, in the lanes that have such.
//!
//! Displacements: the end's node has a mobility matrix `W` in place of one inverse mass, zero along
//! held axes and `1 / (mu + k)` along others, `k` the stiffness of the spring; along held axes the
//! force in the segment at the tip is an unknown, as at a tip that is held whole. Rotations: the
//! frame of the end is one more unknown, without inertia, between the joint of the last half
//! segment and the support. With `dtheta = J A dpsi`, `psi` the coordinates along the axes `A` of
//! the rotation vector from the support and `J` its Jacobian, the held coordinates are taken to
//! zero and the others eliminated, which changes the block of the segment at that end only.

use super::array::{store, store_quat};
use super::chain::RotationChain;
use super::joint_geometry::{JointEffect, combine, hat, slope_of_log};
use super::supports::{BothSupports, SupportLanes};
use pulp::Simd;
use rapunzel_lanes::{Lane, M3, Quat, Sym, V3};

impl<S: Simd> RotationChain<S> {
    /// Place of a supported root, whose balance and that of all nodes gives what the support does
    /// not; that of other lanes is `position`.
    #[inline(always)]
    pub(super) fn supported_root(
        &self,
        supports: &BothSupports<S>,
        position: V3<S>,
        [root_force, tip_force]: [V3<S>; 2],
    ) -> V3<S> {
        let (simd, n, ends) = (self.simd, self.n, &self.ends);
        let [root, tip] = supports;
        let (one, zero) = (Lane::splat(simd, 1.0), V3::splat(simd, 0.0));
        // Nodes before the tip.
        let spring = Sym::load(simd, &root.spring, 0);
        let place = V3::load(simd, &root.place, 0);
        let mut sum = root_force + spring.apply(place);
        let mut mass = spring;
        let mut chord = zero;
        let known = |a: usize, chord: V3<S>| {
            let mu = self.one(&self.room.mu, a);
            (self.vec(&self.room.b, a) - (chord - self.vec(&self.start, a)).scale(mu), mu)
        };
        for a in 0..n {
            let (force, mu) = known(a, chord);
            sum += force;
            mass = mass + Sym::diagonal(mu);
            chord = self.vec(&self.room.d, 3 * a + 2).mul_add(self.one(&self.model.h, a), chord);
        }
        // The tip: by its reaction along what is held of it, else by its balance.
        let pull = Sym::load(simd, &tip.spring, 0);
        let (force, mu) = known(n, chord);
        let free = tip_force + force + pull.apply(V3::load(simd, &tip.place, 0) - chord);
        let held = Sym::load(simd, &tip.held, 0) + Sym::diagonal(Lane::new(simd, ends.tip_held));
        sum += free - held.apply(free - V3::load(simd, &ends.tip_reaction, 0));
        let open = Sym::diagonal(one) - held;
        mass = mass + Sym::symmetric_part(open.times((pull + Sym::diagonal(mu)).full()));
        // Solve for the directions that are not held.
        let held = Sym::load(simd, &root.held, 0);
        let open = Sym::diagonal(one) - held;
        let fixed = held.apply(place);
        let inner = Sym::symmetric_part(open.times(mass.times(open.full()))) + held;
        let (inverse, _) = inner.inverse();
        let free = inverse.apply(open.apply(sum - mass.apply(fixed)) + fixed);
        Lane::new(simd, root.shifts).positive().select(free, position)
    }

    /// Force in the last segment and gap of a supported tip at `position`, from the force that its
    /// balance without the support asks for; those of other lanes are `force` and `gap`.
    #[inline(always)]
    pub(super) fn supported_tip(
        &self,
        tip: &SupportLanes<S>,
        position: V3<S>,
        balance: V3<S>,
        [force, gap]: [V3<S>; 2],
    ) -> [V3<S>; 2] {
        let simd = self.simd;
        let away = V3::load(simd, &tip.place, 0) - position;
        let free = balance + Sym::load(simd, &tip.spring, 0).apply(away);
        let held = Sym::load(simd, &tip.held, 0);
        let reaction = V3::load(simd, &self.ends.tip_reaction, 0);
        let shifts = Lane::new(simd, tip.shifts).positive();
        [
            shifts.select(free - held.apply(free - reaction), force),
            shifts.select(held.apply(away), gap),
        ]
    }

    /// Eliminates the frame of the end `k` (0 for the root), between whose joint and support there
    /// is no inertia. Returns what to subtract from stiffness and torque of the segment at that
    /// end, and what this adds to the signature.
    #[inline(always)]
    pub(super) fn eliminate_end(
        &mut self,
        k: usize,
        joint: &JointEffect<S>,
        exact: Lane<S>,
    ) -> (Sym<S>, V3<S>, Lane<S>) {
        let simd = self.simd;
        let zero = V3::splat(simd, 0.0);
        let (one, half) = (Lane::splat(simd, 1.0), Lane::splat(simd, 0.5));
        let own = self.quat(if k == 0 { &self.ends.root_frame } else { &self.ends.tip_frame });
        let Some(supports) = &mut self.supports else {
            return (Sym::diagonal(one.lift(0.0)), zero, one.lift(0.0));
        };
        let support = &mut supports[k];
        let turns = Lane::new(simd, support.turns);
        // Rotation vector from the support, world, and the inverse of its Jacobian.
        let target = Quat::load(simd, &support.frame, 0);
        let (phi, fw) = target.inverse_times(own).log();
        let psi = combine(target.directors(), phi);
        let angle2 = phi.dot(phi);
        let c = slope_of_log(angle2, fw);
        let square = Sym::outer(psi) - Sym::diagonal(angle2);
        let slope = (Sym::diagonal(one) + square.scale(c)).full() - hat(psi.scale(half));
        let axes = [0, 1, 2].map(|i| V3::load(simd, &support.axes[i], 0));
        let along = axes.map(|axis| axis.dot(psi));
        let [loose, springs] =
            [0, 1].map(|i| [0, 1, 2].map(|j| Lane::new(simd, support.loose[i][j])));
        // Turns of the frame by the coordinates; the held ones go to zero.
        let columns = axes.map(|axis| slope.solve(axis));
        let mut fixed = zero;
        for i in 0..3 {
            fixed -= columns[i].scale(along[i] * (one - loose[i]));
        }
        let fixed = turns.positive().select(fixed, zero);
        let free = M3([0, 1, 2].map(|i| columns[i].scale(loose[i] * turns)));
        // Stiffness and torque of the loose coordinates.
        let sign = if k == 0 { one } else { -one };
        let moment = support.moment(own.directors());
        let torque = joint.moment.scale(sign) + moment - joint.hessian.apply(fixed);
        let mut inner =
            Sym::transposed_product(free.transposed(), joint.hessian.times(free.transposed()));
        let mut right = free.apply(torque);
        for i in 0..3 {
            let loose = loose[i] * turns;
            inner.0[i] = inner.0[i] + loose * springs[i] + one - loose;
            right.0[i] = right.0[i] - loose * springs[i] * along[i];
        }
        let (inverse, signs) = inner.inverse();
        let alone = fixed + free.apply_transposed(inverse.apply(right));
        let reach = Sym::transposed_product(free, inverse.times(free));
        // The coupling to the segment, in the row of the end.
        let mut coupling = hat(joint.moment.scale(exact * half)) - joint.hessian.full();
        if k == 1 {
            coupling = coupling.transposed();
        }
        let dragged = reach.times(coupling);
        store(&mut support.alone, 0, alone);
        for i in 0..3 {
            store(&mut support.dragged, i, dragged.0[i]);
        }
        let stiffness = Sym::transposed_product(coupling, dragged);
        (stiffness, coupling.apply_transposed(alone), signs - one.lift(3.0))
    }

    /// Largest rotation of the frames of supported ends in the last solve, rad.
    #[inline(always)]
    pub(super) fn largest_end_turn(&self) -> Lane<S> {
        let mut turn = Lane::splat(self.simd, 0.0);
        for (k, support) in self.supports.iter().flat_map(|both| both.iter()).enumerate() {
            let segment = if k == 0 { 0 } else { self.n - 1 };
            turn = turn.max(support.turn(self.vec(&self.kept.step, 2 * segment + 1)).max_abs());
        }
        turn
    }

    /// Turns the frames of supported ends by `scale` times the last solve where `fresh > 0`.
    #[inline(always)]
    pub(super) fn turn_ends(&mut self, fresh: Lane<S>, scale: Lane<S>) {
        let Some(supports) = &self.supports else { return };
        for (k, support) in supports.iter().enumerate() {
            let segment = if k == 0 { 0 } else { self.n - 1 };
            let turn = support.turn(self.vec(&self.kept.step, 2 * segment + 1));
            let frame = if k == 0 { &mut self.ends.root_frame } else { &mut self.ends.tip_frame };
            let here = Quat::load(self.simd, frame, 0);
            let moves = (fresh * Lane::new(self.simd, support.turns)).positive();
            store_quat(frame, 0, moves.select(here.turned_by(turn.scale(scale)), here));
        }
    }
}
