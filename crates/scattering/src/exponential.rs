use nalgebra::Vector3;
use std::f64::consts::{LN_2, LOG2_E};

/// `exp(x)` of numbers at most 1, to 5e-16 of its value; what is below -600 is taken as -600, so
/// that products do not underflow. Without a call or a branch, so that numbers are taken together.
#[inline(always)]
pub(crate) fn exponentials<const N: usize>(x: [f64; N]) -> [f64; N] {
    // 1 / k! from k = 13 down.
    const TAYLOR: [f64; 14] = {
        let mut terms = [1.0; 14];
        let mut k = 1;
        while k < 14 {
            terms[k] = terms[k - 1] / k as f64;
            k += 1;
        }
        terms
    };
    const LEAST: f64 = -600.0;
    /// Added to a number, this leaves its whole part in the lowest bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // The upper bits of ln 2, by which a product with a whole number is exact, and the rest.
    const HIGH: f64 = 0.693_147_180_369_123_8;
    const LOW: f64 = 1.908_214_929_270_587_7e-10;
    const { assert!(HIGH - LN_2 + LOW < 1e-16 && LN_2 - HIGH - LOW < 1e-16) };
    let mut all = [0.0; N];
    for (found, x) in all.iter_mut().zip(x) {
        // Not `max`, which would lose what is no number.
        let clamped = if LEAST > x { LEAST } else { x };
        let shifted = clamped * LOG2_E + ROUND;
        let whole = shifted - ROUND;
        let r = clamped - whole * HIGH - whole * LOW;
        let [c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12, c13] = TAYLOR;
        let (r2, r4) = (r * r, (r * r) * (r * r));
        let a = (c0 + c1 * r) + (c2 + c3 * r) * r2;
        let b = (c4 + c5 * r) + (c6 + c7 * r) * r2;
        let c = (c8 + c9 * r) + (c10 + c11 * r) * r2;
        let sum = a + r4 * (b + r4 * (c + r4 * (c12 + c13 * r)));
        let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
        *found = sum * power;
    }
    all
}

/// What a path of the length `l` radii transmits (thesis (6.9)).
pub(crate) fn transmitted(sigma: &Vector3<f64>, l: f64) -> Vector3<f64> {
    if *sigma == Vector3::zeros() {
        return Vector3::repeat(1.0);
    }
    // Four are as quick as three.
    let [r, g, b, _] = exponentials([-sigma.x * l, -sigma.y * l, -sigma.z * l, 0.0]);
    Vector3::new(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_exponentials() {
        for k in 0..=60_100_u32 {
            let x = 1.0 - f64::from(k) / 100.0;
            let [found] = exponentials([x]);
            let whole = x.exp();
            assert!((found - whole).abs() <= 5e-16 * whole, "{x}: {found} {whole}");
        }
        assert_eq!(exponentials([0.0])[0], 1.0);
        assert!(exponentials([f64::NEG_INFINITY])[0] < 1e-260);
        assert!(exponentials([f64::NAN])[0].is_nan());
    }
}
