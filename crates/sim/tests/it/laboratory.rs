//! What the instruments give back of what was put into simulated hairs.

use rapunzel_keratin::lab::Instrument;
use rapunzel_keratin::{Climate, HairType, Thickness, Treatment};
use rapunzel_sim::lab::{LabSample, Number, Reading, measure};
use rapunzel_sim::scene::{Keratin, Law};

fn sample(kind: HairType, treatment: Treatment, humidity: f64) -> LabSample {
    let (thickness, law, extrapolate) = (Thickness::Any, Law::Elastic, true);
    let keratin = Keratin { kind, treatment, thickness, law, extrapolate };
    LabSample { keratin, climate: Climate::new(humidity, 23.0).expect("a climate") }
}

fn read(instrument: Instrument, sample: &LabSample) -> Reading {
    measure(instrument, sample).expect("a reading")
}

/// By what part a number is off from what was put in.
fn off(number: &Number) -> f64 {
    (number.value / number.put_in.expect("it was put in") - 1.0).abs()
}

#[test]
fn instruments_give_back_what_was_put_in() {
    // Within the bias that each formula is known to have, which `put_in` has in it.
    for (kind, treatment, humidity) in [
        (HairType::Chinese, Treatment::Untreated, 0.65),
        (HairType::African, Treatment::Bleached, 0.3),
        (HairType::Caucasian, Treatment::Relaxed, 1.0),
    ] {
        let sample = sample(kind, treatment, humidity);
        assert!(off(&read(Instrument::Tensile, &sample).numbers[0]) < 1e-9);
        let hook = read(Instrument::Hook, &sample).numbers[0];
        assert!(off(&hook) < 0.01, "{hook:?}");
        let pendulum = read(Instrument::Pendulum, &sample).numbers;
        assert!(off(&pendulum[0]) < 0.01 && off(&pendulum[1]) < 0.02, "{pendulum:?}");
        let swing = read(Instrument::Oscillation, &sample).numbers;
        assert!(off(&swing[0]) < 0.01 && off(&swing[1]) < 0.02, "{swing:?}");
        let waves = read(Instrument::Waviness, &sample).numbers[0];
        assert!(off(&waves) < 0.01, "{waves:?}");
    }
}

#[test]
fn the_capstan_gives_the_coefficient_of_friction() {
    for humidity in [0.65, 1.0] {
        let sample = sample(HairType::Caucasian, Treatment::None, humidity);
        let found = read(Instrument::Capstan, &sample);
        assert!(off(&found.numbers[0]) < 0.01, "{:?}", found.numbers[0]);
    }
}

#[test]
fn damp_hair_is_softer_and_loses_its_curl() {
    let at = |instrument, humidity| {
        let sample = sample(HairType::Caucasian, Treatment::None, humidity);
        read(instrument, &sample).numbers[0].value
    };
    let curls = [0.3, 0.5, 0.7, 0.9].map(|h| at(Instrument::CurlRetention, h));
    assert!(curls.windows(2).all(|w| w[1] < w[0]), "{curls:?}");
    let moduli = [0.3, 0.7, 1.0].map(|h| at(Instrument::Hook, h));
    assert!(moduli.windows(2).all(|w| w[1] < w[0]), "{moduli:?}");
    let ratio = at(Instrument::Hysteresis, 1.0);
    assert!((1.5..=1.8).contains(&ratio), "near 1/0.6: {ratio}");
}

#[test]
fn a_tress_takes_room_and_resists_the_comb() {
    let sample = sample(HairType::Caucasian, Treatment::None, 0.65);
    let volume = read(Instrument::TressVolume, &sample).numbers[0].value;
    // Of a lock 12 mm wide and 12 cm long, waves of 6 mm included: 2 to 30 cm^3.
    assert!((2e-6..30e-6).contains(&volume), "{volume:e}");
    let combing = read(Instrument::Combing, &sample);
    let [peak, mean] = [0, 1].map(|i| combing.numbers[i].value);
    // The comb is held up by what it pulls; sixteen hairs weigh 1e-4 N.
    assert!(mean > 0.0 && peak > 2.0 * mean, "{peak:e} {mean:e}");
}
