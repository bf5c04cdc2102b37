use super::Light;
use super::cone::in_cone;
use crate::check::{check, check_light, check_point, check_positive, unit};
use crate::{PathRandom, Ray, RenderError};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A light that was checked, with what is computed of it once.
#[derive(Debug, Clone)]
pub(super) enum Emitter {
    Rectangle {
        center: Point3<f64>,
        half_edges: [Vector3<f64>; 2],
        /// Their dual basis in the plane.
        duals: [Vector3<f64>; 2],
        /// The side to which it shines.
        normal: Vector3<f64>,
        area: f64,
        radiance: Vector3<f64>,
    },
    Sphere {
        center: Point3<f64>,
        radius: f64,
        radiance: Vector3<f64>,
    },
    /// The cosine of the angular radius falls short of 1 by `gap`.
    Disc {
        toward: Vector3<f64>,
        gap: f64,
        radiance: Vector3<f64>,
    },
    /// A single direction.
    Beam {
        toward: Vector3<f64>,
        irradiance: Vector3<f64>,
    },
    Point {
        position: Point3<f64>,
        intensity: Vector3<f64>,
    },
}

/// What is seen of an emitter in a direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// How far away it is, m.
    pub(super) distance: f64,
    pub(super) radiance: Vector3<f64>,
    /// Density with which [`Emitter::draw`] draws the direction, per sr.
    pub(super) density: f64,
}

/// Light from a single direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Delta {
    pub(super) direction: Vector3<f64>,
    pub(super) distance: f64,
    /// Of a plane across the direction.
    pub(super) irradiance: Vector3<f64>,
}

impl Emitter {
    pub(super) fn new(light: &Light) -> Result<Self, RenderError> {
        const RADIANCE: &str = "the radiance of a light (W/(m^2 sr))";
        match *light {
            Light::Rectangle { center, half_edges, radiance } => {
                check_point("a coordinate of a light (m)", &center)?;
                check_light(RADIANCE, &radiance)?;
                let [a, b] = half_edges;
                let cross = a.cross(&b);
                let area = 4.0 * cross.norm();
                check_positive("the area of a light (m^2)", area)?;
                let normal = unit("the area of a light (m^2)", &cross)?;
                let height = 0.25 * area;
                let duals = [b.cross(&normal) / height, normal.cross(&a) / height];
                Ok(Self::Rectangle { center, half_edges, duals, normal, area, radiance })
            }
            Light::Sphere { center, radius, radiance } => {
                check_point("a coordinate of a light (m)", &center)?;
                check_positive("the radius of a light (m)", radius)?;
                check_light(RADIANCE, &radiance)?;
                Ok(Self::Sphere { center, radius, radiance })
            }
            Light::Distant { toward, irradiance, angular_radius } => {
                let toward = unit("the largest component of the direction to a light", &toward)?;
                check_light("the irradiance of a light (W/m^2)", &irradiance)?;
                if angular_radius == 0.0 {
                    return Ok(Self::Beam { toward, irradiance });
                }
                let allowed = (1e-6..=FRAC_PI_2).contains(&angular_radius);
                let must = "0 or in [1e-6, pi/2]";
                check("the angular radius of a light (rad)", angular_radius, must, allowed)?;
                let radiance = irradiance / (PI * angular_radius.sin().powi(2));
                check_light(RADIANCE, &radiance)?;
                let gap = 2.0 * (0.5 * angular_radius).sin().powi(2);
                Ok(Self::Disc { toward, gap, radiance })
            }
            Light::Point { position, intensity } => {
                check_point("a coordinate of a light (m)", &position)?;
                check_light("the intensity of a light (W/sr)", &intensity)?;
                Ok(Self::Point { position, intensity })
            }
        }
    }

    /// A direction in which it can be seen; `None` where it cannot, or has a single one.
    pub(super) fn draw(&self, from: &Point3<f64>, random: &mut PathRandom) -> Option<Vector3<f64>> {
        match self {
            Self::Rectangle { center, half_edges: [a, b], normal, .. } => {
                let [u, v] = random.pair().map(|x| 2.0 * x - 1.0);
                let to = center + a * u + b * v - from;
                if to.dot(normal) < 0.0 { to.try_normalize(0.0) } else { None }
            }
            Self::Sphere { center, radius, .. } => {
                let to = center - from;
                let gap = sphere_gap(radius * radius / to.norm_squared())?;
                Some(in_cone(&to.normalize(), gap, random.pair()))
            }
            Self::Disc { toward, gap, .. } => Some(in_cone(toward, *gap, random.pair())),
            Self::Beam { .. } | Self::Point { .. } => None,
        }
    }

    /// What a ray meets of it.
    pub(super) fn seen(&self, ray: &Ray) -> Option<Seen> {
        match self {
            Self::Rectangle { center, duals, normal, area, radiance, .. } => {
                let cosine = -normal.dot(&ray.direction);
                let distance = normal.dot(&(ray.origin - center)) / cosine;
                let place = ray.at(distance) - center;
                let inside = duals.iter().all(|dual| dual.dot(&place).abs() <= 1.0);
                let density = distance * distance / (area * cosine);
                let is_seen = cosine > 0.0 && distance > 0.0 && inside && density.is_finite();
                is_seen.then_some(Seen { distance, radiance: *radiance, density })
            }
            Self::Sphere { center, radius, radiance } => {
                let (to, square) = (center - ray.origin, radius * radius);
                let along = to.dot(&ray.direction);
                let under_root = square - (to - ray.direction * along).norm_squared();
                let far = to.norm_squared();
                let gap = sphere_gap(square / far)?;
                // The nearer root, without a difference of neighbors.
                (along > 0.0 && under_root >= 0.0).then(|| Seen {
                    distance: (far - square) / (along + under_root.sqrt()),
                    radiance: *radiance,
                    density: 1.0 / (TAU * gap),
                })
            }
            Self::Disc { .. } => self.beyond(&ray.direction),
            Self::Beam { .. } | Self::Point { .. } => None,
        }
    }

    /// What is seen of a distant light in a direction.
    pub(super) fn beyond(&self, direction: &Vector3<f64>) -> Option<Seen> {
        let Self::Disc { toward, gap, radiance } = self else { return None };
        let inside = (direction - toward).norm_squared() <= 2.0 * gap;
        let density = 1.0 / (TAU * gap);
        inside.then_some(Seen { distance: f64::INFINITY, radiance: *radiance, density })
    }

    /// The light that comes from it in a single direction, if it does.
    pub(super) fn delta(&self, from: &Point3<f64>) -> Option<Delta> {
        match self {
            Self::Beam { toward, irradiance } => {
                Some(Delta { direction: *toward, distance: f64::INFINITY, irradiance: *irradiance })
            }
            Self::Point { position, intensity } => {
                let to = position - from;
                let direction = to.try_normalize(0.0)?;
                let irradiance = intensity / to.norm_squared();
                let finite = irradiance.iter().all(|x| x.is_finite());
                finite.then_some(Delta { direction, distance: to.norm(), irradiance })
            }
            Self::Rectangle { .. } | Self::Sphere { .. } | Self::Disc { .. } => None,
        }
    }
}

/// By what the cosine of the angle under which the radius of a sphere is seen falls short of 1;
/// `None` from inside.
fn sphere_gap(sine_squared: f64) -> Option<f64> {
    let gap = sine_squared / (1.0 + (1.0 - sine_squared).sqrt());
    (sine_squared < 1.0 && gap > 1e-300).then_some(gap)
}
