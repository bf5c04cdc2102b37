//! Lines through the origin, as far from each other as can be: packings in the Grassmannian space
//! G(3, 1) (thesis, 7.3.7.2; Conway, Hardin and Sloane 1996).

use crate::random::SplitMix64;
use nalgebra::{DMatrix, DVector, Vector3};

/// Directions of `count` lines through the origin with the largest least angle between any two that
/// was found, the same for every call.
///
/// From several random starts, least of the smooth maximum `log sum exp(b c^2) / b` of the squared
/// cosines c of all pairs, for rising b: each a Newton-like descent from the one before. The best
/// start is refined until b is so large that the smooth maximum is the maximum to 1e-6. All
/// best known angles (Sloane's tables) for 3 to 20 lines are reached within 0.05 degrees; for more
/// lines the starts are fewer, and the angle is a good one. Cost: half a second for 20 lines, some
/// seconds for 100.
#[must_use]
pub fn lines(count: usize) -> Vec<Vector3<f64>> {
    let mut random = SplitMix64(count as u64);
    let starts = (200_000 / (count * count).max(1)).clamp(3, 1000);
    let mut best: Option<Packing> = None;
    for _ in 0..starts {
        let mut packing = Packing((0..count).map(|_| random.direction()).collect());
        packing.descend(SHARPNESS[0].iter());
        if best.as_ref().is_none_or(|b| packing.largest() < b.largest()) {
            best = Some(packing);
        }
    }
    let mut packing = best.unwrap_or_else(|| Packing(Vec::new()));
    packing.descend(SHARPNESS[1].iter());
    packing.0
}

/// The least angle between any two lines, radians; a right angle for fewer than two.
#[must_use]
pub fn least_angle(lines: &[Vector3<f64>]) -> f64 {
    let mut least = std::f64::consts::FRAC_PI_2;
    for (i, a) in lines.iter().enumerate() {
        for b in &lines[..i] {
            least = least.min(a.cross(b).norm().atan2(a.dot(b).abs()));
        }
    }
    least
}

/// Factors b of all starts, and of the best one.
const SHARPNESS: [&[f64]; 2] =
    [&[10.0, 40.0, 160.0, 640.0, 2560.0], &[1e4, 4e4, 1.6e5, 6.4e5, 2.56e6]];

struct Packing(Vec<Vector3<f64>>);

impl Packing {
    fn squared_cosines(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let lines = &self.0;
        (1..lines.len())
            .flat_map(move |i| (0..i).map(move |j| (i, j, lines[i].dot(&lines[j]).powi(2))))
    }

    fn largest(&self) -> f64 {
        self.squared_cosines().map(|(_, _, c)| c).fold(0.0, f64::max)
    }

    fn smooth_maximum(&self, sharpness: f64) -> f64 {
        let largest = self.largest();
        let sum: f64 =
            self.squared_cosines().map(|(_, _, c)| (sharpness * (c - largest)).exp()).sum();
        largest + sum.max(1.0).ln() / sharpness
    }

    /// Descends at each sharpness in turn, damped as of Levenberg and Marquardt.
    fn descend<'a>(&mut self, sharpnesses: impl Iterator<Item = &'a f64>) {
        if self.0.len() < 2 {
            return;
        }
        for &sharpness in sharpnesses {
            let mut damping = 1.0;
            let mut value = self.smooth_maximum(sharpness);
            for _ in 0..30 {
                let (gradient, curvature, tangents) = self.model(sharpness);
                let damped =
                    curvature + DMatrix::identity(gradient.len(), gradient.len()) * damping;
                let Some(factor) = damped.cholesky() else { break };
                let step = factor.solve(&gradient);
                let expected = gradient.dot(&step);
                let moved = self.moved(&tangents, &step);
                let next = moved.smooth_maximum(sharpness);
                if next < value {
                    *self = moved;
                    damping = (0.2 * damping).max(1e-9);
                } else {
                    damping *= 5.0;
                }
                // Less than the smoothing is no gain.
                if expected < 1e-4 / sharpness {
                    break;
                }
                value = value.min(next);
            }
        }
    }

    /// Gradient of the smooth maximum in tangent coordinates, two a line; the part of its second
    /// derivative that grows with the sharpness, which is positive; and the tangents.
    fn model(&self, sharpness: f64) -> (DVector<f64>, DMatrix<f64>, Vec<[Vector3<f64>; 2]>) {
        let lines = &self.0;
        let tangents: Vec<_> = lines.iter().map(tangents).collect();
        let largest = self.largest();
        let weight = |c: f64| (sharpness * (c - largest)).exp();
        let total: f64 = self.squared_cosines().map(|(_, _, c)| weight(c)).sum();
        let mut gradient = DVector::zeros(2 * lines.len());
        let mut curvature = DMatrix::zeros(2 * lines.len(), 2 * lines.len());
        for (i, j, c) in self.squared_cosines() {
            let w = weight(c) / total;
            if w < 1e-12 {
                continue;
            }
            let slope = 2.0 * lines[i].dot(&lines[j]);
            let along = |i: usize, j: usize| tangents[i].map(|t| slope * t.dot(&lines[j]));
            let ([a, b], [d, e]) = (along(i, j), along(j, i));
            let entries = [(2 * i, a), (2 * i + 1, b), (2 * j, d), (2 * j + 1, e)];
            for (row, x) in entries {
                gradient[row] += w * x;
                for (column, y) in entries {
                    curvature[(row, column)] += sharpness * w * x * y;
                }
            }
        }
        curvature.ger(-sharpness, &gradient, &gradient, 1.0);
        (gradient, curvature, tangents)
    }

    /// All lines moved against `step`.
    fn moved(&self, tangents: &[[Vector3<f64>; 2]], step: &DVector<f64>) -> Self {
        let moved =
            self.0.iter().zip(tangents).enumerate().map(|(i, (line, [t, u]))| {
                (line - t * step[2 * i] - u * step[2 * i + 1]).normalize()
            });
        Self(moved.collect())
    }
}

/// Two unit vectors that are orthogonal to `line` and to each other.
fn tangents(line: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let first = line.cross(&Vector3::ith(line.iamin(), 1.0)).normalize();
    [first, line.cross(&first)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Best known least angles of 3 to 20 lines, degrees (Sloane's tables of packings).
    const BEST: [f64; 18] = [
        90.0, 70.5288, 63.4349, 63.4349, 54.7356, 49.6399, 47.9821, 46.6746, 44.4031, 41.8820,
        39.8131, 38.6824, 38.1349, 37.3774, 35.2353, 34.4088, 33.2115, 32.7071,
    ];

    #[test]
    fn the_best_known_angles_are_reached() {
        for (count, best) in (3..).zip(BEST) {
            let lines = lines(count);
            assert_eq!(lines.len(), count);
            let angle = least_angle(&lines).to_degrees();
            // Nothing is better than the best known by more than its last digit.
            assert!((best - 0.05..best + 1e-4).contains(&angle), "{count}: {angle} of {best}");
            assert!(lines.iter().all(|v| (v.norm() - 1.0).abs() < 1e-14));
        }
    }

    /// Caps of half the angle around both ends of each line are disjoint, so the part of the sphere
    /// that they cover bounds what can be reached; no packing covers more than
    /// discs do the plane, and a good one of many caps nearly as much.
    #[test]
    fn many_lines_are_packed_densely() {
        let lines = lines(60);
        let covered = 60.0 * (1.0 - (0.5 * least_angle(&lines)).cos());
        assert!((0.82..0.907).contains(&covered), "{covered}");
    }

    #[test]
    fn few_lines_are_no_trouble() {
        assert!(lines(0).is_empty());
        assert_eq!(lines(1).len(), 1);
        assert!((least_angle(&lines(2)).to_degrees() - 90.0).abs() < 1e-3);
    }
}
