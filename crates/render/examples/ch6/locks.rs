//! Figure 6.11 and section 6.2: locks with and without scattering between hairs, and wisps in
//! light from the front and from behind.

use crate::studio::{ROUND, Shot, front, hair, images, lit, luminance, near, wisp};
use crate::wavy::RADIUS;
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::generate::{Handedness, Helix, Lock, root_pose};
use rapunzel_fiber::{Fiber, Material};
use rapunzel_render::{Camera, FiberCurve};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_scattering::Pigments;

const UP: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);

/// Nine locks of 450 hairs, 25 cm long, that wind as their guides do, one way and the other.
fn locks() -> Fallible<Vec<FiberCurve>> {
    let kind = Lock { count: 450, radius: 0.007, curvature_variation: 0.06, clumping: 0.5 };
    let mut all = Vec::new();
    for k in 0..9_u32 {
        let right = k % 2 == 0;
        let handedness = if right { Handedness::Right } else { Handedness::Left };
        let pitch = 0.08 + 0.005 * f64::from(k * 4 % 9);
        let helix = Helix { radius: 0.009, pitch, handedness };
        let root = Point3::new(0.011 * (f64::from(k) - 4.0), if right { 0.0 } else { 0.012 }, 0.25);
        let straight = Fiber::uniform(0.25, 60, ROUND, &Material::HAIR)?;
        let guide = helix.bend(straight.with_root(root_pose(root, &-UP)?))?;
        let hairs = kind.grow(&guide, u64::from(k))?;
        all.extend(hairs.iter().map(|hair| FiberCurve::round(hair.rest_shape().0, RADIUS)));
    }
    Ok(all)
}

/// Figure 6.11.
pub(crate) fn curls() -> Fallible<Figure> {
    let fibers = locks()?;
    let points: Vec<Point3<f64>> = fibers.iter().flat_map(|f| f.nodes.clone()).collect();
    let size = [150, 220];
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let (view, sight) = (14.0_f64.to_radians(), Vector3::new(0.0, 1.0, -0.1));
    let camera = Camera::framing(&points, &sight, &UP, view, aspect)?;
    let distance = (camera.position() - Point3::new(0.0, 0.0, 0.13)).norm();
    let pixel = 2.0 * distance * (0.5 * view).tan() / f64::from(size[0]);
    let (mut pictures, mut ratios) = (Vec::new(), Vec::new());
    for (name, pigments) in [("blond", Pigments::BLOND), ("red", Pigments::RED)] {
        let bsdf = near(hair(&pigments, 0.25)?)?;
        let scene = lit(&fibers, bsdf, Vector3::new(0.6, -0.7, 0.5), 0.15)?;
        let of = |order| Shot::of(&scene, &camera, order, size, 24);
        let (with, without) = (of(None)?, of(Some(0))?);
        ratios.push(luminance(&with.mean) / luminance(&without.mean));
        pictures.push(with.image(format!("{name}, all orders"), 2.5));
        pictures.push(without.image(format!("{name}, order 0"), 2.5));
    }
    let told = "seen by eye, on Beethoven's hair";
    Ok(Figure {
        scene: "nine locks of 450 hairs of 25 cm around helices, light of a disc of 17 degrees",
        parameters: "150 x 220 pixels, 24 samples; near field, roughness 0.25",
        drawings: vec![images(
            "6.11 Locks with and without scattering between hairs",
            "all two and a half stops brighter",
            pixel,
            4,
            pictures,
        )],
        checks: vec![
            check(
                "blond: mean luminance of all orders over order 0",
                ratios[0],
                "",
                Criterion::AtLeast(1.5),
                told,
            ),
            check(
                "red: mean luminance of all orders over order 0",
                ratios[1],
                "",
                Criterion::AtLeast(1.1),
                told,
            ),
        ],
    })
}

/// Light from the front and from behind.
pub(crate) fn front_and_back() -> Fallible<Figure> {
    let (fibers, camera) = (wisp(3000), front()?);
    let colors =
        [("blond", Pigments::BLOND), ("brown", Pigments::BROWN), ("black", Pigments::BLACK)];
    let (mut pictures, mut ratios) = ([Vec::new(), Vec::new()], Vec::new());
    for (name, pigments) in colors {
        let mut bright = [0.0; 2];
        for (k, (place, y)) in [("the front", -0.9), ("behind", 0.9)].into_iter().enumerate() {
            let bsdf = near(hair(&pigments, 0.3)?)?;
            let scene = lit(&fibers, bsdf, Vector3::new(0.2, y, 0.35), 0.1)?;
            let shot = Shot::of(&scene, &camera, None, [112; 2], 32)?;
            bright[k] = luminance(&shot.mean);
            pictures[k].push(shot.image(format!("{name}, light from {place}"), 1.0));
        }
        ratios.push(bright[1] / bright[0]);
    }
    let told = "strong scattering forward: fair hair is very bright in light from behind";
    let must = [Criterion::AtLeast(1.5), Criterion::Told, Criterion::Told];
    let names = colors.iter().map(|c| c.0);
    let more = ratios[0] / ratios[2];
    let checks = names.zip(ratios).zip(must).map(|((name, ratio), must)| {
        let what = format!("{name}: mean luminance, light from behind over light from the front");
        check(what, ratio, "", must, told)
    });
    let what = "the same of blond over that of black";
    let checks = checks.chain([check(what, more, "", Criterion::AtLeast(1.5), told)]);
    Ok(Figure {
        scene: "3000 wavy fibres of 30 cm",
        parameters: "112 x 112 pixels, 32 samples, all orders; near field, roughness 0.3",
        drawings: vec![images(
            "6.2 Wisps in light from the front and from behind",
            "all a stop brighter",
            2.0 * 0.48 * 10.0_f64.to_radians().tan() / 112.0,
            3,
            pictures.concat(),
        )],
        checks: checks.collect(),
    })
}
