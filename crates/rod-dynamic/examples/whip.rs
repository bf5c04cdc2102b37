//! A hair released from the horizontal: cost, iterations, halvings and energy over a minute.
//!
//! `cargo run --release -p rapunzel-rod-dynamic --example whip -- [planar|curly] [dt s] [time s]
//! [fibers] [rho_inf]`
#![expect(clippy::print_stdout, clippy::cast_possible_truncation, reason = "a program of its own")]
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Conditions, Instant, Rod, RodIntegrator, RodStepReport, Staggered, StaggeredBatch, Steady,
};
use std::f64::consts::FRAC_PI_2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let number = |i: usize, default: f64| arguments.get(i).map_or(Ok(default), |a| a.parse());
    let curly = arguments.get(1).is_some_and(|a| a == "curly");
    let (dt, duration) = (number(2, 0.01)?, number(3, 10.0)?);
    let (fibers, rho_inf) = (number(4, 1.0)? as usize, number(5, StaggeredBatch::DEFAULT_RHO_INF)?);

    let length = 0.3;
    let kappa = if curly { Vector3::new(0.0, 4.0, 12.0) / length } else { Vector3::zeros() };
    let root = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
    let pose = Isometry3::from_parts(Translation3::identity(), root);
    let fiber = Fiber::uniform(length, 100, Section::Circle { radius: 35e-6 }, &Material::HAIR)?
        .with_root(pose);
    let straight = Staggered::new(Rod::new(fiber.clone()))?.state();
    let rod = Rod::new(fiber.with_natural_curvature(|_| kappa)?);
    let gravity = Vector3::new(0.0, if curly { 0.2 * 9.81 } else { 0.0 }, -9.81);
    let hold = Steady(Instant::clamped(pose, gravity));

    let mut batch = StaggeredBatch::new(vec![rod.clone(); fibers], rho_inf)?;
    for fiber in 0..fibers {
        batch.set_state(fiber, &straight)?;
    }
    let conditions: Vec<&dyn Conditions> = vec![&hold; fibers];
    let mut reports = vec![RodStepReport::default(); fibers];
    let unit = rod.fiber.mass() * 9.81 * length;
    let start = batch.energy(0, &gravity).total();
    let steps = (duration / dt).round() as usize;
    let (mut iterations, mut worst, mut halvings, mut highest) = (0, 0, 0, f64::MIN);
    let mut times = Vec::with_capacity(steps);
    for _ in 0..steps {
        let clock = std::time::Instant::now();
        batch.step(dt, &conditions, &mut reports)?;
        times.push(clock.elapsed().as_secs_f64());
        iterations += reports[0].iterations;
        worst = worst.max(reports[0].iterations);
        halvings += reports[0].halvings;
        highest = f64::max(highest, (batch.energy(0, &gravity).total() - start) / unit);
    }
    times.sort_by(f64::total_cmp);
    let end = (batch.energy(0, &gravity).total() - start) / unit;
    println!(
        "dt {dt} s, {fibers} fibres: {:.4} ms per fibre and step (median; {:.4} least), {:.2} \
         iterations (worst {worst}), {halvings} halvings in {steps} steps, energy {end:+.4} w L \
         (highest {highest:+.1e}), tip {:.9?}",
        1e3 * times[steps / 2] / fibers as f64,
        1e3 * times[0] / fibers as f64,
        iterations as f64 / steps as f64,
        batch.node(0, 100).0.coords.as_slice(),
    );
    Ok(())
}
