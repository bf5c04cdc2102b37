//! What a pack of fibres is made of.
//!
//! Most hair of a bundle is alike: packs that are made one after another and are alike share it.

use super::array::{Array, at, set, zeros};
use crate::Rod;
use crate::joint::Joint;
use pulp::Simd;
use pulp::bytemuck::cast_slice;
use std::any::Any;
use std::cell::RefCell;
use std::sync::{Arc, Weak};

/// Numbers of up to eight fibres with equally many segments that their motion does not change.
pub(super) struct BatchModel<S: Simd> {
    /// Segment lengths.
    pub(super) h: Array<S>,
    /// Masses of the nodes.
    pub(super) mass: Array<S>,
    /// Inertias of d1 and d2 of each segment (2).
    pub(super) inertia: Array<S>,
    /// Stiffness of the joints over their lengths, and their natural rotation vectors (3).
    pub(super) stiffness: Array<S>,
    pub(super) rest: Array<S>,
}

impl<S: Simd> BatchModel<S> {
    /// Of at least one rod; spare lanes repeat the last one. Masses are lumped.
    pub(super) fn of(rods: &[Rod]) -> Arc<Self> {
        let n = rods[0].fiber.segments();
        let mut model = Self {
            h: zeros::<S>(n),
            mass: zeros::<S>(n + 1),
            inertia: zeros::<S>(2 * n),
            stiffness: zeros::<S>(3 * (n + 1)),
            rest: zeros::<S>(3 * (n + 1)),
        };
        for lane in 0..S::F64_LANES {
            model.fill(lane, &rods[lane.min(rods.len() - 1)]);
        }
        model.shared()
    }

    fn fill(&mut self, lane: usize, rod: &Rod) {
        let (fiber, n) = (&rod.fiber, rod.fiber.segments());
        let (nodes, h) = (fiber.nodes(), fiber.segment_lengths());
        for e in 0..n {
            set(&mut self.h, e, lane, h[e]);
            for a in [e, e + 1] {
                let mass = at(&self.mass, a, lane) + 0.5 * fiber.segment_mass(e);
                set(&mut self.mass, a, lane, mass);
            }
            // The kinetic energy of a section is rho (I2 |d1'|^2 + I1 |d2'|^2) / 2.
            let inertia = 0.5 * h[e] * (nodes[e].rotary_inertia + nodes[e + 1].rotary_inertia);
            set(&mut self.inertia, 2 * e, lane, inertia.y);
            set(&mut self.inertia, 2 * e + 1, lane, inertia.x);
        }
        for j in 0..=n {
            let joint = Joint::new(fiber, j);
            for i in 0..3 {
                set(&mut self.stiffness, 3 * j + i, lane, joint.stiffness[i]);
                set(&mut self.rest, 3 * j + i, lane, joint.rest[i]);
            }
        }
    }

    /// The last one of this thread in its place if that is the same, bit for bit.
    fn shared(self) -> Arc<Self> {
        LAST.with_borrow_mut(|last| {
            let known = last.upgrade().and_then(|known| known.downcast::<Self>().ok());
            if let Some(known) = known.filter(|known| known.bytes() == self.bytes()) {
                return known;
            }
            let new = Arc::new(self);
            *last = Arc::downgrade(&(Arc::clone(&new) as Arc<dyn Any + Send + Sync>));
            new
        })
    }

    fn bytes(&self) -> [&[u8]; 5] {
        let Self { h, mass, inertia, stiffness, rest } = self;
        [h, mass, inertia, stiffness, rest].map(|array| cast_slice(array))
    }
}

thread_local! {
    /// What the last pack of this thread was made of.
    static LAST: RefCell<Weak<dyn Any + Send + Sync>> = RefCell::new(Weak::<()>::new());
}
