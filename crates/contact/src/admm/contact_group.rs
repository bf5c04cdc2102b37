//! Eight contacts with all that the method reads of them.

use crate::{Contact, ErrorMasses, LimitCurve, VectorLanes};
use nalgebra::Vector3;
use rapunzel_lanes::LANES;

/// A number for each contact of a group.
pub(super) type ContactNumbers = [f64; LANES];

/// Indices of what belongs to the first point of each contact of a group, and to the second.
pub(super) type SideIndices = [[u32; LANES]; 2];

/// Data of eight contacts that the method reads in every iteration. Lanes that are left are of
/// contacts that bear nothing and stay so.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(super) struct ContactGroup {
    /// Normals and first tangents, world. To find the second tangent anew is less than to read it.
    pub(super) axes: [VectorLanes<f64>; 2],
    /// Given relative velocities in the frames, bias included, m/s.
    pub(super) velocities: VectorLanes<f64>,
    /// Given impulses in the frames, N s.
    pub(super) impulses: VectorLanes<f64>,
    /// Answers of the relative velocities to the contacts' own impulses in the metric, 1/kg.
    pub(super) responses: ContactNumbers,
    /// Masses with which reports compare errors of velocities and of impulses, kg.
    pub(super) weights: ContactNumbers,
    /// What these are multiplied by where errors of impulses are those of heavier bodies too, if
    /// any contact has such.
    pub(super) heavier: Option<Box<ContactNumbers>>,
    /// Points of the contacts.
    pub(super) points: SideIndices,
    /// Sides of the contacts.
    pub(super) sides: SideIndices,
    /// Coefficients of friction, if every contact has the same in all directions.
    pub(super) circles: Option<ContactNumbers>,
    /// Adhesion, N s, and compliance, 1/kg, if any contact has some.
    pub(super) soft: Option<Box<[ContactNumbers; 2]>>,
    /// Ones for contacts that are joints and zeros for others, if any is.
    pub(super) joints: Option<Box<ContactNumbers>>,
}

impl ContactGroup {
    /// A group of at most eight contacts with their given relative `velocities`, m/s, world, and
    /// `impulses`, N s, in their frames; `responses`, 1/kg, and `masses`.
    pub(super) fn new(
        contacts: &[Contact],
        velocities: impl Iterator<Item = Vector3<f64>>,
        impulses: &[Vector3<f64>],
        responses: impl Iterator<Item = f64>,
        masses: impl Iterator<Item = ErrorMasses>,
        [points, sides]: [SideIndices; 2],
    ) -> Self {
        let mut group = Self {
            axes: Default::default(),
            velocities: Default::default(),
            impulses: Default::default(),
            soft: None,
            joints: None,
            responses: [1.0; LANES],
            weights: [1.0; LANES],
            heavier: None,
            circles: Some(Default::default()),
            points,
            sides,
        };
        let given = velocities.zip(impulses);
        let own = responses.zip(masses);
        for (lane, ((contact, given), own)) in contacts.iter().zip(given).zip(own).enumerate() {
            let velocity = contact.frame.tr_mul(&given.0) + contact.bias;
            for k in 0..3 {
                for i in 0..2 {
                    group.axes[i][k][lane] = contact.frame[(k, i)];
                }
                (group.velocities[k][lane], group.impulses[k][lane]) = (velocity[k], given.1[k]);
            }
            if contact.adhesion != 0.0 || contact.compliance != 0.0 {
                let [adhesion, compliance] = &mut **group.soft.get_or_insert_default();
                (adhesion[lane], compliance[lane]) = (contact.adhesion, contact.compliance);
            }
            if contact.is_joint() {
                group.joints.get_or_insert_default()[lane] = 1.0;
            }
            let (response, ErrorMasses { own, moved }) = own;
            (group.responses[lane], group.weights[lane]) = (response, own);
            if moved > own {
                group.heavier.get_or_insert_with(|| Box::new([1.0; LANES]))[lane] = moved / own;
            }
            match (&mut group.circles, &contact.friction) {
                (Some(circles), LimitCurve::Circle { mu }) => circles[lane] = *mu,
                (circles, _) => *circles = None,
            }
        }
        group
    }
}
