//! Figure 2.12: water waves over humidity.

use crate::common::{at_rest, center_line};
use nalgebra::Vector3;
use rapunzel_fiber::generate::{Handedness, Helix};
use rapunzel_keratin::lab::curl::{self, WaterWave};
use rapunzel_keratin::{Climate, Hair, HairType};
use rapunzel_repro::plot::{Chart, Curve, Drawing, Picture, Pictures};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

const LENGTH: f64 = 0.15;

pub(crate) fn retention() -> Fallible<Figure> {
    let hair = Hair::of(HairType::Caucasian);
    let mandrel = Helix { radius: 0.006, pitch: 0.003, handedness: Handedness::Right };
    let wave = WaterWave::on(mandrel)?;
    let (mut over_humidity, mut over_modulus, mut pictures) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..=14 {
        let humidity = 0.3 + 0.05 * f64::from(i);
        let climate = Climate::new(humidity.min(1.0), 23.0)?;
        let fiber = wave.curl(&hair, climate, LENGTH, 60)?;
        let points = center_line(&at_rest(&fiber, Vector3::zeros(), 1.0), LENGTH, 300);
        let depth = points.iter().map(|p| -p.z).fold(0.0, f64::max);
        let index = curl::retention(LENGTH, depth)?;
        over_humidity.push([humidity, index]);
        over_modulus.push([1e-9 * hair.stretching_modulus(&climate)?.value, index]);
        if i % 2 == 0 {
            let caption = format!("{:.0} %", 100.0 * humidity);
            pictures.push(Picture { caption, fibers: vec![points] });
        }
    }
    let rise = over_humidity.windows(2).map(|w| w[1][1] - w[0][1]).fold(f64::MIN, f64::max);
    let checks = vec![
        check(
            "largest rise from one humidity to the next",
            rise,
            "",
            Criterion::AtMost(0.0),
            "falls",
        ),
        check(
            "correlation of index and modulus",
            correlation(&over_modulus),
            "",
            Criterion::AtLeast(0.95),
            "linear",
        ),
    ];
    over_modulus.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let chart = |title: &str, x, points| {
        let curves = vec![Curve { name: "after 3 h".into(), points }];
        let y = "curl retention index";
        Drawing::Chart(Chart { title: title.into(), x, y, log_from: None, curves })
    };
    Ok(Figure {
        scene: "a Caucasian hair of 15 cm, wound wet to a helix of 6 mm radius",
        parameters: "10 min wet, 1 h drying at 50 %, 3 h in the air of the test, then its own weight",
        drawings: vec![
            Drawing::Pictures(Pictures {
                title: "2.12 The curl after three hours".into(),
                view: "seen along y, x to the right",
                axes: [Vector3::x(), Vector3::z()],
                columns: 8,
                pictures,
            }),
            chart("Over humidity", "relative humidity", over_humidity),
            chart("Over Young's modulus", "E in tension (GPa)", over_modulus),
        ],
        checks,
    })
}

fn correlation(points: &[[f64; 2]]) -> f64 {
    let count = points.len() as f64;
    let mean = [0, 1].map(|i| points.iter().map(|p| p[i]).sum::<f64>() / count);
    let sum = |i: usize, j: usize| {
        points.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>()
    };
    sum(0, 1) / (sum(0, 0) * sum(1, 1)).sqrt()
}
