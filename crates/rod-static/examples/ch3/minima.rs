//! Rods under loads along the way: minima of the energy, and following forces.

use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_repro::Criterion::{AtLeast, AtMost, Within};
use rapunzel_repro::plot::{Drawing, Picture, Pictures};
use rapunzel_repro::{ClaimCheck, Fallible, Figure, check};
use rapunzel_rod_static::{Chain, Piece, Properties, Rest, Target};
use std::f64::consts::FRAC_PI_2;

const SEGMENTS: usize = 100;

fn chain(tangent: &Vector3<f64>, piece: Piece) -> Fallible<Chain> {
    let turn = if *tangent == Vector3::z() { 0.0 } else { FRAC_PI_2 };
    let clamp = Isometry3::new(Vector3::zeros(), Vector3::y() * turn);
    Ok(Chain::new(&clamp, &[piece], SEGMENTS)?)
}

fn straight(load: Vector3<f64>, natural_curvature: Vector3<f64>) -> Piece {
    let stiffness = Vector3::new(1.0, 1.0, 0.75);
    Piece::uniform(1.0, Properties { stiffness, natural_curvature, load })
}

fn figure(
    [scene, parameters]: [&'static str; 2],
    rests: Vec<(String, Rest)>,
    checks: Vec<ClaimCheck>,
) -> Figure {
    let pictures = rests
        .into_iter()
        .map(|(caption, rest)| Picture { caption, fibers: vec![rest.shape.positions().to_vec()] });
    let drawing = Pictures {
        title: scene.into(),
        view: "from the side",
        axes: [Vector3::x(), Vector3::z()],
        columns: 4,
        pictures: pictures.collect(),
    };
    Figure { scene, parameters, drawings: vec![Drawing::Pictures(drawing)], checks }
}

fn tip(rest: &Rest) -> Vector3<f64> {
    rest.shape.frames()[SEGMENTS] * Vector3::z()
}

pub(crate) fn followers() -> Fallible<Figure> {
    let (mut rests, mut checks) = (Vec::new(), Vec::new());
    for force in [1.0, 3.0, 6.0, 10.0, 20.0, 40.0, 60.0, 80.0] {
        let mut chain = chain(&Vector3::z(), straight(Vector3::zeros(), Vector3::zeros()))?;
        let mut followers = vec![Vector3::zeros(); SEGMENTS + 1];
        followers[SEGMENTS] = Vector3::x() * force;
        chain.set_followers(&followers)?;
        let rest = chain.solve()?;
        // Turning of the tangent from the clamp to the tip, about y.
        let turned: f64 =
            chain.curvatures(&rest.shape).iter().map(|k| k.y).sum::<f64>() / SEGMENTS as f64;
        let thesis = "beyond the direction of the force, to a half circle, then an S";
        if force == 6.0 {
            checks.push(check("turn of the tip at 6", turned, "rad", AtLeast(FRAC_PI_2), thesis));
        }
        let bends = chain.curvatures(&rest.shape);
        let changes = bends.windows(2).filter(|k| k[0].y * k[1].y < 0.0).count();
        if force == 80.0 {
            let changes = f64::from(u32::try_from(changes)?);
            checks.push(check(
                "changes of the bend's side at 80",
                changes,
                "",
                AtLeast(1.0),
                thesis,
            ));
        }
        rests.push((format!("F = {force} EI/L^2"), rest));
    }
    let parameters = "an upright rod, the force on its tip across it";
    Ok(figure(["A force that follows the tip", parameters], rests, checks))
}

pub(crate) fn dead_load() -> Fallible<Figure> {
    let (mut rests, mut checks) = (Vec::new(), Vec::new());
    for force in [1.0, 5.0, 20.0, 100.0] {
        let load = Vector3::new(0.0, 0.0, -force);
        let piece = straight(Vector3::zeros(), Vector3::zeros()).with_end_load(load);
        let rest = chain(&Vector3::x(), piece)?.solve()?;
        if force == 100.0 {
            let off = tip(&rest).angle(&-Vector3::z());
            let thesis = "the tip is along the force at most";
            checks.push(check(
                "angle of the tip to the force at 100",
                off,
                "rad",
                Within(0.0, 0.1),
                thesis,
            ));
        }
        rests.push((format!("F = {force} EI/L^2"), rest));
    }
    let parameters = "a level rod, the force on its tip downward";
    Ok(figure(["A force that keeps its direction", parameters], rests, checks))
}

pub(crate) fn curvatures() -> Fallible<Figure> {
    let (mut rests, mut checks) = (Vec::new(), Vec::new());
    let natural = [(0.0, 0.0), (6.0, 0.0), (12.0, 4.0), (25.0, 10.0)];
    for (bend, twist) in natural {
        let piece = straight(Vector3::new(0.0, 0.0, -10.0), Vector3::new(0.0, bend, twist));
        let chain = chain(&Vector3::x(), piece)?;
        let rest = chain.solve()?;
        let gradient = chain.gradient(&rest.shape)?;
        let left = gradient.iter().map(Vector3::norm).fold(0.0, f64::max);
        let compared = format!("moment left over, curvature {bend}, twist {twist}");
        checks.push(check(compared, left, "EI/L", AtMost(1e-10), "curves of least energy"));
        rests.push((format!("curvature {bend}/L, twist {twist}/L"), rest));
    }
    let parameters = "a level clamp, G = 10";
    Ok(figure(["Natural curvatures in gravity", parameters], rests, checks))
}

pub(crate) fn places() -> Fallible<Figure> {
    let places = [Point3::new(0.24, 0.04, 0.04), Point3::new(0.44, -0.06, 0.2)];
    let (mut rests, mut checks) = (Vec::new(), Vec::new());
    for stiffness in [0.0, 10.0, 100.0, f64::INFINITY] {
        let piece = straight(Vector3::new(0.0, 0.0, -12.5), Vector3::new(0.0, 12.5, 3.0));
        let mut chain = chain(&Vector3::z(), piece)?;
        if stiffness > 0.0 {
            let target = |node, i: usize| Target { node, place: places[i], stiffness };
            chain.set_targets(&[target(SEGMENTS / 2, 0), target(SEGMENTS, 1)])?;
        }
        let rest = chain.solve()?;
        let at = rest.shape.positions();
        let off = (at[SEGMENTS / 2] - places[0]).norm().max((at[SEGMENTS] - places[1]).norm());
        if stiffness.is_infinite() {
            checks.push(check(
                "distance from the places, held",
                off,
                "L",
                AtMost(1e-9),
                "as near as can be",
            ));
        } else if stiffness == 100.0 {
            checks.push(check(
                "distance from the places, pulled",
                off,
                "L",
                AtMost(0.2),
                "as near as can be",
            ));
        }
        rests.push((format!("stiffness {stiffness} EI/L^3"), rest));
    }
    let parameters = "a wound fiber of length one, G = 12.5, pulled at its middle and its end";
    Ok(figure(["A wound fiber at two places", parameters], rests, checks))
}
