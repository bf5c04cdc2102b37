//! Impulses on points of the fibres of a batch. Few places have any, so only these are gone
//! through.

use super::array::{fit, set};
use super::ends::EndKind;
use super::point_places::{both_nodes, components, segment};
use super::simd_batch::SimdBatch;
use crate::{Impulses, PointAction};
use nalgebra::Vector3;
use pulp::Simd;
use pulp::bytemuck::{self, Zeroable};

fn numbers<S: Simd>(array: &mut [S::f64s]) -> &mut [f64] {
    bytemuck::cast_slice_mut(array)
}

impl<S: Simd> SimdBatch<S> {
    /// Takes all impulses off.
    pub(super) fn clear_impulses(&mut self) {
        if !self.pressed.is_empty() {
            self.put_impulses(Impulses::NONE);
            self.moments.clear();
        }
    }

    /// Puts impulses in place of those before; what holds an end takes up an impulse on it, or its
    /// part.
    pub(super) fn put_impulses(&mut self, Impulses { points, impulses }: Impulses) {
        let Self { pressed, impulses: on_nodes, moments, .. } = self;
        for (array, places) in
            [(&mut *on_nodes, &mut pressed.nodes), (&mut *moments, &mut pressed.segments)]
        {
            let all = numbers::<S>(array);
            places.drain(..).flat_map(components::<S>).for_each(|i| all[i] = 0.0);
        }
        self.absorbed = [[S::f64s::zeroed(); 3]; 2];
        for (point, impulse) in points.iter().zip(impulses) {
            let moment = point.moment(impulse);
            if moment != Vector3::zeros() {
                if moments.is_empty() {
                    fit::<S>(moments, 3 * self.chain.n);
                }
                let place = *segment::<S>(point).start();
                let all = numbers::<S>(moments);
                components::<S>(place).iter().zip(&moment).for_each(|(&i, x)| all[i] += x);
                pressed.segments.push(place);
            }
            if let PointAction::Force { .. } = point.action {
                let before = *both_nodes::<S>(point).start();
                let all = numbers::<S>(on_nodes);
                for (place, share) in
                    [before, before + 3 * S::F64_LANES].into_iter().zip(point.shares())
                {
                    components::<S>(place).iter().zip(impulse).for_each(|(&i, x)| {
                        all[i] += x * share;
                    });
                    pressed.nodes.push(place);
                }
            }
        }
        pressed.sort();
        if !points.is_empty() {
            self.absorb_at_ends();
        }
    }

    /// Lets what holds ends take up the impulses on them.
    fn absorb_at_ends(&mut self) {
        let n = self.chain.n;
        for lane in 0..self.fibers {
            let held = self.held[lane];
            for (end, (a, kind)) in [(0, held.root), (n, held.tip)].into_iter().enumerate() {
                let whole = self.vector(&self.impulses, a, lane);
                let absorbed = match (kind, &self.chain.supports) {
                    (EndKind::Held, _) => whole,
                    (EndKind::Supported, Some(both)) => both[end].kept(lane, &whole),
                    _ => continue,
                };
                for i in 0..3 {
                    set(&mut self.impulses, 3 * a + i, lane, whole[i] - absorbed[i]);
                    set(&mut self.absorbed[end], i, lane, absorbed[i]);
                }
            }
        }
    }

    /// Puts impulses in place of those before, and what they change by, as far as no end takes it
    /// up, into the workspace. Returns whether that is anything but zeros.
    pub(super) fn exchange_impulses(&mut self, impulses: Impulses) -> bool {
        let zero = S::f64s::zeroed();
        self.chain.room.values.fill(zero);
        self.chain.room.turns.fill(zero);
        self.add_impulses(-1.0);
        self.put_impulses(impulses);
        self.add_impulses(1.0);
        let room = &self.chain.room;
        let changes = |array: &[S::f64s]| {
            // No early exit, so that the loop can be vectorised.
            let numbers = bytemuck::cast_slice::<S::f64s, f64>(array);
            numbers.iter().fold(false, |some, x| some | (*x != 0.0))
        };
        changes(&room.values) | changes(&room.turns)
    }

    /// Adds so many times the impulses and their moments to what is in the workspace.
    fn add_impulses(&mut self, times: f64) {
        let room = &mut self.chain.room;
        let Self { pressed, impulses, moments, .. } = self;
        for (sums, own, places) in [
            (&mut room.values, impulses, &pressed.nodes),
            (&mut room.turns, moments, &pressed.segments),
        ] {
            let (sums, own) = (numbers::<S>(sums), numbers::<S>(own));
            for i in places.iter().copied().flat_map(components::<S>) {
                sums[i] += times * own[i];
            }
        }
    }
}
