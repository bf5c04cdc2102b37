//! A straight segment of a fiber against a field.

use super::{DistanceField, Sample};
use crate::Capsule;
use nalgebra::Vector3;

/// A place where a capsule touches a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldContact {
    /// Fraction along the axis, in 0..=1.
    pub fraction: f64,
    /// Value of the field there less the radius of the capsule, m; negative in penetration.
    pub gap: f64,
    /// Unit normal, out of the surface (world); zero where the field has no gradient.
    pub normal: Vector3<f64>,
}

/// How a segment is searched for contacts.
///
/// Nothing is missed between samples: a part of the axis is left out only where the value at its
/// middle and the Lipschitz constant of the field show that it is clear, and is halved otherwise.
/// The thesis samples at a rate of the user's choice (7.2.2) and adds half of the radius, where it
/// must be all of it (erratum).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactSearch {
    /// Gap up to which a place is a contact, m.
    pub margin: f64,
    /// How finely a part in contact is sampled, m, in search of its deepest point.
    pub spacing: f64,
    /// Gaps are told apart only if they differ by more than this, m; positive.
    pub tolerance: f64,
}

/// A part of the axis that cannot be told from one in contact, and a sample in it.
#[derive(Clone, Copy)]
struct AxisPart {
    ends: [f64; 2],
    fraction: f64,
    value: f64,
}

impl ContactSearch {
    /// Appends the contacts of `capsule`, in order along its axis.
    ///
    /// The points of the axis whose gap is at most the margin lie in a few connected runs. Each run
    /// gives its deepest point, or, where it is as deep to within the tolerance over more than the
    /// spacing, the first and the last such point: a fiber that lies flat is held at two points. A
    /// run may be reported falsely only if its gap is less than `margin + tolerance`. The deepest
    /// point is that of a convex surface exactly, to the tolerance; of a rough one it is a point
    /// where the gap is least among its neighbors at the distance of the spacing.
    ///
    /// Cost: two or three samples of the field for a segment that is clear, `length / spacing` for
    /// one that lies on the surface, and at most `length / tolerance` for one that hovers just
    /// above the margin.
    pub fn contacts(
        &self,
        field: &impl DistanceField,
        capsule: &Capsule,
        contacts: &mut Vec<FieldContact>,
    ) {
        let probe = AxisProbe {
            field,
            capsule,
            length: (capsule.end - capsule.start).norm(),
            reach: capsule.radius + self.margin,
            search: *self,
        };
        let mut parts = Vec::new();
        probe.collect([0.0, 1.0], &mut parts);
        for run in parts.chunk_by(|a, b| a.ends[1] == b.ends[0]) {
            probe.report(run, contacts);
        }
    }
}

struct AxisProbe<'a, F> {
    field: &'a F,
    capsule: &'a Capsule,
    length: f64,
    reach: f64,
    search: ContactSearch,
}

impl<F: DistanceField> AxisProbe<'_, F> {
    fn sample(&self, fraction: f64) -> Sample {
        self.field.sample(&self.capsule.at(fraction))
    }

    /// Finds the parts between two fractions that are in contact, in order.
    fn collect(&self, ends: [f64; 2], parts: &mut Vec<AxisPart>) {
        let fraction = 0.5 * (ends[0] + ends[1]);
        let value = self.field.value(&self.capsule.at(fraction));
        let change = 0.5 * self.field.lipschitz() * (ends[1] - ends[0]) * self.length;
        let places = ends.map(|end| self.capsule.at(end));
        let near = value - change <= self.reach
            && self.field.least_between(&places[0], &places[1]) <= self.reach;
        let ContactSearch { spacing, tolerance, .. } = self.search;
        // A tolerance below the rounding would not end.
        let small = change <= tolerance.max(1e-9 * self.length);
        let fine = (ends[1] - ends[0]) * self.length <= spacing;
        if near && (small || fine && value <= self.reach) {
            parts.push(AxisPart { ends, fraction, value });
        } else if near {
            self.collect([ends[0], fraction], parts);
            self.collect([fraction, ends[1]], parts);
        }
    }

    /// The contacts of one run of parts.
    fn report(&self, run: &[AxisPart], contacts: &mut Vec<FieldContact>) {
        let (Some(first), Some(last)) = (run.first(), run.last()) else { return };
        // The ends of the run, which may be those of the axis, belong to the samples.
        let mut samples: Vec<_> = run.iter().map(|part| (part.fraction, part.value)).collect();
        samples.insert(0, (first.ends[0], self.sample(first.ends[0]).value));
        samples.push((last.ends[1], self.sample(last.ends[1]).value));
        let least = (0..samples.len()).min_by(|&i, &j| samples[i].1.total_cmp(&samples[j].1));
        let least = least.unwrap_or(0);
        let neighbor = |k: usize| samples[k.min(samples.len() - 1)].0;
        let deepest =
            self.descend(neighbor(least.saturating_sub(1)), samples[least], neighbor(least + 1));
        let flat = |&&(_, value): &&(f64, f64)| value <= deepest.1 + self.search.tolerance;
        let (low, high) = (samples.iter().find(flat), samples.iter().rfind(flat));
        match (low, high) {
            (Some(low), Some(high)) if (high.0 - low.0) * self.length > self.search.spacing => {
                contacts.extend([self.contact(low.0), self.contact(high.0)]);
            }
            _ => contacts.push(self.contact(deepest.0)),
        }
    }

    /// The least value between two fractions, found by the slope from a first guess.
    fn descend(&self, mut low: f64, guess: (f64, f64), mut high: f64) -> (f64, f64) {
        let axis = self.capsule.end - self.capsule.start;
        let mut best = guess;
        let mut middle = guess.0;
        while (high - low) * self.length > self.search.tolerance.max(1e-9 * self.length) {
            let Sample { value, gradient } = self.sample(middle);
            if value < best.1 {
                best = (middle, value);
            }
            if gradient.dot(&axis) > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
            middle = 0.5 * (low + high);
        }
        best
    }

    fn contact(&self, fraction: f64) -> FieldContact {
        let Sample { value, gradient } = self.sample(fraction);
        let normal = gradient.try_normalize(0.0).unwrap_or_default();
        FieldContact { fraction, gap: value - self.capsule.radius, normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Ball, Cuboid, HalfSpace};
    use nalgebra::{Point3, Unit};

    const SEARCH: ContactSearch = ContactSearch { margin: 1e-5, spacing: 2e-4, tolerance: 1e-6 };

    fn hair(start: [f64; 3], end: [f64; 3]) -> Capsule {
        Capsule { start: start.into(), end: end.into(), radius: 35e-6 }
    }

    fn contacts(field: &impl DistanceField, capsule: &Capsule) -> Vec<FieldContact> {
        let mut contacts = Vec::new();
        SEARCH.contacts(field, capsule, &mut contacts);
        contacts
    }

    fn ground() -> HalfSpace {
        HalfSpace { point: Point3::origin(), normal: Unit::new_unchecked(Vector3::z()) }
    }

    #[test]
    fn a_fiber_that_lies_flat_is_held_at_both_ends() {
        for z in [40e-6, 20e-6, -1e-3] {
            let found = contacts(&ground(), &hair([0.0, 0.0, z], [3e-3, 0.0, z]));
            let ends: Vec<_> = found.iter().map(|c| c.fraction).collect();
            assert_eq!(ends, [0.0, 1.0]);
            for contact in found {
                assert!((contact.gap - (z - 35e-6)).abs() <= 1e-18);
                assert_eq!(contact.normal, Vector3::z());
            }
        }
        assert_eq!(contacts(&ground(), &hair([0.0, 0.0, 50e-6], [3e-3, 0.0, 50e-6])), []);
    }

    #[test]
    fn a_fiber_that_slopes_touches_with_its_tip() {
        let found = contacts(&ground(), &hair([0.0, 0.0, 1e-3], [3e-3, 0.0, 20e-6]));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].fraction, 1.0);
    }

    #[test]
    fn the_deepest_point_on_a_ball_is_found() {
        let ball = Ball { center: Point3::origin(), radius: 2e-3 };
        let found = contacts(&ball, &hair([-1e-3, 0.0, 2.02e-3], [2e-3, 0.0, 2.02e-3]));
        assert_eq!(found.len(), 1);
        assert!((found[0].fraction - 1.0 / 3.0).abs() <= 1e-6 / 3e-3);
        assert!((found[0].gap - (20e-6 - 35e-6)).abs() <= 1e-9);
    }

    #[test]
    fn two_bumps_are_two_contacts() {
        struct Two(Ball, Ball);
        impl DistanceField for Two {
            fn sample(&self, point: &Point3<f64>) -> Sample {
                let (a, b) = (self.0.sample(point), self.1.sample(point));
                if a.value < b.value { a } else { b }
            }
        }
        let ball = |x: f64| Ball { center: Point3::new(x, 0.0, 0.0), radius: 0.2e-3 };
        let found = contacts(
            &Two(ball(0.5e-3), ball(2e-3)),
            &hair([0.0, 0.0, 0.23e-3], [3e-3, 0.0, 0.23e-3]),
        );
        assert_eq!(found.len(), 2);
        assert!((found[0].fraction - 0.5 / 3.0).abs() <= 1e-3);
        assert!((found[1].fraction - 2.0 / 3.0).abs() <= 1e-3);
    }

    #[test]
    fn what_is_no_number_or_no_length_ends() {
        let cuboid = Cuboid { half: Vector3::repeat(1e-3) };
        assert_eq!(contacts(&cuboid, &hair([f64::NAN; 3], [0.0; 3])), []);
        assert_eq!(contacts(&cuboid, &hair([1.02e-3, 0.0, 0.0], [1.02e-3, 0.0, 0.0])).len(), 1);
        assert!(contacts(&cuboid, &hair([0.0; 3], [1e300, 0.0, 0.0])).len() <= 2);
    }
}
