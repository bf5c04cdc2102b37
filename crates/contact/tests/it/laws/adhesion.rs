//! What sticks: glue and water.
use crate::common::{Dense, G, circle, contact, exact, resolve};
use nalgebra::Vector3;
use rapunzel_contact::{Bond, Cylinders, wet_pair_energy};
use std::f64::consts::{FRAC_PI_2, PI};

const WATER: f64 = 0.072;
const HAIR: f64 = 35e-6;

/// A weight glued under a ceiling, pulled more from step to step.
#[test]
fn a_bond_holds_until_its_force() {
    let dt = 1e-3;
    // Light hold, Tab. 2.12.
    let mut bond = Bond::new(0.1).expect("positive");
    let mass = 1e-3;
    let mut weight = [Dense::particle(mass)];
    let mut contacts = [contact(0, None, &-Vector3::z(), circle(0.5))];
    let mut force = 0.0;
    while force < 0.2 {
        weight[0].push(&[0.01 * dt, 0.0, -(mass * G + force) * dt]);
        contacts[0].adhesion = bond.adhesion(dt);
        let mut impulses = [Vector3::zeros()];
        assert!(resolve(&mut weight, &contacts, &mut impulses, &mut exact()).converged);
        let u = contacts[0].frame.tr_mul(&weight[0].velocities()[0]);
        let load = mass * G + force;
        // Friction is what the pull leaves of the bond: 0.5 (0.1 - load) holds 0.01.
        if bond.is_intact() && load < 0.08 {
            assert!(u.norm() < 1e-15, "{load} {u}");
        }
        let broke = bond.update(&contacts[0], &u, &impulses[0], 1e-12);
        assert_eq!(broke, bond.adhesion(dt) == 0.0 && contacts[0].adhesion > 0.0);
        if broke {
            assert!((load - 0.1).abs() < 1.01e-3, "{load}");
        }
        if !bond.is_intact() && !broke {
            assert_eq!(impulses[0], Vector3::zeros());
        }
        force += 1e-3;
    }
    assert!(!bond.is_intact());
    for strength in [0.0, -1.0, f64::NAN] {
        assert!(Bond::new(strength).is_err());
    }
}

#[test]
fn the_work_of_a_wet_pair_is_known() {
    let energy = wet_pair_energy(HAIR, WATER);
    assert!((energy - 5.754e-6).abs() < 1e-9, "{energy}");
    // Bico: L_dry^4 = 9 B d^2 / W of clamped hairs 0.707 mm apart.
    let bending = 4e9 * PI * HAIR.powi(4) / 4.0;
    let dry = (9.0 * bending * 0.707e-3_f64.powi(2) / energy).powf(0.25);
    assert!((dry - 7.792e-3).abs() < 1e-5, "{dry}");
    // It is the difference of the perimeters with flat menisci.
    let pair = Cylinders::new(HAIR, WATER).expect("positive");
    let joined = pair.parallel_energy(0.0, (4.0 - PI) * HAIR * HAIR).expect("wet");
    assert!((4.0 * PI * HAIR * WATER - joined - energy).abs() < 1e-12 * energy);
}

#[test]
fn the_parallel_force_is_the_slope_of_the_energy() {
    let pair = Cylinders::new(HAIR, WATER).expect("positive");
    let flat = (4.0 - PI) * HAIR * HAIR;
    let mut last_reach = 0.0;
    for share in [0.01, 0.1, 0.5, 0.9] {
        let area = share * flat;
        let step = 1e-4 * HAIR;
        let mut gap = 0.0;
        while pair.parallel_energy(gap + 2.0 * step, area).is_some() {
            let energy = |gap: f64| pair.parallel_energy(gap, area).expect("wet");
            let slope = (energy(gap + 2.0 * step) - energy(gap)) / (2.0 * step);
            let force = pair.parallel_force(gap + step, area);
            assert!((slope / force - 1.0).abs() < 1e-4, "{share} {gap}: {slope} {force}");
            // The menisci alone pull with twice the tension; a neck adds to it.
            assert!(force > 2.0 * WATER, "{share} {gap}: {force}");
            gap += 0.01 * HAIR;
        }
        let reach = pair.reach(area);
        assert!((reach - gap).abs() < 0.011 * HAIR && pair.parallel_force(reach, area) > 0.0);
        assert_eq!(pair.parallel_force(reach * (1.0 + 1e-12), area), 0.0);
        assert!(gap > last_reach, "more liquid reaches farther");
        assert_eq!(pair.parallel_force(gap + 0.1 * HAIR, area), 0.0);
        last_reach = gap;
    }
    assert!((pair.parallel_force(0.0, flat) / (2.0 * WATER) - 1.0).abs() < 1e-6);
    assert_eq!(pair.parallel_force(0.0, 0.0), 0.0);
    assert_eq!(pair.reach(0.0), 0.0);
    assert_eq!(pair.parallel_force(-HAIR, flat), pair.parallel_force(0.0, flat));
}

#[test]
fn crossed_fibers_attract_as_a_sphere_does_a_plane() {
    let pair = Cylinders::new(HAIR, WATER).expect("positive");
    let sphere = 4.0 * PI * WATER * HAIR;
    let volume = 1e-3 * HAIR.powi(3);
    assert!((pair.crossed_force(0.0, volume, FRAC_PI_2) / sphere - 1.0).abs() < 1e-15);
    assert!((pair.crossed_force(0.0, volume, PI / 6.0) / sphere - 2.0).abs() < 1e-12);
    let mut last = f64::INFINITY;
    for k in 0..10 {
        let force = pair.crossed_force(0.1 * f64::from(k) * volume.cbrt(), volume, FRAC_PI_2);
        assert!(force < last && force > 0.0);
        last = force;
    }
    assert_eq!(pair.crossed_force(1.01 * volume.cbrt(), volume, FRAC_PI_2), 0.0);
    assert_eq!(pair.crossed_force(0.0, 0.0, FRAC_PI_2), 0.0);
    assert!(Cylinders::new(0.0, WATER).is_err() && Cylinders::new(HAIR, f64::NAN).is_err());
}
