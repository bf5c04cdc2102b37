use crate::common::{entries, midpoints, number, oracle};
use rapunzel_fiber::Section;
use rapunzel_scattering::{CirclePaths, EllipsePaths, OrderShares, Polarization};
use std::f64::consts::FRAC_PI_2;

const N: f64 = 1.55;

/// Level light along d1, on which the axis of the given ratio lies.
fn paths(ratio: f64) -> EllipsePaths {
    EllipsePaths::new(N, 0.0, &Section::Ellipse { a: ratio, b: 1.0 }).expect("an ellipse")
}

#[test]
fn energies_and_glints_are_those_of_the_trace() {
    let mut glints = 0;
    for (ratio, table) in entries(&oracle()["ellipse_theta0_sigma0"], "axis_along_light/across") {
        let paths = paths(ratio);
        let count = 1 << 16;
        let mut sum = [0.0; 4];
        for h in midpoints(-1.0, 1.0, count) {
            let ray = paths.trace(0.0, h);
            let [r, tt, trt] = ray.share;
            let all = [r, tt, trt, ray.later];
            sum.iter_mut().zip(all).for_each(|(sum, e)| *sum += e / f64::from(count));
        }
        for (found, name) in sum.into_iter().zip(["R", "TT", "TRT", "p>=3"]) {
            let expected = number(table, &[name]);
            assert!((found - expected).abs() < 1e-4, "{ratio} {name}: {found}, not {expected}");
        }
        let caustics = paths.caustics(0.0);
        let expected = table["TRT_caustic_phi_deg"].as_f64();
        let Some(expected) = expected else {
            assert_eq!(caustics, [], "{ratio}");
            continue;
        };
        glints += 1;
        if ratio > 1.4 {
            // No caustic: TRT ends there, by total reflection, where the trace has its largest
            // azimuth.
            let edge = number(table, &["TRT_caustic_h_over_halfwidth"]);
            let inside = bisect(edge - 0.01, edge + 0.01, |h| paths.trace(0.0, h).share[2] > 0.0);
            let found = paths.trace(0.0, inside).azimuth[2].to_degrees();
            assert!((found - expected).abs() < 0.1, "{ratio}: {found}, not {expected}");
            assert_eq!(caustics, [], "{ratio}");
        } else {
            assert_eq!(caustics.len(), 2, "{ratio}");
            for caustic in caustics {
                let found = caustic.azimuth.to_degrees().abs();
                assert!((found - expected).abs() < 1e-3, "{ratio}: {found}, not {expected}");
            }
        }
    }
    assert!(glints > 3);
}

/// The last offset from `low` on where something holds that does not at `high`.
fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// Light back along the way that it left by arrives where it came from, with the same share.
#[test]
fn rays_run_both_ways() {
    for (ratio, theta) in [(0.8, 0.0), (1.3, 0.7)] {
        let paths =
            EllipsePaths::new(N, theta, &Section::Ellipse { a: ratio, b: 1.0 }).expect("paths");
        let half_width = |phi: f64| (ratio * phi.sin()).hypot(phi.cos());
        for (phi, h) in [(0.3, 0.4), (1.2, -0.8), (-2.0, 0.1)] {
            let ray = paths.trace(phi, h);
            // R: the point that was hit is the same; its offset is seen from the other direction.
            let back = phi + ray.azimuth[0];
            let (e, u) = ([phi.sin(), -phi.cos()], [phi.cos(), phi.sin()]);
            let side = h * half_width(phi);
            let form = |x: [f64; 2], y: [f64; 2]| x[0] * y[0] / (ratio * ratio) + x[1] * y[1];
            let s = [e[0] * side, e[1] * side];
            let (a, b, c) = (form(u, u), form(s, u), form(s, s) - 1.0);
            let t = ((b * b - a * c).sqrt() - b) / a;
            let at = [s[0] + t * u[0], s[1] + t * u[1]];
            let seen = (at[0] * back.sin() - at[1] * back.cos()) / half_width(back);
            let reverse = paths.trace(back, seen);
            assert!((reverse.azimuth[0] + ray.azimuth[0]).sin().abs() < 1e-12);
            assert!((reverse.share[0] - ray.share[0]).abs() < 1e-12);
        }
    }
}

#[test]
fn an_ellipse_with_equal_axes_is_the_circle() {
    for theta in [0.0, 0.4, 1.1] {
        let ellipse =
            EllipsePaths::new(N, theta, &Section::Ellipse { a: 2.0, b: 2.0 }).expect("paths");
        let circle = CirclePaths::new(N, theta).expect("paths");
        for gamma in midpoints(-FRAC_PI_2, FRAC_PI_2, 40) {
            let h = gamma.sin();
            let ray = ellipse.trace(0.7, h);
            let shares = OrderShares::new(&circle, h, Polarization::Averaged);
            for p in 0..3 {
                let off = (ray.azimuth[p as usize] - circle.azimuth(p, h)).sin();
                // Rounding, times the slope of the azimuth at grazing, 1 / cos gamma.
                assert!(off.abs() < 1e-11, "{theta} {h} {p}: {off}");
                assert!((ray.share[p as usize] - shares.first[p as usize]).abs() < 1e-11);
                let length = f64::from(p) * circle.segment(h);
                assert!((ray.length[p as usize] - length).abs() < 1e-11);
            }
            assert!((ray.later - shares.later).abs() < 1e-11);
        }
    }
}
