use crate::Scene;

/// When a run steps, records and shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// The time step, s: the largest not above the scene's of which the frame interval is a
    /// multiple.
    pub dt: f64,
    /// Number of steps of the whole run; it ends at the scene's duration or up to a step after.
    pub steps: u64,
    /// Steps from frame to frame.
    pub steps_per_frame: u64,
    /// Steps from row to row of the tables.
    pub steps_per_record: u64,
}

impl Plan {
    /// The plan of a valid scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        // With charge every step is a frame.
        let interval = match scene.charging {
            Some(_) => scene.stepper.dt,
            None => 1.0 / scene.output.frame_rate,
        };
        let steps_per_frame = up(interval / scene.stepper.dt);
        let dt = interval / steps_per_frame as f64;
        let steps_per_record = up((scene.output.record_interval / dt).round());
        Self { dt, steps: up(scene.duration / dt), steps_per_frame, steps_per_record }
    }

    /// Number of frames, with that of the start.
    #[must_use]
    pub fn frames(&self) -> u64 {
        1 + self.steps / self.steps_per_frame
    }
}

/// The next integer from 1 on, where rounding errors do not count as more.
fn up(x: f64) -> u64 {
    #[expect(clippy::cast_possible_truncation, reason = "a validated scene has fewer than 2^53")]
    let integer = (x * (1.0 - 1e-12)).ceil().max(1.0) as u64;
    integer
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
