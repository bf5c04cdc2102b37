use super::space::{flat, in_world, spatial};
use super::strands::{Polyline, places, polylines, strand, surface};
use crate::NodePull;
use crate::scene::{Hold, Integrator, MassSpring, NodeLoad};
use crate::stepper::ContactForce;
use nalgebra::{Point3, SVector, Vector3};
use rapunzel_collision::field::HalfSpace;
use rapunzel_coupling::CollisionObject;
use rapunzel_coupling::TimeInterval;
use rapunzel_export::{Strand, usd};
use rapunzel_mass_spring::{
    Contacts, Enclosure, ImplicitEuler, Leapfrog, NodeVectors, Obstacle, RigidChain, SpringError,
    StepTooLong, System, Touched, runge_kutta,
};
use rapunzel_rod_dynamic::Energy;
use std::collections::BTreeMap;

/// A mass-spring system of any dimension in the world.
pub(crate) trait ErasedSystem: Send + Sync {
    /// Moves it by a step among objects, and returns the iterations of Newton's
    /// method.
    fn step(
        &mut self,
        step: TimeInterval,
        gravity: &Vector3<f64>,
        objects: &[CollisionObject],
    ) -> Result<usize, SpringError>;
    /// Number of nodes.
    fn nodes(&self) -> usize;
    /// Position and velocity of a node (world).
    fn node(&self, node: usize) -> (Point3<f64>, Vector3<f64>);
    /// Energy in a gravity.
    fn energy(&self, gravity: &Vector3<f64>) -> Energy;
    /// Springs as lines.
    fn strands(&self) -> Vec<Strand>;
    /// Appends the points of these lines, m.
    fn points(&self, into: &mut Vec<Point3<f64>>);
    /// What it is bounded by, of points of these lines, if it has a surface.
    fn surface(&self) -> Option<usd::PrimShape>;
    /// In which of these lines every node is, and where in it.
    fn places(&self) -> BTreeMap<usize, [usize; 2]>;
    /// The node that a point of a line is.
    fn node_of(&self, line: usize, point: usize) -> usize;
    /// Lets hands pull at nodes, in place of those before.
    fn pull(&mut self, pulls: &[NodePull]) -> Result<(), SpringError>;
    /// Adds a hold to those of the scene.
    fn hold(&mut self, hold: Hold) -> Result<(), SpringError>;
    /// Whether something holds a node now.
    fn is_held(&self, node: usize) -> bool;
    /// Where nodes touched in the last step, and with what force.
    fn touches(&self) -> Vec<ContactForce>;
    /// Energy of the loads (J), which is not in that of the system; power that is dissipated and
    /// power of the supports (W), by which the sum of both changes; wind (world, m/s), and area or
    /// volume now and at rest.
    fn readings(&self) -> Vec<f64>;
    /// All numbers that change.
    fn save(&self) -> Vec<f64>;
    /// Goes back to saved numbers; false if they are those of another system.
    fn restore(&mut self, numbers: &[f64]) -> bool;
    /// Whether steps of `dt` are too long for the integrator.
    fn warning(&self, dt: f64) -> Option<StepTooLong>;
}

/// What is needed to move a system.
pub(crate) struct MovingSystem<const D: usize> {
    system: System<D>,
    method: SpringIntegrator<D>,
    substeps: usize,
    holds: Vec<Hold>,
    /// Of the scene.
    loads: Vec<NodeLoad>,
    /// Nodes at which hands pull.
    pulled: Vec<usize>,
    contacts: Option<Contacts>,
    /// Where nodes touched in the last step, and the sum of impulses on the first, N s.
    touched: BTreeMap<(usize, Touched), (Point3<f64>, Vector3<f64>)>,
    /// Length of that step, s.
    touched_for: f64,
    ground: Option<HalfSpace>,
    enclosure: Option<Enclosure<D>>,
    yields: bool,
    lines: Vec<Polyline>,
    /// Nodes of the faces.
    faces: Vec<Vec<usize>>,
    /// With which lines are drawn, m.
    radius: f64,
}

enum SpringIntegrator<const D: usize> {
    Chain(RigidChain),
    Leapfrog(Leapfrog<D>),
    RungeKutta,
    ImplicitEuler(ImplicitEuler),
}

/// Lines without contacts are drawn with this part of the mean rest length as their radius.
const DRAWN: f64 = 0.03;

impl<const D: usize> MovingSystem<D> {
    pub(crate) fn new(
        scene: &MassSpring,
        system: System<D>,
        faces: Vec<Vec<usize>>,
        enclosure: Option<Enclosure<D>>,
        contacts: Option<Contacts>,
        chain: bool,
    ) -> Self {
        let method = match scene.integrator {
            _ if chain => SpringIntegrator::Chain(RigidChain::new()),
            Integrator::Leapfrog => SpringIntegrator::Leapfrog(Leapfrog::new()),
            Integrator::RungeKutta => SpringIntegrator::RungeKutta,
            Integrator::ImplicitEuler => SpringIntegrator::ImplicitEuler(ImplicitEuler::default()),
        };
        let springs = system.springs();
        let mean = (0..springs).map(|s| system.spring(s).rest_length).sum::<f64>() / springs as f64;
        let ground = scene.contacts.as_ref().and_then(|contacts| contacts.ground);
        let ground = ground
            .map(|z| HalfSpace { point: Point3::new(0.0, 0.0, z), normal: Vector3::z_axis() });
        let lines = polylines((0..springs).map(|s| system.spring(s).nodes));
        Self {
            system,
            method,
            substeps: scene.substeps,
            holds: scene.holds.clone(),
            loads: scene.loads.clone(),
            pulled: Vec::new(),
            contacts,
            touched: BTreeMap::new(),
            touched_for: 1.0,
            ground,
            enclosure,
            yields: scene.yield_strain.is_some(),
            lines,
            faces,
            radius: DRAWN * mean,
        }
    }

    /// Takes, moves and lets go of nodes as it is time to, each by the last of its holds; doing so
    /// again changes nothing.
    fn apply_holds(&mut self, time: f64) -> Result<(), SpringError> {
        let begun = self.holds.iter().filter(|hold| time >= hold.from);
        let last: BTreeMap<usize, &Hold> = begun.map(|hold| (hold.node, hold)).collect();
        for hold in last.into_values() {
            if time < hold.until {
                self.system.hold(hold.node, flat(&hold.velocity))?;
            } else if hold.release {
                self.system.release(hold.node)?;
            } else {
                self.system.pin(hold.node)?;
            }
        }
        Ok(())
    }
}

/// An error of a call after `done` sub-steps, with the sub-step counted from the first.
fn after(done: usize, error: SpringError) -> SpringError {
    match error {
        SpringError::BlownUp { step, node } => SpringError::BlownUp { step: done + step, node },
        error => error,
    }
}

impl<const D: usize> ErasedSystem for MovingSystem<D>
where
    Enclosure<D>: Send + Sync,
{
    fn step(
        &mut self,
        step: TimeInterval,
        gravity: &Vector3<f64>,
        objects: &[CollisionObject],
    ) -> Result<usize, SpringError> {
        let TimeInterval { start: time, length: dt } = step;
        (self.touched, self.touched_for) = (BTreeMap::new(), dt);
        self.apply_holds(time)?;
        self.system.set_time(time);
        self.system.set_gravity(flat(&(*gravity).into()))?;
        let dt = dt / self.substeps as f64;
        // Contacts and yielding come after every sub-step; without them all go through at once.
        let together = self.contacts.is_none() && !self.yields;
        let (rounds, steps) = if together { (1, self.substeps) } else { (self.substeps, 1) };
        let mut iterations = 0;
        for round in 0..rounds {
            let system = &mut self.system;
            let start = system.time();
            match &mut self.method {
                SpringIntegrator::Chain(chain) => chain.advance(system, dt, steps),
                SpringIntegrator::Leapfrog(leapfrog) => leapfrog.advance(system, dt, steps),
                SpringIntegrator::RungeKutta => runge_kutta(system, dt, steps),
                SpringIntegrator::ImplicitEuler(euler) => (0..steps).try_for_each(|step| {
                    iterations += euler.step(system, dt).map_err(|e| after(step, e))?;
                    Ok(())
                }),
            }
            .map_err(|e| after(round, e))?;
            if let Some(contacts) = &mut self.contacts {
                let objects = objects.iter().map(|object| {
                    let poses = object.poses(TimeInterval { start, length: dt });
                    Obstacle { field: &**object.field(), poses, dt }
                });
                let obstacles: Vec<_> =
                    self.ground.iter().map(|g| Obstacle::at_rest(g)).chain(objects).collect();
                contacts.resolve(system, &obstacles)?;
                for touch in contacts.touches() {
                    let sum = self.touched.entry((touch.node, touch.touched));
                    let (place, impulse) = sum.or_default();
                    (*place, *impulse) = (touch.place, *impulse + touch.impulse);
                }
            }
            if self.yields {
                system.give_way();
            }
        }
        if let Some(enclosure) = &self.enclosure {
            enclosure.control(&mut self.system)?;
        }
        Ok(iterations)
    }

    fn nodes(&self) -> usize {
        self.system.nodes()
    }

    fn node(&self, node: usize) -> (Point3<f64>, Vector3<f64>) {
        (in_world(&self.system.position(node)), spatial(&self.system.velocity(node)))
    }

    fn energy(&self, gravity: &Vector3<f64>) -> Energy {
        let energy = self.system.energy();
        let weight = |node| self.system.masses()[node] * gravity.dot(&self.node(node).0.coords);
        Energy {
            kinetic: energy.kinetic,
            elastic: energy.elastic,
            gravitational: -(0..self.nodes()).map(weight).sum::<f64>(),
        }
    }

    fn strands(&self) -> Vec<Strand> {
        let force = |s| spatial(&self.system.spring_force(s));
        self.lines.iter().map(|line| strand(line, |n| self.node(n), force, self.radius)).collect()
    }

    fn points(&self, into: &mut Vec<Point3<f64>>) {
        let nodes = self.lines.iter().flat_map(Polyline::nodes);
        into.extend(nodes.map(|node| in_world(&self.system.position(*node))));
    }

    fn surface(&self) -> Option<usd::PrimShape> {
        surface(&self.places(), &self.faces)
    }

    fn places(&self) -> BTreeMap<usize, [usize; 2]> {
        places(&self.lines)
    }

    fn node_of(&self, line: usize, point: usize) -> usize {
        self.lines[line].node(point)
    }

    fn pull(&mut self, pulls: &[NodePull]) -> Result<(), SpringError> {
        let pulled = pulls.iter().map(|pull| pull.node).collect();
        let before = std::mem::replace(&mut self.pulled, pulled);
        for node in before.into_iter().chain(self.pulled.iter().copied()) {
            let own = self.loads.iter().rfind(|load| load.node == node);
            let own = own.map_or_else(Vector3::zeros, |load| Vector3::from(load.force));
            let of = pulls.iter().filter(|pull| pull.node == node);
            let sum = of.fold(own, |sum, pull| sum + pull.force);
            self.system.set_load(node, flat(&sum.into()))?;
        }
        Ok(())
    }

    fn hold(&mut self, hold: Hold) -> Result<(), SpringError> {
        // Only to find out whether there is such a node.
        self.system.clone().pin(hold.node)?;
        self.holds.push(hold);
        Ok(())
    }

    fn is_held(&self, node: usize) -> bool {
        self.system.is_held(node)
    }

    fn touches(&self) -> Vec<ContactForce> {
        let bear = self.touched.values().filter(|(_, impulse)| impulse.norm() > 0.0);
        bear.map(|(place, sum)| ContactForce { place: *place, force: sum / self.touched_for })
            .collect()
    }

    fn readings(&self) -> Vec<f64> {
        let mut supports = self.system.support_power();
        if let SpringIntegrator::Chain(chain) = &self.method {
            supports += chain.support_power(&self.system);
        }
        let mut numbers = vec![self.system.energy().load, self.system.dissipation(), supports];
        numbers.extend(spatial(&self.system.wind()).iter());
        if let Some(enclosure) = &self.enclosure {
            numbers.extend([enclosure.measure(&self.system), enclosure.rest_measure()]);
        }
        numbers
    }

    fn save(&self) -> Vec<f64> {
        let (x, v) = (self.system.positions(), self.system.velocities());
        let nodes = (0..self.nodes()).flat_map(|n| [x.get(n), v.get(n)]);
        let mut numbers: Vec<f64> = nodes.flat_map(|vector| vector.data.0[0]).collect();
        numbers.extend((0..self.system.springs()).map(|s| self.system.spring(s).rest_length));
        numbers
    }

    fn restore(&mut self, numbers: &[f64]) -> bool {
        let (nodes, springs) = (self.nodes(), self.system.springs());
        if numbers.len() != 2 * D * nodes + springs {
            return false;
        }
        let (vectors, lengths) = numbers.split_at(2 * D * nodes);
        let (mut x, mut v) = (NodeVectors::zeros(nodes), NodeVectors::zeros(nodes));
        for (node, both) in vectors.chunks_exact(2 * D).enumerate() {
            x.set(node, &SVector::from_column_slice(&both[..D]));
            v.set(node, &SVector::from_column_slice(&both[D..]));
        }
        let restored = self.system.set_state(&x, &v).is_ok();
        restored && self.system.set_rest_lengths(lengths.iter().copied().enumerate()).is_ok()
    }

    fn warning(&self, dt: f64) -> Option<StepTooLong> {
        let dt = dt / self.substeps as f64;
        match self.method {
            SpringIntegrator::Leapfrog(_) => self.system.warn_of_step(dt),
            SpringIntegrator::RungeKutta => self.system.warn_of_runge_kutta_step(dt),
            // A chain has no stiff springs.
            SpringIntegrator::ImplicitEuler(_) | SpringIntegrator::Chain(_) => None,
        }
    }
}
