//! The joints of a chain: their moments, energies and Hessians.

use super::chain::RotationChain;
use super::joint_geometry::{JointEffect, combine, log_hessian, moment, slope_of_log};
use pulp::Simd;
use rapunzel_lanes::{Lane, M3, Quat, Sym, V3};

impl<S: Simd> RotationChain<S> {
    /// Moment, energy and Hessian of the joint between rotations `a` and `b`; `d` belongs to `b`.
    #[inline(always)]
    pub(super) fn joint(
        &self,
        j: usize,
        a: Quat<S>,
        b: Quat<S>,
        d: [V3<S>; 3],
        exact: Lane<S>,
    ) -> JointEffect<S> {
        let (phi, fw) = a.inverse_times(b).log();
        let one = fw.lift(1.0);
        let half = fw.lift(0.5);
        // Moment and energy of the joint in its own frame: linear, or from the model of a section
        // law.
        let k = self.vec(&self.room.k, j);
        let (m, energy, tangent) = match &self.laws {
            None => {
                let strain = phi - self.vec(&self.room.target, j);
                let m = k.times(strain);
                (m, half * m.dot(strain), None)
            }
            Some(laws) => {
                let (m, energy, tangent) = laws.model(self.simd, j, phi);
                (m, energy, Some(tangent))
            }
        };
        // Moment in the world, J^-T m.
        let angle2 = phi.dot(phi);
        let c = slope_of_log(angle2, fw);
        let moment = moment(phi, m, c, d);
        // Rows of J^-1 R^T, J^-1 = E + hat(phi)/2 + c (phi phi^T - a^2 E).
        let [x, y, z] = phi.0;
        let s = c.negate_mul_add(angle2, one);
        let cp = phi.scale(c);
        let inverse = M3([
            V3([
                cp.0[0].mul_add(x, s),
                half.negate_mul_add(z, cp.0[0] * y),
                half.mul_add(y, cp.0[0] * z),
            ]),
            V3([
                half.mul_add(z, cp.0[1] * x),
                cp.0[1].mul_add(y, s),
                half.negate_mul_add(x, cp.0[1] * z),
            ]),
            V3([
                half.negate_mul_add(y, cp.0[2] * x),
                half.mul_add(x, cp.0[2] * y),
                cp.0[2].mul_add(z, s),
            ]),
        ]);
        // Hessian: j^T K j with j = J^-1 R^T, and in exact lanes the second derivative of the
        // logarithm.
        let j = M3(d).transposed().times(inverse.transposed()).transposed();
        let kj = match tangent {
            None => M3([j.0[0].scale(k.0[0]), j.0[1].scale(k.0[1]), j.0[2].scale(k.0[2])]),
            Some(tangent) => tangent.times(j),
        };
        let coupling = Sym::transposed_product(j, kj);
        let (phi_world, m_world) = (combine(d, phi), combine(d, m));
        let hessian = coupling + log_hessian(phi_world, m_world, angle2).scale(exact);
        JointEffect { moment, energy, hessian }
    }
}
