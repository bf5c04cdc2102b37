use super::Handedness;
use super::chords::chords;
use crate::FiberError;
use crate::error::positive;
use nalgebra::{Point3, Vector3};
use std::f64::consts::{PI, TAU};

/// Halvings of an interval in which an angle is searched: to the last bit.
const HALVINGS: usize = 60;

/// A fibre wound around a cylinder: straight, then a helix, then straight again, without a corner.
///
/// In the frame of the cylinder, whose axis is z: the helix begins on the x axis, seen along the
/// axis, and the middle of it is at z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wound {
    /// Distance of the middles of the segments from the axis where they touch, m: the radii of
    /// cylinder and fibre together.
    pub radius: f64,
    /// Number of turns.
    pub turns: f64,
    /// Advance along the axis in one turn, m.
    pub pitch: f64,
    /// Handedness of the helix.
    pub handedness: Handedness,
    /// Length of the straight part before the helix, m.
    pub lead: f64,
}

impl Wound {
    /// Nodes for segments of the given lengths, m. Segments are chords of the curve; on the helix
    /// the middles of the longest are at the radius, and none is nearer to the axis.
    ///
    /// # Errors
    /// Refuses numbers that are not finite or not positive, a pitch or a lead below zero, segments
    /// longer than half a turn can hold, and a fibre that is too short.
    pub fn nodes(&self, lengths: &[f64]) -> Result<Vec<Point3<f64>>, FiberError> {
        positive("radius of the winding (m)", self.radius)?;
        positive("turns of the winding", self.turns)?;
        for (quantity, value) in
            [("pitch of the winding (m)", self.pitch), ("lead of the winding (m)", self.lead)]
        {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(FiberError::OutOfRange { quantity, value, range: "[0, infinity)" });
            }
        }
        let (whole, longest) =
            (lengths.iter().sum::<f64>(), lengths.iter().copied().fold(0.0, f64::max));
        let rise = self.pitch / TAU;
        // Angle of a chord whose middle is at the radius.
        let reach = |angle: f64| (2.0 * self.radius * (0.5 * angle).tan()).hypot(rise * angle);
        let (mut low, mut high) = (0.0, 0.5 * PI);
        if reach(high) < longest {
            let needed = (whole / reach(high)).ceil();
            return Err(FiberError::Unresolved { segments: lengths.len(), needed });
        }
        for _ in 0..HALVINGS {
            let angle = 0.5 * (low + high);
            *if reach(angle) < longest { &mut low } else { &mut high } = angle;
        }
        let radius = self.radius / (0.5 * high).cos();
        let slope = radius.hypot(rise);
        let around = TAU * self.turns;
        if self.lead + around * slope > whole {
            let quantity = "what the winding and its lead leave of the fibre's length (m)";
            let value = whole - self.lead - around * slope;
            return Err(FiberError::OutOfRange { quantity, value, range: "[0, infinity)" });
        }
        let sign = match self.handedness {
            Handedness::Right => 1.0,
            Handedness::Left => -1.0,
        };
        let at = |way: f64| {
            let angle = ((way - self.lead) / slope).clamp(0.0, around);
            let beyond = way - self.lead - angle * slope;
            let (sin, cos) = angle.sin_cos();
            let place =
                Vector3::new(radius * cos, sign * radius * sin, rise * (angle - 0.5 * around));
            let tangent = Vector3::new(-radius * sin, sign * radius * cos, rise) / slope;
            Point3::from(place + beyond * tangent)
        };
        Ok(chords(lengths, at))
    }
}
