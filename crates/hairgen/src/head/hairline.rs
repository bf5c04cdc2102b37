use crate::HairgenError;
use nalgebra::{Point3, Rotation3, Unit, Vector3};
use rapunzel_collision::field::Soup;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The rim of the hair: its height above the horizontal plane through the head's origin, seen from
/// there, over the azimuth from the face to the nape; the same on both sides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>")]
pub struct Hairline(Vec<[f64; 2]>);

/// Lean of the axis of the scalp backward from the vertical, degrees: it points to the middle
/// between the hairline at the forehead and at the nape.
const LEAN: f64 = 38.0;

impl Default for Hairline {
    /// A forehead of some 7 cm above the eyes, receding a little at the temples, whiskers before
    /// the ears, above and behind these, and down to the nape.
    fn default() -> Self {
        Self(vec![
            [0.0, 42.0],
            [20.0, 42.0],
            [38.0, 41.0],
            [52.0, 26.0],
            [64.0, 6.0],
            [80.0, 2.0],
            [95.0, 14.0],
            [110.0, 8.0],
            [124.0, -14.0],
            [145.0, -34.0],
            [165.0, -42.0],
            [180.0, -43.0],
        ])
    }
}

impl Hairline {
    /// The hairline through these points: azimuth from the face, 0 to 180 degrees, rising, and
    /// height, degrees.
    ///
    /// # Errors
    /// [`HairgenError::Hairline`] of fewer than three points, azimuths that do not rise from 0 to
    /// 180, heights outside of -60 to 80 degrees, or a rim that folds over itself.
    pub fn new(points: Vec<[f64; 2]>) -> Result<Self, HairgenError> {
        let line = Self(points);
        line.check()?;
        Ok(line)
    }

    fn check(&self) -> Result<(), HairgenError> {
        let refuse = |problem| Err(HairgenError::Hairline { problem });
        let (Some(first), Some(last)) = (self.0.first(), self.0.last()) else {
            return refuse("has no points; give at least three");
        };
        if self.0.len() < 3 {
            return refuse("has fewer than three points");
        }
        if first[0] != 0.0 || last[0] != 180.0 {
            return refuse("must run from azimuth 0 (face) to 180 degrees (nape)");
        }
        if !self.0.windows(2).all(|pair| pair[0][0] < pair[1][0]) {
            return refuse("has azimuths that do not rise");
        }
        if !self.0.iter().all(|point| (-60.0..=80.0).contains(&point[1])) {
            return refuse("has a height outside of -60 to 80 degrees");
        }
        if self.rim().windows(2).any(|pair| pair[0][0] >= pair[1][0]) {
            return refuse("folds over itself, seen from the middle of the scalp");
        }
        Ok(())
    }

    /// The middle of the scalp as a direction from the origin, head frame.
    #[must_use]
    pub fn axis(&self) -> Unit<Vector3<f64>> {
        lean() * Vector3::y_axis()
    }

    /// Angles of the points about the leaning axis from the front, and from the axis, rad.
    fn rim(&self) -> Vec<[f64; 2]> {
        let to_axis = lean().inverse();
        let point = |&[azimuth, height]: &[f64; 2]| {
            let (a, h) = (azimuth.to_radians(), height.to_radians());
            let d = to_axis * Vector3::new(a.sin() * h.cos(), h.sin(), a.cos() * h.cos());
            [d.x.atan2(d.z), d.y.clamp(-1.0, 1.0).acos()]
        };
        self.0.iter().map(point).collect()
    }

    /// Angle of the rim from the axis of the scalp at an angle about it from the front, rad: cubic
    /// between the points, with the slopes of Fritsch and Butland (1984), which do not overshoot.
    fn polar(rim: &[[f64; 2]], about: f64) -> f64 {
        // Both sides are alike.
        let angle = (about + PI).rem_euclid(TAU) - PI;
        let angle = angle.abs();
        let last = rim.len() - 2;
        let i = rim[1..=last].partition_point(|point| point[0] <= angle);
        let width = |k: usize| rim[k + 1][0] - rim[k][0];
        let slope = |k: usize| (rim[k + 1][1] - rim[k][1]) / width(k);
        // At the face and the nape the rim crosses the plane of symmetry at a right angle.
        let tangent = |k: usize| {
            if k == 0 || k > last || slope(k - 1) * slope(k) <= 0.0 {
                return 0.0;
            }
            let weight = (width(k - 1) + 2.0 * width(k)) / (3.0 * (width(k - 1) + width(k)));
            slope(k - 1) * slope(k) / (weight * slope(k) + (1.0 - weight) * slope(k - 1))
        };
        let (h, t) = (width(i), ((angle - rim[i][0]) / width(i)).clamp(0.0, 1.0));
        let (u, v) = (t * t * (3.0 - 2.0 * t), t * (1.0 - t));
        rim[i][1] * (1.0 - u)
            + rim[i + 1][1] * u
            + h * v * ((1.0 - t) * tangent(i) - t * tangent(i + 1))
    }

    /// How far within the hairline a direction from the origin lies, rad; negative outside.
    #[must_use]
    pub fn within(&self, direction: &Unit<Vector3<f64>>) -> f64 {
        let d = lean().inverse() * direction.into_inner();
        Self::polar(&self.rim(), d.x.atan2(d.z)) - d.y.clamp(-1.0, 1.0).acos()
    }

    /// A disc of triangles within the hairline: `place` puts directions from the origin on a
    /// surface.
    pub(crate) fn disc(
        &self,
        around: u32,
        rings: u32,
        place: impl Fn(&Unit<Vector3<f64>>) -> Point3<f64> + Sync,
    ) -> Result<Soup, HairgenError> {
        self.disc_to(around, rings, |_| 1.0, place)
    }

    /// A disc of triangles within the hairline that reaches, at an angle about the middle of the
    /// scalp, to a part of the way to the rim.
    pub(crate) fn disc_to(
        &self,
        around: u32,
        rings: u32,
        part: impl Fn(f64) -> f64 + Sync,
        place: impl Fn(&Unit<Vector3<f64>>) -> Point3<f64> + Sync,
    ) -> Result<Soup, HairgenError> {
        if around < 3 || rings < 1 {
            return Err(HairgenError::Resolution { around, rings });
        }
        let rim = self.rim();
        let direction = |number: u32| {
            let (sector, ring) = (number % around, 1 + number / around);
            let about = TAU * f64::from(sector) / f64::from(around);
            let reach = Self::polar(&rim, about) * part(about);
            let polar = reach * f64::from(ring) / f64::from(rings);
            let d = Vector3::new(about.sin() * polar.sin(), polar.cos(), about.cos() * polar.sin());
            Unit::new_normalize(lean() * d)
        };
        let mut soup = Soup { vertices: vec![place(&self.axis())], triangles: Vec::new() };
        let others = (0..around * rings).into_par_iter().map(|number| place(&direction(number)));
        soup.vertices.par_extend(others);
        let vertex = |sector: u32, ring: u32| {
            if ring == 0 { 0 } else { 1 + (ring - 1) * around + sector % around }
        };
        for sector in 0..around {
            soup.triangles.push([0, vertex(sector, 1), vertex(sector + 1, 1)]);
            for ring in 1..rings {
                let [a, b] = [sector, sector + 1].map(|s| vertex(s, ring));
                let [c, d] = [sector, sector + 1].map(|s| vertex(s, ring + 1));
                soup.triangles.extend([[a, c, d], [a, d, b]]);
            }
        }
        Ok(soup)
    }
}

impl TryFrom<Vec<[f64; 2]>> for Hairline {
    type Error = HairgenError;

    fn try_from(points: Vec<[f64; 2]>) -> Result<Self, HairgenError> {
        Self::new(points)
    }
}

impl From<Hairline> for Vec<[f64; 2]> {
    fn from(line: Hairline) -> Self {
        line.0
    }
}

/// From the axis of the scalp to the head frame: the vertical leans backward.
fn lean() -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::x_axis(), -LEAN.to_radians())
}
