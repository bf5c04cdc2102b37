use nalgebra::Vector3;
use rapunzel_export::{Frame, Strand};
use std::str::FromStr;

/// A quantity that fibres show by their color.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coloring {
    /// Strain of the surface by bending: radius times curvature.
    Strain,
    /// Curvature of the centerline, 1/m.
    Curvature,
    /// Tension, N.
    Tension,
    /// Speed, m/s.
    Speed,
    /// Magnitude of the force of contacts, N.
    Contact,
    /// Charge, C.
    Charge,
    /// Which fibre it is.
    Fiber,
}

impl FromStr for Coloring {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "strain" => Ok(Self::Strain),
            "curvature" => Ok(Self::Curvature),
            "tension" => Ok(Self::Tension),
            "speed" => Ok(Self::Speed),
            "contact" => Ok(Self::Contact),
            "charge" => Ok(Self::Charge),
            "fibre" | "fiber" => Ok(Self::Fiber),
            _ => Err(format!(
                "\"{text}\" is nothing that fibres can be colored by: take strain, curvature, tension, \
                 speed, contact, charge or fibre"
            )),
        }
    }
}

/// Values between which colors are spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorRange {
    /// The value of the darkest color.
    pub low: f64,
    /// The value of the brightest color.
    pub high: f64,
}

impl ColorRange {
    /// From the lowest of some values, or zero if it is above, to the highest.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let ends = |range: Self, value: f64| Self {
            low: range.low.min(value),
            high: range.high.max(value),
        };
        values.into_iter().fold(Self { low: 0.0, high: 0.0 }, ends)
    }

    /// Where a value lies in the range, in `[0, 1]`.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let width = self.high - self.low;
        if width > 0.0 { ((value - self.low) / width).clamp(0.0, 1.0) } else { 0.0 }
    }
}

impl Coloring {
    /// Name and unit, for a legend; none of what has no scale.
    #[must_use]
    pub fn title(self) -> Option<&'static str> {
        match self {
            Self::Strain => Some("strain"),
            Self::Curvature => Some("curvature 1/m"),
            Self::Tension => Some("tension N"),
            Self::Speed => Some("speed m/s"),
            Self::Contact => Some("contact force N"),
            Self::Charge => Some("charge C"),
            Self::Fiber => None,
        }
    }

    /// Values at all nodes of a frame, one strand after another.
    #[must_use]
    pub fn values(self, frame: &Frame) -> Vec<f64> {
        let of = |(index, strand): (usize, &Strand)| self.of_strand(index, strand);
        frame.strands.iter().enumerate().flat_map(of).collect()
    }

    /// Values at all nodes of the strand number `index`.
    #[must_use]
    pub fn of_strand(self, index: usize, strand: &Strand) -> Vec<f64> {
        let curvature = |k: usize| strand.curvatures[k].xy().norm();
        let tension = |segment: usize| {
            let tangent = strand.frames[segment].matrix().column(2).into_owned();
            tangent.dot(&strand.forces[segment])
        };
        let last = strand.frames.len() - 1;
        let value = |k: usize| match self {
            Self::Strain => strand.radii[k] * curvature(k),
            Self::Curvature => curvature(k),
            // A node bears the mean of its segments.
            Self::Tension => 0.5 * (tension(k.saturating_sub(1)) + tension(k.min(last))),
            Self::Speed => strand.velocities[k].norm(),
            Self::Contact => strand.contact_forces[k].norm(),
            Self::Charge => strand.charges[k],
            Self::Fiber => index as f64,
        };
        (0..strand.points.len()).map(value).collect()
    }

    /// The color of a value, linear red, green and blue.
    pub(crate) fn color(self, value: f64, range: &ColorRange) -> Vector3<f64> {
        match self {
            // Hues that are far apart for neighbors: by the golden ratio.
            Self::Fiber => hue((value * 0.618_033_988_749_894_9).fract()),
            _ => viridis(range.place(value)),
        }
    }
}

/// The color map viridis (van der Walt and Smith 2015), linear between nine of its colors.
pub(crate) fn viridis(place: f64) -> Vector3<f64> {
    const COLORS: [[u8; 3]; 9] = [
        [68, 1, 84],
        [71, 44, 122],
        [59, 81, 139],
        [44, 113, 142],
        [33, 144, 141],
        [39, 173, 129],
        [92, 200, 99],
        [170, 220, 50],
        [253, 231, 37],
    ];
    let scaled = place.clamp(0.0, 1.0) * 8.0;
    let first = (0..8).rev().find(|k| f64::from(*k) <= scaled).unwrap_or(0);
    let t = scaled - f64::from(first);
    let [a, b] = [first, first + 1].map(|k| COLORS[k as usize].map(f64::from));
    let mixed = [0, 1, 2].map(|k| (a[k] + t * (b[k] - a[k])) / 255.0);
    Vector3::from(mixed.map(linear))
}

/// A color of a hue in `[0, 1)`, of even brightness.
fn hue(turn: f64) -> Vector3<f64> {
    let wave = |shift: f64| 0.5 + 0.4 * (std::f64::consts::TAU * (turn - shift)).cos();
    Vector3::new(wave(0.0), wave(1.0 / 3.0), wave(2.0 / 3.0)).map(linear)
}

/// The linear value of one of sRGB, in `[0, 1]`.
fn linear(x: f64) -> f64 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::font;

    #[test]
    fn every_letter_of_a_title_is_drawn() {
        for name in ["strain", "curvature", "tension", "speed", "contact", "charge"] {
            let coloring: Coloring = name.parse().expect("a quantity");
            for letter in coloring.title().expect("a scale").chars().filter(|c| *c != ' ') {
                assert_ne!(font::rows(letter), [0; 7], "{letter} of {name}");
            }
        }
    }
}
