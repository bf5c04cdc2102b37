use nalgebra::Vector3;
use rapunzel_render::{FiberOptics, Polarization};
use serde_json::Value;
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

/// Even numbers in `[0, 1)` from a seed (SplitMix64).
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
