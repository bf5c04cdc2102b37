//! Hair wound wet keeps its turn when it is dried, and loses it when the air becomes humid.

use rapunzel_sim::scene::SceneError;
use rapunzel_sim::{Scene, World};

const SCENE: &str = include_str!("../../../../scenes/water-wave.ron");

/// Runs a scene to each of some times, s, and reads how far from straight the first hair is: one
/// less the distance of its ends over its length.
fn bends(scene: &Scene, times: &[f64]) -> Vec<f64> {
    let mut world = World::build(scene).expect("a world");
    let mut read = |end: f64| {
        while world.time() < end {
            world.step(scene.stepper.dt).expect("a step");
        }
        bend(&world)
    };
    times.iter().map(|t| read(*t)).collect()
}

fn bend(world: &World) -> f64 {
    let (first, last) = (world.node(0, Some(0)).0, world.node(0, None).0);
    1.0 - (last - first).norm() / world.assembly().fibers()[0].length()
}

#[test]
fn a_water_wave_holds_in_dry_air_and_is_lost_in_humid_air() {
    let mut scene = Scene::from_ron(SCENE).expect("a scene");
    let [wound, let_go, dry, damp] =
        <[f64; 4]>::try_from(bends(&scene, &[4190.0, 4300.0, 7190.0, 14400.0])).expect("four");
    assert!(wound > 0.7, "{wound}");
    assert!(let_go > 0.5 * wound, "it springs back in part: {let_go} of {wound}");
    assert!(dry > 0.8 * let_go, "it holds for most of an hour: {dry} of {let_go}");
    assert!(damp < 0.3 * dry, "and is lost: {damp} of {dry}");
    // Without the humid air it holds.
    scene.environment.climate.humidity.truncate(2);
    let kept = bends(&scene, &[14400.0])[0];
    assert!(kept > 0.8 * dry, "{kept} of {dry}");
}

#[test]
fn a_wave_resumes_to_the_same_bits() {
    let scene = Scene::from_ron(SCENE).expect("a scene");
    let mut world = World::build(&scene).expect("a world");
    let run = |world: &mut World, steps: u32| {
        (0..steps).for_each(|_| {
            world.step(scene.stepper.dt).expect("a step");
        });
    };
    run(&mut world, 440);
    let half = world.snapshot();
    run(&mut world, 300);
    let mut resumed = World::build(&scene).expect("a world");
    resumed.restore(&half).expect("of the same scene");
    run(&mut resumed, 300);
    assert_eq!(world.snapshot(), resumed.snapshot());
}

#[test]
fn keratin_that_makes_no_sense_is_refused() {
    let refused = |from: &str, to: &str| match Scene::from_ron(&SCENE.replacen(from, to, 1)) {
        Err(SceneError { problems, .. }) => problems[0].to_string(),
        other => panic!("{other:?}"),
    };
    let misspelt = refused("Caucasian", "Caucasien");
    assert!(misspelt.contains("did you mean Caucasian"), "{misspelt}");
    let percent = refused("(660.0, 0.5)", "(660.0, 50)");
    assert!(percent.contains("environment.climate.humidity[1][1]"), "{percent}");
    let elastic = refused("law: ThreeElement", "law: Elastic");
    assert!(elastic.contains("follows no climate that changes"), "{elastic}");
    let bare = refused("material: Keratin(type: \"Caucasian\", law: ThreeElement),", "");
    assert!(bare.contains("fibers[0].section: is missing"), "{bare}");
    let damped = refused("length: 0.05,", "length: 0.05, damping_time: 0.1,");
    assert!(damped.contains("damping_time"), "{damped}");
    let boxed = refused("method: BackwardEuler", "method: Box()");
    assert!(boxed.contains("material.law"), "{boxed}");
    let hot = refused("temperature: 23.0", "temperature: 120.0");
    assert!(hot.contains("is measured for temperature"), "{hot}");
}
