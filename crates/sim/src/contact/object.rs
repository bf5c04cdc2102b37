//! What fibres lie on and bump into.

use super::touch::{Partner, Touch};
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::continuous::MovingSegment;
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

/// One fibre before and after a step.
pub(crate) struct Strand<'a> {
    pub(crate) fiber: u32,
    pub(crate) start: &'a [Point3<f64>],
    pub(crate) end: &'a [Point3<f64>],
    pub(crate) radii: &'a [f64],
}

impl Object {
    /// Appends where a fibre touches the object after the step from `time` to `time + dt`, with
    /// gaps up to `margin`, m, or would have passed into it on the way.
    pub(crate) fn touches(
        &self,
        index: u32,
        strand: &Strand,
        [time, dt]: [f64; 2],
        margin: f64,
        found: &mut Vec<Touch>,
    ) {
        let poses = [time, time + dt].map(|t| (self.pose)(t));
        let placed = Placed { field: &*self.field, pose: poses[1] };
        let slope = placed.lipschitz();
        let values: Vec<f64> = strand.end.iter().map(|node| placed.value(node)).collect();
        let mut contacts: Vec<FieldContact> = Vec::new();
        for (s, &radius) in strand.radii.iter().enumerate() {
            let (start, end) = (strand.end[s], strand.end[s + 1]);
            let length = (end - start).norm();
            contacts.clear();
            if let Some(contact) = self.passing(strand, s, poses) {
                contacts.push(contact);
            } else if 0.5 * (values[s] + values[s + 1] - slope * length) <= radius + margin {
                // No point of other segments is near enough.
                let capsule = Capsule { start, end, radius };
                let search = Search { margin, spacing: 0.1 * length, tolerance: 1e-3 * radius };
                search.contacts(&placed, &capsule, &mut contacts);
            }
            for contact in contacts.iter().filter(|c| c.normal != Vector3::zeros()) {
                let place = start + contact.fraction * (end - start)
                    - contact.normal * (contact.gap + radius);
                let was = poses[0] * poses[1].inverse_transform_point(&place);
                #[expect(clippy::cast_possible_truncation, reason = "counted with 32 bits")]
                let segment = s as u32;
                found.push(Touch {
                    fiber: strand.fiber,
                    partner: Partner::Object(index),
                    segments: [segment, 0],
                    fractions: [contact.fraction, 0.0],
                    normal: contact.normal,
                    axis: end - start,
                    other_axis: Vector3::zeros(),
                    gap: contact.gap,
                    drive: (place - was) / dt,
                    impulse: Vector3::zeros(),
                    working: false,
                });
            }
        }
    }

    /// Where the axis of a segment that moves by more than its radius meets the surface, with the
    /// gap along the normal there that the end of the step would leave.
    fn passing(
        &self,
        strand: &Strand,
        segment: usize,
        poses: [Isometry3<f64>; 2],
    ) -> Option<FieldContact> {
        let radius = strand.radii[segment];
        let own = |nodes: &[Point3<f64>], pose: &Isometry3<f64>| {
            [0, 1].map(|k| pose.inverse_transform_point(&nodes[segment + k]))
        };
        let before = own(strand.start, &poses[0]);
        let after = own(strand.end, &poses[1]);
        let way = (after[0] - before[0]).norm().max((after[1] - before[1]).norm());
        if way < radius {
            return None;
        }
        let moving = MovingSegment { before, after };
        let impact = moving.impact_on(&&*self.field, 0.0, 0.1 * radius)?;
        let [fraction] = impact.coordinates;
        let place = moving.at(impact.time, radius).at(fraction);
        let Sample { value, gradient } = self.field.sample(&place);
        let normal = gradient.try_normalize(0.0)?;
        let surface = place - value * normal;
        let gap = normal.dot(&(moving.at(1.0, radius).at(fraction) - surface)) - radius;
        Some(FieldContact { fraction, gap, normal: poses[1] * normal })
    }
}
