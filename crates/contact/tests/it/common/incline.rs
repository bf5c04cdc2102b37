//! What steps of time make of a block that stops or turns on an incline.

/// How far a block may be off where its motion is exact in every step but the one in which its slip
/// ends: downhill velocities and ways, m/s and m.
///
/// Let it slow down at `a` and, where it does not stick, go on at `b` the other way. In the step in
/// which the slip ends after a time `c` of it, the law sees the whole step's gravity and friction
/// and leaves the velocity `max(0, b dt - a c)`; right is `b (dt - c)`. That lags by at most `dt b
/// (a - b) / a`, where `a c = b dt`, and never leads; from then on the way lags by that much more
/// every second. The step's own way, by the trapezoidal rule, lags by at most `a dt^2 / 2` where
/// the block turns. Where it sticks it goes too far by `a c (dt - c) / 2`, at most `a dt^2 / 8`,
/// once and for all.
pub(crate) struct EndOfSlip {
    /// Slowing down, and speeding up afterwards, m/s^2.
    slows: f64,
    starts: f64,
    /// When the slip ends, s.
    at: f64,
    dt: f64,
}

impl EndOfSlip {
    /// For a block that starts with `v0`, m/s downhill, on a plane inclined by `alpha`, rad.
    pub(crate) fn new(alpha: f64, mu: f64, g: f64, v0: f64, dt: f64) -> Self {
        let (drive, limit) = (g * alpha.sin(), mu * g * alpha.cos());
        let slows = if v0 > 0.0 { limit - drive } else { limit + drive };
        let ends = v0 != 0.0 && slows > 0.0;
        let at = if ends { v0.abs() / slows } else { f64::INFINITY };
        Self { slows, starts: (drive - limit).max(0.0), at, dt }
    }

    /// Least and most that the velocity lags at time `t`.
    pub(crate) fn velocity(&self, t: f64) -> [f64; 2] {
        let most = self.dt * self.starts * (self.slows - self.starts) / self.slows;
        [0.0, if t > self.at { most } else { 0.0 }]
    }

    /// Least and most that the way lags at time `t`.
    pub(crate) fn way(&self, t: f64) -> [f64; 2] {
        let step = self.slows * self.dt * self.dt;
        match (t > self.at, self.starts > 0.0) {
            (false, _) => [0.0; 2],
            (true, true) => [0.0, 0.5 * step + self.velocity(t)[1] * (t - self.at)],
            (true, false) => [-0.125 * step, 0.125 * step],
        }
    }
}

/// Whether `lag` is between the bounds, but for rounding.
pub(crate) fn within(lag: f64, [least, most]: [f64; 2]) -> bool {
    (least - 1e-11..=most + 1e-11).contains(&lag)
}
