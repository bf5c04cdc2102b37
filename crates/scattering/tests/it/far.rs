use crate::common::{chi_squared, integrals};
use crate::common::{direction, hair, midpoints, random};
use nalgebra::Vector3;
use proptest::prelude::*;
use rapunzel_scattering::{FarField, FiberBsdf, FiberOptics, Polarization};

/// Hair of any roughness that the quadratures of the tests resolve.
fn any_hair() -> impl Strategy<Value = FiberOptics> {
    (0.0..1.0_f64, 0.12..1.0_f64, 0.2..1.0_f64, 0.0..5.0_f64, any::<bool>()).prop_map(
        |(sigma, beta_m, beta_n, alpha, tracked)| {
            let polarization = if tracked { Polarization::Tracked } else { Polarization::Averaged };
            FiberOptics { polarization, ..hair(sigma, beta_m, beta_n, alpha) }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn a_white_fibre_scatters_all_light_and_weights_are_one(
        optics in any_hair(), theta in -85.0..85.0_f64, seed in any::<u64>(),
    ) {
        let white = FiberOptics { absorption: Vector3::zeros(), ..optics };
        let far = FarField::new(white).expect("a fibre");
        for theta in [theta, -85.0, 85.0] {
            let arrival = far.arrive(0.0, &direction(theta.to_radians(), 0.4));
            let [scattered, pdf] = integrals(&far, &arrival, 600, 200);
            prop_assert!((scattered - 1.0).abs() < 1e-3, "{theta}: {scattered}");
            prop_assert!((pdf - 1.0).abs() < 1e-4, "{theta}: {pdf}");
            let mut random = random(seed);
            for _ in 0..200 {
                let weight = far.sample(&arrival, &mut random).expect("a direction").weight;
                prop_assert!(weight.iter().all(|w| (w - 1.0).abs() < 0.01), "{weight}");
            }
        }
    }

    #[test]
    fn light_runs_both_ways(optics in any_hair(), seed in any::<u64>()) {
        let far = FarField::new(optics).expect("a fibre");
        let mut random = random(seed);
        for _ in 0..500 {
            let [a, b] = [(); 2].map(|()| {
                direction(3.1 * (random() - 0.5), 6.2 * random())
            });
            let forth = far.evaluate(&far.arrive(0.0, &a), &b).value;
            let back = far.evaluate(&far.arrive(0.0, &b), &a).value;
            // Rounding; the narrowest lobe here has 1 / v = 500.
            prop_assert!((forth - back).norm() <= 1e-11 * forth.norm(), "{forth} {back}");
        }
    }

    #[test]
    fn absorbing_fibres_scatter_their_albedo_and_samples_weigh_it(
        optics in any_hair(), theta in -85.0..85.0_f64, seed in any::<u64>(),
    ) {
        let far = FarField::new(optics).expect("a fibre");
        let arrival = far.arrive(0.0, &direction(theta.to_radians(), 0.4));
        let albedo = far.albedo(theta.to_radians()).mean();
        let [scattered, pdf] = integrals(&far, &arrival, 600, 200);
        prop_assert!((scattered - albedo).abs() < 1e-4 && albedo < 1.0 + 1e-12);
        prop_assert!((pdf - 1.0).abs() < 1e-4);
        let mut random = random(seed);
        for _ in 0..200 {
            let sample = far.sample(&arrival, &mut random).expect("a direction");
            prop_assert!((sample.weight.mean() / albedo - 1.0).abs() < 1e-9);
            prop_assert!((sample.to.norm() - 1.0).abs() < 1e-12);
            let again = far.evaluate(&arrival, &sample.to);
            prop_assert!((again.pdf / sample.pdf - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn samples_are_distributed_by_their_density() {
    for (sigma, beta, alpha, theta) in
        [(0.0, 0.3, 3.0, 0.3), (0.2, 0.5, 0.0, -1.2), (4.0, 0.25, 4.0, 1.3)]
    {
        let far = FarField::new(hair(sigma, beta, beta, alpha)).expect("a fibre");
        chi_squared(&far, &far.arrive(0.0, &direction(theta, 0.7)));
    }
}

#[test]
fn narrow_lobes_conserve_energy_too() {
    for alpha in [0.0, 3.0] {
        let optics = FiberOptics { variance: [1e-5; 4], ..hair(0.0, 0.3, 0.5, alpha) };
        let far = FarField::new(optics).expect("a fibre");
        for theta in [-85.0, -40.0, 0.0, 20.0, 85.0_f64] {
            let arrival = far.arrive(0.0, &direction(theta.to_radians(), 0.0));
            let [scattered, pdf] = integrals(&far, &arrival, 8000, 60);
            assert!((scattered - 1.0).abs() < 1e-3, "{alpha} {theta}: {scattered}");
            assert!((pdf - 1.0).abs() < 1e-3, "{alpha} {theta}: {pdf}");
        }
    }
}

#[test]
fn lobes_have_the_energies_of_the_smooth_fibre() {
    // Nearly smooth along the fibre; all that is left of the azimuth is its integral.
    let optics = FiberOptics { variance: [1e-6; 4], ..hair(0.0, 0.3, 0.9, 0.0) };
    let far = FarField::new(optics).expect("a fibre");
    for (theta, energies) in
        [(0.0, [0.074955, 0.861791, 0.055672]), (60.0_f64, [0.173474, 0.697349, 0.102011])]
    {
        let theta = theta.to_radians();
        let arrival = far.arrive(0.0, &direction(theta, 0.0));
        let (low, high, count) = (-theta - 0.01, -theta + 0.01, 400);
        let mut sums = [0.0; 3];
        for r in midpoints(low, high, count) {
            for phi in midpoints(0.0, std::f64::consts::PI, 100) {
                let parts = far.lobes(&arrival, &direction(r, phi));
                let measure =
                    r.cos().powi(2) * 0.02 / f64::from(count) * std::f64::consts::TAU / 100.0;
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += part.x * measure);
            }
        }
        for (found, expected) in sums.into_iter().zip(energies) {
            assert!((found - expected).abs() < 1e-4, "{theta}: {found}, not {expected}");
        }
    }
}

/// Lobes of very different widths: R narrow and TT wide scatter up to 1.4 of the light if nobody
/// balances them, the other way round 0.6.
#[test]
fn lobes_of_different_widths_are_balanced() {
    for variance in [[0.01, 0.3, 0.1, 0.1], [0.3, 0.01, 0.1, 0.1], [0.02, 0.02, 2.0, 0.02]] {
        let optics = FiberOptics { variance, ..hair(0.0, 0.3, 0.4, 2.0) };
        let far = FarField::new(optics).expect("a fibre");
        for theta in [-85.0, -50.0, 0.0, 70.0, 85.0_f64] {
            let arrival = far.arrive(0.0, &direction(theta.to_radians(), 0.4));
            let [scattered, _] = integrals(&far, &arrival, 1000, 100);
            assert!((scattered - 1.0).abs() < 1e-3, "{variance:?} {theta}: {scattered}");
        }
        chi_squared(&far, &far.arrive(0.0, &direction(1.1, 0.7)));
    }
}

/// Scales at 3 degrees, light from the side of the root at 30: R has its peak at 24 degrees, where
/// the thesis has it measured, TT and TRT where their shifts say.
#[test]
fn scales_move_the_peaks_of_lobes() {
    let optics = FiberOptics { variance: [1e-4; 4], ..hair(0.0, 0.3, 0.5, 3.0) };
    let far = FarField::new(optics).expect("a fibre");
    let arrival = far.arrive(0.0, &direction(-30.0_f64.to_radians(), 0.0));
    for (p, phi, peak) in [(0, 0.5, 24.0), (1, 2.9, 33.308), (2, 0.5, 42.717)] {
        let at = |degrees: f64| far.lobes(&arrival, &direction(degrees.to_radians(), phi))[p].x;
        let highest = midpoints(15.0, 55.0, 4000).max_by(|a, b| at(*a).total_cmp(&at(*b)));
        // The cosine and the normal scattering move the peak by their slope times the variance.
        assert!((highest.expect("a peak") - peak).abs() < 0.05, "{p}: {highest:?}");
    }
}
