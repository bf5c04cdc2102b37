use super::CylinderChain;
use crate::rigid::{angular, linear, stack};
use crate::thesis::Response;
use crate::thesis::projection::{Partner, PolygonalCone, Touch};
use crate::{ContactError, Report, RigidBody};
use nalgebra::{Point3, Vector3, Vector6};
use std::collections::BTreeMap;

/// Other side of a contact of a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SegmentPartner {
    /// Something whose motion is given: its velocity at the point, world, m/s.
    Given(Vector3<f64>),
    /// Another segment.
    Segment {
        /// Index of the other chain.
        chain: usize,
        /// Index of the segment in the other chain.
        segment: usize,
    },
}

/// A contact of a chain's segment, as a collision test found it: at the chains' poses, or with
/// [`ChainForm::contact_time`](super::ChainForm) as printed at those of
/// [`CylinderChain::half_way`].
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentContact {
    /// Index of the chain.
    pub chain: usize,
    /// Index of the segment in the chain.
    pub segment: usize,
    /// Point of the contact, world, m.
    pub point: Point3<f64>,
    /// Unit normal, world, from the partner to the segment.
    pub normal: Vector3<f64>,
    /// Gap, m. An open one may close in what is left of the step; a negative one is not repaired.
    pub gap: f64,
    /// Other side of the contact.
    pub partner: SegmentPartner,
    /// Limit curve, its angle zero along the segment's axis, root to tip.
    pub friction: PolygonalCone,
}

/// Changes of the linear and angular momentum of a segment by its contacts, N s and N m s, world.
pub(super) struct MomentumChange {
    pub(super) chain: usize,
    pub(super) segment: usize,
    pub(super) linear: Vector3<f64>,
    pub(super) angular: Vector3<f64>,
}

/// The impacts of the touched segments: `ahead` gives a segment as it is before the contacts act,
/// `closing` the velocity at which a contact may close.
pub(super) fn resolve(
    chains: &[CylinderChain],
    contacts: &[SegmentContact],
    closing: impl Fn(&SegmentContact) -> f64,
    restitution: f64,
    response: &mut dyn Response,
    ahead: impl Fn(usize, usize) -> RigidBody,
) -> Result<(Vec<MomentumChange>, Option<Report>), ContactError> {
    let mut touched = BTreeMap::new();
    for (index, contact) in contacts.iter().enumerate() {
        let mut touch = |chain: usize, segment: usize| {
            if chains.get(chain).is_none_or(|chain| segment >= chain.segments.len()) {
                let why = "it is on a segment that there is not";
                return Err(ContactError::Contact { contact: index, why });
            }
            touched.insert((chain, segment), 0);
            Ok(())
        };
        touch(contact.chain, contact.segment)?;
        if let SegmentPartner::Segment { chain, segment } = contact.partner {
            touch(chain, segment)?;
        }
    }
    let mut bodies: Vec<RigidBody> = Vec::with_capacity(touched.len());
    for ((chain, segment), slot) in &mut touched {
        *slot = bodies.len();
        bodies.push(ahead(*chain, *segment));
    }
    let touches: Vec<Touch> = contacts
        .iter()
        .map(|contact| {
            let body = touched[&(contact.chain, contact.segment)];
            Touch {
                body,
                partner: match contact.partner {
                    SegmentPartner::Given(velocity) => Partner::Given(velocity),
                    SegmentPartner::Segment { chain, segment } => {
                        Partner::Body(touched[&(chain, segment)])
                    }
                },
                point: contact.point,
                normal: contact.normal,
                tangent: tangent(&bodies[body], &contact.normal),
                closing: closing(contact),
                friction: contact.friction.clone(),
            }
        })
        .collect();
    let before: Vec<Vector6<f64>> = bodies.iter().map(momenta).collect();
    let report = response.collide(&mut bodies, &touches, restitution)?;
    let changes = touched
        .into_keys()
        .zip(bodies.iter().zip(&before))
        .map(|((chain, segment), (body, before))| {
            let change = momenta(body) - before;
            MomentumChange { chain, segment, linear: linear(&change), angular: angular(&change) }
        })
        .collect();
    Ok((changes, report))
}

/// Velocity along the normal at which the two sides of a contact part, m/s.
pub(super) fn parting(chains: &[CylinderChain], contact: &SegmentContact) -> f64 {
    let of = |chain: usize, segment: usize| {
        let segment: &RigidBody = &chains[chain].segments[segment];
        segment.velocity_at(&contact.point)
    };
    let other = match contact.partner {
        SegmentPartner::Given(velocity) => velocity,
        SegmentPartner::Segment { chain, segment } => of(chain, segment),
    };
    contact.normal.dot(&(of(contact.chain, contact.segment) - other))
}

fn momenta(body: &RigidBody) -> Vector6<f64> {
    stack(&(body.mass() * body.velocity), &body.angular_momentum)
}

/// The segment's axis, or where it is along the normal (a tip that touches) another direction.
fn tangent(segment: &RigidBody, normal: &Vector3<f64>) -> Vector3<f64> {
    let axis = segment.pose.rotation * Vector3::z();
    if axis.cross(normal).norm() > 1e-6 * normal.norm() {
        axis
    } else {
        segment.pose.rotation * Vector3::x()
    }
}
