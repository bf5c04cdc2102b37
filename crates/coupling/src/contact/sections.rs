//! Flat sections, by which fibres touch where their surfaces are.
//!
//! Detection sees a fibre as a tube as wide as the longest semi-axis of its section, and finds all
//! that may touch. Where two fibres do, the places along both and the normal become those where
//! their surfaces are closest (`closest_surfaces`). Each contact point is then moved to where a
//! plane across its normal touches the section: of an ellipse with the semi-axes `a` and `b` that
//! is at the height `h = sqrt(a^2 u1^2 + b^2 u2^2)` in the direction `u`, and aside. Of two fibres
//! that is exact, but where one is met on its way; at an object it is as far as this is flat.
//!
//! A section that is pressed rocks about the place where it lies flat, the faster the harder it is
//! pressed, and its places follow from list to list, not within a solve. They follow no faster than
//! a step can.

use super::closest_surfaces::{EllipticSegment, FacingPlace, SegmentPair, touched};
use super::warm_start::ExpectedImpulses;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use nalgebra::{Matrix3, Unit, Vector3};
use rapunzel_collision::{CapsuleContact, Capsules, Pair, segment_radii};
use rapunzel_fiber::{Assembly, Fiber, Layout};
use rayon::prelude::*;
use std::borrow::Cow;

/// Sections of all segments.
pub(crate) struct SectionShapes {
    /// The longest semi-axis of each segment, m.
    pub(crate) radii: Vec<f64>,
    /// Semi-axes of each segment along d1 and d2, m; none where all are round.
    semi_axes: Vec<[f64; 2]>,
    /// Polar inertia of each segment, kg m^2; none where all are round.
    inertias: Vec<f64>,
    /// The smallest ratio of a semi-axis to the other.
    flatness: f64,
}

/// Sections of all segments at the end of a motion.
#[derive(Clone, Copy)]
pub(crate) struct OrientedSections<'a> {
    pub(crate) shapes: &'a SectionShapes,
    /// Directors d1 and d2 of each segment; none where all count as round.
    pub(crate) directors: &'a [[Vector3<f64>; 2]],
}

impl SectionShapes {
    /// Sections of the fibres of an assembly; of the two at the ends of a segment the larger.
    pub(crate) fn new(assembly: &Assembly) -> Self {
        let layout = assembly.layout();
        let nodes = || assembly.fibers().iter().flat_map(Fiber::nodes);
        let along = |of: fn((f64, f64)) -> f64| {
            let own: Vec<f64> = nodes().map(|node| of(node.section.semi_axes())).collect();
            segment_radii(layout, &own)
        };
        let ratios = nodes().map(|node| {
            let (a, b) = node.section.semi_axes();
            a.min(b) / a.max(b)
        });
        let flatness = ratios.fold(1.0, f64::min);
        let radii = along(|(a, b)| a.max(b));
        if flatness == 1.0 {
            return Self::round(radii);
        }
        let both = along(|(a, _)| a).into_iter().zip(along(|(_, b)| b));
        let semi_axes: Vec<_> = both.map(|(a, b)| [a, b]).collect();
        let own = |fiber: &Fiber| (0..fiber.segments()).map(|s| fiber.segment_mass(s)).collect();
        let masses: Vec<Vec<f64>> = assembly.fibers().iter().map(own).collect();
        let inertia = |(mass, [a, b]): (f64, &[f64; 2])| 0.25 * mass * (a * a + b * b);
        let inertias = masses.into_iter().flatten().zip(&semi_axes).map(inertia).collect();
        Self { radii, semi_axes, inertias, flatness }
    }

    /// Circles with these radii, m.
    pub(crate) fn round(radii: Vec<f64>) -> Self {
        Self { radii, semi_axes: Vec::new(), inertias: Vec::new(), flatness: 1.0 }
    }

    /// The shorter semi-axis of a segment, m.
    pub(crate) fn height(&self, segment: usize) -> f64 {
        self.semi_axes.get(segment).map_or(self.radii[segment], |[a, b]| a.min(*b))
    }

    /// Whether all sections are circles.
    pub(crate) fn are_round(&self) -> bool {
        self.semi_axes.is_empty()
    }
}

impl OrientedSections<'_> {
    /// Part of the radii within which no axis of another fibre comes.
    pub(crate) fn inner(&self) -> f64 {
        if self.directors.is_empty() { 1.0 } else { self.shapes.flatness }
    }

    /// The ellipsoid of a segment: the sum over its semi-axes of their squares, m^2, along their
    /// directions, world. Across the segment it is the section, and a tip is half of it.
    fn ellipsoid(&self, segment: usize) -> Matrix3<f64> {
        let ([d1, d2], [a, b]) = (&self.directors[segment], self.shapes.semi_axes[segment]);
        let axes = [(d1, a * a), (d2, b * b), (&d1.cross(d2), a * b)];
        axes.into_iter().map(|(d, square)| d * square * d.transpose()).sum()
    }

    /// From the axis of a flat segment to where a plane across a direction `towards`, of unit
    /// length, touches it, m, world.
    fn support(&self, segment: usize, towards: &Vector3<f64>) -> Vector3<f64> {
        touched(&self.ellipsoid(segment), towards)
    }

    /// Two segments as their surfaces are; `None` if both are round.
    fn flat_pair(&self, end: &Capsules, pair: Pair) -> Option<SegmentPair> {
        let pair = pair.map(|segment| segment as usize);
        let flat = |segment: usize| self.shapes.semi_axes.get(segment).is_some_and(|[a, b]| a != b);
        if self.directors.is_empty() || !pair.into_iter().any(flat) {
            return None;
        }
        Some(SegmentPair(pair.map(|segment| {
            let axis = end.get(segment);
            let ([a, b], start) = (self.shapes.semi_axes[segment], axis.start);
            let (shape, sharpest) = (self.ellipsoid(segment), a.min(b).powi(2) / a.max(b));
            EllipticSegment { start, axis: axis.end - axis.start, shape, sharpest }
        })))
    }

    /// Contacts of axes, of each pair the closest before those beside it, where the surfaces of
    /// flat fibres are closest: with the places and normals of these, and with the gaps of tubes
    /// there.
    pub(crate) fn closest<'c>(
        &self,
        end: &Capsules,
        contacts: &'c [CapsuleContact],
    ) -> Cow<'c, [CapsuleContact]> {
        if self.directors.is_empty() {
            return Cow::Borrowed(contacts);
        }
        let one = |(i, contact): (usize, &CapsuleContact)| {
            let Some(pair) = self.flat_pair(end, contact.pair) else { return *contact };
            let axes =
                FacingPlace { fractions: contact.fractions, normal: contact.normal.into_inner() };
            let is_beside = i > 0 && contacts[i - 1].pair == contact.pair;
            let place = if is_beside {
                pair.beside(0, axes.fractions[0], &axes.normal)
            } else {
                pair.closest(&axes)
            };
            let radii: f64 = contact.pair.map(|s| self.shapes.radii[s as usize]).iter().sum();
            let gap = place.normal.dot(&pair.offset(place.fractions)) - radii;
            let normal = Unit::new_unchecked(place.normal);
            CapsuleContact { pair: contact.pair, fractions: place.fractions, normal, gap }
        };
        Cow::Owned(contacts.iter().enumerate().map(one).collect())
    }

    /// Distance of the surfaces of two segments, m, whose axes are apart by the root of a `squared`
    /// distance, m^2; `normal` is one of theirs, from the second to the first.
    pub(crate) fn gap(
        &self,
        end: &Capsules,
        pair: Pair,
        squared: f64,
        normal: &Vector3<f64>,
    ) -> f64 {
        let Some(flat) = self.flat_pair(end, pair) else {
            let [first, second] = pair.map(|segment| self.shapes.radii[segment as usize]);
            return squared.sqrt() - normal.dot(&(normal * second + normal * first));
        };
        let [first, second] = pair.map(|segment| end.get(segment as usize));
        let closest = first.closest(&second);
        let normal = closest.offset.try_normalize(0.0).unwrap_or(-normal);
        flat.separation(&flat.closest(&FacingPlace { fractions: closest.fractions, normal }))
    }

    /// Moves contact points to where the surfaces of flat fibres are.
    pub(crate) fn seat(&self, layout: &Layout, points: &mut [ContactPoint]) {
        if self.directors.is_empty() {
            return;
        }
        points.par_iter_mut().for_each(|point| {
            for side in 0..2 {
                let Some(segment) = segment(layout, point, side) else { continue };
                let towards = if side == 0 { -point.normal } else { point.normal };
                let place = self.support(segment, &towards);
                point.gap += self.shapes.radii[segment] - place.dot(&towards);
                point.seat(side, place);
            }
        });
    }

    /// Moves places that bear something so that no section rocks faster than a step of `dt` seconds
    /// can follow: a moment that acts aside by `x` turns a free section within the step so far that
    /// the place moves by so many `times` of `x`.
    ///
    /// Listed places are those of sections that turn as they do if they are pressed where they were
    /// in the step before. Pressed where it ends, a place goes `1 / (1 + times)` of the way from
    /// there to the listed one: between fibres it has this part, as backward Euler does. What else
    /// holds a section lets its place come to rest in more steps, but where it is listed. On an
    /// object a place has this part of the way from below the axis, and bears too little moment.
    pub(crate) fn settle(
        &self,
        layout: &Layout,
        dt: f64,
        expected: &ExpectedImpulses,
        points: &mut [ContactPoint],
    ) {
        if self.directors.is_empty() {
            return;
        }
        // All that rests on a segment turns it.
        let mut pressed = vec![0.0; self.shapes.radii.len()];
        for point in points.iter() {
            let push = point.impulse.dot(&point.normal).abs();
            let sides = [0, 1].into_iter().filter_map(|side| segment(layout, point, side));
            sides.for_each(|segment| pressed[segment] += push);
        }
        let bears = |point: &&mut ContactPoint| point.impulse != Vector3::zeros();
        points.par_iter_mut().filter(bears).for_each(|point| {
            let before = expected.nearest(point);
            for side in 0..2 {
                let Some(segment) = segment(layout, point, side) else { continue };
                let place = point.offsets[side];
                let height = point.normal * place.dot(&point.normal);
                let (rest, pressed) = if point.sides[1 - side].is_object() {
                    (height, point.impulse.dot(&point.normal).abs())
                } else {
                    let Some(before) = before.map(|before| before.offset(side)) else { continue };
                    let aside = before - point.normal * before.dot(&point.normal);
                    (height + aside, pressed[segment])
                };
                let [a, b] = self.shapes.semi_axes[segment];
                let roll = (a * a - b * b).abs() / height.norm().max(a.min(b));
                let times = pressed * dt * roll / self.shapes.inertias[segment];
                point.seat(side, rest + (place - rest) / (1.0 + times));
            }
        });
    }
}

/// The segment of all that a side of a contact point is on, if that is a fibre.
fn segment(layout: &Layout, point: &ContactPoint, side: usize) -> Option<usize> {
    let BodyRef::Fiber(fiber) = point.sides[side] else { return None };
    Some(layout.segment_range(fiber as usize).start + point.segments[side] as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Rotation3};
    use proptest::prelude::*;
    use rapunzel_collision::{contacts, squared_distances};

    const RADIUS: f64 = 1e-4;
    const LENGTH: f64 = 3e-3;

    proptest! {
        /// Of four fibres of a segment two are round. The pair of these stays as it is; the nearest
        /// contact of others has the gap of their surfaces. These have tubes within them, and are
        /// within those around them.
        #[test]
        fn flat_fibers_touch_with_their_surfaces(
            nodes in prop::array::uniform8(prop::array::uniform3(-1.0..1.0_f64)),
            turns in prop::array::uniform4(0.0..7.0_f64),
            ratio in 0.05..0.9_f64,
        ) {
            let layout = Layout::new([1; 4]);
            let place = |[x, y, z]: [f64; 3]| Point3::new(x * LENGTH, y * LENGTH, z * RADIUS);
            let nodes = nodes.map(place);
            let semi_axes = [1.0, ratio, 1.0, 0.5 * ratio].map(|part| [RADIUS, part * RADIUS]);
            let shapes = SectionShapes {
                radii: vec![RADIUS; 4],
                semi_axes: semi_axes.to_vec(),
                inertias: Vec::new(),
                flatness: 0.5 * ratio,
            };
            let directors = [0, 1, 2, 3].map(|s| {
                let along = Unit::new_normalize(nodes[2 * s + 1] - nodes[2 * s]);
                let d1 = along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
                let d1 = Rotation3::from_axis_angle(&along, turns[s]) * d1;
                [d1, along.cross(&d1)]
            });
            let sections = OrientedSections { shapes: &shapes, directors: &directors };
            let end = Capsules::new(&layout, &nodes, &shapes.radii).expect("one layout");
            for pair in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
                let mut found = Vec::new();
                contacts(&end, &[pair], LENGTH, &mut found).expect("a reach");
                let moved = sections.closest(&end, &found);
                if pair == [0, 2] {
                    prop_assert_eq!(&*moved, &*found);
                }
                let mut squared = Vec::new();
                squared_distances(&end, &[pair], &mut squared);
                let Some(contact) = moved.first() else { continue };
                let normal = -*contact.normal;
                let gap = sections.gap(&end, pair, squared[0], &normal);
                let [first, second] = pair.map(|segment| segment as usize);
                let far = sections.support(second, &normal) - sections.support(first, &-normal);
                let heights = normal.dot(&far);
                let own = contact.gap + 2.0 * RADIUS - heights;
                prop_assert!((own - gap).abs() < 1e-9 * LENGTH, "{own} of {gap}");
                let heights = pair.map(|s| sections.shapes.height(s as usize)).iter().sum::<f64>();
                let distance = squared[0].sqrt();
                prop_assert!(gap > distance - 2.0 * RADIUS - 1e-9 * LENGTH, "{gap}");
                prop_assert!(gap < distance - heights + 1e-9 * LENGTH, "{gap}");
            }
        }
    }
}
