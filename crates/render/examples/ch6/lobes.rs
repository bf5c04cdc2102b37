//! Figure 6.2: the light of a single hair in the plane of its axis and the light.

use crate::draw::{chart, curve, peaks, samples};
use crate::studio::{SCALES, hair};
use nalgebra::Vector3;
use rapunzel_repro::plot::Curve;
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_scattering::{CuticleTilt, FarField, FiberBsdf, FiberOptics, Pigments};

/// Angle of the light to the plane across the fibre, degrees.
const LIGHT: f64 = 30.0;
/// Standard deviation of R over inclinations, degrees; that of TRT is twice as large.
const WIDTH: f64 = 5.0;

/// The direction of an inclination, degrees, at the azimuth of the light.
fn direction(degrees: f64) -> Vector3<f64> {
    let theta = degrees.to_radians();
    Vector3::new(theta.cos(), 0.0, theta.sin())
}

/// What a meter sees of a hair, per length, from all inclinations in the plane.
struct Scan {
    /// Mean of the colors.
    curve: Curve,
    /// Its lobes of R and TRT.
    lobes: [Curve; 2],
    far: FarField,
    light: f64,
}

impl Scan {
    /// Light at 30 degrees from the root if `side` is -1, from the tip if it is 1.
    fn new(name: &str, pigments: &Pigments, side: f64) -> Fallible<Self> {
        let v = WIDTH.to_radians().powi(2);
        let variance = [v, 0.25 * v, 4.0 * v, 4.0 * v];
        let far = FarField::new(FiberOptics { variance, ..hair(pigments, 0.3)? })?;
        let light = side * LIGHT;
        let arrival = far.arrive(0.0, &direction(light));
        let over = |name: &str, of: &dyn Fn(&Vector3<f64>) -> f64| {
            let seen = |degrees: f64| [degrees, of(&direction(degrees)) * direction(degrees).x];
            curve(name, samples(-75.0, 75.0, 600).map(seen))
        };
        let curve = over(name, &|to| far.evaluate(&arrival, to).value.mean());
        let lobes = [("R", 0), ("TRT", 2)].map(|(lobe, p)| {
            over(&format!("{name}, {lobe} alone"), &|to| far.lobes(&arrival, to)[p].mean())
        });
        Ok(Self { curve, lobes, far, light })
    }

    /// Blue over red at an inclination, degrees.
    fn tint(&self, degrees: f64) -> f64 {
        let arrival = self.far.arrive(0.0, &direction(self.light));
        let value = self.far.evaluate(&arrival, &direction(degrees)).value;
        value.z / value.x
    }

    /// The maximum of R, and that of TRT, if there is one, which is farther to the tip.
    fn peaks(&self) -> ([f64; 2], Option<[f64; 2]>) {
        let near = peaks(&self.curve).into_iter().filter(|p| (10.0..55.0).contains(&p[0].abs()));
        let mut found: Vec<[f64; 2]> = near.collect();
        found.sort_by(|a, b| a[0].total_cmp(&b[0]));
        (found.first().copied().unwrap_or([f64::NAN; 2]), found.get(1).copied())
    }
}

pub(crate) fn goniophotometer() -> Fallible<Figure> {
    let of = |name: &str, pigments: &Pigments| Scan::new(name, pigments, -1.0);
    let blond = of("blond", &Pigments::BLOND)?;
    let brown = of("brown", &Pigments::BROWN)?;
    let black = of("black", &Pigments::BLACK)?;
    let back = Scan::new("brown, light from the tip", &Pigments::BROWN, 1.0)?;
    let height = |scan: &Scan| scan.peaks().1.map_or(0.0, |p| p[1]);
    let place = |scan: &Scan| scan.peaks().1.map_or(f64::NAN, |p| p[0]);
    let [r, tt, trt] = CuticleTilt::trace(FiberOptics::KERATIN_INDEX, SCALES, -LIGHT.to_radians())?
        .map(|theta| theta.to_degrees() - LIGHT);
    let (first, more) =
        ("maximum about 6 degrees to the root, at 24", "about 16 right of it, at 40");
    let scales = "R 2 alpha to the root, TT at most 2 alpha, TRT more than 2 alpha to the tip";
    let degrees = |what: &str, found: f64, must: Criterion, thesis: &'static str| {
        check(what, found, "degrees", must, thesis)
    };
    let checks = vec![
        degrees("brown: maximum of R", brown.peaks().0[0], Criterion::Within(23.0, 25.0), first),
        degrees("black: maximum", black.peaks().0[0], Criterion::Within(23.0, 25.0), first),
        degrees("blond: maximum of R", blond.peaks().0[0], Criterion::Told, first),
        degrees("brown: second maximum", place(&brown), Criterion::Within(38.0, 42.0), more),
        degrees("blond: second maximum", place(&blond), Criterion::Within(38.0, 44.0), more),
        degrees(
            "brown, light from the tip: maximum of R",
            back.peaks().0[0].abs(),
            Criterion::Within(35.0, 37.0),
            "at 36, the curve as if mirrored",
        ),
        check(
            "second maximum of brown over that of blond",
            height(&brown) / height(&blond),
            "",
            Criterion::AtMost(0.9),
            "lower for brown hair",
        ),
        check(
            "black: height of a second maximum",
            height(&black),
            "",
            Criterion::AtMost(0.0),
            "as a rule none",
        ),
        check(
            "brown: blue over red at the maximum of R",
            brown.tint(brown.peaks().0[0]),
            "",
            Criterion::AtLeast(0.9),
            "white",
        ),
        check(
            "brown: blue over red at the second maximum",
            brown.tint(place(&brown)),
            "",
            Criterion::AtMost(0.6),
            "of the color of the hair",
        ),
        check(
            "blond: second maximum over that of R",
            height(&blond) / blond.peaks().0[1],
            "",
            Criterion::Told,
            "R is the maximum",
        ),
        degrees("scales at 3 degrees, traced: R off", r, Criterion::Within(-6.01, -5.99), scales),
        degrees("scales at 3 degrees, traced: TT off", tt, Criterion::Within(0.0, 6.0), scales),
        degrees("scales at 3 degrees, traced: TRT off", trt, Criterion::AtLeast(6.0), scales),
    ];
    let labels = ["inclination (degrees)", "radiance times cosine, per irradiance"];
    let [[r, fair], [_, dark]] = [blond.lobes.clone(), brown.lobes.clone()];
    let parts = vec![Curve { name: "all, R alone".into(), ..r }, fair, dark];
    let curves = [blond, brown, black, back].map(|scan| scan.curve).to_vec();
    Ok(Figure {
        scene: "a round hair in parallel light at 30 degrees to its normal plane, from the root",
        parameters: "far field in the plane of axis and light; R 5 degrees wide, TRT 10; pigments of \
                     our own",
        drawings: vec![
            chart("6.2 Light of a hair in the plane of its axis and the light", labels, curves),
            chart("6.2 Its parts", labels, parts),
        ],
        checks,
    })
}
