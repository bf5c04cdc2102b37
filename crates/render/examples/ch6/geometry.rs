//! Figures 6.4, 6.5 and 6.8: angles, the cone on which a smooth fibre scatters, and offsets.

use crate::draw::{chart, curve, samples};
use crate::studio::{hair, wrapped};
use crate::trace::{Exit, INDEX, exit, light};
use crate::wavy::RADIUS;
use nalgebra::{Point3, Vector3};
use rapunzel_repro::plot::{Drawing, Picture, Pictures};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_scattering::thesis_raw::near_normal_scattering;
use rapunzel_scattering::{
    CirclePaths, FarField, FiberBsdf, Pigments, Polarization, normal_scattering,
};
use std::f64::consts::{FRAC_PI_2, TAU};

const NAMES: [&str; 3] = ["R", "TT", "TRT"];

/// The direction of an inclination and an azimuth, rad.
fn direction(theta: f64, phi: f64) -> Vector3<f64> {
    Vector3::new(theta.cos() * phi.cos(), theta.cos() * phi.sin(), theta.sin())
}

/// A view half from above of a fibre, which stands upright and comes first; lengths in its radii
/// become lengths.
fn view(title: &str, columns: usize, mut pictures: Vec<Picture>) -> Drawing {
    let toward = Vector3::new(1.0, -0.55, 0.45).normalize();
    let right = Vector3::z().cross(&toward).normalize();
    let axes = [right, toward.cross(&right)];
    let points = pictures.iter_mut().flat_map(|picture| &mut picture.fibers).flatten();
    points.for_each(|p| *p *= RADIUS);
    let view = "half from above, d1 to the front, d2 to the right, d3 up";
    Drawing::Pictures(Pictures { title: title.into(), view, axes, columns, pictures })
}

/// The axis of a fibre.
fn axis(half: f64) -> Vec<Point3<f64>> {
    [-half, half].map(|z| Point3::new(0.0, 0.0, z)).to_vec()
}

/// An arc of directions between two pairs of an inclination and an azimuth.
fn arc(from: [f64; 2], to: [f64; 2], radius: f64) -> Vec<Point3<f64>> {
    let at = |t: f64| [0, 1].map(|k| from[k] + t * (to[k] - from[k]));
    samples(0.0, 1.0, 24).map(|t| Point3::from(direction(at(t)[0], at(t)[1]) * radius)).collect()
}

fn ray(to: Vector3<f64>) -> Vec<Point3<f64>> {
    vec![Point3::origin(), Point3::from(to)]
}

/// Figure 6.4: inclination and azimuth, and that nothing else counts.
pub(crate) fn angles() -> Fallible<Figure> {
    let circle: Vec<_> =
        samples(0.0, TAU, 96).map(|phi| Point3::from(direction(0.0, phi))).collect();
    let of = |name: &str, angles: [f64; 2]| {
        let [theta, phi] = angles.map(f64::to_degrees);
        let caption = format!("{name}: theta = {theta:.0}, phi = {phi:.0} degrees");
        let flat = [0.0, angles[1]];
        let fibers = vec![
            axis(1.5),
            circle.clone(),
            ray(Vector3::x() * 1.5),
            ray(Vector3::y() * 1.5),
            ray(direction(angles[0], angles[1]) * 1.4),
            ray(direction(flat[0], flat[1])),
            arc(flat, angles, 1.0),
            arc([0.0; 2], flat, 0.4),
        ];
        Picture { caption, fibers }
    };
    let pictures = vec![of("light", [0.6, 0.5]), of("eye", [0.9, 1.9])];
    let far = FarField::new(hair(&Pigments::BLOND, 0.3)?)?;
    let value = |i: &Vector3<f64>, r: &Vector3<f64>| far.evaluate(&far.arrive(0.0, i), r).value;
    let (mut turned, mut back) = (0.0_f64, 0.0_f64);
    for theta_i in [-1.2, -0.4, 0.1, 0.8] {
        for theta_r in [-0.9, 0.0, 0.5, 1.3] {
            for change in [0.0, 0.6, 1.9, 3.0] {
                let f =
                    |phi: f64| value(&direction(theta_i, phi), &direction(theta_r, phi + change));
                let here = f(0.0);
                turned = turned.max((f(2.1) - here).amax() / here.amax());
                let reverse = value(&direction(theta_r, change), &direction(theta_i, 0.0));
                back = back.max((reverse - here).amax() / here.amax());
            }
        }
    }
    Ok(Figure {
        scene: "a fibre along d3",
        parameters: "the far field of blond hair, 64 pairs of directions",
        drawings: vec![view("6.4 Inclination and azimuth in the frame of a fibre", 2, pictures)],
        checks: vec![
            check(
                "far field: largest change when both azimuths turn by 120 degrees",
                turned,
                "",
                Criterion::AtMost(1e-9),
                "N depends on the difference of azimuths alone",
            ),
            check(
                "far field: largest change when light and eye change places",
                back,
                "",
                Criterion::AtMost(1e-9),
                "theta_d and theta_h are symmetric; models of today are not",
            ),
        ],
    })
}

/// Offsets at which rays are traced.
fn offsets() -> impl Iterator<Item = f64> + Clone {
    samples(-0.98, 0.98, 50)
}

/// Figure 6.5: parallel rays leave on a cone.
pub(crate) fn cone() -> Fallible<Figure> {
    let theta = 0.5_f64;
    let [mut spread, mut bravais, mut length, mut advance] = [0.0_f64; 4];
    for degrees in [0.0_f64, 15.0, 30.0, 45.0, 60.0, 75.0] {
        let theta = degrees.to_radians();
        let paths = CirclePaths::new(INDEX, theta)?;
        for (h, order) in offsets().flat_map(|h| [0, 1, 2].map(|order| (h, order))) {
            let found = exit(theta, h, order);
            spread = spread.max((found.inclination() + theta).abs());
            bravais = bravais.max(wrapped(found.azimuth() - paths.azimuth(order, h)).abs());
            length = length.max((found.inside - f64::from(order) * paths.segment(h)).abs());
            // Light from above goes down.
            advance = advance.max((found.at.z + paths.axial_advance(order, h)).abs());
        }
    }
    let rim = |z: f64| samples(0.0, TAU, 48).map(move |p| Point3::new(p.cos(), p.sin(), z));
    let wall = |phi: f64| [-3.0, 3.0].map(|z| Point3::new(phi.cos(), phi.sin(), z)).to_vec();
    let picture = |(order, name): (u32, &str)| {
        let mut fibers = vec![axis(3.0), rim(-3.0).collect(), rim(3.0).collect()];
        fibers.extend([2.07, 5.21].map(wall));
        for h in samples(-0.95, 0.95, 20) {
            let Exit { points, at, direction, .. } = exit(theta, h, order);
            let before = points[0] + light(theta) * 4.0;
            let all = std::iter::once(before).chain(points).chain([at + direction * 4.0]);
            fibers.push(all.map(Point3::from).collect());
        }
        Picture { caption: name.into(), fibers }
    };
    let pictures = (0..).zip(NAMES).map(picture).collect();
    let told = |name: &str, value: f64, unit: &'static str, thesis: &'static str| {
        check(format!("{name}, 0 to 75 degrees"), value, unit, Criterion::AtMost(1e-9), thesis)
    };
    Ok(Figure {
        scene: "a smooth round fibre, n = 1.55, in parallel light at 29 degrees",
        parameters: "rays traced in space at 51 offsets; checks at 0, 15, 30, 45, 60 and 75 degrees",
        drawings: vec![view("6.5 Parallel rays leave a smooth fibre on a cone", 3, pictures)],
        checks: vec![
            told(
                "largest difference of inclinations, out against in",
                spread,
                "rad",
                "light is seen only where theta_r = -theta_i",
            ),
            told(
                "largest error of the azimuth by Bravais's n' and (6.4)",
                bravais,
                "rad",
                "the plane suffices, with n' for n",
            ),
            told(
                "largest error of a way inside over cos theta_t",
                length,
                "radii",
                "longer by 1 / sin theta_i (erratum E1)",
            ),
            told(
                "largest error of the way along the fibre (6.21)",
                advance,
                "radii",
                "s_M tan theta_t for each way inside",
            ),
        ],
    })
}

/// Figure 6.8: where rays leave, and the density of rays.
pub(crate) fn offsets_of_rays() -> Fallible<Figure> {
    let paths = CirclePaths::new(INDEX, 0.0)?;
    let mut mirrored = 0.0_f64;
    for theta in [0.0, 0.5, 1.0] {
        for (h, order) in offsets().flat_map(|h| [0, 1, 2].map(|order| (h, order))) {
            mirrored = mirrored.max((exit(theta, h, order).offset() + h).abs());
        }
    }
    let leave = |(order, name)| {
        let of = |h| [h, exit(0.0, h, order).offset()];
        curve(name, offsets().map(of))
    };
    let density = |(order, name)| {
        let of = |h: f64| [h, paths.azimuth_slope(order, h).abs().recip()];
        curve(&format!("{name}, D of (6.19)"), offsets().map(of))
    };
    let exact = curve("all, traced |d h_r / d h_i|^-1", offsets().map(|h| [h, 1.0]));
    // What (6.20) gives once both offsets are integrated out, over the far field.
    let mut twice = [f64::INFINITY, 0.0_f64];
    for azimuth in samples(0.1, 3.0, 29) {
        let right = normal_scattering(&paths, 0, azimuth, 0.0, Polarization::Averaged)?;
        let ratio = near_normal_scattering(0, INDEX, 0.0, azimuth)? / right;
        twice = [twice[0].min(ratio), twice[1].max(ratio)];
    }
    let mut checks = vec![check(
        "largest |h_r + h_i|, R, TT and TRT, 0 to 57 degrees",
        mirrored,
        "",
        Criterion::AtMost(1e-9),
        "delta(h_i + h_r)",
    )];
    let told = "D^NF = D, as dh_r is near dphi; but then rays count twice (erratum E5)";
    for (name, ratio) in ["least", "largest"].into_iter().zip(twice) {
        let name = format!("R: mean of (6.20) over the width, over the far field: {name}");
        checks.push(check(name, ratio, "", Criterion::AtMost(0.75), told));
    }
    let largest = samples(-FRAC_PI_2, FRAC_PI_2, 200)
        .map(|gamma| paths.azimuth_slope(1, gamma.sin()).abs().recip())
        .fold(0.0, f64::max);
    let what = "TT: largest D of (6.19); traced it is 1 everywhere";
    checks.push(check(what, largest, "", Criterion::AtLeast(1.2), told));
    Ok(Figure {
        scene: "a smooth round fibre, n = 1.55",
        parameters: "rays traced in space",
        drawings: vec![
            chart(
                "6.8 Offsets at which rays leave: one line for all",
                ["h_i", "h_r"],
                (0..).zip(NAMES).map(leave).collect(),
            ),
            chart(
                "6.8 Density of rays over the width",
                ["h_i", "density"],
                std::iter::once(exact).chain((0..2).zip(NAMES).map(density)).collect(),
            ),
        ],
        checks,
    })
}
