use super::hairline::Hairline;
use super::measures::HeadMeasures;
use super::shape::HeadShape;
use super::volume::HairVolume;
use crate::HairgenError;
use nalgebra::{Point3, Unit, Vector3};
use rapunzel_collision::field::{Soup, shapes};

/// Smallest and largest measure that a head may have, m: from a doll's to a giant's.
const MEASURES: [f64; 2] = [0.02, 1.0];

/// Cells along a side of the cube on which the head is meshed.
const HEAD_CELLS: i32 = 48;

/// A bald head with a neck, from measures.
#[derive(Debug, Clone, PartialEq)]
pub struct ParametricHead {
    shape: HeadShape,
    hairline: Hairline,
}

impl ParametricHead {
    /// The head with these measures and this hairline.
    ///
    /// # Errors
    /// [`HairgenError::Measure`] of a measure that no head has.
    pub fn new(measures: HeadMeasures, hairline: Hairline) -> Result<Self, HairgenError> {
        let named = [
            ("length", measures.length),
            ("breadth", measures.breadth),
            ("height", measures.height),
        ];
        for (what, value) in named {
            // Written so that a value that is no number is refused too.
            if !(MEASURES[0]..=MEASURES[1]).contains(&value) {
                return Err(HairgenError::Measure { what, value });
            }
        }
        Ok(Self { shape: HeadShape::new(measures), hairline })
    }

    /// The surface of the head along a direction from the origin (head frame), m.
    #[must_use]
    pub fn surface(&self, direction: &Unit<Vector3<f64>>) -> Point3<f64> {
        self.shape.reach(&Point3::origin(), direction)
    }

    /// The closed surface of the head, of some 18,000 triangles.
    #[must_use]
    pub fn mesh(&self) -> Soup {
        let mut soup = shapes::sphere(1.0, HEAD_CELLS);
        for vertex in &mut soup.vertices {
            *vertex = self.surface(&Unit::new_normalize(vertex.coords));
        }
        soup
    }

    /// The part of the surface within the hairline, a disc of triangles: `around` sectors about the
    /// middle of the scalp, each of `rings` cells.
    ///
    /// # Errors
    /// [`HairgenError::Resolution`] of fewer than 3 sectors or 1 ring.
    pub fn scalp(&self, around: u32, rings: u32) -> Result<Soup, HairgenError> {
        self.hairline.disc(around, rings, |direction| self.surface(direction))
    }

    /// The surface of head and hair together, closed, as a scan would show it.
    ///
    /// # Errors
    /// [`HairgenError::Measure`] of a volume with impossible measures.
    pub fn hull(&self, volume: &HairVolume) -> Result<Soup, HairgenError> {
        volume.surface(&self.shape, &self.hairline)
    }

    /// The hairline.
    #[must_use]
    pub fn hairline(&self) -> &Hairline {
        &self.hairline
    }
}
