//! Derivatives of what is a function of an equilibrium by the loads on its end.

use crate::StaticError;
use crate::chain::Chain;
use crate::linearized::LinearizedBalance;
use crate::newton::moved;
use crate::relax::Rest;
use crate::segment::turn;
use crate::shape::Shape;
use nalgebra::Vector3;
use rapunzel_fiber::so3::right_jacobian_inverse;

/// Derivatives of a functional of a shape of a [`Chain`] by what the shape is made of; the unit is
/// the functional's over that of the quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeDerivatives {
    /// By the positions of the nodes, world frame, the clamp first.
    pub positions: Vec<Vector3<f64>>,
    /// By the tangents of the nodes, unit vectors in the world frame, the clamp first.
    pub tangents: Vec<Vector3<f64>>,
    /// By the curvatures of the segments, in their own axes, as of [`Chain::curvatures`].
    pub curvatures: Vec<Vector3<f64>>,
}

impl ShapeDerivatives {
    /// Zeros for a chain of `segments` segments.
    #[must_use]
    pub fn zeros(segments: usize) -> Self {
        let zeros = |count| vec![Vector3::zeros(); count];
        Self {
            positions: zeros(segments + 1),
            tangents: zeros(segments + 1),
            curvatures: zeros(segments),
        }
    }
}

/// Derivatives of a functional of an equilibrium by the loads on the last node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndLoadDerivatives {
    /// By the dead force, world frame; the unit is the functional's over N.
    pub force: Vector3<f64>,
    /// By the couple of [`Chain::set_tip_couple`], in the node's own axes; the unit is the
    /// functional's over N m.
    pub couple: Vector3<f64>,
}

impl Chain {
    /// Derivatives of a functional by the rotations of the nodes behind the clamp, rotation vectors
    /// in their own axes, from its derivatives by positions, tangents and curvatures. A node's
    /// rotation moves all nodes beyond, so derivatives by positions are summed up from the end,
    /// like the forces of [`Chain::gradient`]. Cost: in proportion to the segments.
    ///
    /// # Errors
    /// A shape or derivatives of another number of nodes.
    pub fn by_rotations(
        &self,
        shape: &Shape,
        by: &ShapeDerivatives,
    ) -> Result<Vec<Vector3<f64>>, StaticError> {
        self.check(shape)?;
        self.check_nodes("the derivatives by the positions", &by.positions)?;
        self.check_nodes("the derivatives by the tangents", &by.tangents)?;
        self.check_free(&by.curvatures)?;
        let motions = self.trial(shape).motions(self);
        let mut rotations = vec![Vector3::zeros(); motions.len()];
        let mut beyond = Vector3::zeros();
        for (i, motion) in motions.iter().enumerate().rev() {
            beyond += by.positions[i + 1];
            // A tangent d3 turns by `R (b x e3)`.
            let tangent = shape.frames[i + 1].inverse_transform_vector(&by.tangents[i + 1]);
            // The rotation vector of a segment changes by `inverse b` of the frame behind, and by
            // `-inverse^T b` of the one before.
            let turn = turn(&shape.frames[i], &shape.frames[i + 1]);
            let inverse = right_jacobian_inverse(&turn);
            let bent = by.curvatures[i] / self.segments[i].length;
            rotations[i] +=
                motion[1].tr_mul(&beyond) + Vector3::z().cross(&tangent) + inverse.tr_mul(&bent);
            if i > 0 {
                rotations[i - 1] += motion[0].tr_mul(&beyond) - inverse * bent;
            }
        }
        Ok(rotations)
    }

    /// Derivatives of a functional of the equilibrium `rest` of this chain by the dead force and by
    /// the couple on the last node, from its derivatives `by` the rotations of the nodes behind the
    /// clamp, in their own axes (see [`Chain::by_rotations`]).
    ///
    /// The adjoint method: one solution with the transposed Jacobian of the balance serves all six
    /// loads. The Hessian is symmetric, and the couple's part of the Jacobian is skew, so the
    /// transposed Jacobian is that of the opposite couple. Cost: about that of a Newton step.
    ///
    /// # Errors
    /// A shape or derivatives of another number of nodes, and [`StaticError::NoDerivative`] for a
    /// chain with following forces, or at a limit of stability.
    pub fn end_load_derivatives(
        &self,
        rest: &Rest,
        by: &[Vector3<f64>],
    ) -> Result<EndLoadDerivatives, StaticError> {
        self.check_free(by)?;
        let transposed = LinearizedBalance::new(self, rest, -self.tip_couple)?;
        let adjoint = transposed.turns(self, by)?;
        // A force on the last node turns each node in proportion to how that moves the last one.
        let force = moved(transposed.motions(), &adjoint);
        Ok(EndLoadDerivatives { force, couple: adjoint[adjoint.len() - 1] })
    }
}
