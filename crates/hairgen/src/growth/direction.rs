//! In which direction hair leaves the scalp.

use super::axes::HeadAxes;
use super::disc_map::DiscMap;
use super::field::DiscField;
use super::geodesic::{geodesic_distances, surface_gradient};
use super::scalp::ScalpMesh;
use super::surface_point::SurfacePoint;
use crate::HairgenError;
use nalgebra::{Point2, Unit, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Tilt from the normal at the top of the head if none is given, rad.
const TOP_TILT: f64 = 20.0 * PI / 180.0;

/// Tilt from the normal at the lowest part of the hairline if none is given, rad.
const LOW_TILT: f64 = 80.0 * PI / 180.0;

/// A part of a direction that is no longer than this has none.
const LEAST_DIRECTION: f64 = 1e-9;

/// The place that hair turns away from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Whorl {
    /// Its middle in the disc; if none is given, the vertex that lies farthest up and back, each as
    /// much as the other.
    pub place: Option<Point2<f64>>,
    /// Angle from straight away to the direction of growth beside the middle, rad,
    /// counter-clockwise seen from outside.
    pub turn: f64,
    /// Distance along the surface over which the angle falls by the factor e, m.
    pub reach: f64,
}

impl Default for Whorl {
    /// Clockwise by 70 degrees, falling over 4 cm. Most whorls are clockwise.
    fn default() -> Self {
        Self { place: None, turn: -70.0 * PI / 180.0, reach: 0.04 }
    }
}

/// To which side hair grows, along the surface.
#[derive(Debug, Clone)]
pub enum GrowthFlow {
    /// Away from a whorl, in a spiral that becomes straight.
    Whorl(Whorl),
    /// By the angle of the direction in the disc, rad, from `x` to `y`.
    Angle(DiscField),
}

/// Direction and tilt over a scalp, ready to be asked.
#[derive(Debug, Clone)]
pub(super) struct GrowthDirection {
    /// Where the whorl is.
    pub(super) crown: SurfacePoint,
    /// Distances along the surface from the crown to the vertices, m.
    distances: Vec<f64>,
    /// Unit vectors at the vertices straight away from the crown (world).
    away: Vec<Vector3<f64>>,
    flow: GrowthFlow,
    tilt: Option<DiscField>,
    /// Heights from the lowest vertex to the highest, between 0 and 1.
    heights: Vec<f64>,
}

impl GrowthDirection {
    pub(super) fn new(
        mesh: &ScalpMesh,
        map: &DiscMap,
        axes: &HeadAxes,
        flow: GrowthFlow,
        tilt: Option<DiscField>,
    ) -> Result<Self, HairgenError> {
        let place = match &flow {
            GrowthFlow::Whorl(Whorl { place, turn, reach }) => {
                if !(turn.is_finite() && *reach > 0.0 && reach.is_finite()) {
                    return Err(HairgenError::Whorl { turn: *turn, reach: *reach });
                }
                *place
            }
            GrowthFlow::Angle(_) => None,
        };
        let along = |direction: Vector3<f64>| {
            mesh.vertices().iter().map(move |p| p.coords.dot(&direction)).collect::<Vec<f64>>()
        };
        let crown = match place {
            Some(place) if place.iter().all(|x| x.is_finite()) => map.locate(&place),
            Some(place) => return Err(HairgenError::Place { place: place.into() }),
            None => mesh.vertex(first_largest(&along(*axes.up() - *axes.front()))),
        };
        let distances = geodesic_distances(mesh, &crown);
        let away = surface_gradient(mesh, &distances);
        let away = away.iter().map(|g| g.try_normalize(LEAST_DIRECTION).unwrap_or_default());
        let heights = along(axes.up().into_inner());
        let far = f64::INFINITY;
        let (low, high) =
            heights.iter().fold((far, -far), |(low, high), &h| (low.min(h), high.max(h)));
        let span = if high > low { high - low } else { 1.0 };
        let heights = heights.iter().map(|h| (h - low) / span).collect();
        let away = away.collect();
        Ok(Self { crown, distances, away, flow, tilt, heights })
    }

    /// The direction of growth at a point of the surface (world).
    pub(super) fn at(
        &self,
        mesh: &ScalpMesh,
        map: &DiscMap,
        point: &SurfacePoint,
    ) -> Result<Unit<Vector3<f64>>, HairgenError> {
        let (place, normal) = (map.place(point), mesh.normal(point));
        let tilt = match &self.tilt {
            Some(tilt) => tilt.checked("tilt from the normal (rad)", &place, [0.0, FRAC_PI_2])?,
            None => {
                let height: f64 = point.mix(self.at_corners(mesh, point, &self.heights));
                let smooth = height * height * (3.0 - 2.0 * height);
                LOW_TILT + smooth * (TOP_TILT - LOW_TILT)
            }
        };
        let flow = match &self.flow {
            GrowthFlow::Whorl(whorl) => {
                let away = level(&point.mix(self.at_corners(mesh, point, &self.away)), &normal);
                let distance: f64 = point.mix(self.at_corners(mesh, point, &self.distances));
                let (sin, cos) = (whorl.turn * (-distance / whorl.reach).exp()).sin_cos();
                cos * away + sin * normal.cross(&away)
            }
            GrowthFlow::Angle(field) => {
                let direction = field.direction(&place);
                if !direction.iter().all(|x| x.is_finite()) {
                    let (what, value) = ("angle of growth (rad)", field.value(&place));
                    let (place, least, most) = (place.into(), f64::MIN, f64::MAX);
                    return Err(HairgenError::DiscValue { what, value, place, least, most });
                }
                let lifted = map.lifted(mesh, point.face(), &direction);
                level(&lifted.try_normalize(0.0).unwrap_or_default(), &normal)
            }
        };
        let (sin, cos) = tilt.sin_cos();
        Ok(Unit::new_normalize(cos * normal.into_inner() + sin * flow))
    }

    /// The values at the corners of the face of a point.
    fn at_corners<T: Copy>(&self, mesh: &ScalpMesh, point: &SurfacePoint, values: &[T]) -> [T; 3] {
        mesh.triangles()[point.face() as usize].map(|v| values[v as usize])
    }
}

/// The unit vector along the part of `direction` normal to `normal`; where there is none, any.
fn level(direction: &Vector3<f64>, normal: &Unit<Vector3<f64>>) -> Vector3<f64> {
    let part = direction - direction.dot(normal) * normal.into_inner();
    part.try_normalize(LEAST_DIRECTION).unwrap_or_else(|| {
        let mut axis = Vector3::zeros();
        axis[normal.iamin()] = 1.0;
        normal.cross(&axis).normalize()
    })
}

/// Index of the first of the largest values.
pub(super) fn first_largest(values: &[f64]) -> u32 {
    let mut best = 0;
    for (k, value) in (0_u32..).zip(values) {
        if *value > values[best as usize] {
            best = k;
        }
    }
    best
}
