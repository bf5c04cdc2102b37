use nalgebra::Vector3;

/// Positive nodes on `[-1, 1]` and their weights, of Gauss-Legendre quadrature with eight points
/// (Abramowitz and Stegun, table 25.4).
const HALF: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_27),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// The integral of `f` over `[from, to]`; its error is that of degree 16 in the length.
pub(crate) fn gauss(from: f64, to: f64, f: impl Fn(f64) -> Vector3<f64>) -> Vector3<f64> {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let mut sum = Vector3::zeros();
    for (x, weight) in HALF {
        sum += (f(middle - half * x) + f(middle + half * x)) * (weight * half);
    }
    sum
}
