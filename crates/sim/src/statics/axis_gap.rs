//! The distance of two straight axes as a function of their ends.

use nalgebra::{Matrix2, SMatrix, SVector, Vector3};
use rapunzel_collision::Capsule;

/// Part of the product of two squared lengths below which axes count as parallel.
const PARALLEL: f64 = 1e-12;

/// Where two axes come closest, with the derivatives of their distance by their four ends: those of
/// the first axis, then those of the second.
pub(super) struct AxisGap {
    /// Distance of the axes, m.
    pub(super) distance: f64,
    pub(super) derivatives: SVector<f64, 12>,
    /// Second derivatives, 1/m.
    pub(super) curvature: SMatrix<f64, 12, 12>,
    /// Whether the distance depends on each of the ends.
    pub(super) depends: [bool; 4],
}

impl AxisGap {
    pub(super) fn of(first: &Capsule, second: &Capsule) -> Self {
        let closest = first.closest(second);
        let [s, t] = closest.fractions;
        let [along_first, along_second] =
            [first, second].map(|capsule| capsule.end - capsule.start);
        let free = [(s, along_first), (t, along_second)]
            .map(|(part, along)| part > 0.0 && part < 1.0 && along.norm_squared() > 0.0);
        let way = -closest.offset;
        let distance = way.norm();
        let normal = way.try_normalize(0.0).unwrap_or_else(Vector3::z);
        // The way from the second axis to the first at these fractions is linear in the ends.
        let weights = [1.0 - s, s, t - 1.0, -t];
        let mut linear = SMatrix::<f64, 3, 12>::zeros();
        for (i, weight) in weights.iter().enumerate() {
            for k in 0..3 {
                linear[(k, 3 * i + k)] = *weight;
            }
        }
        let derivatives = linear.transpose() * normal;
        let mut half_square = linear.transpose() * linear;
        // The fractions follow the ends.
        let mut mixed = SMatrix::<f64, 2, 12>::zeros();
        let signs = [[-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0]];
        for (row, (along, sign)) in [along_first, -along_second].iter().zip(signs).enumerate() {
            if free[row] {
                let mut line = along.transpose() * linear;
                for (i, sign) in sign.iter().enumerate() {
                    for k in 0..3 {
                        line[3 * i + k] += sign * way[k];
                    }
                }
                mixed.set_row(row, &line);
            }
        }
        let (a, b) = (along_first.norm_squared(), along_second.norm_squared());
        let between = if free == [true, true] { -along_first.dot(&along_second) } else { 0.0 };
        let own = |is_free: bool, square: f64| if is_free { square } else { 1.0 };
        let mut squares = Matrix2::new(own(free[0], a), between, between, own(free[1], b));
        if squares.determinant() <= PARALLEL * squares[(0, 0)] * squares[(1, 1)] {
            // Parallel axes: the second fraction stays.
            squares = Matrix2::new(squares[(0, 0)], 0.0, 0.0, squares[(1, 1)]);
            mixed.row_mut(1).fill(0.0);
        }
        if let Some(inverse) = squares.try_inverse() {
            half_square -= mixed.transpose() * inverse * mixed;
        }
        let curvature =
            (half_square - derivatives * derivatives.transpose()) / distance.max(f64::MIN_POSITIVE);
        let depends =
            [free[0] || s < 1.0, free[0] || s > 0.0, free[1] || t < 1.0, free[1] || t > 0.0];
        Self { distance, derivatives, curvature, depends }
    }
}

/// Whether two axes that move straight from one place to another may pass through each other: not
/// if a plane stays between them.
pub(super) fn may_cross(from: [&Capsule; 2], to: [&Capsule; 2]) -> bool {
    let closest = from[0].closest(from[1]);
    let Some(normal) = closest.offset.try_normalize(0.0) else { return true };
    let along = |capsule: &Capsule| {
        [capsule.start, capsule.end].map(|end| (end - from[0].start).dot(&normal))
    };
    let [first, second] = to.map(along);
    // The first axis stays below, the second above.
    first[0].max(first[1]) >= second[0].min(second[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    /// Derivatives against differences, for axes that come closest inside, at an end, and at ends.
    #[test]
    fn derivatives_are_exact() {
        let ends =
            |x: &SVector<f64, 12>, i: usize| Point3::new(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
        let gap = |x: &SVector<f64, 12>| {
            let capsule =
                |i: usize| Capsule { start: ends(x, i), end: ends(x, i + 1), radius: 0.0 };
            AxisGap::of(&capsule(0), &capsule(2))
        };
        for shift in [0.0, 1.4, 3.0] {
            let x = SVector::<f64, 12>::from_column_slice(&[
                shift,
                0.1,
                0.0,
                1.0 + shift,
                -0.2,
                0.1,
                0.5,
                -1.0,
                0.6,
                0.4,
                0.9,
                0.8,
            ]);
            let here = gap(&x);
            let h = 1e-5;
            for i in 0..12 {
                let mut by = SVector::<f64, 12>::zeros();
                by[i] = h;
                let (low, high) = (gap(&(x - by)), gap(&(x + by)));
                let slope = (high.distance - low.distance) / (2.0 * h);
                assert!((slope - here.derivatives[i]).abs() < 1e-9, "{shift} {i}");
                let bent = (high.derivatives - low.derivatives) / (2.0 * h);
                let error = (bent - here.curvature.column(i)).amax();
                assert!(error < 1e-8, "{shift} {i}: {error:e}");
            }
        }
    }
}
