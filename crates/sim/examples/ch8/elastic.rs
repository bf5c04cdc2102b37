//! Figures 8.16 to 8.18: impacts that are partly elastic, and fibers without bending springs.

use crate::size::{Size, captioned, extents, filmed};
use nalgebra::Vector3;
use rapunzel_repro::plot::{Chart, Curve, Drawing, Pictures};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

const TIMES: [f64; 4] = [0.0, 0.1, 0.2, 0.6];

/// Figure 8.16: what falls with a restitution of a half comes to rest.
pub(crate) fn impacts(size: Size) -> Fallible<Figure> {
    let mut curves = Vec::new();
    let mut checks = Vec::new();
    for restitution in [0.0, 0.5] {
        let mut scene = size.scene("partly-elastic", 20, 50)?;
        scene.contact.as_mut().ok_or("a scene with contact")?.restitution = restitution;
        let (mut points, mut most, mut rise) = (Vec::new(), 0.0_f64, 0.0_f64);
        let mut last = f64::INFINITY;
        filmed(&scene, &[], |world| {
            let energy = world.energy();
            points.push([world.time(), 1e6 * energy.kinetic]);
            most = most.max(energy.kinetic);
            rise = rise.max(energy.total() - last);
            last = energy.total();
        })?;
        let left = points.last().map_or(f64::NAN, |p| p[1]) / (1e6 * most);
        checks.push(check(
            format!("restitution {restitution}: kinetic energy left over its most"),
            left,
            "",
            Criterion::AtMost(1e-3),
            if restitution > 0.0 { "it stagnates, the hairs never rest" } else { "they rest" },
        ));
        checks.push(check(
            format!("restitution {restitution}: largest gain of energy in a step over that"),
            rise / most,
            "",
            Criterion::AtMost(1e-6),
            if restitution > 0.0 { "not excluded" } else { "none" },
        ));
        curves.push(Curve { name: format!("restitution {restitution}"), points });
    }
    Ok(Figure {
        scene: "scenes/contact/partly-elastic.ron",
        parameters: "0.6 s where the thesis runs 20 s; friction 0.3",
        drawings: vec![Drawing::Chart(Chart {
            title: "8.16 Kinetic energy of hairs that fall on a plane".into(),
            x: "time (s)",
            y: "kinetic energy (uJ)",
            log_from: Some(1e-6),
            curves,
        })],
        checks,
    })
}

/// Figure 8.18: stiff hairs stand on their coils, limp ones lie flat.
pub(crate) fn stiffness(size: Size) -> Fallible<Figure> {
    let mut pictures = Vec::new();
    let mut heights = Vec::new();
    for (name, scene) in [("stiff", "partly-elastic"), ("limp", "partly-elastic-limp")] {
        let scene = size.scene(scene, 10, 50)?;
        let mut height = 0.0;
        let film = filmed(&scene, &TIMES, |world| height = extents(world).z)?;
        pictures.extend(captioned(name, film));
        heights.push(1e3 * height);
    }
    let checks = vec![
        check(
            "height at rest, stiff",
            heights[0],
            "mm",
            Criterion::AtLeast(9.0),
            "stable loops keep it from lying flat; the coils are 12 mm high",
        ),
        check(
            "height at rest, limp",
            heights[1],
            "mm",
            Criterion::AtMost(3.0),
            "loops collapse, the fibers sink into an irregular shape",
        ),
    ];
    Ok(Figure {
        scene: "scenes/contact/partly-elastic.ron, partly-elastic-limp.ron",
        parameters: "rods with a thousandth of hair's moduli in place of chains without springs",
        drawings: vec![Drawing::Pictures(Pictures {
            title: "8.18 Hairs on a plane, stiff and limp".into(),
            view: "seen along x",
            axes: [Vector3::y(), Vector3::z()],
            columns: 4,
            pictures,
        })],
        checks,
    })
}
