//! One step of the rod's equations along the arc length, with its derivatives.
//!
//! Numbers here are scaled: the rod's length and a stiffness of it are one.

use crate::rod::Properties;
use nalgebra::{Matrix3, Quaternion, SMatrix, SVector, UnitQuaternion, Vector3};
use rapunzel_fiber::so3::hat;

/// Rows of position, quaternion (i, j, k, w), moment, force, elastic energy, work of the loads.
const STATE: usize = 15;
/// With the derivatives of position, rotation and moment by rotation, moment and force.
const WITH_DERIVATIVES: usize = STATE + 81;

/// Derivatives of a state by another one: rows and columns position, rotation vector (world
/// frame, from the left), moment, force.
pub(crate) type Propagator = SMatrix<f64, 12, 12>;

/// Position, frame, moment and force at a node, scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    pub(crate) r: Vector3<f64>,
    pub(crate) q: UnitQuaternion<f64>,
    pub(crate) m: Vector3<f64>,
    pub(crate) n: Vector3<f64>,
}

/// Where a step leads.
pub(crate) struct Reached {
    pub(crate) node: Node,
    /// Elastic energy of the step, and the work of the distributed load from the origin.
    pub(crate) elastic: f64,
    pub(crate) work: f64,
}

impl Node {
    fn pack<const N: usize>(&self) -> SVector<f64, N> {
        let mut y = SVector::<f64, N>::zeros();
        y.fixed_rows_mut::<3>(0).copy_from(&self.r);
        y.fixed_rows_mut::<4>(3).copy_from(&self.q.coords);
        y.fixed_rows_mut::<3>(7).copy_from(&self.m);
        y.fixed_rows_mut::<3>(10).copy_from(&self.n);
        y
    }

    fn reached<const N: usize>(y: &SVector<f64, N>) -> Reached {
        let q = Quaternion::from_vector(y.fixed_rows::<4>(3).into_owned());
        let node = Self {
            r: y.fixed_rows::<3>(0).into_owned(),
            q: UnitQuaternion::from_quaternion(q),
            m: y.fixed_rows::<3>(7).into_owned(),
            n: y.fixed_rows::<3>(10).into_owned(),
        };
        Reached { node, elastic: y[13], work: y[14] }
    }

    /// The step from `from` to `to` through `properties(s)`.
    pub(crate) fn step(
        &self,
        from: f64,
        to: f64,
        properties: impl Fn(f64) -> Properties,
    ) -> Reached {
        let rate = |s: f64, y: &SVector<f64, STATE>| {
            let mut rate = SVector::<f64, _>::zeros();
            fill(&properties(s), y, &mut rate);
            rate
        };
        Self::reached(&cooper_verner(self.pack(), from, to, rate))
    }

    /// The step and its derivatives.
    pub(crate) fn step_with_derivatives(
        &self,
        from: f64,
        to: f64,
        properties: impl Fn(f64) -> Properties,
    ) -> (Reached, Propagator) {
        let rate = |s: f64, y: &SVector<f64, WITH_DERIVATIVES>| {
            let mut rate = SVector::<f64, _>::zeros();
            let p = properties(s);
            let frame = fill(&p, y, &mut rate);
            vary(&p, &frame, y, &mut rate);
            rate
        };
        let mut y = self.pack::<WITH_DERIVATIVES>();
        for column in 0..6 {
            // Rotation and moment start as themselves; the rows are position, rotation, moment.
            y[STATE + 9 * column + 3 + column] = 1.0;
        }
        let y = cooper_verner(y, from, to, rate);
        let mut propagator = Propagator::identity();
        let rows = SMatrix::<f64, 9, 9>::from_column_slice(&y.as_slice()[STATE..]);
        propagator.fixed_view_mut::<9, 9>(0, 3).copy_from(&rows);
        (Self::reached(&y), propagator)
    }
}

/// Writes the derivatives of the state by the arc length; returns the frame.
fn fill<const N: usize>(
    p: &Properties,
    y: &SVector<f64, N>,
    rate: &mut SVector<f64, N>,
) -> Matrix3<f64> {
    let q = Quaternion::from_vector(y.fixed_rows::<4>(3).into_owned());
    let frame = UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner();
    let (m, n) = (y.fixed_rows::<3>(7).into_owned(), y.fixed_rows::<3>(10).into_owned());
    let body = frame.tr_mul(&m);
    let strain = body.component_div(&p.stiffness);
    let tangent = frame.column(2).into_owned();
    let turned = q * Quaternion::from_imag(0.5 * (p.natural_curvature + strain));
    rate.fixed_rows_mut::<3>(0).copy_from(&tangent);
    rate.fixed_rows_mut::<4>(3).copy_from(&turned.coords);
    rate.fixed_rows_mut::<3>(7).copy_from(&n.cross(&tangent));
    rate.fixed_rows_mut::<3>(10).copy_from(&-p.load);
    rate[13] = 0.5 * body.dot(&strain);
    rate[14] = p.load.dot(&y.fixed_rows::<3>(0));
    frame
}

/// Writes the derivatives of the variations by the arc length.
fn vary(
    p: &Properties,
    frame: &Matrix3<f64>,
    y: &SVector<f64, WITH_DERIVATIVES>,
    rate: &mut SVector<f64, WITH_DERIVATIVES>,
) {
    let (m, n) = (y.fixed_rows::<3>(7).into_owned(), y.fixed_rows::<3>(10).into_owned());
    let tangent = hat(&frame.column(2).into_owned());
    let mut flexible = *frame;
    for (mut column, stiffness) in flexible.column_iter_mut().zip(p.stiffness.iter()) {
        column /= *stiffness;
    }
    let flexible = flexible * frame.transpose();
    let (by_rotation, to_moment) = (flexible * hat(&m), -hat(&n) * tangent);
    for column in 0..9 {
        let at = STATE + 9 * column;
        let (rotation, moment) =
            (y.fixed_rows::<3>(at + 3).into_owned(), y.fixed_rows::<3>(at + 6).into_owned());
        let mut moved = to_moment * rotation;
        if column >= 6 {
            moved -= tangent.column(column - 6);
        }
        rate.fixed_rows_mut::<3>(at).copy_from(&(-tangent * rotation));
        rate.fixed_rows_mut::<3>(at + 3).copy_from(&(flexible * moment + by_rotation * rotation));
        rate.fixed_rows_mut::<3>(at + 6).copy_from(&moved);
    }
}

/// `sqrt(21)`.
const S: f64 = 4.582_575_694_955_84;

/// Nodes of the method of Cooper and Verner (1972): order eight with eleven stages.
const NODES: [f64; 11] = [
    0.0,
    0.5,
    0.5,
    (7.0 + S) / 14.0,
    (7.0 + S) / 14.0,
    0.5,
    (7.0 - S) / 14.0,
    (7.0 - S) / 14.0,
    0.5,
    (7.0 + S) / 14.0,
    1.0,
];

/// Its nonzero coefficients, stage by stage: the earlier stage and the factor.
const STAGES: [&[(usize, f64)]; 11] = [
    &[],
    &[(0, 0.5)],
    &[(0, 0.25), (1, 0.25)],
    &[(0, 1.0 / 7.0), (1, (-7.0 - 3.0 * S) / 98.0), (2, (21.0 + 5.0 * S) / 49.0)],
    &[(0, (11.0 + S) / 84.0), (2, (18.0 + 4.0 * S) / 63.0), (3, (21.0 - S) / 252.0)],
    &[
        (0, (5.0 + S) / 48.0),
        (2, (9.0 + S) / 36.0),
        (3, (-231.0 + 14.0 * S) / 360.0),
        (4, (63.0 - 7.0 * S) / 80.0),
    ],
    &[
        (0, (10.0 - S) / 42.0),
        (2, (-432.0 + 92.0 * S) / 315.0),
        (3, (633.0 - 145.0 * S) / 90.0),
        (4, (-504.0 + 115.0 * S) / 70.0),
        (5, (63.0 - 13.0 * S) / 35.0),
    ],
    &[(0, 1.0 / 14.0), (4, (14.0 - 3.0 * S) / 126.0), (5, (13.0 - 3.0 * S) / 63.0), (6, 1.0 / 9.0)],
    &[
        (0, 1.0 / 32.0),
        (4, (91.0 - 21.0 * S) / 576.0),
        (5, 11.0 / 72.0),
        (6, (-385.0 - 75.0 * S) / 1152.0),
        (7, (63.0 + 13.0 * S) / 128.0),
    ],
    &[
        (0, 1.0 / 14.0),
        (4, 1.0 / 9.0),
        (5, (-733.0 - 147.0 * S) / 2205.0),
        (6, (515.0 + 111.0 * S) / 504.0),
        (7, (-51.0 - 11.0 * S) / 56.0),
        (8, (132.0 + 28.0 * S) / 245.0),
    ],
    &[
        (4, (-42.0 + 7.0 * S) / 18.0),
        (5, (-18.0 + 28.0 * S) / 45.0),
        (6, (-273.0 - 53.0 * S) / 72.0),
        (7, (301.0 + 53.0 * S) / 72.0),
        (8, (28.0 - 28.0 * S) / 45.0),
        (9, (49.0 - 7.0 * S) / 18.0),
    ],
];

/// Its weights: those of Lobatto's quadrature with five points.
const WEIGHTS: [(usize, f64); 5] =
    [(0, 1.0 / 20.0), (7, 49.0 / 180.0), (8, 16.0 / 45.0), (9, 49.0 / 180.0), (10, 1.0 / 20.0)];

/// One step of the explicit Runge-Kutta method.
fn cooper_verner<const N: usize>(
    y: SVector<f64, N>,
    from: f64,
    to: f64,
    rate: impl Fn(f64, &SVector<f64, N>) -> SVector<f64, N>,
) -> SVector<f64, N> {
    let h = to - from;
    let mut rates = [SVector::<f64, N>::zeros(); 11];
    for (stage, parts) in STAGES.iter().enumerate() {
        let mut at = y;
        for (earlier, factor) in *parts {
            at.axpy(h * factor, &rates[*earlier], 1.0);
        }
        rates[stage] = rate(from + h * NODES[stage], &at);
    }
    let mut end = y;
    for (stage, weight) in WEIGHTS {
        end.axpy(h * weight, &rates[stage], 1.0);
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    fn properties(s: f64) -> Properties {
        Properties {
            stiffness: Vector3::new(1.0, 0.6, 0.7 + 0.2 * s),
            natural_curvature: Vector3::new(2.0 * s, -1.0, 1.5 * (3.0 * s).cos()),
            load: Vector3::new(0.3, -2.0 * s, 4.0),
        }
    }

    fn node() -> Node {
        Node {
            r: Vector3::new(0.1, 0.2, 0.3),
            q: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.5, 0.2)),
            m: Vector3::new(1.5, -0.8, 0.6),
            n: Vector3::new(-3.0, 2.0, 5.0),
        }
    }

    fn run(steps: u32) -> Node {
        let mut node = node();
        for i in 0..steps {
            let at = |i: u32| f64::from(i) / f64::from(steps);
            node = node.step(at(i), at(i + 1), properties).node;
        }
        node
    }

    #[test]
    fn stages_are_consistent() {
        for (stage, parts) in STAGES.iter().enumerate() {
            let sum: f64 = parts.iter().map(|(_, factor)| factor).sum();
            assert!((sum - NODES[stage]).abs() < 1e-14, "stage {stage}: {sum}");
        }
    }

    #[test]
    fn the_order_is_eight() {
        let exact = run(128);
        let [coarse, fine] = [8, 16].map(|steps| (run(steps).r - exact.r).norm());
        let order = (coarse / fine).log2();
        assert!((7.5..9.5).contains(&order), "order {order}: {coarse:e}, {fine:e}");
    }

    /// The derivatives against central differences.
    #[test]
    fn derivatives_are_exact() {
        let (_, propagator) = node().step_with_derivatives(0.0, 0.05, properties);
        let h = 1e-5;
        let end = |column: usize, h: f64| {
            let mut node = node();
            let mut change = [Vector3::zeros(); 4];
            change[column / 3][column % 3] = h;
            node.r += change[0];
            node.q = UnitQuaternion::from_scaled_axis(change[1]) * node.q;
            node.m += change[2];
            node.n += change[3];
            node.step(0.0, 0.05, properties).node
        };
        for column in 0..12 {
            let (a, b) = (end(column, -h), end(column, h));
            let parts = [b.r - a.r, (b.q * a.q.inverse()).scaled_axis(), b.m - a.m, b.n - a.n];
            for (part, difference) in parts.iter().enumerate() {
                let exact = propagator.fixed_view::<3, 1>(3 * part, column);
                let error = (difference / (2.0 * h) - exact).norm();
                assert!(error < 1e-8, "rows {part}, column {column}: {error:e}");
            }
        }
    }
}
