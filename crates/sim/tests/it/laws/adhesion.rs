//! What holds touches together: films, bonds, water.

use super::{G, GROUND, RADIUS, hair, run_of, weight};
use crate::common::Run;
use nalgebra::Vector3;
use rapunzel_contact::Cylinders;
use rapunzel_sim::{Scene, World};
use std::f64::consts::PI;

/// A hair that starts 0.1 um above the ground, along a direction, while gravity draws it up for
/// `steps` steps of 1 ms: the height of its root above the ground then, m.
fn drawn_up(way: &Vector3<f64>, adhesion: &str, steps: usize) -> f64 {
    let lying = hair(&Vector3::new(0.0, 0.0, RADIUS + 1e-7), way);
    let laws = format!("friction: Isotropic(0.3), adhesion: {adhesion}");
    let mut run = run_of(&lying, GROUND, &laws, G, 1e-3);
    for _ in 0..steps {
        run.step();
    }
    run.world.state(0).positions[0].z - RADIUS
}

/// A hair whose film pulls less than gravity leaves; one whose film pulls more stays.
#[test]
fn a_film_holds_what_it_can() {
    let film = |share: f64| format!("Line(force: {:?}, range: 2e-5)", share * weight() / 0.008);
    let steps = 30;
    assert!(drawn_up(&Vector3::x(), &film(1.01), steps).abs() < 1.4e-6);
    assert!(drawn_up(&Vector3::x(), &film(0.99), steps) > 2e-6);
    // Within its range a film only takes its share of the weight: a dt^2 n (n + 1) / 2.
    let [start, n] = [1e-7, 3.0];
    let way = drawn_up(&Vector3::x(), &film(0.75), 3) - start;
    let expected = 0.25 * G * 1e-6 * 0.5 * n * (n + 1.0);
    println!("rose {way:.4e} m for {expected:.4e} m");
    assert!((way / expected - 1.0).abs() < 1e-3, "{way} for {expected}");
}

/// A hair that stands on the ground is held by one bond until its weight is more.
#[test]
fn a_bond_breaks_at_its_strength() {
    let held = |share: f64| {
        let bond = format!("Bonds(strength: {:?}, range: 1e-6)", share * weight());
        drawn_up(&Vector3::z(), &bond, 30)
    };
    assert!(held(1.01).abs() < 1.4e-6);
    // The step that breaks it still has its force, and the rest none.
    let n = 30.0;
    let way = 1e-7 + G * 1e-6 * (0.01 * n + 0.5 * n * (n - 1.0));
    println!("rose {:.6} mm for {:.6} mm", 1e3 * held(0.99), 1e3 * way);
    assert!((held(0.99) / way - 1.0).abs() < 1e-4, "{} for {way}", held(0.99));
}

/// Table 2.12 of the thesis, N: bonds break in the middle of what it has for each spray.
#[test]
fn bonds_of_hair_spray_break_as_the_table_has_it() {
    // So near that what the bond bears more than it must closes the gap in a step.
    let standing = hair(&Vector3::new(0.0, 0.0, RADIUS + 1e-12), &Vector3::z());
    for (hold, [least, most]) in [
        ("ultra-high hold", [0.35, 0.4]),
        ("hard-to-hold", [0.25, 0.3]),
        ("regular hold", [0.2, 0.25]),
        ("light hold", [0.1, 0.1]),
    ] {
        let laws =
            format!("friction: Isotropic(0.3), adhesion: Spray(hold: {hold:?}, range: 1e-6)");
        let pulled = |share: f64| {
            let force = share * 0.5 * (least + most);
            let tip =
                format!("root_joint: Free, tip: Loaded(force: (value: (0.0, 0.0, {force:?})))");
            let mut run =
                run_of(&standing.replace("root_joint: Free", &tip), GROUND, &laws, 0.0, 1e-6);
            for _ in 0..3 {
                run.step();
            }
            run.world.contacts().any(|bearing| bearing.bonded)
        };
        let both = [pulled(0.99), pulled(1.01)];
        assert_eq!(both, [true, false], "{hold}");
    }
}

/// Two free hairs side by side draw each other over the whole of their length.
#[test]
fn a_film_joins_a_pair() {
    let gap = 5e-6;
    let pair = [0.0, 2.0 * RADIUS + gap].map(|y| hair(&Vector3::y().scale(y), &Vector3::x()));
    let (mass, acceleration) = (weight() / G, 0.5);
    let force = 0.5 * acceleration * mass / 0.008;
    let laws = format!(
        "friction: Isotropic(0.3), adhesion: Line(force: {force:?}, range: {:?})",
        2.0 * gap
    );
    let mut run = run_of(&pair.join(", "), "", &laws, 0.0, 1e-3);
    let distance = |run: &Run, node: usize| {
        let [a, b] = [0, 1].map(|i| run.world.state(i).positions[node]);
        (b - a).norm() - 2.0 * RADIUS
    };
    for n in 1..=3 {
        run.step();
        let closed = acceleration * 1e-6 * 0.5 * f64::from(n * (n + 1));
        for node in 0..5 {
            let found = gap - distance(&run, node);
            assert!((found / closed - 1.0).abs() < 2e-3, "{found} for {closed}");
        }
    }
    for _ in 0..20 {
        run.step();
    }
    assert!(distance(&run, 2).abs() < 0.02 * 2.0 * RADIUS, "they stay together");
}

/// Water draws two free hairs to each other as the formulas for cylinders side by side and crossed
/// say.
#[test]
fn water_draws_hairs_together() {
    let (gap, area, volume, tension) = (2e-6, 2e-10, 1e-15, 0.0728e-6);
    let laws = format!(
        "friction: Isotropic(0.3), \
         adhesion: Capillary(surface_tension: {tension:?}, area: {area:?}, volume: {volume:?})"
    );
    let water = Cylinders::new(RADIUS, tension).expect("positive");
    let mass = weight() / G;
    let above = |x: f64| Vector3::new(x, 0.0, 2.0 * RADIUS + gap);
    let (lower, beside) =
        (hair(&Vector3::zeros(), &Vector3::x()), hair(&above(0.0), &Vector3::x()));
    let across = hair(&(above(0.004) - 0.004 * Vector3::y()), &Vector3::y());
    let along = 0.008 * water.parallel_force(gap, area);
    let crossed = water.crossed_force(gap, volume, 0.5 * PI);
    for (other, force) in [(beside, along), (across, crossed)] {
        let mut run = run_of(&format!("{lower}, {other}"), "", &laws, 0.0, 1e-4);
        run.step();
        let momentum = |fiber: usize| {
            let velocities = run.world.state(fiber).velocities;
            let ends = 0.5 * (velocities[0].z + velocities[4].z);
            mass / 4.0 * (ends + velocities[1..4].iter().map(|v| v.z).sum::<f64>())
        };
        for found in [momentum(0), -momentum(1)] {
            assert!((found / (force * 1e-4) - 1.0).abs() < 1e-4, "{found} for {}", force * 1e-4);
        }
    }
    let drowned = laws.replace(&format!("{area:?}"), "1e-6");
    let scene = format!(
        "(format: 1, duration: 1.0, fibers: [{lower}], contact: ({drowned}), stepper: (dt: 1e-4))"
    );
    let scene = Scene::from_ron(&scene).expect("a scene");
    let error = World::build(&scene).err().expect("it drowns");
    assert!(error.to_string().contains("area of the liquid"), "{error}");
}

/// What is bonded goes on from a snapshot as it would have, bit for bit, and does not glue again
/// what has broken.
#[test]
fn bonds_survive_a_snapshot() {
    for share in [1.01, 0.99] {
        let laws = format!(
            "friction: Isotropic(0.3), restitution: 0.2, \
             adhesion: Bonds(strength: {:?}, range: 1e-6)",
            share * weight()
        );
        let standing = hair(&Vector3::new(0.0, 0.0, RADIUS + 1e-7), &Vector3::z());
        let new = || run_of(&standing, GROUND, &laws, G, 1e-3);
        let mut run = new();
        for _ in 0..5 {
            run.step();
        }
        let mut other = new();
        other.world.restore(&run.world.snapshot()).expect("of the same scene");
        assert_eq!(run.world.contacts().any(|bearing| bearing.bonded), share > 1.0);
        for _ in 0..5 {
            run.step();
            other.step();
            assert_eq!(run.world.state(0).positions, other.world.state(0).positions);
        }
    }
}
