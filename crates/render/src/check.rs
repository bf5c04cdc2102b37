use crate::RenderError;
use nalgebra::{Point3, Vector3};

/// Refuses `value` unless it is `allowed`, which is false for NaN.
pub(crate) fn check(
    what: &'static str,
    value: f64,
    must: &'static str,
    allowed: bool,
) -> Result<(), RenderError> {
    if allowed { Ok(()) } else { Err(RenderError::Parameter { what, value, must }) }
}

/// Refuses a number that is not positive and finite.
pub(crate) fn check_positive(what: &'static str, value: f64) -> Result<(), RenderError> {
    check(what, value, "above zero and finite", value > 0.0 && value.is_finite())
}

/// Refuses a point with a coordinate that is not finite.
pub(crate) fn check_point(what: &'static str, point: &Point3<f64>) -> Result<(), RenderError> {
    point.iter().try_for_each(|x| check(what, *x, "finite", x.is_finite()))
}

/// Refuses light that is negative or not finite in a color.
pub(crate) fn check_light(what: &'static str, light: &Vector3<f64>) -> Result<(), RenderError> {
    let allowed = |x: &f64| *x >= 0.0 && x.is_finite();
    light.iter().try_for_each(|x| check(what, *x, "finite and not negative", allowed(x)))
}

/// The unit vector along a direction of any length; refuses one without a direction.
pub(crate) fn unit(
    what: &'static str,
    direction: &Vector3<f64>,
) -> Result<Vector3<f64>, RenderError> {
    // Squares of very large or small components would overflow or vanish.
    let largest = direction.amax();
    check_positive(what, if direction.iter().any(|x| x.is_nan()) { f64::NAN } else { largest })?;
    Ok((direction / largest).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_of_all_lengths_have_a_unit_vector() {
        for length in [1e-308, 1.0, 1e307] {
            let unit = unit("it", &(Vector3::new(3.0, 0.0, 4.0) * length)).expect("a direction");
            assert!((unit - Vector3::new(0.6, 0.0, 0.8)).norm() < 1e-15, "{length}");
        }
        for none in [[0.0, 0.0, 0.0], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
            assert!(unit("it", &none.into()).is_err(), "{none:?}");
        }
    }
}
