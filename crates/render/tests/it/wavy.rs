//! The scene that renderers are compared by: wavy fibres, 30 cm long, with a radius of 35
//! micrometres, their roots above.

use nalgebra::{Point3, Vector3};
use rapunzel_render::FiberCurve;
use std::f64::consts::TAU;

/// Radius of the fibres, m.
pub(crate) const RADIUS: f64 = 35e-6;
/// Length of a fibre, cm.
const LENGTH: f64 = 30.0;

/// The radical inverse of a number.
fn halton(mut index: u32, base: u32) -> f64 {
    let (mut fraction, mut sum) = (1.0, 0.0);
    while index > 0 {
        fraction /= f64::from(base);
        sum += fraction * f64::from(index % base);
        index /= base;
    }
    sum
}

/// Control points, m, as other renderers get them.
fn control(count: u32, points: u32) -> Vec<Vec<Vector3<f64>>> {
    let fiber = |k: u32| {
        let (x0, y0) = (12.0 * (halton(k, 2) - 0.5), 3.0 * (halton(k, 3) - 0.5));
        let phase = TAU * (0.15 * halton(k, 5) + 0.08 * x0);
        let point = |i: u32| {
            let s = f64::from(i) / f64::from(points - 1);
            let (w, a) = (TAU * LENGTH * s / 5.0, 0.4 * (4.0 * s).min(1.0));
            let (x, y) = (x0 * (1.0 + 0.1 * s), y0 * (1.0 + 0.1 * s));
            let (x, y) = (x + a * (w + phase).sin(), y + a * (w + phase).cos());
            Vector3::new(x, y, LENGTH * (1.0 - 0.96 * s))
        };
        (0..points).map(point).collect::<Vec<_>>()
    };
    let mut fibers: Vec<_> = (1..=count).map(fiber).collect();
    let length = |fiber: &Vec<Vector3<f64>>| -> f64 {
        fiber.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    };
    let mean = fibers.iter().map(length).sum::<f64>() / f64::from(count);
    let squeeze = (1.0 - 2.0 * (mean - LENGTH) / LENGTH).max(0.0).sqrt();
    for point in fibers.iter_mut().flatten() {
        if mean > LENGTH {
            point.z = LENGTH - (LENGTH - point.z) * squeeze;
        }
        *point *= 0.01;
    }
    fibers
}

/// Nodes of the curves: where the B-splines of the control points pass.
pub(crate) fn wavy(count: u32, points: u32) -> Vec<FiberCurve> {
    let fiber = |control: Vec<Vector3<f64>>| {
        let last = control.len() - 1;
        let node = |i: usize| {
            if i == 0 || i == last {
                control[i]
            } else {
                (control[i - 1] + 4.0 * control[i] + control[i + 1]) / 6.0
            }
        };
        FiberCurve::round((0..=last).map(|i| Point3::from(node(i))).collect(), RADIUS)
    };
    control(count, points).into_iter().map(fiber).collect()
}
