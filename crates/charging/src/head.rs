//! What the head does to charges.

use crate::ChargingError;
use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::{DistanceField, Mesh, Soup};
use rapunzel_electrostatics::{
    Accuracy, COULOMB_CONSTANT, ChargedFibers, Condition, ConductingSphere, ConductingSurface,
    Electrostatics, ElectrostaticsError, Fields, Method, Multipole, thesis_repulsion,
};
use rapunzel_scene::{self as scene, ConductorHold, ObjectShape};
use std::fmt;
use std::sync::Arc;

/// Least number of triangles of a conductor; shapes that are shown with fewer are refined.
const TRIANGLES: usize = 2000;

/// The object of a scene that is the head.
#[derive(Clone)]
pub struct HeadGeometry {
    /// Distance to the surface of the head, in its frame.
    pub field: Arc<dyn DistanceField + Send + Sync>,
    /// Pose of the head, which does not change.
    pub pose: Isometry3<f64>,
    /// Surface of the head, in its frame.
    pub surface: Soup,
}

impl fmt::Debug for HeadGeometry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HeadGeometry").field("pose", &self.pose).finish_non_exhaustive()
    }
}

/// The head as far as charge is concerned.
#[derive(Debug, Clone)]
pub(crate) enum HeadModel {
    None,
    /// A conducting ball.
    Ball {
        center: Point3<f64>,
        radius: f64,
        held: ConductorHold,
    },
    /// Any other conductor.
    Surface {
        surface: Arc<ConductingSurface>,
        held: ConductorHold,
    },
    /// The thesis's heuristic: a charge that repels by (4.13), corrected.
    Thesis {
        geometry: HeadGeometry,
        charge: f64,
    },
}

/// What the head does to charges at some points.
pub(crate) struct HeadAction {
    /// Energy of the head with the charges and of the charges in what they induce, J.
    pub(crate) energy: f64,
    /// Forces on the charges (world), N.
    pub(crate) forces: Vec<Vector3<f64>>,
}

/// The charges on a conductor beside other charges.
pub(crate) enum Induced<'a> {
    None,
    /// Image charges: points inside and their charges, C.
    Points(Vec<Point3<f64>>, Vec<f64>),
    /// A surface and the charges of its triangles, C.
    Triangles(&'a ConductingSurface, Vec<f64>),
}

/// What a conductor is like beside other charges.
pub(crate) struct ConductorResponse<'a> {
    pub(crate) induced: Induced<'a>,
    /// Potential of the conductor, V.
    pub(crate) potential: f64,
    /// Energy of the conductor with the other charges, J, less half of theirs in the potential that
    /// it makes.
    energy: f64,
}

impl Induced<'_> {
    /// What they make at `targets` outside.
    pub(crate) fn fields(
        &self,
        targets: &[Point3<f64>],
        accuracy: Accuracy,
    ) -> Result<Fields, ElectrostaticsError> {
        match self {
            Self::None => Ok(Fields {
                potentials: vec![0.0; targets.len()],
                fields: vec![Vector3::zeros(); targets.len()],
            }),
            Self::Points(points, charges) => {
                Multipole { accuracy }.fields(points, charges, targets)
            }
            Self::Triangles(surface, charges) => surface.fields(charges, targets, accuracy),
        }
    }
}

impl HeadModel {
    /// The head of a scene among its objects, of which `geometry` is the head, if it has one.
    ///
    /// # Errors
    /// [`ChargingError::Head`] for a surface that bounds nothing, [`ChargingError::Electrostatics`]
    /// for one whose charges are not found.
    pub(crate) fn new(
        head: &scene::Head,
        objects: &[scene::Object],
        geometry: Option<HeadGeometry>,
    ) -> Result<Self, ChargingError> {
        let Some(geometry) = geometry else { return Ok(Self::None) };
        let (object, held) = match *head {
            scene::Head::None => return Ok(Self::None),
            scene::Head::Thesis { charge, .. } => return Ok(Self::Thesis { geometry, charge }),
            scene::Head::Conductor { object, held } => (object, held),
        };
        let own = &objects[object];
        if let ObjectShape::Ball { radius } = own.shape {
            return Ok(Self::Ball { center: own.position.into(), radius, held });
        }
        let mut surface = geometry.surface;
        surface.vertices.iter_mut().for_each(|vertex| *vertex = geometry.pose * *vertex);
        while own.shape.file().is_none() && surface.triangles.len() < TRIANGLES {
            surface = refined(&surface);
        }
        let refuse = |source: CollisionError| ChargingError::Head { object, source };
        let mesh = Mesh::new(surface).map_err(refuse)?;
        let surface = ConductingSurface::new(&mesh).map_err(ChargingError::electric(0.0))?;
        Ok(Self::Surface { surface: Arc::new(surface), held })
    }

    /// Whether a point (world, m) is in the conductor.
    pub(crate) fn holds(&self, point: &Point3<f64>) -> bool {
        match self {
            Self::None | Self::Thesis { .. } => false,
            Self::Ball { center, radius, .. } => (point - center).norm() <= *radius,
            Self::Surface { surface, .. } => surface.check_outside(&[*point]).is_err(),
        }
    }

    /// The conductor beside `charges` (C) at `points` (world, m) when this share of its own charge
    /// or potential is dealt.
    pub(crate) fn response(
        &self,
        points: &[Point3<f64>],
        charges: &[f64],
        share: f64,
        accuracy: Accuracy,
    ) -> Result<ConductorResponse<'_>, ElectrostaticsError> {
        // By Green's reciprocity the charge that is induced at zero potential is that of the
        // potential of the conductor at 1 V, at the charges.
        let (held, capacity, grounded) = match self {
            Self::None | Self::Thesis { .. } => {
                return Ok(ConductorResponse {
                    induced: Induced::None,
                    potential: 0.0,
                    energy: 0.0,
                });
            }
            Self::Ball { center, radius, held } => {
                let condition = Condition::Potential(0.0);
                let ball = ConductingSphere { center: *center, radius: *radius, condition };
                let (places, images) = ball.images(points, charges)?;
                (held, radius / COULOMB_CONSTANT, Induced::Points(places, images))
            }
            Self::Surface { surface, held } => {
                let potentials = surface.potentials(points, charges, accuracy)?;
                let induced = surface.charges(&potentials, Condition::Potential(0.0))?;
                (held, surface.capacity(), Induced::Triangles(surface, induced))
            }
        };
        let drawn = match &grounded {
            Induced::Points(_, charges) | Induced::Triangles(_, charges) => {
                -charges.iter().sum::<f64>()
            }
            Induced::None => 0.0,
        };
        let (potential, own) = match condition(*held, share) {
            Condition::Potential(potential) => (potential, potential),
            Condition::Charge(charge) => ((charge + drawn) / capacity, charge / capacity),
        };
        let induced = match grounded {
            Induced::Points(places, mut charges) => {
                if let Some(center) = charges.last_mut() {
                    *center += potential * capacity;
                }
                Induced::Points(places, charges)
            }
            Induced::Triangles(surface, mut charges) => {
                crate::anderson::add(&mut charges, potential, surface.unit_charges());
                Induced::Triangles(surface, charges)
            }
            Induced::None => Induced::None,
        };
        Ok(ConductorResponse { induced, potential, energy: 0.5 * own * drawn })
    }

    /// What `fibers` with the nodes at `positions` (world, m) do to each other, beside a surface
    /// when this share of its own charge or potential is dealt.
    pub(crate) fn beside(
        &self,
        fibers: &ChargedFibers,
        positions: &[Point3<f64>],
        share: f64,
    ) -> Result<Electrostatics, ElectrostaticsError> {
        match self {
            Self::Surface { surface, held } => {
                fibers.forces_beside(positions, surface, condition(*held, share))
            }
            _ => fibers.forces(positions),
        }
    }

    /// What any other head does to `charges` (C) at `points` (world, m) when this share of its own
    /// charge or potential is dealt.
    pub(crate) fn act(
        &self,
        points: &[Point3<f64>],
        charges: &[f64],
        share: f64,
        accuracy: Accuracy,
    ) -> Result<HeadAction, ElectrostaticsError> {
        if let Self::Thesis { geometry, charge } = self {
            return thesis(geometry, share * charge, points, charges);
        }
        let ConductorResponse { induced, energy, .. } =
            self.response(points, charges, share, accuracy)?;
        let Fields { potentials, fields } = induced.fields(points, accuracy)?;
        let forces = charges.iter().zip(fields).map(|(q, field)| *q * field).collect();
        Ok(HeadAction { energy: energy + 0.5 * crate::anderson::dot(charges, &potentials), forces })
    }
}

/// What is known of a conductor when this share of what it is held at is dealt.
fn condition(held: ConductorHold, share: f64) -> Condition {
    match held {
        ConductorHold::Potential(potential) => Condition::Potential(share * potential),
        ConductorHold::Charge(charge) => Condition::Charge(share * charge),
    }
}

/// (4.13), corrected.
fn thesis(
    head: &HeadGeometry,
    total: f64,
    points: &[Point3<f64>],
    charges: &[f64],
) -> Result<HeadAction, ElectrostaticsError> {
    let (field, pose) = (&*head.field, head.pose);
    let own: Vec<_> = points.iter().map(|x| pose.inverse_transform_point(x)).collect();
    let forces = thesis_repulsion(field, total, &own, charges)?;
    let energy = own.iter().zip(charges).map(|(x, q)| q / field.value(x)).sum::<f64>();
    Ok(HeadAction {
        energy: COULOMB_CONSTANT * total * energy,
        forces: forces.iter().map(|force| pose * force).collect(),
    })
}

/// The surface with every triangle cut into four.
fn refined(surface: &Soup) -> Soup {
    let mut vertices = surface.vertices.clone();
    let mut known = std::collections::BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *known.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            vertices.push(nalgebra::center(&vertices[a as usize], &vertices[b as usize]));
            #[expect(clippy::cast_possible_truncation, reason = "a few thousand vertices")]
            let index = (vertices.len() - 1) as u32;
            index
        })
    };
    let mut triangles = Vec::with_capacity(4 * surface.triangles.len());
    for &[a, b, c] in &surface.triangles {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    Soup { vertices, triangles }
}
