//! Phases in which every contact does something by itself, as many at once as a register holds.

use super::admm_part::AdmmPart;
use super::admm_state::AdmmState;
use super::anderson::AndersonUpdate;
use super::contact_lanes::{ContactLanes, norm};
use crate::VectorLanes;
use crate::metric;
use crate::residual::{JOINT_CLOSED, ResidualSums};
use pulp::{Arch, Simd, WithSimd};
use rapunzel_lanes::{LANES, Lane, V3};

/// Step of the descent, relative to the largest with which it does not diverge.
const STEP_MARGIN: f64 = 0.95;

/// Work that every contact of a part does by itself.
pub(super) enum ContactKernel<'p> {
    /// Finds the impulse that obeys the law as the metric answers it, and keeps the velocity for
    /// which it does if these are looked at.
    Prox { keeps_velocities: bool },
    /// Evaluates how far the velocities that contacts want are from those that the bodies have.
    EvalSplitting,
    /// Evaluates how far the velocities that have been evaluated are from the law.
    EvalResidual,
    /// Finds where the gradient leads, back into the cone, and the `increments` of the impulses
    /// times the roots of the responses; with `evaluates_residual` also what [`Self::EvalResidual`]
    /// does.
    DescentGradient { evaluates_residual: bool, increments: &'p mut Vec<f64> },
    /// Takes the accelerated step, back into the cone; the numbers are a buffer.
    DescentUpdate(&'p AndersonUpdate, &'p mut Vec<f64>),
}

impl ContactKernel<'_> {
    /// Runs the kernel on all contacts of a part, in the widest registers of the machine.
    pub(super) fn run(self, part: &mut AdmmPart, state: &AdmmState) {
        Arch::new().dispatch(KernelOnPart { kernel: self, part, state });
    }
}

/// A kernel with what it works on, for any kind of machine.
struct KernelOnPart<'p, 'a, 'b> {
    kernel: ContactKernel<'p>,
    part: &'p mut AdmmPart<'a, 'b>,
    state: &'p AdmmState<'p>,
}

impl WithSimd for KernelOnPart<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { kernel, part, state } = self;
        match kernel {
            ContactKernel::Prox { keeps_velocities } => prox(simd, part, state, keeps_velocities),
            ContactKernel::EvalSplitting => eval_splitting(simd, part, state),
            ContactKernel::EvalResidual => eval_residual(simd, part, state),
            ContactKernel::DescentGradient { evaluates_residual, increments } => {
                descent_gradient(simd, part, state, evaluates_residual, increments);
            }
            ContactKernel::DescentUpdate(update, buffer) => {
                descent_update(simd, part, state, update, buffer);
            }
        }
    }
}

/// The proximal step `z` of the splitting: with a response that is a multiple of the identity,
/// normal and friction are found one after another in closed form.
#[inline(always)]
fn prox<S: Simd>(simd: S, part: &mut AdmmPart, state: &AdmmState, keeps_velocities: bool) {
    let contacts = &state.contacts[part.contacts.clone()];
    for register in 0..ContactLanes::<S>::registers(contacts.len()) {
        let lanes = ContactLanes::new(simd, &part.groups, contacts, register);
        let (response, adhesion) = (lanes.responses(), lanes.adhesion());
        let least = lanes.least_normal();
        // The velocity without the contact's own impulse, from the state h.
        let velocity = lanes.relative_velocities(&state.h, &lanes.group.sides);
        let q = velocity - lanes.given_impulses().scale(response);
        // Signorini's law of the normal, then Coulomb's limit of the friction that would stop the
        // slip.
        let answer = (response + lanes.compliance()).recip();
        let normal = (-q.0[0] * answer).max(least);
        let [s, t] = lanes.project([-q.0[1] * answer, -q.0[2] * answer], normal + adhesion);
        let r = V3([normal, s, t]);
        store_impulses(&lanes, r, &mut part.impulses, state, part.contacts.start);
        if keeps_velocities {
            lanes.store(q + r.scale(response), &mut part.wanted[lanes.group_index]);
        }
    }
}

/// Errors of the splitting, `v - z`, as the measures of a report.
#[inline(always)]
fn eval_splitting<S: Simd>(simd: S, part: &mut AdmmPart, state: &AdmmState) {
    let contacts = &state.contacts[part.contacts.clone()];
    let mut sums = LaneSums::zero(simd);
    for register in 0..ContactLanes::<S>::registers(contacts.len()) {
        let lanes = ContactLanes::new(simd, &part.groups, contacts, register);
        let r = lanes.load(&part.impulses[lanes.group_index]);
        let wanted = lanes.load(&part.wanted[lanes.group_index]);
        let v = lanes.relative_velocities(&state.velocity_changes, &lanes.group.points);
        let (zero, weight) = (lanes.splat(0.0), lanes.weights());
        let moved = weight * lanes.heavier();
        // Where nothing holds a contact, only what closes the gap is wrong.
        let loose = lanes.least_normal();
        let open = V3([v.0[0].min(zero), zero, zero]);
        let off = r.0[0].less_or_equal(loose).select(open, v - wanted);
        let off = lanes.joint().map_or(off, |joint| joint.select(moving(off, off), off));
        let u = v + r.scale(lanes.compliance());
        sums.residual_squares = sums.residual_squares + squared(off) * (moved * moved);
        sums.impulse_squares = sums.impulse_squares + squared(r);
        sums.normal_error = sums.normal_error.max(off.0[0].abs());
        sums.slip_error = sums.slip_error.max(slip_error(&lanes, u, r, weight));
    }
    part.sums = sums.reduce();
}

/// Natural map of the law and errors of velocities, as the measures of a report.
#[inline(always)]
fn eval_residual<S: Simd>(simd: S, part: &mut AdmmPart, state: &AdmmState) {
    let contacts = &state.contacts[part.contacts.clone()];
    let mut sums = LaneSums::zero(simd);
    for register in 0..ContactLanes::<S>::registers(contacts.len()) {
        let lanes = ContactLanes::new(simd, &part.groups, contacts, register);
        let r = lanes.load(&part.impulses[lanes.group_index]);
        sums.add(&lanes, relative_velocities(&lanes, state, r), r);
    }
    part.sums = sums.reduce();
}

/// The image `P(r - D (u + de Saxcé's term))` of the impulses (Tasora and Anitescu 2011).
#[inline(always)]
fn descent_gradient<S: Simd>(
    simd: S,
    part: &mut AdmmPart,
    state: &AdmmState,
    evaluates_residual: bool,
    increments: &mut Vec<f64>,
) {
    let contacts = &state.contacts[part.contacts.clone()];
    let image = part.descent_history.image_mut();
    let [images, increments] = [image, increments].map(|all| {
        // Nothing is written into registers that no contact of the last group is in: they must not
        // hold what another part has left.
        all.clear();
        all.resize(part.groups.len() * 3 * LANES, 0.0);
        all.as_chunks_mut::<LANES>().0.as_chunks_mut::<3>().0
    });
    let mut sums = LaneSums::zero(simd);
    for register in 0..ContactLanes::<S>::registers(contacts.len()) {
        let lanes = ContactLanes::new(simd, &part.groups, contacts, register);
        let r = lanes.load(&part.impulses[lanes.group_index]);
        let mut u = relative_velocities(&lanes, state, r);
        if evaluates_residual {
            sums.add(&lanes, u, r);
        }
        // Plain descent does not diverge with D below twice the reciprocal of the largest response.
        let bound = lanes.splat(metric::largest_response(state.metric_weight)) * lanes.responses();
        let mass = (bound / lanes.splat(2.0 * STEP_MARGIN) + lanes.compliance()).recip();
        u.0[0] = u.0[0] + lanes.dissipation([u.0[1], u.0[2]]);
        let next = nearest_in_cone(&lanes, r - u.scale(mass));
        lanes.store(next, &mut images[lanes.group_index]);
        let increment = (next - r).scale(lanes.responses().sqrt());
        lanes.store(increment, &mut increments[lanes.group_index]);
    }
    if evaluates_residual {
        part.sums = sums.reduce();
    }
}

/// Relative velocities that have been evaluated, m/s, in the frames, with what compliance adds.
#[inline(always)]
fn relative_velocities<S: Simd>(
    lanes: &ContactLanes<S>,
    state: &AdmmState,
    impulse: V3<S>,
) -> V3<S> {
    let velocity = lanes.relative_velocities(&state.velocity_changes, &lanes.group.points);
    velocity + impulse.scale(lanes.compliance())
}

/// The next impulses of the descent: the accelerated ones, back into the cones.
#[inline(always)]
fn descent_update<S: Simd>(
    simd: S,
    part: &mut AdmmPart,
    state: &AdmmState,
    update: &AndersonUpdate,
    buffer: &mut Vec<f64>,
) {
    let contacts = &state.contacts[part.contacts.clone()];
    let next = part.descent_history.apply(update, buffer);
    let next = next.as_chunks::<LANES>().0.as_chunks::<3>().0;
    for register in 0..ContactLanes::<S>::registers(contacts.len()) {
        let lanes = ContactLanes::new(simd, &part.groups, contacts, register);
        let r = nearest_in_cone(&lanes, lanes.load(&next[lanes.group_index]));
        store_impulses(&lanes, r, &mut part.impulses, state, part.contacts.start);
    }
}

/// Stores impulses, N s, in the contacts' frames, and their changes from the given ones, world. The
/// first contact of the part is number `start`.
#[inline(always)]
fn store_impulses<S: Simd>(
    lanes: &ContactLanes<S>,
    r: V3<S>,
    impulses: &mut [VectorLanes<f64>],
    state: &AdmmState,
    start: usize,
) {
    lanes.store(r, &mut impulses[lanes.group_index]);
    let changes = lanes.unpack(lanes.in_world(r - lanes.given_impulses()));
    for (i, change) in lanes.range().zip(&changes) {
        state.impulse_changes.set(start + i, change);
    }
}

/// Impulses within the cones, whose tips are at minus the adhesion, nearest to others, N s.
#[inline(always)]
fn nearest_in_cone<S: Simd>(lanes: &ContactLanes<S>, V3([n, s, t]): V3<S>) -> V3<S> {
    let tip = lanes.adhesion();
    let V3([n, s, t]) = lanes.project_cone(V3([n + tip, s, t]));
    V3([n - tip, s, t])
}

/// Slips that the friction does not allow, m/s, as the slip of [`crate::Violation`].
#[inline(always)]
fn slip_error<S: Simd>(
    lanes: &ContactLanes<S>,
    u: V3<S>,
    impulse: V3<S>,
    weight: Lane<S>,
) -> Lane<S> {
    let zero = lanes.splat(0.0);
    let limit = (impulse.0[0] + lanes.adhesion()).max(zero);
    let V3([_, s, t]) = impulse - u.scale(weight);
    let [s, t] = lanes.project([s, t], limit);
    let along = (impulse.0[1] - s) * u.0[1] + (impulse.0[2] - t) * u.0[2];
    along.less_or_equal(zero).select(zero, along / norm([u.0[1], u.0[2]])) / weight
}

/// Something of joints where these velocities, m/s, are more than what is let be.
#[inline(always)]
fn moving<S: Simd>(u: V3<S>, of: V3<S>) -> V3<S> {
    let square = squared(u);
    let still = square.less_or_equal(square.lift(JOINT_CLOSED * JOINT_CLOSED));
    still.select(V3([square.lift(0.0); 3]), of)
}

/// Squares of the norms of vectors: sums of rounded squares, as each contact alone has them.
#[inline(always)]
fn squared<S: Simd>(V3([x, y, z]): V3<S>) -> Lane<S> {
    x * x + y * y + z * z
}

/// Sums and largest values of a [`ResidualSums`], by lane.
struct LaneSums<S: Simd> {
    residual_squares: Lane<S>,
    impulse_squares: Lane<S>,
    normal_error: Lane<S>,
    slip_error: Lane<S>,
}

impl<S: Simd> LaneSums<S> {
    #[inline(always)]
    fn zero(simd: S) -> Self {
        let zero = Lane::splat(simd, 0.0);
        Self { residual_squares: zero, impulse_squares: zero, normal_error: zero, slip_error: zero }
    }

    /// Adds contacts with their relative velocities, m/s, and impulses, N s, in their frames, as
    /// [`crate::Violation`] does.
    #[inline(always)]
    fn add(&mut self, lanes: &ContactLanes<S>, u: V3<S>, impulse: V3<S>) {
        let weight = lanes.weights();
        // The impulse from the cone's tip.
        let r = V3([impulse.0[0] + lanes.adhesion(), impulse.0[1], impulse.0[2]]);
        let [n, s, t] = u.0;
        let saxce = V3([n + lanes.dissipation([s, t]), s, t]);
        // The natural map of the law, with de Saxcé's term along the normal.
        let projected = lanes.project_cone(r - saxce.scale(weight));
        let mut normal_error = n.min(r.0[0] / weight).abs();
        let mut slip_error = slip_error(lanes, u, impulse, weight);
        let mut error = (r - projected).scale(lanes.heavier());
        if let Some(joint) = lanes.joint() {
            error = joint.select(moving(u, error), error);
            normal_error = joint.select(lanes.splat(0.0), normal_error);
            slip_error = joint.select(squared(u).sqrt(), slip_error);
        }
        self.residual_squares = self.residual_squares + squared(error);
        self.impulse_squares = self.impulse_squares + squared(r);
        self.normal_error = self.normal_error.max(normal_error);
        self.slip_error = self.slip_error.max(slip_error);
    }

    /// Sums and largest values over all lanes.
    #[inline(always)]
    fn reduce(self) -> ResidualSums {
        ResidualSums {
            residual_squares: self.residual_squares.reduce_sum(),
            impulse_squares: self.impulse_squares.reduce_sum(),
            normal_error: self.normal_error.reduce_max(),
            slip_error: self.slip_error.reduce_max(),
        }
    }
}
