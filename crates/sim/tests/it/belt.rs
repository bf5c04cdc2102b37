//! A hair on a belt, for tests and for the chapter of validation: its scene, and its theory.

use nalgebra::Point3;
use std::f64::consts::PI;

const RADIUS: f64 = 3.5e-5;
const LENGTH: f64 = 0.01;
const SEGMENTS: u32 = 4;
const G: f64 = 9.81;
/// Coefficients at rest and in sliding.
const REST: f64 = 0.4;
const SLIDE: f64 = 0.3;

/// A hair that is pinned at its root lies on a belt that turns about that pin, and a force at its
/// tip draws it back: an oscillator of one degree of freedom, for angles as small as these. With
/// the coefficient at rest it is carried along until the force wins, with that of sliding it swings
/// back, by the period `2 D / V + (2 / w) (pi - atan(w D / V))`.
///
/// The moment of friction about the pin is known whatever the pressure along the hair: that of the
/// weight, which no other moment bears. The hair is stiff, so that it slips everywhere at once, and
/// an arc that lies flat, which cannot roll as a straight one would: 0.3 mm high, ten radii. And
/// `slip` is small against the belt's velocity, as what slips less counts as sticking.
pub(crate) struct Belt {
    /// Force on the tip, N.
    force: f64,
    /// Velocity of the belt, rad/s.
    pace: f64,
    /// Angle about which it swings, rad.
    middle: f64,
    /// Length of a step, s.
    pub(crate) dt: f64,
    /// Period, s.
    pub(crate) period: f64,
}

/// Curvature of the hair, 1/m.
const BEND: f64 = 24.0;

impl Belt {
    pub(crate) fn new() -> Self {
        // In units of the angular frequency the same as 1 g on 1 N/m and a belt of 1 cm/s.
        let frequency = 200.0;
        let mass = 1300.0 * PI * RADIUS * RADIUS * LENGTH;
        // Distances from the pin, and masses. Directors of the segments turn too, but a thin
        // section adds nothing.
        let lump = |a: u32| {
            let share = if a == 0 || a == SEGMENTS { 0.5 } else { 1.0 };
            let arc = LENGTH * f64::from(a) / f64::from(SEGMENTS);
            [(0.5 * BEND * arc).sin() * 2.0 / BEND, share * mass / f64::from(SEGMENTS)]
        };
        let lumps = || (0..=SEGMENTS).map(lump);
        let sum = |power: i32| lumps().map(|[x, m]| m * x.powi(power)).sum::<f64>();
        let [far, _] = lump(SEGMENTS);
        let force = frequency * frequency * sum(2) / far;
        let pressure = G * sum(1) / far;
        let swing = (REST - SLIDE) * pressure / force;
        let pace = frequency * swing / 3.1;
        let period =
            2.0 * swing / pace + 2.0 / frequency * (PI - (frequency * swing / pace).atan());
        Self { force, pace, middle: SLIDE * pressure / force, dt: 1e-3 / frequency, period }
    }

    /// The scene; the hair leaves its pin by an angle `aside` beside the force, rad.
    pub(crate) fn scene(&self, aside: f64) -> String {
        let Self { force, pace, dt, .. } = self;
        format!(
            "(format: 1, duration: 10.0, fibers: [(
                length: {LENGTH:?}, segments: {SEGMENTS}, section: Circle(radius: {RADIUS:?}),
                shape: Curved(curvature: (-{BEND:?}, 0, 0)),
                material: Elastic(density: 1300.0, youngs_modulus: 3.8e13, shear_modulus: 1.3e13),
                root: (position: (0, 0, {RADIUS:?}),
                    orientation: Along(direction: ({:?}, {:?}, 0))),
                root_joint: Ball(), tip: Loaded(force: (value: ({force:?}, 0.0, 0.0))),
            )],
            objects: [(shape: Plane(normal: (0, 0, 1)),
                motion: Rotate(axis: (0, 0, 1), rate: {:?}, until: 10.0))],
            contact: (friction: Resting(resting: {REST:?}, sliding: {SLIDE:?}),
                slip: {:?}, residual: 1e-5, depth: 5e-3),
            environment: (gravity: (0.0, 0.0, -{G:?})), stepper: (dt: {dt:?}))",
            aside.cos(),
            -aside.sin(),
            pace.to_degrees(),
            1e-4 * pace * LENGTH
        )
    }

    /// When the hair is carried through the middle of what it swings about, s, in somewhat more
    /// than two periods; `next` takes a step and tells the tip, `seen` hears of times, s, and
    /// angles.
    pub(crate) fn crossings<E>(
        &self,
        mut next: impl FnMut() -> Result<Point3<f64>, E>,
        mut seen: impl FnMut(f64, f64),
    ) -> Result<Vec<f64>, E> {
        let (mut step, mut before, mut times) = (0_u32, 0.0, Vec::new());
        while f64::from(step) * self.dt < 2.7 * self.period {
            let angle = angle(&next()?);
            let part = (self.middle - before) / (angle - before);
            if before < self.middle && angle >= self.middle {
                times.push(self.dt * (f64::from(step) + part));
            }
            step += 1;
            before = angle;
            seen(self.dt * f64::from(step), angle);
        }
        Ok(times)
    }
}

/// Angle of a tip about the pin, rad: with it aside in [`Belt::scene`] the force leads straight
/// away from the pin.
pub(crate) fn angle(tip: &Point3<f64>) -> f64 {
    tip.y.atan2(tip.x)
}
