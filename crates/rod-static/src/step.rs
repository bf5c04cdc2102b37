//! One step of the rod's equations along the arc length, with its derivatives.
//!
//! Numbers here are scaled: the rod's length and a stiffness of it are one.

use crate::gauss::{CUBIC, NODES, STAGES, STEPS, WEIGHTS};
use crate::rod::Properties;
use nalgebra::{
    Const, LU, Matrix3, Matrix3x4, Matrix4, Matrix4x3, Quaternion, SMatrix, SVector,
    UnitQuaternion, Vector3, Vector4,
};
use rapunzel_fiber::so3::hat;

/// Derivatives of a state by another one: rows and columns position, rotation vector (world
/// frame, from the left), moment, force.
pub(crate) type Propagator = SMatrix<f64, 12, 12>;

/// Position, frame, moment and force at a node, scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ShootingNode {
    pub(crate) r: Vector3<f64>,
    pub(crate) q: UnitQuaternion<f64>,
    pub(crate) m: Vector3<f64>,
    pub(crate) n: Vector3<f64>,
}

/// Result of a step.
pub(crate) struct Reached {
    pub(crate) node: ShootingNode,
    /// Elastic energy of the step.
    pub(crate) elastic: f64,
    /// Work of the distributed load in the step, with displacements from the origin.
    pub(crate) work: f64,
    /// Error estimate: how much of the rotation, rad, and of the moment, in units of what the force
    /// bends with, the highest polynomial carries.
    pub(crate) rough: f64,
}

/// Largest number of Newton steps for the stages.
const MOST_STAGE_ITERATIONS: usize = 20;
/// Size of a correction below which the derivatives of the step before are used again.
const NEAR_STAGE: f64 = 1e-2;
/// Size of a correction below which only rounding is left.
const SMALL_STAGE: f64 = 1e-12;

/// Number of unknowns of a step: the quaternions of all stages.
const UNKNOWNS: usize = 4 * STAGES;
/// Derivatives of the stages' rates by quaternion and moment.
type StageRates = [(Matrix4<f64>, Matrix4x3<f64>); STAGES];
type StageSolver = LU<f64, Const<UNKNOWNS>, Const<UNKNOWNS>>;

/// Quantities of the rod's equations at one stage.
struct GaussStage {
    q: Quaternion<f64>,
    m: Vector3<f64>,
    n: Vector3<f64>,
    p: Properties,
    tangent: Vector3<f64>,
    strain: Vector3<f64>,
    /// Derivative of the quaternion by the arc length.
    rate: Vector4<f64>,
}

impl GaussStage {
    fn new(q: Quaternion<f64>, n: Vector3<f64>, p: Properties) -> Self {
        let tangent = (q * Quaternion::from_imag(Vector3::z()) * q.conjugate()).imag();
        let zero = Vector3::zeros();
        Self { q, m: zero, n, p, tangent, strain: zero, rate: Vector4::zeros() }
    }

    /// Sets the moment `m`, and the strain and rate that follow from it.
    fn bend(&mut self, m: Vector3<f64>) {
        let body = (self.q.conjugate() * Quaternion::from_imag(m) * self.q).imag();
        self.m = m;
        self.strain = body.component_div(&self.p.stiffness);
        let curvature = Quaternion::from_imag(self.p.natural_curvature + self.strain);
        self.rate = (self.q * curvature).coords * 0.5;
    }

    fn moment_rate(&self) -> Vector3<f64> {
        self.n.cross(&self.tangent)
    }

    /// Derivative of the tangent by the quaternion of the stage.
    fn tangent_by_q(&self) -> Matrix3x4<f64> {
        let z = Quaternion::from_imag(Vector3::z()) * self.q.conjugate();
        2.0 * right(&z).fixed_rows::<3>(0)
    }

    /// Derivatives of the rate by quaternion and moment.
    fn rate_by(&self) -> (Matrix4<f64>, Matrix4x3<f64>) {
        let curvature = Quaternion::from_imag(self.p.natural_curvature + self.strain);
        let bent = left(&self.q).fixed_columns::<3>(0) * 0.5;
        let mut soft = Matrix3::from_diagonal(&self.p.stiffness.map(|k| 1.0 / k));
        let body = self.q.conjugate() * Quaternion::from_imag(self.m);
        let by_q = right(&curvature) * 0.5 + bent * soft * (2.0 * left(&body).fixed_rows::<3>(0));
        let turn = left(&self.q.conjugate()) * right(&self.q);
        soft *= turn.fixed_view::<3, 3>(0, 0);
        (by_q, bent * soft)
    }
}

/// Matrix `L(p)` of the product `p q` with a quaternion `q`.
fn left(p: &Quaternion<f64>) -> Matrix4<f64> {
    side(p, 1.0)
}

/// Matrix `R(p)` of the product `q p` with a quaternion `q`.
fn right(p: &Quaternion<f64>) -> Matrix4<f64> {
    side(p, -1.0)
}

fn side(p: &Quaternion<f64>, sign: f64) -> Matrix4<f64> {
    let v = p.imag();
    let mut m = Matrix4::from_diagonal_element(p.w);
    let mut turn = m.fixed_view_mut::<3, 3>(0, 0);
    turn += hat(&v) * sign;
    m.fixed_view_mut::<3, 1>(0, 3).copy_from(&v);
    m.fixed_view_mut::<1, 3>(3, 0).copy_from(&-v.transpose());
    m
}

/// A step of Gauss's method whose stages meet the equations.
struct GaussStep {
    h: f64,
    stages: [GaussStage; STAGES],
    converged: bool,
}

impl GaussStep {
    fn new(
        node: &ShootingNode,
        from: f64,
        to: f64,
        properties: impl Fn(f64) -> Properties,
    ) -> Self {
        let h = to - from;
        // Predict the quaternions of the stages with the curvature at the start.
        let p = NODES.map(|c| properties(from + h * c));
        let start = properties(from);
        let body = node.q.inverse_transform_vector(&node.m).component_div(&start.stiffness);
        let turn = (start.natural_curvature + body) * h;
        let mut q =
            NODES.map(|c| (node.q * UnitQuaternion::from_scaled_axis(turn * c)).into_inner());
        let mut stages = Self::stages(node, h, &q, &p);
        let (_, mut solver) = Self::derivatives(h, &stages);
        let mut size = f64::INFINITY;
        for iteration in 0..MOST_STAGE_ITERATIONS {
            // Near the solution the derivatives serve again: the error falls by their own.
            if iteration > 0 && size > NEAR_STAGE {
                (_, solver) = Self::derivatives(h, &stages);
            }
            // Residual of the stages: q_i - q_0 - h sum_j a_ij rate_j.
            let mut missed = SVector::<f64, UNKNOWNS>::zeros();
            for i in 0..STAGES {
                let mut sum = q[i].coords - node.q.coords;
                (0..STAGES).for_each(|j| sum -= stages[j].rate * (h * STEPS[i][j]));
                missed.fixed_rows_mut::<4>(4 * i).copy_from(&sum);
            }
            // Newton correction of the quaternions, and new stages.
            solver.solve_mut(&mut missed);
            for i in 0..STAGES {
                q[i].coords -= missed.fixed_rows::<4>(4 * i);
            }
            stages = Self::stages(node, h, &q, &p);
            size = missed.amax();
            if size < SMALL_STAGE {
                break;
            }
        }
        Self { h, stages, converged: size < SMALL_STAGE }
    }

    /// Stages with the given quaternions: forces follow from the loads, moments from forces and
    /// quaternions.
    fn stages(
        node: &ShootingNode,
        h: f64,
        q: &[Quaternion<f64>; STAGES],
        p: &[Properties; STAGES],
    ) -> [GaussStage; STAGES] {
        let mut stages = [0, 1, 2, 3].map(|i| {
            let load = (0..STAGES).fold(Vector3::zeros(), |sum, j| sum + p[j].load * STEPS[i][j]);
            GaussStage::new(q[i], node.n - load * h, p[i])
        });
        let rates = [0, 1, 2, 3].map(|j| stages[j].moment_rate());
        for i in 0..STAGES {
            let change = (0..STAGES).fold(Vector3::zeros(), |sum, j| sum + rates[j] * STEPS[i][j]);
            stages[i].bend(node.m + change * h);
        }
        stages
    }

    /// Derivatives of the rates of all stages, and the factored Jacobian of the stages' equations
    /// by the quaternions.
    fn derivatives(h: f64, stages: &[GaussStage; STAGES]) -> (StageRates, StageSolver) {
        let by = [0, 1, 2, 3].map(|j| stages[j].rate_by());
        let mut matrix = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::identity();
        for l in 0..STAGES {
            let moment = hat(&stages[l].n) * stages[l].tangent_by_q() * (h * h);
            let bends: [Matrix4<f64>; STAGES] =
                [0, 1, 2, 3].map(|j| by[j].1 * (moment * STEPS[j][l]));
            for i in 0..STAGES {
                let mut block = by[l].0 * (h * STEPS[i][l]);
                (0..STAGES).for_each(|j| block += bends[j] * STEPS[i][j]);
                let mut at = matrix.fixed_view_mut::<4, 4>(4 * i, 4 * l);
                at -= block;
            }
        }
        (by, matrix.lu())
    }

    /// Sum of a quantity over the stages with the weights of the method, times the step length.
    fn sum<T>(&self, zero: T, of: impl Fn(&GaussStage) -> T) -> T
    where
        T: std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
    {
        let all = self.stages.iter().zip(WEIGHTS);
        all.fold(zero, |sum, (stage, weight)| sum + of(stage) * (weight * self.h))
    }

    fn reached(&self, node: &ShootingNode) -> Reached {
        let zero = Vector3::zeros();
        let end = Quaternion::from_vector(node.q.coords + self.sum(Vector4::zeros(), |s| s.rate));
        let mut work = 0.0;
        for (i, stage) in self.stages.iter().enumerate() {
            let way = (0..STAGES).fold(zero, |sum, j| sum + self.stages[j].tangent * STEPS[i][j]);
            work += WEIGHTS[i] * self.h * stage.p.load.dot(&(node.r + way * self.h));
        }
        let cubic = |of: &dyn Fn(&GaussStage) -> Vector4<f64>| {
            let all = self.stages.iter().zip(CUBIC);
            all.fold(Vector4::zeros(), |sum, (stage, part)| sum + of(stage) * (part * self.h))
                .norm()
        };
        let strength =
            |s: &GaussStage| 1.0 + (s.n.norm() * s.p.stiffness.min()).sqrt() + s.m.norm();
        let moment = |s: &GaussStage| s.moment_rate().push(0.0) / strength(s);
        Reached {
            node: ShootingNode {
                r: node.r + self.sum(zero, |s| s.tangent),
                q: UnitQuaternion::from_quaternion(end),
                m: node.m + self.sum(zero, GaussStage::moment_rate),
                n: node.n - self.sum(zero, |s| s.p.load),
            },
            elastic: 0.5 * self.sum(0.0, |s| s.strain.dot(&s.strain.component_mul(&s.p.stiffness))),
            work,
            rough: cubic(&|s| s.rate * 2.0).max(cubic(&moment)),
        }
    }

    /// Derivatives of the state `reached` by the state `node` at the start of the step.
    fn propagator(&self, node: &ShootingNode, reached: &ShootingNode) -> Propagator {
        let (by, solver) = Self::derivatives(self.h, &self.stages);
        // Columns: rotation, moment, force of the start.
        let mut start = SMatrix::<f64, 4, 9>::zeros();
        let turn = right(&node.q).fixed_columns::<3>(0) * 0.5;
        start.fixed_view_mut::<4, 3>(0, 0).copy_from(&turn);
        let mut moment = SMatrix::<f64, 3, 9>::zeros();
        moment.fixed_view_mut::<3, 3>(0, 3).fill_with_identity();
        // Derivatives of the moment rates by the force at the start, at constant quaternions, times
        // h.
        let pulled: [SMatrix<f64, 3, 9>; STAGES] = [0, 1, 2, 3].map(|l| {
            let mut by_force = SMatrix::<f64, 3, 9>::zeros();
            let tangent = hat(&self.stages[l].tangent) * -self.h;
            by_force.fixed_view_mut::<3, 3>(0, 6).copy_from(&tangent);
            by_force
        });
        // Derivative of the moment at stage i: start moment plus weighted parts.
        let along = |i: usize, parts: &[SMatrix<f64, 3, 9>; STAGES]| {
            (0..STAGES).fold(moment, |sum, l| sum + parts[l] * STEPS[i][l])
        };
        // Derivatives of the stages' quaternions: right-hand sides, then the factored Jacobian.
        let mut stages = SMatrix::<f64, UNKNOWNS, 9>::zeros();
        for i in 0..STAGES {
            let mut rows = start;
            for j in 0..STAGES {
                rows += by[j].1 * along(j, &pulled) * (self.h * STEPS[i][j]);
            }
            stages.fixed_view_mut::<4, 9>(4 * i, 0).copy_from(&rows);
        }
        solver.solve_mut(&mut stages);
        let q = [0, 1, 2, 3].map(|j| stages.fixed_view::<4, 9>(4 * j, 0).into_owned());
        let tangents = [0, 1, 2, 3].map(|j| self.stages[j].tangent_by_q() * q[j]);
        let moments =
            [0, 1, 2, 3].map(|j| pulled[j] + hat(&self.stages[j].n) * tangents[j] * self.h);
        // Derivatives of position, quaternion and moment at the end, with the weights of the
        // method.
        let mut propagator = Propagator::identity();
        let (mut position, mut end) = (SMatrix::<f64, 3, 9>::zeros(), start);
        let mut carried = moment;
        for (j, (by_q, by_m)) in by.iter().enumerate() {
            position += tangents[j] * (self.h * WEIGHTS[j]);
            carried += moments[j] * WEIGHTS[j];
            end += (by_q * q[j] + by_m * along(j, &moments)) * (self.h * WEIGHTS[j]);
        }
        // From the quaternion to the rotation vector at the end.
        let turned = right(&reached.q.conjugate()).fixed_rows::<3>(0) * end * 2.0;
        propagator.fixed_view_mut::<3, 9>(0, 3).copy_from(&position);
        propagator.fixed_view_mut::<3, 9>(3, 3).copy_from(&turned);
        propagator.fixed_view_mut::<3, 9>(6, 3).copy_from(&carried);
        propagator
    }
}

impl ShootingNode {
    /// Takes the step from arc length `from` to `to` through `properties(s)`.
    pub(crate) fn step(
        &self,
        from: f64,
        to: f64,
        properties: impl Fn(f64) -> Properties,
    ) -> Reached {
        GaussStep::new(self, from, to, properties).reached(self)
    }

    /// Takes the step and returns its derivatives too; `None` if it is too long for its equations
    /// to be solved.
    pub(crate) fn step_with_derivatives(
        &self,
        from: f64,
        to: f64,
        properties: impl Fn(f64) -> Properties,
    ) -> Option<(Reached, Propagator)> {
        let step = GaussStep::new(self, from, to, properties);
        let reached = step.reached(self);
        let by = step.propagator(self, &reached.node);
        step.converged.then_some((reached, by))
    }
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

    fn node() -> ShootingNode {
        ShootingNode {
            r: Vector3::new(0.1, 0.2, 0.3),
            q: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.5, 0.2)),
            m: Vector3::new(1.5, -0.8, 0.6),
            n: Vector3::new(-3.0, 2.0, 5.0),
        }
    }

    fn run(steps: u32) -> ShootingNode {
        let mut node = node();
        for i in 0..steps {
            let at = |i: u32| f64::from(i) / f64::from(steps);
            node = node.step(at(i), at(i + 1), properties).node;
        }
        node
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
        let step = node().step_with_derivatives(0.0, 0.05, properties);
        let (_, propagator) = step.expect("a short step");
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
