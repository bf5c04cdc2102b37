//! Figure 6.6, elliptical sections: the rule (6.12) against rays that are traced.

use crate::draw::{chart, curve, midpoints};
use crate::trace::INDEX;
use rapunzel_fiber::Section;
use rapunzel_repro::plot::Curve;
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_scattering::{
    CirclePaths, EllipsePaths, Polarization, equivalent_index, normal_scattering,
};

/// Axis along the light over that across it.
const RATIOS: [f64; 5] = [0.85, 0.90, 1.00, 1.10, 1.20];
/// Parts of a turn in which light is counted, of a degree.
const BINS: usize = 360;
/// Azimuths in a part at which (6.11) is taken; it is infinite at a glint.
const FINE: u32 = 400;

/// Light over the azimuths, in even parts of a turn from -180 degrees on.
struct Spread {
    bins: [f64; BINS],
    /// Azimuth of the glint, degrees.
    glint: Option<f64>,
}

impl Spread {
    /// What rays bring that are traced through the ellipse.
    fn traced(ratio: f64) -> Fallible<Self> {
        let paths = EllipsePaths::new(INDEX, 0.0, &Section::Ellipse { a: ratio, b: 1.0 })?;
        let mut bins = [0.0; BINS];
        let count = 400_000;
        for h in midpoints(-1.0, 1.0, count) {
            let ray = paths.trace(0.0, h);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "in [0, BINS]"
            )]
            let bin = ((ray.azimuth[2].to_degrees() + 180.0) / 360.0 * BINS as f64) as usize;
            bins[bin.min(BINS - 1)] += ray.share[2] / f64::from(count);
        }
        let glint = paths.caustics(0.0).first().map(|c| c.azimuth.to_degrees().abs());
        Ok(Self { bins, glint })
    }

    /// What (6.11) says of the circle with the index of (6.12).
    fn printed(ratio: f64) -> Fallible<Self> {
        let (mut bins, mut several) = ([0.0; BINS], Vec::new());
        let width = 360.0 / BINS as f64;
        for (k, bin) in bins.iter_mut().enumerate() {
            let low = width * k as f64 - 180.0;
            for degrees in midpoints(low, low + width, FINE) {
                let azimuth = degrees.to_radians();
                let n = equivalent_index(INDEX, ratio, 0.5 * azimuth)?;
                let paths = CirclePaths::new(n, 0.0)?;
                if paths.roots(2, azimuth).len() > 1 {
                    several.push(degrees.abs());
                }
                let value = normal_scattering(&paths, 2, azimuth, 0.0, Polarization::Averaged)?;
                *bin += value * width.to_radians() / f64::from(FINE);
            }
        }
        // There, two roots become one and end.
        let glint = several.into_iter().reduce(f64::max);
        Ok(Self { bins, glint })
    }

    fn energy(&self) -> f64 {
        self.bins.iter().sum()
    }

    fn middle(k: usize) -> f64 {
        360.0 * (k as f64 + 0.5) / BINS as f64 - 180.0
    }

    fn curve(&self, name: &str) -> Curve {
        let per_radian = BINS as f64 / std::f64::consts::TAU;
        let points = (0..BINS).map(|k| [Self::middle(k), self.bins[k] * per_radian]);
        curve(name, points.filter(|p| p[0].abs() < 90.0))
    }
}

pub(crate) fn sections() -> Fallible<Figure> {
    let told = "(6.12) holds about for moderate ellipses";
    let (mut checks, mut traced_curves, mut printed_curves) = (Vec::new(), Vec::new(), Vec::new());
    let mut energies = [Vec::new(), Vec::new()];
    for ratio in RATIOS {
        let (traced, printed) = (Spread::traced(ratio)?, Spread::printed(ratio)?);
        traced_curves.push(traced.curve(&format!("traced, axes {ratio:.2} : 1")));
        printed_curves.push(printed.curve(&format!("(6.12), axes {ratio:.2} : 1")));
        let over = printed.energy() / traced.energy();
        energies[0].push([ratio, 100.0 * traced.energy()]);
        energies[1].push([ratio, 100.0 * printed.energy()]);
        let wrong = match ratio {
            1.0 => Criterion::Within(0.98, 1.02),
            _ if ratio < 1.0 => Criterion::AtMost(0.67),
            _ => Criterion::AtLeast(1.5),
        };
        let name = format!("TRT, axes {ratio:.2} : 1: energy by (6.12) over that of traced rays");
        checks.push(check(name, over, "", wrong, told));
        if let (Some(traced), Some(printed)) = (traced.glint, printed.glint) {
            let name = format!("TRT, axes {ratio:.2} : 1: glint by (6.12), less traced");
            let right = Criterion::Within(-0.02, 0.02);
            let must = if ratio == 1.0 { right } else { Criterion::Told };
            checks.push(check(name, printed - traced, "degrees", must, told));
        }
    }
    let labels = ["change of azimuth (degrees)", "N_TRT (1/rad)"];
    let [traced, printed] = energies;
    Ok(Figure {
        scene: "smooth fibres, n = 1.55, without absorption, level light along an axis",
        parameters: "400,000 rays; means over a degree",
        drawings: vec![
            chart("6.6 TRT of ellipses, traced", labels, traced_curves),
            chart("6.6 TRT of ellipses by the rule (6.12)", labels, printed_curves),
            chart(
                "6.6 Energy of TRT",
                ["axis along the light over that across", "energy (%)"],
                vec![curve("traced", traced), curve("(6.12)", printed)],
            ),
        ],
        checks,
    })
}
