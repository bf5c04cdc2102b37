use crate::error::non_negative;
use crate::supports::Guide;
use crate::{SpringError, System};
use nalgebra::{Point3, SVector, Vector3};
use rapunzel_collision::field::{DistanceField, Sample};
use rapunzel_collision::{Candidates, Capsules};
use rapunzel_fiber::Layout;
use std::collections::BTreeSet;

/// What nodes do when they meet surfaces or each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Radius of the nodes, m.
    pub radius: f64,
    /// Part of the normal velocity that comes back, 0 to 1.
    pub restitution: f64,
    /// Coulomb's coefficient of friction.
    pub friction: f64,
}

/// Contacts of nodes as balls, after every step: velocities change by impulses, positions are moved
/// out of what they are in.
///
/// Nodes on supports do not yield. Nodes that share a spring do not touch each other. In the plane
/// the world is that with z = 0.
pub struct Contacts {
    surface: Surface,
    obstacles: Vec<Box<dyn DistanceField + Send>>,
    mutual: Option<Mutual>,
}

/// The search for nodes that touch each other.
struct Mutual {
    layout: Layout,
    radii: Vec<f64>,
    /// Every node twice: a segment of no length.
    positions: Vec<Point3<f64>>,
    candidates: Candidates,
    connected: BTreeSet<[usize; 2]>,
}

impl Contacts {
    /// Contacts with obstacles, and with each other if `mutual`.
    ///
    /// # Errors
    /// [`SpringError::Parameter`].
    pub fn new<const D: usize>(
        system: &System<D>,
        surface: Surface,
        obstacles: Vec<Box<dyn DistanceField + Send>>,
        mutual: bool,
    ) -> Result<Self, SpringError> {
        non_negative("the radius of the nodes (m)", surface.radius)?;
        non_negative("the friction of the nodes", surface.friction)?;
        if !(0.0..=1.0).contains(&surface.restitution) {
            let (what, value) = ("the restitution of the nodes", surface.restitution);
            return Err(SpringError::Parameter { what, value, allowed: "between 0 and 1" });
        }
        let mutual = if mutual {
            crate::error::positive(
                "the radius of nodes that touch each other (m)",
                surface.radius,
            )?;
            Some(Mutual::new(system, surface.radius)?)
        } else {
            None
        };
        Ok(Self { surface, obstacles, mutual })
    }

    /// Resolves all contacts of the present state and returns how many there were. Call it after
    /// every step.
    ///
    /// # Errors
    /// [`SpringError::Collision`] if positions are not finite.
    pub fn resolve<const D: usize>(
        &mut self,
        system: &mut System<D>,
    ) -> Result<usize, SpringError> {
        let mut count = 0;
        if let Some(mutual) = &mut self.mutual {
            count += mutual.resolve(system, &self.surface)?;
        }
        for obstacle in &self.obstacles {
            for node in 0..system.nodes() {
                let Sample { value, gradient } = obstacle.sample(&in_space(system, node));
                let gap = value - self.surface.radius;
                let normal = SVector::<f64, D>::from_fn(|axis, _| {
                    gradient.get(axis).copied().unwrap_or(0.0)
                });
                if gap < 0.0 && normal.norm_squared() > 0.0 && yields(system, node) {
                    let normal = normal.normalize();
                    let velocity = system.velocities.get(node);
                    let change = self.surface.change(&velocity, &normal);
                    system.velocities.add(node, &change);
                    system.positions.add(node, &(normal * -gap));
                    count += 1;
                }
            }
        }
        Ok(count)
    }
}

impl Surface {
    /// The change of a velocity relative to a surface with a normal that points out of it.
    fn change<const D: usize>(
        &self,
        velocity: &SVector<f64, D>,
        normal: &SVector<f64, D>,
    ) -> SVector<f64, D> {
        let approach = -velocity.dot(normal);
        if approach <= 0.0 {
            return SVector::zeros();
        }
        let pressed = (1.0 + self.restitution) * approach;
        let sliding = velocity + normal * approach;
        let speed = sliding.norm();
        let rubbed = if speed > 0.0 { (self.friction * pressed / speed).min(1.0) } else { 0.0 };
        normal * pressed - sliding * rubbed
    }
}

fn in_space<const D: usize>(system: &System<D>, node: usize) -> Point3<f64> {
    let position = system.positions.get(node);
    Vector3::from_fn(|axis, _| position.get(axis).copied().unwrap_or(0.0)).into()
}

fn yields<const D: usize>(system: &System<D>, node: usize) -> bool {
    (0..D).all(|axis| system.supports.guide(node, axis) == Guide::Free)
}

impl Mutual {
    fn new<const D: usize>(system: &System<D>, radius: f64) -> Result<Self, SpringError> {
        let sorted = |&[i, j]: &[usize; 2]| [i.min(j), i.max(j)];
        Ok(Self {
            layout: Layout::new(vec![1; system.nodes()]),
            radii: vec![radius; system.nodes()],
            positions: Vec::new(),
            candidates: Candidates::new(0.0, radius)?,
            connected: system.springs.nodes.iter().map(sorted).collect(),
        })
    }

    fn resolve<const D: usize>(
        &mut self,
        system: &mut System<D>,
        surface: &Surface,
    ) -> Result<usize, SpringError> {
        self.positions.clear();
        self.positions.extend((0..system.nodes()).flat_map(|node| [in_space(system, node); 2]));
        self.candidates.update(&Capsules::new(&self.layout, &self.positions, &self.radii)?)?;
        // Which nodes touch is settled before any moves, and they come in order, so that the result
        // does not depend on when the list of candidates was made.
        let gap = |system: &System<D>, [i, j]: [usize; 2]| {
            (system.positions.get(j) - system.positions.get(i)).norm() - 2.0 * surface.radius
        };
        let pairs = self.candidates.pairs().iter().map(|pair| pair.map(|node| node as usize));
        let mut touching: Vec<_> = pairs
            .map(|[i, j]| [i.min(j), i.max(j)])
            .filter(|&pair| gap(system, pair) < 0.0 && !self.connected.contains(&pair))
            .collect();
        touching.sort_unstable();
        let mut count = 0;
        for [i, j] in touching {
            let apart = system.positions.get(j) - system.positions.get(i);
            let distance = apart.norm();
            let gap = (distance - 2.0 * surface.radius).min(0.0);
            if distance == 0.0 {
                continue;
            }
            let weight =
                |node| if yields(system, node) { system.inverse_masses[node] } else { 0.0 };
            let [first, second] = [weight(i), weight(j)];
            let both = first + second;
            if both == 0.0 {
                continue;
            }
            let normal = apart / distance;
            let velocity = system.velocities.get(j) - system.velocities.get(i);
            let change = surface.change(&velocity, &normal) / both;
            let shift = normal * (-gap / both);
            system.velocities.add(i, &(change * -first));
            system.velocities.add(j, &(change * second));
            system.positions.add(i, &(shift * -first));
            system.positions.add(j, &(shift * second));
            count += 1;
        }
        Ok(count)
    }
}
