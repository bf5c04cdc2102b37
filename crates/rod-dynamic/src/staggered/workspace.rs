//! Where packs work: memory that they lend each other, one for each thread.
//!
//! A solve writes far more numbers than the motion of its rods has. Nearly all of them mean nothing
//! after the call that wrote them, so that each thread has room for one pack, and a pack in which
//! nothing is being solved holds none.

use super::array::{Array, fit, zeros};
use super::factor::{Factor, Right};
use pulp::Simd;
use pulp::bytemuck::Zeroable;
use std::any::Any;
use std::cell::RefCell;

/// What a call writes before it reads it, and nobody reads after it.
pub(super) struct BatchWorkspace<S: Simd> {
    /// Stiffness of the joints (3), with the damping of the step in it.
    pub(super) k: Array<S>,
    /// Rotation vectors at which the joints are at rest (3).
    pub(super) target: Array<S>,
    /// Mass coefficients of the nodes.
    pub(super) mu: Array<S>,
    /// Known forces on the nodes (3).
    pub(super) b: Array<S>,
    /// Positions of the nodes at the start of the step (3).
    pub(super) start: Array<S>,
    /// Inertia vectors beside d1 and d2 (6).
    pub(super) p: Array<S>,
    /// Directors now, and at the start of the step (9).
    pub(super) d: Array<S>,
    pub(super) d_start: Array<S>,
    /// Rotation vectors of the joints (3).
    pub(super) phi: Array<S>,
    /// The last assembly: Hessians of the segments (6), and eliminated right-hand sides (6).
    pub(super) hessian: Array<S>,
    pub(super) rhs: Array<S>,
    /// The turns of the segments along which is searched (3), and the rotations from where (4).
    pub(super) direction: Array<S>,
    pub(super) origin: Array<S>,
    /// Impulses in, mean velocities out (3 a node), and what is solved for them (3 and 6 a
    /// segment).
    pub(super) values: Array<S>,
    pub(super) loads: Array<S>,
    pub(super) solution: Array<S>,
    /// Blocks of the inverse, on the diagonal (6 a segment) and beside it (9), and what nodes
    /// answer themselves (6 a node).
    pub(super) diagonal: Array<S>,
    pub(super) right: Array<S>,
    pub(super) blocks: Array<S>,
    /// Added masses of the nodes, and added inertias of d3 (kg and kg m^2).
    pub(super) mass: Array<S>,
    pub(super) inertia: Array<S>,
    /// For packs that have none of their own.
    pub(super) kept: Kept<S>,
}

/// What a step that is taken in several calls needs from one to the next.
pub(super) struct Kept<S: Simd> {
    /// Positions of the nodes (3).
    pub(super) r: Array<S>,
    /// Inverses of the mass coefficients of the nodes (zero where a node is held).
    pub(super) w: Array<S>,
    /// Of Newton's matrix at the last assembly, and its blocks to the right of segments, between
    /// turns (9).
    pub(super) factor: Factor<S>,
    pub(super) coupling: Array<S>,
    /// Increments of the last solve (6), and how far the tip was from where it is held.
    pub(super) step: Array<S>,
    pub(super) gap: [S::f64s; 3],
}

impl<S: Simd> BatchWorkspace<S> {
    pub(super) fn empty() -> Self {
        let none = || zeros::<S>(0);
        Self {
            k: none(),
            target: none(),
            mu: none(),
            b: none(),
            start: none(),
            p: none(),
            d: none(),
            d_start: none(),
            phi: none(),
            hessian: none(),
            rhs: none(),
            direction: none(),
            origin: none(),
            values: none(),
            loads: none(),
            solution: none(),
            diagonal: none(),
            right: none(),
            blocks: none(),
            mass: none(),
            inertia: none(),
            kept: Kept::empty(),
        }
    }

    /// Makes it fit rods of `n` segments.
    fn fit(&mut self, n: usize) {
        let of_nodes = [
            (&mut self.k, 3),
            (&mut self.target, 3),
            (&mut self.mu, 1),
            (&mut self.b, 3),
            (&mut self.start, 3),
            (&mut self.phi, 3),
            (&mut self.values, 3),
            (&mut self.blocks, 6),
            (&mut self.mass, 1),
        ];
        of_nodes.into_iter().for_each(|(array, size)| fit::<S>(array, size * (n + 1)));
        let of_segments = [
            (&mut self.p, 6),
            (&mut self.d, 9),
            (&mut self.d_start, 9),
            (&mut self.hessian, 6),
            (&mut self.rhs, 6),
            (&mut self.direction, 3),
            (&mut self.origin, 4),
            (&mut self.loads, 3),
            (&mut self.solution, 6),
            (&mut self.diagonal, 6),
            (&mut self.right, 9),
            (&mut self.inertia, 1),
        ];
        of_segments.into_iter().for_each(|(array, size)| fit::<S>(array, size * n));
        self.kept.fit(n);
    }
}

impl<S: Simd> Kept<S> {
    /// The blocks beside those of the factors, with these inverse masses of the nodes.
    pub(super) fn right<'a>(&'a self, w: &'a [S::f64s]) -> Right<'a, S> {
        Right { b: &self.coupling, w }
    }

    pub(super) fn empty() -> Self {
        let none = || zeros::<S>(0);
        let gap = [S::f64s::zeroed(); 3];
        Self { r: none(), w: none(), factor: Factor::new(0), coupling: none(), step: none(), gap }
    }

    /// Makes it fit rods of `n` segments.
    pub(super) fn fit(&mut self, n: usize) {
        let of_nodes = [(&mut self.r, 3), (&mut self.w, 1)];
        of_nodes.into_iter().for_each(|(array, size)| fit::<S>(array, size * (n + 1)));
        fit::<S>(&mut self.coupling, 9 * n);
        fit::<S>(&mut self.step, 6 * n);
        self.factor.fit(n);
    }
}

thread_local! {
    /// The rooms that are free: at most one for each width of registers in use, as large as the
    /// largest pack needed.
    static FREE: RefCell<Vec<Box<dyn Any>>> = const { RefCell::new(Vec::new()) };
}

/// Room of this thread for rods of `n` segments.
pub(super) fn borrow<S: Simd>(n: usize) -> Box<BatchWorkspace<S>> {
    let found = FREE.with_borrow_mut(|free| {
        let at = free.iter().position(|room| room.is::<BatchWorkspace<S>>())?;
        free.swap_remove(at).downcast().ok()
    });
    let mut room = found.unwrap_or_else(|| Box::new(BatchWorkspace::empty()));
    room.fit(n);
    room
}

/// Leaves room to the next.
pub(super) fn give_back<S: Simd>(room: Box<BatchWorkspace<S>>) {
    FREE.with_borrow_mut(|free| free.push(room));
}
