//! Whether scalp, head and hair stand so that hair can grow.

use super::surfaces::StyleSurfaces;
use crate::HairgenError;
use crate::growth::ScalpMesh;
use nalgebra::Point3;
use rapunzel_collision::field::DistanceField;

/// Height of the hair's surface over the scalp below which there is no room, m.
const LEAST_ROOM: f64 = 1e-3;

/// Distance from the head at which a scalp is none of it, m: more than a wig is thick.
const FARTHEST: f64 = 0.02;

/// The room for hair over a scalp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ScalpRoom {
    /// Part of the scalp's area that is outside of the hair by more than the least room.
    pub(super) bare: f64,
    /// Largest distance of a vertex of the scalp from the surface of the head, m.
    pub(super) off: f64,
}

impl ScalpRoom {
    /// The room over a scalp between its surfaces.
    ///
    /// # Errors
    /// [`HairgenError::ScalpOff`], [`HairgenError::NoRoom`].
    pub(super) fn of(surfaces: &StyleSurfaces, scalp: &ScalpMesh) -> Result<Self, HairgenError> {
        let StyleSurfaces { head_field, hull_field, hull, .. } = surfaces;
        let mut off = 0.0;
        for vertex in scalp.vertices() {
            let distance = head_field.value(vertex).abs();
            if distance > FARTHEST {
                return Err(HairgenError::ScalpOff { distance, place: (*vertex).into() });
            }
            off = f64::max(off, distance);
        }
        let (mut bare, mut highest) = (0.0, f64::NEG_INFINITY);
        for (face, area) in (0..).zip(scalp.areas()) {
            let [a, b, c] = scalp.corners(face);
            let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
            let room = -hull_field.value(&middle);
            highest = f64::max(highest, room);
            bare += if room < -LEAST_ROOM { *area } else { 0.0 };
        }
        let is_outside = |p: &Point3<f64>| head_field.value(p) > LEAST_ROOM;
        if highest <= LEAST_ROOM || !hull.vertices.iter().any(is_outside) {
            return Err(HairgenError::NoRoom { least: LEAST_ROOM });
        }
        Ok(Self { bare: bare / scalp.area(), off })
    }
}
