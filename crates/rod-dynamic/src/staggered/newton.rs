//! Newton's method for the rotations of one step, with the search along its directions.

use super::array::{get, store, store_quat};
use super::chain::RotationChain;
use super::ends::Held;
use super::laws::Turns;
use super::search::{MAX_ITERATIONS, Search, SearchOutcome, Solve};
use pulp::Simd;
use rapunzel_lanes::{LANES, Lane, V3};

impl<S: Simd> RotationChain<S> {
    /// Newton's method on all lanes at once. Lanes that are not `wanted` stay as they are, and so
    /// do lanes once they have converged: no fibre depends on its neighbours in the batch. `far`
    /// says that the solution is expected to be far away.
    #[inline(always)]
    pub(super) fn newton(
        &mut self,
        wanted: &[bool; LANES],
        held: &[Held; LANES],
        far: bool,
        out: &mut [SearchOutcome; LANES],
    ) {
        let simd = self.simd;
        let lanes = S::F64_LANES;
        let mut search = [Search::new(false, Held::CLAMPED, far); LANES];
        for lane in 0..lanes {
            search[lane] = Search::new(wanted[lane], held[lane], far);
            if wanted[lane] {
                out[lane] = SearchOutcome::NONE;
            }
        }
        for iteration in 0..MAX_ITERATIONS {
            // Residuals and Newton increments at the present rotations.
            let (nodes, gap) = self.shape();
            let (joints, turn) = self.solve(gap, &mut search);
            let energy = nodes + joints;
            let open = gap.max_abs();
            // Merit test, line search and convergence, lane by lane.
            let (mut fresh, mut scale) = ([0.0; LANES], [0.0; LANES]);
            for lane in 0..lanes {
                if search[lane].active {
                    let h = get(self.one(&self.model.h, 0), lane);
                    let solve = Solve {
                        iteration,
                        turn: get(turn, lane),
                        energy: get(energy, lane),
                        closed: get(open, lane) <= 1e-13 * self.n as f64 * h,
                    };
                    (fresh[lane], scale[lane]) = search[lane].next(&mut out[lane], &solve);
                }
            }
            // Next trial rotations.
            let lift = |x: &[f64; LANES]| Lane::load(simd, x, 0);
            self.advance(lift(&fresh), lift(&scale));
            if !search[..lanes].iter().any(|s| s.active) {
                break;
            }
        }
        // Shape and joints at the final rotations.
        self.shape();
        self.measure_joints();
    }

    /// Solves for the increments of Newton's method at the present rotations, without taking them.
    /// Returns the largest rotation increment, rad, and the vector from a held tip to its support.
    #[inline(always)]
    pub(super) fn increments(&mut self, search: &mut [Search; LANES]) -> (Lane<S>, V3<S>) {
        let (_, gap) = self.shape();
        let (_, turn) = self.solve(gap, search);
        (turn, gap)
    }

    #[inline(always)]
    pub(super) fn largest_turn(&self) -> Lane<S> {
        let mut turn = Lane::splat(self.simd, 0.0);
        if self.supports.is_some() {
            turn = self.largest_end_turn();
        }
        if self.spins {
            return turn.max(self.largest_swing());
        }
        for e in 0..self.n {
            turn = turn.max(self.vec(&self.kept.step, 2 * e + 1).max_abs());
        }
        turn
    }

    /// One Newton solve; lanes whose Hessian is indefinite are solved again with ever more of the
    /// definite part. Returns the potential energy of joints and directors and the largest
    /// increment.
    #[inline(always)]
    fn solve(&mut self, gap: V3<S>, search: &mut [Search; LANES]) -> (Lane<S>, Lane<S>) {
        let (simd, lanes) = (self.simd, S::F64_LANES);
        // Laws that are not affine are evaluated anew at the present rotations.
        if self.laws.as_ref().is_some_and(|laws| laws.bends()) {
            self.measure_joints();
            let Self { laws, room, ends, .. } = self;
            let turns = Turns { phi: &room.phi, rest: &room.target, ends };
            laws.iter_mut().for_each(|laws| laws.renew(turns));
        }
        // Raise the weight of the definite part until every lane has a usable direction.
        loop {
            let mut definite = [0.0; LANES];
            for lane in 0..lanes {
                definite[lane] = search[lane].definite_part();
            }
            let definite = Lane::load(simd, &definite, 0);
            self.definite = definite.value;
            let (potential, signature) = self.assemble(gap, definite);
            let turn = self.largest_turn();
            let mut again = false;
            for lane in 0..lanes {
                again |= search[lane].needs_more(get(signature, lane) == 0.0, get(turn, lane));
            }
            if !again {
                return (potential, turn);
            }
        }
    }

    /// Turns the segments by `scale` times the search direction, from where the direction started.
    /// Lanes with `fresh > 0` first take the last solve as their new direction.
    #[inline(always)]
    pub(super) fn advance(&mut self, fresh: Lane<S>, scale: Lane<S>) {
        for e in 0..self.n {
            let (new, old) =
                (self.vec(&self.kept.step, 2 * e + 1), self.vec(&self.room.direction, e));
            let (here, origin) =
                (self.quat(&self.q[4 * e..]), self.quat(&self.room.origin[4 * e..]));
            let turn = fresh.positive().select(new, old);
            let from = fresh.positive().select(here, origin);
            store(&mut self.room.direction, e, turn);
            store_quat(&mut self.room.origin, e, from);
            let moves = scale.positive();
            let to = if self.spins {
                let (old, origin) =
                    (self.one(&self.kept.spin, e), self.one(&self.room.spin_origin, e));
                let known = fresh.positive().select(old, origin);
                let (to, spin) = self.turned(e, (from, known), turn.scale(scale));
                self.room.spin_origin[e] = known.value;
                self.kept.spin[e] = moves.select(spin, old).value;
                to
            } else {
                from.turned_by(turn.scale(scale))
            };
            store_quat(&mut self.q, e, moves.select(to, here));
        }
        let reaction = self.vec(&self.kept.step, 2 * (self.n - 1));
        let held = self.vec(&self.ends.tip_reaction, 0);
        let moved = fresh.positive().select(reaction.mul_add(scale, held), held);
        store(&mut self.ends.tip_reaction, 0, moved);
        self.turn_ends(fresh, scale);
    }
}
