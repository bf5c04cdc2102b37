//! Tresses: the room that they take, and the force that combs them.

use super::sample::{LabSample, Number, Reading, Record};
use crate::scene::Scene;
use crate::{SimError, World};
use rapunzel_keratin::lab::tress;
use rapunzel_keratin::surface::Wetness;

/// Slices of a radial volume.
const SLICES: usize = 20;

/// A lock of wavy hairs that hangs still: each for itself, as if they did not touch.
const LOCK: &str = "(
    format: 1, seed: 1, duration: 1.5, stepper: (dt: 5e-3, method: BackwardEuler),
    fibers: [(
        length: 0.12, segments: 40, section: Circle(radius: 1e-5), damping_time: 5e-3,
        shape: Helix(radius: 0.003, pitch: 0.025),
        arrangement: Lock(count: 39, radius: 0.006, curvature_variation: 0.3),
    )],
)";

/// A wavy tress of thirty hairs, and a comb of five teeth that goes into it near its roots and down
/// through it with 10 cm/s.
const COMB: &str = "(
    format: 1, seed: 1, duration: 0.6, stepper: (dt: 2e-3),
    fibers: [(
        length: 0.06, segments: 24, section: Circle(radius: 1e-5),
        shape: Helix(radius: 0.002, pitch: 0.015),
        arrangement: Ellipse(semi_axes: (0.003, 0.002), count: 30),
    )],
    objects: [TEETH],
    contact: (friction: Keratin(on: Hair, wetness: WETNESS)),
    environment: (viscosity: 1.8e-5),
)";
const TOOTH: &str = "(
    shape: Capsule(length: 0.03, radius: 0.0004), position: (PLACE, 0.02, -0.012), turn: (90, 0, 0),
    motion: Keyframes(points: [
        (time: 0.0), (time: 0.1, translation: (0, -0.02, 0)), (time: 0.6, translation: (0, -0.02, -0.05)),
    ]),
    friction: Keratin(on: Nylon, wetness: WETNESS),
)";
/// Places of the teeth across the tress, m.
const PLACES: [f64; 5] = [-0.003, -0.0015, 0.0, 0.0015, 0.003];

/// Lets a lock of forty wavy hairs hang, and reads its radial volume.
pub(super) fn volume(sample: &LabSample) -> Result<Reading, SimError> {
    let volume = |world: &World| {
        let fibers: Vec<_> =
            (0..world.assembly().fibers().len()).map(|i| world.state(i).positions).collect();
        1e6 * tress::radial_volume(&fibers, SLICES)
    };
    let points = run(sample, Scene::from_ron(LOCK)?, volume)?;
    let last = points.last().map_or(0.0, |p| p[1]);
    let numbers = vec![
        Number::new("radial volume", "m^3", 1e-6 * last),
        Number::new("radial volume before it hangs", "m^3", 1e-6 * points[0][1]),
    ];
    Ok(Reading { numbers, record: Record { axes: ["time (s)", "volume (cm^3)"], points } })
}

/// Draws a comb of nylon through a tress, wet where the air is saturated, and reads the force down
/// the hair of all teeth together.
pub(super) fn combing(sample: &LabSample) -> Result<Reading, SimError> {
    let wet = if sample.wetness() == Wetness::Wet { "Wet" } else { "Dry" };
    let teeth = PLACES.map(|x| TOOTH.replace("PLACE", &format!("{x:?}"))).join(", ");
    let scene = Scene::from_ron(&COMB.replace("TEETH", &teeth).replace("WETNESS", wet))?;
    let teeth = PLACES.len();
    // Downward is what the teeth do to the hairs, upward what they bear.
    let pull = |world: &World| 1e3 * (0..teeth).map(|tooth| world.force_on(tooth).z).sum::<f64>();
    let points = run(sample, scene, pull)?;
    let peak = points.iter().map(|p| p[1]).fold(0.0, f64::max);
    let mean = points.iter().map(|p| p[1]).sum::<f64>() / points.len() as f64;
    let numbers = vec![
        Number::new("largest combing force", "N", 1e-3 * peak),
        Number::new("mean combing force", "N", 1e-3 * mean),
    ];
    Ok(Reading { numbers, record: Record { axes: ["time (s)", "force on the comb (mN)"], points } })
}

/// Runs a scene with fibres of the sample, and reads it after every step: `[time, reading]`. A hair
/// that slips off a tooth takes some ms: fewer readings would cut the peaks of the force.
fn run(
    sample: &LabSample,
    mut scene: Scene,
    read: impl Fn(&World) -> f64,
) -> Result<Vec<[f64; 2]>, SimError> {
    sample.put_into(&mut scene);
    let mut world = World::build(&scene)?;
    let mut points = vec![[0.0, read(&world)]];
    while world.time() < scene.duration {
        world.step(scene.stepper.dt)?;
        points.push([world.time(), read(&world)]);
    }
    Ok(points)
}
