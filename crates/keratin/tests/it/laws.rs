//! The laws against closed forms, against each other, and against thermodynamics.

use approx::assert_relative_eq;
use nalgebra::Vector3;
use proptest::prelude::*;
use rapunzel_fiber::SectionLaw;
use rapunzel_keratin::law::{
    Aging, Breuer, Creep, MaxwellElement, MaxwellModel, Relaxation, Tension, ThreeElement,
    Viscoelastic, transitions,
};
use rapunzel_keratin::{Climate, Hair, HairType, Humidity, Temperature};
use std::f64::consts::{PI, TAU};

/// Random models: a spring, or none, and some Maxwell elements, over six decades of time.
fn relaxation() -> impl Strategy<Value = Relaxation> {
    let branch = (0.01..10.0, -3.0..3.0_f64)
        .prop_map(|(modulus, decade)| MaxwellElement { modulus, time: 10_f64.powf(decade) });
    let equilibrium = prop_oneof![Just(0.0), 0.01..5.0];
    (equilibrium, prop::collection::vec(branch, 1..7))
        .prop_map(|(g, branches)| Relaxation::new(g, branches).expect("positive numbers"))
}

/// Random histories: times between steps, and strains.
fn history() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec(((-4.0..3.0_f64).prop_map(|d| 10_f64.powf(d)), -1.0..1.0), 1..40)
}

/// Integral from 0 to t by Gauss and Legendre's rule of four points on panels that grow from both
/// ends, as functions of time do here.
fn integral(t: f64, f: impl Fn(f64) -> f64) -> f64 {
    const NODES: [[f64; 2]; 2] = [
        [0.339_981_043_584_856_3, 0.652_145_154_862_546_1],
        [0.861_136_311_594_052_6, 0.347_854_845_137_453_9],
    ];
    let mut cuts = vec![0.0];
    cuts.extend((0..400).map(|i| 0.5 * t * 10_f64.powf(-8.0 + f64::from(i) / 50.0)));
    let ends: Vec<f64> = cuts.iter().rev().map(|c| t - c).collect();
    cuts.push(0.5 * t);
    cuts.extend(ends);
    let panel = |a: f64, b: f64| {
        let (m, h) = (0.5 * (a + b), 0.5 * (b - a));
        NODES.iter().map(|[x, w]| w * h * (f(m + h * x) + f(m - h * x))).sum::<f64>()
    };
    cuts.windows(2).map(|w| panel(w[0], w[1])).sum()
}

proptest! {
    #[test]
    fn relaxation_and_creep_are_inverse(g in relaxation(), decade in -3.0..3.0_f64) {
        let t = 10_f64.powf(decade);
        let j = Creep::from(&g);
        // (2.6) with the jump at 0.
        let found = j.at(t) * g.glassy() + integral(t, |tau| j.at(t - tau) * g.rate(tau));
        prop_assert!((found - 1.0).abs() < 1e-6, "{}", found - 1.0);
        // Both start at the glassy modulus and compliance; and G* J* = 1.
        prop_assert!((j.at(0.0) * g.at(0.0) - 1.0).abs() < 1e-14);
        let ([g1, g2], [j1, j2]) = (g.dynamic(t), j.dynamic(t));
        prop_assert!((g1 * j1 + g2 * j2 - 1.0).abs() < 1e-9);
        prop_assert!((g2 * j1 - g1 * j2).abs() < 1e-9);
    }

    #[test]
    fn histories_superpose(
        g in relaxation(), one in history(), other in history(), factor in -2.0..2.0_f64,
    ) {
        let absolute = |h: &[(f64, f64)]| -> Vec<(f64, f64)> {
            h.iter().scan(0.0, |t, (dt, x)| { *t += dt; Some((*t, *x)) }).collect()
        };
        let (one, other) = (absolute(&one), absolute(&other));
        let both: Vec<_> =
            one.iter().copied().chain(other.iter().map(|(t, x)| (*t, factor * x))).collect();
        let (j, t) = (Creep::from(&g), 5e3);
        let scale = g.glassy() * 120.0;
        let sum = g.stress(&one, t) + factor * g.stress(&other, t);
        prop_assert!((g.stress(&both, t) - sum).abs() < 1e-10 * scale);
        let sum = j.strain(&one, t) + factor * j.strain(&other, t);
        prop_assert!((j.strain(&both, t) - sum).abs() < 1e-10 * j.at(t) * 120.0);
    }

    #[test]
    fn a_strand_follows_boltzmann(g in relaxation(), history in history()) {
        let mut strand = MaxwellModel::new(&g);
        let (mut t, mut steps, mut last) = (0.0, Vec::new(), 0.0);
        for (dt, strain) in history {
            // A jump, and a rest.
            strand.strain_to(strain, 0.0);
            steps.push((t, strain - last));
            last = strain;
            t += dt;
            let stress = strand.strain_to(strain, dt).stress;
            // Times since the steps are known to the rounding of the clock, each.
            let clock = 2.0 * f64::EPSILON * t / g.branches()[0].time * steps.len() as f64;
            let error = (stress - g.stress(&steps, t)).abs();
            prop_assert!(error < (1e-10 + clock) * g.glassy(), "{error}");
        }
    }

    #[test]
    fn a_strand_creates_no_energy(g in relaxation(), history in history()) {
        let mut strand = MaxwellModel::new(&g);
        let mut done = 0.0;
        for (dt, strain) in history {
            let before = strand.stored_energy();
            let work = strand.strain_to(strain, dt).work;
            done += work.abs();
            prop_assert!(strand.stored_energy() - before <= work + 1e-13 * (done + before));
        }
    }

    #[test]
    fn a_section_creates_no_energy(
        g in relaxation(), history in history(), tau in 0.0..1.0_f64, turn in 0.0..TAU,
    ) {
        let stiffness = Vector3::new(1.0, 2.0, 0.7);
        let law = Viscoelastic::new(stiffness, &g, tau).expect("a law");
        let mut memory = vec![Vector3::zeros(); law.memory()];
        let (mut last, mut moment, mut scale) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for (i, (dt, size)) in history.into_iter().enumerate() {
            let (sin, cos) = (turn * i as f64).sin_cos();
            let strain = size * Vector3::new(cos, sin, sin * cos);
            let before = law.stored_energy(&memory, &last);
            let response = law.response(&memory, &strain, dt);
            law.commit(&mut memory, &strain, dt);
            let after = law.stored_energy(&memory, &strain);
            // Holds for the moment at the end since (1 - m)^2 <= 1 - exp(-2 x), m the mean of
            // exp over a step of x relaxation times.
            let work = response.moment.dot(&(strain - last));
            scale += work.abs() + before;
            prop_assert!(after - before <= work + 1e-12 * scale, "{after} {before} {work}");
            // The tangent is the slope of the moment.
            let other = law.response(&memory, &strain, dt);
            prop_assert_eq!(other.tangent, response.tangent);
            (last, moment) = (strain, response.moment);
        }
        prop_assert!(moment.iter().all(|x| x.is_finite()));
    }

    #[test]
    fn tension_gives_no_work_away(
        recovery in 0.0..=1.0_f64, strains in prop::collection::vec(-0.02..0.5_f64, 1..30),
    ) {
        let mut fiber = Tension::new(3.89e9, recovery).expect("a fibre");
        for strain in strains {
            // Straight pieces of work: the trapezoid is exact between corners, so take many.
            const PARTS: i32 = 200;
            let (from, before) = (fiber.strain(), fiber.available_work());
            let mut work = 0.0;
            for i in 1..=PARTS {
                let (e0, s0) = (fiber.strain(), fiber.stress());
                let next = from + (strain - from) * f64::from(i) / f64::from(PARTS);
                let s1 = fiber.strain_to(next).expect("not broken");
                work += 0.5 * (s0 + s1) * (next - e0);
            }
            // A corner costs at most the modulus by the square of a part.
            let corner = 3.89e9 * ((strain - from) / f64::from(PARTS)).powi(2);
            prop_assert!(fiber.available_work() - before <= work + 3.0 * corner + 1e-3);
        }
    }

    #[test]
    fn a_hair_in_changing_climate_creates_no_energy(
        steps in prop::collection::vec((0.0..=1.0_f64, 0.0..90.0_f64, -1.0..1.0_f64, 1.0..1e4_f64), 1..30),
    ) {
        let mut hair =
            ThreeElement::new(&Hair::of(HairType::Indian), Climate::STANDARD).expect("a hair");
        for (humidity, celsius, strain, dt) in steps {
            hair.enter(Climate::new(humidity, celsius).expect("a climate"));
            let before = hair.stored_energy();
            let work = hair.bend_to(strain, dt).work;
            prop_assert!(hair.stored_energy() - before <= work + 1e-12 * (before + work.abs()));
        }
    }
}

#[test]
fn creep_undoes_relaxation_of_a_standard_solid() {
    // Zener: G = 1 + 3 exp(-t/2) has J = 1 - 3/4 exp(-t/8).
    let g =
        Relaxation::new(1.0, vec![MaxwellElement { modulus: 3.0, time: 2.0 }]).expect("a model");
    let j = Creep::from(&g);
    for t in [0.0, 0.3, 2.0, 50.0] {
        assert_relative_eq!(j.at(t), 1.0 - 0.75 * (-t / 8.0_f64).exp(), max_relative = 1e-14);
    }
    // Maxwell's fluid creeps for ever: J = 1/3 + t/6.
    let fluid =
        Relaxation::new(0.0, vec![MaxwellElement { modulus: 3.0, time: 2.0 }]).expect("a model");
    assert_relative_eq!(Creep::from(&fluid).at(5.0), 1.0 / 3.0 + 5.0 / 6.0, max_relative = 1e-14);
}

#[test]
fn a_cycle_loses_pi_loss_modulus_by_amplitude_squared() {
    let g =
        Relaxation::new(4.1e9, vec![MaxwellElement { modulus: 1e9, time: 0.02 }]).expect("a model");
    let (frequency, amplitude) = (30.0, 0.01);
    let mut strand = MaxwellModel::new(&g);
    let count = 20_000;
    let dt = TAU / frequency / f64::from(count);
    let mut work = 0.0;
    // The first cycles forget the start: 30 of 0.2 s are many relaxation times.
    for i in 1..=31 * count {
        let strain = amplitude * (frequency * dt * f64::from(i)).sin();
        let done = strand.strain_to(strain, dt).work;
        if i > 30 * count {
            work += done;
        }
    }
    let [_, loss] = g.dynamic(frequency);
    // (2.9); straight steps in place of a sine are off by the square of the step, 1e-7.
    assert_relative_eq!(work, PI * loss * amplitude * amplitude, max_relative = 1e-6);
}

#[test]
fn kelvin_and_voigt_creep() {
    let law = Viscoelastic::kelvin_voigt(Vector3::repeat(2.0), 0.5).expect("a law");
    let mut memory = vec![Vector3::zeros(); law.memory()];
    // Under a constant moment the strain is (1 - exp(-t/tau)) M/K; backward Euler in small steps.
    let (moment, dt, count) = (Vector3::new(1.0, 0.0, -1.0), 1e-5, 100_000);
    for _ in 0..count {
        let start = memory[0];
        let there = law.response(&memory, &start, dt);
        let strain = start
            + there.tangent.diagonal().map(|x| 1.0 / x).component_mul(&(moment - there.moment));
        law.commit(&mut memory, &strain, dt);
    }
    let expected = 0.5 * (1.0 - (-2.0_f64).exp());
    assert_relative_eq!(memory[0].x, expected, max_relative = 1e-4);
    assert_relative_eq!(memory[0].z, -expected, max_relative = 1e-4);
}

#[test]
fn wool_relaxes_along_a_line_and_stiffens_with_age() {
    let wool = Aging::wool().expect("Chapman's numbers");
    let aged = wool.at_age(1e9);
    assert_relative_eq!(aged.at(60.0), 4.0e9, max_relative = 1e-12);
    // From one decade to the next it loses 0.3 GPa, less what the end of the distribution at 1000
    // minutes takes: E1(0.01) - E1(0.1) in place of ln 10, 3.8 %.
    for minutes in [1.0, 10.0] {
        let loss = aged.at(60.0 * minutes) - aged.at(600.0 * minutes);
        assert_relative_eq!(loss, 0.3e9, max_relative = 0.04);
    }
    // Classes are 0.3 GPa apart, at all times; between them in the logarithm of age.
    for t in [0.0, 60.0, 6e3] {
        let class = |minutes: f64| wool.at_age(60.0 * minutes).at(t);
        assert_relative_eq!(class(100.0) - class(10.0), 0.3e9, max_relative = 1e-9);
        assert_relative_eq!(class(1000.0) - class(100.0), 0.3e9, max_relative = 1e-9);
        assert_relative_eq!(
            class(31.622_776_601_683_79) - class(10.0),
            0.15e9,
            max_relative = 1e-9
        );
        assert_relative_eq!(class(1.0), class(10.0), max_relative = 1e-15);
    }
    // The modified superposition is Boltzmann's once the material is aged, and less before.
    let steps = [(0.0, 0.01), (600.0, -0.004)];
    let boltzmann = aged.stress(&steps, 1200.0);
    assert_relative_eq!(wool.stress(&steps, 1200.0, 1e9), boltzmann, max_relative = 1e-15);
    assert!(wool.stress(&steps, 1200.0, 600.0) < boltzmann);
}

#[test]
fn tension_has_three_regions() {
    let mut fiber = Tension::new(3.89e9, 0.5).expect("a fibre");
    let slope = |e: f64| (fiber.envelope(e + 1e-4) - fiber.envelope(e)) / 1e-4;
    let [hooke, yields, post] = [slope(0.01), slope(0.2), slope(0.4)];
    assert_relative_eq!(hooke / yields, 100.0, max_relative = 1e-6);
    assert_relative_eq!(post / yields, 10.0, max_relative = 1e-6);
    // 0.30 N at the Hookean limit of a fibre of 70 um.
    assert_relative_eq!(fiber.envelope(0.02) * PI * 35e-6_f64.powi(2), 0.30, max_relative = 0.01);
    // A way in one direction, at once or in parts.
    let mut parts = fiber;
    for i in 1..=30 {
        parts.strain_to(0.01 * f64::from(i)).expect("whole");
    }
    assert_relative_eq!(fiber.strain_to(0.3).expect("whole"), parts.stress(), max_relative = 1e-12);
    // Back to the origin, as in water, and it breaks at 50 %.
    assert_eq!(fiber.strain_to(0.0), Some(0.0));
    assert_eq!(fiber.strain_to(0.51), None);
    assert_eq!(fiber.strain(), 0.0);
    let wet = Tension::of(&Hair::of(HairType::Indian), &Climate::WET, 0.5).expect("a fibre");
    assert_eq!(wet.break_strain(), 1.0);
    assert!(Tension::new(-1.0, 0.5).is_err() && Tension::new(1.0, 1.5).is_err());
}

#[test]
fn breuers_force_falls_with_humidity_once_the_constants_are_exchanged() {
    let hair = Breuer::hair(Temperature::new(200.0).expect("a temperature"));
    let force =
        |law: &Breuer, h| law.force(Temperature::ROOM, Humidity::new(h).expect("a humidity"));
    assert!(force(&hair, 0.0) > force(&hair, 0.5) && force(&hair, 0.5) > force(&hair, 1.0));
    let [k2, k1] = hair.binding;
    let printed = Breuer { binding: [k1, k2], ..hair };
    assert!(force(&printed, 1.0) > force(&printed, 0.0));
    // Dry, at the melting temperature, there is none.
    let melted = hair.force(hair.melting, Humidity::DRY);
    assert!(melted.abs() < 1e-9 * force(&hair, 0.0));
}

#[test]
fn a_water_wave_holds_when_dry_and_is_lost_when_it_is_damp() {
    let hair = Hair::of(HairType::Caucasian);
    let air = |h: f64| Climate::new(h, 23.0).expect("a climate");
    let wave = ThreeElement::water_wave(&hair, 600.0, air(0.5), 3600.0).expect("a wave");
    // What became solid in the new shape, over all that was bent: 1 - 1/2.4 at most.
    let kept = wave.strain();
    assert!((0.5..=1.0 - 1.0 / 2.40 + 0.06).contains(&kept), "{kept}");
    // After three hours: less, the damper the air, and nothing in water.
    let after = |h: f64| {
        let mut wave = wave.clone();
        wave.enter(air(h));
        wave.release(3.0 * 3600.0) / kept
    };
    let retained: Vec<f64> = [0.2, 0.4, 0.6, 0.7, 0.8, 0.9, 1.0].map(after).to_vec();
    assert!(retained.windows(2).all(|w| w[1] < w[0] + 1e-12), "{retained:?}");
    assert!(retained[0] > 0.95 && retained[6].abs() < 0.1, "{retained:?}");
    // A release in parts differs by the error of a release, which is about a per cent.
    let (mut whole, mut parts) = (wave.clone(), wave.clone());
    whole.enter(air(0.8));
    parts.enter(air(0.8));
    whole.release(1e4);
    (0..20).for_each(|_| {
        parts.release(500.0);
    });
    assert!((whole.strain() - parts.strain()).abs() < 0.01 * kept, "{whole:?} {parts:?}");
    // Wound dry, it springs back.
    let mut dry = ThreeElement::new(&hair, air(0.4)).expect("a hair");
    dry.bend_to(1.0, 1.0);
    dry.bend_to(1.0, 4200.0);
    assert!(dry.release(0.0) < 0.15, "{}", dry.strain());
}

#[test]
fn a_section_and_a_strand_of_the_same_hair_agree_in_any_climate() {
    let hair = Hair::of(HairType::Chinese);
    let stiffness = hair.stiffness(&Climate::STANDARD).expect("measured");
    let whole = hair.bending_modulus(&Climate::STANDARD).expect("measured").value;
    let mut strand = ThreeElement::new(&hair, Climate::STANDARD).expect("a hair");
    let mut memory = vec![Vector3::zeros(); 8];
    for (humidity, strain, dt) in
        [(1.0, 1.0, 10.0), (1.0, 1.0, 600.0), (0.4, 0.7, 50.0), (0.9, 0.2, 1e4)]
    {
        let climate = Climate::new(humidity, 23.0).expect("a climate");
        let law = ThreeElement::section(&hair, &climate).expect("a law");
        assert_eq!(law.memory(), memory.len());
        strand.enter(climate);
        let stress = strand.bend_to(strain, dt).stress;
        let bent = strain * Vector3::new(1.0, -1.0, 0.5);
        let moment = law.response(&memory, &bent, dt).moment.component_div(&stiffness);
        law.commit(&mut memory, &bent, dt);
        assert_relative_eq!(moment.x, stress / whole, max_relative = 1e-12);
        assert_relative_eq!(moment.y, -stress / whole, max_relative = 1e-12);
        assert_relative_eq!(moment.z, 0.5 * stress / whole, max_relative = 1e-12);
    }
}

#[test]
fn transitions_fall_with_water() {
    let [low, high] = transitions(&Climate::WET);
    assert!((low.celsius() - 0.0).abs() < 1e-9 && (high.celsius() - 70.0).abs() < 1e-9);
    let dry = Climate::new(0.0, 23.0).expect("a climate");
    assert!((transitions(&dry)[0].celsius() - 144.0).abs() < 1e-9);
}
