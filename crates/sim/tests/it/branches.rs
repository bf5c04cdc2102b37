//! Cases that ask for a start, a way of equilibria or a critical load, against closed forms.

use nalgebra::{Point3, Vector3};
use rapunzel_rod_static::elliptic::first_kind;
use rapunzel_sim::SimError;
use rapunzel_sim::statics::{Case, CaseAnswer, Ended, Stability, solve};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A rod of 1 m without weight, with what else is said of it.
fn text(bending: &str, more: &str) -> String {
    format!(
        "(format: 1, length: 1.0, gravity: (0, 0, 0),
         rod: Measured(bending: {bending}, torsion: 0.75, linear_density: 0, radius: 0.001),
         clamp: (orientation: Euler(degrees: (0, 0, 0))), {more})"
    )
}

fn case(bending: &str, more: &str) -> Case {
    Case::from_ron(&text(bending, more)).unwrap_or_else(|error| panic!("{error}"))
}

fn answer(bending: &str, more: &str) -> CaseAnswer {
    solve(&case(bending, more)).unwrap_or_else(|error| panic!("{error}"))
}

/// The critical value, and how many ways lead down behind it.
fn critical(bending: &str, more: &str) -> (f64, usize) {
    let branch = answer(bending, more).branch.expect("a branch");
    assert_eq!((branch.ended, branch.limits.len()), (Ended::Lost, 1));
    let mode = branch.limits[0].mode.iter().map(|one| Vector3::from(one.displacement).norm());
    assert!((mode.fold(0.0, f64::max) - 1.0).abs() < 1e-12);
    (branch.limits[0].parameter, branch.limits[0].ways_down[1])
}

#[test]
fn eulers_four_columns() {
    let slides = |hold: &str| {
        format!("end: Sliding(position: (0, 0, 1), direction: (0, 0, -1), force: 1, hold: {hold})")
    };
    let clamped = slides("Clamped(orientation: Euler(degrees: (0, 0, 0)))");
    let joint = slides("Joint");
    let hinged = format!("root: Joint, {joint}");
    let free = "end: Free(force: (0, 0, -1))".to_owned();
    // The first root of tan x = x.
    let x: f64 = 4.493_409_457_909_064;
    for (end, right) in
        [(free, FRAC_PI_2.powi(2)), (clamped, TAU * TAU), (joint, x * x), (hinged, PI * PI)]
    {
        let (found, ways) =
            critical("(1.0, 2.0)", &format!("{end}, critical: (of: EndForce, up_to: 60)"));
        assert!((found / right - 1.0).abs() < 1e-8, "{end}: {found} for {right}");
        assert_eq!(ways, 1);
    }
}

/// Over to the bent branch of a column: the elastica of its last load, to either side.
#[test]
fn a_column_is_followed_bent() {
    let end = |side: &str| {
        let more = format!(
            "end: Free(force: (0, 0, -1)),
             sweep: (of: EndForce, from: 0, to: 5, steps: 10, switch: (at: 0, other_side: {side}))"
        );
        let found = answer("(1.0, 2.0)", &more);
        let branch = found.branch.expect("a branch");
        assert_eq!((branch.ended, branch.limits.len()), (Ended::Reached, 1));
        let first = branch.switched.expect("another branch");
        assert!(branch.points[first].parameter > FRAC_PI_2.powi(2));
        assert!(branch.points.iter().all(|point| point.ways_down == 0));
        let words = "other branch from the bifurcation at 2.467401";
        assert!(branch.table().lines().nth(first + 1).is_some_and(|row| row.contains(words)));
        branch.points[branch.points.len() - 1].end_position
    };
    let [one, other] = ["false", "true"].map(end);
    // The quarter period of its modulus k is the root of the load, and it goes 2 k / root aside.
    let modulus = 0.5 * one[1].abs() * 5.0_f64.sqrt();
    let period = first_kind(FRAC_PI_2, modulus * modulus).expect("a modulus");
    assert!((period - 5.0_f64.sqrt()).abs() < 1e-8, "{period}");
    assert!((one[1] + other[1]).abs() < 1e-8 && one[0].abs() < 1e-8, "{one:?} {other:?}");
}

/// Greenhill 1881, by the weight and by the length.
#[test]
fn greenhills_column() {
    let upright = |asked: &str| {
        let text = text("(1.0, 1.0)", &format!("critical: {asked}"));
        let text = text.replace("gravity: (0, 0, 0)", "gravity: (0, 0, -1)");
        let text = text.replace("linear_density: 0", "linear_density: 1");
        let answer = solve(&Case::from_ron(&text).expect("a case")).expect("an answer");
        answer.branch.expect("a branch").limits[0].parameter
    };
    let right: f64 = 7.837_347_439;
    assert!((upright("(of: Gravity, up_to: 20)") / right - 1.0).abs() < 1e-8);
    assert!((upright("(of: Length, up_to: 3)") / right.cbrt() - 1.0).abs() < 1e-8);
}

/// Michell 1889, Zajac 1962; the energy and the reaction of a twisted ring.
#[test]
fn a_ring_leaves_its_plane() {
    let (found, _) = critical("(1.0, 1.0)", "end: Ring(), critical: (of: EndTwist, up_to: 1500)");
    let right = (TAU * 3.0_f64.sqrt() / 0.75).to_degrees();
    assert!((found / right - 1.0).abs() < 1e-8, "{found} for {right}");
    for twist in [360.0, 800.0] {
        let answer = answer("(1.0, 1.0)", &format!("end: Ring(twist: {twist:?})"));
        let ring = &answer.equilibria[0];
        let twist = f64::to_radians(twist);
        let energy = 0.5 * (TAU * TAU + 0.75 * twist * twist);
        assert!((ring.elastic_energy / energy - 1.0).abs() < 1e-10);
        let force = Vector3::from(ring.clamp_force).norm();
        assert!((force / (0.75 * twist * TAU) - 1.0).abs() < 1e-8, "{force}");
        assert_eq!(ring.stability, Stability::Stable);
    }
}

/// The plane elastica under a dead thrust along z, in its second mode: `sqrt(F) = 3 K(k)`.
#[test]
fn a_start_in_the_second_mode_finds_it() {
    let thrust = 40.0_f64;
    let (mut low, mut high) = (0.01, 0.99);
    for _ in 0..100 {
        let k: f64 = 0.5 * (low + high);
        let quarter = first_kind(FRAC_PI_2, k * k).expect("an integral");
        *(if 3.0 * quarter < thrust.sqrt() { &mut low } else { &mut high }) = k;
    }
    let k = 0.5 * (low + high);
    // `theta'' = -F sin(theta)`, by small steps.
    let (mut angle, mut bend) = (0.0_f64, 2.0 * thrust.sqrt() * k);
    let (mut at, mut lines) = (Point3::<f64>::origin(), String::new());
    let steps = 100_000;
    for i in 0..=steps {
        if i % 1000 == 0 {
            lines += &format!("{} 0 {}\n", at.x, at.z);
        }
        let h = 1.0 / f64::from(steps);
        let middle = angle + 0.5 * h * bend;
        bend -= h * thrust * middle.sin();
        angle = middle + 0.5 * h * bend;
        at += Vector3::new(middle.sin(), 0.0, middle.cos()) * h;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("mode.txt");
    std::fs::write(&file, lines).expect("written");
    let end = format!("end: Free(force: (0, 0, -{thrust:?}))");
    let of = |start: &str| {
        let case = case("(50.0, 1.0)", &format!("{end}, start: {start}")).seen_from(folder.path());
        let answer = solve(&case).unwrap_or_else(|error| panic!("{error}"));
        answer.save(&folder.path().join("out"), &case).expect("saved");
        answer.equilibria[0].clone()
    };
    let found = of("Curve(\"mode.txt\")");
    // One way leads down in the plane, to the first mode, and one out of it.
    assert_eq!(found.stability, Stability::Unstable(2));
    let tip = found.stations[found.stations.len() - 1];
    let sine = (0.5 * (1.0 - tip.frame[2][2])).sqrt();
    assert!((sine / k - 1.0).abs() < 1e-9, "{sine} for {k}");
    // Without a start it is the first mode; from the table of the second, the second.
    let again = of("Answer(\"out/rod-0.csv\")");
    assert!((again.elastic_energy / found.elastic_energy - 1.0).abs() < 1e-9);
    assert_eq!(answer("(50.0, 1.0)", &end).equilibria[0].stability, Stability::Stable);
}

/// Two rods joined end to end turn by the couple over their stiffness.
#[test]
fn joined_rods_bend_each_by_their_stiffness() {
    let more = "end: Free(moment: (0, 0.3, 0)),
                joined: [(from: 0.4, natural_curvature: (0, 0.5, 0),
                    rod: Measured(bending: (0.2, 0.2), torsion: 1, linear_density: 0, radius: 0.001))]";
    let answer = answer("(1.0, 1.0)", more);
    let tip = answer.equilibria[0].stations[100];
    let right: f64 = 0.3 * (0.4 / 1.0 + 0.6 / 0.2) + 0.5 * 0.6;
    assert!((tip.frame[2][0].atan2(tip.frame[2][2]) - right).abs() < 1e-12);
    assert!((tip.curvature[1] - 2.0).abs() < 1e-12);
}

/// A clamped end pushed aside and turned: the sweep ends where it is told, and its table is whole.
#[test]
fn a_sweep_is_a_table() {
    let held = "end: Clamped(position: (0, 0, 0.8), orientation: Euler(degrees: (0, 0, 0)))";
    let more =
        format!("{held}, sweep: (of: EndMove((0.1, 0, 0)), from: 0, to: 2, steps: 8, shapes: 3)");
    let answer = answer("(1.0, 3.0)", &more);
    let branch = answer.branch.as_ref().expect("a branch");
    assert_eq!((branch.ended, answer.equilibria.len()), (Ended::Reached, 3));
    let last = branch.points[branch.points.len() - 1];
    assert!((last.parameter - 2.0).abs() < 1e-12 && (last.end_position[0] - 0.2).abs() < 1e-9);
    let table = branch.table();
    assert_eq!(table.lines().count(), 1 + branch.points.len());
    let columns = table.lines().map(|line| line.split(',').count());
    assert!(columns.clone().all(|count| count == 21), "{:?}", columns.collect::<Vec<_>>());
    // The force on the end is the slope of the energy along the way.
    let [.., a, b] = &branch.points[..] else { panic!("two points") };
    let slope = (b.elastic_energy - a.elastic_energy) / (b.parameter - a.parameter) / 0.1;
    let mean = 0.5 * (a.end_force[0] + b.end_force[0]);
    assert!((slope / mean - 1.0).abs() < 1e-2, "{slope} for {mean}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let free = "end: Free(force: (0, 0, -1))";
    for (more, says) in [
        (format!("{free}, sweep: (of: EndForce, from: 0, to: 9, steps: 0)"), "sweep.steps"),
        (format!("{free}, sweep: (of: EndForce, from: 9, to: 9, steps: 3)"), "give a range"),
        (format!("{free}, sweep: (of: Wind, from: 0, to: 9, steps: 3)"), "EndForce"),
        ("critical: (of: EndForce, up_to: 9)".into(), "the end bears none"),
        (format!("{free}, critical: (of: EndTwist, up_to: 9)"), "not clamped"),
        (format!("{free}, critical: (of: Force(2), up_to: 9)"), "`forces` has 0"),
        ("end: Free(moment: (0, 0, 1)), critical: (of: EndMoment, up_to: 9)".into(), "flutter"),
        (
            "forces: [(at: 1, value: (0, 0, -1), frame: Follower)],
             critical: (of: Force(0), up_to: 9)"
                .into(),
            "not conservative",
        ),
        (format!("{free}, root: Joint"), "no definite place"),
        (
            "joined: [(from: 1.5, rod: Measured(bending: (1, 1), torsion: 1, linear_density: 0,
             radius: 0.001))]"
                .into(),
            "before the end",
        ),
    ] {
        let error = Case::from_ron(&text("(1.0, 1.0)", &more)).expect_err(&more).to_string();
        assert!(error.contains(says), "{more}: {error}");
    }
    let never = case("(1.0, 1.0)", &format!("{free}, critical: (of: EndForce, up_to: 2)"));
    let error = solve(&never).expect_err("it stands");
    assert!(matches!(error, SimError::Case(_)) && error.to_string().contains("raise `up_to`"));
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("short.txt"), "0 0 0\n0 0 0.2\n0 0 0.5\n").expect("written");
    let short = case("(1.0, 1.0)", &format!("{free}, start: Curve(\"short.txt\")"));
    let error = solve(&short.seen_from(folder.path())).expect_err("it is short").to_string();
    assert!(error.contains("is 0.5 m long, but the rod is 1.0 m"), "{error}");
}
