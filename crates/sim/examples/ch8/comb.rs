//! Figure 2.19: the force that combs a tress.

use crate::size::{Size, filmed};
use nalgebra::Vector3;
use rapunzel_repro::plot::{Chart, Curve, Drawing, Pictures};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::BodyRef;

/// When the comb is in the tress and begins to go down, s.
const INSIDE: f64 = 0.15;
/// Steps of 1 ms over which a mean is drawn: contacts come and go one by one.
const SMOOTHED: usize = 20;

pub(crate) fn force(size: Size) -> Fallible<Figure> {
    let scene = size.scene("comb", 40, 50)?;
    let teeth = scene.objects.len();
    let mut series: Vec<[f64; 2]> = Vec::new();
    let mut tips = Vec::new();
    let film = filmed(&scene, &[0.0, 0.15, 0.3, 0.45, 0.6, 0.7], |world| {
        let way = (world.time() - INSIDE).max(0.0) * 0.078 / 0.65;
        let force = (0..teeth).map(|tooth| world.force_on(tooth).z).sum::<f64>();
        let on_teeth = world.contacts().any(|one| matches!(one.sides[1], BodyRef::Object(_)));
        if world.time() >= INSIDE {
            series.push([1e3 * way, 1e6 * force]);
            if on_teeth {
                tips.push(1e3 * way);
            }
        }
    })?;
    let smooth: Vec<[f64; 2]> = series
        .windows(SMOOTHED)
        .map(|w| [w[SMOOTHED / 2][0], w.iter().map(|p| p[1]).sum::<f64>() / SMOOTHED as f64])
        .collect();
    let out = tips.last().copied().unwrap_or(0.0);
    let most = smooth.iter().fold([0.0; 2], |a, b| if b[1] > a[1] { *b } else { a });
    let mean = |from: f64, to: f64| {
        let inside: Vec<_> = smooth.iter().filter(|p| (from..to).contains(&p[0])).collect();
        inside.iter().map(|p| p[1]).sum::<f64>() / inside.len().max(1) as f64
    };
    let after = series.last().map_or(f64::NAN, |p| p[1]);
    let checks = vec![
        check(
            "upward force on the comb against its way, mean while it is inside",
            mean(0.0, out),
            "uN",
            Criterion::AtLeast(0.1),
            "a comb must be pulled",
        ),
        check("force after it has left", after, "uN", Criterion::Within(-1e-9, 1e-9), "none"),
        check(
            "way at the largest force over the way to the last contact",
            most[0] / out,
            "",
            Criterion::Told,
            "the most force is at the tips (Yin et al.), which tangle as the comb comes",
        ),
    ];
    let chart = Chart {
        title: "2.19 Force of the hairs on the comb".into(),
        x: "way of the comb (mm)",
        y: "force upward, against the way (uN)",
        log_from: None,
        curves: vec![
            Curve { name: "every step".into(), points: series },
            Curve { name: "mean of 20 ms".into(), points: smooth },
        ],
    };
    let pictures = Pictures {
        title: "2.19 A comb goes through a tress".into(),
        view: "seen along y, from the tips of the teeth",
        axes: [Vector3::x(), Vector3::z()],
        columns: 6,
        pictures: film.pictures,
    };
    Ok(Figure {
        scene: "scenes/contact/comb.ron",
        parameters: "five teeth of 1.2 mm at 3 mm, 12 cm/s, friction by the scales",
        drawings: vec![Drawing::Chart(chart), Drawing::Pictures(pictures)],
        checks,
    })
}
