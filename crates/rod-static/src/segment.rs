use crate::series::{curve, curve_values, logarithm};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3::hat;

/// A segment of constant curvature between two nodes, whose frames are the unknowns.
///
/// `phi` is the rotation vector from the frame before to the frame behind, the curvature times the
/// length; `nu` is the force that the rod beyond exerts, in the frame before. Variations of a
/// frame are rotation vectors in its own axes: `R exp(b)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ChainSegment {
    pub(crate) length: f64,
    pub(crate) stiffness: Vector3<f64>,
    pub(crate) natural_curvature: Vector3<f64>,
}

/// Gradient and Hessian of a segment's energy by the variations of the frames before and behind.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Blocks {
    pub(crate) gradient: [Vector3<f64>; 2],
    /// Second derivatives by the variation of the frame before.
    pub(crate) before: Matrix3<f64>,
    /// Second derivatives by the variation of the frame behind.
    pub(crate) behind: Matrix3<f64>,
    /// Mixed second derivatives (rows behind, columns before).
    pub(crate) mixed: Matrix3<f64>,
    /// Approximate shift of both diagonal blocks that makes them convex.
    pub(crate) shift: f64,
}

/// The rotation vector from `before` to `behind`, shorter than half a turn.
pub(crate) fn turn(before: &UnitQuaternion<f64>, behind: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = (before.inverse() * behind).into_inner();
    let (v, sign) = (q.imag(), 1.0_f64.copysign(q.w));
    let norm = v.norm();
    let factor = if norm > 1e-9 { 2.0 * norm.atan2(q.w.abs()) / norm } else { 2.0 };
    v * (factor * sign)
}

/// Quantities that gradient, Hessian and motion of the end have in common.
struct Geometry {
    /// Chord over length, `p`.
    chord: Vector3<f64>,
    /// Derivative of the chord over length by `phi`.
    chord_by_phi: Matrix3<f64>,
    /// `phi` changes by `inverse b` of the frame behind, and by `-inverse^T b` of the one before.
    inverse: Matrix3<f64>,
    c: [[f64; 3]; 2],
    d: [f64; 2],
}

impl Geometry {
    fn of(phi: &Vector3<f64>) -> Self {
        let (x, e3, z) = (phi.norm_squared(), Vector3::z(), phi.z);
        let [c2, c3] = curve(x);
        let d = logarithm(x, &c2);
        let (across, along) = (Vector3::new(phi.y, -phi.x, 0.0), phi * z - e3 * x);
        let mut chord_by_phi = (across * c2[1] + along * c3[1]) * 2.0 * phi.transpose();
        chord_by_phi[(0, 1)] += c2[0];
        chord_by_phi[(1, 0)] -= c2[0];
        for i in 0..3 {
            chord_by_phi[(i, i)] += c3[0] * z;
            chord_by_phi[(i, 2)] += c3[0] * phi[i];
            chord_by_phi[(2, i)] -= 2.0 * c3[0] * phi[i];
        }
        let mut inverse = hat(&(0.5 * phi)) + phi * (d[0] * phi).transpose();
        let diagonal = 1.0 - d[0] * x;
        for i in 0..3 {
            inverse[(i, i)] += diagonal;
        }
        let chord = e3 + across * c2[0] + along * c3[0];
        Self { chord, chord_by_phi, inverse, c: [c2, c3], d }
    }

    /// Second derivatives of `nu . p` by `phi`.
    fn chord_hessian(&self, phi: &Vector3<f64>, nu: &Vector3<f64>) -> Matrix3<f64> {
        let [c2, c3] = self.c;
        let k = Vector3::new(-nu.y, nu.x, 0.0);
        let (along, q) = (phi.dot(nu), phi.dot(nu) * phi.z - phi.norm_squared() * nu.z);
        let slope = nu * phi.z + Vector3::z() * along - phi * (2.0 * nu.z);
        let w = 2.0 * (c2[1] * phi.dot(&k) + c3[1] * q);
        let h = (k * c2[1] + slope * c3[1] + phi * (2.0 * (c2[2] * phi.dot(&k) + c3[2] * q))) * 2.0;
        let mut hessian = phi * h.transpose() + h * phi.transpose();
        for i in 0..3 {
            hessian[(i, i)] += w - 2.0 * c3[0] * nu.z;
            hessian[(i, 2)] += c3[0] * nu[i];
            hessian[(2, i)] += c3[0] * nu[i];
        }
        hessian
    }

    /// The derivative of `inverse^T u` by `phi` for a constant `u`.
    fn lifted(&self, phi: &Vector3<f64>, u: &Vector3<f64>, sign: f64) -> Matrix3<f64> {
        let [d, slope] = self.d;
        let (x, along) = (phi.norm_squared(), phi.dot(u));
        let mut lifted = hat(&(0.5 * sign * u))
            + (u * (-2.0 * d) + (phi * along - u * x) * (2.0 * slope)) * phi.transpose()
            + phi * (d * u).transpose();
        for i in 0..3 {
            lifted[(i, i)] += d * along;
        }
        lifted
    }
}

impl ChainSegment {
    /// Vector from the first to the second node, m, in the frame before.
    pub(crate) fn chord(&self, phi: &Vector3<f64>) -> Vector3<f64> {
        let (x, z) = (phi.norm_squared(), phi.z);
        let [c2, c3] = curve_values(x);
        let chord = Vector3::new(c2 * phi.y + c3 * z * phi.x, c3 * z * phi.y - c2 * phi.x, 0.0);
        (chord + Vector3::z() * (1.0 + c3 * (z * z - x))) * self.length
    }

    /// Curvature in excess of the natural one, 1/m, material frame.
    pub(crate) fn strain(&self, phi: &Vector3<f64>) -> Vector3<f64> {
        phi / self.length - self.natural_curvature
    }

    /// Elastic energy of the segment, J.
    pub(crate) fn elastic(&self, phi: &Vector3<f64>) -> f64 {
        let strain = self.strain(phi);
        0.5 * self.length * strain.dot(&self.stiffness.component_mul(&strain))
    }

    /// Gradient and Hessian of the elastic energy less `nu . chord`.
    pub(crate) fn blocks(&self, phi: &Vector3<f64>, nu: &Vector3<f64>) -> Blocks {
        self.blocks_pushed(phi, nu, None)
    }

    /// As [`ChainSegment::blocks`], also less `push . half chord`, with a force on the middle of
    /// the segment, in the frame before.
    pub(crate) fn blocks_pushed(
        &self,
        phi: &Vector3<f64>,
        nu: &Vector3<f64>,
        push: Option<&Vector3<f64>>,
    ) -> Blocks {
        let g = Geometry::of(phi);
        let (l, force) = (self.length, nu * self.length);
        let (inverse, transposed) = (g.inverse, g.inverse.transpose());
        let mut pulled = g.chord_by_phi.transpose() * force;
        let mut turned = g.chord_by_phi.transpose() * hat(&force);
        let mut bent = g.chord_hessian(phi, &force);
        let mut moment = g.chord.cross(&force);
        let mut swept = hat(&g.chord) * hat(&force);
        let mut slack = force.norm() - force.dot(&g.chord);
        if let Some(push) = push {
            // The half chord is half of the chord over length at half of phi.
            let half = 0.5 * phi;
            let (h, force) = (Geometry::of(&half), push * l);
            pulled += h.chord_by_phi.transpose() * force * 0.25;
            turned += h.chord_by_phi.transpose() * hat(&force) * 0.25;
            bent += h.chord_hessian(&half, &force) * 0.125;
            moment += h.chord.cross(&force) * 0.5;
            swept += hat(&h.chord) * hat(&force) * 0.5;
            slack += 0.5 * (force.norm() - force.dot(&h.chord));
        }
        // u: derivative of the energy by phi; by_phi: its second derivative by phi.
        let u = self.stiffness.component_mul(&self.strain(phi)) - pulled;
        let mut by_phi = -bent;
        for i in 0..3 {
            by_phi[(i, i)] += self.stiffness[i] / l;
        }
        let lifted = g.lifted(phi, &u, 1.0) + transposed * by_phi;
        let lowered = g.lifted(phi, &u, -1.0) + inverse * by_phi;
        let behind = lifted * inverse;
        // The two halves of this sum are each other's transposes.
        let crossed = inverse * turned;
        let before = lowered * transposed + crossed + crossed.transpose() - swept;
        Blocks {
            gradient: [-(inverse * u) - moment, transposed * u],
            before: symmetric(&before),
            behind: symmetric(&behind),
            mixed: -(lifted * transposed) - transposed * turned,
            shift: 0.5 * (slack + u.norm() * phi.norm()),
        }
    }

    /// Vector from the first node to the middle, m, in the frame before.
    pub(crate) fn half_chord(&self, phi: &Vector3<f64>) -> Vector3<f64> {
        Self { length: 0.5 * self.length, ..*self }.chord(&(0.5 * phi))
    }

    /// Derivatives of the half chord, in the frame before, by the variations of the frames before
    /// and behind.
    pub(crate) fn half_motion(&self, phi: &Vector3<f64>) -> [Matrix3<f64>; 2] {
        let (g, h) = (Geometry::of(phi), Geometry::of(&(0.5 * phi)));
        let by_phi = h.chord_by_phi * (0.25 * self.length);
        let chord = h.chord * (0.5 * self.length);
        [-(hat(&chord) + by_phi * g.inverse.transpose()), by_phi * g.inverse]
    }

    /// Derivatives of the chord, in the frame before, by the variations of the frames before and
    /// behind.
    pub(crate) fn motion(&self, phi: &Vector3<f64>) -> [Matrix3<f64>; 2] {
        let g = Geometry::of(phi);
        let by_phi = g.chord_by_phi * self.length;
        [-(hat(&(g.chord * self.length)) + by_phi * g.inverse.transpose()), by_phi * g.inverse]
    }
}

fn symmetric(m: &Matrix3<f64>) -> Matrix3<f64> {
    0.5 * (m + m.transpose())
}
