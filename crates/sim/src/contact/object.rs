//! What fibres lie on and bump into.

use super::touch::{Partner, Touch};
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::field::{DistanceField, FieldContact, Sample, Search};

/// A surface with its pose over time.
pub(crate) struct Object {
    /// In the object's own frame.
    pub(crate) field: Box<dyn DistanceField + Send + Sync>,
    pub(crate) pose: Box<dyn Fn(f64) -> Isometry3<f64> + Send + Sync>,
}

/// A field somewhere.
struct Placed<'a> {
    field: &'a (dyn DistanceField + Send + Sync),
    pose: Isometry3<f64>,
}

impl DistanceField for Placed<'_> {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let Sample { value, gradient } =
            self.field.sample(&self.pose.inverse_transform_point(point));
        Sample { value, gradient: self.pose * gradient }
    }

    fn value(&self, point: &Point3<f64>) -> f64 {
        self.field.value(&self.pose.inverse_transform_point(point))
    }

    fn lipschitz(&self) -> f64 {
        self.field.lipschitz()
    }

    fn error(&self) -> f64 {
        self.field.error()
    }

    fn band(&self) -> f64 {
        self.field.band()
    }
}

/// One fibre at the end of a step.
pub(crate) struct Strand<'a> {
    pub(crate) fiber: u32,
    pub(crate) nodes: &'a [Point3<f64>],
    pub(crate) radii: &'a [f64],
}

impl Object {
    /// Appends where a fibre touches the object after the step from `time` to `time + dt`, with
    /// gaps up to `margin`, m.
    pub(crate) fn touches(
        &self,
        index: u32,
        strand: &Strand,
        [time, dt]: [f64; 2],
        margin: f64,
        found: &mut Vec<Touch>,
    ) {
        let [before, after] = [time, time + dt].map(|t| (self.pose)(t));
        let placed = Placed { field: &*self.field, pose: after };
        let slope = placed.lipschitz();
        let values: Vec<f64> = strand.nodes.iter().map(|node| placed.value(node)).collect();
        let mut contacts: Vec<FieldContact> = Vec::new();
        for (s, radius) in (0_u32..).zip(strand.radii) {
            let [a, b] = [s as usize, s as usize + 1];
            let (start, end) = (strand.nodes[a], strand.nodes[b]);
            let length = (end - start).norm();
            // No point of the segment is nearer than this.
            if 0.5 * (values[a] + values[b] - slope * length) > radius + margin {
                continue;
            }
            contacts.clear();
            let capsule = Capsule { start, end, radius: *radius };
            let search = Search { margin, spacing: 0.1 * length, tolerance: 1e-3 * radius };
            search.contacts(&placed, &capsule, &mut contacts);
            for contact in contacts.iter().filter(|c| c.normal != Vector3::zeros()) {
                let place = start + contact.fraction * (end - start)
                    - contact.normal * (contact.gap + radius);
                let was = before * after.inverse_transform_point(&place);
                found.push(Touch {
                    fiber: strand.fiber,
                    partner: Partner::Object(index),
                    segments: [s, 0],
                    fractions: [contact.fraction, 0.0],
                    normal: contact.normal,
                    axis: end - start,
                    other_axis: Vector3::zeros(),
                    gap: contact.gap,
                    drive: (place - was) / dt,
                    impulse: Vector3::zeros(),
                });
            }
        }
    }
}
