//! How fast an end may move and turn: what is faster is a jump.

use super::check::Check;
use nalgebra::Vector3;

/// Largest speed of an end, m/s; beyond it is a typing error or a jump.
const FASTEST: f64 = 100.0;
/// Largest angular speed of an end, degrees/s: a thousand turns per second.
const FASTEST_TURN: f64 = 3.6e5;

/// Reports a velocity (m/s) that is not finite or that is a jump.
pub(crate) fn check_velocity(check: &mut Check, velocity: &[f64; 3]) {
    check.vector("velocity", velocity, "m/s");
    if velocity.iter().all(|x| x.is_finite()) {
        check_speed(check, "velocity", Vector3::from(*velocity).norm());
    }
}

/// Reports a field that moves an end at more than the largest speed, m/s.
pub(crate) fn check_speed(check: &mut Check, field: &str, speed: f64) {
    if speed > FASTEST {
        let message =
            format!("moves the end at {speed:?} m/s: a jump; at most {FASTEST} m/s are allowed");
        check.refuse(field, message);
    }
}

/// Reports a field that turns an end at more than the largest rate, degrees/s.
pub(crate) fn check_rate(check: &mut Check, field: &str, rate: f64) {
    if rate > FASTEST_TURN {
        let message = format!(
            "turns the end at {rate:?} degrees/s: a jump; at most {FASTEST_TURN} are allowed"
        );
        check.refuse(field, message);
    }
}
