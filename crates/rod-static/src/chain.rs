use crate::StaticError;
use crate::error::finite;
use crate::rod::Piece;
use crate::segment::{ChainSegment, turn};
use crate::shape::Shape;
use crate::target::Target;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use std::f64::consts::PI;

/// A rod in segments of constant curvature, clamped at its root, with forces on its nodes: the
/// thesis's energy minimization (section 3.3.2).
///
/// Inextensible: the center line is a helix in each segment, so its error falls with the square of
/// the segments' length. Loads along the rod act on the nodes; they may be given at will by
/// [`Chain::set_forces`]. Everything costs in proportion to the number of segments.
#[derive(Debug, Clone)]
pub struct Chain {
    pub(crate) clamp: Isometry3<f64>,
    pub(crate) segments: Vec<ChainSegment>,
    /// Dead forces on the nodes, N, world frame.
    pub(crate) forces: Vec<Vector3<f64>>,
    /// Forces on the nodes that follow their frames, N, in the nodes' own axes.
    pub(crate) followers: Vec<Vector3<f64>>,
    /// Couple on the last node that follows its frame, N m, in the node's own axes.
    pub(crate) tip_couple: Vector3<f64>,
    pub(crate) targets: Vec<Target>,
    pub(crate) tip: TipHold,
}

/// Constraint on the direction of the last node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TipHold {
    Free,
    /// The tangent of the last node is held.
    Aligned,
    /// The whole frame of the last node is held.
    Held,
}

impl Chain {
    /// The rod made of `pieces`, in order from the clamp, whose pose is `clamp`: its z axis is the
    /// tangent. It is cut into about `segments` segments of about the same length, at least one for
    /// each piece; each has the properties of its middle, and its load acts on its two ends.
    ///
    /// # Errors
    /// An invalid piece, no pieces or segments, and segments so long that they turn by half a turn
    /// naturally.
    pub fn new(
        clamp: &Isometry3<f64>,
        pieces: &[Piece],
        segments: usize,
    ) -> Result<Self, StaticError> {
        check_pose(clamp)?;
        pieces
            .iter()
            .try_fold(0.0, |from, piece| piece.validate(from).map(|()| from + piece.length()))?;
        if pieces.is_empty() {
            return Err(StaticError::NoPieces);
        }
        if segments == 0 {
            return Err(StaticError::NoSegments);
        }
        let total: f64 = pieces.iter().map(Piece::length).sum();
        let mut lengths = Vec::with_capacity(segments);
        for (i, piece) in pieces.iter().enumerate() {
            let share = (segments as f64 * piece.length() / total).round().max(1.0);
            let mut part = 0.0;
            while part < share {
                lengths.push((i, piece.length() / share));
                part += 1.0;
            }
        }
        Self::cut(clamp, pieces, &lengths)
    }

    /// The rod cut into segments, each given by its piece and its length.
    pub(crate) fn cut(
        clamp: &Isometry3<f64>,
        pieces: &[Piece],
        lengths: &[(usize, f64)],
    ) -> Result<Self, StaticError> {
        let mut chain = Self {
            clamp: *clamp,
            segments: Vec::with_capacity(lengths.len()),
            forces: vec![Vector3::zeros()],
            followers: vec![Vector3::zeros(); lengths.len() + 1],
            tip_couple: Vector3::zeros(),
            targets: Vec::new(),
            tip: TipHold::Free,
        };
        let mut from = 0.0;
        for (i, &(piece, length)) in lengths.iter().enumerate() {
            // Properties at the middle of the segment.
            let p = pieces[piece].at(from + length * 0.5);
            let angle = p.natural_curvature.norm() * length;
            if angle > PI {
                return Err(StaticError::TooCoarse { segment: i, angle });
            }
            chain.segments.push(ChainSegment {
                length,
                stiffness: p.stiffness,
                natural_curvature: p.natural_curvature,
            });
            // Half of the load on each end, and the end load of a piece on its last node.
            let half = p.load * (0.5 * length);
            let ends = lengths.get(i + 1).is_none_or(|next| next.0 > piece);
            let end_load = if ends { pieces[piece].end_load() } else { Vector3::zeros() };
            chain.forces[i] += half;
            chain.forces.push(half + end_load);
            from += length;
        }
        Ok(chain)
    }

    /// Number of segments; there is one node more.
    #[must_use]
    pub fn segment_count(&self) -> usize {
        self.segments.len()
    }

    /// Arc lengths of the nodes from the clamp, m.
    #[must_use]
    pub fn arc_lengths(&self) -> Vec<f64> {
        let mut at = vec![0.0];
        at.extend(self.segments.iter().scan(0.0, |s, segment| {
            *s += segment.length;
            Some(*s)
        }));
        at
    }

    /// The pose of the clamp.
    #[must_use]
    pub fn clamp(&self) -> Isometry3<f64> {
        self.clamp
    }

    /// Moves the clamp.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub fn set_clamp(&mut self, clamp: &Isometry3<f64>) -> Result<(), StaticError> {
        check_pose(clamp)?;
        self.clamp = *clamp;
        Ok(())
    }

    /// The dead forces on the nodes, N, world frame.
    #[must_use]
    pub fn forces(&self) -> &[Vector3<f64>] {
        &self.forces
    }

    /// Replaces the dead forces on all nodes, N, world frame; the force on node 0 acts on the clamp
    /// only.
    ///
    /// # Errors
    /// A number of forces other than one for each node, and numbers that are not finite.
    pub fn set_forces(&mut self, forces: &[Vector3<f64>]) -> Result<(), StaticError> {
        self.check_nodes("the forces on the nodes (N)", forces)?;
        self.forces.copy_from_slice(forces);
        Ok(())
    }

    /// Sets forces that follow the nodes, N, in the nodes' own axes. They have no energy, so an
    /// equilibrium with them is not a minimum.
    ///
    /// # Errors
    /// A number of forces other than one for each node, and numbers that are not finite.
    pub fn set_followers(&mut self, followers: &[Vector3<f64>]) -> Result<(), StaticError> {
        self.check_nodes("the following forces (N)", followers)?;
        self.followers.copy_from_slice(followers);
        Ok(())
    }

    /// Sets a couple on the last node that follows it, N m, in the node's own axes.
    ///
    /// Like a following force it has no energy, so an equilibrium with it is not a minimum; its
    /// work depends on the way (nor would a couple that is fixed in the world have an energy). In
    /// equilibrium it is the moment in the rod's end, so without other loads the curvature's excess
    /// over the natural one is the couple over the stiffness all along a naturally straight round
    /// rod.
    ///
    /// # Errors
    /// Numbers that are not finite.
    pub fn set_tip_couple(&mut self, couple: &Vector3<f64>) -> Result<(), StaticError> {
        finite("the couple on the last node (N m)", couple.as_slice())?;
        self.tip_couple = *couple;
        Ok(())
    }

    /// Whether loads act that follow the rod and so have no energy.
    pub(crate) fn is_followed(&self) -> bool {
        let zero = Vector3::zeros();
        self.tip_couple != zero || self.followers.iter().any(|force| *force != zero)
    }

    /// Sets the places that nodes are held at or pulled to.
    ///
    /// # Errors
    /// Nodes that are not there or are the clamp, stiffnesses that are not positive, places that
    /// are not finite, and held places farther apart than the rod between them is long.
    pub fn set_targets(&mut self, targets: &[Target]) -> Result<(), StaticError> {
        let at = self.arc_lengths();
        let mut held: Vec<(f64, Point3<f64>)> = vec![(0.0, self.clamp.translation.vector.into())];
        for target in targets {
            let last = self.segments.len();
            if !(1..=last).contains(&target.node) {
                return Err(StaticError::NoNode { node: target.node, last });
            }
            finite("the place of a target (m)", target.place.coords.as_slice())?;
            if target.stiffness.is_nan() || target.stiffness <= 0.0 {
                let quantity = "the stiffness of a target (N/m)";
                return Err(StaticError::NotPositive { quantity, value: target.stiffness });
            }
            if target.is_held() {
                for (other, place) in &held {
                    let (distance, length) =
                        ((target.place - place).norm(), (at[target.node] - other).abs());
                    if distance > length {
                        return Err(StaticError::OutOfReach { distance, length });
                    }
                }
                held.push((at[target.node], target.place));
            }
        }
        self.targets = targets.to_vec();
        Ok(())
    }

    /// Sets whether the last node keeps the frame that it has in the shape given to
    /// [`Chain::relax`]: with a target that holds its place, the end is clamped.
    pub fn hold_tip_frame(&mut self, held: bool) {
        self.tip = if held { TipHold::Held } else { TipHold::Free };
    }

    /// The targets of [`Chain::set_targets`]: places that nodes are held at or pulled to.
    #[must_use]
    pub fn targets(&self) -> &[Target] {
        &self.targets
    }

    pub(crate) fn check_nodes(
        &self,
        quantity: &'static str,
        values: &[Vector3<f64>],
    ) -> Result<(), StaticError> {
        if values.len() != self.forces.len() {
            let (given, nodes) = (values.len(), self.forces.len());
            return Err(StaticError::WrongCount { quantity, given, nodes });
        }
        values.iter().try_for_each(|v| finite(quantity, v.as_slice()))
    }

    /// The shape without loads.
    #[must_use]
    pub fn natural_shape(&self) -> Shape {
        let mut frames = vec![self.clamp.rotation];
        for (i, segment) in self.segments.iter().enumerate() {
            let turn = segment.natural_curvature * segment.length;
            frames.push(frames[i] * UnitQuaternion::from_scaled_axis(turn));
        }
        self.shape(frames)
    }

    /// The shape after the rotations `by` of the nodes behind the clamp, rotation vectors in their
    /// own axes: `R exp(b)`.
    ///
    /// # Errors
    /// A shape or rotations of another number of nodes.
    pub fn turned(&self, shape: &Shape, by: &[Vector3<f64>]) -> Result<Shape, StaticError> {
        self.check(shape)?;
        self.check_free(by)?;
        let mut frames = shape.frames.clone();
        turn_by(&mut frames, by, 1.0);
        Ok(self.shape(frames))
    }

    /// The shape with the given frames of all nodes, the clamp first: what [`Shape::frames`] of a
    /// shape of this chain makes, to the last bit.
    ///
    /// # Errors
    /// A number of frames other than one for each node, and numbers that are not finite.
    pub fn shape_of(&self, frames: Vec<UnitQuaternion<f64>>) -> Result<Shape, StaticError> {
        let (given, nodes) = (frames.len(), self.forces.len());
        let quantity = "the frames of the shape";
        if given != nodes {
            return Err(StaticError::WrongCount { quantity, given, nodes });
        }
        frames.iter().try_for_each(|frame| finite(quantity, frame.coords.as_slice()))?;
        Ok(self.shape(frames))
    }

    /// The shape with the given frames of the nodes behind the clamp.
    pub(crate) fn shape(&self, frames: Vec<UnitQuaternion<f64>>) -> Shape {
        let mut shape = Shape { frames, positions: Vec::new() };
        self.place(&mut shape);
        shape
    }

    /// Computes the positions of the nodes from their frames.
    pub(crate) fn place(&self, shape: &mut Shape) {
        let mut at = Point3::from(self.clamp.translation.vector);
        shape.positions.clear();
        shape.positions.push(at);
        for (segment, ends) in self.segments.iter().zip(shape.frames.windows(2)) {
            at += ends[0] * segment.chord(&turn(&ends[0], &ends[1]));
            shape.positions.push(at);
        }
    }

    /// Forces in the segments, N, world frame: the sum over all nodes beyond of the dead forces, of
    /// `factor` times the following forces, and of the targets' `pulls`.
    pub(crate) fn carried(
        &self,
        frames: &[UnitQuaternion<f64>],
        factor: f64,
        pulls: &[Vector3<f64>],
    ) -> Vec<Vector3<f64>> {
        let mut carried = self.forces[1..].to_vec();
        if factor > 0.0 {
            for (i, force) in carried.iter_mut().enumerate() {
                *force += frames[i + 1] * (factor * self.followers[i + 1]);
            }
        }
        for (target, pull) in self.targets.iter().zip(pulls) {
            carried[target.node - 1] += pull;
        }
        for i in (1..carried.len()).rev() {
            let beyond = carried[i];
            carried[i - 1] += beyond;
        }
        carried
    }

    /// Checks that `shape` has this chain's number of nodes.
    pub(crate) fn check(&self, shape: &Shape) -> Result<(), StaticError> {
        let (given, nodes) = (shape.frames.len(), self.forces.len());
        let quantity = "the frames of the shape";
        let same = given == nodes;
        if same { Ok(()) } else { Err(StaticError::WrongCount { quantity, given, nodes }) }
    }

    /// Checks that there is one rotation for each node behind the clamp.
    pub(crate) fn check_free(&self, by: &[Vector3<f64>]) -> Result<(), StaticError> {
        let (given, nodes) = (by.len(), self.segments.len());
        let quantity = "the rotations of the nodes behind the clamp";
        let same = given == nodes;
        if same { Ok(()) } else { Err(StaticError::WrongCount { quantity, given, nodes }) }
    }

    /// Curvatures of the segments in their own axes, 1/m.
    #[must_use]
    pub fn curvatures(&self, shape: &Shape) -> Vec<Vector3<f64>> {
        let turns = shape.frames.windows(2).map(|ends| turn(&ends[0], &ends[1]));
        turns.zip(&self.segments).map(|(turn, segment)| turn / segment.length).collect()
    }
}

fn check_pose(clamp: &Isometry3<f64>) -> Result<(), StaticError> {
    finite("the pose of the clamp", clamp.translation.vector.as_slice())?;
    finite("the pose of the clamp", clamp.rotation.coords.as_slice())
}

/// Turns the frames behind the first by the rotation vectors `part * by` in their own axes.
pub(crate) fn turn_by(frames: &mut [UnitQuaternion<f64>], by: &[Vector3<f64>], part: f64) {
    for (frame, variation) in frames[1..].iter_mut().zip(by) {
        let turned = *frame * UnitQuaternion::from_scaled_axis(variation * part);
        *frame = UnitQuaternion::new_normalize(turned.into_inner());
    }
}
