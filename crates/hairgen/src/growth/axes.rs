use crate::HairgenError;
use nalgebra::{Unit, Vector3};

/// How a head stands in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadAxes {
    up: Unit<Vector3<f64>>,
    front: Unit<Vector3<f64>>,
}

impl HeadAxes {
    /// Axes by the direction out of the crown and one in which the face looks (world, of any
    /// length); of the latter the part normal to `up` is taken.
    ///
    /// # Errors
    /// [`HairgenError::HeadAxes`] where one is zero or not finite, or both are parallel.
    pub fn new(up: &Vector3<f64>, front: &Vector3<f64>) -> Result<Self, HairgenError> {
        let refused = HairgenError::HeadAxes { up: (*up).into(), front: (*front).into() };
        let unit = |v: Vector3<f64>, least| Unit::try_new(v, least).filter(|v| v[0].is_finite());
        let (Some(up), Some(front)) = (unit(*up, 0.0), unit(*front, 0.0)) else {
            return Err(refused);
        };
        let level = front.into_inner() - front.dot(&up) * up.into_inner();
        match unit(level, f64::EPSILON.sqrt()) {
            Some(front) => Ok(Self { up, front }),
            None => Err(refused),
        }
    }

    /// Direction out of the crown (world).
    #[must_use]
    pub fn up(&self) -> Unit<Vector3<f64>> {
        self.up
    }

    /// Direction in which the face looks (world), normal to `up`.
    #[must_use]
    pub fn front(&self) -> Unit<Vector3<f64>> {
        self.front
    }

    /// Direction to the person's left (world).
    #[must_use]
    pub fn left(&self) -> Unit<Vector3<f64>> {
        Unit::new_unchecked(self.up.cross(&self.front))
    }
}

impl Default for HeadAxes {
    /// `y` up, the face to `z`, the person's left at `x`.
    fn default() -> Self {
        Self { up: Vector3::y_axis(), front: Vector3::z_axis() }
    }
}
