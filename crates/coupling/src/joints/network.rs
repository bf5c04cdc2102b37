//! Joints as unknowns of one system of equations.

use super::junction::{Junction, JunctionAction};
use super::node_joint::{Connection, FiberPlace, NodeJoint};
use crate::{CouplingError, Fibers};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rapunzel_linalg::{LinalgError, SparseSystem};
use rapunzel_rod_dynamic::{LoadPlace, LoadPoint, StaggeredBatch};

/// Largest number of unknowns of joints that are solved without regard to zeros.
const DENSE: usize = 120;
/// Largest residual of a solution in parts of the sizes that it is made of.
const LARGEST_RESIDUAL: f64 = 1e-8;
/// Largest gap of a joint at the start, in lengths of its fibres.
const LARGEST_GAP: f64 = 1e-9;

/// One side of a joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkSide {
    pub(super) group: usize,
    pub(super) lane: usize,
    pub(super) node: usize,
    pub(super) segment: usize,
    /// Places of its force and of its moment, if it has one, among the points of the group.
    pub(super) force: usize,
    pub(super) moment: Option<usize>,
}

/// A joint in the equations.
#[derive(Debug, Clone)]
pub(super) struct Link {
    pub(super) sides: [LinkSide; 2],
    pub(super) junction: Option<Junction>,
    /// Length of a segment, m, by which forces and gaps are measured.
    length: f64,
    /// First of its unknowns in its cluster.
    first: usize,
}

/// Where a load of a group comes from: the unknown, and its sign.
#[derive(Debug, Clone, Copy)]
struct LoadSource {
    link: usize,
    /// Offset among the unknowns of the link.
    offset: usize,
    sign: f64,
    /// Place in the response matrix of its fibre.
    rank: usize,
}

/// Loads of joints on a group.
#[derive(Debug, Clone, Default)]
pub(super) struct GroupLoads {
    pub(super) points: Vec<LoadPoint>,
    sources: Vec<LoadSource>,
}

/// What a group tells of the last linearisation.
#[derive(Debug, Clone, Default)]
pub(super) struct GroupMotion {
    /// Ways of its points, m or rad.
    pub(super) ways: Vec<Vector3<f64>>,
    /// By lane, the change of these by loads.
    pub(super) responses: Vec<DMatrix<f64>>,
}

/// All joints of an assembly of fibres.
pub(super) struct Network {
    pub(super) links: Vec<Link>,
    pub(super) groups: Vec<GroupLoads>,
    /// Links that are coupled by fibres they share, and their number of unknowns.
    clusters: Vec<(Vec<usize>, usize)>,
}

/// Joints as they are at the last linearisation.
pub(super) struct JointState<'a> {
    /// Gaps at the start of the step, m, by link.
    pub(super) gaps: &'a [Vector3<f64>],
    /// Actions of junctions, by link.
    pub(super) actions: &'a [Option<JunctionAction>],
    pub(super) motions: &'a [GroupMotion],
    /// Loads of the last linearisation, by group.
    pub(super) loads: &'a [Vec<Vector3<f64>>],
}

impl Network {
    /// The network of joints between fibres.
    ///
    /// # Errors
    /// [`CouplingError::JointOpen`] for joints that start open, [`CouplingError::JointTwice`] for
    /// those between what others have joined already.
    pub(super) fn new(
        joints: &[NodeJoint],
        fibers: &Fibers<StaggeredBatch>,
    ) -> Result<Self, CouplingError> {
        let mut groups = vec![GroupLoads::default(); fibers.groups.len()];
        let mut links: Vec<Link> = Vec::with_capacity(joints.len());
        for joint in joints {
            check_closed(joint, fibers)?;
            let own = joint.places.map(|place| &fibers.assembly().fibers()[place.fiber]);
            let segments = [0, 1].map(|i| joint.places[i].node.saturating_sub(1));
            let at = links.len();
            let [first, second] = [0, 1].map(|i| {
                let FiberPlace { fiber, node } = joint.places[i];
                let (group, lane) = fibers.lane(fiber);
                let (segment, sign) = (segments[i], if i == 0 { 1.0 } else { -1.0 });
                let mut add = |place: LoadPlace, offset: usize, sign: f64| {
                    let GroupLoads { points, sources } = &mut groups[group];
                    let point = LoadPoint { fiber: index(lane), place };
                    let rank = points.iter().filter(|other| other.fiber == point.fiber).count();
                    points.push(point);
                    sources.push(LoadSource { link: at, offset, sign, rank });
                    points.len() - 1
                };
                let force = add(LoadPlace::Node(index(node)), 0, sign);
                let moment = (joint.connection != Connection::Ball)
                    .then(|| add(LoadPlace::Segment(index(segment)), 3 + 3 * i, 1.0));
                LinkSide { group, lane, node, segment, force, moment }
            });
            let damping = joint.damping_time;
            let frames = || [first, second].map(|side| frame(fibers, &side));
            let nodes = joint.places.map(|place| place.node);
            let junction = match joint.connection {
                Connection::Ball => None,
                Connection::Stiff => Some(Junction::weld(own, segments, nodes, frames(), damping)),
                Connection::Spliced { twist } => Some(Junction::splice(own, damping, twist)),
            };
            let length = own[0].segment_lengths()[segments[0]];
            links.push(Link { sides: [first, second], junction, length, first: 0 });
        }
        refuse_repeated(joints)?;
        let clusters = clusters(&mut links);
        Ok(Self { links, groups, clusters })
    }

    /// Changes of all loads, by group, that bring joints where they must be, as the equations are
    /// linearised.
    ///
    /// # Errors
    /// [`LinalgError`] where joints hold what cannot move.
    pub(super) fn solve(
        &self,
        state: &JointState<'_>,
    ) -> Result<Vec<Vec<Vector3<f64>>>, LinalgError> {
        let mut solution = vec![[0.0; 9]; self.links.len()];
        for cluster in &self.clusters {
            let unknowns = self.solve_cluster(cluster, state)?;
            for &link in &cluster.0 {
                let Link { first, length, .. } = self.links[link];
                let own = &mut solution[link];
                for i in 0..self.links[link].unknowns() {
                    own[i] = unknowns[first + i] / if i < 3 { length } else { 1.0 };
                }
            }
        }
        let of = |source: &LoadSource| {
            source.sign * Vector3::from_fn(|i, _| solution[source.link][source.offset + i])
        };
        Ok(self.groups.iter().map(|group| group.sources.iter().map(of).collect()).collect())
    }

    fn solve_cluster(
        &self,
        (members, size): &(Vec<usize>, usize),
        state: &JointState<'_>,
    ) -> Result<DVector<f64>, LinalgError> {
        let mut entries = Vec::new();
        let mut right = DVector::zeros(*size);
        for &member in members {
            let link = &self.links[member];
            let mut put = |row: usize, column: usize, block: &Matrix3<f64>| {
                for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                    entries.push((row + i, column + j, block[(i, j)]));
                }
            };
            // Nodes meet: forces times the length of a segment are the unknowns.
            let mut gap = state.gaps[member];
            for (side, sign) in link.sides.iter().zip([1.0, -1.0]) {
                gap += sign * state.motions[side.group].ways[side.force];
                let weight = Matrix3::from_diagonal_element(sign / link.length);
                self.respond(side.group, side.force, state, |column, block| {
                    put(link.first, column, &(weight * block));
                });
            }
            right.fixed_rows_mut::<3>(link.first).copy_from(&(-gap / link.length));
            // Moments of the junction on both segments.
            let Some(action) = &state.actions[member] else { continue };
            for (i, side) in link.sides.iter().enumerate() {
                let Some(own) = side.moment else { continue };
                let row = link.first + 3 + 3 * i;
                let sign = if i == 0 { 1.0 } else { -1.0 };
                let mut torque = sign * action.moment - state.loads[side.group][own];
                put(row, row, &Matrix3::identity());
                for (j, by) in link.sides.iter().enumerate() {
                    let Some(other) = by.moment else { continue };
                    let hessian = action.hessian.fixed_view::<3, 3>(3 * i, 3 * j).into_owned();
                    torque -= hessian * state.motions[by.group].ways[other];
                    self.respond(by.group, other, state, |column, block| {
                        put(row, column, &(hessian * block));
                    });
                }
                right.fixed_rows_mut::<3>(row).copy_from(&torque);
            }
        }
        solved(*size, &entries, &right)
    }

    /// Tells how the way of a point of a group changes with the unknowns: their first column and
    /// the block.
    fn respond(
        &self,
        group: usize,
        point: usize,
        state: &JointState<'_>,
        mut tell: impl FnMut(usize, Matrix3<f64>),
    ) {
        let GroupLoads { points, sources } = &self.groups[group];
        let lane = points[point].fiber;
        let matrix = &state.motions[group].responses[lane as usize];
        let row = 3 * sources[point].rank;
        let own = points.iter().zip(sources).filter(|(other, _)| other.fiber == lane);
        for (_, source) in own {
            let block = matrix.fixed_view::<3, 3>(row, 3 * source.rank).into_owned();
            let link = &self.links[source.link];
            let scale = source.sign / if source.offset == 0 { link.length } else { 1.0 };
            tell(link.first + source.offset, scale * block);
        }
    }
}

impl Link {
    fn unknowns(&self) -> usize {
        if self.junction.is_some() { 9 } else { 3 }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a fibre has at most 100 000 segments")]
fn index(i: usize) -> u32 {
    i as u32
}

/// Frame of the segment at a side.
pub(super) fn frame(
    fibers: &Fibers<StaggeredBatch>,
    side: &LinkSide,
) -> nalgebra::UnitQuaternion<f64> {
    fibers.groups[side.group].batch.frame(side.lane, side.segment)
}

/// Refuses a joint whose nodes do not meet.
fn check_closed(joint: &NodeJoint, fibers: &Fibers<StaggeredBatch>) -> Result<(), CouplingError> {
    let [a, b] = joint.places.map(|place| fibers.node(place.fiber, Some(place.node)).0);
    let own = joint.places.map(|place| fibers.assembly().fibers()[place.fiber].length());
    let (gap, most) = ((a - b).norm(), LARGEST_GAP * own[0].max(own[1]));
    if gap <= most {
        return Ok(());
    }
    let places = [a, b].map(|place| place.coords.into());
    Err(CouplingError::JointOpen { joint: joint.name.clone(), gap, most, places })
}

/// Refuses joints between nodes that others join already.
fn refuse_repeated(joints: &[NodeJoint]) -> Result<(), CouplingError> {
    // By node that is joined: a number that all that are joined to it have in common, and the last
    // joint there.
    let mut known: Vec<(FiberPlace, usize, usize)> = Vec::new();
    for (i, joint) in joints.iter().enumerate() {
        let sets = joint.places.map(|place| {
            let found = known.iter().position(|(other, ..)| *other == place);
            found.unwrap_or_else(|| {
                known.push((place, known.len(), i));
                known.len() - 1
            })
        });
        let [a, b] = sets.map(|at| known[at].1);
        if a == b {
            let other = joints[known[sets[0]].2].name.clone();
            return Err(CouplingError::JointTwice { joint: joint.name.clone(), other });
        }
        known.iter_mut().filter(|(_, set, _)| *set == b).for_each(|(_, set, _)| *set = a);
        sets.iter().for_each(|&at| known[at].2 = i);
    }
    Ok(())
}

/// Groups links by the fibres they share, numbers their unknowns, and counts these.
fn clusters(links: &mut [Link]) -> Vec<(Vec<usize>, usize)> {
    /// Members, and the fibres that they join.
    type Cluster = (Vec<usize>, Vec<(usize, usize)>);
    let fiber = |side: &LinkSide| (side.group, side.lane);
    let mut clusters: Vec<Cluster> = Vec::new();
    for (i, link) in links.iter().enumerate() {
        let own = [fiber(&link.sides[0]), fiber(&link.sides[1])];
        let (mut members, mut fibers) = (Vec::new(), own.to_vec());
        clusters.retain(|(others, of)| {
            let meets = own.iter().any(|fiber| of.contains(fiber));
            if meets {
                members.extend(others);
                fibers.extend(of);
            }
            !meets
        });
        members.push(i);
        fibers.sort_unstable();
        fibers.dedup();
        clusters.push((members, fibers));
    }
    let count = |(mut members, _): Cluster| {
        members.sort_unstable();
        let mut size = 0;
        for &member in &members {
            links[member].first = size;
            size += links[member].unknowns();
        }
        (members, size)
    };
    clusters.into_iter().map(count).collect()
}

/// The solution of a system that is small, or else sparse.
fn solved(
    size: usize,
    entries: &[(usize, usize, f64)],
    right: &DVector<f64>,
) -> Result<DVector<f64>, LinalgError> {
    if size > DENSE {
        let columns = DMatrix::from_column_slice(size, 1, right.as_slice());
        let solution = SparseSystem::new(size, entries)?.solve(&columns)?;
        return Ok(solution.column(0).into_owned());
    }
    let mut matrix = DMatrix::zeros(size, size);
    entries.iter().for_each(|&(row, column, value)| matrix[(row, column)] += value);
    let solution = matrix.clone().lu().solve(right).ok_or(LinalgError::Singular)?;
    let scale = right.amax() + matrix.amax() * solution.amax();
    let residual = (right - matrix * &solution).amax();
    if residual <= LARGEST_RESIDUAL * scale { Ok(solution) } else { Err(LinalgError::Singular) }
}
