//! How the rod answers impulses, with the matrix that the last solve has factorised.
//!
//! An impulse is a jump of a node's velocity at the start of the step. It moves the end of the
//! step by `dt P / m` if nothing else acts, so it enters the node's balance as the force
//! `c1 dt P`, and the answer is the change of the mean velocity, displacement over `dt`. Both maps
//! are the same up to transposition, so the response is symmetric.

use super::chain::{hat, store};
use super::factor::{Block, Factor};
use super::lanes::{Array, Lane, M3, Sym, V3, zeros};
use super::pack::{Pack, at, set};
use super::scheme::{Problem, Stage};
use crate::Point;
use pulp::bytemuck::Zeroable;
use pulp::{NullaryFnOnce, Simd};

/// Room for one response; allocated with the first.
pub(super) struct Workspace<S: Simd> {
    /// Impulses in, mean velocities out (3 a node).
    pub(super) values: Array<S>,
    loads: Array<S>,
    pub(super) solution: Array<S>,
    /// Displacements of the nodes that the last linearisation would add (3 a node).
    pub(super) way: Array<S>,
    diagonal: Array<S>,
    right: Array<S>,
    /// Diagonal blocks out (6 a node).
    pub(super) blocks: Array<S>,
    /// Added masses of the nodes, and added inertias of d3 (both kg or kg m^2).
    mass: Array<S>,
    inertia: Array<S>,
    /// What the added masses make of the inverse masses of the nodes, and of the factors.
    w: Array<S>,
    weighted: Factor<S>,
}

impl<S: Simd> Workspace<S> {
    pub(super) fn new(n: usize) -> Self {
        Self {
            values: zeros::<S>(3 * (n + 1)),
            loads: zeros::<S>(3 * n),
            solution: zeros::<S>(6 * n),
            way: zeros::<S>(3 * (n + 1)),
            diagonal: zeros::<S>(6 * n),
            right: zeros::<S>(9 * n),
            blocks: zeros::<S>(6 * (n + 1)),
            mass: zeros::<S>(n + 1),
            inertia: zeros::<S>(n),
            w: zeros::<S>(n + 1),
            weighted: Factor::new(n),
        }
    }
}

/// Which inertia answers an impulse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Inertia {
    /// That of the rods.
    Own,
    /// The same with the masses that were added.
    Weighted,
}

/// What is asked of the factorised step.
enum Question<'a, S: Simd> {
    Respond(Inertia, usize),
    RespondThrice(usize, &'a mut Columns<S>),
    Blocks,
    Weigh(&'a [Point], &'a [f64]),
}

/// Three sets of impulses on all nodes, to be replaced by mean velocities: `3 a + k` is the vector
/// of node `a` in set `k`.
pub(super) struct Columns<S: Simd> {
    pub(super) values: Array<S>,
    loads: Array<S>,
    solution: Array<S>,
}

impl<S: Simd> Columns<S> {
    pub(super) fn new(n: usize) -> Self {
        let (values, loads) = (zeros::<S>(9 * (n + 1)), zeros::<S>(9 * n));
        Self { values, loads, solution: zeros::<S>(18 * n) }
    }
}

/// Replaces `K` sets of impulses by the mean velocities that they cause, from node `from` on, with
/// the inverse masses `w` and the factors of their inertia. The columns are the values, and room for
/// loads and solutions.
#[inline(always)]
fn answer<S: Simd, const K: usize>(
    stage: &Stage<S>,
    w: &[S::f64s],
    factor: &Factor<S>,
    from: usize,
    [values, loads, solution]: [&mut [S::f64s]; 3],
) {
    let simd = stage.dt.simd();
    let n = w.len() - 1;
    let gain = stage.c1 * stage.dt;
    let first = from.saturating_sub(1);
    for e in first..n {
        let (w0, w1) = (Lane::new(simd, w[e]), Lane::new(simd, w[e + 1]));
        for i in K * e..K * (e + 1) {
            let (before, here) = (V3::load(simd, values, i), V3::load(simd, values, i + K));
            store(loads, i, (before.scale(w0) - here.scale(w1)).scale(gain));
        }
    }
    factor.solve::<K>(simd, first, loads, solution);
    let rate = stage.dt.recip();
    for a in from..=n {
        for i in K * a..K * (a + 1) {
            let mut sum = V3::load(simd, values, i).scale(gain);
            if a < n {
                sum += V3::load(simd, solution, 2 * i);
            }
            if a > 0 {
                sum -= V3::load(simd, solution, 2 * (i - K));
            }
            store(values, i, sum.scale(Lane::new(simd, w[a]) * rate));
        }
    }
}

impl<S: Simd> Pack<S> {
    /// Replaces the impulses in the workspace by mean velocities, of node `from` and those behind
    /// it. No node before it may have an impulse; what is theirs in the workspace is left alone.
    pub(super) fn respond(&mut self, inertia: Inertia, from: usize) {
        self.ask(Question::Respond(inertia, from));
    }

    /// The same for three sets of impulses at once, in columns of their own.
    pub(super) fn respond_thrice(&mut self, from: usize, columns: &mut Columns<S>) {
        self.ask(Question::RespondThrice(from, columns));
    }

    /// Computes the diagonal blocks of all nodes.
    pub(super) fn response_blocks(&mut self) {
        self.ask(Question::Blocks);
    }

    /// Factorises again with masses added at points.
    pub(super) fn weigh(&mut self, points: &[Point], masses: &[f64]) {
        self.ask(Question::Weigh(points, masses));
    }

    fn ask(&mut self, question: Question<'_, S>) {
        struct Ask<'a, 'b, S: Simd>(&'a mut Pack<S>, Question<'b, S>);
        impl<S: Simd> NullaryFnOnce for Ask<'_, '_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let stage = self.0.stage(&self.0.last_dt, Problem::Step);
                match self.1 {
                    Question::Respond(inertia, from) => {
                        self.0.solve_response(&stage, inertia, from);
                    }
                    Question::RespondThrice(from, columns) => {
                        let Columns { values, loads, solution } = columns;
                        let chain = &self.0.chain;
                        let columns = [&mut values[..], &mut loads[..], &mut solution[..]];
                        answer::<S, 3>(&stage, &chain.w, &chain.factor, from, columns);
                    }
                    Question::Blocks => self.0.solve_blocks(&stage),
                    Question::Weigh(points, masses) => {
                        self.0.factorize_weighted(&stage, points, masses);
                    }
                }
            }
        }
        self.chain.simd.vectorize(Ask(self, question));
    }

    #[inline(always)]
    pub(super) fn solve_response(&mut self, stage: &Stage<S>, inertia: Inertia, from: usize) {
        let (chain, work) = (&self.chain, &mut self.work);
        let (w, factor) = match inertia {
            Inertia::Own => (&chain.w, &chain.factor),
            Inertia::Weighted => (&work.w, &work.weighted),
        };
        let columns = [&mut work.values[..], &mut work.loads[..], &mut work.solution[..]];
        answer::<S, 1>(stage, w, factor, from, columns);
    }

    #[inline(always)]
    fn solve_blocks(&mut self, stage: &Stage<S>) {
        let (simd, n) = (self.chain.simd, self.chain.n);
        let work = &mut self.work;
        self.chain.factor.inverse_blocks(simd, &mut work.diagonal, &mut work.right);
        let one = Lane::splat(simd, 1.0);
        for a in 0..=n {
            let w = Lane::new(simd, self.chain.w[a]);
            let mut inner = Sym::diagonal(w.lift(0.0));
            if a > 0 {
                inner = inner + Sym::load(simd, &work.diagonal, a - 1);
            }
            if a < n {
                inner = inner + Sym::load(simd, &work.diagonal, a);
            }
            if a > 0 && a < n {
                let right = &work.right[9 * (a - 1)..];
                let rows =
                    [V3::load(simd, right, 0), V3::load(simd, right, 1), V3::load(simd, right, 2)];
                inner = inner - Sym::twice_symmetric_part(M3(rows));
            }
            let block = (Sym::diagonal(one) + inner.scale(w)).scale(w * stage.c1);
            for i in 0..6 {
                work.blocks[6 * a + i] = block.0[i].value;
            }
        }
    }

    /// A mass at a point of a rigid segment is a mass on each of its nodes, and takes away
    /// `m f (1 - f) h^2` of the inertia of the segment's d3.
    #[inline(always)]
    fn factorize_weighted(&mut self, stage: &Stage<S>, points: &[Point], masses: &[f64]) {
        let (simd, n) = (self.chain.simd, self.chain.n);
        let work = &mut self.work;
        work.mass.fill(S::f64s::zeroed());
        work.inertia.fill(S::f64s::zeroed());
        for (point, m) in points.iter().zip(masses) {
            let (lane, e, f) = (point.fiber as usize, point.segment as usize, point.fraction);
            let h = at(&self.chain.h, e, lane);
            let add = |array: &mut [S::f64s], i: usize, x: f64| {
                let old = at(array, i, lane);
                set(array, i, lane, old + x);
            };
            add(&mut work.mass, e, m * (1.0 - f));
            add(&mut work.mass, e + 1, m * f);
            add(&mut work.inertia, e, -m * f * (1.0 - f) * h * h);
        }
        for a in 0..=n {
            let free = Lane::new(simd, self.chain.w[a]);
            let mu = stage.c1.fma(Lane::new(simd, work.mass[a]), Lane::new(simd, self.chain.mu[a]));
            work.w[a] = free.positive_or(mu.recip(), free).value;
        }
        let mut carry = Block::zero(simd);
        let zero = V3::splat(simd, 0.0);
        for e in 0..n {
            let h = self.chain.one(&self.chain.h, e);
            let d = self.chain.vec(&self.chain.d, 3 * e + 2);
            let inertia = Lane::new(simd, work.inertia[e]) * stage.c1;
            let hessian = Sym::load(simd, &self.chain.hessian, e);
            let across = Sym::diagonal(inertia) - Sym::outer(d).scale(inertia);
            let (w0, w1) = (Lane::new(simd, work.w[e]), Lane::new(simd, work.w[e + 1]));
            let block = Block {
                compliance: Sym::diagonal(-(w0 + w1)),
                lever: hat(d.scale(h)),
                stiffness: hessian + across,
                load: zero,
                torque: zero,
            };
            let coupling = self.chain.factor.coupling(simd, e);
            (carry, _) = work.weighted.eliminate(e, block - carry, w1, coupling);
        }
    }
}
