//! Branches of equilibria: critical loads and folds against closed forms.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rapunzel_rod_static::elliptic::first_kind;
use rapunzel_rod_static::{
    Branch, BranchEnd, EndCondition, EndHold, LimitKind, ParameterSweep, Piece, Problem,
    Properties, State, StaticError,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn piece(stiffness: [f64; 3], load: Vector3<f64>) -> Piece {
    let stiffness = Vector3::from(stiffness);
    Piece::uniform(1.0, Properties { stiffness, natural_curvature: Vector3::zeros(), load })
}

fn sliding(thrust: f64, hold: EndHold) -> EndCondition {
    let (point, along) = (Point3::origin(), Vector3::z_axis());
    EndCondition::Sliding { point, along, force: -thrust, hold }
}

/// The branch of the rod that is straight at the start up to where it buckles.
fn buckles(problem: &dyn Fn(f64) -> Result<Problem, StaticError>, to: f64) -> Branch {
    let start = problem(0.0).and_then(|rod| rod.solve()).expect("a straight rod");
    let sweep = ParameterSweep { problem, from: 0.0, to, steps: 10 };
    sweep.until_unstable(&start).expect("a branch")
}

/// Euler's four columns, and their modes.
#[test]
fn eulers_columns_buckle_at_their_loads() {
    let held = EndHold::Frame(UnitQuaternion::identity());
    let soft_in_one_plane = [1.0, 2.0, 1.0];
    let clamped = |end: EndCondition| {
        let rod = vec![piece(soft_in_one_plane, Vector3::zeros())];
        Problem::new(&Isometry3::identity(), rod, end)
    };
    let free = |thrust: f64| {
        let force = Vector3::new(0.0, 0.0, -thrust);
        clamped(EndCondition::Free { force, moment: Vector3::zeros() })
    };
    let guided = |thrust: f64| clamped(sliding(thrust, held));
    let propped = |thrust: f64| clamped(sliding(thrust, EndHold::Joint));
    let hinged = |thrust: f64| clamped(sliding(thrust, EndHold::Joint))?.hinged();
    // The first root of tan x = x.
    let x: f64 = 4.493_409_457_909_064;
    type Column<'a> = &'a dyn Fn(f64) -> Result<Problem, StaticError>;
    let columns: [Column; 4] = [&free, &guided, &propped, &hinged];
    let loads = [FRAC_PI_2.powi(2), TAU * TAU, x * x, PI * PI];
    for (i, (problem, critical)) in columns.into_iter().zip(loads).enumerate() {
        let branch = buckles(problem, 50.0);
        assert_eq!(branch.ended, BranchEnd::Lost, "column {i}");
        let limit = &branch.limits[0];
        let error = (limit.parameter / critical - 1.0).abs();
        assert!(error < 1e-9, "column {i}: {} for {critical}: {error:e}", limit.parameter);
        assert_eq!(limit.kind, LimitKind::Bifurcation);
        assert_eq!(limit.conjugate_points, [0, 1]);
        // The softer plane is that across d1.
        let shape = |s: f64| limit.mode.at(s)[0].y;
        let right = match i {
            0 => |s: f64| 1.0 - (FRAC_PI_2 * s).cos(),
            1 => |s: f64| 1.0 - (TAU * s).cos(),
            2 => |s: f64| {
                let x = 4.493_409_457_909_064_f64;
                x * s - (x * s).sin() - x * (1.0 - (x * s).cos())
            },
            _ => |s: f64| (PI * s).sin(),
        };
        for s in [0.2, 0.35, 0.5, 0.7] {
            let ratio = shape(s) / shape(0.6) * right(0.6) / right(s);
            assert!((ratio - 1.0).abs() < 1e-7, "column {i} at {s}: {ratio}");
        }
    }
}

/// Greenhill 1881, in both planes at once.
#[test]
fn an_upright_rod_buckles_under_its_weight() {
    let problem = |weight: f64| {
        let rod = vec![piece([1.0; 3], Vector3::new(0.0, 0.0, -weight))];
        Problem::new(&Isometry3::identity(), rod, EndCondition::FREE)
    };
    let branch = buckles(&problem, 20.0);
    let limit = &branch.limits[0];
    assert!((limit.parameter / 7.837_347_439 - 1.0).abs() < 1e-9, "{}", limit.parameter);
    assert_eq!(limit.conjugate_points, [0, 2]);
}

/// What makes no sweep is refused.
#[test]
fn a_sweep_needs_steps_a_range_and_a_definite_place() {
    let problem = |thrust: f64| {
        let rod = vec![piece([1.0; 3], Vector3::zeros())];
        Problem::new(&Isometry3::identity(), rod, sliding(thrust, EndHold::Joint))
    };
    let start = problem(0.0).and_then(|rod| rod.solve()).expect("a straight rod");
    let sweep =
        |steps, to| ParameterSweep { problem: &problem, from: 0.0, to, steps }.follow(&start);
    assert_eq!(sweep(0, 1.0).err(), Some(StaticError::NoSteps));
    assert_eq!(sweep(1, 0.0).err(), Some(StaticError::NoRange { value: 0.0 }));
    let near = ParameterSweep { problem: &problem, from: 0.0, to: 21.0, steps: 5 }.follow(&start);
    let near = near.expect("a branch").points.pop().expect("a point").equilibrium;
    let unstable = ParameterSweep { problem: &problem, from: 21.0, to: 40.0, steps: 1 };
    let straight = unstable.until_unstable(&near).err();
    assert_eq!(straight, Some(StaticError::Unstable { ways: 2 }));
    let rod = vec![piece([1.0; 3], Vector3::zeros())];
    let loose = Problem::new(&Isometry3::identity(), rod, EndCondition::FREE);
    assert_eq!(loose.and_then(Problem::hinged).err(), Some(StaticError::Loose));
}

/// Michell and Zajac: a ring leaves its plane at the twist `2 pi sqrt(3) EI / GJ`. It may turn
/// about its tangent at the clamp, which is neutral all along.
#[test]
fn a_twisted_ring_leaves_its_plane() {
    for torsion in [0.75, 1.4] {
        let problem = |twist: f64| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * twist);
            let end = EndCondition::Held(Isometry3::from_parts(Translation3::identity(), turn));
            Problem::new(
                &Isometry3::identity(),
                vec![piece([1.0, 1.0, torsion], Vector3::zeros())],
                end,
            )
        };
        let ring: Vec<(f64, State)> = (0..64)
            .map(|i| {
                let s = f64::from(i) / 64.0;
                let (sin, cos) = (TAU * s).sin_cos();
                let frame = UnitQuaternion::from_scaled_axis(Vector3::y() * (TAU * s));
                let state = State {
                    position: Point3::new((1.0 - cos) / TAU, 0.0, sin / TAU),
                    frame: frame.to_rotation_matrix(),
                    force: Vector3::zeros(),
                    moment: Vector3::y() * TAU,
                };
                (s, state)
            })
            .collect();
        let start = problem(0.0).and_then(|rod| rod.solve_near(&ring)).expect("a ring");
        let sweep = ParameterSweep { problem: &problem, from: 0.0, to: 30.0, steps: 20 };
        let branch = sweep.until_unstable(&start).expect("a branch");
        let limit = &branch.limits[0];
        let critical = TAU * 3.0_f64.sqrt() / torsion;
        let error = (limit.parameter / critical - 1.0).abs();
        assert!(error < 1e-9, "{} for {critical}: {error:e}", limit.parameter);
        for point in &branch.points {
            let energy = 0.5 * (TAU * TAU + torsion * point.parameter.powi(2));
            assert!((point.equilibrium.energy() / energy - 1.0).abs() < 1e-10);
        }
    }
}

/// A cantilever at the angle `LEAN` to the thrust on its end that leans to the other side: with the
/// modulus `k = sin(theta_1 / 2)` of the angle of its end it carries `(K(k) + F(phi, k))^2`,
/// `sin(phi) = sin(LEAN / 2) / k`, whose least value is where it snaps back.
const LEAN: f64 = 0.3;

fn thrust(k: f64) -> f64 {
    let integral = |phi: f64| first_kind(phi, k * k).expect("an integral");
    (integral(FRAC_PI_2) + integral(((0.5 * LEAN).sin() / k).min(1.0).asin())).powi(2)
}

#[test]
fn a_leaning_cantilever_snaps_at_its_fold() {
    // Golden section.
    let (mut low, mut high) = ((0.5 * LEAN).sin(), 0.9);
    for _ in 0..100 {
        let inner = [high - 0.618_033_988_75 * (high - low), low + 0.618_033_988_75 * (high - low)];
        *(if thrust(inner[0]) < thrust(inner[1]) { &mut high } else { &mut low }) =
            if thrust(inner[0]) < thrust(inner[1]) { inner[1] } else { inner[0] };
    }
    let critical = thrust(0.5 * (low + high));
    // In the plane of x and z, stiff out of it.
    let clamp = Isometry3::rotation(Vector3::y() * LEAN);
    let problem = |thrust: f64| {
        let rod = vec![piece([90.0, 1.0, 90.0], Vector3::zeros())];
        let force = Vector3::new(0.0, 0.0, -thrust);
        Problem::new(&clamp, rod, EndCondition::Free { force, moment: Vector3::zeros() })
    };
    let k: f64 = 0.8;
    let most = thrust(k);
    let moment = -(2.0 * most * (LEAN.cos() - 1.0 + 2.0 * k * k)).sqrt();
    let root = State {
        position: Point3::origin(),
        frame: clamp.rotation.to_rotation_matrix(),
        force: Vector3::new(0.0, 0.0, -most),
        moment: Vector3::new(0.0, moment, 0.0),
    };
    let start = problem(most).and_then(|rod| rod.solve_near(&[(0.0, root)])).expect("it leans");
    assert!(start.is_stable() && start.tip().position.x < 0.0);
    let branch =
        ParameterSweep { problem: &problem, from: most, to: 1.0, steps: 20 }.follow(&start);
    let branch = branch.expect("a branch");
    assert_eq!(branch.ended, BranchEnd::Returned);
    let [limit] = &branch.limits[..] else { panic!("{} limits", branch.limits.len()) };
    assert_eq!((limit.kind, limit.conjugate_points), (LimitKind::Fold, [0, 1]));
    let error = (limit.parameter / critical - 1.0).abs();
    assert!(error < 1e-9, "{} for {critical}: {error:e}", limit.parameter);
    // Each point is on the curve of thrust against modulus.
    for point in &branch.points {
        let tip = point.equilibrium.tip().frame * Vector3::z();
        let k = (0.5 * (1.0 - tip.z)).sqrt();
        let error = (thrust(k) / point.parameter - 1.0).abs();
        assert!(error < 1e-9, "at {}: {error:e}", point.parameter);
    }
}

/// The plane elastica under a dead thrust in its second mode, `sqrt(F) = 3 K(k)`, from a curve.
#[test]
fn a_curve_in_the_second_mode_leads_to_it() {
    let k: f64 = 0.6;
    let thrust = (3.0 * first_kind(FRAC_PI_2, k * k).expect("an integral")).powi(2);
    // `theta'' = -F sin(theta)` in small steps.
    let (mut angle, mut bend) = (0.0_f64, 2.0 * thrust.sqrt() * k);
    let (mut at, mut points) = (Point3::<f64>::origin(), Vec::new());
    let steps = 100_000;
    for i in 0..=steps {
        if i % 1000 == 0 {
            points.push(at);
        }
        let h = 1.0 / f64::from(steps);
        let middle = angle + 0.5 * h * bend;
        bend -= h * thrust * middle.sin();
        angle = middle + 0.5 * h * bend;
        at += Vector3::new(middle.sin(), 0.0, middle.cos()) * h;
    }
    let rod = vec![piece([50.0, 1.0, 50.0], Vector3::zeros())];
    let force = Vector3::new(0.0, 0.0, -thrust);
    let free = EndCondition::Free { force, moment: Vector3::zeros() };
    let problem = |end| Problem::new(&Isometry3::identity(), rod.clone(), end).expect("a problem");
    let found = problem(free).solve_along(&points).expect("the second mode");
    let sine = |tip: State| (0.5 * (1.0 - (tip.frame * Vector3::z()).z)).sqrt();
    assert!((sine(found.tip()) / k - 1.0).abs() < 1e-10, "{}", sine(found.tip()));
    assert_eq!(found.conjugate_points(), 1);
    // Held where that ends, the force is found too.
    let tip = found.tip();
    let end = Isometry3::from_parts(
        Translation3::from(tip.position),
        UnitQuaternion::from_rotation_matrix(&tip.frame),
    );
    let held = problem(EndCondition::Held(end)).solve_along(&points).expect("the second mode");
    assert!((held.tip().force - force).norm() < 1e-7 * thrust, "{}", held.tip().force);
    assert_eq!(problem(free).solve_along(&points[..2]).err(), Some(StaticError::NotFound));
}
