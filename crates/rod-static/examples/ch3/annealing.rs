//! The thesis's search for boundary values: four parameters of the closed form, found by simulated
//! annealing (3.119-3.123).

use nalgebra::{Point3, Rotation3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use rapunzel_rod_static::{Lagrange, State, StaticError};

/// Ratio of torsion to bending stiffness.
pub(crate) const TORSION: f64 = 0.75;
/// Length of the rod, in the unit of the parameters.
pub(crate) const LENGTH: f64 = 2.5;
/// Angle of the clamp's tangent to the force, which the thesis takes along z.
const ANGLE: f64 = 1.0;
/// The parameters that make the thesis's target: n, m3, mz, theta'.
pub(crate) const TARGET: [f64; 4] = [1.0, 2.0, 1.1, 1.0];
/// Cycles, and iterations in each.
pub(crate) const CYCLES: u32 = 1500;
const ITERATIONS: u32 = 100;
/// Width of a step at the temperature one, and the temperatures of the first and last cycle.
const STEP: f64 = 0.5;
const HOT: f64 = 1.0;
const COLD: f64 = 1e-8;

/// The frame of the clamp.
pub(crate) fn clamp() -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::y_axis(), ANGLE)
}

/// The end of the rod with the given parameters.
pub(crate) fn end([n, m3, mz, bend]: [f64; 4]) -> Result<State, StaticError> {
    let (z, d3) = (Vector3::z(), clamp() * Vector3::z());
    let (sin, cos) = ANGLE.sin_cos();
    let along = (mz - m3 * cos) / (sin * sin);
    let moment = z * along + d3 * (m3 - along * cos) + z.cross(&d3) * (bend / sin);
    let start = State { position: Point3::origin(), frame: clamp(), force: z * n, moment };
    Ok(Lagrange::new(1.0, TORSION, 0.0, &start)?.at(LENGTH))
}

/// What a search ends with.
pub(crate) struct Found {
    pub(crate) parameters: [f64; 4],
    /// The best value after each cycle.
    pub(crate) history: Vec<f64>,
}

/// Searches for the minimum of `cost` with `n > 0` from a random perturbation of the target's own
/// parameters.
pub(crate) fn search(
    seed: u64,
    cost: impl Fn([f64; 4]) -> Result<f64, StaticError>,
) -> Result<Found, StaticError> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut unit = move || (random.next_u64() >> 11) as f64 * 2.0_f64.powi(-53);
    let mut now = TARGET.map(|x| x + 2.0 * unit() - 1.0);
    now[0] = now[0].abs();
    let mut value = cost(now)?;
    let (mut best, mut lowest) = (now, value);
    let mut history = Vec::new();
    for cycle in 0..CYCLES {
        let temperature = HOT * f64::powf(COLD / HOT, f64::from(cycle) / f64::from(CYCLES));
        for _ in 0..ITERATIONS {
            let width = STEP * temperature.sqrt();
            let mut next = now.map(|x| x + width * (2.0 * unit() - 1.0));
            next[0] = next[0].abs().max(1e-6);
            let other = cost(next)?;
            if other < value || unit() < ((value - other) / temperature).exp() {
                (now, value) = (next, other);
            }
            if value < lowest {
                (best, lowest) = (now, value);
            }
        }
        history.push(lowest);
    }
    Ok(Found { parameters: best, history })
}
