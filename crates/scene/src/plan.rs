use crate::Scene;

/// The times at which a run steps, records and writes frames: whole numbers of intervals of a clock
/// that ticks with the frames, and the end of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// The time step, s: the largest not above the scene's of which the frame interval is a
    /// multiple.
    pub dt: f64,
    /// Number of steps of the whole run.
    pub steps: u64,
    /// Number of steps between frames.
    pub steps_per_frame: u64,
    /// Number of steps between rows of the tables.
    pub steps_per_record: u64,
    /// Frames in a second of the run, 1/s.
    pub frame_rate: f64,
    /// Time at which the run ends, s.
    pub duration: f64,
    /// Number of whole frame intervals.
    intervals: u64,
    /// Size of the steps after the last whole interval, s: the largest not above the scene's of
    /// which the rest of the duration is a multiple.
    last_dt: f64,
}

/// Fraction of a step below which a rest of the duration is no step of its own.
const REST: f64 = 1e-6;

impl Plan {
    /// The plan of a scene; for a scene that was not validated it may have no end.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        // With charge every step is a frame.
        let (interval, frame_rate) = match scene.charging {
            Some(_) => (scene.stepper.dt, 1.0 / scene.stepper.dt),
            None => (1.0 / scene.output.frame_rate, scene.output.frame_rate),
        };
        let steps_per_frame = up(interval / scene.stepper.dt);
        let dt = interval / steps_per_frame as f64;
        let steps_per_record = up((scene.output.record_interval / dt).round());
        let duration = scene.duration;
        let intervals = down(duration * frame_rate + REST / steps_per_frame as f64);
        let rest = duration - intervals as f64 / frame_rate;
        let rest_steps =
            if intervals == 0 || rest > REST * dt { up(rest / scene.stepper.dt) } else { 0 };
        let steps = intervals.saturating_mul(steps_per_frame).saturating_add(rest_steps);
        let last_dt = rest / rest_steps.max(1) as f64;
        Self {
            dt,
            steps,
            steps_per_frame,
            steps_per_record,
            frame_rate,
            duration,
            intervals,
            last_dt,
        }
    }

    /// Number of frames, including those at the start and the end.
    #[must_use]
    pub fn frames(&self) -> u64 {
        1 + self.frames_after(self.steps)
    }

    /// Number of frames after the first one when `steps` steps have been taken.
    #[must_use]
    pub fn frames_after(&self, steps: u64) -> u64 {
        if steps == self.steps {
            steps.div_ceil(self.steps_per_frame)
        } else {
            steps / self.steps_per_frame
        }
    }

    /// Whether there is a frame when `steps` steps have been taken.
    #[must_use]
    pub fn is_frame(&self, steps: u64) -> bool {
        steps.is_multiple_of(self.steps_per_frame) || steps == self.steps
    }

    /// Whether the tables have a row when `steps` steps have been taken.
    #[must_use]
    pub fn is_record(&self, steps: u64) -> bool {
        steps.is_multiple_of(self.steps_per_record) || steps == self.steps
    }

    /// Time of frame `index`, s.
    #[must_use]
    pub fn frame_time(&self, index: u64) -> f64 {
        (index as f64 / self.frame_rate).min(self.duration)
    }

    /// Size of the step that follows `steps` steps, s.
    #[must_use]
    pub fn step_after(&self, steps: u64) -> f64 {
        if steps < self.intervals * self.steps_per_frame { self.dt } else { self.last_dt }
    }
}

/// Smallest integer from 1 on that is not below `x`, up to rounding errors.
fn up(x: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, reason = "a validated scene has fewer than 2^53")]
    let integer = (x * (1.0 - 1e-12)).ceil().max(1.0) as u64;
    integer
}

/// Largest integer that is not above `x`, up to rounding errors.
fn down(x: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, reason = "a validated scene has fewer than 2^53")]
    let integer = (x * (1.0 + 1e-12)) as u64;
    integer
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plan(dt: f64, frame_rate: f64, duration: f64, record_interval: f64) -> Plan {
        let text = format!(
            "(format: 1, duration: {duration}, stepper: (dt: {dt}),
              output: (frame_rate: {frame_rate}, record_interval: {record_interval}),
              fibers: [(length: 0.1, segments: 10, section: Circle(radius: 4e-5))])"
        );
        Plan::new(&Scene::from_ron(&text).expect("a valid scene"))
    }

    #[test]
    fn frames_fall_on_steps() {
        let even = plan(0.001, 25.0, 2.0, 0.01);
        assert_eq!((even.steps_per_frame, even.steps, even.steps_per_record), (40, 2000, 10));
        assert_eq!((even.dt, even.frames()), (0.001, 51));
        let odd = plan(0.001, 30.0, 5.0, 0.0);
        assert_eq!((odd.steps_per_frame, odd.steps, odd.steps_per_record), (34, 5100, 1));
        assert_eq!(odd.frames(), 151);
        // The step of the thesis, as long as the frame.
        assert_eq!(plan(1.0 / 30.0, 30.0, 1.0, 0.0).steps, 30);
        // A step longer than the frame interval is cut to it.
        assert_eq!(plan(0.1, 30.0, 1.0, 0.0).steps_per_frame, 1);
    }

    #[test]
    fn the_last_frame_is_the_end() {
        let short = plan(0.001, 30.0, 0.01, 0.0);
        assert_eq!((short.steps, short.frames()), (10, 2));
        assert_eq!((short.step_after(0), short.frame_time(1)), (0.001, 0.01));
        // A duration cut after six digits is as good as the third of a second that was meant.
        assert_eq!(plan(0.001, 3.0, 0.333333, 0.0).frames(), 2);
    }

    proptest! {
        #[test]
        fn steps_add_up_to_the_duration(
            dt in 1e-5_f64..0.1,
            frame_rate in prop_oneof![1e-1_f64..1e3, Just(24.0), Just(29.97), Just(30.0)],
            duration in prop_oneof![1e-9_f64..2.0, Just(1.0 / 3.0), Just(0.1 + 0.2)],
        ) {
            let plan = plan(dt, frame_rate, duration, 0.0);
            let (mut time, mut frames) = (0.0, vec![0.0]);
            for step in 0..plan.steps {
                let length = plan.step_after(step);
                prop_assert!(length > 0.0 && length <= dt * (1.0 + 1e-9), "{length}");
                time += length;
                if plan.is_frame(step + 1) {
                    frames.push(time);
                    prop_assert_eq!(plan.frames_after(step + 1), frames.len() as u64 - 1);
                }
            }
            // What sums of so many steps round, and the rest that is no step.
            let bound = REST * dt + 1e-16 * (plan.steps as f64 + 10.0) * duration;
            prop_assert!((time - duration).abs() <= bound, "{time} of {duration}");
            prop_assert_eq!(frames.len() as u64, plan.frames());
            for (index, time) in frames.iter().enumerate() {
                prop_assert!((plan.frame_time(index as u64) - time).abs() <= bound);
            }
        }
    }
}
