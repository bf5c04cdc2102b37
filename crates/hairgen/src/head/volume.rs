use super::hairline::Hairline;
use super::shape::HeadShape;
use crate::HairgenError;
use crate::error::choice;
use nalgebra::{Point3, Unit, Vector3};
use rapunzel_collision::field::Soup;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Depth of the hull over bare skin, m.
const SKIN: f64 = 0.5e-3;
/// Angle over which the hair's depth falls to nothing at the hairline, rad.
const RIM: f64 = 0.3;
/// Vertices around and along a meridian of the hull, above and below the level of the ears.
const AROUND: u32 = 160;
const ABOVE: u32 = 48;
const BELOW: u32 = 72;
/// Heights at which the widest place of the hair over an azimuth is looked for.
const HEIGHTS: u32 = 40;
/// Lowest height at which the neck is looked for, m, of the head as drawn.
const LOWEST_NECK: f64 = -0.153;

/// A surface that hair fills: its depth over the scalp, and how far it hangs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HairVolume {
    /// Depth over the crown, m.
    pub crown: f64,
    /// Depth at the sides and the back, at the level of the ears, m.
    pub sides: f64,
    /// Height of the lower end of hanging hair over the origin of the head, m, negative below it;
    /// where there is none, hair ends at the hairline.
    #[serde(default)]
    pub hem: Option<f64>,
    /// Azimuth from the face within which nothing hangs, degrees.
    #[serde(default = "opening")]
    pub opening: f64,
    /// Number of tufts around the head, 0 for an even surface.
    #[serde(default)]
    pub tufts: u32,
}

fn opening() -> f64 {
    60.0
}

impl HairVolume {
    /// Short hair: two centimeters, less at the sides.
    pub const SHORT: Self = Self { crown: 0.022, sides: 0.014, hem: None, opening: 60.0, tufts: 0 };
    /// A bob down to the chin.
    pub const BOB: Self =
        Self { crown: 0.028, sides: 0.032, hem: Some(-0.115), opening: 62.0, tufts: 0 };
    /// Long hair down to the shoulder blades.
    pub const LONG: Self =
        Self { crown: 0.022, sides: 0.030, hem: Some(-0.33), opening: 68.0, tufts: 0 };
    /// A ball of curls.
    pub const AFRO: Self = Self { crown: 0.060, sides: 0.055, hem: None, opening: 60.0, tufts: 0 };
    /// Plait-like tufts.
    pub const TUFTS: Self =
        Self { crown: 0.045, sides: 0.045, hem: None, opening: 60.0, tufts: 14 };

    pub(crate) fn validate(&self) -> Result<(), HairgenError> {
        for (what, value) in [("crown", self.crown), ("sides", self.sides)] {
            if !(1e-3..=0.5).contains(&value) {
                return Err(HairgenError::Measure { what, value });
            }
        }
        if let Some(value) = self.hem
            && !(-2.0..=0.0).contains(&value)
        {
            return Err(HairgenError::Measure { what: "hem", value });
        }
        let (opening, tufts) = (self.opening, f64::from(self.tufts));
        let half = |x: f64| (0.0..=180.0).contains(&x);
        choice("the opening of hanging hair (degrees)", opening, "between 0 and 180", half)?;
        choice("the number of tufts", tufts, "at most 1000", |x| x <= 1e3)
    }

    /// The closed surface of head and hair.
    pub(super) fn surface(
        &self,
        head: &HeadShape,
        hairline: &Hairline,
    ) -> Result<Soup, HairgenError> {
        self.validate()?;
        let scale = head.scale().y;
        let floor = LOWEST_NECK * scale;
        let hem = self.hem.unwrap_or(floor);
        let bottom = hem.min(floor) - 2.0 * SKIN;
        let curtain: Vec<_> =
            (0..AROUND).map(|sector| self.hanging(head, hairline, azimuth(sector))).collect();
        let mut soup = Soup::default();
        soup.vertices.push(self.grown(head, hairline, &Vector3::y_axis()));
        for ring in 1..=ABOVE + BELOW {
            for (sector, curtain) in (0..AROUND).zip(&curtain) {
                soup.vertices.push(if ring <= ABOVE {
                    // Meridians of a sphere from the vertex to the level of the ears.
                    let height = FRAC_PI_2 * (1.0 - f64::from(ring) / f64::from(ABOVE));
                    let place = self.grown(head, hairline, &direction(azimuth(sector), height));
                    let across = place.x.hypot(place.z);
                    // Hair that hangs from above covers what is below.
                    let covered = height < curtain.height && across < curtain.radius;
                    if covered { place * (curtain.radius / across) } else { place }
                } else {
                    // Vertical below.
                    let height = bottom * f64::from(ring - ABOVE) / f64::from(BELOW);
                    let above = ((height - hem) / (8.0 * SKIN)).clamp(0.0, 1.0).sqrt();
                    self.below(head, hairline, azimuth(sector), height, curtain.radius * above)
                });
            }
        }
        let vertex = |sector: u32, ring: u32| 1 + (ring - 1) * AROUND + sector % AROUND;
        let last = ABOVE + BELOW;
        let lowest = soup.vertices.len();
        soup.vertices.push(Point3::new(0.0, bottom - SKIN, 0.0));
        let lowest = u32::try_from(lowest).unwrap_or(u32::MAX);
        for sector in 0..AROUND {
            soup.triangles.push([0, vertex(sector, 1), vertex(sector + 1, 1)]);
            for ring in 1..last {
                let [a, b] = [sector, sector + 1].map(|s| vertex(s, ring));
                let [c, d] = [sector, sector + 1].map(|s| vertex(s, ring + 1));
                soup.triangles.extend([[a, c, d], [a, d, b]]);
            }
            soup.triangles.push([lowest, vertex(sector + 1, last), vertex(sector, last)]);
        }
        Ok(soup)
    }

    /// Depth of the hair over the scalp along a direction, m: nothing at the hairline.
    fn depth(&self, hairline: &Hairline, direction: &Unit<Vector3<f64>>) -> f64 {
        let within = (hairline.within(direction) / RIM).clamp(0.0, 1.0);
        let rim = within * within * (3.0 - 2.0 * within);
        let up = direction.y.max(0.0);
        let depth = self.sides + (self.crown - self.sides) * up * up;
        SKIN + depth * rim * self.tuft(direction)
    }

    /// Part of the depth that tufts leave: one at their tips, a quarter between them.
    fn tuft(&self, direction: &Unit<Vector3<f64>>) -> f64 {
        if self.tufts == 0 {
            return 1.0;
        }
        // Tips on a spiral that covers the sphere evenly.
        let count = f64::from(2 * self.tufts);
        let golden = TAU * 0.5 * (5_f64.sqrt() - 1.0);
        let nearest = (0..2 * self.tufts).fold(-1.0_f64, |most, k| {
            let y = 1.0 - (2.0 * f64::from(k) + 1.0) / count;
            let ring = (1.0 - y * y).sqrt();
            let angle = golden * f64::from(k);
            let tip = Vector3::new(ring * angle.sin(), y, ring * angle.cos());
            most.max(tip.dot(direction))
        });
        // The angle at which a tuft ends is half of that between neighbors.
        let width = (4.0 * PI / count).sqrt() * 0.5;
        0.25 + 0.75 * (-(nearest.clamp(-1.0, 1.0).acos() / (0.6 * width)).powi(2)).exp()
    }

    /// The hull where hair grows, along a direction from the origin.
    fn grown(
        &self,
        head: &HeadShape,
        hairline: &Hairline,
        direction: &Unit<Vector3<f64>>,
    ) -> Point3<f64> {
        let skin = head.reach(&Point3::origin(), direction);
        skin + direction.into_inner() * self.depth(hairline, direction)
    }

    /// What hangs at an azimuth: as far out as the widest place above.
    fn hanging(&self, head: &HeadShape, hairline: &Hairline, azimuth: f64) -> Curtain {
        let none = Curtain { radius: 0.0, height: 0.0 };
        if self.hem.is_none() {
            return none;
        }
        let from = azimuth.min(TAU - azimuth).to_degrees();
        let beside = ((from - self.opening) / 12.0).clamp(0.0, 1.0);
        let widest = (0..HEIGHTS).fold(none, |widest, k| {
            let height = 0.8 * FRAC_PI_2 * f64::from(k) / f64::from(HEIGHTS);
            let place = self.grown(head, hairline, &direction(azimuth, height));
            let radius = place.x.hypot(place.z);
            if radius > widest.radius { Curtain { radius, height } } else { widest }
        });
        let mixed = beside * beside * (3.0 - 2.0 * beside);
        Curtain { radius: widest.radius * mixed, ..widest }
    }

    /// The hull at a height below the ears: hair that grows there or hangs down to `curtain` from
    /// the axis, m, and the skin where there is none.
    fn below(
        &self,
        head: &HeadShape,
        hairline: &Hairline,
        azimuth: f64,
        height: f64,
        curtain: f64,
    ) -> Point3<f64> {
        let out = direction(azimuth, 0.0);
        let neck = LOWEST_NECK * head.scale().y;
        let mut radius = SKIN;
        if height >= neck {
            let axis = Point3::new(0.0, height, 0.0);
            let skin = head.reach(&axis, &out);
            let depth = self.depth(hairline, &Unit::new_normalize(skin.coords));
            radius = (skin - axis).norm() + depth;
        }
        Point3::new(0.0, height, 0.0) + out.into_inner() * radius.max(curtain)
    }
}

/// Hair that hangs at an azimuth.
struct Curtain {
    /// Distance from the vertical axis of the head, m.
    radius: f64,
    /// Angle over the horizontal at which it begins, rad.
    height: f64,
}

fn azimuth(sector: u32) -> f64 {
    TAU * f64::from(sector) / f64::from(AROUND)
}

fn direction(azimuth: f64, height: f64) -> Unit<Vector3<f64>> {
    let ring = height.cos();
    Unit::new_normalize(Vector3::new(ring * azimuth.sin(), height.sin(), ring * azimuth.cos()))
}
