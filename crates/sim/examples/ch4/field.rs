//! Potential and field across the tress at the middle of its length; figure 4.3 shows the potential
//! of one on a grid, which `grid` of a scene writes.

use crate::Size;
use crate::film::play;
use nalgebra::{Point3, Vector3};
use rapunzel_electrostatics::units;
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::{SimError, World};

/// Distance from the axis up to which the field is drawn, m, and points along it.
const FAR: f64 = 0.15;
const POINTS: i32 = 150;

/// The field along the minor axis of the tress, and at the 12 cm of Patel's field meter.
pub(crate) fn plane(size: Size) -> Fallible<Figure> {
    let mut scene = size.scene("tress")?;
    scene.environment.climate.humidity = vec![(0.0, 0.65)];
    scene.duration = 8.0;
    let [mut potential, mut curve] = [Vec::new(), Vec::new()];
    let (mut failed, mut fibers) = (None, 0);
    play(&scene, |world| {
        if world.steps() == 8 {
            fibers = world.assembly().fibers().len();
            match along(world) {
                Ok(both) => [potential, curve] = both,
                Err(error) => failed = Some(error),
            }
        }
    })?;
    if let Some(error) = failed {
        return Err(error.into());
    }
    let at = |distance: f64| {
        let place = curve.iter().find(|[x, _]| *x >= 100.0 * distance - 1e-9);
        place.map_or(f64::NAN, |[_, field]| *field)
    };
    // A long line with the charge of all fibers: 2 k lambda/d, for a finite one a little less.
    let charge = fibers as f64 * units::THESIS_LINE_DENSITY.abs() * 0.3;
    let length = 0.3_f64;
    let line = 1e-3 * 2.0 * units::COULOMB_CONSTANT * charge
        / length
        / 0.12
        / (1.0 + (2.0 * 0.12 / length).powi(2)).sqrt();
    let checks = vec![
        check(
            "field at 12 cm over that of a straight line of the same charge",
            at(0.12) / line,
            "",
            Criterion::Within(0.8, 1.2),
            "20 to 120 kV/m by Patel, which the thesis compares with the field within",
        ),
        check("field at 12 cm", at(0.12), "kV/m", Criterion::Told, "0.86 kV/m for 300 fibers"),
    ];
    Ok(Figure {
        scene: "scenes/charge/tress.ron, charged, at 65 %",
        parameters: "from the middle of the tress outward along its minor axis",
        drawings: vec![
            chart("4.3 Potential across the charged tress", "potential (V)", potential),
            chart("4.3 Field across the charged tress", "field (kV/m)", curve),
        ],
        checks,
    })
}

fn chart(title: &str, y: &'static str, points: Vec<[f64; 2]>) -> Drawing {
    Drawing::Chart(Chart {
        title: title.into(),
        x: "distance from the axis (cm)",
        y,
        log_from: None,
        curves: vec![Curve { name: "magnitude".into(), points }],
    })
}

/// From the middle of the tress on along y: distances (cm) with potentials (V), and with fields
/// (kV/m).
fn along(world: &World) -> Result<[Vec<[f64; 2]>; 2], SimError> {
    let count = world.assembly().fibers().len();
    let middles = (0..count).map(|i| {
        let middle = world.assembly().fibers()[i].segments() / 2;
        world.node(i, Some(middle)).0.coords
    });
    let middle = middles.sum::<Vector3<f64>>() / count as f64;
    let distance = |k: i32| FAR * f64::from(k) / f64::from(POINTS);
    let place = |k| Point3::from(middle + distance(k) * Vector3::y());
    let found = world.electric_fields(&(0..=POINTS).map(place).collect::<Vec<_>>())?;
    let over = |values: Vec<f64>| {
        (0..=POINTS).map(|k| 100.0 * distance(k)).zip(values).map(<[f64; 2]>::from).collect()
    };
    let fields = found.fields.iter().map(|field| 1e-3 * field.norm()).collect();
    Ok([over(found.potentials.iter().map(|v| v.abs()).collect()), over(fields)])
}
