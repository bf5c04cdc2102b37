//! Sweeps of the parametric model and of the tensile test.

use rapunzel_keratin::lab::tensile;
use rapunzel_keratin::law::Tension;
use rapunzel_keratin::{
    Climate, Hair, HairType, KeratinError, Outside, SorptionBranch, Treatment, surface, water,
};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

const ROOM: f64 = 23.0;
const HUMIDITY: &str = "relative humidity";

/// The type of hair of all figures, its values marked where nobody measured.
fn hair() -> Hair {
    Hair::of(HairType::Caucasian).outside(Outside::Mark)
}

fn curve(
    name: &str,
    [from, to]: [f64; 2],
    value: impl Fn(f64) -> Result<f64, KeratinError>,
) -> Fallible<Curve> {
    let points = (0..=100).map(|i| {
        let x = from + (to - from) * f64::from(i) / 100.0;
        value(x).map(|y| [x, y])
    });
    Ok(Curve { name: name.into(), points: points.collect::<Result<_, _>>()? })
}

fn chart(title: &str, x: &'static str, y: &'static str, curves: Vec<Curve>) -> Drawing {
    Drawing::Chart(Chart { title: title.into(), x, y, log_from: None, curves })
}

/// Figure 2.3, with the way back as in figure 2.10.
pub(crate) fn tension() -> Fallible<Figure> {
    let mut curves = Vec::new();
    let mut slopes = Vec::new();
    for humidity in [0.3, 0.65, 1.0] {
        let mut fiber = Tension::of(&hair(), &Climate::new(humidity, ROOM)?, 0.6)?;
        let up = tensile::stretch(&mut fiber, 0.45, 450);
        let down = tensile::stretch(&mut fiber, 0.0, 450);
        let region = |from, to| tensile::modulus(&up, from, to);
        slopes.push([region(0.0, 0.018)?, region(0.05, 0.3)?, region(0.34, 0.44)?]);
        let points = up.iter().chain(&down).map(|[e, s]| [100.0 * e, 1e-6 * s]).collect();
        curves.push(Curve { name: format!("{:.0} %", 100.0 * humidity), points });
    }
    let [hooke, yields, post] = slopes[1];
    Ok(Figure {
        scene: "a Caucasian hair in tension",
        parameters: "stress on the way back: 0.6 of that on the way up, assumed",
        drawings: vec![chart("2.3 Stress over strain", "strain (%)", "stress (MPa)", curves)],
        checks: vec![
            check("slope at 65 %", hooke * 1e-9, "GPa", Criterion::Within(3.85, 3.93), "3.89"),
            check(
                "slopes, Hooke over yield",
                hooke / yields,
                "",
                Criterion::Within(99.0, 101.0),
                "100 : 1",
            ),
            check(
                "slopes, post over yield",
                post / yields,
                "",
                Criterion::Within(9.9, 10.1),
                "10 : 1",
            ),
        ],
    })
}

/// Figure 2.11.
pub(crate) fn water() -> Fallible<Figure> {
    let regain = |name: &str, branch| {
        curve(name, [0.0, 1.0], |h| {
            Ok(100.0 * water::regain(&Climate { branch, ..Climate::new(h, ROOM)? }).value)
        })
    };
    let swelling = |name: &str, i: usize| {
        curve(name, [0.0, 1.0], move |h| {
            Ok(100.0 * (water::swelling(&Climate::new(h, ROOM)?)[i] - 1.0))
        })
    };
    Ok(Figure {
        scene: "any hair",
        parameters: "isotherm after Guggenheim, Anderson and de Boer through the thesis's numbers",
        drawings: vec![
            chart(
                "2.11 Regain",
                HUMIDITY,
                "regain (%)",
                vec![
                    regain("absorption", SorptionBranch::Absorption)?,
                    regain("desorption", SorptionBranch::Desorption)?,
                ],
            ),
            chart(
                "Swelling",
                HUMIDITY,
                "more than dry (%)",
                vec![swelling("diameter", 0)?, swelling("length", 1)?],
            ),
        ],
        checks: vec![check(
            "diameter at saturation, over that of dry hair",
            water::swelling(&Climate::WET)[0],
            "",
            Criterion::AtMost(1.16),
            "up to 16 %",
        )],
    })
}

/// Figure 2.14.
pub(crate) fn warmth() -> Fallible<Figure> {
    let e = |humidity: f64| {
        move |celsius| {
            let climate = Climate::new(humidity, celsius)?;
            Ok(1e-9 * hair().stretching_modulus(&climate)?.value)
        }
    };
    let range = [0.0, 95.0];
    let curves = vec![curve("65 %", range, e(0.65))?, curve("in water", range, e(1.0))?];
    let fall = e(1.0)(20.0)? / e(1.0)(90.0)?;
    Ok(Figure {
        scene: "a Caucasian hair",
        parameters: "the values of line 468 exchanged; below 20 and above 90 C extrapolated",
        drawings: vec![chart("2.14 Young's modulus", "temperature (C)", "E (GPa)", curves)],
        checks: vec![check(
            "E in water at 20 C over that at 90 C",
            fall,
            "",
            Criterion::AtLeast(1.0),
            "falls with temperature",
        )],
    })
}

/// Figure 2.16, with the other moduli.
pub(crate) fn moduli() -> Fallible<Figure> {
    type Modulus = fn(&Hair, &Climate) -> Result<rapunzel_keratin::MeasuredValue, KeratinError>;
    let all: [(&str, Modulus); 3] = [
        ("tension", Hair::stretching_modulus),
        ("bending", Hair::bending_modulus),
        ("torsion", Hair::shear_modulus),
    ];
    let mut curves = Vec::new();
    let mut checks = Vec::new();
    for ((name, modulus), (thesis, text)) in
        all.into_iter().zip([(2.62, "2.62"), (2.40, "2.40"), (4.10, "4.10")])
    {
        let at = |h: f64| Ok(1e-9 * modulus(&hair(), &Climate::new(h, ROOM)?)?.value);
        curves.push(curve(name, [0.0, 1.0], at)?);
        let within = Criterion::Within(thesis - 1e-9, thesis + 1e-9);
        checks.push(check(
            format!("{name}, 65 over 100 %"),
            at(0.65)? / at(1.0)?,
            "",
            within,
            text,
        ));
    }
    Ok(Figure {
        scene: "a Caucasian hair",
        parameters: "table 2.9; below 6 % extrapolated",
        drawings: vec![chart("2.16 Moduli", HUMIDITY, "modulus (GPa)", curves)],
        checks,
    })
}

/// Figure 2.17, left.
pub(crate) fn torsion() -> Fallible<Figure> {
    let mut curves = Vec::new();
    for treatment in &Treatment::ALL[1..] {
        let hair = hair().treated(*treatment);
        curves.push(curve(treatment.name(), [0.3, 1.0], |h| {
            Ok(1e-9 * hair.shear_modulus(&Climate::new(h, ROOM)?)?.value)
        })?);
    }
    let g = |treatment, h| -> Fallible<f64> {
        Ok(hair().treated(treatment).shear_modulus(&Climate::new(h, ROOM)?)?.value)
    };
    let ratio = |h| {
        Ok::<_, Box<dyn std::error::Error>>(g(Treatment::Permed, h)? / g(Treatment::Untreated, h)?)
    };
    Ok(Figure {
        scene: "a Caucasian hair after treatments",
        parameters: "table 2.10 between 65 and 100 %",
        drawings: vec![chart("2.17 Shear modulus", HUMIDITY, "G (GPa)", curves)],
        checks: vec![
            check(
                "permed over untreated at 65 %",
                ratio(0.65)?,
                "",
                Criterion::Told,
                "slightly above 1 below 90 % (but 0.99 in table 2.10)",
            ),
            check(
                "permed over untreated at 95 %",
                ratio(0.95)?,
                "",
                Criterion::AtMost(1.0),
                "below 1",
            ),
        ],
    })
}

/// Section 2.4.10.
pub(crate) fn resistance() -> Fallible<Figure> {
    let mut curves = Vec::new();
    for celsius in [13.0, 23.0, 33.0] {
        curves.push(curve(&format!("{celsius:.0} C"), [0.3, 1.0], |h| {
            Ok(surface::resistance(&Climate::new(h, celsius)?, Outside::Refuse)?.value)
        })?);
    }
    let at = |celsius| {
        let climate = Climate::new(0.85, celsius)?;
        Ok::<_, KeratinError>(surface::resistance(&climate, Outside::Refuse)?.value)
    };
    let title = "Electric resistance".into();
    let chart = Chart { title, x: HUMIDITY, y: "resistance (ohm)", log_from: Some(1e6), curves };
    Ok(Figure {
        scene: "any hair",
        parameters: "the dependence on humidity is that of wool",
        drawings: vec![Drawing::Chart(chart)],
        checks: vec![
            check(
                "23 C over 33 C at 85 %",
                at(23.0)? / at(33.0)?,
                "",
                Criterion::Within(5.0 - 1e-9, 5.0 + 1e-9),
                "5",
            ),
            check("at 85 %", at(23.0)?, "ohm", Criterion::Within(1e13, 1.7e13), "1.0 to 1.7e13"),
        ],
    })
}
