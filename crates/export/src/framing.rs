//! Where a picture of everything is taken from.

use crate::surface::Placed;
use crate::{ExportError, Frame, surface};
use nalgebra::{Point3, Vector3};

/// A ball around all that is seen, with camera and lamp away from it.
pub(crate) struct Framing {
    /// Centre of the ball (world), m.
    pub(crate) middle: Point3<f64>,
    /// Place of the camera (world), m: from there the ball takes in 24 degrees.
    pub(crate) eye: Point3<f64>,
    /// Place of the lamp (world), m.
    pub(crate) lamp: Point3<f64>,
    /// Radius of the ball, m.
    pub(crate) radius: f64,
}

impl Framing {
    /// Checks a frame and objects and looks at them.
    ///
    /// # Errors
    /// Refuses invalid and empty frames, and surfaces that are not finite.
    pub(crate) fn of(frame: &Frame, objects: &[Placed]) -> Result<Self, ExportError> {
        frame.validate()?;
        objects.iter().try_for_each(|object| surface::check(&object.surface))?;
        let fibers = frame.strands.iter().flat_map(|strand| &strand.points);
        let first = *fibers.clone().next().ok_or(ExportError::Empty)?;
        let points = fibers.chain(objects.iter().flat_map(|object| &object.surface.vertices));
        let [low, high] = points.fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]);
        let middle = nalgebra::center(&low, &high);
        // No smaller than a millimetre, so that there is something to be away from.
        let radius = (0.5 * (high - low).norm()).max(1e-3);
        let eye = middle + 5.0 * radius * Vector3::new(0.3, -0.9, 0.3);
        let lamp = middle + 5.0 * radius * Vector3::new(-1.0, -1.0, 2.0);
        Ok(Self { middle, eye, lamp, radius })
    }
}
