//! Workspaces of SIMD batches: one per thread, borrowed for the duration of a call.
//!
//! A solve writes far more numbers than the state of its rods has, and nearly all of them are
//! needed only within that call. So each thread has one workspace, and a batch that is not solving
//! holds none.

use super::array::{Array, fit, zeros};
use super::factor::{Factor, Right};
use super::impulse_columns::ImpulseColumns;
use pulp::Simd;
use pulp::bytemuck::Zeroable;
use std::any::Any;
use std::cell::RefCell;

/// Scratch arrays of one call: written before they are read, and not read after the call.
pub(super) struct BatchWorkspace<S: Simd> {
    /// Segments of the rods that the arrays fit.
    n: usize,
    /// Stiffness of the joints with the damping of the step, N m (3 per joint).
    pub(super) k: Array<S>,
    /// Rotation vectors at which the joints have no moment, rad (3 per joint).
    pub(super) target: Array<S>,
    /// Mass coefficients of the nodes (1 per node).
    pub(super) mu: Array<S>,
    /// Known forces on the nodes, N, world (3 per node).
    pub(super) b: Array<S>,
    /// Torques on the segments by impulses beside the axis, N m, world (3 per segment); empty
    /// without.
    pub(super) torque: Array<S>,
    /// Inertia vectors of d1 and d2, or, where spins are coordinates, of d3 and its velocity at the
    /// end of a step in which it does not move (6 per segment).
    pub(super) p: Array<S>,
    /// Of the spins of segments: inertia times the coefficient of accelerations, N m; spin without
    /// torque, rad; spin momentum of the gyroscopic torque, N m s, and its slope by the spin (4 per
    /// segment).
    pub(super) spin: Array<S>,
    /// Velocity by displacement in the step, 1/s.
    pub(super) rate: S::f64s,
    /// Spins from which the search direction starts, rad (1 per segment).
    pub(super) spin_origin: Array<S>,
    /// Directors at the present rotations, world (9 per segment).
    pub(super) d: Array<S>,
    /// Directors at the start of the step, world (9 per segment).
    pub(super) d_start: Array<S>,
    /// Rotation vectors of the joints, rad (3 per joint).
    pub(super) phi: Array<S>,
    /// Hessians of the segments in the last assembly (6 per segment).
    pub(super) hessian: Array<S>,
    /// Eliminated right-hand sides of the last assembly (6 per segment).
    pub(super) rhs: Array<S>,
    /// Rotation increments of the segments that form the search direction, rad (3 per segment).
    pub(super) direction: Array<S>,
    /// Rotations from which the search direction starts (4 per segment).
    pub(super) origin: Array<S>,
    /// Impulses, N s, replaced by mean velocities, m/s (3 per node).
    pub(super) values: Array<S>,
    /// Moments of impulses, N m s, replaced by mean angular velocities, rad/s (3 per segment).
    pub(super) turns: Array<S>,
    /// Right-hand sides for the impulses: constraint rows and torques (6 per segment).
    pub(super) loads: Array<S>,
    /// Solution for the impulses: force and rotation increments (6 per segment).
    pub(super) solution: Array<S>,
    /// Force-force and turn-turn diagonal blocks of the inverse matrix (12 per segment).
    pub(super) diagonal: Array<S>,
    /// Force-force off-diagonal blocks of the inverse matrix (9 per segment).
    pub(super) right: Array<S>,
    /// Response blocks of the nodes, 1/kg (6 per node).
    pub(super) blocks: Array<S>,
    /// Response blocks of the segments to moments, 1/(kg m^2) (6 per segment).
    pub(super) turn_blocks: Array<S>,
    /// Masses added to the nodes, kg (1 per node).
    pub(super) mass: Array<S>,
    /// Inertias added to d3, kg m^2 (1 per segment).
    pub(super) inertia: Array<S>,
    /// Inertias of the masses added beside the axis, kg m^2, world (6 per segment); empty without.
    pub(super) gyration: Array<S>,
    /// Room for three sets of impulses, as large as was last asked for.
    pub(super) columns: ImpulseColumns<S>,
    /// Storage that a batch uses which has no [`Kept`] of its own.
    pub(super) kept: Kept<S>,
}

/// Quantities that a step taken in several calls needs from one call to the next.
pub(super) struct Kept<S: Simd> {
    /// Positions of the nodes, m, world (3 per node).
    pub(super) r: Array<S>,
    /// Inverses of the mass coefficients of the nodes, zero where a node is held (1 per node).
    pub(super) w: Array<S>,
    /// Factors of Newton's matrix at the last assembly.
    pub(super) factor: Factor<S>,
    /// Blocks of Newton's matrix to the right of the segments, between rotations (9 per segment).
    pub(super) coupling: Array<S>,
    /// Force and rotation increments of the last solve (6 per segment).
    pub(super) step: Array<S>,
    /// Spins of the segments since the start of the step, rad (1 per segment), where they are
    /// coordinates.
    pub(super) spin: Array<S>,
    /// Vector from a held tip to its support, m, world.
    pub(super) gap: [S::f64s; 3],
}

impl<S: Simd> BatchWorkspace<S> {
    pub(super) fn empty() -> Self {
        let none = || zeros::<S>(0);
        Self {
            n: 0,
            k: none(),
            target: none(),
            mu: none(),
            b: none(),
            torque: none(),
            p: none(),
            spin: none(),
            rate: S::f64s::zeroed(),
            spin_origin: none(),
            d: none(),
            d_start: none(),
            phi: none(),
            hessian: none(),
            rhs: none(),
            direction: none(),
            origin: none(),
            values: none(),
            turns: none(),
            loads: none(),
            solution: none(),
            diagonal: none(),
            right: none(),
            blocks: none(),
            turn_blocks: none(),
            mass: none(),
            inertia: none(),
            gyration: none(),
            columns: ImpulseColumns::empty(),
            kept: Kept::empty(),
        }
    }

    /// Resizes all arrays to rods of `n` segments.
    fn fit(&mut self, n: usize) {
        if std::mem::replace(&mut self.n, n) == n {
            return;
        }
        let of_nodes = [
            (&mut self.k, 3),
            (&mut self.target, 3),
            (&mut self.mu, 1),
            (&mut self.b, 3),
            (&mut self.phi, 3),
            (&mut self.values, 3),
            (&mut self.blocks, 6),
            (&mut self.mass, 1),
        ];
        of_nodes.into_iter().for_each(|(array, size)| fit::<S>(array, size * (n + 1)));
        let of_segments = [
            (&mut self.p, 6),
            (&mut self.spin, 4),
            (&mut self.spin_origin, 1),
            (&mut self.d, 9),
            (&mut self.d_start, 9),
            (&mut self.hessian, 6),
            (&mut self.rhs, 6),
            (&mut self.direction, 3),
            (&mut self.origin, 4),
            (&mut self.turns, 3),
            (&mut self.loads, 6),
            (&mut self.solution, 6),
            (&mut self.diagonal, 12),
            (&mut self.turn_blocks, 6),
            (&mut self.right, 9),
            (&mut self.inertia, 1),
        ];
        of_segments.into_iter().for_each(|(array, size)| fit::<S>(array, size * n));
        self.kept.fit(n);
    }
}

impl<S: Simd> Kept<S> {
    /// Off-diagonal blocks for the factors, with the inverse masses `w` of the nodes and the
    /// moments of masses beside the axis.
    pub(super) fn right<'a>(&'a self, w: &'a [S::f64s], moments: &'a [S::f64s]) -> Right<'a, S> {
        Right { b: &self.coupling, w, moments }
    }

    pub(super) fn empty() -> Self {
        let none = || zeros::<S>(0);
        let gap = [S::f64s::zeroed(); 3];
        Self {
            r: none(),
            w: none(),
            factor: Factor::new(0),
            coupling: none(),
            step: none(),
            spin: none(),
            gap,
        }
    }

    /// Resizes all arrays to rods of `n` segments.
    pub(super) fn fit(&mut self, n: usize) {
        let of_nodes = [(&mut self.r, 3), (&mut self.w, 1)];
        of_nodes.into_iter().for_each(|(array, size)| fit::<S>(array, size * (n + 1)));
        fit::<S>(&mut self.coupling, 9 * n);
        fit::<S>(&mut self.step, 6 * n);
        fit::<S>(&mut self.spin, n);
        self.factor.fit(n);
    }
}

thread_local! {
    /// Free workspaces: at most one per register width in use, as large as the largest batch
    /// needed.
    static FREE: RefCell<Vec<Box<dyn Any>>> = const { RefCell::new(Vec::new()) };
}

/// Borrows the workspace of this thread, resized to rods of `n` segments.
pub(super) fn borrow<S: Simd>(n: usize) -> Box<BatchWorkspace<S>> {
    let found = FREE.with_borrow_mut(|free| {
        let at = free.iter().position(|room| room.is::<BatchWorkspace<S>>())?;
        free.swap_remove(at).downcast().ok()
    });
    let mut room = found.unwrap_or_else(|| Box::new(BatchWorkspace::empty()));
    room.fit(n);
    room
}

/// Returns a workspace for the next borrower on this thread.
pub(super) fn give_back<S: Simd>(room: Box<BatchWorkspace<S>>) {
    FREE.with_borrow_mut(|free| free.push(room));
}
