//! Distance fields of surfaces (thesis 7.2), and fibers against them.
//!
//! A field is a function of space whose zero set is the surface: positive outside, negative inside,
//! and near the surface the distance (7.1). What the searches rely on is that it is Lipschitz: it
//! changes over a way by no more than a known constant times its length. So between two samples
//! nothing is missed, which answers the open point of the thesis that a fiber must be sampled.

mod analytic;
mod contact;
mod crossing;
mod exact;
mod feature;
mod grid;
mod height;
mod line;
mod mesh;
mod nearest;
mod obj;
mod ply;
mod polygon;
mod query;
mod repair;
mod scan;
pub mod shapes;
mod stl;
mod terrain;

pub use analytic::{Ball, Cuboid, HalfSpace, LevelSet, Posed};
pub use contact::{ContactSearch, FieldContact};
pub use crossing::SelfCrossing;
pub use exact::{MeshDistance, Shell};
pub use grid::{Grid, GridFrame};
pub use height::HeightField;
pub use mesh::{Mesh, Soup};
pub use nearest::{NearestPoint, SurfaceTree};
pub use obj::{Obj, ObjPolyline};
pub use repair::Repairs;
pub use terrain::Terrain;

use nalgebra::{Point3, Vector3};

/// A field at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Value of the field, m.
    pub value: f64,
    /// Gradient of the value: near the surface about the unit normal that points outward; zero
    /// where the field is clipped or has no gradient.
    pub gradient: Vector3<f64>,
}

/// A signed field of distance.
///
/// Near the surface, up to [`band`](Self::band), the value is the signed distance to within
/// [`error`](Self::error). Farther away it has the right sign and its size is no more than the
/// distance plus the error, but no less than the band: it may be clipped. For any two points the
/// values differ by at most [`lipschitz`](Self::lipschitz) times their distance.
pub trait DistanceField: Sync {
    /// Value and gradient at a point (world).
    fn sample(&self, point: &Point3<f64>) -> Sample;

    /// Value at a point (world), m.
    fn value(&self, point: &Point3<f64>) -> f64 {
        self.sample(point).value
    }

    /// A lower bound of the values on the straight way between two points (world), m, where the
    /// shape knows a better one than what slope and values at both ends tell; minus infinity
    /// elsewhere.
    fn least_between(&self, _start: &Point3<f64>, _end: &Point3<f64>) -> f64 {
        f64::NEG_INFINITY
    }

    /// Bound of the slope of the value.
    fn lipschitz(&self) -> f64 {
        1.0
    }

    /// How much the value may differ from the distance in the band, m; zero for exact fields, up to
    /// rounding.
    fn error(&self) -> f64 {
        0.0
    }

    /// Up to which size the value is the distance, m.
    fn band(&self) -> f64 {
        f64::INFINITY
    }
}

impl<F: DistanceField + ?Sized> DistanceField for &F {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        (**self).sample(point)
    }

    fn value(&self, point: &Point3<f64>) -> f64 {
        (**self).value(point)
    }

    fn least_between(&self, start: &Point3<f64>, end: &Point3<f64>) -> f64 {
        (**self).least_between(start, end)
    }

    fn lipschitz(&self) -> f64 {
        (**self).lipschitz()
    }

    fn error(&self) -> f64 {
        (**self).error()
    }

    fn band(&self) -> f64 {
        (**self).band()
    }
}
