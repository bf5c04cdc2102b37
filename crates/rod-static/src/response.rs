//! How an equilibrium changes by the loads on its end.

use crate::StaticError;
use crate::chain::Chain;
use crate::linearized::LinearizedBalance;
use crate::relax::Rest;
use crate::segment::turn;
use nalgebra::{Matrix3, Vector3};
use rapunzel_fiber::so3::right_jacobian_inverse;

/// Change of the shape of a [`Chain`] by the unit of a load, to first order.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeResponse {
    /// Changes of the positions of the nodes, world frame, the clamp first, m for the load's unit.
    pub positions: Vec<Vector3<f64>>,
    /// Changes of the unit tangents of the nodes, world frame, the clamp first, for the load's
    /// unit.
    pub tangents: Vec<Vector3<f64>>,
    /// Changes of the curvatures of the segments, 1/m, in their own axes as those of
    /// [`Chain::curvatures`], for the load's unit.
    pub curvatures: Vec<Vector3<f64>>,
}

impl Chain {
    /// Changes of the equilibrium `rest` of this chain by the three components of the dead force on
    /// the last node, N, world frame, and by those of the couple of [`Chain::set_tip_couple`], N m.
    ///
    /// Cost: about that of two Newton steps. For the derivatives of one functional alone,
    /// [`Chain::end_load_derivatives`] takes less.
    ///
    /// # Errors
    /// A shape of another number of nodes, and [`StaticError::NoDerivative`] for a chain with
    /// following forces, or at a limit of stability.
    pub fn end_load_responses(&self, rest: &Rest) -> Result<[ShapeResponse; 6], StaticError> {
        let balance = LinearizedBalance::new(self, rest, self.tip_couple)?;
        let frames = &rest.shape.frames;
        let inverses: Vec<Matrix3<f64>> = frames
            .windows(2)
            .map(|ends| right_jacobian_inverse(&turn(&ends[0], &ends[1])))
            .collect();
        let response = |load: usize| {
            let turns = balance.turns(self, &self.unit_moments(load, balance.motions()))?;
            Ok(self.response(rest, &turns, balance.motions(), &inverses))
        };
        let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(response);
        Ok([a?, b?, c?, d?, e?, f?])
    }

    /// Moments on the nodes behind the clamp of the unit of a component of the load on the last
    /// node: three of the force and three of the couple.
    fn unit_moments(&self, load: usize, motions: &[[Matrix3<f64>; 2]]) -> Vec<Vector3<f64>> {
        let mut moments = vec![Vector3::zeros(); self.segments.len()];
        if load >= 3 {
            if let Some(last) = moments.last_mut() {
                last[load - 3] = 1.0;
            }
            return moments;
        }
        for (s, motion) in motions.iter().enumerate() {
            moments[s] += motion[1].row(load).transpose();
            if s > 0 {
                moments[s - 1] += motion[0].row(load).transpose();
            }
        }
        moments
    }

    /// The change of the shape by the rotations `turns` of the nodes behind the clamp.
    fn response(
        &self,
        rest: &Rest,
        turns: &[Vector3<f64>],
        motions: &[[Matrix3<f64>; 2]],
        inverses: &[Matrix3<f64>],
    ) -> ShapeResponse {
        let count = turns.len();
        let (mut at, mut before) = (Vector3::zeros(), Vector3::zeros());
        let mut response = ShapeResponse {
            positions: Vec::with_capacity(count + 1),
            tangents: Vec::with_capacity(count + 1),
            curvatures: Vec::with_capacity(count),
        };
        response.positions.push(at);
        response.tangents.push(Vector3::zeros());
        for (i, turn) in turns.iter().enumerate() {
            at += motions[i][0] * before + motions[i][1] * turn;
            response.positions.push(at);
            response.tangents.push(rest.shape.frames[i + 1] * turn.cross(&Vector3::z()));
            let bend = inverses[i] * turn - inverses[i].tr_mul(&before);
            response.curvatures.push(bend / self.segments[i].length);
            before = *turn;
        }
        response
    }
}
