//! Figure 4.9: half a head of hair, before and after it is charged together with its head.

use crate::Size;
use crate::film::{Film, play, scene};
use nalgebra::Vector3;
use rapunzel_repro::plot::{Chart, Curve, Drawing, Pictures};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::scene::{Amount, Arrangement};
use rapunzel_sim::{Scene, World};

/// The thesis's hairs, and ours where time is short.
const THESIS: usize = 65_000;
const FEW: usize = 400;
/// Most hairs that are drawn.
const DRAWN: usize = 3250;

/// The half head, its pictures, and how far its tips are from its middle with every portion.
pub(crate) fn charged(size: Size) -> Fallible<Figure> {
    let mut half = scene("charge/half-head")?;
    let (count, parameters) = match size {
        Size::Full => (
            THESIS,
            "65,000 hairs of 20 segments, lifted as the scene's 2000; every twentieth is drawn",
        ),
        Size::Reduced => (
            FEW,
            "400 hairs of 20 segments, lifted as the scene's 2000; --full takes the thesis's 65,000",
        ),
    };
    resize(&mut half, count)?;
    let mut film = Film::at(&[0.0, half.duration]);
    let (mut distances, mut unsettled, mut strongest) = (Vec::new(), 0, 0.0_f64);
    play(&half, |world| {
        film.observe(world);
        distances.push([world.time(), 1e3 * distance(world)]);
        let Some(report) = world.charge_report().filter(|_| world.steps() > 0) else { return };
        unsettled += report.unsettled;
        strongest = strongest.max(report.lift);
    })?;
    for picture in &mut film.pictures {
        let all = std::mem::take(&mut picture.fibers);
        picture.fibers = all.into_iter().step_by(count.div_ceil(DRAWN)).collect();
    }
    let [before, after] = [distances[0], distances[distances.len() - 1]].map(|[_, value]| value);
    Ok(Figure {
        scene: "scenes/charge/half-head.ron",
        parameters,
        drawings: vec![
            Drawing::Pictures(Pictures {
                title: format!("4.9 Half a head of {count} hairs, before its charge first"),
                view: "seen from the front along y, x to the right",
                axes: [Vector3::x(), Vector3::z()],
                columns: 2,
                pictures: film.pictures,
            }),
            Drawing::Chart(Chart {
                title: "4.9 Tips from the middle of the head".into(),
                x: "portion",
                y: "mean distance (mm)",
                log_from: None,
                curves: vec![Curve { name: "tips".into(), points: distances }],
            }),
        ],
        checks: vec![
            check(
                "distance of the tips from the middle of the head over that before",
                after / before,
                "",
                Criterion::AtLeast(1.05),
                "the hair stands off",
            ),
            check(
                "largest electric force on a hair over its weight",
                strongest,
                "",
                Criterion::Told,
                "not told",
            ),
            check(
                "portions that did not come to rest",
                unsettled as f64,
                "",
                Criterion::AtMost(0.0),
                "not told",
            ),
        ],
    })
}

/// Gives the scene so many hairs, and such charges that they are lifted as they were.
fn resize(half: &mut Scene, count: usize) -> Fallible<()> {
    let bundle = half.fibers.first_mut().ok_or("the half head has no hair")?;
    let Arrangement::Scalp { count: before, .. } = &mut bundle.arrangement else {
        return Err("the hair of the half head is not on a scalp".into());
    };
    // A force on a hair grows with its charge and with that of all.
    let share = (*before as f64 / count as f64).sqrt();
    *before = count;
    let Amount::StatcoulombPerCentimeter(density) = &mut bundle.charge.amount else {
        return Err("the hair of the half head has no charge along its length".into());
    };
    *density *= share;
    Ok(())
}

/// Mean distance of the tips from the middle of the head, which is the origin, m.
fn distance(world: &World) -> f64 {
    let count = world.assembly().fibers().len();
    (0..count).map(|i| world.node(i, None).0.coords.norm()).sum::<f64>() / count as f64
}
