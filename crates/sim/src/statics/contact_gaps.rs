//! What the rods of a case touch, as gaps.

use super::axis_gap::{AxisGap, may_cross};
use crate::SimError;
use crate::objects::{Sizes, build_object};
use nalgebra::{DMatrix, Isometry3, Matrix3, Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_collision::field::Soup;
use rapunzel_coupling::{Field, extents};
use rapunzel_export::surface::Placed;
use rapunzel_rod_static::{Gap, GapFunctions, GapTerm};
use rapunzel_scene::case::{Case, CaseRoot};
use rapunzel_scene::{Object, ObjectShape};

/// Distance, in the sum of two radii, up to which gaps between rods are listed.
const LISTED: f64 = 3.0;
/// Sine of the angle between two segments below which they lie side by side: then stations of one
/// touch the other.
const SIDE_BY_SIDE: f64 = 0.3;
/// Radius of a round object, in segments, from which it is touched by stations.
const ROUND: f64 = 2.0;
/// Arc length along a rod, in its radii, within which it does not touch itself: half a turn.
const OWN: f64 = 7.0;
/// Part of its extent by which nothing may pass through an object on one step.
const PIERCED: f64 = 0.25;
/// Step of differences of a field's gradient, in the radius of the rod.
const FIELD_STEP: f64 = 1e-3;

/// A rod as its contacts see it.
struct TouchingRodGeometry {
    /// Radii at the stations, m.
    radii: Vec<f64>,
    /// Arc lengths of the stations, m.
    lengths: Vec<f64>,
    root: CaseRoot,
}

/// An object as rods see it.
struct FixedObject {
    field: Field,
    pose: Isometry3<f64>,
    /// Axis and radius of a round one, world frame.
    round: Option<Capsule>,
    /// Whether its field is that of a plane.
    flat: bool,
    /// Its smallest extent, m; infinite for the ground.
    extent: f64,
}

/// All gaps of a case.
pub(super) struct CaseGaps {
    rods: Vec<TouchingRodGeometry>,
    objects: Vec<FixedObject>,
}

impl CaseGaps {
    /// The gaps of the rods of a case, each cut into so many segments.
    pub(super) fn new(case: &Case, alone: &[Case], segments: usize) -> Result<Self, SimError> {
        let rod = |rod: &Case| {
            let matter = rod.matter();
            let part = |station: usize| match station {
                0 => 0.0,
                s if s > segments => 1.0,
                s => (s as f64 - 0.5) / segments as f64,
            };
            let parts = (0..segments + 2).map(part);
            TouchingRodGeometry {
                radii: parts
                    .clone()
                    .map(|part| matter.at(part).section.equivalent_radius())
                    .collect(),
                lengths: parts.map(|part| part * rod.length).collect(),
                root: rod.root,
            }
        };
        let rods: Vec<_> = alone.iter().map(rod).collect();
        let sizes = sizes(alone);
        let objects = case.objects.iter().enumerate();
        let objects = objects.map(|(i, object)| FixedObject::new(object, i, &sizes));
        Ok(Self { rods, objects: objects.collect::<Result<_, _>>()? })
    }

    /// Arc length of a place between stations of a rod, by the parts that they have in it, m.
    pub(super) fn arc_length(&self, rod: usize, parts: &[(usize, f64)]) -> f64 {
        parts.iter().map(|(station, part)| part * self.rods[rod].lengths[*station]).sum()
    }

    /// Radius of a rod at such a place, m.
    pub(super) fn radius(&self, rod: usize, parts: &[(usize, f64)]) -> f64 {
        parts.iter().map(|(station, part)| part * self.rods[rod].radii[*station]).sum()
    }

    /// The direction in which a gap pushes its rod, and where it pushes: the stations of the rod
    /// with their parts in the place, and those of the other rod.
    pub(super) fn sides(&self, gap: &Gap) -> (Vector3<f64>, [Vec<(usize, f64)>; 2]) {
        let [rod, first, _, part] = gap.between;
        let is_station = part == 0;
        let is_own = |term: &GapTerm| {
            term.rod == rod
                && (term.station == first || !is_station && term.station == first + 1)
        };
        let (own, others): (Vec<&GapTerm>, Vec<&GapTerm>) = gap.terms.iter().partition(|term| is_own(term));
        let normal: Vector3<f64> = own.iter().map(|term| term.derivative).sum();
        let parts = |terms: Vec<&GapTerm>| {
            terms.iter().map(|t| (t.station, t.derivative.dot(&normal).abs())).collect()
        };
        (normal, [parts(own), parts(others)])
    }

    /// Number of the rods: what is beyond is an object.
    pub(super) fn rod_count(&self) -> usize {
        self.rods.len()
    }

    /// Where the axis of a rod starts within an object, or nearer to that of another rod than half
    /// of the distance at which they touch: the rod, what it is in, and the place.
    pub(super) fn first_overlap(
        &self,
        stations: &[Vec<Point3<f64>>],
    ) -> Option<(usize, usize, Point3<f64>)> {
        for (rod, nodes) in stations.iter().enumerate() {
            for (i, object) in self.objects.iter().enumerate() {
                let held = usize::from(self.rods[rod].root != CaseRoot::Free);
                let inside = |(station, at): &(usize, &Point3<f64>)| {
                    // Out of the ground there is one way, but not for a root that is held.
                    let asked = object.extent.is_finite() || *station < held;
                    asked && object.field.value(&object.pose.inverse_transform_point(at)) < 0.0
                };
                if let Some((_, at)) = nodes.iter().enumerate().find(inside) {
                    return Some((rod, self.rods.len() + i, *at));
                }
            }
            for other in rod + 1..stations.len() {
                for i in 0..nodes.len() - 1 {
                    for j in 0..stations[other].len() - 1 {
                        let pair = [self.chord(rod, i, nodes), self.chord(other, j, &stations[other])];
                        let apart = pair[0].closest(&pair[1]).distance();
                        if apart < 0.5 * (pair[0].radius + pair[1].radius) {
                            return Some((rod, other, pair[0].start));
                        }
                    }
                }
            }
        }
        None
    }

    /// The way between two stations as a capsule.
    fn chord(&self, rod: usize, station: usize, nodes: &[Point3<f64>]) -> Capsule {
        let radii = &self.rods[rod].radii;
        let radius = radii[station].max(radii[station + 1]);
        Capsule { start: nodes[station], end: nodes[station + 1], radius }
    }

    /// The gap between a station and an object.
    fn station_gap(&self, [rod, station]: [usize; 2], object: usize, at: &Point3<f64>) -> Gap {
        let thing = &self.objects[object];
        let radius = self.rods[rod].radii[station];
        let (value, derivative, curvature) = thing.distance(at, radius);
        Gap {
            between: [rod, station, self.rods.len() + object, 0],
            value: value - radius,
            terms: vec![GapTerm { rod, station, derivative }],
            curvature: DMatrix::from_column_slice(3, 3, curvature.as_slice()),
        }
    }

    /// The gap between the ways between two stations of rods, or to the axis of a round object.
    fn axis_gap(
        between: [usize; 4],
        [first, second]: [&Capsule; 2],
        stations: &[Option<[usize; 2]>; 4],
    ) -> Gap {
        let gap = AxisGap::of(first, second);
        let used: Vec<(usize, [usize; 2])> = stations
            .iter()
            .enumerate()
            .filter(|(i, _)| gap.depends[*i])
            .filter_map(|(i, station)| Some((i, (*station)?)))
            .collect();
        let terms = used.iter().map(|&(i, [rod, station])| {
            let derivative = gap.derivatives.fixed_rows::<3>(3 * i).into_owned();
            GapTerm { rod, station, derivative }
        });
        let curvature = DMatrix::from_fn(3 * used.len(), 3 * used.len(), |row, column| {
            let at = |index: usize| 3 * used[index / 3].0 + index % 3;
            gap.curvature[(at(row), at(column))]
        });
        let value = gap.distance - first.radius - second.radius;
        Gap { between, value, terms: terms.collect(), curvature }
    }

    fn object_gaps(&self, rod: usize, nodes: &[Point3<f64>], gaps: &mut Vec<Gap>) {
        // A root that is held stays where it is.
        let first = usize::from(self.rods[rod].root != CaseRoot::Free);
        let spacing = nodes.windows(2).map(|ends| (ends[1] - ends[0]).norm()).fold(0.0, f64::max);
        for (i, object) in self.objects.iter().enumerate() {
            for (station, at) in nodes.iter().enumerate().skip(first) {
                gaps.push(self.station_gap([rod, station], i, at));
            }
            let thin = |round: &&Capsule| round.radius < ROUND * spacing;
            let Some(round) = object.round.as_ref().filter(thin) else { continue };
            for station in 0..nodes.len() - 1 {
                let chord = self.chord(rod, station, nodes);
                let closest = chord.closest(round).fractions[0];
                if closest > 0.0 && closest < 1.0 {
                    let ends = [Some([rod, station]), Some([rod, station + 1]), None, None];
                    let between = [rod, station, self.rods.len() + i, 1];
                    gaps.push(Self::axis_gap(between, [&chord, round], &ends));
                }
            }
        }
    }

    /// Gaps between two rods, or far parts of one.
    fn rod_gaps(&self, [rod, other]: [usize; 2], nodes: &[Vec<Point3<f64>>], gaps: &mut Vec<Gap>) {
        let own = rod == other;
        let chords = |rod: usize| -> Vec<Capsule> {
            (0..nodes[rod].len() - 1).map(|i| self.chord(rod, i, &nodes[rod])).collect()
        };
        let (ones, others) = (chords(rod), chords(other));
        // Of each station of the first rod the nearest way beside it.
        let mut beside: Vec<Option<(f64, usize)>> = vec![None; nodes[rod].len()];
        for (i, one) in ones.iter().enumerate() {
            for (j, two) in others.iter().enumerate() {
                let reach = one.radius + two.radius;
                let lengths = &self.rods[rod].lengths;
                if own && (j <= i + 1 || lengths[j] - lengths[i + 1] < 0.5 * OWN * reach) {
                    continue;
                }
                let lengths = [one, two].map(|chord| (chord.end - chord.start).norm());
                let middles = nalgebra::center(&one.start, &one.end)
                    - nalgebra::center(&two.start, &two.end);
                if middles.norm() > LISTED * reach + 0.5 * (lengths[0] + lengths[1]) {
                    continue;
                }
                let closest = one.closest(two);
                let distance = closest.distance();
                if distance > LISTED * reach {
                    continue;
                }
                let sine = (one.end - one.start).cross(&(two.end - two.start)).norm();
                if sine < SIDE_BY_SIDE * lengths[0] * lengths[1] {
                    for station in [i, i + 1] {
                        let point = point(&nodes[rod][station]);
                        let distance = point.closest(two).distance();
                        if beside[station].is_none_or(|(least, _)| distance < least) {
                            beside[station] = Some((distance, j));
                        }
                    }
                    continue;
                }
                // What comes closest at the end of a way does so at the start of the next.
                let repeated = |part: f64, i: usize, count: usize| part >= 1.0 && i + 1 < count;
                let [s, t] = closest.fractions;
                if repeated(s, i, ones.len()) || repeated(t, j, others.len()) {
                    continue;
                }
                let ends = [[rod, i], [rod, i + 1], [other, j], [other, j + 1]].map(Some);
                gaps.push(Self::axis_gap([rod, i, other, j + 1], [one, two], &ends));
            }
        }
        for (station, near) in beside.iter().enumerate() {
            let Some((_, j)) = near else { continue };
            let mut point = point(&nodes[rod][station]);
            point.radius = self.rods[rod].radii[station];
            let ends = [Some([rod, station]), None, Some([other, *j]), Some([other, *j + 1])];
            gaps.push(Self::axis_gap([rod, station, other, 0], [&point, &others[*j]], &ends));
        }
    }
}

/// The lengths of rods, for what they touch.
fn sizes(alone: &[Case]) -> Sizes {
    Sizes {
        longest: alone.iter().map(|rod| rod.length).fold(0.0, f64::max),
        thickest: alone.iter().map(|rod| rod.matter().thickest()).fold(0.0, f64::max),
        roundest: None,
    }
}

/// The surfaces of the objects of a case, for its picture.
pub(super) fn surfaces(case: &Case) -> Result<Vec<Placed>, SimError> {
    let sizes = sizes(&case.alone());
    let placed = case.objects.iter().enumerate().map(|(i, object)| {
        let built = build_object(object, i, &sizes)?;
        let (pose, Soup { vertices, triangles }) = (built.pose(0.0), built.surface());
        let vertices = vertices.iter().map(|at| pose * at).collect();
        Ok(Placed { pose, surface: Soup { vertices, triangles: triangles.clone() } })
    });
    placed.collect()
}

fn point(at: &Point3<f64>) -> Capsule {
    Capsule { start: *at, end: *at, radius: 0.0 }
}

impl GapFunctions for CaseGaps {
    fn gaps(&self, positions: &[Vec<Point3<f64>>]) -> Vec<Gap> {
        let mut gaps = Vec::new();
        for (rod, nodes) in positions.iter().enumerate() {
            self.object_gaps(rod, nodes, &mut gaps);
            for other in rod..positions.len() {
                self.rod_gaps([rod, other], positions, &mut gaps);
            }
        }
        // Held roots, which nothing moves.
        let held = |term: &GapTerm| term.station == 0 && self.rods[term.rod].root != CaseRoot::Free;
        gaps.retain(|gap| !gap.terms.iter().all(held));
        gaps
    }

    fn is_crossed(&self, from: &[Vec<Point3<f64>>], to: &[Vec<Point3<f64>>]) -> bool {
        let farthest = from.iter().zip(to).flat_map(|(from, to)| from.iter().zip(to));
        let farthest = farthest.map(|(from, to)| (to - from).norm()).fold(0.0, f64::max);
        let near = |one: &Capsule, two: &Capsule, ways: f64| {
            let lengths = [one, two].map(|chord| (chord.end - chord.start).norm());
            let middles =
                nalgebra::center(&one.start, &one.end) - nalgebra::center(&two.start, &two.end);
            middles.norm() <= ways * farthest + 0.5 * (lengths[0] + lengths[1])
        };
        for (rod, nodes) in from.iter().enumerate() {
            for i in 0..nodes.len() - 1 {
                let [before, behind] = [nodes, &to[rod]].map(|nodes| self.chord(rod, i, nodes));
                let round = self.objects.iter().filter_map(|object| object.round.as_ref());
                for round in round.filter(|round| near(&before, round, 1.0)) {
                    if may_cross([&before, round], [&behind, round]) {
                        return true;
                    }
                }
                for other in rod + 1..from.len() {
                    for j in 0..from[other].len() - 1 {
                        let [start, end] =
                            [&from[other], &to[other]].map(|nodes| self.chord(other, j, nodes));
                        if near(&before, &start, 2.0)
                            && may_cross([&before, &start], [&behind, &end])
                        {
                            return true;
                        }
                    }
                }
            }
            for object in self.objects.iter().filter(|object| object.is_pierceable()) {
                let ways = nodes.iter().zip(&to[rod]);
                if ways.skip(1).any(|(from, to)| object.is_pierced(from, to)) {
                    return true;
                }
            }
        }
        false
    }

    fn thinnest(&self) -> f64 {
        let radii = self.rods.iter().flat_map(|rod| rod.radii.iter().copied());
        let radii = radii.filter(|_| self.rods.len() > 1);
        let extents = self.objects.iter().map(|object| 0.5 * object.extent);
        radii.chain(extents).fold(f64::INFINITY, f64::min)
    }
}

impl FixedObject {
    fn new(object: &Object, index: usize, sizes: &Sizes) -> Result<Self, SimError> {
        let built = build_object(object, index, sizes)?;
        let pose = built.pose(0.0);
        let round = match object.shape {
            ObjectShape::Ball { radius } => Some((0.0, radius)),
            ObjectShape::Capsule { length, radius } => Some((length, radius)),
            _ => None,
        };
        let round = round.map(|(length, radius)| {
            let end = Point3::new(0.0, 0.0, 0.5 * length);
            Capsule { start: pose * -end, end: pose * end, radius }
        });
        let endless = object.shape.is_endless();
        let sides = extents(built.surface()).map(|[low, high]| high - low);
        let extent = sides.into_iter().fold(f64::INFINITY, f64::min);
        Ok(Self {
            field: built.field().clone(),
            pose,
            round,
            flat: matches!(object.shape, ObjectShape::Plane { .. }),
            extent: if endless { f64::INFINITY } else { extent },
        })
    }

    /// Distance of a point from the surface, m, with its gradient and second derivatives, 1/m.
    fn distance(&self, at: &Point3<f64>, radius: f64) -> (f64, Vector3<f64>, Matrix3<f64>) {
        if let Some(round) = &self.round {
            let gap = AxisGap::of(&point(at), round);
            let derivative = gap.derivatives.fixed_rows::<3>(0).into_owned();
            let curvature = gap.curvature.fixed_view::<3, 3>(0, 0).into_owned();
            return (gap.distance - round.radius, derivative, curvature);
        }
        let own = self.pose.inverse_transform_point(at);
        let sample = self.field.sample(&own);
        let mut curvature = Matrix3::zeros();
        if !self.flat && sample.value < 2.0 * radius {
            let step = FIELD_STEP * radius;
            for k in 0..3 {
                let by = Vector3::ith(k, step);
                let [low, high] = [own - by, own + by].map(|at| self.field.sample(&at).gradient);
                curvature.set_column(k, &((high - low) / (2.0 * step)));
            }
            curvature = 0.5 * (curvature + curvature.transpose());
        }
        let turn = self.pose.rotation.to_rotation_matrix();
        let curvature = turn.matrix() * curvature * turn.matrix().transpose();
        (sample.value, self.pose * sample.gradient, curvature)
    }

    /// Whether it has an other side, and no axis.
    fn is_pierceable(&self) -> bool {
        self.extent.is_finite() && self.round.is_none()
    }

    /// Whether a point that moves straight goes deep into it.
    fn is_pierced(&self, from: &Point3<f64>, to: &Point3<f64>) -> bool {
        let deep = -PIERCED * self.extent;
        let parts = ((to - from).norm() / (PIERCED * self.extent)).ceil().clamp(1.0, 1000.0);
        let mut part = 1.0;
        while part <= parts {
            let at = from + (to - from) * (part / parts);
            if self.field.value(&self.pose.inverse_transform_point(&at)) < deep {
                return true;
            }
            part += 1.0;
        }
        false
    }
}
