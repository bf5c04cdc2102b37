//! Loads of joints with other fibres in the equations of a step, and what they move.
//!
//! Such a load is a force like that of a segment: it acts at the end of the step, as the
//! acceleration there, and has no velocity of its own, unlike an impulse. Two fibres that share a
//! node by equal and opposite loads are then one fibre, whatever the method in time.

use super::array::{at, fit, get, set};
use super::attempt::BatchAttempts;
use super::scheme::StepProblem;
use super::simd_batch::SimdBatch;
use super::velocity_lanes::BatchVelocities;
use crate::{JointLoads, LoadPlace, LoadPoint};
use nalgebra::{DMatrix, UnitQuaternion, Vector3};
use pulp::bytemuck::Zeroable;
use pulp::{NullaryFnOnce, Simd};
use rapunzel_lanes::LANES;

/// Loads of joints on a batch.
pub(super) trait BatchJointLoads {
    /// Puts these loads in place of those before.
    fn set_joint_loads(&mut self, loads: JointLoads);
    /// Where the points are led by the step with the increments of the last linearisation, to first
    /// order: of nodes the displacement over the step, m, of segments the rotation by the
    /// increment, rad; world frame.
    fn linear_ways(&self, points: &[LoadPoint], ways: &mut [Vector3<f64>]);
    /// By fibre, the change of these ways by loads at its points, in the order of `points`: three
    /// rows and columns each, m or rad per N or N m, symmetric.
    fn load_responses(&mut self, points: &[LoadPoint]) -> Vec<DMatrix<f64>>;
    /// Changes the loads by these, and the increments of the last linearisation with them. The
    /// batch must hold its workspace.
    fn change_loads(&mut self, changes: JointLoads);
    /// Takes the increments of the last linearisation. Returns the largest increment of each lane,
    /// rad.
    fn take_increments(&mut self) -> [f64; LANES];
    /// Rotation of a segment where a step under way has been solved to.
    fn frame(&self, lane: usize, segment: usize) -> UnitQuaternion<f64>;
    /// Chooses the problem that a step in several calls solves.
    fn set_problem(&mut self, problem: StepProblem);
    /// Makes the accelerations that have been solved for those at the start, in lanes that are
    /// `done`, and goes back to the start.
    fn take_start(&mut self, done: &[bool; LANES]);
}

impl<S: Simd> BatchJointLoads for SimdBatch<S> {
    fn set_joint_loads(&mut self, JointLoads { points, loads }: JointLoads) {
        let n = self.chain.n;
        fit::<S>(&mut self.joint_forces, 3 * (n + 1));
        fit::<S>(&mut self.joint_changes, 3 * (n + 1));
        fit::<S>(&mut self.joint_moments, 3 * n);
        self.joint_forces.fill(S::f64s::zeroed());
        self.joint_changes.fill(S::f64s::zeroed());
        self.joint_moments.fill(S::f64s::zeroed());
        for (point, load) in points.iter().zip(loads) {
            let (array, index) = match point.place {
                LoadPlace::Node(node) => (&mut self.joint_forces, node as usize),
                LoadPlace::Segment(segment) => (&mut self.joint_moments, segment as usize),
            };
            add(array, index, point.fiber as usize, load);
        }
    }

    fn linear_ways(&self, points: &[LoadPoint], ways: &mut [Vector3<f64>]) {
        for (point, way) in points.iter().zip(ways) {
            let lane = point.fiber as usize;
            *way = match point.place {
                LoadPlace::Node(node) => self.linear_displacement(lane, node as usize),
                LoadPlace::Segment(segment) => {
                    self.vector(&self.chain.kept.step, 2 * segment as usize + 1, lane)
                }
            };
        }
    }

    fn load_responses(&mut self, points: &[LoadPoint]) -> Vec<DMatrix<f64>> {
        // Points of each fibre, from root to tip.
        let mut fibers: Vec<Vec<usize>> = vec![Vec::new(); S::F64_LANES];
        points.iter().enumerate().for_each(|(i, point)| fibers[point.fiber as usize].push(i));
        let mut all: Vec<_> =
            fibers.iter().map(|own| DMatrix::zeros(3 * own.len(), 3 * own.len())).collect();
        // Places of these in the matrices, sorted along the fibre.
        let orders: Vec<Vec<usize>> = fibers
            .iter()
            .map(|own| {
                let mut order: Vec<usize> = (0..own.len()).collect();
                order.sort_by_key(|&k| points[own[k]].first());
                order
            })
            .collect();
        let gains = self.accelerations_by_way();
        let mut columns = self.borrow_columns();
        let most = fibers.iter().map(Vec::len).max().unwrap_or(0);
        for turn in 0..most {
            let now: Vec<(usize, LoadPoint)> = orders
                .iter()
                .zip(&fibers)
                .enumerate()
                .filter_map(|(lane, (order, own))| order.get(turn).map(|&k| (lane, points[own[k]])))
                .collect();
            let from = now.iter().map(|(_, point)| point.first()).min().unwrap_or(0);
            // What lies before is read too, by the first segment that is solved for.
            columns.values[9 * from.saturating_sub(1)..].fill(S::f64s::zeroed());
            columns.turns[9 * from.saturating_sub(1)..].fill(S::f64s::zeroed());
            for (lane, point) in &now {
                let array = match point.place {
                    LoadPlace::Node(_) => &mut columns.values,
                    LoadPlace::Segment(_) => &mut columns.turns,
                };
                (0..3).for_each(|k| set(array, 9 * point.first() + 4 * k, *lane, 1.0));
            }
            self.respond_thrice(from, &mut columns);
            // Columns of this point in the rows of those behind it; the rest by symmetry.
            for (lane, matrix) in all.iter_mut().enumerate() {
                let (order, own) = (&orders[lane], &fibers[lane]);
                for row in turn..order.len() {
                    let point = points[own[order[row]]];
                    let array = match point.place {
                        LoadPlace::Node(_) => &columns.values,
                        LoadPlace::Segment(_) => &columns.turns,
                    };
                    for (k, i) in (0..9).map(|m| (m / 3, m % 3)) {
                        let answer = at(array, 9 * point.first() + 3 * k + i, lane) / gains[lane];
                        let (to, by) = (3 * order[row] + i, 3 * order[turn] + k);
                        matrix[(to, by)] = answer;
                        matrix[(by, to)] = answer;
                    }
                }
            }
        }
        self.chain.room.columns = columns;
        all
    }

    fn change_loads(&mut self, JointLoads { points, loads: changes }: JointLoads) {
        // As impulses and moments of impulses, which the response is made for.
        let (gains, dt) = (self.accelerations_by_way(), self.last_dt);
        let room = &mut self.chain.room;
        room.values.fill(S::f64s::zeroed());
        room.turns.fill(S::f64s::zeroed());
        for (point, change) in points.iter().zip(changes) {
            let (index, lane) = (point.first(), point.fiber as usize);
            if let LoadPlace::Node(_) = point.place {
                add(&mut self.joint_changes, index, lane, change);
            }
            let [load, known, impulse] = match point.place {
                LoadPlace::Node(_) => [&mut self.joint_forces, &mut room.b, &mut room.values],
                LoadPlace::Segment(_) => {
                    [&mut self.joint_moments, &mut room.torque, &mut room.turns]
                }
            };
            add(load, index, lane, change);
            add(known, index, lane, change);
            add(impulse, index, lane, &(change / (gains[lane] * dt[lane])));
        }
        struct ChangeLoads<'a, S: Simd>(&'a mut SimdBatch<S>);
        impl<S: Simd> NullaryFnOnce for ChangeLoads<'_, S> {
            type Output = ();
            #[inline(always)]
            fn call(self) {
                let stage = self.0.stage(&self.0.last_dt, self.0.problem);
                self.0.solve_increments(&stage);
                self.0.add_solution();
            }
        }
        self.chain.simd.vectorize(ChangeLoads(self));
    }

    fn take_increments(&mut self) -> [f64; LANES] {
        struct TakeIncrements<'a, S: Simd>(&'a mut SimdBatch<S>);
        impl<S: Simd> NullaryFnOnce for TakeIncrements<'_, S> {
            type Output = [f64; LANES];
            #[inline(always)]
            fn call(self) -> [f64; LANES] {
                self.0.take_step()
            }
        }
        self.joint_changes.fill(S::f64s::zeroed());
        self.chain.simd.vectorize(TakeIncrements(self))
    }

    fn frame(&self, lane: usize, segment: usize) -> UnitQuaternion<f64> {
        self.rotation(segment, lane)
    }

    fn set_problem(&mut self, problem: StepProblem) {
        self.problem = problem;
    }

    fn take_start(&mut self, done: &[bool; LANES]) {
        let dt = self.last_dt;
        self.commit(&dt, done, StepProblem::Start);
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Acceleration by displacement at the end of the step under way, by lane, 1/s^2.
    fn accelerations_by_way(&self) -> [f64; LANES] {
        let mut gains = [1.0; LANES];
        let stage = self.stage(&self.last_dt, self.problem);
        for (lane, gain) in gains.iter_mut().enumerate().take(S::F64_LANES) {
            *gain = get(stage.c1, lane);
        }
        gains
    }
}

/// Adds a vector to vector `i` of an array, in one lane.
fn add<T: pulp::bytemuck::Pod>(array: &mut [T], i: usize, lane: usize, v: &Vector3<f64>) {
    for k in 0..3 {
        let sum = at(array, 3 * i + k, lane) + v[k];
        set(array, 3 * i + k, lane, sum);
    }
}
