//! What every contact does by itself.

use super::anderson::Onward;
use super::part::{Common, Part};
use super::wide::{Eight, Vectors, Wide, norm};
use crate::metric;
use crate::residual::ResidualSums;
use pulp::{Simd, WithSimd};
use rapunzel_lanes::{LANES, Lane};

/// How near twice the bound of what keeps descent from diverging a step is.
const NEARLY: f64 = 0.95;

/// What the contacts of a part are to do.
pub(super) struct Alone<'p, 'a, 'b> {
    pub(super) part: &'p mut Part<'a, 'b>,
    pub(super) common: &'p Common<'p>,
    pub(super) act: Act<'p>,
}

pub(super) enum Act<'p> {
    /// Finds the impulse that obeys the law as the metric answers it, and notes the velocity wanted if
    /// these are looked at.
    Obey { looked_at: bool },
    /// Finds how far what is wanted is from what the bodies do.
    Compare,
    /// Finds how far the velocities that have been told are from the law.
    Judge,
    /// Finds where the gradient leads, back into the cone, and how far; also what [`Self::Judge`] does if one
    /// `judges`.
    Descend { judges: bool, ways: &'p mut Vec<f64> },
    /// Goes on, back into the cone.
    Step(&'p Onward, &'p mut Vec<f64>),
}

impl WithSimd for Alone<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { part, common, act } = self;
        match act {
            Act::Obey { looked_at } => obey(simd, part, common, looked_at),
            Act::Compare => compare(simd, part, common),
            Act::Judge => judge(simd, part, common),
            Act::Descend { judges, ways } => descend(simd, part, common, judges, ways),
            Act::Step(onward, room) => step(simd, part, common, onward, room),
        }
    }
}

/// With a response that is a multiple of the identity, normal and friction part one after another.
#[inline(always)]
fn obey<S: Simd>(simd: S, part: &mut Part, common: &Common, looked_at: bool) {
    let contacts = &common.contacts[part.contacts.clone()];
    for register in 0..Wide::<S>::registers(contacts.len()) {
        let wide = Wide::new(simd, &part.groups, contacts, register);
        let (response, adhesion) = (wide.responses(), wide.adhesion());
        let changes = wide.relative(&common.h, &wide.group.sides);
        let q = less(changes, times(wide.given(), response));
        let answer = (response + wide.compliance()).recip();
        let normal = (-q[0] * answer).max(-adhesion);
        let [s, t] = wide.project([-q[1] * answer, -q[2] * answer], normal + adhesion);
        let r = [normal, s, t];
        put(&wide, r, &mut part.impulses, common, part.contacts.start);
        if looked_at {
            wide.store(sum(q, times(r, response)), &mut part.wanted[wide.number]);
        }
    }
}

#[inline(always)]
fn compare<S: Simd>(simd: S, part: &mut Part, common: &Common) {
    let contacts = &common.contacts[part.contacts.clone()];
    let mut sums = WideSums::zero(simd);
    for register in 0..Wide::<S>::registers(contacts.len()) {
        let wide = Wide::new(simd, &part.groups, contacts, register);
        let r = wide.load(&part.impulses[wide.number]);
        let wanted = wide.load(&part.wanted[wide.number]);
        let v = wide.relative(&common.v, &wide.group.points);
        let (zero, weight) = (wide.splat(0.0), wide.weights());
        // Where nothing holds it, only what closes the gap is wrong.
        let loose = -wide.adhesion();
        let off = [
            r[0].less_or_equal(loose).select(v[0].min(zero), v[0] - wanted[0]),
            r[0].less_or_equal(loose).select(zero, v[1] - wanted[1]),
            r[0].less_or_equal(loose).select(zero, v[2] - wanted[2]),
        ];
        let u = sum(v, times(r, wide.compliance()));
        sums.wrong = sums.wrong + squared(off) * (weight * weight);
        sums.all = sums.all + squared(r);
        sums.normal_error = sums.normal_error.max(off[0].abs());
        sums.slip_error = sums.slip_error.max(slip_error(&wide, u, r, weight));
    }
    part.sums = sums.of_all();
}

#[inline(always)]
fn judge<S: Simd>(simd: S, part: &mut Part, common: &Common) {
    let contacts = &common.contacts[part.contacts.clone()];
    let mut sums = WideSums::zero(simd);
    for register in 0..Wide::<S>::registers(contacts.len()) {
        let wide = Wide::new(simd, &part.groups, contacts, register);
        let r = wide.load(&part.impulses[wide.number]);
        sums.judge(&wide, told(&wide, common, r), r);
    }
    part.sums = sums.of_all();
}

#[inline(always)]
fn descend<S: Simd>(simd: S, part: &mut Part, common: &Common, judges: bool, ways: &mut Vec<f64>) {
    let contacts = &common.contacts[part.contacts.clone()];
    let image = part.descents.image();
    let [images, ways] = [image, ways].map(|all| {
        // Nothing is written into registers that no contact of the last group is in: they must not hold
        // what another part has left.
        all.clear();
        all.resize(part.groups.len() * 3 * LANES, 0.0);
        all.as_chunks_mut::<LANES>().0.as_chunks_mut::<3>().0
    });
    let mut sums = WideSums::zero(simd);
    for register in 0..Wide::<S>::registers(contacts.len()) {
        let wide = Wide::new(simd, &part.groups, contacts, register);
        let r = wide.load(&part.impulses[wide.number]);
        let mut u = told(&wide, common, r);
        if judges {
            sums.judge(&wide, u, r);
        }
        let bound = wide.splat(metric::most(common.weight)) * wide.responses();
        let mass = (bound / wide.splat(2.0 * NEARLY) + wide.compliance()).recip();
        u[0] = u[0] + wide.dissipation([u[1], u[2]]);
        let next = nearest(&wide, less(r, times(u, mass)));
        wide.store(next, &mut images[wide.number]);
        wide.store(times(less(next, r), wide.responses().sqrt()), &mut ways[wide.number]);
    }
    if judges {
        part.sums = sums.of_all();
    }
}

/// The velocities that have been told, with what compliance adds.
#[inline(always)]
fn told<S: Simd>(wide: &Wide<S>, common: &Common, impulse: Vectors<S>) -> Vectors<S> {
    sum(wide.relative(&common.v, &wide.group.points), times(impulse, wide.compliance()))
}

#[inline(always)]
fn step<S: Simd>(simd: S, part: &mut Part, common: &Common, onward: &Onward, room: &mut Vec<f64>) {
    let contacts = &common.contacts[part.contacts.clone()];
    let next = part.descents.onward(onward, room).as_chunks::<LANES>().0.as_chunks::<3>().0;
    for register in 0..Wide::<S>::registers(contacts.len()) {
        let wide = Wide::new(simd, &part.groups, contacts, register);
        let r = nearest(&wide, wide.load(&next[wide.number]));
        put(&wide, r, &mut part.impulses, common, part.contacts.start);
    }
}

/// Notes impulses, of contacts that come after `start` others, in their frames, and how they have changed in the
/// world.
#[inline(always)]
fn put<S: Simd>(
    wide: &Wide<S>,
    r: Vectors<S>,
    impulses: &mut [Eight],
    common: &Common,
    start: usize,
) {
    wide.store(r, &mut impulses[wide.number]);
    let changes = wide.unpack(wide.world(less(r, wide.given())));
    for (i, change) in wide.range().zip(&changes) {
        common.impulses.set(start + i, change);
    }
}

/// The impulses of the cones nearest to some.
#[inline(always)]
fn nearest<S: Simd>(wide: &Wide<S>, [n, s, t]: Vectors<S>) -> Vectors<S> {
    let tip = wide.adhesion();
    let [n, s, t] = wide.project_cone([n + tip, s, t]);
    [n - tip, s, t]
}

/// As the slip of [`crate::Violation`].
#[inline(always)]
fn slip_error<S: Simd>(
    wide: &Wide<S>,
    u: Vectors<S>,
    impulse: Vectors<S>,
    weight: Lane<S>,
) -> Lane<S> {
    let zero = wide.splat(0.0);
    let limit = (impulse[0] + wide.adhesion()).max(zero);
    let [_, s, t] = less(impulse, times(u, weight));
    let [s, t] = wide.project([s, t], limit);
    let along = (impulse[1] - s) * u[1] + (impulse[2] - t) * u[2];
    along.less_or_equal(zero).select(zero, along / norm([u[1], u[2]])) / weight
}

#[inline(always)]
fn sum<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
fn less<S: Simd>(a: Vectors<S>, b: Vectors<S>) -> Vectors<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn times<S: Simd>(a: Vectors<S>, b: Lane<S>) -> Vectors<S> {
    [a[0] * b, a[1] * b, a[2] * b]
}

#[inline(always)]
fn squared<S: Simd>([x, y, z]: Vectors<S>) -> Lane<S> {
    x * x + y * y + z * z
}

/// [`ResidualSums`] by lane.
struct WideSums<S: Simd> {
    wrong: Lane<S>,
    all: Lane<S>,
    normal_error: Lane<S>,
    slip_error: Lane<S>,
}

impl<S: Simd> WideSums<S> {
    #[inline(always)]
    fn zero(simd: S) -> Self {
        let zero = Lane::splat(simd, 0.0);
        Self { wrong: zero, all: zero, normal_error: zero, slip_error: zero }
    }

    /// Adds contacts with their velocities and impulses, as [`crate::Violation`] does it.
    #[inline(always)]
    fn judge(&mut self, wide: &Wide<S>, u: Vectors<S>, impulse: Vectors<S>) {
        let weight = wide.weights();
        // From the cone's tip.
        let r = [impulse[0] + wide.adhesion(), impulse[1], impulse[2]];
        let saxce = [u[0] + wide.dissipation([u[1], u[2]]), u[1], u[2]];
        let projected = wide.project_cone(less(r, times(saxce, weight)));
        let normal_error = u[0].min(r[0] / weight).abs();
        self.wrong = self.wrong + squared(less(r, projected));
        self.all = self.all + squared(r);
        self.normal_error = self.normal_error.max(normal_error);
        self.slip_error = self.slip_error.max(slip_error(wide, u, impulse, weight));
    }

    #[inline(always)]
    fn of_all(self) -> ResidualSums {
        ResidualSums {
            wrong: self.wrong.reduce_sum(),
            all: self.all.reduce_sum(),
            normal_error: self.normal_error.reduce_max(),
            slip_error: self.slip_error.reduce_max(),
        }
    }
}
