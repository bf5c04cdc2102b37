//! Kinematic chains, thesis 8.5: a fiber as rigid cylinders joined at their ends, held together by
//! impulses, with springs for bending and torsion, in harmony with contacts (Alg. 7).
//!
//! A joint `j` is between the segments `k` (towards the root) and `l` (towards the tip); its
//! impulse `P_j = (p, L*)` acts on `k`, and `-P_j` on `l`. A held root is a joint between a wall
//! and segment 0. A step of length `dt` takes every segment to
//!
//! ```text
//! x' = x + dt w,           w = v + (p + c)/m + dt f/(2m)                           (8.78), (8.87)
//! R' = exp[dt w_R] R,      w_R = omega + I^-1 (L + c_L) + dt/2 alpha               (8.80), (8.87)
//! ```
//!
//! with `p`, `L` the sums of its joints' impulses, `c`, `c_L` those of its contacts and
//! `alpha = I^-1 (l - omega x I omega)`. Momenta are the state, so that they are kept to rounding,
//! and the corrected turn is that of a free cylinder, exact however fast it spins:
//!
//! ```text
//! R' = exp[dt h/I_1] R exp[dt (1/I_3 - 1/I_1) h_3 e_3],    h = I omega + L + c_L
//! ```
//!
//! The scheme is a leapfrog: velocities between steps are those after the step's forces, half a
//! step of them ahead of the mean velocity `w`. Where the errata correct the print, the corrected
//! text is meant; see [`ChainForm`].

mod collision_matrix;
mod contacts;
mod harmonize;
mod joints;
mod link;
mod springs;
mod tridiagonal;

pub use collision_matrix::collision_matrix;
pub use contacts::{SegmentContact, SegmentPartner};
pub use harmonize::{HarmonizationReport, LastWord, Settings, step};
pub use springs::{Coupling, JointSprings};

use crate::thesis::projection::Form;
use crate::{ContactError, RigidBody};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;

/// Method by which a chain's joints are closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum JointMethod {
    /// Method I, 8.5.1: the impulses after which the joints are closed at the end of the step, by
    /// Newton's method on all joints together. No drift.
    #[default]
    ImpulseCorrection,
    /// Method II, 8.5.2: one linear solve with the matrix (8.98) for the predicted gaps. The error
    /// is of third order in the turn of a step and does not add up, since it is part of the next
    /// gap.
    Linearized,
}

/// Places where the chain can follow the print or its corrections.
///
/// Not to be switched: the printed sum of norms (8.86), (8.89) is one equation a joint for three or
/// six unknowns and has no derivative where it is solved, so that Newton's method does not apply;
/// the printed collision matrix (8.96) has no inverse, see [`collision_matrix`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChainForm {
    /// (8.80). Printed: `alpha = I^-1 l`. Corrected: with the gyroscopic term, in closed form.
    pub gyroscopic: Form,
    /// (8.87). Printed: the impulses act on the segment towards the tip with the wrong sign in the
    /// equations whose root is sought, so that applying them opens the joint. Corrected: outward
    /// joints plus, inward joints minus.
    pub signs: Form,
    /// (8.102) to (8.104) and after. Printed: the rates' difference is an angle and not a
    /// curvature, in two frames, and the natural curvature is taken off in every step. Corrected:
    /// `kappa = log(R_k^T R_l) / ds`. Of effect for [`Coupling::Explicit`] alone.
    pub curvature: Form,
    /// Alg. 7 with Alg. 6. Printed: contacts act half way, on the velocity after all forces, so
    /// that the joints' impulses carry a segment half a step into what it lies on, in every step.
    /// Corrected (not in the errata): contacts act from the start of the step as the joints do, and
    /// it is the mean velocity `w` that must not close the gap.
    pub contact_time: Form,
    /// Restitution in Alg. 7. Printed: that of Alg. 6, of the velocity that contacts find, with
    /// which the joints' impulses also close what is open: it is reflected, and opens them further.
    /// Corrected (not in the errata): of the velocity at the start of the step, contact by contact;
    /// with friction that has no bound on the energy of several oblique contacts.
    pub rebound: Form,
}

impl From<Form> for ChainForm {
    fn from(form: Form) -> Self {
        Self { gyroscopic: form, signs: form, curvature: form, contact_time: form, rebound: form }
    }
}

/// Support of the root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Root {
    /// No support.
    Free,
    /// A hinge at this point (world) at the end of the next step.
    Hinged(Point3<f64>),
    /// A hinge at this pose's origin, with the springs of the first joint between the pose's frame
    /// (third axis along the fiber) and segment 0.
    Clamped(Isometry3<f64>),
}

/// A fiber as rigid cylinders joined at their ends. The third axis of a segment's frame points to
/// the tip.
#[derive(Debug, Clone, PartialEq)]
pub struct CylinderChain {
    /// Segments, root to tip.
    pub(crate) segments: Vec<RigidBody>,
    /// Half the lengths of the segments, m.
    pub(crate) half_lengths: Vec<f64>,
    pub(crate) root: Root,
    pub(crate) springs: Option<JointSprings>,
    /// Curvature as the printed rule carries it along, 1/m, per joint.
    pub(crate) printed_curvature: Vec<Vector3<f64>>,
}

impl CylinderChain {
    /// A chain at rest through `nodes` (world, root to tip) of a round fiber of `linear_density`
    /// (kg/m) and `radius` (m). Frames are carried along without twist from `first_axis`, made
    /// orthogonal to the first segment.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for fewer than two nodes, segments without length, segments that
    /// turn back on themselves, or numbers that are not positive.
    pub fn new(
        nodes: &[Point3<f64>],
        linear_density: f64,
        radius: f64,
        first_axis: &Vector3<f64>,
        root: Root,
    ) -> Result<Self, ContactError> {
        let invalid = |what, value, why| Err(ContactError::Invalid { what, value, why });
        if nodes.len() < 2 {
            return invalid("number of a chain's nodes", nodes.len() as f64, "must be at least 2");
        }
        if !(radius > 0.0 && radius.is_finite()) {
            return invalid("radius of a chain", radius, "must be > 0 m");
        }
        let (mut segments, mut half_lengths) = (Vec::new(), Vec::new());
        let mut frame: Option<Rotation3<f64>> = None;
        for ends in nodes.windows(2) {
            let along = ends[1] - ends[0];
            let length = along.norm();
            let turned = match frame {
                Some(frame) => so3::between(&(frame * Vector3::z()), &along).map(|r| r * frame),
                None => first_frame(first_axis, &along),
            };
            let Some(rotation) = turned.filter(|_| length > 0.0 && length.is_finite()) else {
                return invalid(
                    "length of a chain's segment",
                    length,
                    "must be > 0 m, and no segment may turn back or lie along the first axis",
                );
            };
            frame = Some(rotation);
            let pose = Isometry3::from_parts(
                Translation3::from(ends[0].coords + 0.5 * along),
                UnitQuaternion::from_rotation_matrix(&rotation),
            );
            segments.push(RigidBody::cylinder(linear_density * length, radius, length, pose)?);
            half_lengths.push(0.5 * length);
        }
        let printed_curvature = vec![Vector3::zeros(); segments.len()];
        Ok(Self { segments, half_lengths, root, springs: None, printed_curvature })
    }

    /// This chain with `springs` in the joints.
    ///
    /// # Errors
    /// [`ContactError::Length`] if there is not one natural curvature per joint,
    /// [`ContactError::Invalid`] for stiffnesses that are not positive.
    pub fn with_springs(mut self, springs: JointSprings) -> Result<Self, ContactError> {
        springs.check(self.joints())?;
        self.springs = Some(springs);
        Ok(self)
    }

    /// This chain with moments of inertia about the segments' axes that are `share` of those
    /// across, in place of a cylinder's `6 r^2 / (3 r^2 + l^2)`, a thousandth for hairs.
    ///
    /// Friction at the surface spins cylinders as thin as that by radians in a step, and springs
    /// then find their twist torn where contacts have the last word. Torsional waves are far
    /// quicker than steps; heavier axes slow them down and change no equilibrium.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for a share that is not positive.
    pub fn with_axial_moments(mut self, share: f64) -> Result<Self, ContactError> {
        if !(share > 0.0 && share.is_finite()) {
            let (what, why) = ("share of a segment's axial moment", "must be > 0");
            return Err(ContactError::Invalid { what, value: share, why });
        }
        for segment in &mut self.segments {
            let first = segment.pose.rotation * Vector3::x();
            let across = first.dot(&(segment.inertia() * first));
            let moments = across * Vector3::new(1.0, 1.0, share);
            let (velocity, omega) = (segment.velocity, segment.angular_velocity());
            let inertia = Matrix3::from_diagonal(&moments);
            *segment = RigidBody::new(segment.mass(), inertia, segment.pose)?;
            segment.velocity = velocity;
            segment.set_angular_velocity(&omega);
        }
        Ok(self)
    }

    /// Support of the root.
    #[must_use]
    pub fn root(&self) -> Root {
        self.root
    }

    /// Holds the root otherwise, or moves it: the next step takes the chain there.
    ///
    /// # Errors
    /// [`ContactError::Length`] for a chain with springs whose root was free and would be held, or
    /// the other way around: it has another number of joints then.
    pub fn set_root(&mut self, root: Root) -> Result<(), ContactError> {
        let before = std::mem::replace(&mut self.root, root);
        match self.springs.as_ref().map_or(Ok(()), |springs| springs.check(self.joints())) {
            Ok(()) => Ok(()),
            Err(error) => {
                self.root = before;
                Err(error)
            }
        }
    }

    /// Segments, root to tip.
    #[must_use]
    pub fn segments(&self) -> &[RigidBody] {
        &self.segments
    }

    /// The segments, to set their velocities. Moving them opens joints, which the next step closes.
    pub fn segments_mut(&mut self) -> &mut [RigidBody] {
        &mut self.segments
    }

    /// Number of joints, a held root among them.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.segments.len() - usize::from(self.root == Root::Free)
    }

    /// The two ends of segment `i` (of `segments()`, as in a slice), towards the root and towards
    /// the tip, world, m.
    #[must_use]
    pub fn ends(&self, i: usize) -> [Point3<f64>; 2] {
        let (segment, half) = (&self.segments[i], self.half_lengths[i]);
        [-half, half].map(|z| segment.pose * Point3::new(0.0, 0.0, z))
    }

    /// The widest gap of a joint, (8.77), m, and the joint's index.
    #[must_use]
    pub fn widest_gap(&self) -> (f64, usize) {
        let root = match self.root {
            Root::Free => None,
            Root::Hinged(point) => Some(point),
            Root::Clamped(pose) => Some(pose.translation.vector.into()),
        };
        let outward = root.into_iter().chain((0..self.segments.len()).map(|i| self.ends(i)[1]));
        let first = usize::from(self.root == Root::Free);
        let inward = (first..self.segments.len()).map(|i| self.ends(i)[0]);
        outward
            .zip(inward)
            .enumerate()
            .map(|(joint, (a, b))| ((a - b).norm(), joint))
            .fold((0.0, 0), |widest, gap| if gap.0 > widest.0 { gap } else { widest })
    }

    /// The poses half a step of `dt` ahead, `q + dt/2 u`, at which the printed Alg. 6 asks for
    /// contacts.
    #[must_use]
    pub fn half_way(&self, dt: f64) -> Vec<Isometry3<f64>> {
        self.segments.iter().map(|segment| half_way(segment, dt).pose).collect()
    }
}

/// `segment` half a step of `dt` ahead.
pub(crate) fn half_way(segment: &RigidBody, dt: f64) -> RigidBody {
    let mut ahead = segment.clone();
    ahead.drift(&segment.velocity, &segment.angular_velocity(), 0.5 * dt);
    ahead
}

fn first_frame(axis: &Vector3<f64>, along: &Vector3<f64>) -> Option<Rotation3<f64>> {
    let tangent = along.try_normalize(0.0)?;
    let first = (axis - tangent * tangent.dot(axis)).try_normalize(1e-9 * axis.norm())?;
    Some(Rotation3::from_basis_unchecked(&[first, tangent.cross(&first), tangent]))
}
