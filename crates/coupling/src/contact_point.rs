use crate::body_ref::BodyRef;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// By this, rad, a normal along a fibre is tilted.
const TILT: f64 = 1e-9;

/// Gaps of surfaces that touch are at most this, in levers.
const TOUCHING: f64 = 0.2;

/// Cosine of the angle from which on two normals of fibres face each other: about a bend both of
/// two at right angles may be needed. A corner of an object has but one at a time.
const FACING: f64 = -0.5;

/// A place where two things touch, or nearly do, at the end of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPoint {
    /// The first is a fibre or an object that moves freely, the second may be anything: a pair is
    /// always named in the same order.
    pub(crate) sides: [BodyRef; 2],
    /// Segments within the fibres; 0 of an object that a fibre touches, and between objects the
    /// edge of the one and 0 of the other.
    pub(crate) segments: [u32; 2],
    /// Fractions along the segments or edges.
    pub(crate) fractions: [f64; 2],
    /// Unit normal from the second side to the first, world.
    pub(crate) normal: Vector3<f64>,
    /// What there is to know of each side, world. Of a fibre its axis from root to tip, not of unit
    /// length. Of an object that moves freely it is the lever from its center of mass to where the
    /// impulse acts, m: on the surface of a fibre, in the middle of the gap between objects. Of one
    /// that is kinematic the mean velocity over the step, m/s, of what of it is on the axis of the
    /// fibre, or where the impulse acts on an object.
    pub(crate) arms: [Vector3<f64>; 2],
    /// From the axes of fibres to where they touch, m, world; zero of an object.
    pub(crate) offsets: [Vector3<f64>; 2],
    /// Mean angular velocity over the step of a kinematic object that a fibre touches, rad/s.
    pub(crate) spin: Vector3<f64>,
    /// Distance of the surfaces at the end of the step, m.
    pub(crate) gap: f64,
    /// Impulse on the first side, N s, world.
    pub(crate) impulse: Vector3<f64>,
    /// How far the first side has slipped, against the law, from where it stuck, m, world.
    pub(crate) drift: Vector3<f64>,
    /// How far from there the first side is pressed, across the normal, by rolling resistance, m,
    /// world.
    pub(crate) lean: Vector3<f64>,
    /// Whether it has not slid in the last step.
    pub(crate) rests: bool,
    /// Whether it has borne something, or would have closed, in this step.
    pub(crate) working: bool,
    /// Whether a bond holds it together.
    pub(crate) bonded: bool,
    /// Whether the second side is a kinematic object.
    pub(crate) kinematic: bool,
}

/// The impulse of a contact on its two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactImpulse {
    /// The two bodies, as in a [`ContactPoint`].
    pub(crate) sides: [BodyRef; 2],
    pub(crate) segments: [u32; 2],
    pub(crate) fractions: [f64; 2],
    /// Levers, m, from the centers of mass of free objects and the axes of fibres to where the
    /// impulse acts; zero for kinematic objects.
    pub(crate) levers: [Vector3<f64>; 2],
    /// Impulse on the first side, N s, world; of a couple the moment of an impulse, N m s.
    pub(crate) impulse: Vector3<f64>,
    /// Whether it turns segments of fibres without pushing them.
    pub(crate) couple: bool,
}

/// A place along two fibres, in segments.
fn along(segments: [u32; 2], fractions: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| f64::from(segments[i]) + fractions[i])
}

impl ContactImpulse {
    /// Place along both sides, in segments.
    pub(crate) fn at(&self) -> [f64; 2] {
        along(self.segments, self.fractions)
    }
}

impl ContactPoint {
    /// A contact point that has borne nothing: what a new one is but for its place.
    pub(crate) const IDLE: Self = Self {
        sides: [BodyRef::Fiber(0); 2],
        segments: [0; 2],
        fractions: [0.0; 2],
        normal: Vector3::new(1.0, 0.0, 0.0),
        arms: [Vector3::new(0.0, 0.0, 0.0); 2],
        offsets: [Vector3::new(0.0, 0.0, 0.0); 2],
        spin: Vector3::new(0.0, 0.0, 0.0),
        gap: 0.0,
        impulse: Vector3::new(0.0, 0.0, 0.0),
        drift: Vector3::new(0.0, 0.0, 0.0),
        lean: Vector3::new(0.0, 0.0, 0.0),
        rests: false,
        working: false,
        bonded: false,
        kinematic: false,
    };

    /// What it does with an impulse on the first side, N s, world.
    pub(crate) fn push(&self, impulse: Vector3<f64>) -> ContactImpulse {
        let Self { sides, segments, fractions, .. } = *self;
        let levers = [0, 1].map(|side| self.lever(side));
        ContactImpulse { sides, segments, fractions, levers, impulse, couple: false }
    }

    /// Whether a side is an object that moves freely.
    fn is_free(&self, side: usize) -> bool {
        self.sides[side].is_object() && self.moves(side)
    }

    /// Whether a side is a fibre or an object that moves freely.
    pub(crate) fn moves(&self, side: usize) -> bool {
        !(self.kinematic && side == 1)
    }

    /// Whether any side is an object that moves freely.
    pub(crate) fn has_free(&self) -> bool {
        self.is_free(0) || self.is_free(1)
    }

    /// The axis of a side, from root to tip, not of unit length; zero for an object.
    fn axis(&self, side: usize) -> Vector3<f64> {
        if self.sides[side].is_object() { Vector3::zeros() } else { self.arms[side] }
    }

    /// From the center of mass of a side that is an object which moves freely, or from the axis of
    /// a fibre, to where the impulse acts, m; zero for a kinematic object.
    pub(crate) fn lever(&self, side: usize) -> Vector3<f64> {
        if self.is_free(side) {
            return self.arms[side] + self.lean;
        }
        if self.sides[side].is_object() { Vector3::zeros() } else { self.offsets[side] + self.lean }
    }

    /// Lets the impulse act on the axis of every side that is a fibre where it is not in the part
    /// of that whose surface turns, in segments by fibre; and there on what it touches.
    pub(crate) fn act_on_axis_outside(&mut self, turning: &[Range<f64>]) {
        for side in 0..2 {
            let BodyRef::Fiber(fiber) = self.sides[side] else { continue };
            if turning[fiber as usize].contains(&self.at()[side]) {
                continue;
            }
            self.lean = Vector3::zeros();
            self.seat(side, Vector3::zeros());
        }
    }

    /// Lets the impulse act at another place of a side that is a fibre, m from its axis, world; and
    /// there on what it touches.
    pub(crate) fn seat(&mut self, side: usize, place: Vector3<f64>) {
        let other = 1 - side;
        if self.is_free(other) {
            self.arms[other] += place - self.offsets[side];
        }
        self.offsets[side] = place;
    }

    /// How fast it has drifted in a step of `dt` seconds, m/s, world, if that is to be undone:
    /// where it is more than half of a `slip`, m/s. What is less is let be, and adds up.
    pub(crate) fn undone(&self, dt: f64, slip: f64) -> Vector3<f64> {
        let velocity = self.drift / dt;
        if velocity.norm() > 0.5 * slip { velocity } else { Vector3::zeros() }
    }

    /// Mean velocity over the step, m/s, of the second side where the impulse acts on the first, if
    /// that is kinematic, else zero: what turns as one body does not slip, however deep it is.
    pub(crate) fn drive(&self) -> Vector3<f64> {
        let drive = || self.arms[1] + self.spin.cross(&self.lever(0));
        if self.kinematic { drive() } else { Vector3::zeros() }
    }

    /// Lets the impulse of two fibres that touch act at one place, in the middle of their gap; what
    /// is not yet there keeps the levers that it will have.
    pub(crate) fn meet(&mut self) {
        if !self.sides.iter().any(BodyRef::is_object) {
            let touching = TOUCHING * self.offsets[0].norm().min(self.offsets[1].norm());
            let half = 0.5 * self.gap.clamp(-touching, touching) * self.normal;
            self.offsets[0] -= half;
            self.offsets[1] += half;
        }
    }

    /// Where it is along both sides, in segments.
    pub(crate) fn at(&self) -> [f64; 2] {
        along(self.segments, self.fractions)
    }

    /// How far it is from another place of its pair along either side, at most, in segments.
    pub(crate) fn apart(&self, [u, v]: [f64; 2]) -> f64 {
        let [s, t] = self.at();
        (s - u).abs().max((t - v).abs())
    }

    /// The segment of the first side if that is a fibre.
    pub(crate) fn segment(&self) -> Option<usize> {
        matches!(self.sides[0], BodyRef::Fiber(_)).then_some(self.segments[0] as usize)
    }

    /// Angle from the first side's axis to the second's about the normal, rad.
    pub(crate) fn turn(&self) -> f64 {
        let [axis, other] = [0, 1].map(|side| self.axis(side));
        other.dot(&self.normal.cross(&axis)).atan2(other.dot(&axis))
    }

    /// Normal, along the first side from root to tip, across it; without an axis any two directions
    /// across the normal.
    pub(crate) fn frame(&self) -> Matrix3<f64> {
        let (normal, axis) = (&self.normal, self.axis(0));
        let along = axis - normal * normal.dot(&axis);
        let end_on = || {
            let aside = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
            // A straight fibre pressed exactly end-on buckles to a side only if it is pushed to
            // one.
            let tilt = if axis == Vector3::zeros() { 0.0 } else { TILT };
            ((normal + tilt * aside).normalize(), aside)
        };
        let oblique = along.try_normalize(1e-6 * axis.norm()).map(|along| (*normal, along));
        let (normal, along) = oblique.unwrap_or_else(end_on);
        // Once more, for what rounding left along the normal.
        let along = (along - normal * normal.dot(&along)).normalize();
        Matrix3::from_columns(&[normal, along, normal.cross(&along)])
    }

    pub(crate) fn rank(&self) -> ContactKey {
        ContactKey::new(self.sides, self.segments, self.fractions)
    }

    /// Whether two are of one pair, and not far from each other.
    pub(crate) fn near(&self, other: &Self) -> bool {
        self.sides == other.sides && self.apart(other.at()) < 0.1
    }

    /// Whether two contact points of one pair lie beside each other with normals that face each
    /// other.
    pub(crate) fn opposes(&self, other: &Self) -> bool {
        let facing = if self.sides.iter().any(BodyRef::is_object) { 0.0 } else { FACING };
        self.apart(other.at()) < 1.0 && self.normal.dot(&other.normal) < facing
    }
}

/// Places that are nearer to each other along both sides, in segments, are one: named by two
/// segments that share a node, or two nodes that face each other where fibres were laid side by
/// side.
const SAME_PLACE: f64 = 1e-4;

/// From this number on, sides are objects.
const OBJECTS: u32 = 1 << 31;

/// By pair, then by place, then by segments: of two that name one node the same comes first
/// whatever the order in which they were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ContactKey {
    /// Fibres before objects.
    sides: [u32; 2],
    /// In segments; places are not negative, so that their bits are in order.
    at: [u64; 2],
    segments: [u32; 2],
}

impl ContactKey {
    pub(crate) fn new(sides: [BodyRef; 2], segments: [u32; 2], fractions: [f64; 2]) -> Self {
        let at = along(segments, fractions).map(f64::to_bits);
        let sides = sides.map(|side| match side {
            BodyRef::Fiber(fiber) => fiber,
            BodyRef::Object(object) => OBJECTS + object,
        });
        Self { sides, at, segments }
    }

    /// Whether two are the same place.
    pub(crate) fn same(&self, other: &Self) -> bool {
        self.sides == other.sides && same_place(self.at, other.at)
    }
}

/// Whether two are the same place of a pair, in the bits of segments along both.
pub(crate) fn same_place(a: [u64; 2], b: [u64; 2]) -> bool {
    let near = |i: usize| (f64::from_bits(a[i]) - f64::from_bits(b[i])).abs() < SAME_PLACE;
    near(0) && near(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Two fibres that touch, a little deep or not yet, are pushed at one place, so that their
        /// impulses have no moment together.
        #[test]
        fn fibers_meet_at_one_place(
            radii in (1e-5..1e-2_f64, 1e-5..1e-2_f64),
            depth in -1.0..1.0_f64,
            along in prop::array::uniform3(-1.0..1.0_f64),
        ) {
            let normal = (Vector3::from(along) + Vector3::z() * 2.0).normalize();
            let gap = depth * TOUCHING * radii.0.min(radii.1);
            let mut point = ContactPoint {
                sides: [BodyRef::Fiber(0), BodyRef::Fiber(1)],
                normal,
                offsets: [-radii.0 * normal, radii.1 * normal],
                gap,
                ..ContactPoint::IDLE
            };
            point.meet();
            // From the axis of the second to that of the first, by the one way and the other.
            let apart = (radii.0 + radii.1 + gap) * normal;
            let met = point.lever(1) - point.lever(0);
            prop_assert!((met - apart).norm() < 1e-15 * (1.0 + apart.norm()));
        }
    }
}
