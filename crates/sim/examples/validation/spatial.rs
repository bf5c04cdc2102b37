//! Rods that bend and twist in space.

use crate::discrete::{Convergence, errors, frame, rests, rod};
use crate::theory::{LocalisedHelix, lateral_buckling, writhing_tension};
use nalgebra::{Isometry3, Point3, Rotation3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_rod_dynamic::{End, Instant, Load, RodState};
use rapunzel_rod_static::{EndCondition, Piece, Problem, Properties};
use std::f64::consts::{FRAC_PI_4, PI};

/// Bathe and Bolourchi's 45 degree bend.
pub(crate) fn bend_of_45_degrees() -> Fallible<Figure> {
    const RADIUS: f64 = 100.0;
    const FORCE: f64 = 600.0;
    let length = FRAC_PI_4 * RADIUS;
    // E / 12 and G / 6 of the unit square, as the benchmark has them.
    let stiffness = Vector3::repeat(1e7 / 12.0);
    let natural = Vector3::new(1.0 / RADIUS, 0.0, 0.0);
    let root = frame(Vector3::z(), Vector3::x());
    let force = FORCE * Vector3::z();
    let properties = Properties { stiffness, natural_curvature: natural, load: Vector3::zeros() };
    let clamp = Isometry3::from_parts(Vector3::zeros().into(), root);
    let end = EndCondition::Free { force, moment: Vector3::zeros() };
    let exact = Problem::new(&clamp, vec![Piece::uniform(length, properties)], end)?.solve()?;
    let right = exact.tip().position;
    let bent = |n: usize| -> Fallible<Point3<f64>> {
        let rod = rod(root, (length, n), |_| stiffness, natural, 1.0)?;
        let mut conditions = Instant::clamped(*rod.fiber.root(), Vector3::zeros());
        conditions.tip = End::Loaded { force: Load::World(force), moment: Load::ZERO };
        Ok(rests(&rod, &conditions, None)?.positions[n])
    };
    let mut all = Vec::new();
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        all.push(Convergence::of(axis, &[20, 40, 80, 160], right[i], |n| Ok(bent(n)?[i]))?);
    }
    let mut checks: Vec<_> =
        all.iter().flat_map(|one| one.checks("", "Kirchhoff's equations")).collect();
    // Published ends scatter by one per cent, and are of rods that stretch and shear.
    for (i, published) in [(0, 47.23), (1, 15.79), (2, 53.37)] {
        let room = 0.01 * published;
        let criterion = Criterion::Within(published - room, published + room);
        checks.push(check(
            format!("{}, solved exactly, beside Bathe and Bolourchi", ["x", "y", "z"][i]),
            right[i],
            "",
            criterion,
            "published to one per cent",
        ));
    }
    Ok(Figure {
        scene: "a bar in an eighth of a circle, clamped, with a force across its plane on its end",
        parameters: "R = 100, E I = G J = 1e7 / 12, P = 600; x along the clamp, y to the middle of \
                     the circle",
        checks,
        drawings: vec![errors(&all)],
    })
}

/// Romero et al. 2021, protocol "lateral buckling", with Prandtl's force on the end.
pub(crate) fn lateral() -> Fallible<Figure> {
    // So stiff in the plane of the force that what it bends there counts nothing.
    let stiffness = Vector3::new(1e5, 1.0, 1.0);
    let right = lateral_buckling();
    let small = 1e-7;
    // How far the end goes aside, in the force that pushes it aside.
    let aside = |force: f64, n: usize| -> Fallible<f64> {
        let root = frame(Vector3::y(), Vector3::x());
        let rod = rod(root, (1.0, n), |_| stiffness, Vector3::zeros(), 1.0)?;
        let mut conditions = Instant::clamped(*rod.fiber.root(), Vector3::zeros());
        let load = Load::World(Vector3::new(0.0, small, -force));
        conditions.tip = End::Loaded { force: load, moment: Load::ZERO };
        Ok(rests(&rod, &conditions, None)?.positions[n].y / small)
    };
    // Southwell's line: the inverse vanishes at the critical force. It is one of the square of the
    // force; a parabola through three points of it is off by what the second mode adds.
    let critical = |n: usize| -> Fallible<f64> {
        let points = [0.90, 0.94, 0.98].map(|part| part * right);
        let mut squares = [0.0; 3];
        let mut inverses = [0.0; 3];
        for (i, force) in points.into_iter().enumerate() {
            (squares[i], inverses[i]) = (force * force, 1.0 / aside(force, n)?);
        }
        // Lagrange's interpolation of the square as a function of the inverse, at zero.
        let mut square = 0.0;
        for i in 0..3 {
            let others = (0..3).filter(|j| *j != i);
            let weight = others.map(|j| inverses[j] / (inverses[j] - inverses[i]));
            square += squares[i] * weight.product::<f64>();
        }
        Ok(square.sqrt())
    };
    let all = [Convergence::of("critical force", &[10, 20, 40], right, critical)?];
    let checks = all[0].checks("sqrt(B C) / L^2", "Prandtl, Michell").into();
    Ok(Figure {
        scene: "a level strip, clamped at its root, under a force on its end",
        parameters: "1e5 times as stiff in the plane of the force; the critical force by Southwell's \
                     line from 0.90, 0.94 and 0.98 of it",
        checks,
        drawings: vec![errors(&all)],
    })
}

/// The state of a rod along a localised helix.
fn along(helix: LocalisedHelix, half: f64, n: u32) -> (RodState, [Isometry3<f64>; 2]) {
    let points = helix.points(half, n);
    let turn = |[theta, psi, roll]: [f64; 3]| {
        Rotation3::from_axis_angle(&Vector3::z_axis(), psi)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), theta)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), roll)
    };
    let count = n as usize;
    let frames: Vec<_> = points.iter().skip(1).step_by(2).map(|p| turn(p.angles)).collect();
    let h = 2.0 * half / f64::from(n);
    let mut curvatures = vec![Vector3::new(0.0, 0.0, helix.moment); count + 1];
    for (i, pair) in frames.windows(2).enumerate() {
        curvatures[i + 1] = so3::log(&(pair[0].inverse() * pair[1])) / h;
    }
    let state = RodState {
        time: 0.0,
        positions: points.iter().step_by(2).map(|p| p.position.into()).collect(),
        velocities: vec![Vector3::zeros(); count + 1],
        frames,
        angular_velocities: vec![Vector3::zeros(); count],
        forces: vec![Vector3::z(); count],
        curvatures,
    };
    let pose = |i: usize| {
        let rotation = UnitQuaternion::from_rotation_matrix(&turn(points[i].angles));
        Isometry3::from_parts(Vector3::from(points[i].position).into(), rotation)
    };
    (state, [pose(0), pose(2 * count)])
}

/// A rod that writhes at one place of its length, held at its ends as theory has them: it pulls and
/// twists them as theory says. As the moment goes to two the helix goes to nothing: a rod under the
/// tension T writhes from `M^2 = 4 B T` on.
pub(crate) fn localised_helix() -> Fallible<Figure> {
    let (half, moments) = (20.0, [1.5, 1.7, 1.9]);
    let mut all = Vec::new();
    let mut curves = Vec::new();
    for moment in moments {
        let helix = LocalisedHelix { moment };
        let held = |n: usize| -> Fallible<RodState> {
            let count = u32::try_from(n)?;
            let (start, [root, tip]) = along(helix, half, count);
            let at = UnitQuaternion::identity();
            let straight = Vector3::repeat(1.0);
            let mut rod = rod(at, (2.0 * half, n), |_| straight, Vector3::zeros(), 1.0)?;
            rod.fiber = rod.fiber.with_root(root);
            let mut conditions = Instant::clamped(root, Vector3::zeros());
            conditions.tip = End::Held(tip);
            rests(&rod, &conditions, Some(start))
        };
        let meshes = [200, 400, 800];
        let states = meshes.iter().map(|n| held(*n)).collect::<Fallible<Vec<_>>>()?;
        let read = |name: String, right: f64, of: &dyn Fn(&RodState) -> f64| Convergence {
            name,
            segments: meshes.to_vec(),
            found: states.iter().map(of).collect(),
            right,
        };
        let middle = |state: &RodState| state.forces.len() / 2;
        all.push(read(format!("tension, moment {moment}"), 1.0, &|state| {
            state.forces[middle(state)].norm()
        }));
        all.push(read(format!("twist, moment {moment}"), moment, &|state| {
            state.curvatures[middle(state)].z
        }));
        let finest = &states[meshes.len() - 1];
        let h = 2.0 * half / meshes[meshes.len() - 1] as f64;
        let envelope = finest.frames.iter().enumerate().map(|(i, frame)| {
            let s = -half + (i as f64 + 0.5) * h;
            [s, (frame * Vector3::z()).z.clamp(-1.0, 1.0).acos()]
        });
        let points = envelope.filter(|p| p[0].abs() < 8.0).collect();
        curves.push(Curve { name: format!("moment {moment}, 800 segments"), points });
        let theory = (-80..=80).map(|i| {
            let s = 0.1 * f64::from(i);
            [s, helix.cosine(s).acos()]
        });
        curves.push(Curve { name: format!("moment {moment}, theory"), points: theory.collect() });
    }
    let envelope = Chart {
        title: "The tangent's angle to the axis along localised helices".into(),
        x: "arc length, in sqrt(B / T)",
        y: "angle, rad",
        log_from: None,
        curves,
    };
    Ok(Figure {
        scene: "a long rod held at both ends as if it were infinite",
        parameters: "B = C = T = 1, length 40; the moment is given in sqrt(B T)",
        checks: all.iter().flat_map(|one| one.checks("", "the localised helix")).collect(),
        drawings: vec![Drawing::Chart(envelope), errors(&all)],
    })
}

/// A rod that is clamped and twisted writhes, at a moment that grows with its tension: of long rods
/// at `M^2 = 4 B T`.
pub(crate) fn writhing() -> Fallible<Figure> {
    let mut all = Vec::new();
    for turns in [2.0, 3.0] {
        let angle = 2.0 * PI * turns;
        let right = writhing_tension(angle);
        // How much more tension than that at which its moment lets it writhe a rod has whose ends
        // have come together by a part of its length.
        let excess = |shortening: f64, n: usize| -> Fallible<f64> {
            let root = UnitQuaternion::identity();
            let rod = rod(root, (1.0, n), |_| Vector3::repeat(1.0), Vector3::zeros(), 1.0)?;
            let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
            let place = Vector3::new(0.0, 0.0, 1.0 - shortening);
            let mut conditions = Instant::clamped(*rod.fiber.root(), Vector3::zeros());
            conditions.tip = End::Held(Isometry3::from_parts(place.into(), turned));
            let state = rests(&rod, &conditions, Some(writhed(angle, shortening, n)))?;
            Ok(state.forces[n / 2].z - writhing_tension(state.curvatures[n / 2].z))
        };
        // The line through two shortenings, at none.
        let onset = |n: usize| Ok(right + 2.0 * excess(1e-3, n)? - excess(2e-3, n)?);
        let name = format!("tension, twist of {turns} turns");
        all.push(Convergence::of(name, &[40, 80, 160], right, onset)?);
    }
    Ok(Figure {
        scene: "a rod between two clamps, twisted",
        parameters: "B = C = L = 1; at the onset, from shortenings of 0.1 and 0.2 per cent",
        checks: all.iter().flat_map(|one| one.checks("B / L^2", "Greenhill")).collect(),
        drawings: vec![errors(&all)],
    })
}

/// The first mode of a rod that writhes, `sin(pi s) exp(i M s / 2)`, of a shortening.
fn writhed(moment: f64, shortening: f64, n: usize) -> RodState {
    let half = 0.5 * moment;
    let amplitude = (4.0 * shortening / (PI * PI + half * half)).sqrt();
    let h = 1.0 / n as f64;
    let mut twisted = Rotation3::identity();
    let frames: Vec<Rotation3<f64>> = (0..n)
        .map(|e| {
            let s = (e as f64 + 0.5) * h;
            let (slope, turn) =
                (amplitude * PI * (PI * s).cos(), half * amplitude * (PI * s).sin());
            let (sin, cos) = (half * s).sin_cos();
            let tangent = Vector3::new(slope * cos - turn * sin, slope * sin + turn * cos, 1.0);
            let bent = so3::between(&(twisted * Vector3::z()), &tangent).unwrap_or_default();
            let twist = if e == 0 { 0.5 * h } else { h };
            twisted = bent * twisted * so3::exp(&(moment * twist * Vector3::z()));
            twisted
        })
        .collect();
    let mut positions = vec![Point3::origin()];
    for frame in &frames {
        positions.push(positions[positions.len() - 1] + frame * (h * Vector3::z()));
    }
    let mut curvatures = vec![Vector3::zeros(); n + 1];
    for (i, pair) in frames.windows(2).enumerate() {
        curvatures[i + 1] = so3::log(&(pair[0].inverse() * pair[1])) / h;
    }
    RodState {
        time: 0.0,
        positions,
        velocities: vec![Vector3::zeros(); n + 1],
        frames,
        angular_velocities: vec![Vector3::zeros(); n],
        forces: vec![Vector3::zeros(); n],
        curvatures,
    }
}
