//! The metric of points: how heavy each is taken to be while contacts are solved by themselves.
//!
//! The best is near the geometric mean of what a set of impulses feels at most and at least
//! (Giselsson and Boyd 2017). The most is bounded by the sum of a row of the answers (Gershgorin),
//! which counts where a body is pressed at many points at once; the least nobody knows, and
//! `weight` stands for it.

use crate::Body;
use nalgebra::Vector3;

/// Answer of a point to all sides of its body together, in its own answers, above which it gets
/// lighter: found where hair falls and swings, and in packs that lie, slide and are pressed
/// together. Half and half as much again take more iterations in one of these or the other.
const CROWDING: f64 = 8.0;

/// About the most that all contacts together answer to impulses, in units of what each answers to
/// its own in the metric of this `weight`: a bound where what a body's points answer to each other
/// points one way.
pub(crate) fn largest_response(weight: f64) -> f64 {
    weight * CROWDING
}

/// Writes the metric, kg, of one side at each point of a body, at which there are `sides` of them,
/// and the trace of the point's own answer, 1/kg. A lone side is so many times as heavy as the
/// point itself. Tells how many points are lighter than that, as they are in a crowd.
///
/// Costs four answers of the body.
pub(crate) fn masses(
    body: &mut dyn Body,
    sides: &[usize],
    weight: f64,
    [masses, traces]: [&mut [f64]; 2],
) -> usize {
    body.own_traces(traces);
    let mut crowded = 0;
    for ((mass, trace), together) in masses.iter_mut().zip(&*traces).zip(row_sums(body, sides)) {
        let share = together / CROWDING;
        crowded += usize::from(share > *trace);
        // A point that nothing moves has no inertia to compare with.
        let answer = trace.max(share);
        *mass = weight * if answer > 0.0 { 3.0 / answer } else { 1.0 };
    }
    crowded
}

/// Traces of what each point answers where all sides are pressed alike, 1/kg: sums of rows of the
/// answers (Gershgorin).
fn row_sums(body: &mut dyn Body, sides: &[usize]) -> Vec<f64> {
    let mut asked = vec![Vector3::zeros(); sides.len()];
    let mut answers = asked.clone();
    let mut traces = vec![0.0; sides.len()];
    for k in 0..3 {
        for (asked, &count) in asked.iter_mut().zip(sides) {
            *asked = Vector3::zeros();
            asked[k] = count as f64;
        }
        body.respond(&asked, &mut answers);
        traces.iter_mut().zip(&answers).for_each(|(trace, answer)| *trace += answer[k]);
    }
    traces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ContactError;

    /// A particle of a mass, kg, with a number of points.
    struct Particle(f64, usize);

    impl Body for Particle {
        fn points(&self) -> usize {
            self.1
        }

        fn set_weights(&mut self, _: &[f64]) -> Result<(), ContactError> {
            unreachable!("nobody asks")
        }

        fn respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
            let sum: Vector3<f64> = impulses.iter().sum();
            velocities.fill(sum / self.0);
        }

        fn weighted_respond(&mut self, _: &[Vector3<f64>], _: &mut [Vector3<f64>]) {
            unreachable!("nobody asks")
        }

        fn own_traces(&mut self, traces: &mut [f64]) {
            traces.fill(3.0 / self.0);
        }
    }

    #[test]
    fn a_crowd_shares_what_few_have_each() {
        let all = |sides: &[usize], mass: f64, crowded: usize| {
            let mut found = vec![0.0; sides.len()];
            let mut traces = found.clone();
            let (mut particle, both) = (Particle(2.0, sides.len()), [&mut found[..], &mut traces]);
            assert_eq!(masses(&mut particle, sides, 8.0, both), crowded);
            assert!(found.iter().all(|found| (found - mass).abs() < 1e-12), "{found:?}");
        };
        // Points that are only kept do not count.
        all(&[1, 0, 3, 4], 16.0, 0);
        all(&[1; 32], 4.0, 32);
        all(&[16; 2], 4.0, 2);
        all(&[0; 3], 16.0, 0);
        let mut immovable = vec![0.0; 2];
        masses(&mut Particle(f64::INFINITY, 2), &[1, 1], 8.0, [&mut immovable, &mut [0.0; 2]]);
        assert_eq!(immovable, [8.0; 2]);
    }
}
