//! Places where fibres rest on objects, which stay from step to step.
//!
//! On a curved surface a segment touches where it is tangent, and that place moves along it by the
//! radius of curvature times the angle by which the segment turns. Found anew in every step it
//! follows the turn a step late: what bears there turns the segment back, by as much as tension
//! resists, so that a taut fibre goes to and fro for ever. A place that stays is a fixed point.

use rapunzel_collision::Capsule;
use rapunzel_collision::field::{DistanceField, FieldContact, Sample};

/// A place where a fibre rests on an object.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HeldPlace {
    /// The fibre and the object.
    pub(crate) pair: [u32; 2],
    /// Where on the fibre, in segments from the root.
    pub(crate) at: f64,
}

/// Places where fibres rest on objects.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct HeldPlaces<'a> {
    /// The places, by pair and in order.
    pub(crate) places: &'a [HeldPlace],
    /// How much deeper than there fibres may be nearby, m.
    pub(crate) slack: f64,
}

impl HeldPlaces<'_> {
    /// The places of a fibre and an object.
    pub(crate) fn of_pair(&self, pair: [u32; 2]) -> Self {
        let start = self.places.partition_point(|place| place.pair < pair);
        let end = self.places.partition_point(|place| place.pair <= pair);
        Self { places: &self.places[start..end], ..*self }
    }

    /// Replaces contacts of a segment, whose number is given, by the places on it where its fibre
    /// rests. These are to be of one pair.
    pub(crate) fn keep(
        &self,
        segment: usize,
        field: &impl DistanceField,
        capsule: &Capsule,
        contacts: &mut [FieldContact],
    ) {
        let first = segment as f64;
        let start = self.places.partition_point(|place| place.at < first);
        let end = start + self.places[start..].partition_point(|place| place.at <= first + 1.0);
        let on_segment = &self.places[start..end];
        if on_segment.is_empty() {
            return;
        }
        let found = contacts.to_vec();
        for place in on_segment {
            let fraction = place.at - first;
            let Sample { value, gradient } = field.sample(&capsule.at(fraction));
            let (gap, Some(normal)) = (value - capsule.radius, gradient.try_normalize(0.0)) else {
                continue;
            };
            let far = |i: &usize| (found[*i].fraction - fraction).abs();
            let nearest = (0..found.len()).min_by(|i, j| far(i).total_cmp(&far(j)));
            let Some(i) = nearest.filter(|&i| gap <= found[i].gap + self.slack) else { continue };
            // Of several the deepest stays.
            if contacts[i] == found[i] || gap < contacts[i].gap {
                contacts[i] = FieldContact { fraction, gap, normal };
            }
        }
    }
}
