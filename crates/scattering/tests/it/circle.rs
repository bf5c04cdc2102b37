use crate::common::{BOTH, entries, midpoints, number, oracle};
use nalgebra::{Matrix2, Vector3};
use rapunzel_scattering::{
    BravaisIndices, CirclePaths, CuticleTilt, FresnelReflectance, OrderShares, Polarization,
    absorption_of_color, azimuthal_scale, longitudinal_variance, normal_scattering,
};
use std::f64::consts::{FRAC_PI_2, PI};

const N: f64 = 1.55;

/// Energies of R, TT, TRT, the order 3 and all from it on, over the width: by the midpoint rule in
/// gamma, whose error is below 1e-7 with so many nodes.
fn energies(theta: f64, sigma: f64, polarization: Polarization) -> [f64; 5] {
    let paths = CirclePaths::new(N, theta).expect("paths");
    let count = 4000;
    let mut sum = [0.0; 5];
    for gamma in midpoints(0.0, FRAC_PI_2, count) {
        let h = gamma.sin();
        let shares = OrderShares::new(&paths, h, polarization);
        let t = (-sigma * paths.segment(h)).exp();
        let leaves = shares.absorbed(&Vector3::repeat(t)).map(|e| e.x);
        let third = shares.order(3) * t.powi(3);
        let all = [leaves[0], leaves[1], leaves[2], third, leaves[3]];
        let measure = gamma.cos() * FRAC_PI_2 / f64::from(count);
        sum.iter_mut().zip(all).for_each(|(sum, e)| *sum += e * measure);
    }
    sum
}

fn compare(found: [f64; 5], table: &serde_json::Value, keys: [&str; 5]) {
    for (found, key) in found.into_iter().zip(keys) {
        if let Some(expected) = table[key].as_f64() {
            assert!((found - expected).abs() < 1e-4, "{key}: {found}, not {expected}");
        }
    }
}

const ORDERS: [&str; 5] = ["R", "TT", "TRT", "p3", "p>=3"];

#[test]
fn energies_in_level_light_are_those_of_the_trace() {
    for (sigma, table) in entries(&oracle()["circle_theta0"], "sigma_R") {
        for (polarization, name) in BOTH.into_iter().zip(["mean", "pol"]) {
            let found = energies(0.0, sigma, polarization);
            compare(found, &table[name], ORDERS);
            let sum = found[0] + found[1] + found[2] + found[4];
            assert!((sum - number(table, &[name, "sum"])).abs() < 1e-4);
        }
    }
}

#[test]
fn energies_in_skew_light_are_those_of_the_trace() {
    for (theta, table) in entries(&oracle()["circle_skew"], "theta_deg") {
        let theta = theta.to_radians();
        for (sigma, table) in entries(table, "sigma_R") {
            compare(energies(theta, sigma, Polarization::Averaged), table, ORDERS);
        }
        // The table has six digits.
        let paths = CirclePaths::new(N, theta).expect("paths");
        let indices = BravaisIndices::new(N, theta).expect("indices");
        assert!((indices.perpendicular - number(table, &["n_eff_perp"])).abs() < 6e-7);
        assert!((paths.segment(0.0) - number(table, &["path_TT_at_h0_in_R"])).abs() < 6e-7);
        let advance = number(table, &["axial_advance_TT_at_h0_in_R"]);
        assert!((paths.axial_advance(1, 0.0) + advance).abs() < 6e-7);
    }
}

/// Shares of light by azimuth in parts of 5 degrees, as the table has them from -180 degrees on.
#[test]
fn azimuths_are_those_of_the_trace() {
    let paths = CirclePaths::new(N, 0.0).expect("paths");
    for (sigma, table) in entries(&oracle()["circle_theta0"], "sigma_R") {
        let mut shares = [[0.0; 72]; 3];
        let count = 1 << 18;
        for h in midpoints(-1.0, 1.0, count) {
            let t = (-sigma * paths.segment(h)).exp();
            let leaves =
                OrderShares::new(&paths, h, Polarization::Averaged).absorbed(&Vector3::repeat(t));
            for p in 0..3 {
                let azimuth = paths.azimuth(p, h).rem_euclid(2.0 * PI);
                #[expect(clippy::cast_possible_truncation, reason = "in [0, 72]")]
                let bin = ((azimuth + PI).rem_euclid(2.0 * PI) / (PI / 36.0)) as usize % 72;
                shares[p as usize][bin] += leaves[p as usize].x / f64::from(count);
            }
        }
        for (p, name) in ["R", "TT", "TRT"].into_iter().enumerate() {
            let expected = table["hist5deg_mean"][name].as_array().expect("a list");
            for (found, expected) in shares[p].iter().zip(expected) {
                let expected = expected.as_f64().expect("a number");
                assert!((found - expected).abs() < 1e-4, "{name}: {found}, not {expected}");
            }
        }
    }
}

#[test]
fn the_caustic_is_where_the_trace_has_it_and_caustics_merge() {
    let table = &oracle()["circle_theta0"];
    let found = CirclePaths::new(N, 0.0).expect("paths").caustic(2).expect("a caustic");
    let closed = &table["closed_form"];
    // The table has the ray on the other side.
    let azimuth = number(closed, &["TRT_caustic_phi_deg"]).abs();
    assert!((found.azimuth.to_degrees() - azimuth).abs() < 1e-3);
    assert!(
        (found.h - number(table, &["TRT_caustic", "h_closed_form_sqrt((4-n'^2)/3)"])).abs() < 1e-6
    );
    for (n, azimuth) in [(1.45, 27.685), (1.50, 22.842), (1.60, 14.928)] {
        let caustic = CirclePaths::new(n, 0.0).expect("paths").caustic(2).expect("a caustic");
        assert!((caustic.azimuth.to_degrees() - azimuth).abs() < 1e-3, "{n}");
    }
    let merge = number(closed, &["theta_where_caustics_merge_deg"]);
    let caustic = |theta: f64| CirclePaths::new(N, theta.to_radians()).expect("paths").caustic(2);
    assert!(caustic(merge - 1e-5).is_some() && caustic(merge + 1e-5).is_none());
    let paths = CirclePaths::new(N, 0.0).expect("paths");
    assert!(paths.caustic(0).is_none() && paths.caustic(1).is_none());
}

#[test]
fn roots_are_as_many_as_the_trace_has() {
    let paths = CirclePaths::new(N, 0.0).expect("paths");
    let count = |p: u32, degrees: f64| paths.roots(p, degrees.to_radians()).len();
    let closed = &oracle()["circle_theta0"]["closed_form"];
    let caustic = number(closed, &["TRT_caustic_phi_deg"]).abs();
    let edge = number(closed, &["TRT_phi_at_h1_deg"]);
    let dark = number(closed, &["TT_min_abs_phi_at_h1_deg"]);
    for sign in [-1.0, 1.0] {
        for (degrees, roots) in [(0.01, 3), (caustic - 1e-3, 3), (caustic + 1e-3, 1)] {
            assert_eq!(count(2, sign * degrees), roots, "{degrees}");
        }
        assert_eq!(
            [edge - 1e-3, edge + 1e-3, 90.0, 179.0].map(|d| count(2, sign * d)),
            [1, 0, 0, 0]
        );
        assert_eq!(
            [0.0, dark - 1e-3, dark + 1e-3, 179.0].map(|d| count(1, sign * d)),
            [0, 0, 1, 1]
        );
        assert!((0..180).all(|d| count(0, sign * f64::from(d)) == 1));
    }
}

#[test]
fn roots_are_roots_and_their_densities_count_rays() {
    for (theta, p) in [0.0, 0.5, 1.0].into_iter().flat_map(|t| (0..6).map(move |p| (t, p))) {
        let paths = CirclePaths::new(N, theta).expect("paths");
        for phi in midpoints(-PI, PI, 100) {
            for root in paths.roots(p, phi) {
                let off = (paths.azimuth(p, root.h) - phi) / (2.0 * PI);
                // An ulp of h is multiplied by the slope.
                assert!((off - off.round()).abs() < 1e-14 * (1.0 + 1.0 / root.density), "{off}");
            }
        }
        let found: usize = midpoints(-PI, PI, 20_000).map(|phi| paths.roots(p, phi).len()).sum();
        let path: f64 = {
            let count = 20_000;
            let at =
                |k: u32| paths.azimuth(p, (PI * (f64::from(k) / f64::from(count) - 0.5)).sin());
            (0..count).map(|k| (at(k + 1) - at(k)).abs()).sum()
        };
        // Length of the curve of azimuths over a turn is the mean number of roots.
        let mean = found as f64 / 20_000.0;
        assert!((mean - path / (2.0 * PI)).abs() < 1e-3, "{theta} {p}: {mean} {path}");
    }
}

#[test]
fn the_fresnel_terms_of_bravais_are_those_of_space() {
    for theta in [0.0, 0.3, 1.0, 1.5] {
        let indices = BravaisIndices::new(N, theta).expect("indices");
        assert!((indices.perpendicular * indices.parallel - N * N).abs() < 1e-12);
        let paths = CirclePaths::new(N, theta).expect("paths");
        for h in [0.0, 0.4, -0.9, 0.999] {
            let cos_i = theta.cos() * f64::sqrt(1.0 - h * h);
            let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (N * N)).sqrt();
            let (space, plane) = (
                FresnelReflectance::new(N, cos_i, cos_t),
                FresnelReflectance::projected(&indices, h),
            );
            assert!((space.s - plane.s).abs() < 1e-12 && (space.p - plane.p).abs() < 1e-12);
            let r = OrderShares::new(&paths, h, Polarization::Averaged).first[0];
            assert!((r - space.mean()).abs() < 1e-12);
        }
    }
}

/// Follows fields through the fibre in space, without the formula for the turn of the plane.
#[test]
fn tracked_polarisation_is_that_of_fields_in_space() {
    for (theta, h) in [(0.3, 0.2), (0.8, -0.7), (1.2, 0.95), (0.8, 0.0), (0.0, 0.5)] {
        let paths = CirclePaths::new(N, theta).expect("paths");
        let found = OrderShares::new(&paths, h, Polarization::Tracked);
        let light = Vector3::new(f64::cos(theta), 0.0, f64::sin(theta));
        let (k, side) = (-light, Vector3::new(0.0, -1.0, 0.0));
        let mut normal = side * h + Vector3::x() * f64::sqrt(1.0 - h * h);
        let across = |k: &Vector3<f64>, n: &Vector3<f64>| k.cross(n).normalize();
        let cos_i = -k.dot(&normal);
        let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (N * N)).sqrt();
        let r =
            [(cos_i - N * cos_t) / (cos_i + N * cos_t), (N * cos_i - cos_t) / (N * cos_i + cos_t)];
        let t = Matrix2::from_diagonal(&r.map(|r| (1.0 - r * r).sqrt()).into());
        let r = Matrix2::from_diagonal(&r.into());
        let mut s = across(&k, &normal);
        let mut k = k / N + normal * (cos_i / N - cos_t);
        let mut fields = t;
        let mut shares = vec![0.5 * r.norm_squared()];
        for _ in 1..4 {
            let chord = Vector3::new(k.x, k.y, 0.0);
            normal -= chord * (2.0 * normal.dot(&chord) / chord.norm_squared());
            // Components along s and k x s, in the frame of the next hit.
            let (next, p) = (across(&k, &normal), k.cross(&s));
            let turn = Matrix2::new(
                s.dot(&next),
                p.dot(&next),
                s.dot(&k.cross(&next)),
                p.dot(&k.cross(&next)),
            );
            fields = turn * fields;
            shares.push(0.5 * (t * fields).norm_squared());
            fields = r * fields;
            s = next;
            k -= normal * (2.0 * k.dot(&normal));
        }
        for (p, share) in shares.iter().enumerate() {
            let found = found.order(u32::try_from(p).expect("small"));
            assert!((found - share).abs() < 1e-12, "{theta} {h} {p}: {found}, not {share}");
        }
    }
}

#[test]
fn scales_shift_lobes_as_in_the_trace() {
    let table = oracle()["cuticle_tilt"].as_object().expect("a table");
    assert!(!table.is_empty());
    for (key, case) in table {
        let number_after = |name: &str| -> f64 {
            let rest = key.split(name).nth(1).expect("a name");
            rest.split(' ').next().and_then(|text| text.parse().ok()).expect("a number")
        };
        let (alpha, theta) = (number_after("alpha="), number_after("theta_i="));
        // Light comes from the side of the root.
        let found =
            CuticleTilt::trace(N, alpha.to_radians(), -theta.to_radians()).expect("a trace");
        for (found, name) in found.into_iter().zip(["R_exit_deg", "TT_exit_deg", "TRT_exit_deg"]) {
            let expected = number(case, &[name]);
            assert!(
                (found.to_degrees() - expected).abs() < 6e-4,
                "{key} {name}: {}",
                found.to_degrees()
            );
        }
    }
    // By 2 (p n - 1) alpha for small scales.
    let alpha = 1e-4;
    let tilt = CuticleTilt::of_scales(N, alpha).expect("a tilt");
    for (p, shift) in [0.0, 1.0, 2.0].into_iter().zip(tilt.shift) {
        assert!((shift / alpha - 2.0 * (p * N - 1.0)).abs() < 1e-6);
    }
}

#[test]
fn maps_of_roughness_and_color_are_those_of_the_paper() {
    let table = &oracle()["chiang2016"];
    let near = |found: f64, expected: &serde_json::Value| {
        (found - expected.as_f64().expect("a number")).abs() < 6e-7
    };
    for beta in [0.1, 0.3, 0.5, 0.7, 0.9] {
        let key = beta.to_string();
        assert!(near(longitudinal_variance(beta).expect("a variance"), &table["v(beta_m)"][&key]));
        assert!(near(azimuthal_scale(beta).expect("a scale"), &table["s(beta_n)"][&key]));
        let sigma = absorption_of_color(&Vector3::repeat(0.5), beta).expect("a color");
        assert!(near(sigma.x, &table["sigma_a(colour 0.5, beta_n)"][&key]));
    }
}

/// The normal scattering of an order over all azimuths is what it scatters: by quadrature in the
/// azimuth, in pieces between the ends of the lobe, where the density has roots of a square root.
#[test]
fn normal_scattering_has_the_energy_of_its_order() {
    for (p, theta, ends) in [(0, 0.4, [0.0, PI]), (1, 0.4, [0.0, PI]), (2, 1.0, [0.0, PI])] {
        let paths = CirclePaths::new(N, theta).expect("paths");
        let count = 20_000;
        let sum: f64 = midpoints(ends[0], ends[1], count)
            .map(|phi| {
                normal_scattering(&paths, p, phi, 0.25, Polarization::Averaged).expect("a value")
            })
            .sum();
        let found = 2.0 * sum * (ends[1] - ends[0]) / f64::from(count);
        let expected = energies(theta, 0.25, Polarization::Averaged)[p as usize];
        // A jump at the end of a lobe costs its height times half a part.
        assert!((found - expected).abs() < 1e-4, "{p}: {found}, not {expected}");
    }
    let paths = CirclePaths::new(N, 0.0).expect("paths");
    let at =
        |phi: f64| normal_scattering(&paths, 2, phi, 0.0, Polarization::Averaged).expect("a value");
    let caustic = paths.caustic(2).expect("a caustic").azimuth;
    // Beside the caustic it grows as one over the root of the distance.
    let (near, nearer) = (at(caustic - 1e-6), at(caustic - 1e-8));
    assert!((nearer / near / 10.0 - 1.0).abs() < 1e-2, "{near} {nearer}");
    assert_eq!(at(1.0), 0.0);
}
