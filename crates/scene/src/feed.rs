//! Fibres that are fed through a nozzle: paid out, and taken up.

use super::check::{Allowed, Check};
use super::motion::ramped;
use serde::{Deserialize, Serialize};

/// A nozzle that the fibres of a bundle are fed through by their roots.
///
/// The mouth is where the bundle's `root` and its `motion` have it, and the fibre leaves it along
/// the direction of the root. What is inside is straight on behind the mouth, without weight, and
/// touches nothing; the fibre is clamped at the mouth. Drawn in, it is that of a winch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feed {
    /// Length of each fibre, from its root on, that is inside at the start, m.
    pub inside: f64,
    /// Speed of the feed, m/s: above zero to pay the fibre out, below to take it up. The fibre
    /// starts with it.
    #[serde(default)]
    pub rate: f64,
    /// Time in which the rate grows linearly from zero, s; 0 for at once.
    #[serde(default)]
    pub ramp: f64,
    /// Time at which the feed ends, s; left out, it goes on.
    #[serde(default)]
    pub until: Option<f64>,
    /// Lengths that have been paid out by given times, in place of `rate`, `ramp` and `until`: from
    /// nothing at the start at a constant rate from each to the next, and at rest after the last.
    #[serde(default)]
    pub lengths: Vec<FedLength>,
}

/// How much of a fibre has been paid out by a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FedLength {
    /// Time, s.
    pub time: f64,
    /// Length paid out since the start, m; below zero for what has been taken up.
    pub length: f64,
}

impl Feed {
    /// Length paid out from the start until time `t`, s, m.
    #[must_use]
    pub fn fed(&self, t: f64) -> f64 {
        let start = FedLength { time: 0.0, length: 0.0 };
        let Some(last) = self.lengths.last() else {
            return self.rate * ramped(t.min(self.until.unwrap_or(f64::INFINITY)), self.ramp);
        };
        let after = self.lengths.partition_point(|one| one.time <= t);
        let from = self.lengths[..after].last().unwrap_or(&start);
        let to = self.lengths.get(after).unwrap_or(last);
        let x = if to.time > from.time { (t - from.time) / (to.time - from.time) } else { 0.0 };
        from.length + x * (to.length - from.length)
    }

    /// Length that is inside at time `t`, s, m; zero where it is none but for rounding.
    #[must_use]
    pub fn inside(&self, t: f64) -> f64 {
        let inside = self.inside - self.fed(t);
        if inside.abs() < 1e-12 * self.inside { 0.0 } else { inside }
    }

    /// Speed at the start, m/s.
    #[must_use]
    pub fn starting_speed(&self) -> f64 {
        match self.lengths.first() {
            Some(first) if first.time > 0.0 => first.length / first.time,
            Some(_) => 0.0,
            None if self.ramp > 0.0 || self.until == Some(0.0) => 0.0,
            None => self.rate,
        }
    }

    /// Largest speed, m/s.
    pub(super) fn largest_speed(&self) -> f64 {
        let start = [FedLength { time: 0.0, length: 0.0 }];
        let all: Vec<_> = start.iter().chain(&self.lengths).collect();
        let speeds = all.windows(2).map(|two| {
            let time = two[1].time - two[0].time;
            ((two[1].length - two[0].length) / time).abs()
        });
        if self.lengths.is_empty() { self.rate.abs() } else { speeds.fold(0.0, f64::max) }
    }

    /// Reports numbers that are out of range.
    pub(super) fn check_numbers(&self, check: &mut Check) {
        check.number("inside", self.inside, Allowed::NonNegative, "m");
        check.number("rate", self.rate, Allowed::Finite, "m/s");
        check.number("ramp", self.ramp, Allowed::NonNegative, "s");
        if let Some(until) = self.until {
            check.number("until", until, Allowed::NonNegative, "s");
        }
        check.each("lengths", &self.lengths, |c, one| {
            c.number("time", one.time, Allowed::Positive, "s");
            c.number("length", one.length, Allowed::Finite, "m");
        });
        for (i, two) in self.lengths.windows(2).enumerate() {
            if two[1].time <= two[0].time {
                let message = format!(
                    "is {:?}, but must be later than {:?}, the time before (s)",
                    two[1].time, two[0].time
                );
                check.refuse(&format!("lengths[{}].time", i + 1), message);
            }
        }
        let rated = self.rate != 0.0 || self.ramp != 0.0 || self.until.is_some();
        if !self.lengths.is_empty() && rated {
            let message = "are given beside `rate`, `ramp` or `until`: leave these out, or them";
            check.refuse("lengths", message.into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_fed_at_constant_rates_between_times() {
        let lengths = vec![
            FedLength { time: 1.0, length: 0.2 },
            FedLength { time: 2.0, length: 0.2 },
            FedLength { time: 4.0, length: -0.2 },
        ];
        let feed = Feed { inside: 0.5, rate: 0.0, ramp: 0.0, until: None, lengths };
        for (t, fed) in [(0.0, 0.0), (0.5, 0.1), (1.5, 0.2), (3.0, 0.0), (4.0, -0.2), (9.0, -0.2)] {
            assert!((feed.fed(t) - fed).abs() < 1e-15, "{t}: {}", feed.fed(t));
        }
        assert!((feed.largest_speed() - 0.2).abs() < 1e-15);
        assert!((feed.starting_speed() - 0.2).abs() < 1e-15);
        let feed = Feed { rate: 0.1, ramp: 1.0, until: Some(3.0), lengths: Vec::new(), ..feed };
        assert!((feed.fed(9.0) - 0.25).abs() < 1e-15 && feed.starting_speed() == 0.0);
    }
}
