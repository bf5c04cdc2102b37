//! What is known of the fields of objects at nodes from when they were last asked there.

use nalgebra::Point3;
use rapunzel_collision::field::DistanceField;
use rapunzel_fiber::Layout;

/// The value of an object's field where a node was when it was last looked at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct KnownValue {
    /// Where that was, in the frame of the object, m.
    place: Point3<f64>,
    /// m.
    value: f64,
}

impl KnownValue {
    /// Nothing is known.
    pub(crate) const NONE: Self =
        Self { place: Point3::new(f64::NAN, f64::NAN, f64::NAN), value: f64::NEG_INFINITY };

    /// A lower bound, but for roundings, of the value at a place (in the frame of the object), m,
    /// of a field that changes by at most `slope` along a way. No number where nothing is known.
    pub(crate) fn least_at(&self, place: &Point3<f64>, slope: f64) -> f64 {
        self.value - slope * (place - self.place).norm()
    }

    /// The value at a place (in the frame of the object), m, for which the field is asked unless
    /// that was the last place.
    pub(crate) fn value_at(&mut self, place: &Point3<f64>, field: &dyn DistanceField) -> f64 {
        if self.place != *place {
            *self = Self { place: *place, value: field.value(place) };
        }
        self.value
    }
}

/// What is known at all nodes of all objects' fields: by fibre, and object by object.
#[derive(Debug, Default)]
pub(crate) struct KnownValues(Vec<Vec<KnownValue>>);

impl KnownValues {
    /// What is known at the nodes of each fibre, of so many objects.
    pub(crate) fn of_fibers(&mut self, layout: &Layout, objects: usize) -> &mut [Vec<KnownValue>] {
        self.0.resize_with(layout.fibers(), Vec::new);
        for (fiber, known) in self.0.iter_mut().enumerate() {
            known.resize(objects * layout.node_range(fiber).len(), KnownValue::NONE);
        }
        &mut self.0
    }
}
