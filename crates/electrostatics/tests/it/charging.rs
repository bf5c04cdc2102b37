//! Charge dealt in steps, and charge that flows.

use proptest::prelude::*;
use rapunzel_electrostatics::{ChargeDealing, ChargeFlow, ElectrostaticsError};

/// All of the charge is dealt, in steps that fall.
#[test]
fn shares_are_the_whole() {
    for steps in [1, 2, 8, 64] {
        for dealing in
            [ChargeDealing::Once, ChargeDealing::Equal(steps), ChargeDealing::Falling(steps)]
        {
            let shares = dealing.shares();
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-14, "{dealing:?}");
            assert!(shares.windows(2).all(|pair| pair[1] <= pair[0]), "{dealing:?}");
        }
        assert_eq!(ChargeDealing::Falling(steps).shares().len(), steps);
    }
    assert!(ChargeDealing::Falling(8).shares()[0] > 2.0 * ChargeDealing::Falling(8).shares()[3]);
    assert!(
        ChargeDealing::Equal(0).shares().is_empty()
            && ChargeDealing::Falling(0).shares().is_empty()
    );
}

/// T22: the first mode of a hair whose root touches an earthed head, `sin(pi s/2L)`, falls as
/// `exp(-t/tau)` with `tau = 4 r c L^2/pi^2`.
#[test]
fn a_hair_is_discharged_by_its_first_mode() {
    let (length, segments) = (0.3, 100);
    // 1e13 ohm/cm and 0.19 pF/cm: about 700 s.
    let flow = ChargeFlow { resistance: 1e15, capacity: 19e-12, head: Some(0.0) };
    let tau =
        4.0 * flow.resistance * flow.capacity * length * length / std::f64::consts::PI.powi(2);
    assert!((tau / 700.0 - 1.0).abs() < 0.02, "{tau} s");
    let lengths = vec![length / segments as f64; segments];
    let mode =
        |i: usize| 1e-12 * (std::f64::consts::FRAC_PI_2 * (i as f64 + 0.5) / segments as f64).sin();
    let mut charges: Vec<_> = (0..segments).map(mode).collect();
    let start: f64 = charges.iter().sum();
    let steps = 2000;
    let mut drained = 0.0;
    for _ in 0..steps {
        let step = tau / f64::from(steps);
        drained += flow.advance(&lengths, &vec![0.0; segments], &mut charges, step).expect("valid");
    }
    let left: f64 = charges.iter().sum();
    assert!((left / start / (-1f64).exp() - 1.0).abs() < 1e-3, "{}", left / start);
    assert!((left + drained - start).abs() < 1e-13 * start, "charge is kept");
    for (i, charge) in charges.iter().enumerate() {
        assert!((charge / mode(i) / (-1f64).exp() - 1.0).abs() < 1e-3, "the mode keeps its form");
    }
}

/// Nonsense is refused, and an empty fibre is nothing.
#[test]
fn nonsense_is_refused() {
    let flow = ChargeFlow { resistance: 1e15, capacity: 19e-12, head: None };
    assert_eq!(flow.advance(&[], &[], &mut [], 1.0), Ok(0.0));
    let refused = [
        flow.advance(&[1.0], &[0.0], &mut [1.0], 0.0),
        flow.advance(&[0.0], &[0.0], &mut [1.0], 1.0),
        flow.advance(&[1.0], &[f64::NAN], &mut [1.0], 1.0),
        ChargeFlow { resistance: 0.0, ..flow }.advance(&[1.0], &[0.0], &mut [1.0], 1.0),
        ChargeFlow { head: Some(f64::INFINITY), ..flow }.advance(&[1.0], &[0.0], &mut [1.0], 1.0),
    ];
    for result in refused {
        assert!(matches!(result, Err(ElectrostaticsError::Setting { .. })), "{result:?}");
    }
    let result = flow.advance(&[1.0], &[0.0], &mut [f64::NAN], 1.0);
    assert!(matches!(result, Err(ElectrostaticsError::Charge { .. })));
    let result = flow.advance(&[1.0], &[], &mut [1.0], 1.0);
    assert!(matches!(result, Err(ElectrostaticsError::Count { .. })));
}

proptest! {
    /// An insulated fibre keeps its charge for any step, and after a long time has one potential:
    /// that of its own charge and of the others is everywhere the same.
    #[test]
    fn insulated_fibres_come_to_one_potential(
        parts in prop::collection::vec((0.2f64..3.0, -1.0f64..1.0, -50.0f64..50.0), 1..30),
    ) {
        let flow = ChargeFlow { resistance: 1e12, capacity: 19e-12, head: None };
        let lengths: Vec<_> = parts.iter().map(|(l, ..)| 1e-3 * l).collect();
        let mut charges: Vec<_> = parts.iter().map(|(_, q, _)| 1e-12 * q).collect();
        let outer: Vec<_> = parts.iter().map(|(.., v)| *v).collect();
        let (start, size): (f64, f64) =
            (charges.iter().sum(), charges.iter().map(|q| q.abs()).sum::<f64>() + 1e-12);
        for _ in 0..3 {
            let drained = flow.advance(&lengths, &outer, &mut charges, 1e6).expect("valid");
            prop_assert_eq!(drained, 0.0);
        }
        prop_assert!((charges.iter().sum::<f64>() - start).abs() < 1e-11 * size);
        let potential = |k: usize| charges[k] / (flow.capacity * lengths[k]) + outer[k];
        for k in 1..charges.len() {
            prop_assert!((potential(k) - potential(0)).abs() < 1e-3, "{} V", potential(k));
        }
    }
}
