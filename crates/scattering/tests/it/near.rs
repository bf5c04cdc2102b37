use crate::common::{chi_squared, direction, hair, integrals, midpoints, random};
use nalgebra::Vector3;
use proptest::prelude::*;
use rapunzel_fiber::Section;
use rapunzel_scattering::{EllipsePaths, FarField, FiberBsdf, FiberOptics, NearField};
use std::f64::consts::FRAC_PI_2;

const CIRCLE: Section = Section::Circle { radius: 35e-6 };
const ELLIPSE: Section = Section::Ellipse { a: 30e-6, b: 38e-6 };

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn the_mean_over_the_width_is_the_far_field(
        sigma in 0.0..1.0_f64, beta_m in 0.12..1.0_f64, beta_n in 0.2..1.0_f64, alpha in 0.0..5.0_f64,
        seed in any::<u64>(),
    ) {
        let optics = hair(sigma, beta_m, beta_n, alpha);
        let (far, near) = (FarField::new(optics), NearField::new(optics, &CIRCLE));
        let (far, near) = (far.expect("a fibre"), near.expect("a fibre"));
        let mut random = random(seed);
        for _ in 0..60 {
            let [a, b] = [(); 2].map(|()| direction(2.9 * (random() - 0.5), 6.2 * random()));
            let far = far.evaluate(&far.arrive(0.0, &a), &b).value;
            let count = 600;
            let mut mean = Vector3::zeros();
            for gamma in midpoints(-FRAC_PI_2, FRAC_PI_2, count) {
                let value = near.evaluate(&near.arrive(gamma.sin(), &a), &b).value;
                mean += value * (gamma.cos() * FRAC_PI_2 / f64::from(count));
            }
            // Bilinear interpolation: an eighth of the square of the distance of nodes over the
            // width, 0.15 % in azimuth and, with what caustics move, 0.3 % in theta_d; of the
            // value, or where that is a thousandth of an even fibre's, 1 / pi^2, of that.
            prop_assert!((far - mean).norm() < 5e-3 * far.norm().max(1e-4), "{far} {mean}");
        }
    }

    #[test]
    fn densities_integrate_to_one_and_samples_have_theirs(
        sigma in 0.0..1.0_f64, beta_m in 0.12..1.0_f64, beta_n in 0.2..1.0_f64, alpha in 0.0..5.0_f64,
        theta in -85.0..85.0_f64, h in -1.0..1.0_f64, elliptic in any::<bool>(), seed in any::<u64>(),
    ) {
        let section = if elliptic { ELLIPSE } else { CIRCLE };
        let near = NearField::new(hair(sigma, beta_m, beta_n, alpha), &section).expect("a fibre");
        let arrival = near.arrive(h, &direction(theta.to_radians(), 0.4));
        let [_, pdf] = integrals(&near, &arrival, 600, 200);
        prop_assert!((pdf - 1.0).abs() < 1e-4, "{pdf}");
        let mut random = random(seed);
        for _ in 0..100 {
            if let Some(sample) = near.sample(&arrival, &mut random) {
                let again = near.evaluate(&arrival, &sample.to);
                prop_assert!((again.pdf / sample.pdf - 1.0).abs() < 1e-6);
                let weight = again.value * (sample.to.xy().norm() / again.pdf);
                prop_assert!((weight - sample.weight).norm() < 1e-6 * weight.norm());
            }
        }
    }

    /// The albedo at an offset is linear between the nodes of a table, an eighth of the square of
    /// their distance, 0.008 rad, times the second derivative of the logarithm: that of the
    /// reflectance, near grazing, and of `exp(-sigma l)` is some 10 and at most, where nearly all
    /// is absorbed, 50.
    #[test]
    fn samples_of_a_circle_weigh_what_is_scattered_at_their_offset(
        sigma in prop_oneof![Just(0.0), 0.0..3.0_f64], beta in 0.1..0.9_f64,
        alpha in prop_oneof![Just(0.0), 0.0..5.0_f64], theta in -85.0..85.0_f64, h in -1.0..1.0_f64,
        seed in any::<u64>(),
    ) {
        let near = NearField::new(hair(sigma, beta, beta, alpha), &CIRCLE).expect("a fibre");
        let mut random = random(seed);
        for (theta, h) in [(theta, h), (85.0, h), (-85.0, h), (theta, 1.0), (theta, 0.0)] {
            let arrival = near.arrive(h, &direction(theta.to_radians(), 0.4));
            let [scattered, _] = integrals(&near, &arrival, 600, 200);
            for _ in 0..200 {
                let sample = near.sample(&arrival, &mut random).expect("a direction");
                let weight = sample.weight.mean() / scattered;
                prop_assert!((weight - 1.0).abs() < 5e-4, "{theta} {h}: {weight}");
            }
        }
    }

    #[test]
    fn light_runs_both_ways_with_the_offset(
        beta in 0.2..1.0_f64, alpha in 0.0..5.0_f64, h in -1.0..1.0_f64, seed in any::<u64>(),
    ) {
        let near = NearField::new(hair(0.3, beta, beta, alpha), &CIRCLE).expect("a fibre");
        let mut random = random(seed);
        for _ in 0..200 {
            let [a, b] = [(); 2].map(|()| direction(3.1 * (random() - 0.5), 6.2 * random()));
            let forth = near.evaluate(&near.arrive(h, &a), &b).value;
            let back = near.evaluate(&near.arrive(-h, &b), &a).value;
            prop_assert!((forth - back).norm() <= 1e-9 * forth.norm(), "{forth} {back}");
        }
    }
}

#[test]
fn samples_are_distributed_by_their_density() {
    for (section, sigma, beta, alpha, theta, h) in [
        (CIRCLE, 0.0, 0.3, 3.0, 0.3, 0.2),
        (CIRCLE, 0.3, 0.6, 0.0, -1.3, -0.9),
        (ELLIPSE, 0.1, 0.25, 4.0, 0.9, 0.6),
    ] {
        let near = NearField::new(hair(sigma, beta, beta, alpha), &section).expect("a fibre");
        chi_squared(&near, &near.arrive(h, &direction(theta, 0.7)));
    }
}

/// White fibres, over their width and, for an ellipse, all azimuths. The mean of weights is what is
/// scattered; its error is three standard errors at most, and the table of the balance is good to
/// 1e-4.
#[test]
fn a_white_fibre_scatters_all_light_over_its_width() {
    for (section, beta, alpha) in [(CIRCLE, 0.3, 3.0), (CIRCLE, 0.15, 0.0), (ELLIPSE, 0.3, 3.0)] {
        let near = NearField::new(hair(0.0, beta, beta, alpha), &section).expect("a fibre");
        for theta in [-85.0, -50.0, 0.0, 70.0_f64] {
            let mut random = random(7);
            let (mut sum, mut squares, count) = (0.0, 0.0, 400_000);
            for k in 0..count {
                // Offsets and azimuths in a lattice.
                let h = 2.0 * (f64::from(k) + 0.5) / f64::from(count) - 1.0;
                let phi = f64::from(k) * 0.618_033_988_749_894_9 * std::f64::consts::TAU;
                let arrival = near.arrive(h, &direction(theta.to_radians(), phi));
                let weight = near.sample(&arrival, &mut random).map_or(0.0, |s| s.weight.mean());
                sum += weight;
                squares += weight * weight;
            }
            let mean = sum / f64::from(count);
            let error = ((squares / f64::from(count) - mean * mean) / f64::from(count)).sqrt();
            assert!((mean - 1.0).abs() < 3.0 * error + 1e-4, "{theta}: {mean} +- {error}");
            assert!(error < 1e-3);
        }
    }
}

/// Without tilt and with one width, white fibres scatter all light at every offset, without the
/// lobe that keeps the balance.
#[test]
fn one_width_without_tilt_needs_no_balance() {
    let optics = FiberOptics { variance: [0.1; 4], ..hair(0.0, 0.3, 0.4, 0.0) };
    let near = NearField::new(optics, &CIRCLE).expect("a fibre");
    for (theta, h) in [(0.0, 0.3), (-1.0, 0.99), (1.48, -0.7)] {
        let arrival = near.arrive(h, &direction(theta, 0.4));
        let [scattered, _] = integrals(&near, &arrival, 600, 400);
        // Of the table of energies, by which the balance is, the interpolation.
        assert!((scattered - 1.0).abs() < 1e-5, "{theta} {h}: {scattered}");
        let lobes = near.lobes(&arrival, &direction(-theta, 1.0));
        assert!(lobes[4].norm() < 1e-5 * lobes[1].norm().max(1e-3), "{}", lobes[4]);
    }
}

/// Weights of white hair as it is usual: the density of samples is not quite that of the light,
/// since lobes differ in width and tilt; the deviation is said to stay below a tenth up to 60
/// degrees.
#[test]
fn weights_of_white_hair_are_near_one() {
    let near = NearField::new(hair(0.0, 0.3, 0.3, 3.0), &CIRCLE).expect("a fibre");
    let mut random = random(3);
    for theta in [0.0, 30.0, -30.0, 60.0, -60.0_f64] {
        let (mut squares, count) = (0.0, 20_000);
        for _ in 0..count {
            let arrival = near.arrive(2.0 * random() - 1.0, &direction(theta.to_radians(), 0.0));
            let weight = near.sample(&arrival, &mut random).map_or(0.0, |s| s.weight.mean());
            squares += (weight - 1.0).powi(2);
        }
        let deviation = f64::sqrt(squares / f64::from(count));
        assert!(deviation < 0.1, "{theta}: {deviation}");
    }
}

#[test]
fn nothing_is_allocated_at_a_hit() {
    let optics = hair(0.2, 0.3, 0.3, 3.0);
    let (near, far) = (NearField::new(optics, &ELLIPSE), FarField::new(optics));
    let (near, far) = (near.expect("a fibre"), far.expect("a fibre"));
    let mut random = random(1);
    let info = allocation_counter::measure(|| {
        for theta in [-1.0, 0.0, 1.3] {
            let (near_hit, far_hit) = {
                let from = direction(theta, 0.2);
                (near.arrive(0.3, &from), far.arrive(0.3, &from))
            };
            let to = direction(0.3, 2.0);
            assert!(
                near.evaluate(&near_hit, &to).pdf > 0.0 && far.evaluate(&far_hit, &to).pdf > 0.0
            );
            assert!(near.sample(&near_hit, &mut random).is_some());
            assert!(far.sample(&far_hit, &mut random).is_some());
        }
    });
    assert_eq!(info.count_total, 0);
}

/// An elliptical fibre spreads its lobes around the rays of its own ellipse, which lies along d1
/// and d2.
#[test]
fn an_elliptical_fibre_scatters_to_where_its_rays_go() {
    let optics = FiberOptics { azimuthal_scale: 0.01, ..hair(0.1, 0.3, 0.3, 0.0) };
    let near = NearField::new(optics, &ELLIPSE).expect("a fibre");
    let paths = EllipsePaths::new(1.55, 0.4, &ELLIPSE).expect("paths");
    for (phi, h) in [(0.2, 0.5), (1.4, -0.3), (-2.2, 0.7)] {
        let arrival = near.arrive(h, &direction(0.4, phi));
        let ray = paths.trace(phi, h);
        for p in (0..3).filter(|p| ray.share[*p] > 0.0) {
            let at = |off: f64| {
                let phi = phi + ray.azimuth[p] + off;
                near.lobes(&arrival, &direction(-0.4, phi))[p].x
            };
            // The logistic distribution falls to 4 e / (1 + e)^2 of its peak in one width.
            let fall = 4.0 * 1.0_f64.exp() / (1.0 + 1.0_f64.exp()).powi(2);
            for off in [-0.01, 0.01] {
                assert!((at(off) / at(0.0) - fall).abs() < 1e-9, "{phi} {h} {p}");
            }
        }
    }
}
