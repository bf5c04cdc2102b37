//! Constant properties of a SIMD batch of fibres. Most hair of a bundle is alike: batches that are
//! built one after another from equal fibres share them.

use super::array::{Array, at, set, zeros};
use crate::Rod;
use crate::joint::Joint;
use nalgebra::Vector2;
use pulp::Simd;
use pulp::bytemuck::cast_slice;
use std::any::Any;
use std::cell::RefCell;
use std::sync::{Arc, Weak};

/// Constant properties of up to eight fibres with equally many segments, one fibre per lane.
pub(super) struct BatchModel<S: Simd> {
    /// Segment lengths, m (1 per segment).
    pub(super) h: Array<S>,
    /// Lumped masses of the nodes, kg (1 per node).
    pub(super) mass: Array<S>,
    /// Inertias of the directors d1 and d2, kg m^2 (2 per segment).
    pub(super) inertia: Array<S>,
    /// Stiffness of the joints divided by their lengths, N m (3 per joint).
    pub(super) stiffness: Array<S>,
    /// Natural rotation vectors of the joints, rad (3 per joint).
    pub(super) rest: Array<S>,
    /// 1 in lanes whose fibre is straight by nature and bends alike to all sides, so that it may
    /// spin in any shape without resistance, else 0.
    pub(super) round: Array<S>,
}

impl<S: Simd> BatchModel<S> {
    /// Model of at least one rod; spare lanes repeat the last one. Masses are lumped.
    pub(super) fn of(rods: &[Rod]) -> Arc<Self> {
        let n = rods[0].fiber.segments();
        let mut model = Self {
            h: zeros::<S>(n),
            mass: zeros::<S>(n + 1),
            inertia: zeros::<S>(2 * n),
            stiffness: zeros::<S>(3 * (n + 1)),
            rest: zeros::<S>(3 * (n + 1)),
            round: zeros::<S>(1),
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
        let mut round = true;
        for j in 0..=n {
            let joint = Joint::new(fiber, j);
            for i in 0..3 {
                set(&mut self.stiffness, 3 * j + i, lane, joint.stiffness[i]);
                set(&mut self.rest, 3 * j + i, lane, joint.rest[i]);
            }
            let alike = joint.stiffness.x == joint.stiffness.y;
            round &= alike && joint.rest.xy() == Vector2::zeros();
        }
        set(&mut self.round, 0, lane, f64::from(round));
    }

    /// The last model built on this thread if it equals this one bit for bit, else this one.
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

    fn bytes(&self) -> [&[u8]; 6] {
        let Self { h, mass, inertia, stiffness, rest, round } = self;
        [h, mass, inertia, stiffness, rest, round].map(|array| cast_slice(array))
    }
}

thread_local! {
    /// The last model built on this thread, while any batch uses it.
    static LAST: RefCell<Weak<dyn Any + Send + Sync>> = RefCell::new(Weak::<()>::new());
}
