//! Objects of a scene as things in the world: their fields, surfaces and masses.

use super::edge_capsules::edge_capsules;
use super::mesh::read_mesh;
use crate::SimError;
use crate::scene::{self, Moves, ObjectMass, ObjectShape};
use crate::style::head_mesh;
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, Vector3};
use rapunzel_collision::field::{Ball, Cuboid, Grid, HalfSpace, Mesh, Soup, Terrain, shapes};
use rapunzel_collision::{Capsule, CollisionError};
use rapunzel_contact::{ContactError, RigidBody};
use rapunzel_coupling::{CollisionObject, Field, FreeBody, ObjectGeometry, ObjectMotion};
use std::f64::consts::PI;
use std::sync::Arc;

/// Parts of an octant of a ball that is shown.
const FINENESS: i32 = 16;
/// How far from fibres, in radii of the thickest, fields of terrains and meshes must be distances:
/// contacts are listed up to three radii. Round objects are seen by their axes.
const REACH: f64 = 8.0;

/// The lengths of what is around an object, m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    /// Length of the longest fibre, m.
    pub(crate) longest: f64,
    /// Radius of the thickest.
    pub(crate) thickest: f64,
    /// Radius of the roundest object, or zero, where objects may touch each other.
    pub(crate) roundest: Option<f64>,
}

impl Sizes {
    /// Up to where fields must be distances, m.
    fn reach(&self) -> f64 {
        REACH * self.thickest + self.roundest.unwrap_or(0.0)
    }

    /// The band of the field of a mesh on a grid, m. Beside the reach, the diagonal of a cell is
    /// lost, and two spacings are the least; more lets objects be faster.
    pub(crate) fn band(&self, spacing: f64) -> f64 {
        let cells = if self.roundest.is_some() { 6.0 } else { 3.0 };
        self.reach() + cells * spacing
    }
}

/// Object number `index` of a scene, `scene`, as it is at the start.
///
/// # Errors
/// [`SimError::Io`] and [`SimError::Mesh`] for a mesh that cannot be read or bounds nothing,
/// [`SimError::Object`] for a field and [`SimError::Body`] for a mass that cannot be made.
pub(crate) fn build_object(
    scene: &scene::Object,
    index: usize,
    around: &Sizes,
) -> Result<CollisionObject, SimError> {
    let start = scene.start();
    let refuse = |source| SimError::Object { object: index, source };
    let (field, surface) = match &scene.shape {
        ObjectShape::Mesh { file, spacing, scale, repair } => {
            let (mesh, _) = read_mesh(index, file, *scale, *repair)?;
            scanned(&mesh, *spacing, around).map_err(refuse)?
        }
        ObjectShape::Head { style, spacing } => {
            scanned(&head_mesh(style)?, *spacing, around).map_err(refuse)?
        }
        shape => solid(shape, around).map_err(refuse)?,
    };
    let motion = match scene.moves {
        Moves::Led => ObjectMotion::Kinematic(Box::new(scene.led_pose())),
        Moves::Free { mass, velocity, spin } => {
            let density = match mass {
                ObjectMass::Density(density) => density,
                ObjectMass::Mass(mass) => mass / volume(&scene.shape, &surface),
            };
            let refuse = |source| SimError::Body { object: index, source };
            let (mut body, center) =
                body(&scene.shape, &surface, density, &start).map_err(refuse)?;
            body.velocity = velocity.into();
            body.set_angular_velocity(&Vector3::from(spin.map(f64::to_radians)));
            ObjectMotion::Dynamic(Box::new(FreeBody::new(body, center)))
        }
    };
    let endless = scene.shape.is_endless();
    let edge_capsules = edge_capsules(&scene.shape, &surface, 2.0 * around.thickest);
    let scene::Object { friction, restitution, .. } = *scene;
    let geometry = ObjectGeometry { field, edge_capsules, surface, endless };
    Ok(CollisionObject::new(geometry, motion, friction, restitution))
}

/// Field and surface of a mesh.
fn scanned(mesh: &Mesh, spacing: f64, around: &Sizes) -> Result<(Field, Soup), CollisionError> {
    let field = Grid::scan(mesh, spacing, around.band(spacing))?;
    let (vertices, triangles) = (mesh.vertices().to_vec(), mesh.triangles().to_vec());
    Ok((Arc::new(field), Soup { vertices, triangles }))
}

/// Field and surface of a shape that is no file. Of a plane a square about the origin is shown,
/// with sides of twice the longest fibre.
fn solid(shape: &ObjectShape, around: &Sizes) -> Result<(Field, Soup), CollisionError> {
    Ok(match shape {
        ObjectShape::Plane { normal } => {
            let normal = Unit::new_normalize(Vector3::from(*normal));
            let square = Soup {
                vertices: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                    .map(|[x, y]| facing(&normal) * Point3::new(x, y, 0.0) * around.longest)
                    .to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
            };
            (Arc::new(HalfSpace { point: Point3::origin(), normal }), square)
        }
        ObjectShape::Ball { radius } => {
            let ball = Ball { center: Point3::origin(), radius: *radius };
            (Arc::new(ball), shapes::sphere(*radius, FINENESS))
        }
        ObjectShape::Capsule { length, radius } => {
            let end = Point3::new(0.0, 0.0, 0.5 * length);
            let mut surface = shapes::sphere(*radius, FINENESS);
            for p in &mut surface.vertices {
                // The equator stays where it is.
                p.z += if p.z == 0.0 { 0.0 } else { end.z.copysign(p.z) };
            }
            (Arc::new(Capsule { start: -end, end, radius: *radius }), surface)
        }
        ObjectShape::Cuboid { sides } => {
            let half = 0.5 * Vector3::from(*sides);
            (Arc::new(Cuboid { half }), shapes::cuboid(half))
        }
        ObjectShape::HeightField { sides, spacing, amplitude, wavelength, seed } => {
            let terrain = Terrain {
                sides: *sides,
                spacing: *spacing,
                amplitude: *amplitude,
                wavelength: *wavelength,
                seed: *seed,
            };
            let field = terrain.field(spacing.max(around.reach()))?;
            let surface = field.surface();
            (Arc::new(field), surface)
        }
        ObjectShape::Mesh { .. } | ObjectShape::Head { .. } => {
            return Err(CollisionError::NoTriangles);
        }
    })
}

/// The rotation that turns the third axis to `normal`.
fn facing(normal: &Unit<Vector3<f64>>) -> Rotation3<f64> {
    Rotation3::rotation_between(&Vector3::z(), normal)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), PI))
}

/// Volume, m^3, of a shape that ends.
fn volume(shape: &ObjectShape, surface: &Soup) -> f64 {
    match shape {
        ObjectShape::Ball { radius } => 4.0 / 3.0 * PI * radius.powi(3),
        ObjectShape::Capsule { length, radius } => {
            PI * radius * radius * (length + 4.0 / 3.0 * radius)
        }
        ObjectShape::Cuboid { sides } => sides.iter().product(),
        _ => moments(surface).0,
    }
}

/// A body of even density, kg/m^3, at rest, and its center of mass in the frame of its shape.
fn body(
    shape: &ObjectShape,
    surface: &Soup,
    density: f64,
    start: &Isometry3<f64>,
) -> Result<(RigidBody, Vector3<f64>), ContactError> {
    let mass = density * volume(shape, surface);
    let body = match shape {
        ObjectShape::Ball { radius } => RigidBody::ball(mass, *radius, *start),
        ObjectShape::Cuboid { sides } => RigidBody::cuboid(mass, Vector3::from(*sides), *start),
        ObjectShape::Capsule { length, radius } => {
            let (h, r) = (*length, *radius);
            let [bar, ends] = [h, 4.0 / 3.0 * r].map(|length| density * PI * r * r * length);
            let along = (0.5 * bar + 0.4 * ends) * r * r;
            let across = bar * (h * h / 12.0 + r * r / 4.0)
                + ends * (0.4 * r * r + 0.25 * h * h + 0.375 * h * r);
            let inertia = Matrix3::from_diagonal(&Vector3::new(across, across, along));
            RigidBody::new(mass, inertia, *start)
        }
        _ => {
            let (volume, center, second) = moments(surface);
            let second = density * (second - volume * center * center.transpose());
            let inertia = Matrix3::from_diagonal_element(second.trace()) - second;
            let inertia = 0.5 * (inertia + inertia.transpose());
            let body = RigidBody::new(mass, inertia, start * Translation3::from(center))?;
            return Ok((body, center));
        }
    };
    Ok((body?, Vector3::zeros()))
}

/// Volume, centroid and second moments (the integral of `x x^T`) of what a closed surface bounds:
/// sums over the tetrahedra between its triangles and the origin.
fn moments(surface: &Soup) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for triangle in &surface.triangles {
        let [a, b, c] = triangle.map(|v| surface.vertices[v as usize].coords);
        let (six, sum) = (a.dot(&b.cross(&c)), a + b + c);
        volume += six / 6.0;
        first += six / 24.0 * sum;
        let products = [a, b, c, sum].map(|x| x * x.transpose());
        second += six / 120.0 * products.iter().sum::<Matrix3<f64>>();
    }
    (volume, first / volume, second)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const AROUND: Sizes = Sizes { longest: 0.1, thickest: 4e-5, roundest: None };

    /// What is shown of a shape bounds what fibres meet, and has its volume and inertia.
    #[test]
    fn surfaces_and_moments_are_those_of_the_shapes() {
        let [length, radius] = [0.05, 0.02];
        for (shape, tolerance) in [
            (ObjectShape::Ball { radius }, 0.02),
            (ObjectShape::Capsule { length, radius }, 0.02),
            (ObjectShape::Cuboid { sides: [0.01, 0.02, 0.04] }, 1e-12),
        ] {
            let (field, surface) = solid(&shape, &AROUND).expect("a solid");
            assert!(surface.vertices.iter().all(|p| field.value(p).abs() < 1e-15), "{shape:?}");
            let (exact, center) =
                body(&shape, &surface, 1e3, &Isometry3::identity()).expect("a body");
            let (volume, centroid, second) = moments(&surface);
            assert_relative_eq!(1e3 * volume, exact.mass(), max_relative = tolerance);
            assert!((centroid - center).norm() < 1e-9, "{shape:?}");
            let inertia = 1e3 * (Matrix3::from_diagonal_element(second.trace()) - second);
            let error = (inertia - exact.inertia()).amax() / exact.inertia().amax();
            assert!(error < 2.0 * tolerance, "{shape:?}: {error}");
        }
    }

    #[test]
    fn a_body_that_is_off_its_origin_is_about_its_center_of_mass() {
        let mut surface = shapes::cuboid(Vector3::new(0.01, 0.02, 0.03));
        let by = Vector3::new(0.1, -0.2, 0.3);
        surface.vertices.iter_mut().for_each(|p| *p += by);
        let (file, scale, repair) = ("box.ply".into(), 1.0, false);
        let shape = ObjectShape::Mesh { file, spacing: 0.01, scale, repair };
        let (body, center) = body(&shape, &surface, 2e3, &Isometry3::identity()).expect("a body");
        assert_relative_eq!(center, by, epsilon = 1e-12);
        let edges = Vector3::new(0.02, 0.04, 0.06);
        let exact = RigidBody::cuboid(2e3 * 4.8e-5, edges, body.pose).expect("a body");
        assert_relative_eq!(body.mass(), exact.mass(), max_relative = 1e-12);
        assert_relative_eq!(body.inertia(), exact.inertia(), epsilon = 1e-9 * 4e-5);
    }
}
