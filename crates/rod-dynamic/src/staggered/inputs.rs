//! Inputs of one lane of a batch: conditions, states, laws, loads.

use super::array::{self, at, set};
use super::ends::EndKind;
use super::scheme::Scheme;
use super::simd_batch::SimdBatch;
use super::supports::SupportLanes;
use crate::joint::Joint;
use crate::support::Restraints;
use crate::{End, EndSupport, Impulses, Instant, Load, Restraint, Rod, RodState};
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use pulp::Simd;
use rapunzel_fiber::so3;
use rapunzel_lanes::LANES;

/// Inputs of a batch, one lane at a time.
pub(super) trait BatchInputs {
    /// Sets boundary conditions, gravity, distributed force and air at the end of the lane's step.
    fn set_conditions(&mut self, lane: usize, now: &Instant);
    /// Starts the lane from `state`, whose arrays fit the rod. Positions follow from the frames,
    /// and the strains of the joints at the ends from the curvatures there; at an end that is not
    /// clamped the curvature is the natural one, and the strain vanishes.
    fn set_state(&mut self, lane: usize, rod: &Rod, state: &RodState);
    /// Replaces the lane's section laws by those of `rod`, which must have as much memory.
    fn set_laws(&mut self, lane: usize, rod: &Rod);
    /// Whether the method of the lane in the next step depends on the accelerations at its start.
    fn remembers(&self, lane: usize) -> bool;
    /// Lets the lane move by backward Euler, or by the method of what bears nothing if the batch
    /// has one, from the next step on.
    fn set_bearing(&mut self, lane: usize, bearing: bool);
    /// Takes the methods of the next step for those of the present one. Returns the lanes whose
    /// accelerations these depend on, though the last step did not write them.
    fn take_methods(&mut self) -> [bool; LANES];
    /// Sets the external force on a node, N, world frame.
    fn set_node_force(&mut self, lane: usize, node: usize, force: &Vector3<f64>);
    /// Sets the spring that holds a node until it is set again: its stiffness, N/m, and the place
    /// that it pulls to, m, world.
    fn set_node_spring(&mut self, lane: usize, node: usize, stiffness: f64, place: &Vector3<f64>);
    /// Puts impulses at the start of the step in place of those before; starting a new step clears
    /// them. A support takes up the impulse on the end that it holds.
    fn set_impulses(&mut self, impulses: Impulses);
}

impl<S: Simd> BatchInputs for SimdBatch<S> {
    fn set_conditions(&mut self, lane: usize, now: &Instant) {
        let (air, drag) = now.air.map_or_else(Default::default, |a| {
            (a.wind, [a.drag.normal, a.drag.normal - a.drag.tangential])
        });
        let numbers = now.gravity.iter().chain(&now.distributed).chain(&air).chain(&drag);
        for (i, x) in numbers.enumerate() {
            set(&mut self.fields, i, lane, *x);
        }
        self.set_nozzle(lane, now.inside);
        let n = self.chain.n;
        // A follower load turns with the end, half a segment from the frame of the last segment.
        let mut now = *now;
        now.root = ahead(&now.root, &-self.vector(&self.chain.model.rest, 0, lane));
        now.tip = ahead(&now.tip, &self.vector(&self.chain.model.rest, n, lane));
        let reaction = [0, 1, 2].map(|i| at(&self.chain.force, 3 * (self.chain.n - 1) + i, lane));
        self.held[lane] = self.chain.ends.set(lane, &now, reaction);
        self.chain.ends.any_root_free = self.held.iter().any(|h| h.root == EndKind::Loaded);
        self.set_supports(lane, &now);
        self.chain.ends.any_circulatory = self.held.iter().any(|h| !h.conservative);
    }

    fn set_state(&mut self, lane: usize, rod: &Rod, state: &RodState) {
        let n = self.chain.n;
        for array in self.arrays_mut() {
            for i in 0..array.len() {
                set(array, i, lane, 0.0);
            }
        }
        self.set_nozzle(lane, 0.0);
        let mut position = state.positions[0].coords;
        let mut before: Option<Rotation3<f64>> = None;
        for a in 0..=n {
            for i in 0..3 {
                set(&mut self.chain.start, 3 * a + i, lane, position[i]);
                set(&mut self.nodes.v, 3 * a + i, lane, state.velocities[a][i]);
            }
            if a == n {
                break;
            }
            let frame = so3::quaternion(&state.frames[a]);
            let coordinates = frame.coords;
            for i in 0..4 {
                set(&mut self.chain.q, 4 * a + i, lane, coordinates[i]);
            }
            let matrix: Matrix3<f64> = frame.to_rotation_matrix().into_inner();
            let rates = matrix * so3::hat(&state.angular_velocities[a]);
            let spin = Vector3::new(state.angular_velocities[a].z, 0.0, 0.0);
            let columns = [0, 1, 2].map(|k| rates.column(k).into_owned());
            let [first, second] =
                if self.chain.spins { [columns[2], spin] } else { [columns[0], columns[1]] };
            for (k, rate) in [first, second].into_iter().enumerate() {
                for i in 0..3 {
                    set(&mut self.directors.v, 3 * (2 * a + k) + i, lane, rate[i]);
                }
            }
            position += matrix.column(2) * at(&self.chain.model.h, a, lane);
            let frame = Rotation3::from_matrix_unchecked(matrix);
            if let Some(before) = before {
                let turn = so3::log(&(before.inverse() * frame));
                self.set_turn(lane, a, &turn);
            }
            before = Some(frame);
        }
        self.chain.ends.join(lane);
        for j in [0, n] {
            let strain = state.curvatures[j] - rod.fiber.nodes()[j].natural_curvature;
            let turn = self.vector(&self.chain.model.rest, j, lane)
                + strain * Joint::new(&rod.fiber, j).length;
            self.set_turn(lane, j, &turn);
        }
        self.strain_laws_at_once(lane);
    }

    fn set_laws(&mut self, lane: usize, rod: &Rod) {
        self.chain.laws.iter_mut().for_each(|laws| laws.replace(lane, rod));
    }

    fn remembers(&self, lane: usize) -> bool {
        self.next_schemes[lane].remembers()
    }

    fn set_bearing(&mut self, lane: usize, bearing: bool) {
        if let Some(flight) = self.flight {
            self.next_schemes[lane] = if bearing { Scheme::backward_euler() } else { flight };
        }
    }

    fn take_methods(&mut self) -> [bool; LANES] {
        let before = std::mem::replace(&mut self.schemes, self.next_schemes);
        let takes_off = |lane: usize| !before[lane].remembers() && self.remembers(lane);
        std::array::from_fn(|lane| !self.knows_accelerations && takes_off(lane))
    }

    fn set_node_force(&mut self, lane: usize, node: usize, force: &Vector3<f64>) {
        array::fit::<S>(&mut self.node_forces, 3 * (self.chain.n + 1));
        for i in 0..3 {
            set(&mut self.node_forces, 3 * node + i, lane, force[i]);
        }
    }

    fn set_node_spring(&mut self, lane: usize, node: usize, stiffness: f64, place: &Vector3<f64>) {
        let nodes = self.chain.n + 1;
        let [stiffnesses, places] = &mut self.springs;
        array::fit::<S>(stiffnesses, nodes);
        array::fit::<S>(places, 3 * nodes);
        set(stiffnesses, node, lane, stiffness);
        for i in 0..3 {
            set(places, 3 * node + i, lane, place[i]);
        }
    }

    fn set_impulses(&mut self, impulses: Impulses) {
        self.put_impulses(impulses);
    }
}

impl<S: Simd> SimdBatch<S> {
    /// Sets the supports of the ends of one lane, and where the frame of a supported end starts: as
    /// it lies on the half segment at that end, but for what is held.
    fn set_supports(&mut self, lane: usize, now: &Instant) {
        let ends = [&now.root, &now.tip].map(|end| match end {
            End::Supported(support) => Some(support),
            _ => None,
        });
        // A free root beside a tip that is held follows from the reaction there.
        let hangs =
            matches!(now.root, End::Loaded { .. }) && !matches!(now.tip, End::Loaded { .. });
        let needed = hangs || ends.iter().any(Option::is_some);
        if !needed && self.chain.supports.is_none() {
            return;
        }
        let loose = EndSupport {
            pose: Isometry3::identity(),
            axes: UnitQuaternion::identity(),
            translations: [Restraint::Free; 3],
            rotations: [Restraint::Free; 3],
            force: Load::ZERO,
            moment: Load::ZERO,
        };
        let ends = [ends[0].or(hangs.then_some(&loose)), ends[1]];
        let frames = [0, 1].map(|k| self.end_frame(lane, k, [&now.root, &now.tip][k]));
        let supports =
            self.chain.supports.get_or_insert_with(|| Box::new([SupportLanes::none(); 2]));
        for (k, support) in ends.into_iter().enumerate() {
            supports[k].set(lane, support, hangs && k == 0);
            let Some(frame) = frames[k] else { continue };
            let own = &mut self.chain.ends;
            let array = if k == 0 { &mut own.root_frame } else { &mut own.tip_frame };
            for (i, x) in frame.into_iter().enumerate() {
                set(array, i, lane, x);
            }
        }
    }

    /// Frame of the end `k` (0 for the root) at the start of the step as a quaternion, if its
    /// support leaves that partly free.
    pub(super) fn end_frame(&self, lane: usize, k: usize, end: &End) -> Option<[f64; 4]> {
        let End::Supported(support) = end else { return None };
        if Restraints::of(&support.rotations) != Restraints::Mixed {
            return None;
        }
        let (segment, joint, sign) =
            if k == 0 { (0, 0, -1.0) } else { (self.chain.n - 1, self.chain.n, 1.0) };
        let turn = so3::exp(&(sign * self.vector(&self.phi, joint, lane)));
        let frame = self.rotation(segment, lane) * so3::quaternion(&turn);
        Some(support.nearest(&frame).coords.into())
    }

    fn set_turn(&mut self, lane: usize, joint: usize, turn: &Vector3<f64>) {
        for i in 0..3 {
            set(&mut self.phi, 3 * joint + i, lane, turn[i]);
        }
    }
}

/// An end with its follower loads in the frame of the adjoining segment, from which the frame of
/// the end is rotated by `turn` where no moment bends it further.
pub(super) fn ahead(end: &End, turn: &Vector3<f64>) -> End {
    let moved = |load: &Load| match load {
        Load::Follower(v) => Load::Follower(so3::exp(turn) * v),
        Load::World(_) => *load,
    };
    match end {
        End::Loaded { force, moment } => End::Loaded { force: moved(force), moment: moved(moment) },
        End::Supported(support) => {
            // The moment on a frame that is unknown follows that frame itself.
            let free = Restraints::of(&support.rotations) == Restraints::Free;
            let moment = if free { moved(&support.moment) } else { support.moment };
            End::Supported(EndSupport { force: moved(&support.force), moment, ..*support })
        }
        _ => *end,
    }
}
