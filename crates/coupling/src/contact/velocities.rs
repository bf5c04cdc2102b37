use super::node_arrays::FiberVelocities;
use super::system::CoupledSystem;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use crate::object::ObjectMotion;
use nalgebra::Vector3;
use rapunzel_contact::RigidBody;
use rapunzel_fiber::Layout;

/// How fast all fibres and objects are.
pub(super) struct Velocities<'a> {
    layout: &'a Layout,
    fibers: &'a FiberVelocities,
    /// Velocities of the centers of mass, m/s, and about them, rad/s; zero for given motions.
    objects: Vec<[Vector3<f64>; 2]>,
}

impl<'a> Velocities<'a> {
    /// Given velocities of fibres, and of objects as they have been solved so far.
    pub(super) fn new(system: &'a CoupledSystem<'_>, fibers: &'a FiberVelocities) -> Self {
        Self::of(system, fibers, |[_, solved]| solved)
    }

    /// Given velocities of fibres, and of objects at the start of the step.
    pub(super) fn before(system: &'a CoupledSystem<'_>, fibers: &'a FiberVelocities) -> Self {
        Self::of(system, fibers, |[state, _]| state)
    }

    fn of(
        system: &'a CoupledSystem<'_>,
        fibers: &'a FiberVelocities,
        chosen: impl Fn([&'a RigidBody; 2]) -> &'a RigidBody,
    ) -> Self {
        let objects = system.objects.iter().map(|object| match &object.motion {
            ObjectMotion::Dynamic(body) => {
                let [state, _] = body.bodies();
                let moving = chosen(body.bodies());
                // With the inertia at the start of the step, as the solver has it.
                [moving.velocity, state.inverse_inertia() * moving.angular_momentum]
            }
            ObjectMotion::Kinematic(_) => [Vector3::zeros(); 2],
        });
        Self { layout: system.fibers.assembly().layout(), fibers, objects: objects.collect() }
    }

    /// Velocities of all nodes, m/s.
    pub(super) fn nodes(&self) -> &'a [Vector3<f64>] {
        &self.fibers.nodes
    }

    /// Velocity of a side of a contact point, m/s; zero for an object with a given motion.
    pub(super) fn of_side(&self, point: &ContactPoint, side: usize) -> Vector3<f64> {
        match point.sides[side] {
            BodyRef::Fiber(fiber) => {
                let (fiber, segment) = (fiber as usize, point.segments[side] as usize);
                let (nodes, spins) = (&self.fibers.nodes, &self.fibers.spins);
                let node = self.layout.node_range(fiber).start + segment;
                let spin = spins[self.layout.segment_range(fiber).start + segment];
                let of_axis = nodes[node].lerp(&nodes[node + 1], point.fractions[side]);
                of_axis + spin.cross(&point.lever(side))
            }
            BodyRef::Object(object) => {
                let [velocity, omega] = self.objects[object as usize];
                velocity + omega.cross(&point.lever(side))
            }
        }
    }

    /// Angular velocity of a side of a contact point, rad/s; zero for an object with a given
    /// motion.
    pub(super) fn spin_of_side(&self, point: &ContactPoint, side: usize) -> Vector3<f64> {
        match point.sides[side] {
            BodyRef::Fiber(fiber) => {
                let first = self.layout.segment_range(fiber as usize).start;
                self.fibers.spins[first + point.segments[side] as usize]
            }
            BodyRef::Object(object) => self.objects[object as usize][1],
        }
    }

    /// Velocity of the first side of a contact point as seen from the second, m/s.
    pub(super) fn between(&self, point: &ContactPoint) -> Vector3<f64> {
        self.of_side(point, 0) - self.of_side(point, 1)
    }
}
