//! Rolling resistance: where sides roll over each other, they are pressed ahead of where they
//! touch.
//!
//! The normal force acts aside by a lean `d` across the normal, at most the length `rolling
//! resistance`, and so has the moment `d x n` times itself on the one side and its opposite on the
//! other: what resists a relative angular velocity `omega` leans by `-n x omega`. How far, a
//! controller finds from step to step. From a lean that has been, it goes on by what would have
//! stopped the sides, `-(omega + change of omega)` times the least inertia, so that what rests on
//! a slope rests in the end, and what rolls on leans as far as it may from the second step on.

use super::ContactProblem;
use crate::TimeInterval;
use crate::body_ref::BodyRef;
use crate::contact::node_arrays::FiberVelocities;
use crate::contact::system::CoupledSystem;
use crate::contact::velocities::Velocities;
use crate::contact_point::ContactPoint;
use nalgebra::Vector3;
use rapunzel_rod_dynamic::StepVelocity;

/// How far from each other, in segments, contacts of a pair lean alike.
const BESIDE: f64 = 2.0;

impl ContactProblem {
    /// Lets contacts lean for the next step, by at most `length`, m, after one in which all fibres
    /// have had the given mean velocities.
    pub(crate) fn lean(
        &mut self,
        system: &CoupledSystem,
        mean: &FiberVelocities,
        step: TimeInterval,
        length: f64,
    ) {
        let start = self.velocities(system, StepVelocity::Start);
        let (start, mean) = (Velocities::before(system, &start), Velocities::new(system, mean));
        let led: Vec<_> = system.objects.iter().map(|object| object.led_spin(step)).collect();
        let bearing: Vec<usize> = self
            .working
            .iter()
            .copied()
            .filter(|&i| i < self.listed && self.impulses[i].x > 0.0)
            .collect();
        let fibers = system.fibers.assembly().fibers().len();
        let number = |side: BodyRef| match side {
            BodyRef::Fiber(fiber) => fiber as usize,
            BodyRef::Object(object) => fibers + object as usize,
        };
        // All contacts of a body turn it.
        let mut sharing = vec![0.0_f64; fibers + led.len()];
        for &i in &bearing {
            self.points[i].sides.into_iter().for_each(|side| sharing[number(side)] += 1.0);
        }
        let mut leans: Vec<Vector3<f64>> = Vec::with_capacity(bearing.len());
        for (k, &i) in bearing.iter().enumerate() {
            let point = &self.points[i];
            let led = match point.sides[1] {
                BodyRef::Object(object) => led[object as usize],
                BodyRef::Fiber(_) => Vector3::zeros(),
            };
            let of = |velocities: &Velocities| {
                velocities.spin_of_side(point, 0) - velocities.spin_of_side(point, 1) - led
            };
            let turning = 2.0 * of(&mean) - of(&start);
            let shares = (0..2).filter(|&side| point.moves(side));
            let shares = shares.map(|side| sharing[number(point.sides[side])]).fold(1.0, f64::max);
            // The rotation about an axis answers a moment by no more than the surface a force,
            // over the square of the lever.
            let inertia = self.masses[i].own * least_lever(point).powi(2);
            let aside = point.normal.cross(&turning) * (inertia / (shares * self.impulses[i].x));
            // Where neighbours lean alike it does not matter which of them bears how much.
            let beside = |k: Option<usize>| {
                let other = k.and_then(|k| bearing.get(k)).map(|&j| &self.points[j]);
                let other =
                    other.filter(|o| o.sides == point.sides && o.apart(point.at()) < BESIDE);
                other.map_or(point.lean, |other| other.lean)
            };
            let both = beside(k.checked_sub(1)) + beside(Some(k + 1));
            let lean = 0.5 * point.lean + 0.25 * both - aside;
            let lean = lean - point.normal * point.normal.dot(&lean);
            leans.push(lean.cap_magnitude(length));
        }
        bearing.into_iter().zip(leans).for_each(|(i, lean)| self.points[i].lean = lean);
    }
}

/// Shorter lever of the sides that move, m; zero where one has none.
fn least_lever(point: &ContactPoint) -> f64 {
    let levers = (0..2).filter(|&side| point.moves(side));
    let levers = levers.map(|side| (point.lever(side) - point.lean).norm());
    levers.reduce(f64::min).unwrap_or(0.0)
}
