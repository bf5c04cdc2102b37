use crate::common::{entries, midpoints, number, oracle};
use rapunzel_fiber::Section;
use rapunzel_render::{CirclePaths, EllipsePaths, OrderShares, Polarization};
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
        println!("{ratio} {caustics:?}");
        let expected = &table["TRT_caustic_phi_deg"];
        if let Some(expected) = expected.as_f64() {
            glints += 1;
            let found = caustics.iter().map(|c| c.azimuth.to_degrees().abs());
            let nearest = found.map(|f| (f - expected).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-3, "{ratio}: {caustics:?}, not {expected}");
        }
    }
    assert!(glints > 0);
}

#[test]
fn an_ellipse_with_equal_axes_is_the_circle() {
    for theta in [0.0, 0.4, 1.1] {
        let ellipse = EllipsePaths::new(N, theta, &Section::Ellipse { a: 2.0, b: 2.0 }).expect("paths");
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
