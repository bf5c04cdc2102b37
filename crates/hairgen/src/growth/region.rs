//! The scalp with all that is said about its hair.

use super::axes::HeadAxes;
use super::blue_noise::progressive;
use super::direction::{GrowthDirection, GrowthFlow, Whorl, first_largest};
use super::disc_map::DiscMap;
use super::field::DiscField;
use super::geodesic::geodesic_distances;
use super::mass::Mass;
use super::scalp::ScalpMesh;
use super::surface_point::SurfacePoint;
use super::weights::ConvexWeights;
use crate::{HairgenError, Pore};
use nalgebra::{Point2, Point3};
use rayon::prelude::*;

/// Hairs per m^2 of scalp: 192 +- 12 per cm^2 (thesis 2.3.5, of Pecoraro and Astore 1990).
pub const SPARSE_DENSITY: f64 = 1.92e6;

/// Hairs per m^2 of scalp: 340 +- 76 per cm^2 (thesis 2.3.5, of Orfanos and Brueckmann 1982).
pub const DENSE_DENSITY: f64 = 3.4e6;

/// Points at most of which pores are chosen.
const MOST_PLACES: usize = 1_000_000;

/// Shortest and longest hair, m: from stubble on.
pub(crate) const LENGTHS: [f64; 2] = [1e-4, 10.0];

/// Smallest and largest scalp, m: in meters, and neither in inches nor smaller units.
const SIZES: [f64; 2] = [1e-3, 10.0];

/// What grows where.
#[derive(Debug, Clone)]
pub struct GrowthOptions {
    /// How the head stands.
    pub axes: HeadAxes,
    /// How the scalp is mapped to the disc.
    pub weights: ConvexWeights,
    /// Hairs per m^2 of scalp; not negative.
    pub density: DiscField,
    /// Length of the hairs, m, from 0.1 mm to 10 m.
    pub length: DiscField,
    /// To which side they grow.
    pub flow: GrowthFlow,
    /// Angle from the normal to the direction of growth, rad, from 0 to a right angle. If none is
    /// given, 20 degrees at the top of the scalp and 80 at its lowest point, smoothly by height:
    /// at temples and neck hair lies flat (thesis 5.3.2).
    pub tilt: Option<DiscField>,
}

impl Default for GrowthOptions {
    /// Hair of 20 cm at [`SPARSE_DENSITY`], from a whorl.
    fn default() -> Self {
        Self {
            axes: HeadAxes::default(),
            weights: ConvexWeights::default(),
            density: DiscField::Constant(SPARSE_DENSITY),
            length: DiscField::Constant(0.2),
            flow: GrowthFlow::Whorl(Whorl::default()),
            tilt: None,
        }
    }
}

/// A scalp in the unit disc, with density, length and direction of its hair (thesis 5.3.2).
#[derive(Debug, Clone)]
pub struct GrowthRegion {
    mesh: ScalpMesh,
    map: DiscMap,
    density: DiscField,
    length: DiscField,
    direction: GrowthDirection,
    mass: Mass,
    heights: Vec<f64>,
}

impl GrowthRegion {
    /// Maps the scalp, counts its hairs and lays out the directions. Cost: that of the map.
    ///
    /// # Errors
    /// [`HairgenError::Size`], those of [`DiscMap::new`], [`HairgenError::DiscValue`] for a
    /// density that is negative or not finite, [`HairgenError::Whorl`], [`HairgenError::Place`].
    pub fn new(mesh: ScalpMesh, options: GrowthOptions) -> Result<Self, HairgenError> {
        let GrowthOptions { axes, weights, density, length, flow, tilt } = options;
        let (size, [least, most]) = (mesh.size(), SIZES);
        if !(least..=most).contains(&size) {
            return Err(HairgenError::Size { what: "the scalp", size, least, most });
        }
        let map = DiscMap::new(&mesh, weights, &axes)?;
        let direction = GrowthDirection::new(&mesh, &map, &axes, flow, tilt)?;
        let mass = Mass::new(&mesh, &map, &density)?;
        let down: Vec<f64> = mesh.vertices().iter().map(|p| -p.coords.dot(&axes.up())).collect();
        let heights = geodesic_distances(&mesh, &mesh.vertex(first_largest(&down)));
        let highest = heights.iter().fold(0.0, |most: f64, h| h.max(most));
        let heights = heights.iter().map(|h| h / highest).collect();
        Ok(Self { mesh, map, density, length, direction, mass, heights })
    }

    /// The scalp.
    #[must_use]
    pub fn mesh(&self) -> &ScalpMesh {
        &self.mesh
    }

    /// The scalp in the disc.
    #[must_use]
    pub fn map(&self) -> &DiscMap {
        &self.map
    }

    /// The crown: the middle of the whorl, or, where directions are given, the vertex farthest up
    /// and back.
    #[must_use]
    pub fn crown(&self) -> SurfacePoint {
        self.direction.crown
    }

    /// Number of hairs: the integral of their density over the scalp, rounded. It is summed over
    /// pieces of a triangle within which the density is about linear: half a pixel of an image.
    #[must_use]
    pub fn count(&self) -> usize {
        self.mass.count()
    }

    /// Geodesic height at a place of the disc (thesis 5.3.3, where it is not defined): the distance
    /// along the surface from the lowest vertex, at the neck, in parts of the largest one. At the
    /// forehead it is about 1.
    #[must_use]
    pub fn geodesic_height(&self, place: &Point2<f64>) -> f64 {
        let point = self.map.locate(place);
        let triangle = self.mesh.triangles()[point.face() as usize];
        point.mix(triangle.map(|v| self.heights[v as usize]))
    }

    /// `count` pores in proportion to the density, spread evenly and at random (blue noise), the
    /// same for the same seed. [`count`](Self::count) of them have the density itself. The first
    /// ones of them, however many, are spread evenly too, in proportion to the density: they can
    /// take the guides.
    ///
    /// Points are spread over all the scalp at the largest density, in an order of which any first
    /// part is even; every point is kept where its rank in that order is less than the share that
    /// the density here has of the largest. Cost: `n log n` of that many points.
    ///
    /// # Errors
    /// [`HairgenError::Bald`], [`HairgenError::TooManyPores`], and [`HairgenError::DiscValue`] for
    /// a length below 0.1 mm or above 10 m, or a tilt out of its range.
    pub fn pores(&self, count: usize, seed: u64) -> Result<Vec<Pore>, HairgenError> {
        let chosen = self.places(count, seed)?;
        // Of several errors the first is told, not that of the fastest thread.
        let pores: Vec<_> = chosen.par_iter().map(|point| self.pore(point)).collect();
        pores.into_iter().collect()
    }

    /// The pore at the point of the scalp that is nearest to a point (world).
    ///
    /// # Errors
    /// [`HairgenError::DiscValue`] as for [`pores`](Self::pores).
    pub fn pore_near(&self, point: &Point3<f64>) -> Result<Pore, HairgenError> {
        self.pore(&self.mesh.nearest(point))
    }

    fn pore(&self, point: &SurfacePoint) -> Result<Pore, HairgenError> {
        let disc = self.map.place(point);
        Ok(Pore {
            position: self.mesh.position(point),
            normal: self.mesh.normal(point),
            direction: self.direction.at(&self.mesh, &self.map, point)?,
            length: self.length.checked("length (m)", &disc, LENGTHS)?,
            disc,
        })
    }

    /// Points of the surface in proportion to the density.
    fn places(&self, count: usize, seed: u64) -> Result<Vec<SurfacePoint>, HairgenError> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let share = self.mass.share();
        if share == 0.0 {
            return Err(HairgenError::Bald { count });
        }
        // Some more than needed, since how many fall where the density is high is not exact; very
        // few may all miss a small spot.
        let mut wanted = 1.02 * (count as f64 / share) + 8.0;
        loop {
            if wanted > MOST_PLACES as f64 {
                return Err(HairgenError::TooManyPores { count, most: MOST_PLACES });
            }
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
            let all = progressive(&self.mesh, wanted as usize, seed);
            let order = |(rank, point): (usize, SurfacePoint)| {
                let density = self.density.value(&self.map.place(&point));
                (rank as f64 / density, point)
            };
            let mut ranked: Vec<_> = all.into_iter().enumerate().map(order).collect();
            ranked.retain(|(rank, _)| rank.is_finite());
            if ranked.len() >= count {
                ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
                return Ok(ranked.into_iter().take(count).map(|(_, point)| point).collect());
            }
            wanted *= 2.0;
        }
    }
}
