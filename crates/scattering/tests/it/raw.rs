use crate::common::midpoints;
use rapunzel_scattering::thesis_raw::{
    FresnelReading, PrintedFarField, near_normal_scattering, parallel_index, reflectance,
    transmission,
};
use rapunzel_scattering::{
    CirclePaths, OrderShares, Polarization, equivalent_index, normal_scattering,
};
use std::f64::consts::{FRAC_PI_2, PI};

const N: f64 = 1.55;

/// The mean over the width, by midpoints in gamma.
fn mean(of: impl Fn(f64) -> f64) -> f64 {
    let count = 4000;
    let measure = |gamma: f64| of(gamma.sin()) * gamma.cos() * FRAC_PI_2 / f64::from(count);
    midpoints(0.0, FRAC_PI_2, count).map(measure).sum()
}

fn tracks(found: f64, expected: f64) {
    // The report has three digits.
    assert!((found - expected).abs() < 6e-4, "{found}, not {expected}");
}

#[test]
fn absorption_over_the_sine_makes_fibres_too_dark() {
    let theta = 30.0_f64.to_radians();
    let paths = CirclePaths::new(N, theta).expect("paths");
    let share = |h: f64| OrderShares::new(&paths, h, Polarization::Averaged).first[1];
    let printed = |h: f64| transmission(N, theta, h, 0.25).expect("a value");
    tracks(mean(|h| share(h) * printed(h)), 0.328);
    tracks(mean(|h| share(h) * (-0.25 * paths.segment(h)).exp()), 0.512);
    // E1: level light never comes through, but where there is nothing to absorb it.
    assert_eq!(transmission(N, 0.0, 0.3, 0.25).expect("a value"), 0.0);
    assert_eq!(transmission(N, 0.0, 0.3, 0.0).expect("a value"), 1.0);
}

#[test]
fn readings_of_the_fresnel_terms_differ() {
    let of = |reading, degrees: f64, f: fn(f64) -> f64| {
        mean(|h| f(reflectance(reading, N, degrees.to_radians(), h).expect("a value")))
    };
    tracks(of(FresnelReading::PrintedIndex, 60.0, |f| f), 0.262);
    tracks(of(FresnelReading::PrintedIndex, 60.0, |f| (1.0 - f) * (1.0 - f)), 0.563);
    tracks(of(FresnelReading::OwnAngle, 75.0, |f| f), 0.520);
    tracks(of(FresnelReading::OneIndex, 75.0, |f| f), 0.418);
    assert_eq!(parallel_index(N, 0.0).expect("an index"), N);
}

#[test]
fn the_index_that_stands_for_an_ellipse_misses_it() {
    // E11: what (6.12) gives, and what the trace gives instead.
    for (ratio, index, trt, glint) in [
        (0.85, 1.245, 0.0240, Some(56.9)),
        (0.90, 1.341, 0.0339, Some(40.9)),
        (1.00, 1.55, 0.0557, Some(18.62)),
        (1.10, 1.781, 0.0780, Some(5.24)),
        (1.20, 2.034, 0.0988, None),
    ] {
        let n = equivalent_index(N, ratio, 0.0).expect("an index");
        tracks(n, index);
        let paths = CirclePaths::new(n, 0.0).expect("paths");
        let share = |h: f64| OrderShares::new(&paths, h, Polarization::Averaged).first[2];
        assert!((mean(share) - trt).abs() < 6e-5, "{ratio}: {}", mean(share));
        let caustic = paths.caustic(2).map(|c| c.azimuth.to_degrees());
        assert_eq!(caustic.is_some(), glint.is_some(), "{ratio}");
        if let (Some(found), Some(expected)) = (caustic, glint) {
            assert!((found - expected).abs() < 6e-2, "{ratio}: {found}");
        }
    }
}

#[test]
fn the_printed_near_field_counts_the_density_of_rays_twice() {
    // E5: of R the far field is a quarter of cos(phi / 2) times F, the printed near field that
    // times D.
    let paths = CirclePaths::new(N, 0.0).expect("paths");
    for phi in [0.5, 1.0, 2.0_f64] {
        let right =
            normal_scattering(&paths, 0, phi, 0.0, Polarization::Averaged).expect("a value");
        let printed = near_normal_scattering(0, N, 0.0, phi).expect("a value");
        let density = 0.5 * (0.5 * phi).cos();
        assert!((printed / right - density).abs() < 1e-12, "{phi}");
    }
}

#[test]
fn the_printed_far_field_is_black_in_level_light_and_twice_too_bright() {
    let printed = PrintedFarField {
        refractive_index: N,
        absorption: 0.25,
        widths: [0.1; 3],
        shifts: [0.0; 3],
        axis_ratio: 1.0,
    };
    let of = |fibre: &PrintedFarField, phi| fibre.value([0.0, 0.0], [0.0, phi]).expect("a value");
    // Towards the light there is R and TRT, straight on TT.
    assert!(of(&printed, 1.0) > 0.0);
    assert_eq!(
        of(&printed, PI - 0.1) - of(&PrintedFarField { absorption: 1e6, ..printed }, PI - 0.1),
        0.0
    );
    let clear = PrintedFarField { absorption: 0.0, ..printed };
    let paths = CirclePaths::new(N, 0.0).expect("paths");
    let normal: f64 = (0..3)
        .map(|p| normal_scattering(&paths, p, 2.5, 0.0, Polarization::Averaged).expect("a value"))
        .sum();
    // E8: the peak of g(beta; theta_h), which has the integral 2.
    let peak = 1.0 / (0.1 * (2.0 * PI).sqrt());
    assert!((of(&clear, 2.5) / (normal * peak) - 1.0).abs() < 1e-12);
}
