//! Principal axes of points: the eigenvectors of their covariance.

use nalgebra::{Matrix3, Point3, Vector3};

/// The axes along which points scatter most, next and least: the columns of a matrix that is
/// orthogonal to rounding. Any axes where the scatter is the same in all directions; those of the
/// world where lengths overflow.
///
/// Covariance as (7.12) of the thesis, corrected: about the centroid (erratum). Cost: two passes.
pub(super) fn principal_axes(points: &[Point3<f64>]) -> Matrix3<f64> {
    let share = 1.0 / points.len() as f64;
    let centroid: Vector3<f64> = points.iter().map(|p| p.coords * share).sum();
    let size = points.iter().map(|p| (p.coords - centroid).amax()).fold(0.0, f64::max);
    // In units of the size, so that squares neither overflow nor vanish.
    if !(size > f64::MIN_POSITIVE && size.is_finite()) {
        return Matrix3::identity();
    }
    let mut covariance = Matrix3::zeros();
    for p in points {
        let d = (p.coords - centroid) / size;
        covariance += d * d.transpose();
    }
    eigenvectors(covariance)
}

/// Eigenvectors of a symmetric matrix, by decreasing eigenvalue: Jacobi's rotations, which keep
/// the axes orthogonal. They converge quadratically; eight sweeps are twice what is ever needed.
fn eigenvectors(mut a: Matrix3<f64>) -> Matrix3<f64> {
    let mut axes = Matrix3::identity();
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[(p, q)] == 0.0 {
                continue;
            }
            let tau = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
            let tan = tau.signum() / (tau.abs() + tau.hypot(1.0));
            let cos = 1.0 / tan.hypot(1.0);
            let mut rotation = Matrix3::identity();
            (rotation[(p, p)], rotation[(q, q)]) = (cos, cos);
            (rotation[(p, q)], rotation[(q, p)]) = (tan * cos, -tan * cos);
            a = rotation.transpose() * a * rotation;
            axes *= rotation;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[(j, j)].total_cmp(&a[(i, i)]));
    Matrix3::from_columns(&order.map(|i| axes.column(i).into_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn axes_are_eigenvectors(entries in prop::array::uniform6(-1.0..1.0_f64)) {
            let [xx, yy, zz, xy, xz, yz] = entries;
            let a = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
            let axes = eigenvectors(a);
            prop_assert!((axes.transpose() * axes - Matrix3::identity()).amax() < 1e-14);
            let diagonal = axes.transpose() * a * axes;
            let values = diagonal.diagonal();
            prop_assert!((diagonal - Matrix3::from_diagonal(&values)).amax() < 1e-14);
            prop_assert!(values[0] >= values[1] && values[1] >= values[2]);
        }
    }

    #[test]
    fn degenerate_points_have_axes() {
        let here = Point3::new(1.0, 2.0, 3.0);
        assert_eq!(principal_axes(&[here; 3]), Matrix3::identity());
        let far = Point3::new(1e308, -1e308, 1e308);
        let near = Point3::new(0.0, 1e-160, 1e-160);
        for line in [[far, -far], [Point3::origin(), near], [here, here + far.coords]] {
            let axes = principal_axes(&line);
            assert!((axes.transpose() * axes - Matrix3::identity()).amax() < 1e-14);
        }
    }
}
