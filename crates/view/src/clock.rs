//! How simulated time follows that of the clock on the wall.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// More than so much behind, the time that was lost is not made up for, s.
const MAKE_UP: f64 = 0.1;
/// Over so long the speed is measured.
const WINDOW: Duration = Duration::from_secs(1);

/// Simulated time as it should be.
#[derive(Debug)]
pub(crate) struct WallPace {
    /// Simulated seconds for each second.
    speed: f64,
    /// An instant, and the simulated time then, s; none while all stands still.
    anchor: Option<(Instant, f64)>,
    /// Simulated seconds that were given up, since the start.
    lost: f64,
    /// Instants and simulated times, of the last second.
    past: VecDeque<(Instant, f64)>,
}

impl WallPace {
    pub(crate) fn new() -> Self {
        Self { speed: 1.0, anchor: None, lost: 0.0, past: VecDeque::new() }
    }

    pub(crate) fn speed(&self) -> f64 {
        self.speed
    }

    pub(crate) fn runs(&self) -> bool {
        self.anchor.is_some()
    }

    /// Goes on from a simulated time.
    pub(crate) fn start(&mut self, now: Instant, simulated: f64) {
        if self.anchor.is_none() {
            self.anchor = Some((now, simulated));
            self.past.clear();
        }
    }

    pub(crate) fn stop(&mut self) {
        self.anchor = None;
    }

    /// Begins anew at a simulated time, running or not as before.
    pub(crate) fn reset(&mut self, now: Instant, simulated: f64) {
        self.anchor = self.anchor.map(|_| (now, simulated));
        self.lost = 0.0;
        self.past.clear();
    }

    pub(crate) fn set_speed(&mut self, speed: f64, now: Instant, simulated: f64) {
        self.speed = speed;
        self.reset(now, simulated);
    }

    /// How long to wait until time is to go on from `simulated`; none while all stands still.
    pub(crate) fn wait(&mut self, now: Instant, simulated: f64) -> Option<Duration> {
        let (start, from) = self.anchor?;
        let behind = from + (now - start).as_secs_f64() * self.speed - simulated;
        let most = MAKE_UP * self.speed;
        if behind > most {
            self.lost += behind - most;
            self.anchor = Some((now, simulated + most));
        }
        Some(Duration::from_secs_f64((-behind / self.speed).clamp(0.0, 1.0)))
    }

    /// Simulated seconds by which all is behind, since the start.
    pub(crate) fn lag(&self) -> f64 {
        self.lost
    }

    /// Simulated seconds in each second of late, if that is known.
    pub(crate) fn measured(&mut self, now: Instant, simulated: f64) -> Option<f64> {
        self.anchor?;
        self.past.push_back((now, simulated));
        while self.past.len() > 2 && self.past.front().is_some_and(|(at, _)| now - *at > WINDOW) {
            self.past.pop_front();
        }
        let (at, from) = *self.past.front()?;
        let seconds = (now - at).as_secs_f64();
        (seconds > 0.1).then(|| (simulated - from) / seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_waits_for_the_clock_and_gives_up_what_it_cannot_follow() {
        let start = Instant::now();
        let after = |seconds: f64| start + Duration::from_secs_f64(seconds);
        let mut pace = WallPace::new();
        assert_eq!(pace.wait(start, 0.0), None);
        pace.set_speed(2.0, start, 0.0);
        pace.start(start, 0.0);
        // A second of the clock is two of the simulation: half of one is ahead by a quarter.
        let wait = pace.wait(after(0.0), 0.5).expect("it runs");
        assert!((wait.as_secs_f64() - 0.25).abs() < 1e-9, "{wait:?}");
        assert_eq!(pace.wait(after(0.25), 0.4), Some(Duration::ZERO));
        assert_eq!(pace.lag(), 0.0);
        // Two seconds later only one was simulated: all but what can be made up for is lost.
        assert_eq!(pace.wait(after(1.0), 1.0), Some(Duration::ZERO));
        assert!((pace.lag() - 0.8).abs() < 1e-9, "{}", pace.lag());
        pace.stop();
        assert!(!pace.runs());
        assert_eq!(pace.wait(after(2.0), 1.0), None);
    }

    #[test]
    fn speed_is_that_of_the_last_second() {
        let start = Instant::now();
        let mut pace = WallPace::new();
        pace.start(start, 0.0);
        let mut last = None;
        for tick in 0..40 {
            let seconds = f64::from(tick) * 0.1;
            // Half as fast as the clock, and from 2 s on a tenth.
            let simulated = if seconds < 2.0 { 0.5 * seconds } else { 1.0 + 0.1 * (seconds - 2.0) };
            last = pace.measured(start + Duration::from_secs_f64(seconds), simulated);
        }
        assert!((last.expect("a speed") - 0.1).abs() < 1e-6, "{last:?}");
    }
}
