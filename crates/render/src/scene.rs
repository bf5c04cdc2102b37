use crate::check::{check, check_light};
use crate::vertex::{PathVertex, VertexScattering};
use crate::{CurveHit, Curves, Lights, MeshHit, Ray, RenderError, TriangleMesh};
use nalgebra::{Matrix3, Vector3};
use rapunzel_scattering::FiberBsdf;

/// How fibres look.
pub enum FiberLook {
    /// They scatter light as hair does.
    Scattering {
        /// The model.
        bsdf: Box<dyn FiberBsdf + Send + Sync>,
        /// A color that says to a denoiser what they are, in `[0, 1]`.
        albedo: Vector3<f64>,
    },
    /// They are matte tubes that show a color at every node, of all fibres one after another, in
    /// `[0, 1]`.
    Colored(Vec<Vector3<f32>>),
}

/// Fibres of one look.
pub struct Hairs {
    /// Their shape.
    pub curves: Curves,
    /// Their look.
    pub look: FiberLook,
}

/// All that is in a picture.
pub struct RenderScene {
    hairs: Vec<Hairs>,
    /// Matte surfaces, with their albedos.
    bodies: Vec<(TriangleMesh, Vector3<f64>)>,
    lights: Lights,
}

/// The first thing on a ray.
#[derive(Debug, Clone, Copy)]
pub(crate) enum SceneHit {
    Fiber(usize, CurveHit),
    Face(usize, MeshHit),
}

impl SceneHit {
    pub(crate) fn distance(&self) -> f64 {
        match self {
            Self::Fiber(_, hit) => hit.distance,
            Self::Face(_, hit) => hit.distance,
        }
    }
}

impl RenderScene {
    /// Fibres, and surfaces with their albedos, red, green and blue, in lights.
    ///
    /// # Errors
    /// [`RenderError::Parameter`] if an albedo is not in `[0, 1]`, or there are not as many colors
    /// as nodes.
    pub fn new(
        hairs: Vec<Hairs>,
        bodies: Vec<(TriangleMesh, Vector3<f64>)>,
        lights: Lights,
    ) -> Result<Self, RenderError> {
        let albedo = |color: &Vector3<f64>| {
            check_light("an albedo", color)?;
            check("an albedo", color.max(), "at most 1", color.max() <= 1.0)
        };
        bodies.iter().try_for_each(|(_, color)| albedo(color))?;
        for Hairs { curves, look } in &hairs {
            match look {
                FiberLook::Scattering { albedo: color, .. } => albedo(color)?,
                FiberLook::Colored(colors) => {
                    let (count, nodes) = (colors.len() as f64, curves.nodes());
                    let must = "that of the nodes of all fibres";
                    check("the number of colors", count, must, colors.len() == nodes)?;
                    colors.iter().try_for_each(|color| albedo(&color.cast()))?;
                }
            }
        }
        Ok(Self { hairs, bodies, lights })
    }

    /// The lights.
    #[must_use]
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// The first thing that a ray meets in a range, m.
    pub(crate) fn hit(&self, ray: &Ray, [start, end]: [f64; 2]) -> Option<SceneHit> {
        let mut end = end;
        let mut nearest = None;
        for (index, (mesh, _)) in self.bodies.iter().enumerate() {
            if let Some(hit) = mesh.hit(ray, [start, end]) {
                (end, nearest) = (hit.distance, Some(SceneHit::Face(index, hit)));
            }
        }
        for (index, hairs) in self.hairs.iter().enumerate() {
            if let Some(hit) = hairs.curves.hit(ray, [start, end]) {
                (end, nearest) = (hit.distance, Some(SceneHit::Fiber(index, hit)));
            }
        }
        nearest
    }

    /// Whether anything is on a ray in a range, m.
    pub(crate) fn hides(&self, ray: &Ray, range: [f64; 2]) -> bool {
        self.bodies.iter().any(|(mesh, _)| mesh.hides(ray, range))
            || self.hairs.iter().any(|hairs| hairs.curves.hides(ray, range))
    }

    /// The vertex of a path that a ray makes where it hits.
    pub(crate) fn vertex(&self, ray: &Ray, hit: &SceneHit) -> PathVertex<'_> {
        match hit {
            SceneHit::Face(index, hit) => {
                let (mesh, albedo) = &self.bodies[*index];
                let point = mesh.at(ray, hit);
                // Rounding of the place is far below, what one sees far above a part in 1e9.
                let clearance = 1e-9 * (1.0 + point.position.coords.amax());
                let scatterer = VertexScattering::Matte {
                    face: point.face,
                    normal: point.normal,
                    albedo: *albedo,
                };
                let (position, fiber) = (point.position, None);
                PathVertex { position, normal: point.normal, clearance, fiber, scatterer }
            }
            SceneHit::Fiber(index, hit) => {
                let Hairs { curves, look } = &self.hairs[*index];
                let point = curves.at(ray, hit);
                let scatterer = match look {
                    FiberLook::Scattering { bsdf, albedo } => {
                        let frame = Matrix3::from_columns(&point.frame);
                        let from = frame.tr_mul(&-ray.direction);
                        let arrival = bsdf.arrive(point.offset, &from);
                        VertexScattering::Fiber {
                            bsdf: bsdf.as_ref(),
                            arrival,
                            frame,
                            albedo: *albedo,
                        }
                    }
                    FiberLook::Colored(colors) => {
                        let albedo = curves.between(&point, colors).cast();
                        VertexScattering::Matte { face: point.normal, normal: point.normal, albedo }
                    }
                };
                // A path goes on from where it came in, and does not come in there again.
                let clearance = 1e-3 * point.radius;
                let (position, fiber) = (point.position, Some(point.fiber));
                PathVertex { position, normal: point.normal, clearance, fiber, scatterer }
            }
        }
    }
}
