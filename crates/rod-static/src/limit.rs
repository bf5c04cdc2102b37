//! Limits of stability on a branch, found by where the equations become singular.

use crate::branch::{Followed, ParameterSweep};
use crate::mode::{LimitKind, LimitMode, LimitPoint};
use crate::shooting::Variation;
use nalgebra::{SMatrix, SVector};
use std::f64::consts::PI;

/// Parts of a bracket at which it is divided, if the ones before do not serve.
const PARTS: [f64; 3] = [0.5, 0.37, 0.66];
/// How often a step is halved by the number of conjugate points, before the singular value takes
/// over.
const COUNTED: usize = 6;
/// The same where the singular value does not change its sign: to the rounding of the count.
const COUNTED_ONLY: usize = 40;
/// Most steps of the search for the zero of the singular value.
const MOST_SECANTS: usize = 60;
/// Length of the bracket, in steps along the branch, at which it ends.
const CLOSE: f64 = 1e-13;
/// Part of the largest singular value below which one belongs to a neutral direction.
const NEUTRAL_ALL_ALONG: f64 = 1e-8;
/// Part of the derivative by the parameter that the equations at a fold cannot balance, at least.
const UNBALANCED: f64 = 1e-5;
/// The same near a limit, above which it is sought as a fold.
const BALANCED: f64 = 1e-2;
/// Distance between limits, in parts of the range, below which they are one.
const NEAR_LIMIT: f64 = 1e-3;
/// Points from which the zero of a singular value is interpolated, in a part of a step so short
/// that the error of the interpolation is a rounding.
const SAMPLES: usize = 6;

/// A singular value of the equations, with its vectors.
struct Singular {
    value: f64,
    /// The combination of the end conditions that nothing balances.
    left: SVector<f64, 6>,
    /// The variation, in the coordinates of the elimination, and at the end.
    right: SVector<f64, 6>,
    end: Variation,
}

impl Singular {
    /// The smallest singular value at a point but `neutral` ones.
    fn of(at: &Followed, neutral: usize) -> Option<Self> {
        let linear = at.shooting().eliminated(&at.elements, &at.nodes, None)?;
        let (left, values, right) = decomposed(&linear.onto)?;
        let i = values.len().checked_sub(1 + neutral)?;
        let end = linear.end_variation(&right[i]);
        Some(Self { value: values[i], left: left[i], right: right[i], end })
    }

    /// How much of the derivatives of the end conditions by the parameter nothing balances.
    fn unbalanced(&self, by_parameter: &SVector<f64, 6>) -> f64 {
        let size = by_parameter.norm();
        if size > 0.0 { (self.left.dot(by_parameter) / size).abs() } else { 0.0 }
    }

    /// The value with the sign that it has if its vectors turn continuously from those of `other`.
    fn signed(&self, other: &Self) -> f64 {
        (self.value).copysign(self.left.dot(&other.left) * self.end.dot(&other.end))
    }
}

/// Left vectors, values and right vectors of the singular value decomposition, in falling order.
type Decomposed = (Vec<SVector<f64, 6>>, Vec<f64>, Vec<SVector<f64, 6>>);

fn decomposed(matrix: &SMatrix<f64, 6, 6>) -> Option<Decomposed> {
    let svd = matrix.try_svd(true, true, 5.0 * f64::EPSILON, 300)?;
    let (u, v) = (svd.u?, svd.v_t?);
    let mut order: Vec<usize> = (0..6).collect();
    order.sort_by(|a, b| svd.singular_values[*b].total_cmp(&svd.singular_values[*a]));
    Some((
        order.iter().map(|i| u.column(*i).into_owned()).collect(),
        order.iter().map(|i| svd.singular_values[*i]).collect(),
        order.iter().map(|i| v.row(*i).transpose()).collect(),
    ))
}

/// Number of directions that are neutral at a point.
fn neutral(at: &Followed) -> Option<usize> {
    let linear = at.shooting().eliminated(&at.elements, &at.nodes, None)?;
    let (_, values, _) = decomposed(&linear.onto)?;
    Some(values.iter().filter(|value| **value < NEUTRAL_ALL_ALONG * values[0]).count())
}

impl ParameterSweep<'_> {
    /// The limits between two points of a branch with these numbers of conjugate points.
    pub(crate) fn limits(&self, a: &Followed, b: &Followed, counts: [usize; 2]) -> Vec<LimitPoint> {
        let mut limits = Vec::new();
        // Variations bend more than the rod itself.
        let b = &b.halved();
        let (mut low, mut count) = (-1.0, counts[0]);
        while count != counts[1] {
            let Some((limit, high)) = self.first_limit(a, b, (low, count), counts[1]) else {
                break;
            };
            (low, count) = (high, limit.conjugate_points[1]);
            let near = |other: &LimitPoint| {
                (other.parameter - limit.parameter).abs() < NEAR_LIMIT * self.range().abs()
            };
            match limits.last_mut().filter(|other| near(other)) {
                // Beside a limit rounding may miscount.
                Some(other) => other.conjugate_points[1] = count,
                None => limits.push(limit),
            }
        }
        limits
    }

    /// The first limit beyond the part `low` of a step, counted from its end, where the number of
    /// conjugate points is still `count`; and the part up to which it was sought.
    fn first_limit(
        &self,
        a: &Followed,
        b: &Followed,
        (mut low, count): (f64, usize),
        last: usize,
    ) -> Option<(LimitPoint, f64)> {
        let neutral = neutral(a)?.min(neutral(b)?);
        let (mut high, mut beyond) = (0.0, last);
        let halve = |low: &mut f64, high: &mut f64, beyond: &mut usize| -> Option<()> {
            // Where a point cannot be judged, one beside it can be.
            let at = |part: f64| -> Option<(f64, usize)> {
                let tau = *low + part * (*high - *low);
                Some((tau, self.between(a, b, tau)?.judged()?.conjugate_points()))
            };
            let (middle, found) = PARTS.into_iter().find_map(at)?;
            if found == count {
                *low = middle;
            } else {
                (*high, *beyond) = (middle, found);
            }
            Some(())
        };
        for _ in 0..COUNTED {
            halve(&mut low, &mut high, &mut beyond)?;
        }
        let right = high;
        let ends = [self.between(a, b, low)?, self.between(a, b, high)?];
        let at = match self.crossed(&ends, neutral, count) {
            Some(at) => at,
            None => {
                let of = |tau: f64| Singular::of(&self.between(a, b, tau)?, neutral);
                let reference = of(high)?;
                let before = of(low)?.signed(&reference);
                let tau = if before < 0.0 {
                    let value = |tau: f64| Some(of(tau)?.signed(&reference));
                    zero([low, high], [before, reference.value], value)
                } else {
                    for _ in 0..COUNTED_ONLY {
                        // At the limit itself there is no count.
                        if halve(&mut low, &mut high, &mut beyond).is_none() {
                            break;
                        }
                    }
                    0.5 * (low + high)
                };
                self.between(a, b, tau)?
            }
        };
        let mode = Singular::of(&at, neutral)?;
        let slopes = self.slopes(&at)?;
        let linear = at.shooting().eliminated(&at.elements, &at.nodes, Some(&slopes))?;
        let by_parameter = linear.missed.column(1).into_owned();
        let fold = mode.unbalanced(&by_parameter) > UNBALANCED;
        let limit = LimitPoint {
            kind: if fold { LimitKind::Fold } else { LimitKind::Bifurcation },
            parameter: at.parameter,
            conjugate_points: [count, beyond],
            mode: LimitMode {
                equilibrium: at.resting()?,
                variations: linear.variation(&mode.right)?,
            },
        };
        Some((limit, right))
    }

    /// The limit between two points near it if another branch crosses there: the parameter then
    /// tells the points of the branch apart, also where the rod may turn without effort.
    fn crossed(
        &self,
        [low, high]: &[Followed; 2],
        neutral: usize,
        count: usize,
    ) -> Option<Followed> {
        let reference = Singular::of(high, neutral)?;
        let slopes = self.slopes(high)?;
        let linear = high.shooting().eliminated(&high.elements, &high.nodes, Some(&slopes))?;
        if reference.unbalanced(&linear.missed.column(1).into_owned()) > BALANCED {
            return None;
        }
        let at = |parameter: f64| self.fixed(low.clone(), parameter);
        // Too near to the limit Newton's method may leave the branch: interpolate from around it.
        let (middle, half) =
            (0.5 * (low.parameter + high.parameter), 0.5 * (high.parameter - low.parameter));
        let mut samples = [(0.0, 0.0); SAMPLES];
        let mut points = Vec::new();
        for (i, sample) in samples.iter_mut().enumerate() {
            let x = -(PI * (i as f64 + 0.5) / SAMPLES as f64).cos();
            let point = at(middle + x * half)?;
            let value = Singular::of(&point, neutral)?.value;
            let passed = point.judged()?.conjugate_points() != count;
            *sample = (x, if passed { value } else { -value });
            points.push(point);
        }
        let interpolated = |x: f64| {
            samples.iter().enumerate().fold(0.0, |sum, (i, (own, value))| {
                let others = samples.iter().enumerate().filter(|(j, _)| *j != i);
                sum + value
                    * others.map(|(_, (other, _))| (x - other) / (own - other)).product::<f64>()
            })
        };
        let values = [interpolated(-1.0), interpolated(1.0)];
        if values[0] * values[1] > 0.0 {
            return None;
        }
        let x = zero([-1.0, 1.0], values, |x| Some(interpolated(x)));
        let parameter = middle + x * half;
        // Where there is no convergence at the limit itself, what is beside it.
        at(parameter).or_else(|| {
            let away = |p: &Followed| (p.parameter - parameter).abs();
            let nearest = points.into_iter().min_by(|p, q| away(p).total_cmp(&away(q)))?;
            Some(Followed { parameter, ..nearest })
        })
    }
}

/// The zero of a function between `ends`, where it has `values` of different signs, by the method
/// of Illinois; where the function fails, it ends.
fn zero(mut ends: [f64; 2], mut values: [f64; 2], f: impl Fn(f64) -> Option<f64>) -> f64 {
    let mut kept = None;
    let mut best = if values[0].abs() < values[1].abs() { ends[0] } else { ends[1] };
    for _ in 0..MOST_SECANTS {
        if (ends[1] - ends[0]).abs() < CLOSE * (1.0 + ends[0].abs()) {
            break;
        }
        let tau = (ends[0] * values[1] - ends[1] * values[0]) / (values[1] - values[0]);
        let Some(value) = f(tau) else { break };
        best = tau;
        let side = usize::from((value > 0.0) == (values[1] > 0.0));
        (ends[side], values[side]) = (tau, value);
        if value == 0.0 {
            break;
        }
        if kept == Some(1 - side) {
            values[1 - side] *= 0.5;
        }
        kept = Some(1 - side);
    }
    best
}
