use crate::error::finite;
use crate::error::{non_negative, positive};
use crate::{Obstacle, SpringError, System};
use nalgebra::{Point3, SVector, Vector3};
use rapunzel_collision::{Candidates, Capsules};
use rapunzel_fiber::Layout;
use std::collections::BTreeSet;

/// Contact parameters of nodes with surfaces and with each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Radius of the nodes, m.
    pub radius: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// Coulomb's coefficient of friction.
    pub friction: f64,
}

/// What a node touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Touched {
    /// Another node.
    Node(usize),
    /// An obstacle, by its place in the list.
    Obstacle(usize),
}

/// A contact that was resolved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeTouch {
    /// The node; of two the one with the smaller number.
    pub node: usize,
    /// What it touches.
    pub touched: Touched,
    /// Where, m, world: on the surface of the obstacle, or midway between the nodes.
    pub place: Point3<f64>,
    /// Impulse on the node, N s, world.
    pub impulse: Vector3<f64>,
}

/// Contacts of nodes as balls, resolved after every step: velocities change by impulses, and
/// positions are moved out of penetration.
///
/// Nodes yield as far as their supports let them: a guided node along its guide, tied nodes
/// together, a held one not at all. There is no contact between nodes that share a spring; two
/// nodes at the same point are separated along an axis. For a system in the plane, the second axis
/// is the world's third.
pub struct Contacts {
    surface: Surface,
    mutual: Option<Mutual>,
    touches: Vec<NodeTouch>,
}

/// Search for contacts among nodes.
struct Mutual {
    layout: Layout,
    radii: Vec<f64>,
    /// Positions of the nodes, each twice: a segment of no length.
    positions: Vec<Point3<f64>>,
    candidates: Candidates,
    connected: BTreeSet<[usize; 2]>,
}

/// Least squared cosine between a guide and a contact normal; below it the node does not yield,
/// since it would be thrown far along its guide.
const LEAST_LEAN: f64 = 1e-6;

impl Contacts {
    /// Contacts with obstacles, and among nodes if `mutual`.
    ///
    /// # Errors
    /// [`SpringError::Parameter`].
    pub fn new<const D: usize>(
        system: &System<D>,
        surface: Surface,
        mutual: bool,
    ) -> Result<Self, SpringError> {
        non_negative("the radius of the nodes (m)", surface.radius)?;
        non_negative("the friction of the nodes", surface.friction)?;
        if !(0.0..=1.0).contains(&surface.restitution) {
            let (what, value) = ("the restitution of the nodes", surface.restitution);
            return Err(SpringError::Parameter { what, value, allowed: "between 0 and 1" });
        }
        let mutual = if mutual {
            positive("the radius of nodes that touch each other (m)", surface.radius)?;
            Some(Mutual::new(system, surface.radius)?)
        } else {
            None
        };
        Ok(Self { surface, mutual, touches: Vec::new() })
    }

    /// Resolves all contacts of the present state, among nodes and then with one obstacle after the
    /// other, and returns how many there were. To be called after every step; an obstacle that a
    /// node crosses within one step is not detected.
    ///
    /// # Errors
    /// [`SpringError::Collision`] if positions are not finite; [`SpringError::Parameter`] if the
    /// motion of an obstacle is not; [`SpringError::Count`] in more than three dimensions.
    pub fn resolve<const D: usize>(
        &mut self,
        system: &mut System<D>,
        obstacles: &[Obstacle<'_>],
    ) -> Result<usize, SpringError> {
        if D > 3 {
            let expected = "at most the three of the world".to_owned();
            return Err(SpringError::Count { what: "dimensions", found: D, expected });
        }
        self.touches.clear();
        if let Some(mutual) = &mut self.mutual {
            mutual.resolve(system, &self.surface, &mut self.touches)?;
        }
        for (index, obstacle) in obstacles.iter().enumerate() {
            for node in 0..system.nodes() {
                let place = in_world(&system.positions.get(node));
                let touch = obstacle.touch(&place);
                let gap = touch.value - self.surface.radius;
                let normal: SVector<f64, D> = of_world(&touch.gradient);
                if gap < 0.0 && normal.norm_squared() > 0.0 {
                    let normal = normal.normalize();
                    let away = of_world(&obstacle.velocity(&place));
                    finite("the velocity of an obstacle (m/s)", &away)?;
                    let yielding = system.yielding(node);
                    let velocity = system.velocities.get(node) - away;
                    let Some(lean) = lean(&normal, &yielding) else { continue };
                    let impulse = self.surface.impulse(&velocity, &normal, &yielding);
                    system.impel(node, &impulse);
                    system.shift(node, &(normal * (-gap / lean)));
                    self.touches.push(NodeTouch {
                        node,
                        touched: Touched::Obstacle(index),
                        place: place - in_world(&normal).coords * touch.value,
                        impulse: in_world(&impulse).coords,
                    });
                }
            }
        }
        Ok(self.touches.len())
    }

    /// The contacts that were resolved last: those among nodes, then those with one obstacle after
    /// the other.
    #[must_use]
    pub fn touches(&self) -> &[NodeTouch] {
        &self.touches
    }
}

impl Surface {
    /// Impulse at a contact with the outward normal of a surface, for a velocity relative to the
    /// surface that changes by `yielding` times the impulse, axis by axis.
    fn impulse<const D: usize>(
        &self,
        velocity: &SVector<f64, D>,
        normal: &SVector<f64, D>,
        yielding: &SVector<f64, D>,
    ) -> SVector<f64, D> {
        let approach = -velocity.dot(normal);
        let Some(lean) = lean(normal, yielding).filter(|_| approach > 0.0) else {
            return SVector::zeros();
        };
        let pressed = (1.0 + self.restitution) * approach / lean;
        let after = velocity + yielding.component_mul(normal) * pressed;
        let sliding = after - normal * after.dot(normal);
        let Some(along) = sliding.try_normalize(0.0) else { return normal * pressed };
        let slows = along.dot(&along.component_mul(yielding));
        let limit = self.friction * pressed;
        let rubbed = if slows * limit > sliding.norm() { sliding.norm() / slows } else { limit };
        normal * pressed - along * rubbed
    }
}

/// Change of the normal velocity per unit of normal impulse; `None` where it is negligible.
fn lean<const D: usize>(normal: &SVector<f64, D>, yielding: &SVector<f64, D>) -> Option<f64> {
    let lean = normal.dot(&normal.component_mul(yielding));
    (lean > LEAST_LEAN * yielding.max()).then_some(lean)
}

/// World axis of an axis of the system.
fn world_axis<const D: usize>(axis: usize) -> usize {
    if axis + 1 == D { 2 } else { axis }
}

fn in_world<const D: usize>(point: &SVector<f64, D>) -> Point3<f64> {
    let mut result = Point3::origin();
    for axis in 0..D {
        result[world_axis::<D>(axis)] = point[axis];
    }
    result
}

fn of_world<const D: usize>(vector: &Vector3<f64>) -> SVector<f64, D> {
    SVector::from_fn(|axis, _| vector[world_axis::<D>(axis)])
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
        touches: &mut Vec<NodeTouch>,
    ) -> Result<(), SpringError> {
        self.positions.clear();
        self.positions.extend(
            (0..system.nodes()).flat_map(|node| [in_world(&system.positions.get(node)); 2]),
        );
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
        for [i, j] in touching {
            let apart = system.positions.get(j) - system.positions.get(i);
            let yielding = system.yielding_apart(i, j);
            let distance = apart.norm();
            let gap = (distance - 2.0 * surface.radius).min(0.0);
            // No direction is better than another where there is none, but one must not be barred.
            let normal = if distance > 0.0 {
                apart / distance
            } else {
                let free = yielding.imax();
                SVector::from_fn(|axis, _| if axis == free { 1.0 } else { 0.0 })
            };
            let Some(lean) = lean(&normal, &yielding) else { continue };
            let velocity = system.velocities.get(j) - system.velocities.get(i);
            let impulse = surface.impulse(&velocity, &normal, &yielding);
            let shift = normal * (-gap / lean);
            touches.push(NodeTouch {
                node: i,
                touched: Touched::Node(j),
                place: in_world(&(system.positions.get(i) + 0.5 * apart)),
                impulse: in_world(&-impulse).coords,
            });
            system.impel(i, &-impulse);
            system.impel(j, &impulse);
            system.shift(i, &-shift);
            system.shift(j, &shift);
        }
        Ok(())
    }
}
