//! Where two segments with elliptic sections come closest.
//!
//! Such a segment is the sum of its axis and of an ellipsoid, which has the section across the axis
//! and ends in half of itself. A plane across the unit normal `n` touches an ellipsoid at the
//! height `h(n)`. With the offset `D(s, t)` from the first axis to the second at the fractions `s`
//! and `t`, the surfaces are apart by `n . D - h1(n) - h2(n)`, where that is greatest over `n`, and
//! that is least over `s` and `t`; it is convex in these. Where they are in each other it is the
//! depth.
//!
//! Between the ends of both axes the normal is across both. At an end of one it is across the
//! other, and is found as that of two ellipses, or of two ellipsoids where the place is an end of
//! both.

use nalgebra::{Matrix2, Matrix3, Matrix3x2, Point3, Vector3};

/// Axes that enclose less than this angle are parallel; its squared sine. Roundings turn the
/// normal across both by `1e-6` rad then, and change the separation by the square of that.
const PARALLEL_AXES: f64 = 1e-20;

/// Distances that differ by less than this part of the lengths that make them are the same.
const LEVEL: f64 = 1e-9;

/// Most steps towards a normal, and most halvings of one.
const MOST_STEPS: usize = 60;

/// Newton's step, rad, after which the error is that of rounding: of the order of the square.
const LAST_STEP: f64 = 1e-8;

/// A segment with an elliptic section.
#[derive(Debug, Clone, Copy)]
pub(super) struct EllipticSegment {
    /// Where the axis starts, m, world.
    pub(super) start: Point3<f64>,
    /// From there to where it ends, m, world.
    pub(super) axis: Vector3<f64>,
    /// The ellipsoid: the sum over its semi-axes of their squares, m^2, along their directions,
    /// world.
    pub(super) shape: Matrix3<f64>,
    /// The least radius of curvature of that, m.
    pub(super) sharpest: f64,
}

/// A place where the surfaces of two segments face each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FacingPlace {
    /// Fractions along both axes, each in 0..=1.
    pub(super) fractions: [f64; 2],
    /// Unit normal of both surfaces, from the first to the second, world.
    pub(super) normal: Vector3<f64>,
}

/// Two segments.
#[derive(Debug, Clone, Copy)]
pub(super) struct SegmentPair(pub(super) [EllipticSegment; 2]);

impl SegmentPair {
    /// Where the surfaces come closest, from where the axes do. Of parallel axes, which are as
    /// close along a way, the fraction along the shorter stays; and so does all where the two are
    /// so deep in each other that no place is the shallowest.
    pub(super) fn closest(&self, axes: &FacingPlace) -> FacingPlace {
        let [first, second] = self.axes().map(|axis| axis.norm());
        let Some(crossing) = self.crossing(&axes.normal) else {
            let shorter = usize::from(second < first);
            return self.proven(shorter, axes.fractions[shorter], axes).unwrap_or(*axes);
        };
        let within = crossing.fractions.map(clamped) == crossing.fractions;
        if within && self.is_shallow(&crossing) {
            return crossing;
        }
        let near = crossing.fractions.map(|part| if part > 0.5 { 1.0 } else { 0.0 });
        let ends = [(0, near[0]), (1, near[1]), (0, 1.0 - near[0]), (1, 1.0 - near[1])];
        let mut best = if within { crossing } else { *axes };
        for (side, end) in ends {
            let Some(place) = self.proven(side, end, axes) else { continue };
            if self.is_shallow(&place) {
                return place;
            }
            if self.separation(&place) > self.separation(&best) {
                best = place;
            }
        }
        best
    }

    /// Where the surfaces come closest that has this fraction along one side, if no other fraction
    /// is closer.
    fn proven(&self, side: usize, fraction: f64, axes: &FacingPlace) -> Option<FacingPlace> {
        let place = self.beside(side, fraction, &axes.normal);
        let parted = self.parted(&place.normal, [[0.0, 1.0]; 2]);
        (parted >= self.separation(&place) - self.level(&place)).then_some(place)
    }

    /// What does not count of distances at a place, m.
    fn level(&self, place: &FacingPlace) -> f64 {
        let lengths: f64 = self.axes().map(|axis| axis.norm()).iter().sum();
        LEVEL * (lengths + self.offset(place.fractions).norm())
    }

    /// Where the surfaces come closest that has this fraction along one side.
    pub(super) fn beside(&self, side: usize, fraction: f64, normal: &Vector3<f64>) -> FacingPlace {
        let other = 1 - side;
        let mut range = [[fraction; 2]; 2];
        range[other] = [0.0, 1.0];
        let [first, end] = [0, 1].map(|i| range.map(|along| along[i]));
        let Some(along) = self.0[other].axis.try_normalize(0.0) else {
            return self.at(first, normal);
        };
        let (own, is_on) = self.across(other, first, &along, normal);
        if self.is_shallow(&own) {
            return if is_on { own } else { self.at(own.fractions, normal) };
        }
        // The axis goes through an ellipse, but its ends may be outside.
        let parted = |place: &FacingPlace| self.parted(&place.normal, range);
        let ends = [first, end].map(|fractions| {
            let place = self.at(fractions, normal);
            let way = self.offset(end) - self.offset(first);
            let fractions = if place.normal.dot(&way) > 0.0 { first } else { end };
            FacingPlace { fractions, ..place }
        });
        ends.into_iter().fold(own, |a, b| if parted(&b) > parted(&a) { b } else { a })
    }

    /// Where two ellipsoids come closest, at these fractions.
    fn at(&self, fractions: [f64; 2], normal: &Vector3<f64>) -> FacingPlace {
        let sum = EllipsoidSum { shapes: self.shapes(), sharpest: self.sharpest() };
        FacingPlace { fractions, normal: sum.outward(&self.offset(fractions), normal) }
    }

    /// Where the surfaces come closest, with the fraction of one side, if the other, which is
    /// `along` a unit vector, went on beyond its ends; and whether that is between these.
    fn across(
        &self,
        other: usize,
        mut fractions: [f64; 2],
        along: &Vector3<f64>,
        normal: &Vector3<f64>,
    ) -> (FacingPlace, bool) {
        let (offset, shapes) = (self.offset(fractions), self.shapes());
        let across = |v: &Vector3<f64>| v - along * along.dot(v);
        let any = || along.cross(&Vector3::ith(along.iamin(), 1.0)).normalize();
        let start = across(normal).try_normalize(f64::EPSILON).unwrap_or_else(any);
        let seen = shapes.map(|shape| seen_along(&shape, along));
        let sum = EllipsoidSum { shapes: seen, sharpest: self.sharpest() };
        let normal = sum.outward(&across(&offset), &start);
        let way = (reach(&shapes, &normal) - offset).dot(along) / self.0[other].axis.norm();
        let way = if other == 1 { way } else { -way };
        fractions[other] = clamped(way);
        (FacingPlace { fractions, normal }, fractions[other] == way)
    }

    /// Distance of the planes that touch the two across a normal, m; negative where they are in
    /// each other.
    pub(super) fn separation(&self, place: &FacingPlace) -> f64 {
        separation(&self.offset(place.fractions), &self.shapes(), &place.normal)
    }

    /// How far planes across a normal that have the two, between these fractions, on either side
    /// are apart, m: what a separation is at least.
    fn parted(&self, normal: &Vector3<f64>, [first, second]: [[f64; 2]; 2]) -> f64 {
        let [one, other] = self.axes().map(|axis| normal.dot(&axis));
        let nearest = second.map(|t| t * other).into_iter().fold(f64::INFINITY, f64::min);
        let farthest = first.map(|s| s * one).into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.separation(&FacingPlace { fractions: [0.0; 2], normal: *normal }) + nearest - farthest
    }

    /// Whether the two are apart at a place, or less deep in each other than any radius of
    /// curvature: where planes touch them at places that face each other there is no shallower one
    /// then.
    fn is_shallow(&self, place: &FacingPlace) -> bool {
        self.separation(place) > -self.sharpest()
    }

    /// Where the surfaces of two that go on beyond their ends face each other, on the side of a
    /// `normal`; `None` if they are parallel.
    fn crossing(&self, normal: &Vector3<f64>) -> Option<FacingPlace> {
        let [first, second] = self.axes();
        let across = first.cross(&second);
        let squared = across.norm_squared();
        let parallel = PARALLEL_AXES * first.norm_squared() * second.norm_squared();
        (squared > parallel).then(|| {
            let side = if across.dot(normal) < 0.0 { -1.0 } else { 1.0 };
            let normal = across * (side / squared.sqrt());
            // From one surface to the other is along the normal.
            let aside = self.offset([0.0; 2]) - reach(&self.shapes(), &normal);
            let fractions = [second, first].map(|other| aside.cross(&other).dot(&across) / squared);
            FacingPlace { fractions, normal }
        })
    }

    /// From the first axis to the second, at fractions along them, m.
    pub(super) fn offset(&self, [s, t]: [f64; 2]) -> Vector3<f64> {
        let [first, second] = &self.0;
        second.start - first.start + t * second.axis - s * first.axis
    }

    /// The least radius of curvature of the sum of the two, m, or less.
    fn sharpest(&self) -> f64 {
        self.0.iter().map(|one| one.sharpest).sum()
    }

    fn axes(&self) -> [Vector3<f64>; 2] {
        self.0.each_ref().map(|segment| segment.axis)
    }

    fn shapes(&self) -> [Matrix3<f64>; 2] {
        self.0.each_ref().map(|segment| segment.shape)
    }
}

/// `x` moved into 0..=1, never the zero below zero: places are ordered by their bits.
fn clamped(x: f64) -> f64 {
    x.clamp(0.0, 1.0) + 0.0
}

/// An ellipsoid that is seen along a direction as another is, and has its longest axis along it.
fn seen_along(shape: &Matrix3<f64>, direction: &Vector3<f64>) -> Matrix3<f64> {
    let far = shape * direction;
    let skew = far * direction.transpose();
    let own = direction * (far.dot(direction) + shape.trace()) * direction.transpose();
    shape - skew - skew.transpose() + own
}

/// From the center of an ellipsoid to where a plane across a unit normal touches it, m.
pub(super) fn touched(shape: &Matrix3<f64>, normal: &Vector3<f64>) -> Vector3<f64> {
    let far = shape * normal;
    // The height is the root of this, and never zero.
    far / far.dot(normal).sqrt()
}

/// The same of the sum of two.
fn reach(shapes: &[Matrix3<f64>; 2], normal: &Vector3<f64>) -> Vector3<f64> {
    touched(&shapes[0], normal) + touched(&shapes[1], normal)
}

/// How far a place is outside of the plane that touches the sum of two ellipsoids, m.
fn separation(place: &Vector3<f64>, shapes: &[Matrix3<f64>; 2], normal: &Vector3<f64>) -> f64 {
    normal.dot(&(place - reach(shapes, normal)))
}

/// The sum of two ellipsoids about the origin.
struct EllipsoidSum {
    shapes: [Matrix3<f64>; 2],
    /// No radius of curvature is less than this, m.
    sharpest: f64,
}

impl EllipsoidSum {
    /// The unit normal across which a place is farthest outside; of a place inside one where it is
    /// less deep than for normals nearby. It is sought from a `start`.
    ///
    /// Only one normal has the place outside or less deep than the least radius of curvature, and
    /// no other place on the surface faces it. Uphill from any that has it so the search finds that
    /// one. Where it does not, it comes from afar, in steps that keep the place so.
    fn outward(&self, place: &Vector3<f64>, start: &Vector3<f64>) -> Vector3<f64> {
        let outside =
            |at: &Vector3<f64>, normal: &Vector3<f64>| separation(at, &self.shapes, normal);
        let better = |a, b| if outside(place, &b) > outside(place, &a) { b } else { a };
        let level = self.level(place).unwrap_or(*start);
        let normal = self.ascend(place, better(*start, level));
        if outside(place, &normal) > -self.sharpest {
            return normal;
        }
        let size = self.shapes.iter().map(|shape| shape.trace().sqrt()).sum::<f64>();
        let mut at = place.try_normalize(0.0).map_or(*place, |way| way * (2.0 * size));
        let mut other = self.ascend(&at, level);
        for _ in 0..MOST_STEPS {
            let way = other.dot(&(at - place));
            let free = 0.9 * (outside(&at, &other) + self.sharpest);
            let part = if way > free { free / way } else { 1.0 };
            at += (place - at) * part;
            other = self.ascend(&at, other);
            if part == 1.0 {
                break;
            }
        }
        better(normal, other)
    }

    /// The normal of an ellipsoid through a place: nearly the one sought of two that are alike.
    fn level(&self, place: &Vector3<f64>) -> Option<Vector3<f64>> {
        let [first, second] = self.shapes;
        (first + second).try_inverse().and_then(|inverse| (inverse * place).try_normalize(0.0))
    }

    /// Newton's method from a normal, which goes uphill only.
    fn ascend(&self, place: &Vector3<f64>, mut normal: Vector3<f64>) -> Vector3<f64> {
        let mut most = separation(place, &self.shapes, &normal);
        let rounding = 4.0 * f64::EPSILON * (place.norm() + most.abs());
        for _ in 0..MOST_STEPS {
            let mut step = uphill(place, &self.shapes, &normal);
            let last = step.norm() < LAST_STEP;
            let mut found = None;
            for _ in 0..MOST_STEPS {
                let trial = (normal + step).normalize();
                let own = separation(place, &self.shapes, &trial);
                if own >= most - rounding {
                    found = Some((trial, own));
                    break;
                }
                step *= 0.5;
            }
            let Some(better) = found else { break };
            (normal, most) = better;
            if last {
                break;
            }
        }
        normal
    }
}

/// Newton's step from a normal towards where a place is farther outside of the sum of two
/// ellipsoids, across the normal.
fn uphill(place: &Vector3<f64>, shapes: &[Matrix3<f64>; 2], normal: &Vector3<f64>) -> Vector3<f64> {
    let away = place - reach(shapes, normal);
    let outside = normal.dot(&away);
    let aside = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let plane = Matrix3x2::from_columns(&[aside, normal.cross(&aside)]);
    // How far the touched places move as the normal turns: the radii of curvature.
    let moves = |shape: &Matrix3<f64>| {
        let far = touched(shape, normal);
        (shape - far * far.transpose()) / far.dot(normal)
    };
    let radii = plane.tr_mul(&((moves(&shapes[0]) + moves(&shapes[1])) * plane));
    let slope = plane.tr_mul(&away);
    let newton = (radii + Matrix2::identity() * outside).cholesky();
    // Deep inside, where the place is beyond a center of curvature, it still goes uphill.
    let step = newton.or_else(|| radii.cholesky()).map(|factors| factors.solve(&slope));
    step.map_or_else(Vector3::zeros, |step| plane * step)
}

#[cfg(test)]
mod tests;
