use super::ExportError;
use nalgebra::{Point3, Rotation3, Vector3};

/// State of all fibres at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Number of the frame in its series, from 0.
    pub index: usize,
    /// Simulated time, s.
    pub time: f64,
    /// The fibres, one strand each.
    pub strands: Vec<Strand>,
}

/// One fibre at one instant: `n + 1` points and `n >= 1` segments between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Strand {
    /// Nodes of the centerline (world), m.
    pub points: Vec<Point3<f64>>,
    /// Radii at the points, m.
    pub radii: Vec<f64>,
    /// Velocity of the points (world), m/s.
    pub velocities: Vec<Vector3<f64>>,
    /// Material frame of each segment; its columns are d1, d2 and the tangent d3 (world).
    pub frames: Vec<Rotation3<f64>>,
    /// Darboux vector at the points (material frame), 1/m.
    pub curvatures: Vec<Vector3<f64>>,
    /// Internal force of each segment (world), N; its part along the tangent is the tension.
    pub forces: Vec<Vector3<f64>>,
    /// Force of all contacts at the points (world), N; zero where nothing touches.
    pub contact_forces: Vec<Vector3<f64>>,
    /// Charge at the points, C.
    pub charges: Vec<f64>,
}

impl Frame {
    /// Total number of points of all strands.
    #[must_use]
    pub fn points(&self) -> usize {
        self.strands.iter().map(|strand| strand.points.len()).sum()
    }

    /// Checks that every strand has a segment and arrays of matching length, all finite.
    ///
    /// # Errors
    /// [`ExportError::Count`] and [`ExportError::NotFinite`] name the first array that is wrong.
    pub fn validate(&self) -> Result<(), ExportError> {
        self.strands.iter().enumerate().try_for_each(|(i, strand)| strand.validate(i))
    }
}

impl Strand {
    /// Checks this strand as [`Frame::validate`] does; `strand` is its index, for errors.
    pub(super) fn validate(&self, strand: usize) -> Result<(), ExportError> {
        let points = self.points.len();
        if points < 2 {
            return Err(ExportError::Count { strand, what: "points", found: points, expected: 2 });
        }
        let count = |what, found, expected| {
            if found == expected {
                Ok(())
            } else {
                Err(ExportError::Count { strand, what, found, expected })
            }
        };
        count("radii", self.radii.len(), points)?;
        count("velocities", self.velocities.len(), points)?;
        count("curvatures", self.curvatures.len(), points)?;
        count("contact forces", self.contact_forces.len(), points)?;
        count("charges", self.charges.len(), points)?;
        count("frames", self.frames.len(), points - 1)?;
        count("forces", self.forces.len(), points - 1)?;
        finite(strand, "position", self.points.iter().map(|p| p.coords.sum()))?;
        finite(strand, "radius", self.radii.iter().copied())?;
        finite(strand, "velocity", self.velocities.iter().map(Vector3::sum))?;
        finite(strand, "curvature", self.curvatures.iter().map(Vector3::sum))?;
        finite(strand, "frame", self.frames.iter().map(|r| r.matrix().sum()))?;
        finite(strand, "force", self.forces.iter().map(Vector3::sum))?;
        finite(strand, "contact force", self.contact_forces.iter().map(Vector3::sum))?;
        finite(strand, "charge", self.charges.iter().copied())
    }
}

fn finite(
    strand: usize,
    what: &'static str,
    mut sums: impl Iterator<Item = f64>,
) -> Result<(), ExportError> {
    sums.position(|x| !x.is_finite())
        .map_or(Ok(()), |index| Err(ExportError::NotFinite { strand, what, index }))
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut frame = sample::frame(0);
        frame.validate().expect("a sound frame");
        frame.strands[1].forces.pop();
        let error = frame.validate().expect_err("a force is missing");
        assert!(matches!(error, ExportError::Count { strand: 1, what: "forces", .. }), "{error}");

        let mut frame = sample::frame(0);
        frame.strands[2].velocities[4].y = f64::NAN;
        let error = frame.validate().expect_err("NaN");
        assert_eq!(
            error.to_string(),
            "velocity of strand 2 is not finite at index 4; the simulation has failed"
        );
    }
}
