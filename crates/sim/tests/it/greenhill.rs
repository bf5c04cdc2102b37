//! When a rod between clamps that is twisted under tension leaves its axis (Greenhill 1883), for
//! tests and for the chapter of validation.

/// What vanishes where a rod with `B = L = 1` writhes, of `a = M / 2` and `b^2 = a^2 - T` with the
/// twisting moment `M` and the tension `T`.
///
/// Beside the straight line there are `exp(i k s)` with `k = a + b` and `a - b`, and a straight
/// line that is tilted; with `x = k / 2` both clamps ask for `(sin x - x cos x) y sin y = (sin y -
/// y cos y) x sin x`. Without tension it is `tan x = x`, without moment Euler's load of clamped
/// ends; of long rods it is `M^2 = 4 T`.
pub(crate) fn clamps(a: f64, b: f64) -> f64 {
    let [x, y] = [0.5 * (a + b), 0.5 * (a - b)];
    let bent = |x: f64| x.sin() - x * x.cos();
    // Of equal roots it vanishes always.
    (bent(x) * y * y.sin() - bent(y) * x * x.sin()) / b
}
