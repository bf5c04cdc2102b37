//! Every number of the tables is returned where it was measured.

use approx::assert_relative_eq;
use rapunzel_keratin::moduli::{oscillating_moduli, sound};
use rapunzel_keratin::surface::{
    Direction, Spray, Wetness, bond_strength, friction, resistance, waviness,
};
use rapunzel_keratin::tables::{Value, fact, tables};
use rapunzel_keratin::{
    Climate, Growth, Hair, HairType, Humidity, KeratinError, MeasuredValue, Outside, Sex, Standing,
    Thickness, Treatment, follicle_density, water,
};

/// Some operations on numbers of full precision.
const ROUNDING: f64 = 1e-14;

/// Checks a value, that it counts as measured, and that it tells a line of the thesis.
fn measured(found: &MeasuredValue, expected: f64) {
    assert_relative_eq!(found.value, expected, max_relative = ROUNDING);
    assert_eq!(found.standing, Standing::Measured, "{found:?}");
    assert!(found.sources.iter().all(|s| (283..=1005).contains(&s.line)), "{found:?}");
    assert!(!found.sources.is_empty(), "{found:?}");
}

fn at(humidity: f64, celsius: f64) -> Climate {
    Climate::new(humidity, celsius).expect("a climate")
}

#[test]
fn nothing_was_lost() {
    let t = tables();
    let rows = [
        t.growth.rows.len(),
        t.diameters.rows.len(),
        t.waviness.rows.len(),
        t.follicles.rows.len(),
        t.sound.rows.len(),
        t.nikiforidis.rows.len(),
        t.second_moments.rows.len(),
        t.scott_robbins.rows.len(),
        t.moduli.rows.len(),
        t.torsion.rows.len(),
        t.friction.rows.len(),
        t.sprays.rows.len(),
    ];
    assert_eq!(rows, [4, 7, 7, 2, 2, 15, 4, 12, 3, 6, 24, 4]);
    assert_eq!(t.facts.len(), 85);
}

#[test]
fn sizes() {
    for (kind, row) in Growth::ALL.iter().zip(&tables().growth.rows) {
        assert_eq!(kind.name(), row.kind);
        let [length, diameter] = kind.size();
        measured(&length, row.l_max * 1e-2);
        measured(&diameter, row.r_max * 1e-6);
    }
    for (kind, row) in HairType::ALL.iter().zip(&tables().diameters.rows) {
        assert_eq!(row.group.parse(), Ok(*kind));
        let hair = Hair::of(*kind);
        let [largest, smallest] = hair.diameters(&Climate::STANDARD);
        measured(&largest, row.d_max * 1e-6);
        measured(&smallest, row.d_min * 1e-6);
        // The printed ratio has two decimals.
        assert!((largest.value / smallest.value - row.ratio).abs() < 0.00501, "{row:?}");
        // Printed areas are 1.6 to 8.9 % larger than those of the ellipses.
        let more = row.area * 1e-12 / hair.section(&Climate::STANDARD).area();
        assert!((1.0155..=1.0895).contains(&more), "{row:?}: {more}");
    }
    let follicles = &tables().follicles.rows;
    for (ages, row) in [[16.0, 29.0], [30.0, 55.0]].iter().zip(follicles) {
        for (sex, value) in [(Sex::Female, row.female), (Sex::Male, row.male)] {
            for years in ages {
                let found = follicle_density(sex, *years, Outside::Refuse).expect("measured");
                measured(&found, value * 1e4);
            }
        }
    }
}

#[test]
fn ratios_of_second_moments_are_those_of_table_2_7() {
    let moments = |kind: HairType| Hair::of(kind).section(&Climate::STANDARD).second_moments();
    let [european, ..] = moments(HairType::WestEuropean);
    for row in &tables().second_moments.rows {
        let [i1, i2, _] = moments(row.group.parse().expect("a type"));
        assert!((i2 / i1 - row.i2_i1).abs() <= 0.00501, "{row:?}: {}", i2 / i1);
        assert!((i1 / european - row.i1_i1w).abs() <= 0.00501, "{row:?}: {}", i1 / european);
    }
}

#[test]
fn moduli() {
    let hair = Hair::of(HairType::Caucasian);
    let [stretching, bending, torsion] = [0, 1, 2].map(|row| tables().moduli.rows[row]);
    for (humidity, wet) in [(0.60, false), (0.65, false), (1.0, true)] {
        let climate = at(humidity, 23.0);
        let expected = |row: rapunzel_keratin::tables::Modulus| {
            1e9 * row.modulus / if wet { row.ratio_65_100 } else { 1.0 }
        };
        measured(&hair.stretching_modulus(&climate).expect("measured"), expected(stretching));
        measured(&hair.bending_modulus(&climate).expect("measured"), expected(bending));
        measured(&hair.shear_modulus(&climate).expect("measured"), expected(torsion));
    }
    let rows = &tables().nikiforidis.rows;
    let mean = |e: [f64; 15]| 1e9 * e.iter().sum::<f64>() / 15.0;
    let [thin, thick] = [
        mean(std::array::from_fn(|i| rows[i].e_thin)),
        mean(std::array::from_fn(|i| rows[i].e_thick)),
    ];
    for (class, expected) in [(Thickness::Thin, thin), (Thickness::Thick, thick)] {
        let found = hair.of_thickness(class).stretching_modulus(&at(0.45, 23.0)).expect("measured");
        assert_relative_eq!(found.value, expected, max_relative = ROUNDING);
    }
    for row in &tables().sound.rows {
        let humidity = Humidity::new(row.rh / 100.0).expect("a humidity");
        let [speed, modulus] = sound(humidity, Outside::Refuse).expect("measured");
        measured(&speed, 1e3 * row.v_s);
        measured(&modulus, 1e9 * row.e);
        // E = rho v^2, printed with two digits.
        let density = hair.density(&Climate::STANDARD).value;
        assert_relative_eq!(density * speed.value.powi(2), modulus.value, max_relative = 0.005);
    }
    let [storage, loss] = oscillating_moduli();
    measured(&storage, 4.1e9);
    measured(&loss, 0.177e9);
}

#[test]
fn torsion_after_treatments() {
    for (treatment, row) in Treatment::ALL[1..].iter().zip(&tables().torsion.rows) {
        assert_eq!(row.treatment.parse(), Ok(*treatment));
        let hair = Hair::of(HairType::Caucasian).treated(*treatment);
        let shear = |climate: &Climate| hair.shear_modulus(climate).expect("measured");
        measured(&shear(&Climate::STANDARD), 1e9 * row.g);
        let decrement = hair.log_decrement(&Climate::STANDARD).expect("measured");
        measured(&decrement, row.log_decrement);
        let loss = hair.torsional_loss_modulus(&Climate::STANDARD).expect("measured");
        measured(&loss, 1e9 * row.g * row.log_decrement / std::f64::consts::PI);
        // Rigidity is G A^2, (2.13).
        let rigidity =
            |climate: &Climate| shear(climate).value * hair.section(climate).area().powi(2);
        let ratio = rigidity(&Climate::WET) / rigidity(&Climate::STANDARD);
        assert_relative_eq!(ratio, row.rigidity_ratio, max_relative = ROUNDING);
    }
    // The wet modulus of line 861 is met without having been used: 0.18 GPa, against 0.20.
    let wet = Hair::of(HairType::Caucasian)
        .treated(Treatment::Untreated)
        .shear_modulus(&Climate::WET)
        .expect("measured");
    let Some(Value::Number(measured)) = fact("g_wet").map(|f| f.value.clone()) else {
        panic!("a number");
    };
    assert_relative_eq!(wet.value, 1e9 * measured, max_relative = 0.15);
}

#[test]
fn surfaces() {
    for row in &tables().friction.rows {
        let direction = Direction::ALL[usize::from(row.direction) - 1];
        let ask = |wetness| friction(row.pair, row.treatment, direction, wetness);
        let shifted = row.treatment.starts_with("washed with ABS");
        for (wetness, slip, stick) in [
            (Wetness::Dry, row.mu_k_dry, row.mu_s_dry),
            (Wetness::Wet, row.mu_k_wet, row.mu_s_wet.filter(|_| !shifted)),
        ] {
            if let Some(slip) = slip {
                measured(&ask(wetness).expect("measured").slip, slip);
            }
            if let Some(stick) = stick {
                measured(&ask(wetness).expect("measured").stick, stick);
            }
        }
        if shifted {
            let dry = ask(Wetness::Dry).expect("read so").slip;
            assert_eq!((Some(dry.value), dry.standing), (row.mu_s_wet, Standing::Assumed));
        }
    }
    for (spray, row) in Spray::ALL.iter().zip(&tables().sprays.rows) {
        let [least, most] = bond_strength(row.class.parse().expect("a class"));
        assert_eq!(spray.name(), row.class);
        measured(&least, row.force.0);
        measured(&most, row.force.1);
    }
    for row in &tables().waviness.rows {
        measured(&waviness(row.hair, row.treatment, Wetness::Dry).expect("measured"), row.dry);
        if let Some(wet) = row.wet {
            measured(&waviness(row.hair, row.treatment, Wetness::Wet).expect("measured"), wet);
        }
    }
    let resistance = resistance(&at(0.85, 23.0), Outside::Refuse).expect("measured");
    measured(&resistance, 1.7e26_f64.sqrt());
    assert!((1e13..=1.7e13).contains(&resistance.value));
}

#[test]
fn water_and_warmth() {
    measured(&water::regain(&Climate::WET), 0.30);
    measured(&water::regain(&Climate::STANDARD), 0.15);
    measured(&Hair::of(HairType::Indian).density(&Climate::STANDARD), 1300.0);
    let e = |celsius| {
        Hair::of(HairType::Indian).stretching_modulus(&at(1.0, celsius)).expect("measured")
    };
    // Exchanged: see the inconsistencies.
    for (celsius, expected) in [(40.0, 1.03e9), (90.0, 0.38e9)] {
        assert_relative_eq!(e(celsius).value, expected, max_relative = ROUNDING);
        assert_eq!(e(celsius).standing, Standing::Assumed);
    }
}

#[test]
fn facts_are_found_by_name() {
    for one in &tables().facts {
        let found = fact(one.key).expect("a fact");
        assert_eq!(found, one);
        assert_eq!(found.origin().line, one.line);
        assert!((283..=1005).contains(&one.line), "{}", one.key);
        match &one.value {
            Value::Number(x) => assert!(x.is_finite(), "{}", one.key),
            Value::Range(low, high) => assert!(low <= high, "{}", one.key),
            Value::List(all) => assert!(all.len() > 2, "{}", one.key),
            Value::Text(text) => assert!(!text.is_empty(), "{}", one.key),
            Value::Flag(_) => {}
        }
    }
    assert_eq!(fact("no such fact"), None);
}

#[test]
fn where_nobody_measured_is_refused_or_marked() {
    let hair = Hair::of(HairType::African);
    for (humidity, celsius) in [(0.02, 23.0), (0.65, 60.0), (0.65, -10.0), (1.0, 95.0)] {
        let climate = at(humidity, celsius);
        let refused = hair.stretching_modulus(&climate).expect_err("nobody measured");
        assert!(matches!(refused, KeratinError::Outside { .. }), "{refused}");
        let marked = hair.outside(Outside::Mark).stretching_modulus(&climate).expect("marked");
        assert_eq!(marked.standing, Standing::Extrapolated);
        assert!(marked.value > 0.0 && marked.value.is_finite());
    }
    assert!(hair.log_decrement(&Climate::WET).is_err());
    assert!(resistance(&at(0.1, 23.0), Outside::Refuse).is_err());
}

#[test]
fn moduli_never_rise_with_humidity_or_warmth() {
    let hair = Hair::of(HairType::Mongolian).outside(Outside::Mark);
    let all = |climate: &Climate| {
        let e = hair.stretching_modulus(climate).expect("marked").value;
        let b = hair.bending_modulus(climate).expect("marked").value;
        let g = hair.shear_modulus(climate).expect("marked").value;
        [e, b, g]
    };
    for i in 0..100 {
        let h = f64::from(i) / 100.0;
        for (here, there) in all(&at(h, 23.0)).iter().zip(all(&at(h + 0.01, 23.0))) {
            assert!(there <= here * (1.0 + ROUNDING), "at {h}");
        }
        let t = f64::from(i);
        for (here, there) in all(&at(1.0, t)).iter().zip(all(&at(1.0, t + 1.0))) {
            assert!(there <= here * (1.0 + ROUNDING), "at {t} C");
        }
    }
}
