//! Elliptic functions and integrals against values of forty digits, and their identities.

use proptest::prelude::*;
use rapunzel_rod_static::carlson::{rc, rd, rf, rj};
use rapunzel_rod_static::elliptic::{Modulus, first_kind, jacobi, kind_d, second_kind, third_kind};
use serde::Deserialize;
use std::f64::consts::{FRAC_PI_2, PI};

#[derive(Debug, Deserialize)]
struct Values {
    jacobi: Vec<[f64; 5]>,
    integrals: Vec<[f64; 7]>,
    carlson: Vec<[f64; 7]>,
}

fn values() -> Values {
    serde_json::from_str(include_str!("../data/elliptic.json")).expect("the values")
}

#[test]
fn jacobi_functions_have_all_digits() {
    for [u, m, sn, cn, dn] in values().jacobi {
        let found = jacobi(u, m).expect("finite arguments");
        // An argument of size u is known to eps u; a period of a modulus far above one is short.
        let allowed = 4e-15 * (1.0 + u.abs() * m.abs().max(1.0).sqrt());
        for (found, exact) in [(found.sn, sn), (found.cn, cn), (found.dn, dn)] {
            let error = (found - exact).abs() / exact.abs().max(1.0);
            assert!(error < allowed, "u = {u}, m = {m}: {found} for {exact}");
        }
    }
}

#[test]
fn integrals_have_all_digits() {
    for [phi, m, n, first, second, d, third] in values().integrals {
        let found =
            [first_kind(phi, m), second_kind(phi, m), kind_d(phi, m), third_kind(n, phi, m)];
        for (kind, (found, exact)) in found.iter().zip([first, second, d, third]).enumerate() {
            let found = found.expect("a real integral");
            // Where an integrand is steep, the amplitude's last digit counts as often.
            let steep = 1.0 - m.min(1.0).max(n.min(1.0)) * phi.sin().powi(2);
            let error = (found / exact - 1.0).abs();
            // There the integral of the third kind is a difference.
            let lost = if !(0.0..=1.0).contains(&m) && n < 0.0 { 1e-15 * (-n).sqrt() } else { 0.0 };
            let allowed = 1e-14 + lost + 1e-15 * phi.abs() / steep.max(1e-6);
            assert!(error < allowed, "kind {kind}, phi {phi}, m {m}, n {n}: {error:e}");
        }
    }
}

#[test]
fn carlson_integrals_have_all_digits() {
    for [x, y, z, p, first, second, third] in values().carlson {
        let found = [rf(x, y, z), rd(x, y, z), rj(x, y, z, p)];
        for (kind, (found, exact)) in found.iter().zip([first, second, third]).enumerate() {
            let error = (found / exact - 1.0).abs();
            // A principal value is a difference.
            let allowed = if p < 0.0 && kind == 2 { 1e-12 } else { 4e-15 };
            assert!(error < allowed, "kind {kind} of {x}, {y}, {z}, {p}: {found} for {exact}");
        }
    }
}

#[test]
fn degenerate_integrals_are_elementary() {
    assert!((rc(0.0, 0.25) - PI).abs() < 1e-15);
    assert!((rc(0.25, -2.0) - 2.0_f64.ln() / 3.0).abs() < 1e-15);
    assert!((rf(1.0, 1.0, 1.0) - 1.0).abs() < 1e-15);
    assert_eq!(first_kind(1.3, 0.0).map(|f| (f - 1.3).abs() < 1e-15), Some(true));
    assert_eq!(
        second_kind(2.0, 1.0).map(|e| (e - (2.0 - 2.0_f64.sin())).abs() < 1e-15),
        Some(true)
    );
    for (phi, m) in [(FRAC_PI_2, 1.0), (2.0, 1.5), (1.0, 4.0), (f64::NAN, 0.5), (1.0, f64::NAN)] {
        assert_eq!(first_kind(phi, m), None, "phi {phi}, m {m}");
    }
    for complement in [0.0, -1.0, 1.1, f64::NAN] {
        assert_eq!(Modulus::from_complement(complement), None);
    }
}

/// Complements from that of `k = 0` to far below what `1 - k^2` can show.
fn complement() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1.0), Just(1e-200), 0.0..1.0_f64, (-60.0..0.0_f64).prop_map(|e| 10f64.powf(e))]
        .prop_filter("positive", |c| *c > 0.0)
}

proptest! {
    #[test]
    fn squares_add_up(c in complement(), u in -50.0..50.0_f64) {
        let at = Modulus::from_complement(c).expect("a complement").jacobi(u);
        prop_assert!((at.sn * at.sn + at.cn * at.cn - 1.0).abs() < 2e-15);
        let dn = at.cn * at.cn + c * at.sn * at.sn;
        prop_assert!((at.dn * at.dn - dn).abs() < 4e-15 * dn.max(at.dn), "{at:?}");
    }

    #[test]
    fn the_amplitude_inverts_the_first_kind(m in -20.0..0.999_f64, phi in -9.0..9.0_f64) {
        let u = first_kind(phi, m).expect("real");
        let at = jacobi(u, m).expect("finite");
        prop_assert!((at.sn - phi.sin()).abs() < 1e-13 && (at.cn - phi.cos()).abs() < 1e-13);
        if m >= 0.0 {
            let modulus = Modulus::from_complement(1.0 - m).expect("a complement");
            prop_assert!((modulus.amplitude(u) - phi).abs() < 1e-13);
        }
    }

    /// `K` by Landen's transformation is that of Carlson.
    #[test]
    fn quarter_periods_agree(c in complement()) {
        let k = Modulus::from_complement(c).expect("a complement").quarter_period();
        prop_assert!((k / rf(0.0, c, 1.0) - 1.0).abs() < 4e-15);
    }

    /// Legendre's relation of the complete integrals.
    #[test]
    fn legendre(m in 0.0..1.0_f64) {
        let of = |m: f64| first_kind(FRAC_PI_2, m).zip(second_kind(FRAC_PI_2, m));
        if let (Some((k, e)), Some((k1, e1))) = (of(m), of(1.0 - m)) {
            prop_assert!((e * k1 + e1 * k - k * k1 - FRAC_PI_2).abs() < 1e-14 * k.max(k1));
        }
    }

    #[test]
    fn integrals_continue_over_periods(phi in -1.5..1.5_f64, m in -5.0..0.99_f64, n in -5.0..0.99_f64) {
        let shifted = third_kind(n, phi + 3.0 * PI, m).expect("real");
        let whole = 6.0 * third_kind(n, FRAC_PI_2, m).expect("real");
        let part = third_kind(n, phi, m).expect("real");
        prop_assert!((shifted - whole - part).abs() < 1e-13 * whole.abs());
    }
}
