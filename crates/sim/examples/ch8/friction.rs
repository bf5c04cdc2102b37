//! Figures 8.8 and 8.19 with Table 8.1: what friction does.

use crate::Fallible;
use crate::drawing::{Drawing, Pictures};
use crate::report::{Criterion, Figure, check};
use crate::size::{Size, captioned, extents, filmed};
use nalgebra::{Point3, Vector3};
use rapunzel_sim::scene::Friction;

/// Figure 8.8: with friction a bundle rests on a ball, without it splits in two.
pub(crate) fn split(size: Size) -> Fallible<Figure> {
    let times = [0.0, 0.15, 0.25, 0.4];
    let mut pictures = Vec::new();
    let mut ends = Vec::new();
    for (name, mu) in [("with friction", 0.5), ("without", 0.0)] {
        let mut scene = size.scene("horizontal-bundle-on-ball", 40, 30)?;
        scene.duration = 0.4;
        scene.contact.as_mut().ok_or("a scene with contact")?.friction = Friction::Isotropic(mu);
        let mut middles = Vec::new();
        let film = filmed(&scene, &times, |world| {
            let fibers = world.assembly().fibers().iter().enumerate();
            middles = fibers.map(|(i, f)| world.node(i, Some(f.segments() / 2)).0).collect();
        })?;
        pictures.extend(captioned(name, film));
        ends.push(middles);
    }
    type Place = fn(&Point3<f64>) -> bool;
    let share = |end: usize, holds: Place| {
        ends[end].iter().filter(|p| holds(p)).count() as f64 / ends[end].len() as f64
    };
    // The top of the ball is at z = -15 mm.
    let on_top: Place = |p| p.z > -0.02;
    let both = Criterion::Within(0.25, 0.75);
    let portions = "two portions of different size";
    let compared: [(_, _, Place, _, _); 4] = [
        ("with friction, on top of the ball", 0, on_top, Criterion::AtLeast(0.99), "they stay"),
        ("without, on top of the ball", 1, on_top, Criterion::AtMost(0.05), "they slip off"),
        ("without, to the left", 1, |p| p.y > 0.005, both, portions),
        ("without, to the right", 1, |p| p.y < -0.005, both, portions),
    ];
    let checks = compared.map(|(what, end, holds, criterion, thesis)| {
        let what = format!("hairs with their middle: {what}");
        check(what, share(end, holds), "", criterion, thesis)
    });
    Ok(Figure {
        scene: "scenes/contact/horizontal-bundle-on-ball.ron",
        parameters: "0.4 s; friction 0.5, which the thesis does not tell, and none",
        drawings: vec![Drawing::Pictures(Pictures {
            title: "8.8 A bundle on a ball, with friction and without".into(),
            view: "seen along the bundle from its root",
            axes: [Vector3::y(), Vector3::z()],
            columns: 4,
            pictures,
        })],
        checks: checks.into(),
    })
}

/// Of a thousand nodes, those left out at each side of a box that single hairs are not to decide.
const OUTERMOST: usize = 5;

/// Figure 8.19: the box around a lock on a ball after 0.7 s, with three kinds of friction.
///
/// A box is as wide as its outermost hairs, and where these come to lie is chance: of runs that differ by
/// the solver or a little by the air the whole box differs by 4 %, the one around 99 % along each axis by 1 %.
pub(crate) fn volumes(size: Size) -> Fallible<Figure> {
    let mut pictures = Vec::new();
    let mut volumes = Vec::new();
    for name in ["isotropic", "anisotropic", "none"] {
        let scene = size.scene(&format!("friction-{name}"), 40, 60)?;
        let mut boxes = [0.0; 2];
        let film = filmed(&scene, &[scene.duration], |world| {
            boxes = [0, OUTERMOST].map(|outermost| 1e6 * extents(world, outermost).product());
        })?;
        pictures.extend(captioned(&format!("{name}, {:.0} cm^3", boxes[0]), film));
        volumes.push(boxes);
    }
    let ratio = |of: usize, to: usize| [0, 1].map(|i| volumes[of][i] / volumes[to][i]);
    let [anisotropic, none] = [1, 2].map(|of| ratio(of, 0));
    let checks = vec![
        check("volume, isotropic", volumes[0][0], "cm^3", Criterion::Told, "1022.39, other sizes"),
        check(
            "anisotropic over isotropic",
            anisotropic[0],
            "",
            Criterion::AtLeast(1.0),
            "1.01 in the table, less than 1 in the text: the table is right",
        ),
        check("the same, boxes around 99 %", anisotropic[1], "", Criterion::Told, "1.01"),
        check("none over isotropic", none[0], "", Criterion::Within(0.86, 0.96), "0.915"),
        check("the same, boxes around 99 %", none[1], "", Criterion::Told, "0.915"),
        check(
            "none over anisotropic",
            ratio(2, 1)[0],
            "",
            Criterion::Told,
            "0.906, which the table gives as its ratio to isotropic",
        ),
    ];
    Ok(Figure {
        scene: "scenes/contact/friction-isotropic.ron, -anisotropic, -none",
        parameters: "0.7 s; helix, stiffness and ball, which the thesis does not tell, are fitted to its boxes",
        drawings: vec![Drawing::Pictures(Pictures {
            title: "8.19 A lock on a ball with three kinds of friction".into(),
            view: "seen along y",
            axes: [Vector3::x(), Vector3::z()],
            columns: 3,
            pictures,
        })],
        checks,
    })
}
