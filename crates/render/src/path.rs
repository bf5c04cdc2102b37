use crate::scene::RenderScene;
use crate::vertex::{Onward, PathVertex};
use crate::{FilmPixel, FilmSample, FirstSurface, LightHit, PathRandom, Ray};
use nalgebra::Vector3;

/// Events after which a path without an order may end by chance.
const SURE_EVENTS: u32 = 4;
/// Largest chance to go on.
const GO_ON: f64 = 0.95;

/// Ways in which light is looked for at every event. All give the same picture in the end, unless
/// one cannot find a light at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LightSearch {
    /// Both, each with the share of the power heuristic (Veach and Guibas 1995).
    #[default]
    Both,
    /// At a light that is chosen (next-event estimation).
    Lights,
    /// In the direction in which the path goes on. Lights that come from a single direction are
    /// never found.
    Onward,
}

impl LightSearch {
    /// Share of a sample that was drawn with the density `own` where the other way has the density
    /// `other`; `this` is the way by itself.
    fn share(self, this: Self, own: f64, other: f64) -> f64 {
        match self {
            // As a ratio: squares of large densities would overflow.
            Self::Both => 1.0 / (1.0 + (other / own).powi(2)),
            _ => f64::from(u8::from(self == this)),
        }
    }
}

/// What a path finds that begins with a ray from a camera.
///
/// An event is a scattering; a path has at most `events` of them, one at least, or as many as
/// chance lets it.
pub(crate) fn trace(
    scene: &RenderScene,
    ray: Ray,
    events: Option<u32>,
    search: LightSearch,
    random: &mut PathRandom,
) -> FilmSample {
    let mut ray = ray;
    let mut radiance = Vector3::zeros();
    let mut throughput = Vector3::repeat(1.0);
    let mut surface = None;
    // Density with which the direction of the ray was drawn; none of a ray from the camera.
    let mut drawn: Option<f64> = None;
    let mut start = 0.0;
    for event in 0_u32.. {
        let hit = scene.hit(&ray, [start, f64::INFINITY]);
        let distance = hit.as_ref().map_or(f64::INFINITY, |hit| hit.distance());
        // Light along the ray, which ends there.
        let seen = scene.lights().hit(&ray, distance);
        let is_light = seen.is_some() || hit.is_none();
        if is_light {
            let LightHit { radiance: light, pdf, .. } =
                seen.unwrap_or_else(|| scene.lights().escaped(&ray.direction));
            let share = drawn.map_or(1.0, |drawn| search.share(LightSearch::Onward, drawn, pdf));
            radiance += throughput.component_mul(&light) * share;
        }
        let (Some(hit), false) = (hit, is_light) else { break };
        if events.is_some_and(|most| event >= most) {
            break;
        }
        let vertex = scene.vertex(&ray, &hit);
        surface.get_or_insert_with(|| first_surface(&vertex, distance));
        radiance += throughput.component_mul(&direct(scene, &vertex, ray.time, search, random));
        let Some(Onward { direction, weight, pdf }) = vertex.scatterer.sample(random) else {
            break;
        };
        throughput.component_mul_assign(&weight);
        if events.is_none() && event >= SURE_EVENTS {
            let chance = throughput.max().min(GO_ON);
            if random.number() >= chance {
                break;
            }
            throughput /= chance;
        }
        if throughput.max() == 0.0 {
            break;
        }
        ray = Ray { origin: vertex.position, direction, time: ray.time };
        (start, drawn) = (vertex.clearance, Some(pdf));
    }
    FilmSample { radiance, surface }
}

/// Light that comes to a vertex straight from a light and is scattered back along the path.
fn direct(
    scene: &RenderScene,
    vertex: &PathVertex<'_>,
    time: f64,
    search: LightSearch,
    random: &mut PathRandom,
) -> Vector3<f64> {
    let Some(light) = scene.lights().sample(&vertex.position, random) else {
        return Vector3::zeros();
    };
    let (value, drawn) = vertex.scatterer.evaluate(&light.direction);
    if value.max() <= 0.0 {
        return Vector3::zeros();
    }
    let other = if light.delta { 0.0 } else { drawn };
    let share = search.share(LightSearch::Lights, light.pdf, other);
    let ray = Ray { origin: vertex.position, direction: light.direction, time };
    let end = light.distance - vertex.clearance;
    if scene.hides(&ray, [vertex.clearance, end]) {
        return Vector3::zeros();
    }
    value.component_mul(&light.radiance) * (share / light.pdf)
}

fn first_surface(vertex: &PathVertex<'_>, depth: f64) -> FirstSurface {
    let fiber = vertex.fiber.and_then(|fiber| u32::try_from(fiber).ok());
    FirstSurface {
        albedo: vertex.scatterer.albedo(),
        normal: vertex.normal,
        depth,
        fiber: fiber.unwrap_or(FilmPixel::NO_FIBER),
    }
}
