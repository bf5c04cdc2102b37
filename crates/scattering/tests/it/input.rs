use crate::common::{direction, hair};
use nalgebra::Vector3;
use proptest::prelude::*;
use rapunzel_fiber::Section;
use rapunzel_scattering::thesis_raw::{FresnelReading, reflectance, transmission};
use rapunzel_scattering::{
    BravaisIndices, CirclePaths, CuticleTilt, EllipsePaths, FarField, FiberBsdf, FiberOptics,
    KajiyaKay, MarschnerField, NearField, Pigments, Polarization, ScatteringError, SymmetricLobe,
    absorption_of_color, azimuthal_scale, deon, equivalent_index, gaussian, longitudinal_variance,
    normal_scattering,
};

const CIRCLE: Section = Section::Circle { radius: 1.0 };

#[test]
fn optics_out_of_range_are_refused_and_named() {
    let good = hair(0.1, 0.3, 0.3, 3.0);
    assert_eq!(good.validate(), Ok(()));
    let nan = f64::NAN;
    let mut bad = vec![];
    for n in [0.9, 11.0, nan] {
        bad.push(FiberOptics { refractive_index: n, ..good });
    }
    for sigma in [-1e-9, f64::INFINITY, nan] {
        bad.push(FiberOptics { absorption: Vector3::new(0.1, sigma, 0.1), ..good });
    }
    for v in [0.0, 1e9, nan] {
        bad.push(FiberOptics { variance: [0.1, 0.1, v, 0.1], ..good });
    }
    for azimuthal_scale in [0.0, 1e4, nan] {
        bad.push(FiberOptics { azimuthal_scale, ..good });
    }
    for shift in [2.0, nan] {
        bad.push(FiberOptics { tilt: CuticleTilt { shift: [0.0, shift, 0.0] }, ..good });
    }
    for optics in bad {
        assert!(matches!(NearField::new(optics, &CIRCLE), Err(ScatteringError::Parameter { .. })));
        assert!(matches!(FarField::new(optics), Err(ScatteringError::Parameter { .. })));
        assert!(MarschnerField::new(optics).is_err());
    }
    let tracked = FiberOptics { polarization: Polarization::Tracked, ..good };
    let ellipse = Section::Ellipse { a: 1.0, b: 1.2 };
    assert_eq!(NearField::new(tracked, &ellipse).err(), Some(ScatteringError::TrackedEllipse));
    for section in [Section::Circle { radius: 0.0 }, Section::Ellipse { a: 1.0, b: nan }] {
        assert!(matches!(NearField::new(good, &section), Err(ScatteringError::Section(_))));
    }
    let flat = Section::Ellipse { a: 1.0, b: 20.0 };
    assert!(matches!(NearField::new(good, &flat), Err(ScatteringError::Parameter { .. })));
}

#[test]
fn functions_refuse_what_they_cannot_use() {
    let nan = f64::NAN;
    for theta in [1.571, -2.0, nan] {
        assert!(BravaisIndices::new(1.55, theta).is_err());
        assert!(CirclePaths::new(1.55, theta).is_err());
        assert!(EllipsePaths::new(1.55, theta, &CIRCLE).is_err());
        assert!(CuticleTilt::trace(1.55, 0.05, theta).is_err());
        assert!(reflectance(FresnelReading::OwnAngle, 1.55, theta, 0.0).is_err());
    }
    // Scales along which light passes without a hit, or that keep it inside.
    assert!(CuticleTilt::trace(1.55, 0.1, 1.55).is_err());
    assert!(CuticleTilt::of_scales(1.55, 0.5).is_err());
    assert!(CuticleTilt::of_scales(1.55, nan).is_err());
    for beta in [-0.1, 1.1, nan] {
        assert!(longitudinal_variance(beta).is_err() && azimuthal_scale(beta).is_err());
        assert!(absorption_of_color(&Vector3::repeat(0.5), beta).is_err());
    }
    for color in [0.0, 1.1, nan] {
        assert!(absorption_of_color(&Vector3::new(0.5, color, 0.5), 0.3).is_err());
    }
    assert!(gaussian(0.0, 0.1).is_err() && deon(0.0, 0.1, 0.1).is_err());
    assert!(SymmetricLobe::new(0.1, nan).is_err() && SymmetricLobe::new(nan, 0.1).is_err());
    assert!(equivalent_index(1.55, 0.0, 0.0).is_err() && equivalent_index(nan, 1.0, 0.0).is_err());
    assert!(transmission(1.55, 0.3, 0.0, -1.0).is_err());
    let paths = CirclePaths::new(1.55, 0.3).expect("paths");
    assert!(normal_scattering(&paths, 1, nan, 0.1, Polarization::Averaged).is_err());
    assert!(normal_scattering(&paths, 1, 0.1, nan, Polarization::Averaged).is_err());
    let (a, b) = (Vector3::repeat(0.6), Vector3::repeat(0.5));
    assert!(KajiyaKay::new(a, b, 1.0).is_err() && KajiyaKay::new(b, b, nan).is_err());
    let bleached = Pigments { eumelanin: -1.0, ..Pigments::BLOND };
    assert!(bleached.absorption().is_err());
}

#[test]
fn pigments_add() {
    let sigma = Pigments::RED.absorption().expect("red hair");
    assert!((sigma - Vector3::new(0.3082, 0.6194, 1.534)).norm() < 1e-12);
    let dye = Vector3::new(0.1, 0.2, 0.0);
    let dyed = Pigments::BLACK.bleached(0.1).dyed(dye).absorption().expect("dyed hair");
    assert!(
        (dyed - (Pigments::BLACK.absorption().expect("black hair") * 0.1 + dye)).norm() < 1e-12
    );
    // A wanted color of a third of white: the map is squared in the logarithm.
    let of = |c: f64| absorption_of_color(&Vector3::repeat(c), 0.3).expect("a color").x;
    assert!((of(0.25) / of(0.5) - 4.0).abs() < 1e-12);
    assert_eq!(of(1.0), 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// No direction, offset or lobe makes a number that is none.
    #[test]
    fn values_are_finite_everywhere(
        log_v in -8.0..8.0_f64, log_s in -1.5..3.0_f64, sigma in 0.0..1e3_f64, n in 1.0..10.0_f64,
        shift in -0.3..0.3_f64, elliptic in any::<bool>(),
    ) {
        let optics = FiberOptics {
            refractive_index: n,
            absorption: Vector3::new(0.0, sigma, 1e300),
            variance: [10.0_f64.powf(log_v), 0.1, 0.1, 0.1],
            azimuthal_scale: 10.0_f64.powf(log_s),
            tilt: CuticleTilt { shift: [shift, -shift, 2.0 * shift] },
            polarization: Polarization::Averaged,
        };
        let section = if elliptic { Section::Ellipse { a: 1.0, b: 3.0 } } else { CIRCLE };
        let near = NearField::new(optics, &section).expect("a fibre");
        let angles = [-1.0, -0.999, -0.5, 0.0, 1e-9, 0.7, 1.0].map(|x| x * std::f64::consts::FRAC_PI_2);
        let mut state = crate::common::random(5);
        for (a, b) in angles.into_iter().flat_map(|a| angles.map(|b| (a, b))) {
            for h in [-1.0, 0.0, 0.6, 1.0, 2.0] {
                let arrival = near.arrive(h, &direction(a, 0.3));
                let found = near.evaluate(&arrival, &direction(b, 1.0));
                prop_assert!(found.value.iter().all(|v| *v >= 0.0 && v.is_finite()), "{found:?}");
                prop_assert!(found.pdf >= 0.0 && found.pdf.is_finite(), "{found:?}");
                if let Some(sample) = near.sample(&arrival, &mut state) {
                    prop_assert!(sample.weight.iter().all(|w| *w >= 0.0 && w.is_finite()));
                    prop_assert!((sample.to.norm() - 1.0).abs() < 1e-9);
                }
            }
        }
        let none = near.arrive(f64::NAN, &Vector3::repeat(f64::NAN));
        prop_assert_eq!(near.evaluate(&none, &direction(0.0, 0.0)).value, Vector3::zeros());
        prop_assert!(near.sample(&none, &mut state).is_none());
    }
}
