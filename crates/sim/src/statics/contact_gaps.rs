//! What the rods of a case touch, as gaps.

use super::axis_gap::{AxisGap, may_cross};
use super::chord_boxes::ChordBoxes;
use super::fixed_object::{FixedObject, point, sizes};
use crate::SimError;
use nalgebra::{DMatrix, Point3, Vector3};
use rapunzel_collision::Capsule;
use rapunzel_rod_static::{Gap, GapFunctions, GapTerm};
use rapunzel_scene::case::{Case, CaseRoot};
use std::collections::BTreeMap;

/// Distance, in the sum of two radii, up to which gaps between rods are listed.
const LISTED: f64 = 3.0;
/// Sine of the angle between two segments below which they lie side by side: then stations of one
/// touch the other.
const SIDE_BY_SIDE: f64 = 0.3;
/// Radius of a round object, in segments, from which it is touched by stations.
const ROUND: f64 = 2.0;
/// Arc length along a rod, in its radii, within which it does not touch itself: half a turn.
const OWN: f64 = 7.0;

/// A rod as its contacts see it.
struct TouchingRodGeometry {
    /// Radii at the stations, m.
    radii: Vec<f64>,
    /// Arc lengths of the stations, m.
    lengths: Vec<f64>,
    root: CaseRoot,
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
        let [rod, first, other, part] = gap.between;
        // Two parts of one rod are told by their stations.
        let is_own = |term: &GapTerm| {
            let here = term.station == first || part > 0 && term.station == first + 1;
            term.rod == rod && (rod != other || here)
        };
        let (own, others): (Vec<&GapTerm>, Vec<&GapTerm>) =
            gap.terms.iter().partition(|term| is_own(term));
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
                        let pair =
                            [self.chord(rod, i, nodes), self.chord(other, j, &stations[other])];
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
            let thin = |round: &&Capsule| round.radius < ROUND * spacing;
            let Some(round) = object.round.as_ref().filter(thin) else {
                for (station, at) in nodes.iter().enumerate().skip(first) {
                    gaps.push(self.station_gap([rod, station], i, at));
                }
                continue;
            };
            // A thin one is touched between stations too, where the way to it is shortest.
            let chords: Vec<_> =
                (0..nodes.len() - 1).map(|station| self.chord(rod, station, nodes)).collect();
            let apart: Vec<_> = chords.iter().map(|one| one.closest(round).distance()).collect();
            let crosses: Vec<_> = chords.iter().map(|one| !lie_side_by_side(one, round)).collect();
            let mut met = 0;
            for (station, chord) in chords.iter().enumerate() {
                let nearer = station == 0 || apart[station] < apart[station - 1];
                let nearest = nearer && apart.get(station + 1).is_none_or(|d| apart[station] <= *d);
                if crosses[station] && nearest {
                    let ends = [Some([rod, station]), Some([rod, station + 1]), None, None];
                    // Counted, so that one that slides along the rod stays the same.
                    gaps.push(Self::axis_gap(
                        [rod, met, self.rods.len() + i, 1],
                        [chord, round],
                        &ends,
                    ));
                    met += 1;
                }
            }
            for (station, at) in nodes.iter().enumerate().skip(first) {
                let beside = [station.checked_sub(1), Some(station)].into_iter().flatten();
                if !beside.filter_map(|chord| crosses.get(chord)).any(|crosses| *crosses) {
                    gaps.push(self.station_gap([rod, station], i, at));
                }
            }
        }
    }

    /// The ways between the stations of a rod.
    fn chords(&self, rod: usize, nodes: &[Point3<f64>]) -> Vec<Capsule> {
        (0..nodes.len() - 1).map(|station| self.chord(rod, station, nodes)).collect()
    }

    /// Whether two ways of one rod are so near along it, or so ordered, that they are not looked
    /// at.
    fn is_own(&self, rod: usize, [i, j]: [usize; 2], reach: f64) -> bool {
        let lengths = &self.rods[rod].lengths;
        j <= i + 1 || lengths[j] - lengths[i + 1] < 0.5 * OWN * reach
    }

    /// Gaps between two rods, or far parts of one, with their ways.
    fn rod_gaps(
        &self,
        [rod, other]: [usize; 2],
        [ones, others]: [&[Capsule]; 2],
        pairs: impl Iterator<Item = [usize; 2]>,
        gaps: &mut Vec<Gap>,
    ) {
        let own = rod == other;
        // Of each station of the first rod the nearest way beside it; and how far ways are apart.
        let mut beside: Vec<Option<(f64, usize)>> = vec![None; ones.len() + 1];
        let mut apart = BTreeMap::new();
        let mut crossing = Vec::new();
        for [i, j] in pairs {
            let (one, two) = (&ones[i], &others[j]);
            let reach = one.radius + two.radius;
            if own && self.is_own(rod, [i, j], reach) {
                continue;
            }
            let distance = one.closest(two).distance();
            if distance > LISTED * reach {
                continue;
            }
            apart.insert([i, j], distance);
            if !lie_side_by_side(one, two) {
                crossing.push([i, j]);
                continue;
            }
            for (station, at) in [(i, &one.start), (i + 1, &one.end)] {
                let distance = point(at).closest(two).distance();
                if beside[station].is_none_or(|(least, _)| distance < least) {
                    beside[station] = Some((distance, j));
                }
            }
        }
        crossing.sort_unstable();
        // Ways that cross touch where they are nearer than the ways before and behind them: so
        // there is one contact at a kink, and what is known of it does not jump.
        let mut met = 0;
        for [i, j] in crossing {
            let near = apart[&[i, j]];
            let mut around = (i.saturating_sub(1)..(i + 2).min(ones.len())).flat_map(|k| {
                (j.saturating_sub(1)..(j + 2).min(others.len())).map(move |l| [k, l])
            });
            let nearest = around.all(|[k, l]| {
                let other = apart.get(&[k, l]).copied().unwrap_or(f64::INFINITY);
                // Of equal ones the first counts.
                [k, l] == [i, j] || near < other || near == other && [i, j] < [k, l]
            });
            if nearest {
                let ends = [[rod, i], [rod, i + 1], [other, j], [other, j + 1]].map(Some);
                // Counted between two rods, so that one that slides stays the same.
                let first = if own { i } else { met };
                gaps.push(Self::axis_gap(
                    [rod, first, other, 1 + if own { j } else { 0 }],
                    [&ones[i], &others[j]],
                    &ends,
                ));
                met += 1;
            }
        }
        for (station, near) in beside.iter().enumerate() {
            let Some((_, j)) = near else { continue };
            let mut point =
                point(if station == 0 { &ones[0].start } else { &ones[station - 1].end });
            point.radius = self.rods[rod].radii[station];
            let ends = [Some([rod, station]), None, Some([other, *j]), Some([other, *j + 1])];
            gaps.push(Self::axis_gap([rod, station, other, 0], [&point, &others[*j]], &ends));
        }
    }
}

/// Whether two axes go the same way, or opposite ways; not if one of them is a point.
fn lie_side_by_side(one: &Capsule, two: &Capsule) -> bool {
    let [first, second] = [one, two].map(|capsule| capsule.end - capsule.start);
    let product = first.norm() * second.norm();
    product > 0.0 && first.cross(&second).norm() < SIDE_BY_SIDE * product
}

impl GapFunctions for CaseGaps {
    fn gaps(&self, positions: &[Vec<Point3<f64>>]) -> Vec<Gap> {
        let mut gaps = Vec::new();
        let rods = || positions.iter().enumerate();
        let chords: Vec<_> = rods().map(|(rod, nodes)| self.chords(rod, nodes)).collect();
        let boxes: Vec<_> = chords.iter().map(|chords| ChordBoxes::of(chords)).collect();
        for (rod, nodes) in rods() {
            self.object_gaps(rod, nodes, &mut gaps);
            for other in rod..positions.len() {
                let pairs = boxes[rod].pairs(&boxes[other], LISTED);
                self.rod_gaps([rod, other], [&chords[rod], &chords[other]], pairs, &mut gaps);
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
        let [before, behind] = [from, to].map(|positions| -> Vec<Vec<Capsule>> {
            let rods = positions.iter().enumerate();
            rods.map(|(rod, nodes)| self.chords(rod, nodes)).collect()
        });
        let ways = before.iter().zip(&behind);
        let boxes: Vec<_> = ways.map(|(from, to)| ChordBoxes::swept(from, to)).collect();
        for (rod, nodes) in from.iter().enumerate() {
            for (before, behind) in before[rod].iter().zip(&behind[rod]) {
                let round = self.objects.iter().filter_map(|object| object.round.as_ref());
                for round in round.filter(|round| near(before, round, 1.0)) {
                    if may_cross([before, round], [behind, round]) {
                        return true;
                    }
                }
            }
            for other in rod..from.len() {
                let crosses = |[i, j]: [usize; 2]| {
                    let [start, end] = [&before, &behind].map(|all| [&all[rod][i], &all[other][j]]);
                    let reach = start[0].radius + start[1].radius;
                    let own = rod == other && self.is_own(rod, [i, j], reach);
                    !own && near(start[0], start[1], 2.0) && may_cross(start, end)
                };
                if boxes[rod].pairs(&boxes[other], 0.0).any(crosses) {
                    return true;
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
