//! Figures of a spring that is let go.

use crate::film::{play, scene};
use crate::rods::{tip, with_box};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{ClaimCheck, Criterion, Fallible, Figure};
use rapunzel_sim::Scene;
use rapunzel_sim::scene::{FiberShape, Tip, Weights};

/// Height of the tip (m) and its velocity along z (m/s) over the time since release.
struct Ringing {
    velocity: Vec<[f64; 2]>,
    /// Hz, from the zero crossings of the velocity.
    frequency: f64,
    /// Largest speed later than 50 ms after release over the largest before.
    left: f64,
    fastest: f64,
}

const RELEASE: f64 = 0.1;

/// The spring of the scene with fewer turns, so that six segments can tell them, with so many
/// segments, moved by the thesis's coefficients with steps of `dt` s.
fn coarse(segments: usize, dt: f64) -> Fallible<Ringing> {
    let mut scene = scene("prestressed-spring")?;
    let bundle = &mut scene.fibers[0];
    bundle.segments = segments;
    // The frequency goes with the length times the radius.
    bundle.length = 0.0196;
    if let FiberShape::Helix { radius, pitch, .. } = &mut bundle.shape {
        (*radius, *pitch) = (0.0022, 0.0037);
    }
    if let Tip::Loaded { force, .. } = &mut bundle.tip {
        force.value = [0.0, 0.0, -5e-5];
    }
    with_box(&mut scene, Weights::Thesis, dt);
    scene.output.frame_rate = 1.0 / dt;
    ring(&scene)
}

fn ring(scene: &Scene) -> Fallible<Ringing> {
    let mut velocity = Vec::new();
    play(scene, |world| velocity.push([world.time(), tip(world).1.z]))?;
    let after: Vec<[f64; 2]> = velocity.iter().copied().filter(|p| p[0] > RELEASE).collect();
    let fastest = after.iter().map(|p| p[1].abs()).fold(0.0, f64::max);
    let late = after.iter().filter(|p| p[0] > RELEASE + 0.05).map(|p| p[1].abs());
    // Crossings while it still swings well.
    let crossings: Vec<f64> = after
        .windows(2)
        .filter(|w| w[0][1] * w[1][1] < 0.0 && w[0][0] < RELEASE + 0.03)
        .map(|w| w[0][0] - w[0][1] * (w[1][0] - w[0][0]) / (w[1][1] - w[0][1]))
        .collect();
    let frequency = match (crossings.first(), crossings.last()) {
        (Some(a), Some(b)) if b > a => 0.5 * (crossings.len() - 1) as f64 / (b - a),
        _ => 0.0,
    };
    let left = late.fold(0.0, f64::max) / fastest;
    Ok(Ringing { velocity, frequency, left, fastest })
}

/// Figure 3.18: the velocity of a spring's end, which is pulled for 0.1 s and let go.
pub(crate) fn spring() -> Fallible<Figure> {
    let ringing = ring(&scene("prestressed-spring")?)?;
    Ok(Figure {
        scene: "prestressed-spring",
        parameters: "pulled for 0.1 s as in the thesis; the coil is ours, so that its first \
                     frequency is the thesis's",
        drawings: vec![Drawing::Chart(Chart {
            title: "3.18 A spring is let go at 0.1 s".into(),
            x: "time (s)",
            y: "velocity of the tip along z (m/s)",
            log_from: None,
            curves: vec![Curve { name: "v_z".into(), points: ringing.velocity }],
        })],
        checks: vec![
            ClaimCheck {
                compared: "frequency after release".into(),
                obtained: ringing.frequency,
                unit: "Hz",
                criterion: Criterion::Within(150.0, 170.0),
                thesis: "about 160 Hz",
            },
            ClaimCheck {
                compared: "speed 50 ms after release over the largest".into(),
                obtained: ringing.left,
                unit: "",
                criterion: Criterion::AtMost(0.05),
                thesis: "it finds its equilibrium within 0.05 s",
            },
        ],
    })
}

/// Figure 3.19: the same with 100 down to 6 segments, and with steps from 1e-5 to 1e-2 s.
pub(crate) fn sizes() -> Fallible<Figure> {
    let mut checks = Vec::new();
    let mut check = |name: &str, ringing: &Ringing, reference: f64| {
        checks.push(ClaimCheck {
            compared: format!("{name}: largest speed over that of 100 segments, 1e-4 s"),
            obtained: ringing.fastest / reference,
            unit: "",
            criterion: Criterion::AtMost(1.5),
            thesis: "stable whatever the segments and steps",
        });
    };
    let reference = coarse(100, 1e-4)?.fastest;
    let (mut by_segments, mut by_step) = (Vec::new(), Vec::new());
    for segments in [100, 50, 25, 12, 6] {
        let ringing = coarse(segments, 1e-4)?;
        let name = format!("{segments} segments");
        check(&name, &ringing, reference);
        by_segments.push(Curve { name, points: ringing.velocity });
    }
    for dt in [1e-5, 1e-4, 1e-3, 1e-2] {
        let ringing = coarse(100, dt)?;
        let name = format!("steps of {dt:.0e} s");
        check(&name, &ringing, reference);
        // A point each 0.1 ms is more than the chart shows.
        let thin = if dt < 1e-4 { 10 } else { 1 };
        let points = ringing.velocity.into_iter().step_by(thin).collect();
        by_step.push(Curve { name, points });
    }
    let chart = |title: &str, curves| {
        Drawing::Chart(Chart {
            title: title.into(),
            x: "time (s)",
            y: "velocity of the tip along z (m/s)",
            log_from: None,
            curves,
        })
    };
    Ok(Figure {
        scene: "prestressed-spring",
        parameters: "box scheme with alpha 0.3, beta 0, gamma 0.7; a spring of 1.4 turns. The 4.6 \
                     turns of figure 3.18 need 100 segments: with 50, the loaded spring flutters \
                     in this scheme, with any step and coefficients, for its frames and its \
                     velocities agree to the square of the segments only",
        drawings: vec![
            chart("3.19 Fewer and fewer segments, steps of 1e-4 s", by_segments),
            chart("Longer and longer steps, 100 segments", by_step),
        ],
        checks,
    })
}
