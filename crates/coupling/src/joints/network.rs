//! Joints as unknowns of one system of equations.

use super::junction::{Junction, JunctionAction};
use super::node_joint::{Connection, FiberPlace, NodeJoint, refuse_repeated};
use crate::{CouplingError, Fibers};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rapunzel_rod_dynamic::{LoadPlace, LoadPoint, StaggeredBatch};

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
    pub(super) length: f64,
    /// First of its unknowns in its cluster.
    pub(super) first: usize,
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

impl GroupLoads {
    /// Numbers of points by lane, up to the last that has any.
    pub(super) fn counts(&self) -> Vec<usize> {
        let last = self.points.iter().map(|point| point.fiber as usize + 1).max();
        let mut counts = vec![0; last.unwrap_or(0)];
        self.points.iter().for_each(|point| counts[point.fiber as usize] += 1);
        counts
    }
}

/// All joints of an assembly of fibres.
pub(super) struct Network {
    pub(super) links: Vec<Link>,
    pub(super) groups: Vec<GroupLoads>,
    /// Links that are coupled by fibres they share, and their number of unknowns.
    pub(super) clusters: Vec<(Vec<usize>, usize)>,
}

/// Joints where the increments of the last linearisation lead.
pub(super) struct JointState<'a> {
    /// Gaps at the start of the step, m, by link.
    pub(super) gaps: &'a [Vector3<f64>],
    /// Actions of junctions at the last linearisation, by link.
    pub(super) actions: &'a [Option<JunctionAction>],
    /// By group, ways of its points, m or rad.
    pub(super) ways: &'a [Vec<Vector3<f64>>],
    /// Loads, by group.
    pub(super) loads: &'a [Vec<Vector3<f64>>],
}

/// What is wrong with joints.
pub(super) struct JointResiduals {
    /// By cluster, gaps in lengths of a segment, and moments that lack, N m.
    pub(super) of_clusters: Vec<DVector<f64>>,
    /// The largest of them, moments as the angles that they bend junctions by, rad.
    pub(super) worst: f64,
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
            joint.check_closed(fibers)?;
            let segments = joint.places.map(FiberPlace::segment);
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
            let frames = [first, second].map(|side| frame(fibers, &side));
            let junction = Junction::new(joint, fibers.assembly(), frames);
            let own = &fibers.assembly().fibers()[joint.places[0].fiber];
            let length = own.segment_lengths()[segments[0]];
            links.push(Link { sides: [first, second], junction, length, first: 0 });
        }
        refuse_repeated(joints)?;
        let clusters = clusters(&mut links);
        Ok(Self { links, groups, clusters })
    }

    /// What is wrong with joints in a state.
    pub(super) fn residuals(&self, state: &JointState<'_>) -> JointResiduals {
        let mut worst = 0.0_f64;
        let of_cluster = |(members, size): &(Vec<usize>, usize)| {
            let mut right = DVector::zeros(*size);
            for &member in members {
                let link = &self.links[member];
                let way = |side: &LinkSide| state.ways[side.group][side.force];
                let gap = state.gaps[member] + way(&link.sides[0]) - way(&link.sides[1]);
                let gap = gap / link.length;
                worst = worst.max(gap.norm());
                right.fixed_rows_mut::<3>(link.first).copy_from(&-gap);
                let both = state.actions[member].as_ref().zip(link.junction.as_ref());
                let Some((action, junction)) = both else { continue };
                for (i, side) in link.sides.iter().enumerate() {
                    let Some(own) = side.moment else { continue };
                    let sign = if i == 0 { 1.0 } else { -1.0 };
                    let mut torque = sign * action.moment - state.loads[side.group][own];
                    for (j, by) in link.sides.iter().enumerate() {
                        let Some(other) = by.moment else { continue };
                        let hessian = action.hessian.fixed_view::<3, 3>(3 * i, 3 * j);
                        torque -= hessian * state.ways[by.group][other];
                    }
                    worst = worst.max(torque.norm() / junction.stiffness.norm());
                    right.fixed_rows_mut::<3>(link.first + 3 + 3 * i).copy_from(&torque);
                }
            }
            right
        };
        let of_clusters = self.clusters.iter().map(of_cluster).collect();
        JointResiduals { of_clusters, worst }
    }

    /// Loads, by group, of unknowns by cluster.
    pub(super) fn loads(&self, unknowns: &[DVector<f64>]) -> Vec<Vec<Vector3<f64>>> {
        let mut solution = vec![[0.0; 9]; self.links.len()];
        for ((members, _), unknowns) in self.clusters.iter().zip(unknowns) {
            for &link in members {
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
        self.groups.iter().map(|group| group.sources.iter().map(of).collect()).collect()
    }

    /// Tells how the way of a point of a group changes with the unknowns: their first column and
    /// the block. `responses` are those of the fibres, by group and lane.
    pub(super) fn respond(
        &self,
        group: usize,
        point: usize,
        responses: &[Vec<DMatrix<f64>>],
        mut tell: impl FnMut(usize, Matrix3<f64>),
    ) {
        let GroupLoads { points, sources } = &self.groups[group];
        let lane = points[point].fiber;
        let matrix = &responses[group][lane as usize];
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
