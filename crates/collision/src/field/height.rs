//! Terrain: heights over a square lattice.

use super::mesh::index;
use super::{DistanceField, Sample, Soup};
use crate::CollisionError;
use crate::triangle::nearest_weights;
use nalgebra::{Point3, Vector3};

/// The ground below a graph `z = h(x, y)`.
///
/// The heights stand on a square lattice, and every square is two triangles, split along the
/// diagonal from its low corner in x and y to its high corner. Beyond the lattice the heights at
/// its rim go on, constant along the outward normal of the rim.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightField {
    origin: [f64; 2],
    spacing: f64,
    columns: usize,
    heights: Vec<f64>,
    band: f64,
    /// Distance over height above the ground is at least this, the cosine of the steepest slope.
    cosine: f64,
}

impl HeightField {
    /// `heights`, m, in rows along x, `columns` to a row, the first above `origin` (world, x and
    /// y), m, at distances of `spacing`, m. Up to `band`, m, values are distances; the cost of a
    /// query grows with the square of the band over the spacing.
    ///
    /// # Errors
    /// [`CollisionError::Heights`] if there are not at least two rows and two columns, or the array
    /// does not fill its rows, or a number is not finite, or `spacing` or `band` not positive.
    pub fn new(
        origin: [f64; 2],
        spacing: f64,
        columns: usize,
        heights: Vec<f64>,
        band: f64,
    ) -> Result<Self, CollisionError> {
        let refuse = |problem| Err(CollisionError::Heights { problem });
        if columns < 2 || heights.len() < 2 * columns {
            return refuse("at least two rows and two columns are needed");
        }
        if !heights.len().is_multiple_of(columns) {
            return refuse("the last row is not full");
        }
        if !heights.iter().chain(&origin).all(|x| x.is_finite()) {
            return refuse("all heights and the origin must be finite");
        }
        if ![spacing, band].iter().all(|&x| x > 0.0 && x.is_finite()) {
            return refuse("spacing and band must be positive and finite");
        }
        let mut field = Self { origin, spacing, columns, heights, band, cosine: 1.0 };
        let mut steepest: f64 = 0.0;
        for row in 0..=field.rows() as isize {
            for column in 0..=columns as isize {
                for corners in field.triangles(column - 1, row - 1) {
                    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
                    steepest = steepest.max(normal.xy().norm() / normal.z);
                }
            }
        }
        field.cosine = 1.0 / steepest.hypot(1.0);
        Ok(field)
    }

    /// The triangles of the ground within the lattice, counter-clockwise from above: an open
    /// surface.
    #[must_use]
    pub fn surface(&self) -> Soup {
        let [x, y] = self.origin;
        let (columns, rows) = (self.columns, self.rows());
        let vertices = self.heights.iter().enumerate().map(|(k, &height)| {
            let (i, j) = ((k % columns) as f64, (k / columns) as f64);
            Point3::new(x + i * self.spacing, y + j * self.spacing, height)
        });
        let square = |k: usize| {
            let low = k / (columns - 1) * columns + k % (columns - 1);
            let [a, b, c, d] = [low, low + 1, low + columns + 1, low + columns].map(index);
            [[a, b, c], [a, c, d]]
        };
        Soup {
            vertices: vertices.collect(),
            triangles: (0..(columns - 1) * (rows - 1)).flat_map(square).collect(),
        }
    }

    fn rows(&self) -> usize {
        self.heights.len() / self.columns
    }

    /// A corner of the lattice (world, horizontally relative to the origin), m; also beyond it.
    fn corner(&self, column: isize, row: isize) -> Vector3<f64> {
        let inside = |x: isize, count: usize| x.clamp(0, count as isize - 1).unsigned_abs();
        let (i, j) = (inside(column, self.columns), inside(row, self.rows()));
        let height = self.heights[j * self.columns + i];
        Vector3::new(column as f64 * self.spacing, row as f64 * self.spacing, height)
    }

    /// The two triangles of a square, counter-clockwise from above.
    fn triangles(&self, column: isize, row: isize) -> [[Vector3<f64>; 3]; 2] {
        let [a, b, c, d] =
            [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| self.corner(column + i, row + j));
        [[a, b, c], [a, c, d]]
    }

    /// The square above which a horizontal position is, as column or row.
    fn square(&self, x: f64, count: usize) -> isize {
        // Far outside all squares are alike.
        #[expect(clippy::cast_possible_truncation, reason = "clamped to the lattice")]
        let index = (x / self.spacing).floor().clamp(-1.0, count as f64 - 1.0) as isize;
        index
    }
}

impl DistanceField for HeightField {
    fn sample(&self, point: &Point3<f64>) -> Sample {
        let [x0, y0] = self.origin;
        // Beyond the rim the ground does not change with the distance from it.
        let rim = |x: f64, count: usize| {
            let far = 2.0 * self.band + self.spacing;
            x.clamp(-far, (count - 1) as f64 * self.spacing + far)
        };
        let p =
            Vector3::new(rim(point.x - x0, self.columns), rim(point.y - y0, self.rows()), point.z);
        let (column, row) = (self.square(p.x, self.columns), self.square(p.y, self.rows()));
        let [lower, upper] = self.triangles(column, row);
        let across = (p - lower[0]).xy();
        let [a, b, c] = if across.x >= across.y { lower } else { upper };
        let normal = (b - a).cross(&(c - a));
        let above = normal.dot(&(p - a)) / normal.z;
        let bound = self.cosine * above;
        if bound.abs() >= self.band {
            return Sample { value: bound, gradient: self.cosine / normal.z * normal };
        }
        let reach = above.abs().min(self.band);
        let range = |x: f64, low: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "within the rim and the reach")]
            let index = ((x + low * reach) / self.spacing).floor() as isize;
            index
        };
        let mut nearest = Vector3::new(0.0, 0.0, above);
        let mut least = f64::INFINITY;
        for j in range(p.y, -1.0)..=range(p.y, 1.0) {
            for i in range(p.x, -1.0)..=range(p.x, 1.0) {
                for triangle in self.triangles(i, j) {
                    let corners = triangle.map(|corner| corner - p);
                    let weights = nearest_weights(&corners);
                    let foot: Vector3<f64> = (0..3).map(|k| weights[k] * corners[k]).sum();
                    if foot.norm_squared() < least {
                        least = foot.norm_squared();
                        nearest = foot;
                    }
                }
            }
        }
        let distance = nearest.norm();
        let sign = 1.0_f64.copysign(above);
        // On the ground itself the direction to the foot is rounding.
        let gradient = if distance > 1e-9 * self.spacing {
            -sign / distance * nearest
        } else {
            normal.normalize()
        };
        if distance >= self.band {
            return Sample { value: sign * self.band, gradient: Vector3::zeros() };
        }
        Sample { value: sign * distance, gradient }
    }

    fn band(&self) -> f64 {
        self.band
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn hills() -> HeightField {
        let height = |k: usize| {
            let (x, y) = ((k % 12) as f64, (k / 12) as f64);
            0.7 * (1.3 * x).sin() * (0.9 * y).cos()
        };
        HeightField::new([-0.5, 0.25], 0.5, 12, (0..120).map(height).collect(), 0.6).expect("valid")
    }

    fn point() -> impl Strategy<Value = Point3<f64>> {
        [-3.0..8.0_f64, -3.0..7.0_f64, -2.0..2.0_f64].prop_map(Point3::from)
    }

    proptest! {
        /// Every triangle, of the lattice and of a wide rim, is asked.
        #[test]
        fn values_are_clipped_distances(p in point(), step in prop::array::uniform3(-0.2..0.2_f64)) {
            let field = hills();
            let q = p.coords - Vector3::new(-0.5, 0.25, 0.0);
            let mut least = f64::INFINITY;
            for (i, j) in (-12..24).flat_map(|i| (-12..24).map(move |j| (i, j))) {
                for triangle in field.triangles(i, j) {
                    let corners = triangle.map(|corner| corner - q);
                    let weights = nearest_weights(&corners);
                    let foot: Vector3<f64> = (0..3).map(|k| weights[k] * corners[k]).sum();
                    least = least.min(foot.norm());
                }
            }
            let Sample { value, gradient } = field.sample(&p);
            prop_assert!(value.abs() <= least + 1e-12);
            if least < 0.6 {
                prop_assert!((value.abs() - least).abs() <= 1e-12);
                prop_assert!((gradient.norm() - 1.0).abs() <= 1e-9);
            } else {
                prop_assert!(value.abs() >= 0.6);
            }
            let other = p + Vector3::from(step);
            let change = (value - field.value(&other)).abs();
            prop_assert!(change <= Vector3::from(step).norm() + 1e-12);
        }
    }

    #[test]
    fn bad_lattices_are_refused() {
        let field = |columns, heights: &[f64], spacing, band| {
            HeightField::new([0.0; 2], spacing, columns, heights.to_vec(), band)
        };
        assert!(field(2, &[0.0; 4], 1.0, 1.0).is_ok());
        for bad in [
            field(1, &[0.0; 4], 1.0, 1.0),
            field(2, &[0.0; 3], 1.0, 1.0),
            field(2, &[0.0; 5], 1.0, 1.0),
            field(2, &[0.0, f64::NAN, 0.0, 0.0], 1.0, 1.0),
            field(2, &[0.0; 4], 0.0, 1.0),
            field(2, &[0.0; 4], 1.0, f64::INFINITY),
        ] {
            assert!(matches!(bad, Err(CollisionError::Heights { .. })));
        }
    }
}
