//! Supports that hold, spring or leave free the freedoms of an end one by one, in lanes.

use super::array::{at, set};
use super::joint_geometry::combine;
use crate::support::Restraints;
use crate::{EndSupport, Load, Restraint};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use pulp::Simd;
use pulp::bytemuck::Zeroable;
use rapunzel_lanes::{Lane, M3, Sym, V3};

/// Supports of the root and of the tip.
pub(super) type BothSupports<S> = [SupportLanes<S>; 2];

/// The support of one end in all lanes; zero in lanes without one.
#[derive(Clone, Copy)]
pub(super) struct SupportLanes<S: Simd> {
    /// 1 where displacements are supported one by one.
    pub(super) shifts: S::f64s,
    /// 1 where rotations are, so that the frame of the end is unknown.
    pub(super) turns: S::f64s,
    pub(super) place: [S::f64s; 3],
    /// The axes, world.
    pub(super) axes: [[S::f64s; 3]; 3],
    /// Projectors, symmetric: on held axes, and on held and sprung ones.
    pub(super) held: [S::f64s; 6],
    bound: [S::f64s; 6],
    /// Stiffness matrix of the linear springs, N/m, world, symmetric.
    pub(super) spring: [S::f64s; 6],
    /// Along the axes: 1 where the displacement is not held, and stiffness, N/m.
    open: [[S::f64s; 3]; 2],
    /// Frame of the support.
    pub(super) frame: [S::f64s; 4],
    /// About the axes: 1 where the rotation is not held, and stiffness, N m/rad.
    pub(super) loose: [[S::f64s; 3]; 2],
    /// Moment on the frame of the end, N m: world components, then follower components.
    moment: [[S::f64s; 3]; 2],
    /// Mobility of the end's node by the coefficients of the step: the rod's own, and with added
    /// masses.
    mobility: [[S::f64s; 6]; 2],
    /// Rotation of the end's frame in the last solve, rad, world: what it is while the segment does
    /// not turn, and the rows of the matrix that the turn of the segment is subtracted by.
    pub(super) alone: [S::f64s; 3],
    pub(super) dragged: [S::f64s; 9],
}

impl<S: Simd> SupportLanes<S> {
    pub(super) fn none() -> Self {
        let o = S::f64s::zeroed();
        Self {
            shifts: o,
            turns: o,
            place: [o; 3],
            axes: [[o; 3]; 3],
            held: [o; 6],
            bound: [o; 6],
            spring: [o; 6],
            open: [[o; 3]; 2],
            frame: [o; 4],
            loose: [[o; 3]; 2],
            moment: [[o; 3]; 2],
            mobility: [[o; 6]; 2],
            alone: [o; 3],
            dragged: [o; 9],
        }
    }

    /// Sets one lane to a support, or to none. One that `hangs` on a held tip has free
    /// displacements that follow from the reaction there.
    pub(super) fn set(&mut self, lane: usize, support: Option<&EndSupport>, hangs: bool) {
        let parts =
            support.map(|support| [&support.translations, &support.rotations].map(Restraints::of));
        let mixed = |i: usize| {
            parts.is_some_and(|parts| parts[i] == Restraints::Mixed) || (hangs && i == 0)
        };
        let flag = |x: &mut S::f64s, on: bool| {
            set(std::slice::from_mut(x), 0, lane, f64::from(on));
        };
        flag(&mut self.shifts, mixed(0));
        flag(&mut self.turns, mixed(1));
        let none = EndSupport {
            pose: Isometry3::identity(),
            axes: UnitQuaternion::identity(),
            translations: [Restraint::Held; 3],
            rotations: [Restraint::Held; 3],
            force: Load::ZERO,
            moment: Load::ZERO,
        };
        let support = support.unwrap_or(&none);
        let axes = support.axes.to_rotation_matrix();
        for (k, axis) in self.axes.iter_mut().enumerate() {
            put(axis, lane, axes.matrix().column(k).as_slice());
        }
        put(&mut self.place, lane, support.pose.translation.vector.as_slice());
        put(&mut self.frame, lane, support.pose.rotation.coords.as_slice());
        let is_held = |one: &Restraint| f64::from(*one == Restraint::Held);
        let is_bound =
            |one: &Restraint| f64::from(*one == Restraint::Held || one.stiffness() > 0.0);
        let shifts = f64::from(mixed(0));
        for (array, matrix) in [
            (&mut self.held, support.along(is_held)),
            (&mut self.bound, support.along(is_bound)),
            (&mut self.spring, support.along(Restraint::stiffness)),
        ] {
            let m = matrix * shifts;
            let entries = [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(0, 2)], m[(1, 2)]];
            put(array, lane, &entries);
        }
        for (numbers, three) in
            [(&mut self.open, &support.translations), (&mut self.loose, &support.rotations)]
        {
            put(&mut numbers[0], lane, &three.map(|one| 1.0 - is_held(&one)));
            put(&mut numbers[1], lane, &three.map(|one| one.stiffness()));
        }
        let turning = mixed(1);
        let moment = if turning { support.moment } else { Load::ZERO };
        let zero = Vector3::zeros();
        let (world, follower) = match &moment {
            Load::World(v) => (v, &zero),
            Load::Follower(v) => (&zero, v),
        };
        put(&mut self.moment[0], lane, world.as_slice());
        put(&mut self.moment[1], lane, follower.as_slice());
    }

    #[inline(always)]
    fn vec(simd: S, a: &[S::f64s; 3]) -> V3<S> {
        V3::load(simd, a, 0)
    }

    /// Projector on held and sprung axes.
    #[inline(always)]
    pub(super) fn bound(&self, simd: S) -> Sym<S> {
        Sym::load(simd, &self.bound, 0)
    }

    /// Mobility of the end's node; with added masses if they are `weighted`.
    #[inline(always)]
    pub(super) fn mobility(&self, simd: S, weighted: bool) -> Sym<S> {
        Sym::load(simd, &self.mobility[usize::from(weighted)], 0)
    }

    /// Sets the mobility for the mass coefficient `mu` of the end's node.
    #[inline(always)]
    pub(super) fn set_mobility(&mut self, mu: Lane<S>, weighted: bool) {
        let simd = mu.simd();
        let mut sum = Sym::diagonal(mu.lift(0.0));
        for (k, axis) in self.axes.iter().enumerate() {
            let (open, stiffness) =
                (Lane::new(simd, self.open[0][k]), Lane::new(simd, self.open[1][k]));
            let share = open * (mu + stiffness).recip() * Lane::new(simd, self.shifts);
            sum = sum + Sym::outer(Self::vec(simd, axis)).scale(share);
        }
        for i in 0..6 {
            self.mobility[usize::from(weighted)][i] = sum.0[i].value;
        }
    }

    /// Mobility in one lane times a vector.
    pub(super) fn moved(&self, lane: usize, v: &Vector3<f64>) -> Vector3<f64> {
        apply(&self.mobility[0], lane, v)
    }

    /// The part of an impulse on the end of one lane that the support takes up.
    pub(super) fn kept(&self, lane: usize, v: &Vector3<f64>) -> Vector3<f64> {
        apply(&self.held, lane, v)
    }

    /// World moment of the loads on an end whose frame is `d`.
    #[inline(always)]
    pub(super) fn moment(&self, d: [V3<S>; 3]) -> V3<S> {
        let simd = d[0].0[0].simd();
        combine(d, Self::vec(simd, &self.moment[1])) + Self::vec(simd, &self.moment[0])
    }

    /// Rotation of the end's frame in the last solve, with the segment's `turn`.
    #[inline(always)]
    pub(super) fn turn(&self, turn: V3<S>) -> V3<S> {
        let simd = turn.0[0].simd();
        let row = |i: usize| V3::load(simd, &self.dragged, i);
        Self::vec(simd, &self.alone) - M3([row(0), row(1), row(2)]).apply(turn)
    }
}

fn put<T: pulp::bytemuck::Pod>(a: &mut [T], lane: usize, x: &[f64]) {
    for (i, x) in x.iter().enumerate() {
        set(a, i, lane, *x);
    }
}

/// The symmetric matrix `m` of one lane times a vector.
fn apply<T: pulp::bytemuck::Pod>(m: &[T; 6], lane: usize, v: &Vector3<f64>) -> Vector3<f64> {
    let [xx, yy, zz, xy, xz, yz] = [0, 1, 2, 3, 4, 5].map(|i| at(m, i, lane));
    Vector3::new(
        xx * v.x + xy * v.y + xz * v.z,
        xy * v.x + yy * v.y + yz * v.z,
        xz * v.x + yz * v.y + zz * v.z,
    )
}
