use super::PolygonalCone;
use crate::{ContactError, RigidBody};
use nalgebra::{Point3, Vector3};

/// Other side of a contact of a rigid body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Partner {
    /// Something whose motion is given: its velocity at the point, world, m/s.
    Given(Vector3<f64>),
    /// Another of the bodies, by index.
    Body(usize),
}

/// A contact of rigid bodies, as a collision test found it.
#[derive(Debug, Clone, PartialEq)]
pub struct Touch {
    /// Index of the body that is touched.
    pub body: usize,
    /// Other side of the contact.
    pub partner: Partner,
    /// Point of the contact, world, m.
    pub point: Point3<f64>,
    /// Unit normal, world, from the partner to the body.
    pub normal: Vector3<f64>,
    /// Direction in the surface along which the friction's angle is zero, `t1`; made orthogonal to
    /// the normal. On a fiber its axis, root to tip (thesis after (8.48)). The other is
    /// `t2 = normal x t1`.
    pub tangent: Vector3<f64>,
    /// Velocity at which the contact may still close, m/s: an open gap divided by the time that is
    /// left; zero where the bodies touch or overlap; negative where they must part.
    pub closing: f64,
    /// Limit curve of the friction that acts on the body.
    pub friction: PolygonalCone,
}

impl Touch {
    /// The columns n, t1, t2.
    pub(crate) fn frame(&self, index: usize) -> Result<[Vector3<f64>; 3], ContactError> {
        let bad = |why| ContactError::Contact { contact: index, why };
        let normal = self
            .normal
            .try_normalize(0.0)
            .filter(|n| n.iter().all(|x| x.is_finite()))
            .ok_or_else(|| bad("its normal has no direction"))?;
        let tangent = self
            .tangent
            .try_normalize(0.0)
            .map(|t| t - normal * normal.dot(&t))
            .filter(|t| t.norm() > 1e-9)
            .ok_or_else(|| bad("its tangent is parallel to its normal"))?
            .normalize();
        Ok([normal, tangent, normal.cross(&tangent)])
    }

    pub(crate) fn check(&self, index: usize, bodies: usize) -> Result<(), ContactError> {
        let bad = |why| Err(ContactError::Contact { contact: index, why });
        if self.body >= bodies || matches!(self.partner, Partner::Body(b) if b >= bodies) {
            return bad("it is on a body that there is not");
        }
        if self.partner == Partner::Body(self.body) {
            return bad("a body touches itself");
        }
        if !self.point.iter().all(|x| x.is_finite()) {
            return bad("its point is not finite");
        }
        if !self.closing.is_finite() {
            return bad("its closing velocity must be finite");
        }
        Ok(())
    }
}

/// Mass that a body shows along `direction` (unit) at `point`, kg: (8.68), whose second term has
/// the square of the gradient's norm (erratum; the same here as the direction is a unit).
pub(super) fn effective_mass(
    body: &RigidBody,
    point: &Point3<f64>,
    direction: &Vector3<f64>,
) -> f64 {
    let moment = (point - body.center()).cross(direction);
    1.0 / (1.0 / body.mass() + moment.dot(&(body.inverse_inertia() * moment)))
}
