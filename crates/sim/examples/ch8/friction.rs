//! Figures 8.8 and 8.19 with Table 8.1: what friction does.

use crate::size::{Size, captioned, extents, filmed};
use nalgebra::{Point3, Vector3};
use rapunzel_repro::plot::{Drawing, Pictures};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::scene::FrictionLaw;

/// Figure 8.8: with friction a bundle rests on a ball, without it splits in two.
pub(crate) fn split(size: Size) -> Fallible<Figure> {
    let times = [0.0, 0.15, 0.25, 0.4];
    let mut pictures = Vec::new();
    let mut ends = Vec::new();
    for (name, mu) in [("with friction", 0.5), ("without", 0.0)] {
        let mut scene = size.scene("horizontal-bundle-on-ball", 40, 30)?;
        scene.duration = 0.4;
        scene.contact.as_mut().ok_or("a scene with contact")?.friction = FrictionLaw::Isotropic(mu);
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

/// Locks of every kind of friction, whose hairs their seeds root in other places.
const LOCKS: u64 = 5;

/// Figure 8.19: the box around a lock on a ball after 0.7 s, with three kinds of friction.
///
/// A box is as wide as its outermost hairs, and where a single hair comes to lie is chance:
/// compared are means of several locks.
pub(crate) fn volumes(size: Size) -> Fallible<Figure> {
    let mut pictures = Vec::new();
    let mut volumes = Vec::new();
    for name in ["isotropic", "anisotropic", "none"] {
        let mut scene = size.scene(&format!("friction-{name}"), 40, 60)?;
        let mut locks = Vec::new();
        for seed in 1..=LOCKS {
            scene.seed = seed;
            let mut volume = 0.0;
            let film = filmed(&scene, &[scene.duration], |world| {
                volume = 1e6 * extents(world).product();
            })?;
            if seed == 1 {
                pictures.extend(captioned(&format!("{name}, {volume:.0} cm^3"), film));
            }
            locks.push(volume);
        }
        volumes.push(locks);
    }
    let smaller = Criterion::Within(0.86, 0.96);
    let larger = Criterion::AtLeast(1.0);
    let compared = [
        ("none over isotropic", 2, 0, smaller, "0.915"),
        ("none over anisotropic", 2, 1, smaller, "0.906, in the table as its ratio to isotropic"),
        (
            "anisotropic over isotropic",
            1,
            0,
            larger,
            "1.01 in the table, less than 1 in the text: of these scenes the table is right",
        ),
    ];
    let (volume, _) = mean_and_error(&volumes[0]);
    let mut checks =
        vec![check("volume, isotropic", volume, "cm^3", Criterion::Told, "1022.39, other sizes")];
    for (what, of, to, criterion, thesis) in compared {
        let ratios: Vec<_> = volumes[of].iter().zip(&volumes[to]).map(|(of, to)| of / to).collect();
        let (mean, error) = mean_and_error(&ratios);
        checks.push(check(what, mean, "", criterion, thesis));
        let what = format!("{what}, standard error");
        checks.push(check(what, error, "", Criterion::Told, "one run"));
    }
    Ok(Figure {
        scene: "scenes/contact/friction-isotropic.ron, -anisotropic, -none",
        parameters: "0.7 s, means of five locks; helix, stiffness, damping and ball, which the thesis does \
                     not tell, are fitted to its ratios",
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

/// The mean of several numbers, and its standard error.
fn mean_and_error(of: &[f64]) -> (f64, f64) {
    let n = of.len() as f64;
    let mean = of.iter().sum::<f64>() / n;
    let squares: f64 = of.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, (squares / (n * (n - 1.0))).sqrt())
}
