use crate::HairgenError;
use crate::error::choice;
use nalgebra::{Point3, Rotation3, Vector3};
use rapunzel_fiber::so3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The golden ratio less one: multiples of it fill a turn evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Curls or waves of a hair about its way along the guides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curl {
    /// Whether hair winds or waves.
    pub shape: CurlShape,
    /// Largest distance from the way, m.
    pub radius: f64,
    /// Length of a turn or a wave along the way, m.
    pub wavelength: f64,
    /// Length of the way over which curls grow from nothing at the root, m.
    #[serde(default = "rise")]
    pub rise: f64,
    /// Spread of the phases of neighbours, in turns: 0 for curls side by side, 1 for frizz.
    #[serde(default = "spread")]
    pub spread: f64,
}

/// The shape of a curl.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CurlShape {
    /// A helix, to the right.
    Helix,
    /// A wave across the scalp's normal, level with the surface.
    Wave,
}

fn rise() -> f64 {
    0.03
}

fn spread() -> f64 {
    0.15
}

impl Curl {
    pub(super) fn validate(&self) -> Result<(), HairgenError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        choice("the radius of a curl (m)", self.radius, "at least 0 and finite", |x| {
            x >= 0.0 && x.is_finite()
        })?;
        choice("the wavelength of a curl (m)", self.wavelength, "positive and finite", positive)?;
        choice("the rise of curls (m)", self.rise, "positive and finite", positive)?;
        choice("the spread of curls", self.spread, "between 0 and 1", |x| (0.0..=1.0).contains(&x))
    }

    /// Leads the way of hair number `number` out of a scalp with the unit `normal` in curls, in
    /// axes that are carried along it without a twist.
    pub(super) fn wind(&self, way: &mut [Point3<f64>], normal: &Vector3<f64>, number: usize) {
        let phase = TAU * self.spread * (GOLDEN * number as f64).fract();
        let mut frame = Rotation3::identity();
        let (mut last, mut along) = (Vector3::z(), 0.0);
        let mut before: Option<Point3<f64>> = None;
        for node in 0..way.len() {
            let at = way[node];
            let next = way.get(node + 1).map_or(last, |next| next - at);
            let tangent = next.try_normalize(0.0).unwrap_or(last);
            match before {
                Some(point) => {
                    along += (at - point).norm();
                    frame = so3::between(&last, &tangent).unwrap_or_default() * frame;
                }
                None => frame = root_axes(&tangent, normal),
            }
            (before, last) = (Some(at), tangent);
            let turn = TAU * along / self.wavelength + phase;
            let size = self.radius * smooth(along / self.rise);
            let across = match self.shape {
                CurlShape::Helix => Vector3::new(turn.cos(), turn.sin(), 0.0),
                CurlShape::Wave => Vector3::new(0.0, turn.sin(), 0.0),
            };
            way[node] = at + frame * across * size;
        }
    }
}

/// Axes with the third along `tangent` and the first toward `normal`, or any where that is along.
fn root_axes(tangent: &Vector3<f64>, normal: &Vector3<f64>) -> Rotation3<f64> {
    if tangent.cross(normal).norm() > 1e-6 {
        Rotation3::face_towards(tangent, normal) * turned()
    } else {
        so3::between(&Vector3::z(), tangent).unwrap_or_default()
    }
}

/// From axes with the second toward the normal to those with the first.
fn turned() -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2)
}

/// From 0 to 1 without a kink.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Along a straight way a helix keeps its radius, pitch and handedness, and a wave stays in the
    /// plane across the normal.
    #[test]
    fn curls_have_their_radius_and_wavelength() {
        let way: Vec<_> = (0..=400).map(|i| Point3::new(0.0, 0.0, 5e-4 * f64::from(i))).collect();
        let mut curl = Curl {
            shape: CurlShape::Helix,
            radius: 3e-3,
            wavelength: 0.02,
            rise: 0.01,
            spread: 0.0,
        };
        let mut wound = way.clone();
        curl.wind(&mut wound, &Vector3::x(), 0);
        assert!((wound[0] - way[0]).norm() < 1e-15, "the root stays");
        for (node, (point, axis)) in wound.iter().zip(&way).enumerate().skip(20) {
            let off = point - axis;
            assert!((off.norm() - 3e-3).abs() < 1e-12 && off.z.abs() < 1e-15, "{node}: {off}");
            let turn = TAU * axis.z / 0.02;
            let right = Vector3::new(turn.cos(), turn.sin(), 0.0) * 3e-3;
            assert!((off - right).norm() < 1e-12, "{node}: {off}");
        }
        curl.shape = CurlShape::Wave;
        let mut waved = way.clone();
        curl.wind(&mut waved, &Vector3::x(), 0);
        assert!(waved.iter().all(|p| p.x.abs() < 1e-15));
        let largest = waved.iter().map(|p| p.y).fold(0.0, f64::max);
        assert!((largest - 3e-3).abs() < 1e-6, "{largest}");
    }
}
