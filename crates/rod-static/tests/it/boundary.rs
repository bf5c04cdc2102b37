//! Boundary values against the reference values.

use crate::common::reference::{Elastica, HeavyRod};
use crate::common::rotation;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;
use rapunzel_oracles::cases;
use rapunzel_rod_static::{EndCondition, Equilibrium, Piece, Problem, Properties, State};
use serde::Deserialize;

/// Allowed errors: position in lengths, frame in radians, force and moment in parts of their size.
const ALLOWED: [f64; 3] = [1e-9, 1e-8, 1e-6];

/// Errors of a state in position, frame, force and moment.
fn errors(found: &State, exact: &State) -> [f64; 3] {
    let relative = |a: Vector3<f64>, b: Vector3<f64>| (a - b).norm() / b.norm().max(1.0);
    [
        (found.position - exact.position).norm(),
        so3::log(&(found.frame * exact.frame.inverse())).norm(),
        relative(found.force, exact.force).max(relative(found.moment, exact.moment)),
    ]
}

fn check(name: &str, worst: &[f64; 3]) {
    let fine = worst.iter().zip(ALLOWED).all(|(w, allowed)| *w < allowed);
    assert!(fine, "{name}: {worst:?} of {ALLOWED:?}");
}

fn larger(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0].max(b[0]), a[1].max(b[1]), a[2].max(b[2])]
}

fn problem(case: &Elastica) -> Problem {
    Problem::new(&case.clamp(), vec![case.piece()], EndCondition::FREE).expect("a problem")
}

/// All equilibria of all cases, the unstable ones too, from a start near them: states, energies.
#[test]
fn planar_equilibria_of_the_reference() {
    for case in cases::<Elastica>("b_heavy_elastica_planar.json").expect("the oracle") {
        let problem = problem(&case);
        for (i, equilibrium) in case.equilibria.iter().enumerate() {
            let name = format!("{}, equilibrium {i}", case.name);
            let states = case.states(equilibrium);
            let found = problem.solve_near(&states).unwrap_or_else(|e| panic!("{name}: {e}"));
            let mut worst = [0.0; 3];
            for (s, exact) in &states {
                worst = larger(worst, errors(&found.at(*s), exact));
            }
            check(&name, &worst);
            let moment = found.root().moment.z - equilibrium.root_moment;
            assert!(moment.abs() < 1e-6 * equilibrium.root_moment.abs().max(1.0), "{name}");
            let scale = 1.0 + case.g;
            assert!((found.elastic_energy() - equilibrium.elastic).abs() < 1e-9 * scale, "{name}");
            assert!((found.energy() - equilibrium.energy).abs() < 1e-9 * scale, "{name}");
            let index = found.conjugate_points();
            assert_eq!(found.is_stable(), equilibrium.stable, "{name}: index {index}");
        }
    }
}

/// From the unloaded shape, and for upright rods from bent ones: a stable equilibrium of the list.
#[test]
fn planar_rods_find_a_stable_equilibrium() {
    for case in cases::<Elastica>("b_heavy_elastica_planar.json").expect("the oracle") {
        let found = problem(&case).solve().unwrap_or_else(|e| panic!("{}: {e}", case.name));
        let known = case
            .equilibria
            .iter()
            .any(|e| e.stable && (e.energy - found.energy()).abs() < 1e-9 * (1.0 + case.g));
        assert!(found.is_stable() && known, "{}: energy {}", case.name, found.energy());
    }
}

#[test]
fn heavy_rods_of_the_reference() {
    for case in cases::<HeavyRod>("b_heavy_rod_3d.json").expect("the oracle") {
        let problem =
            Problem::new(&case.clamp(), vec![case.piece()], EndCondition::FREE).expect("a problem");
        let found = problem.solve().unwrap_or_else(|e| panic!("{}: {e}", case.name));
        let mut worst = [0.0; 3];
        for station in &case.stations {
            let exact = State {
                position: Point3::from(station.r),
                frame: rotation(&station.frame),
                force: Vector3::new(0.0, 0.0, -case.g * (1.0 - station.s)),
                moment: Vector3::from(station.m_fixed),
            };
            worst = larger(worst, errors(&found.at(station.s), &exact));
        }
        check(&case.name, &worst);
        assert!((found.energy() - case.energy).abs() < 1e-9 * (1.0 + case.g), "{}", case.name);
        assert!((found.elastic_energy() - case.elastic).abs() < 1e-9, "{}", case.name);
        assert_eq!(found.is_stable(), case.stable, "{}", case.name);
    }
}

/// A case of `c_clamped_clamped.json`: L = 1, gravity -z, the root at the origin.
#[derive(Debug, Deserialize)]
struct Clamped {
    name: String,
    #[serde(rename = "G")]
    g: f64,
    #[serde(rename = "EI1")]
    ei1: f64,
    #[serde(rename = "EI2")]
    ei2: f64,
    #[serde(rename = "Gmu")]
    torsion: f64,
    kappa0: [f64; 3],
    start_moment: [f64; 3],
    path_from_start_state: Vec<Waypoint>,
    #[serde(rename = "R1")]
    end: [[f64; 3]; 3],
    r1: [f64; 3],
    #[serde(rename = "force_n_at_0")]
    force: [f64; 3],
    #[serde(rename = "force_n_at_1")]
    tip_force: [f64; 3],
    #[serde(rename = "moment_m_at_0_fixed")]
    moment: [f64; 3],
    #[serde(rename = "moment_m_at_1_fixed")]
    tip_moment: [f64; 3],
    #[serde(rename = "E_elastic")]
    elastic: f64,
    #[serde(rename = "E_gravity")]
    gravity: f64,
    stable: bool,
    stations: Vec<ClampedStation>,
}

#[derive(Debug, Deserialize)]
struct Waypoint {
    r: [f64; 3],
    rotvec: [f64; 3],
}

#[derive(Debug, Deserialize)]
struct ClampedStation {
    s: f64,
    r: [f64; 3],
    #[serde(rename = "R")]
    frame: [[f64; 3]; 3],
}

#[test]
fn clamped_rods_of_the_reference() {
    for case in cases::<Clamped>("c_clamped_clamped.json").expect("the oracle") {
        let problem = |end| {
            let piece = Piece::uniform(
                1.0,
                Properties {
                    stiffness: Vector3::new(case.ei1, case.ei2, case.torsion),
                    natural_curvature: Vector3::from(case.kappa0),
                    load: Vector3::new(0.0, 0.0, -case.g),
                },
            );
            Problem::new(&Isometry3::identity(), vec![piece], end).expect("a problem")
        };
        let mut found: Equilibrium =
            problem(EndCondition::FREE).bent(&Vector3::from(case.start_moment)).expect("a start");
        for to in &case.path_from_start_state {
            let to = Isometry3::from_parts(
                Translation3::from(Vector3::from(to.r)),
                UnitQuaternion::from_scaled_axis(Vector3::from(to.rotvec)),
            );
            found = problem(EndCondition::Held(to))
                .solve_from(&found)
                .unwrap_or_else(|e| panic!("{}: {e}", case.name));
        }
        let mut worst = [0.0; 3];
        for station in &case.stations {
            let at = found.at(station.s);
            let exact =
                State { position: Point3::from(station.r), frame: rotation(&station.frame), ..at };
            worst = larger(worst, errors(&at, &exact));
        }
        let ends = [
            (
                found.root(),
                State { force: case.force.into(), moment: case.moment.into(), ..found.root() },
            ),
            (
                found.tip(),
                State {
                    position: case.r1.into(),
                    frame: rotation(&case.end),
                    force: case.tip_force.into(),
                    moment: case.tip_moment.into(),
                },
            ),
        ];
        for (at, exact) in &ends {
            worst = larger(worst, errors(at, exact));
        }
        check(&case.name, &worst);
        assert!((found.elastic_energy() - case.elastic).abs() < 1e-8, "{}", case.name);
        assert!((found.load_energy() - case.gravity).abs() < 1e-8, "{}", case.name);
        assert_eq!(found.is_stable(), case.stable, "{}", case.name);
        // Without the reference's start the same is found: it is the nearest stable one.
        let end = Isometry3::from_parts(
            Translation3::from(Vector3::from(case.r1)),
            UnitQuaternion::from_rotation_matrix(&rotation(&case.end)),
        );
        let again = problem(EndCondition::Held(end)).solve().expect("an equilibrium");
        assert!((again.energy() - found.energy()).abs() < 1e-9, "{}", case.name);
    }
}
