//! A rod that is twisted winds up with itself.

use crate::ply::{DT, Ply, growth, length, text};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::{Scene, SimError, World};

/// Angle of the ply, degrees.
const ANGLE: f64 = 25.0;

/// A plectoneme grows while the ends of its rod are turned at constant tension.
pub(crate) fn plectoneme() -> Fallible<Figure> {
    let ply = Ply { angle: ANGLE.to_radians() };
    let points = ply.curve();
    let scene = Scene::from_ron(&ply.scene("ply.txt", length(&points)))?;
    let folder = std::env::temp_dir().join(format!("ply-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("ply.txt"), text(&points))?;
    let built = World::build(&scene.seen_from(&folder));
    std::fs::remove_dir_all(&folder)?;
    let mut world = built?;
    let grown = growth(|| {
        world.step(DT)?;
        Ok::<_, SimError>(world.state(0))
    })?;
    // The strands are chords, between whose middles and ends the distance from the axis differs by
    // as much as the arc is high. A chain that bends, winds and is pulled as the rod is in balance
    // with a moment that is 0.3 per cent less to 0.4 more, a turn of it takes up 0.5 less to 0.6
    // more, and its angle is 0.2 degrees more: less where nodes lie against middles, more where
    // they lie against nodes, and all by the square of the length of segments. The moment is 1.8
    // per cent more by the rate: by the damping of what spins in the bends at the ends of the ply,
    // for which a quarter of a circle lets expect 2.5, and by oil. Turned three times as slowly it
    // is 0.7 more, with a fifth of the damping 0.8; without a rate that is 0.1.
    let room = ply.sagitta();
    let near = |right: f64| Criterion::Within((1.0 - room) * right, (1.0 + room) * right);
    let angle = grown.angle.to_degrees();
    let checks = vec![
        check(
            "ends come together in a turn, beside what twists",
            grown.slope,
            "m",
            near(ply.slope()),
            "4 pi r / sin 2a",
        ),
        check(
            "twisting moment",
            grown.moment,
            "N m",
            near(ply.moment()),
            "2 B sin^3 a cos a / (r cos 2a)",
        ),
        check("angle of the ply", angle, "degrees", near(ANGLE), "of the tension"),
        check(
            "twist and writhe of a turn",
            grown.link,
            "",
            Criterion::Within(0.999, 1.001),
            "a turn",
        ),
    ];
    let from = grown.extensions[0][1];
    let line = [0.0, 1.0].map(|turn| [turn, from - turn * ply.slope()]);
    let chart = Chart {
        title: "A plectoneme takes up its rod".into(),
        x: "turns of its ends",
        y: "distance between them, m",
        log_from: None,
        curves: vec![
            Curve { name: "segments of a radius".into(), points: grown.extensions },
            Curve { name: "slope of theory".into(), points: line.into() },
        ],
    };
    Ok(Figure {
        scene: "a rod that winds up with itself without friction, in oil; its ends are turned \
                against each other under a constant tension",
        parameters: "ply of 25 degrees, whose tension is B sin^4 a / r^2 (1 / 2 + 1 / cos 2a)",
        checks,
        drawings: vec![Drawing::Chart(chart)],
    })
}
