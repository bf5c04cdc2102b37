//! Rods that bend in a plane.

use crate::discrete::{Convergence, errors, frame, rests, rod};
use crate::theory::{cone_under_couple, heavy_cantilever, tip_load};
use nalgebra::Vector3;
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Fallible, Figure};
use rapunzel_rod_dynamic::{End, Instant, Load};

const MESHES: [usize; 4] = [25, 50, 100, 200];

/// A level clamp: bending downward is about d1.
fn level() -> nalgebra::UnitQuaternion<f64> {
    frame(Vector3::y(), Vector3::x())
}

/// Length and stiffness 1; weight in the unit of bending. Height over width of the cantilever.
fn sag(gamma: f64, segments: usize) -> Fallible<[f64; 2]> {
    let rod = rod(level(), (1.0, segments), |_| Vector3::repeat(1.0), Vector3::zeros(), 1.0)?;
    let conditions = Instant::clamped(*rod.fiber.root(), -gamma * Vector3::z());
    let tip = rests(&rod, &conditions, None)?.positions[segments];
    Ok([tip.x, -tip.z])
}

/// Romero et al. 2021, protocol "cantilever".
pub(crate) fn cantilever() -> Fallible<Figure> {
    let weights = [1.0, 5.0, 20.0];
    let mut all = Vec::new();
    for gamma in weights {
        let [along, down] = heavy_cantilever(gamma);
        let name = format!("height over width, weight {gamma}");
        all.push(Convergence::of(name, &MESHES, down / along, |n| {
            let [along, down] = sag(gamma, n)?;
            Ok(down / along)
        })?);
    }
    let curve = |name: &str, of: &dyn Fn(f64) -> Fallible<[f64; 2]>| -> Fallible<Curve> {
        let points = (-4..=20).map(|i| {
            let gamma = 2_f64.powf(0.25 * f64::from(i));
            let [along, down] = of(gamma)?;
            Ok([gamma, down / along])
        });
        Ok(Curve { name: name.into(), points: points.collect::<Fallible<_>>()? })
    };
    let master = Chart {
        title: "The master curve of cantilevers".into(),
        x: "weight w L^3 / B",
        y: "height over width",
        log_from: None,
        curves: vec![
            curve("the heavy elastica", &|gamma| Ok(heavy_cantilever(gamma)))?,
            curve("50 segments", &|gamma| sag(gamma, 50))?,
        ],
    };
    Ok(Figure {
        scene: "a level rod, clamped at its root, under its weight",
        parameters: "length and bending stiffness 1; the weight is given in w L^3 / B",
        checks: all.iter().flat_map(|one| one.checks("", "the heavy elastica")).collect(),
        drawings: vec![Drawing::Chart(master), errors(&all)],
    })
}

/// Mattiasson's table of the cantilever with a force on its end.
pub(crate) fn mattiasson() -> Fallible<Figure> {
    let bent = |a: f64, n: usize| -> Fallible<[f64; 2]> {
        let rod = rod(level(), (1.0, n), |_| Vector3::repeat(1.0), Vector3::zeros(), 1.0)?;
        let mut conditions = Instant::clamped(*rod.fiber.root(), Vector3::zeros());
        let force = Load::World(-a * Vector3::z());
        conditions.tip = End::Loaded { force, moment: Load::ZERO };
        let tip = rests(&rod, &conditions, None)?.positions[n];
        Ok([tip.x, -tip.z])
    };
    let mut all = Vec::new();
    for a in [1.0, 2.0, 5.0, 10.0] {
        let right = tip_load(a);
        for (i, what) in ["along", "down"].into_iter().enumerate() {
            let name = format!("end {what}, force {a}");
            all.push(Convergence::of(name, &MESHES, right[i], |n| Ok(bent(a, n)?[i]))?);
        }
    }
    Ok(Figure {
        scene: "a level rod, clamped at its root, under a force on its end",
        parameters: "length and bending stiffness 1; the force is given in P L^2 / B",
        checks: all.iter().flat_map(|one| one.checks("", "elliptic integrals")).collect(),
        drawings: vec![errors(&all)],
    })
}

/// A cone under a couple on its end.
pub(crate) fn cone() -> Fallible<Figure> {
    const TIP: f64 = 0.4;
    let moment = 2.0 / cone_under_couple(TIP, 1.0, 1.0);
    let stiffness = |part: f64| Vector3::repeat((1.0 - (1.0 - TIP) * part).powi(4));
    // At the middle of the last segment, where its frame is.
    let turned = |n: usize| -> Fallible<f64> {
        let rod = rod(level(), (1.0, n), stiffness, Vector3::zeros(), 1.0)?;
        let mut conditions = Instant::clamped(*rod.fiber.root(), Vector3::zeros());
        let moment = Load::World(moment * Vector3::y());
        conditions.tip = End::Loaded { force: Load::ZERO, moment };
        let state = rests(&rod, &conditions, None)?;
        let tangent = state.frames[n - 1] * Vector3::z();
        let angle = (-tangent.z).atan2(tangent.x);
        let middle = 1.0 - 0.5 / n as f64;
        // As if it were at the end: what is missing is that of theory.
        let missing = cone_under_couple(TIP, 1.0, 1.0) - cone_under_couple(TIP, 1.0, middle);
        Ok(angle + 2.0 * missing / cone_under_couple(TIP, 1.0, 1.0))
    };
    let all = [Convergence::of("angle at the end", &MESHES, 2.0, turned)?];
    Ok(Figure {
        scene: "a level cone, clamped at its root, under a couple on its end",
        parameters: "the radius falls to 0.4 of that at the root; the end turns by 2 rad",
        checks: all.iter().flat_map(|one| one.checks("rad", "the integral of M / E I")).collect(),
        drawings: vec![errors(&all)],
    })
}
