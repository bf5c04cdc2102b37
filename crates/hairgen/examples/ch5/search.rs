//! Section 5.3.3: the search of guides without derivatives, and ours by the adjoint.

use crate::grown::{Ground, Size};
use rapunzel_hairgen::head::HairVolume;
use rapunzel_hairgen::thesis::simplex_guides;
use rapunzel_hairgen::{GuideOptions, place_guides};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};

/// Equilibria that the simplex may take for a guide.
const MOST: usize = 4000;
/// Part of a value by which another must be lower to be another minimum.
const LOWER: f64 = 1e-3;

/// Values and equilibria of both on the same pores.
pub(crate) fn compared(size: Size) -> Fallible<Figure> {
    let ground = Ground::new(&HairVolume::BOB, 0.24, 1000)?;
    let (pores, region) = (&ground.pores[..size.of(200, 20)], ground.region());
    // As low as the simplex goes.
    let options = GuideOptions { tolerance: 2.5e-8, ..GuideOptions::default() };
    let own = place_guides(pores, &ground.pre, region, None, &options)?.guides;
    let simplex = simplex_guides(pores, &ground.pre, region, None, &options, MOST)?;
    let mut pairs: Vec<_> = own
        .iter()
        .filter_map(|guide| Some((guide, simplex.get(guide.pore).copied().flatten()?)))
        .collect();
    pairs.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
    let count = pairs.len().max(1) as f64;
    let curves = |values: [Vec<f64>; 2]| {
        let numbered =
            |values: Vec<f64>| (1..).map(f64::from).zip(values).map(<[f64; 2]>::from).collect();
        let names = ["simplex, without derivatives", "quasi-Newton, by the adjoint"];
        let both = names.into_iter().zip(values);
        both.map(|(name, values)| Curve { name: name.into(), points: numbered(values) }).collect()
    };
    let chart = |title: &str, y, log_from, curves| {
        let x = "guides by the value that the simplex finds";
        Drawing::Chart(Chart { title: title.into(), x, y, log_from, curves })
    };
    let values = [
        pairs.iter().map(|(_, simplex)| simplex.value).collect(),
        pairs.iter().map(|(own, _)| own.value).collect(),
    ];
    let equilibria: [Vec<f64>; 2] = [
        pairs.iter().map(|(_, simplex)| simplex.equilibria as f64).collect(),
        pairs.iter().map(|(own, _)| own.equilibria as f64).collect(),
    ];
    let [others, ours] = equilibria.each_ref().map(|all| all.iter().sum::<f64>());
    let share = |lower: &dyn Fn(f64, f64) -> bool| {
        100.0 * pairs.iter().filter(|(own, simplex)| lower(own.value, simplex.value)).count() as f64
            / count
    };
    let sum = |values: &Vec<f64>| values.iter().sum::<f64>();
    let ratio = sum(&values[1]) / sum(&values[0]);
    Ok(Figure {
        scene: "the bob on the parametric head, hairs of 24 cm",
        parameters: "20 pores, --full 200; at most 4,000 equilibria of the simplex, 60 of ours",
        drawings: vec![
            chart(
                "5.3.3 The objective (5.7) at the end loads found",
                "value",
                Some(1e-6),
                curves(values),
            ),
            chart(
                "5.3.3 Equilibria that the search took",
                "equilibria",
                Some(1.0),
                curves(equilibria),
            ),
        ],
        checks: vec![
            check(
                "sum of all values, ours over the simplex's",
                ratio,
                "",
                Criterion::AtMost(1.0),
                "one search only",
            ),
            check(
                "guides for which the simplex finds less by a thousandth",
                share(&|own, simplex| simplex < own * (1.0 - LOWER)),
                "%",
                Criterion::AtMost(1.0),
                "one search only",
            ),
            check(
                "guides for which ours finds less by a thousandth",
                share(&|own, simplex| own < simplex * (1.0 - LOWER)),
                "%",
                Criterion::Told,
                "one search only",
            ),
            check(
                "equilibria of the simplex over ours",
                others / ours,
                "",
                Criterion::AtLeast(50.0),
                "one search only",
            ),
        ],
    })
}
