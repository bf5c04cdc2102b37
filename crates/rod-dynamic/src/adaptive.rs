//! Adaptive step size for any integrator, controlled by the estimated position error.

use crate::{Conditions, RodIntegrator, StepError};
use nalgebra::Point3;

/// Smallest step size, as a fraction of the duration.
const SMALLEST: f64 = 1.0 / 1_048_576.0;
/// Safety factor on the step size that the error estimate suggests.
const SAFETY: f64 = 0.8;
/// Largest factor by which the step size may grow or shrink from one step to the next.
const GROWTH: f64 = 4.0;

/// Statistics of an adaptive advance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AdaptiveReport {
    /// Steps accepted, each made of two halves.
    pub steps: usize,
    /// Steps rejected, for their error or because Newton's method failed.
    pub rejected: usize,
    /// Steps accepted at the smallest size although their error was too large.
    pub missed: usize,
    /// Newton iterations, over all attempts.
    pub iterations: usize,
    /// Halvings inside the integrator, over all attempts.
    pub halvings: usize,
    /// Sum of the estimated errors of the steps, m: an estimate of the error at the end where
    /// neighbouring motions do not diverge.
    pub error: f64,
    /// Shortest step accepted, s.
    pub shortest: f64,
}

/// Advances `integrator` by `duration` (s) in steps chosen so that the estimated errors of all node
/// positions add up to at most `tolerance` (m).
///
/// Every step is done once whole and once in two halves; for a method of second order a third of
/// the largest distance between the two results estimates the error of the halves (Richardson),
/// which are kept. A step may err by its share of `tolerance` in time. The smallest step is
/// 2^-20 of `duration`; those that miss their share even then are counted in the report.
/// Costs three times the integrator's steps.
///
/// # Errors
/// [`StepError::TimeStep`] unless `duration` is positive and finite, [`StepError::Conditions`]
/// unless `tolerance` is, and the integrator's own error where its smallest step fails. The rod
/// is then as before.
pub fn advance(
    integrator: &mut dyn RodIntegrator,
    duration: f64,
    tolerance: f64,
    conditions: &dyn Conditions,
) -> Result<AdaptiveReport, StepError> {
    let time = integrator.time();
    if !(duration > 0.0 && duration.is_finite()) {
        return Err(StepError::TimeStep(duration));
    }
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        let why = "must be positive and finite (m)";
        return Err(StepError::Conditions { fiber: 0, what: "tolerance", time, why });
    }
    let mut before = Vec::new();
    integrator.save(&mut before);
    let result = run(integrator, duration, tolerance, conditions);
    if result.is_err() {
        integrator.restore(&before).expect("numbers that this integrator has just saved");
    }
    result
}

fn run(
    integrator: &mut dyn RodIntegrator,
    duration: f64,
    tolerance: f64,
    conditions: &dyn Conditions,
) -> Result<AdaptiveReport, StepError> {
    let end = integrator.time() + duration;
    let mut report = AdaptiveReport { shortest: duration, ..AdaptiveReport::default() };
    let mut start = Vec::new();
    let mut dt = duration / 16.0;
    loop {
        let left = end - integrator.time();
        if left <= 1e-12 * duration {
            return Ok(report);
        }
        // No sliver is left for a last step.
        dt = if dt >= left { left } else { dt.min(0.5 * left) };
        start.clear();
        integrator.save(&mut start);
        let smallest = dt <= duration * SMALLEST;
        let allowed = tolerance * dt / duration;
        let attempt = double(integrator, dt, conditions, &start, &mut report);
        let growth = match attempt {
            Ok(error) if error <= allowed || smallest => {
                report.steps += 1;
                report.missed += usize::from(error > allowed);
                report.error += error;
                report.shortest = report.shortest.min(dt);
                SAFETY * (allowed / error.max(f64::MIN_POSITIVE)).sqrt()
            }
            Err(error) if smallest => return Err(error),
            rejected => {
                integrator.restore(&start).expect("numbers that this integrator has just saved");
                report.rejected += 1;
                rejected.map_or(0.5, |error| (SAFETY * (allowed / error).sqrt()).min(0.5))
            }
        };
        dt = (dt * growth.clamp(1.0 / GROWTH, GROWTH)).max(duration * SMALLEST);
    }
}

/// Takes one whole step and, from the same start, two half steps, whose result is kept. Returns the
/// estimated error, m.
fn double(
    integrator: &mut dyn RodIntegrator,
    dt: f64,
    conditions: &dyn Conditions,
    start: &[f64],
    report: &mut AdaptiveReport,
) -> Result<f64, StepError> {
    let mut step = |integrator: &mut dyn RodIntegrator, dt: f64| {
        let step = integrator.step(dt, conditions)?;
        report.iterations += step.iterations;
        report.halvings += step.halvings;
        Ok(())
    };
    step(integrator, dt)?;
    let whole = integrator.state().positions;
    integrator.restore(start).expect("numbers that this integrator has just saved");
    step(integrator, 0.5 * dt)?;
    step(integrator, 0.5 * dt)?;
    Ok(distance(&whole, &integrator.state().positions) / 3.0)
}

fn distance(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}
