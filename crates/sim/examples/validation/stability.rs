//! Loads, turns and shapes at which rods lose their stability, by the branches of `rod-static`.

use crate::discrete::{self, frame, rests};
use crate::theory::{columns, hanging_curl, ring_twist, snap_thrust, upright_buckling};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, Figure, check};
use rapunzel_rod_dynamic::Instant;
use rapunzel_rod_static::{
    Branch, EndCondition, EndHold, Equilibrium, ParameterSweep, Piece, Problem, Properties, State,
    StaticError,
};
use std::f64::consts::{PI, TAU};

/// Relative error of a critical value: the mesh resolves its variation to order eight, and the
/// singular value is known to a rounding.
const CRITICAL: f64 = 1e-8;

type Family<'a> = &'a dyn Fn(f64) -> Result<Problem, StaticError>;

fn rod(stiffness: [f64; 3], natural: Vector3<f64>, load: Vector3<f64>) -> Vec<Piece> {
    let (stiffness, natural_curvature) = (stiffness.into(), natural);
    vec![Piece::uniform(1.0, Properties { stiffness, natural_curvature, load })]
}

/// The first limit of the branch from `start` on.
fn limit(problem: Family<'_>, [from, to]: [f64; 2], start: &Equilibrium) -> Fallible<f64> {
    let branch = ParameterSweep { problem, from, to, steps: 20 }.until_unstable(start)?;
    Ok(branch.limits.first().ok_or("it does not lose its stability")?.parameter)
}

fn beside(name: impl Into<String>, found: f64, right: f64, theory: &'static str) -> ClaimCheck {
    let room = CRITICAL * right;
    check(name.into(), found, "", Criterion::Within(right - room, right + room), theory)
}

/// Euler's four columns and Greenhill's.
pub(crate) fn buckling() -> Fallible<Figure> {
    let zero = Vector3::zeros();
    let straight = |end: EndCondition| {
        Problem::new(&Isometry3::identity(), rod([1.0, 2.0, 1.0], zero, zero), end)
    };
    let slides = |thrust: f64, hold: EndHold| {
        let (point, along) = (Point3::origin(), Vector3::z_axis());
        straight(EndCondition::Sliding { point, along, force: -thrust, hold })
    };
    let free = |thrust: f64| {
        let force = -thrust * Vector3::z();
        straight(EndCondition::Free { force, moment: zero })
    };
    let joints = |thrust: f64| slides(thrust, EndHold::Joint)?.hinged();
    let propped = |thrust: f64| slides(thrust, EndHold::Joint);
    let clamps = |thrust: f64| slides(thrust, EndHold::Frame(UnitQuaternion::identity()));
    let upright = |weight: f64| {
        let pieces = rod([1.0; 3], zero, -weight * Vector3::z());
        Problem::new(&Isometry3::identity(), pieces, EndCondition::FREE)
    };
    let [a, b, c, d] = columns();
    let all: [(&str, Family<'_>, f64, &str); 5] = [
        ("free above a clamp", &free, a, "pi^2 / 4"),
        ("between joints", &joints, b, "pi^2"),
        ("a joint above a clamp", &propped, c, "tan x = x"),
        ("between clamps", &clamps, d, "4 pi^2"),
        ("under its own weight", &upright, upright_buckling(), "zero of J(-1/3)"),
    ];
    let mut checks = Vec::new();
    for (name, problem, right, theory) in all {
        let found = limit(problem, [0.0, 60.0], &problem(0.0)?.solve()?)?;
        checks.push(beside(name, found, right, theory));
    }
    Ok(Figure {
        scene: "straight rods under a thrust on their end, and one under its weight",
        parameters: "loads in units of B / L^2, twice as stiff in the other plane",
        checks,
        drawings: Vec::new(),
    })
}

/// A ring that is twisted before it is closed.
pub(crate) fn ring() -> Fallible<Figure> {
    let mut checks = Vec::new();
    let mut points = [Vec::new(), Vec::new()];
    for torsion in [0.6, 0.8, 1.0, 1.25, 1.5] {
        let problem = |twist: f64| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * twist);
            let end = EndCondition::Held(Isometry3::from_parts(Translation3::identity(), turn));
            let pieces = rod([1.0, 1.0, torsion], Vector3::zeros(), Vector3::zeros());
            Problem::new(&Isometry3::identity(), pieces, end)
        };
        let state = |i: u32| {
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
        };
        let start = problem(0.0)?.solve_near(&(0..64).map(state).collect::<Vec<_>>())?;
        let found = limit(&problem, [0.0, 30.0], &start)?;
        let right = ring_twist(torsion);
        checks.push(beside(
            format!("twist, C / B = {torsion}"),
            found,
            right,
            "2 pi sqrt(3) B / C",
        ));
        points[0].push([torsion, found]);
        points[1].push([torsion, right]);
    }
    Ok(Figure {
        scene: "a straight rod bent to a ring and closed after a twist: where it leaves its plane",
        parameters: "clamped to itself; twist in rad",
        checks,
        drawings: vec![chart("A ring leaves its plane", "C / B", "twist, rad", points)],
    })
}

/// Romero et al. 2021, protocol "bend-twist": a curved rod that hangs from a clamp, which points
/// down, leaves its plane. Light or short ones stay in it however curved they are.
pub(crate) fn bend_twist() -> Fallible<Figure> {
    const TORSION: f64 = 2.0 / 3.0;
    let stiffness = Vector3::new(1.0, 1.0, TORSION);
    let mut checks = Vec::new();
    let mut points = [Vec::new(), Vec::new()];
    for weight in [30.0, 100.0, 1000.0] {
        let problem = |curl: f64| {
            let natural = Vector3::x() * curl;
            let pieces = rod([1.0, 1.0, TORSION], natural, -weight * Vector3::z());
            let clamp = Isometry3::rotation(Vector3::y() * PI);
            Problem::new(&clamp, pieces, EndCondition::FREE)
        };
        let right = hanging_curl(weight, TORSION);
        let from = 0.8 * right;
        let found = limit(&problem, [from, 1.1 * right], &problem(from)?.solve()?)?;
        checks.push(beside(
            format!("natural curvature, weight {weight}"),
            found,
            right,
            "Jacobi's condition along the heavy elastica",
        ));
        points[0].push([found, weight / found.powi(3)]);
        points[1].push([right, weight / right.powi(3)]);
    }
    // What the rod in segments does on either side, bent aside a little.
    let weight = 100.0;
    let right = hanging_curl(weight, TORSION);
    for (part, criterion) in [(0.97, Criterion::AtMost(0.01)), (1.03, Criterion::AtLeast(0.05))] {
        let natural = Vector3::new(part * right, 1e-4, 0.0);
        let root = frame(-Vector3::x(), -Vector3::z());
        let rod = discrete::rod(root, (1.0, 100), |_| stiffness, natural, 1.0)?;
        let conditions = Instant::clamped(*rod.fiber.root(), -weight * Vector3::z());
        let state = rests(&rod, &conditions, None)?;
        let aside = state.positions.iter().map(|p| p.x.abs()).fold(0.0, f64::max);
        let name = format!("out of the plane, of 100 segments, at {part} of it, weight {weight}");
        checks.push(check(name, aside, "", criterion, "in it below, out of it above"));
    }
    Ok(Figure {
        scene: "a rod, curved by nature, hangs from a clamp that points down: where it leaves its \
                plane",
        parameters: "C / B = 2/3; weight in B / L^2, curvature in 1 / L",
        checks,
        drawings: vec![chart(
            "A hanging curved rod leaves its plane",
            "natural curvature times length",
            "weight per length, in B k^3",
            points,
        )],
    })
}

/// A clamped strip that leans away from where a thrust on its end would bend it.
pub(crate) fn snap() -> Fallible<Figure> {
    let mut checks = Vec::new();
    let mut points = [Vec::new(), Vec::new()];
    for lean in [0.1, 0.2, 0.3, 0.4_f64] {
        let clamp = Isometry3::rotation(Vector3::y() * lean);
        let problem = |thrust: f64| {
            let force = -thrust * Vector3::z();
            let pieces = rod([90.0, 1.0, 90.0], Vector3::zeros(), Vector3::zeros());
            Problem::new(&clamp, pieces, EndCondition::Free { force, moment: Vector3::zeros() })
        };
        // Clamped upright it leans to either side; then the clamp turns.
        let upright = |angle: f64| {
            let clamp = Isometry3::rotation(Vector3::y() * angle);
            let force = -20.0 * Vector3::z();
            let pieces = rod([90.0, 1.0, 90.0], Vector3::zeros(), Vector3::zeros());
            Problem::new(&clamp, pieces, EndCondition::Free { force, moment: Vector3::zeros() })
        };
        let leans = upright(-lean)?.solve()?;
        let turned: Branch = ParameterSweep { problem: &upright, from: -lean, to: lean, steps: 10 }
            .follow(&leans)?;
        let start = &turned.points.last().ok_or("no branch")?.equilibrium;
        let branch =
            ParameterSweep { problem: &problem, from: 20.0, to: 1.0, steps: 30 }.follow(start)?;
        let found = branch.limits.first().ok_or("it does not snap")?.parameter;
        let right = snap_thrust(lean);
        checks.push(beside(format!("thrust, {lean} rad"), found, right, "(K + F)^2"));
        points[0].push([lean, found]);
        points[1].push([lean, right]);
    }
    Ok(Figure {
        scene: "a strip, clamped aslant, that leans away from where the thrust on its end would bend \
                it, and snaps back under less thrust: a fold of its equilibria",
        parameters: "thrust in units of B / L^2; the strip stays in its plane",
        checks,
        drawings: vec![chart("A leaning strip snaps", "angle, rad", "thrust", points)],
    })
}

fn chart(
    title: &'static str,
    x: &'static str,
    y: &'static str,
    [found, theory]: [Vec<[f64; 2]>; 2],
) -> Drawing {
    let curves = vec![
        Curve { name: "branches".into(), points: found },
        Curve { name: "theory".into(), points: theory },
    ];
    Drawing::Chart(Chart { title: title.into(), x, y, log_from: None, curves })
}
