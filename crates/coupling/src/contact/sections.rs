//! Flat sections, by which fibres touch where their surfaces are.
//!
//! Detection sees a fibre as a tube as wide as the longest semi-axis of its section, and finds
//! all that may touch. Each contact point is then moved to where a plane across its normal
//! touches the section: of an ellipse with the semi-axes `a` and `b` that is at the height
//! `h = sqrt(a^2 u1^2 + b^2 u2^2)` in the direction `u`, and aside. At an object that is exact as
//! far as this is flat; of two ellipses side by side the normal stays that of their axes, and the
//! gap along it is that of two planes between them, at most what it is.
//!
//! A section that is pressed rocks about the place where it lies flat, the faster the harder it is
//! pressed, and its places follow from list to list, not within a solve. What would rock faster
//! than a step can follow is pressed along the normal, without what is aside.

use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use nalgebra::Vector3;
use rapunzel_collision::segment_radii;
use rapunzel_fiber::{Assembly, Fiber, Layout};
use rayon::prelude::*;

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

    /// From the axis of a segment to where a plane across a direction `towards`, of unit length,
    /// touches it, m, world. A tip is half an ellipsoid.
    fn support(&self, segment: usize, towards: &Vector3<f64>) -> Vector3<f64> {
        let Some([d1, d2]) = self.directors.get(segment) else {
            return towards * self.shapes.radii[segment];
        };
        let [a, b] = self.shapes.semi_axes[segment];
        let axes = [(d1, a * a), (d2, b * b), (&d1.cross(d2), a * b)];
        let far = axes.into_iter().map(|(d, square)| d * (square * d.dot(towards)));
        let far = far.sum::<Vector3<f64>>();
        // The height is the root of this, and never zero.
        far / far.dot(towards).sqrt()
    }

    /// How far from the axes of two segments the planes that touch them across a normal, from the
    /// second to the first, are together, m.
    pub(crate) fn heights(&self, segments: [usize; 2], normal: &Vector3<f64>) -> f64 {
        let [first, second] = segments;
        normal.dot(&(self.support(second, normal) - self.support(first, &-normal)))
    }

    /// Moves contact points to where the surfaces of flat fibres are.
    pub(crate) fn seat(&self, layout: &Layout, points: &mut [ContactPoint]) {
        if self.directors.is_empty() {
            return;
        }
        points.par_iter_mut().for_each(|point| {
            for side in 0..2 {
                let BodyRef::Fiber(fiber) = point.sides[side] else { continue };
                let first = layout.segment_range(fiber as usize).start;
                let segment = first + point.segments[side] as usize;
                let towards = if side == 0 { -point.normal } else { point.normal };
                let place = self.support(segment, &towards);
                point.gap += self.shapes.radii[segment] - place.dot(&towards);
                point.seat(side, place);
            }
        });
    }

    /// Moves places that bear something, by what rests on them in a step of `dt` seconds, along the
    /// normal of those that would rock too fast: a moment that acts aside by `x` turns a section
    /// within the step so far that the place moves by so many times `x`.
    pub(crate) fn settle(&self, layout: &Layout, dt: f64, points: &mut [ContactPoint]) {
        if self.directors.is_empty() {
            return;
        }
        let bears = |point: &&mut ContactPoint| point.impulse != Vector3::zeros();
        points.par_iter_mut().filter(bears).for_each(|point| {
            for side in 0..2 {
                let BodyRef::Fiber(fiber) = point.sides[side] else { continue };
                let first = layout.segment_range(fiber as usize).start;
                let segment = first + point.segments[side] as usize;
                let [a, b] = self.shapes.semi_axes[segment];
                let place = point.offsets[side];
                let height = point.normal * place.dot(&point.normal);
                let roll = (a * a - b * b).abs() / height.norm().max(a.min(b));
                let pressed = point.impulse.dot(&point.normal).abs();
                let times = pressed * dt * roll / self.shapes.inertias[segment];
                point.seat(side, height + (place - height) / (1.0 + times));
            }
        });
    }
}
