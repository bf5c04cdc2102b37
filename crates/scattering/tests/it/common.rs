use nalgebra::Vector3;
use rapunzel_scattering::{Arrival, FiberBsdf, FiberOptics, Polarization};
use serde_json::Value;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::LazyLock;

/// The oracle file.
pub(crate) fn oracle() -> &'static Value {
    static FILE: LazyLock<Value> =
        LazyLock::new(|| rapunzel_oracles::whole("render.json").expect("the oracle file"));
    &FILE
}

/// The number at a path of keys.
pub(crate) fn number(value: &Value, keys: &[&str]) -> f64 {
    let found = keys.iter().fold(value, |value, key| &value[*key]);
    found.as_f64().unwrap_or_else(|| panic!("no number at {keys:?}"))
}

/// The entries of a table whose keys are `name=number`.
pub(crate) fn entries<'a>(value: &'a Value, name: &str) -> Vec<(f64, &'a Value)> {
    let table = value.as_object().expect("a table");
    let of = |key: &str| key.strip_prefix(name)?.strip_prefix('=')?.parse().ok();
    let found: Vec<_> = table.iter().filter_map(|(k, v)| Some((of(k)?, v))).collect();
    assert!(!found.is_empty(), "{name}");
    found
}

/// The midpoints of `count` even parts of an interval, and their length.
pub(crate) fn midpoints(low: f64, high: f64, count: u32) -> impl Iterator<Item = f64> + Clone {
    (0..count).map(move |k| low + (f64::from(k) + 0.5) / f64::from(count) * (high - low))
}

/// The direction of an inclination and an azimuth, rad.
pub(crate) fn direction(theta: f64, phi: f64) -> Vector3<f64> {
    Vector3::new(theta.cos() * phi.cos(), theta.cos() * phi.sin(), theta.sin())
}

/// Even numbers in `[0, 1)` from a seed (`SplitMix64`).
pub(crate) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Hair of the roughness `beta` in both ways, scales at `alpha` degrees.
pub(crate) fn hair(sigma: f64, beta_m: f64, beta_n: f64, alpha: f64) -> FiberOptics {
    let sigma = Vector3::new(1.0, 1.7, 3.3) * sigma;
    FiberOptics::hair(sigma, beta_m, beta_n, alpha.to_radians()).expect("hair")
}

pub(crate) const BOTH: [Polarization; 2] = [Polarization::Averaged, Polarization::Tracked];

/// What is scattered of light from one direction, the mean of the colors, and the integral of the
/// density of samples: by midpoints in the inclination and the azimuth. The error falls faster than
/// any power of the width of a part where that resolves the lobes, but at the poles and where the
/// logistic distribution is cut, as its square.
pub(crate) fn integrals(
    bsdf: &impl FiberBsdf,
    arrival: &Arrival,
    inclinations: u32,
    azimuths: u32,
) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for theta in midpoints(-FRAC_PI_2, FRAC_PI_2, inclinations) {
        for phi in midpoints(-PI, PI, azimuths) {
            let found = bsdf.evaluate(arrival, &direction(theta, phi));
            sums[0] += found.value.mean() * theta.cos() * theta.cos();
            sums[1] += found.pdf * theta.cos();
        }
    }
    sums.map(|sum| sum * 2.0 * PI * PI / f64::from(inclinations) / f64::from(azimuths))
}

/// Checks that samples fall into parts of the sphere as often as their density says: 12 by 12
/// parts, chi squared at most five standard deviations above its mean.
pub(crate) fn chi_squared(bsdf: &impl FiberBsdf, arrival: &Arrival) {
    const PARTS: usize = 12;
    const FINE: u32 = 600;
    let mut expected = [[0.0; PARTS]; PARTS];
    let part = |theta: f64, phi: f64| {
        #[expect(clippy::cast_possible_truncation, reason = "in [0, PARTS]")]
        let of = |x: f64| ((x * PARTS as f64) as usize).min(PARTS - 1);
        (of(theta / PI + 0.5), of(phi / (2.0 * PI) + 0.5))
    };
    for theta in midpoints(-FRAC_PI_2, FRAC_PI_2, FINE) {
        for phi in midpoints(-PI, PI, FINE) {
            let (i, j) = part(theta, phi);
            let measure = theta.cos() * 2.0 * PI * PI / f64::from(FINE * FINE);
            expected[i][j] += bsdf.evaluate(arrival, &direction(theta, phi)).pdf * measure;
        }
    }
    let mut random = random(11);
    let mut found = [[0.0; PARTS]; PARTS];
    let count = 200_000;
    for _ in 0..count {
        let to = bsdf.sample(arrival, &mut random).expect("a direction").to;
        let (i, j) = part(to.z.asin(), to.y.atan2(to.x));
        found[i][j] += 1.0;
    }
    let (mut chi2, mut freedom) = (0.0, -1.0_f64);
    let mut rest = [0.0; 2];
    for (expected, found) in expected.iter().flatten().zip(found.iter().flatten()) {
        let expected = expected * f64::from(count);
        if expected > 10.0 {
            chi2 += (found - expected).powi(2) / expected;
            freedom += 1.0;
        } else {
            rest = [rest[0] + expected, rest[1] + found];
        }
    }
    assert!((rest[0] - rest[1]).abs() < 5.0 * rest[0].sqrt() + 5.0, "{rest:?}");
    assert!(freedom > 10.0);
    assert!(
        chi2 < freedom + 5.0 * (2.0 * freedom).sqrt(),
        "{chi2} with {freedom} degrees of freedom"
    );
}
