//! A conducting sphere, by images.

use super::Condition;
use crate::error::{check_charges, check_positions, check_positive};
use crate::{COULOMB_CONSTANT, ElectrostaticsError};
use nalgebra::Point3;

/// Conducting sphere: exact, as one more set of charges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConductingSphere {
    /// Center of the sphere (world), m.
    pub center: Point3<f64>,
    /// Radius of the sphere, m.
    pub radius: f64,
    /// Known potential or charge of the sphere.
    pub condition: Condition,
}

impl ConductingSphere {
    /// Charges (C) within the sphere (world, m) whose field outside is that of the sphere beside
    /// `charges` at `sources`: for each the image `-q R/r` at `R^2/r`, and one in the center that
    /// makes up the potential or the total charge.
    ///
    /// The force on a charge is its charge times the field of the images and of the other charges.
    ///
    /// # Errors
    /// Positions and charges that are not finite or do not fit, a radius that is not positive, and
    /// charges that are not outside.
    pub fn images(
        &self,
        sources: &[Point3<f64>],
        charges: &[f64],
    ) -> Result<(Vec<Point3<f64>>, Vec<f64>), ElectrostaticsError> {
        check_positions("source", sources)?;
        check_positions("center", &[self.center])?;
        check_charges(charges, sources.len())?;
        let radius = self.radius;
        check_positive("the radius of the sphere", radius)?;
        let mut points = Vec::with_capacity(sources.len() + 1);
        let mut images = Vec::with_capacity(sources.len() + 1);
        for (index, (source, charge)) in sources.iter().zip(charges).enumerate() {
            let offset = source - self.center;
            let distance = offset.norm();
            if distance <= radius {
                return Err(ElectrostaticsError::Inside { index, depth: radius - distance });
            }
            let ratio = radius / distance;
            points.push(self.center + offset * (ratio * ratio));
            images.push(-charge * ratio);
        }
        points.push(self.center);
        images.push(match self.condition {
            Condition::Potential(potential) => potential * radius / COULOMB_CONSTANT,
            Condition::Charge(charge) => charge - images.iter().sum::<f64>(),
        });
        Ok((points, images))
    }
}
