//! Figure 6.7: the near field and the far field of a fibre from nearby.

use crate::draw::{chart, curve, midpoints};
use crate::studio::{Bsdf, ROUND, Shot, hair, images, lit, luminance, near};
use crate::wavy::RADIUS;
use nalgebra::{Point3, Vector3};
use rapunzel_render::{Camera, FiberCurve, Projection, RenderScene};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_scattering::{FarField, FiberBsdf, NearField, Pigments};
use std::f64::consts::{FRAC_PI_2, PI};

const ROUGHNESS: f64 = 0.2;
/// Width of the pictures, m, their pixels, and samples.
const WIDE: f64 = 16.0 * RADIUS;
const SIDE: u32 = 160;
const SAMPLES: u32 = 48;
/// Pixels across the fibre whose mean is compared.
const STRIP: [u32; 2] = [160, 2];

/// Three fibres that cross each other, seen from nearby.
fn crossing() -> Vec<FiberCurve> {
    let line = |x: f64, y: f64, slope: f64| {
        let at = |k: i32| {
            let z = 2e-4 * f64::from(k);
            Point3::new(x * RADIUS + slope * z + 60.0 * z * z, y * RADIUS, z)
        };
        FiberCurve::round((-4..=4).map(at).collect(), RADIUS)
    };
    vec![line(-3.2, -1.5, 0.3), line(0.5, 0.8, -0.2), line(3.6, 3.5, 0.1)]
}

/// One upright fibre.
fn single() -> Vec<FiberCurve> {
    let nodes = (-4..=4).map(|k| Point3::new(0.0, 0.0, 2e-4 * f64::from(k))).collect();
    vec![FiberCurve::round(nodes, RADIUS)]
}

fn camera(width: f64) -> Fallible<Camera> {
    let (at, view) = (Point3::new(0.0, -0.01, 0.0), Projection::Orthographic { width });
    Ok(Camera::new(at, &Point3::origin(), &Vector3::z(), view)?)
}

/// Directions to the light, by name: what is seen from -y.
fn lights() -> [(&'static str, Vector3<f64>); 3] {
    [
        ("light from the eye", Vector3::new(0.0, -1.0, 0.0)),
        ("light from the side", Vector3::new(0.94, -0.34, 0.0)),
        ("light from behind", Vector3::new(0.3, 0.95, 0.0)),
    ]
}

/// Radiance over irradiance across a fibre and its mean, level light from an azimuth; the eye is at
/// the azimuth 0.
fn across(bsdf: &dyn FiberBsdf, azimuth: f64) -> (Vec<[f64; 2]>, f64) {
    let (eye, light) = (Vector3::x(), Vector3::new(azimuth.cos(), azimuth.sin(), 0.0));
    let seen = |h: f64| luminance(&bsdf.evaluate(&bsdf.arrive(h, &eye), &light).value);
    // Rays turn fast where they graze the edge.
    let gammas = midpoints(-FRAC_PI_2, FRAC_PI_2, 1000);
    let points: Vec<[f64; 2]> = gammas.map(|gamma| [gamma.sin(), seen(gamma.sin())]).collect();
    let measure = |[h, seen]: &[f64; 2]| seen * (1.0 - h * h).sqrt();
    let mean = points.iter().map(measure).sum::<f64>() * FRAC_PI_2 / points.len() as f64;
    (points, mean)
}

/// Standard deviation over the mean of what is seen of a fibre across its width, but for 5 % at
/// both edges, which are a part of a pixel.
fn contrast(scene: &RenderScene) -> Fallible<f64> {
    let shot = Shot::of(scene, &camera(1.9 * RADIUS)?, Some(0), STRIP, 16)?;
    let columns: Vec<f64> = shot.columns().iter().map(luminance).collect();
    let mean = columns.iter().sum::<f64>() / columns.len() as f64;
    let square = columns.iter().map(|x| (x / mean - 1.0).powi(2)).sum::<f64>();
    Ok((square / columns.len() as f64).sqrt())
}

pub(crate) fn near_and_far() -> Fallible<Figure> {
    let optics = hair(&Pigments::BLOND, ROUGHNESS)?;
    let (near_field, far_field) = (NearField::new(optics, &ROUND)?, FarField::new(optics)?);
    let models = || -> Fallible<[(&str, Bsdf); 2]> {
        Ok([("far field", Box::new(far_field.clone())), ("near field", near(optics)?)])
    };
    let (mut pictures, mut checks) = ([Vec::new(), Vec::new()], Vec::new());
    for ((place, toward), exposure) in lights().into_iter().zip([1.0, 1.0, -2.0]) {
        for ((name, bsdf), row) in models()?.into_iter().zip(&mut pictures) {
            let scene = lit(&crossing(), bsdf, toward, 0.1)?;
            let shot = Shot::of(&scene, &camera(WIDE)?, None, [SIDE; 2], SAMPLES)?;
            row.push(shot.image(format!("{name}, {place}"), exposure));
        }
    }
    for (name, bsdf) in models()? {
        let constant = contrast(&lit(&single(), bsdf, lights()[1].1, 0.0)?)?;
        let (must, what) = if name == "far field" {
            (Criterion::AtMost(1e-3), "the color stays constant over the section")
        } else {
            (Criterion::AtLeast(0.3), "details that the far field lacks")
        };
        let name = format!("{name}: deviation of radiance across a fibre over its mean");
        checks.push(check(name, constant, "", must, what));
    }
    let mut curves = vec![curve("far field", [[-1.0, 1.0], [1.0, 1.0]])];
    for degrees in [0.0, 70.0, 160.0_f64] {
        let (points, mean) = across(&near_field, degrees.to_radians());
        let (_, far) = across(&far_field, degrees.to_radians());
        let relative = points.iter().map(|p| [p[0], p[1] / far]);
        curves.push(curve(&format!("near field, light at {degrees:.0} degrees"), relative));
        let name = "mean of the near field over the width over the far field, less 1";
        checks.push(check(
            format!("{name}, {degrees:.0} degrees"),
            100.0 * (mean / far - 1.0),
            "%",
            Criterion::Within(-0.5, 0.5),
            "the near field generalises the far field",
        ));
    }
    let mut largest = 0.0_f64;
    for azimuth in midpoints(-PI, PI, 90) {
        let ratio = across(&near_field, azimuth).1 / across(&far_field, azimuth).1;
        largest = largest.max((ratio - 1.0).abs());
    }
    checks.push(check(
        "the same, largest over all azimuths of the light",
        100.0 * largest,
        "%",
        Criterion::AtMost(0.5),
        "the near field generalises the far field",
    ));
    let labels = ["offset across the fibre (radii)", "radiance over that of the far field"];
    let title = "6.7 Three blond fibres from nearby";
    let legend = "one stop brighter, from behind two stops darker";
    Ok(Figure {
        scene: "three curved blond fibres; one straight one for the numbers",
        parameters: "roughness 0.2; parallel projection; light of a disc of 11 degrees; all orders",
        drawings: vec![
            images(title, legend, WIDE / f64::from(SIDE), 3, pictures.concat()),
            chart("6.7 Radiance across a fibre", labels, curves),
        ],
        checks,
    })
}
