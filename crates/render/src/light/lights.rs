use super::emitter::{Delta, Emitter};
use super::{Light, Sky};
use crate::{PathRandom, Ray, RenderError};
use nalgebra::{Point3, Vector3};

/// All that sends light in a scene.
///
/// Lights hide each other and the sky, but are not hidden by other things: whether those are in the
/// way is for the caller to find out. Every light, and the sky, is chosen with the same chance. A
/// density is that of a direction whichever light it was drawn for, so where a sample of one light
/// meets another its weight is right, too. Every question costs a test of each light.
#[derive(Debug, Clone)]
pub struct Lights {
    emitters: Vec<Emitter>,
    sky: Option<Sky>,
    /// Chance of each light and of the sky to be chosen.
    chance: f64,
}

/// A direction to look for light in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightSample {
    /// The direction to the light, of unit length.
    pub direction: Vector3<f64>,
    /// Distance of the light, m; infinite for the sky and distant lights.
    pub distance: f64,
    /// Radiance, W/(m^2 sr), not divided by the density; for a delta light irradiance of a plane
    /// across the direction, W/m^2.
    pub radiance: Vector3<f64>,
    /// Density with which the direction was drawn, per sr, above zero; for a delta light the chance
    /// with which it was chosen.
    pub pdf: f64,
    /// Whether the light comes from a single direction, which no ray finds by chance.
    pub delta: bool,
}

/// A light that is seen along a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightHit {
    /// Distance of the light, m; infinite for the sky and distant lights.
    pub distance: f64,
    /// Radiance, W/(m^2 sr).
    pub radiance: Vector3<f64>,
    /// Density with which [`Lights::sample`] draws this direction from the origin of the ray, per
    /// sr.
    pub pdf: f64,
}

const NOTHING: LightHit =
    LightHit { distance: f64::INFINITY, radiance: Vector3::new(0.0, 0.0, 0.0), pdf: 0.0 };

impl Lights {
    /// These lights and the sky, if there is one.
    ///
    /// # Errors
    /// [`RenderError::Parameter`] if a light has no extent or direction, its angular radius is out
    /// of range, radiance is negative, or a number is not finite.
    pub fn new(lights: &[Light], sky: Option<Sky>) -> Result<Self, RenderError> {
        let emitters = lights.iter().map(Emitter::new).collect::<Result<Vec<_>, _>>()?;
        let sky = sky.map(Sky::checked).transpose()?;
        let count = emitters.len() + usize::from(sky.is_some());
        Ok(Self { emitters, sky, chance: 1.0 / count.max(1) as f64 })
    }

    /// Chooses a light and a direction in which it may be seen from a point (world, m); `None`
    /// where the choice sends no light, which counts as a sample of nothing.
    pub fn sample(&self, from: &Point3<f64>, random: &mut PathRandom) -> Option<LightSample> {
        #[expect(clippy::cast_possible_truncation, reason = "the number of a light")]
        let choice = (random.number() / self.chance) as usize;
        let direction = match self.emitters.get(choice) {
            Some(light) => match light.delta(from) {
                Some(delta) => return self.unhidden(from, &delta),
                None => light.draw(from, random)?,
            },
            None => self.sky.as_ref()?.draw(random),
        };
        let ray = Ray { origin: *from, direction, time: 0.0 };
        let seen = self.hit(&ray, f64::INFINITY).unwrap_or_else(|| self.escaped(&direction));
        let LightHit { distance, radiance, pdf } = seen;
        let drawn = pdf > 0.0 && pdf.is_finite();
        drawn.then_some(LightSample { direction, distance, radiance, pdf, delta: false })
    }

    /// The nearest light of finite extent that a ray meets before `range_end`, m.
    #[must_use]
    pub fn hit(&self, ray: &Ray, range_end: f64) -> Option<LightHit> {
        let mut nearest = NOTHING;
        for seen in self.emitters.iter().filter_map(|light| light.seen(ray)) {
            nearest.pdf += self.chance * seen.density;
            if seen.distance < nearest.distance {
                (nearest.distance, nearest.radiance) = (seen.distance, seen.radiance);
            }
        }
        // Distant lights are at an infinite distance.
        let is_hit = nearest.distance < range_end;
        is_hit.then(|| {
            let sky = self.sky.as_ref().map_or(0.0, |sky| sky.seen(&ray.direction).1);
            LightHit { pdf: nearest.pdf + self.chance * sky, ..nearest }
        })
    }

    /// What is seen of the sky and of distant lights in a direction (world, of unit length) in
    /// which nothing else is met.
    #[must_use]
    pub fn escaped(&self, direction: &Vector3<f64>) -> LightHit {
        let mut all = NOTHING;
        let sky = self.sky.iter().map(|sky| sky.seen(direction));
        let discs = self.emitters.iter().filter_map(|light| light.beyond(direction));
        for (radiance, density) in sky.chain(discs.map(|seen| (seen.radiance, seen.density))) {
            all.radiance += radiance;
            all.pdf += self.chance * density;
        }
        all
    }

    fn unhidden(&self, from: &Point3<f64>, delta: &Delta) -> Option<LightSample> {
        let Delta { direction, distance, irradiance } = *delta;
        let ray = Ray { origin: *from, direction, time: 0.0 };
        let (radiance, pdf) = (irradiance, self.chance);
        let sample = LightSample { direction, distance, radiance, pdf, delta: true };
        self.hit(&ray, distance).is_none().then_some(sample)
    }
}
