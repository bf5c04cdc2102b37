//! A hand that holds a node while a world runs, and what of it is written into the scene.

use rapunzel_scene::{Grip, GripPlace, Hold, Scene};
use rapunzel_sim::{SimError, World};

/// Stiffness of a hand's spring, in masses of a node over the square of a step: what is held
/// oscillates slower than steps can follow by far.
const STIFFNESS: f64 = 0.25;
/// Its damping, in masses of a node over a step.
const DAMPING: f64 = 0.3;
/// Largest force on fibres and on springs, in weights of all that may hang at the node.
const FIBER_FORCE: f64 = 20.0;
const SPRING_FORCE: f64 = 5.0;
/// Weight of a mass, m/s^2.
const WEIGHT: f64 = 9.81;
/// A node that is fixed follows a hand within so long, s, and no faster than this, m/s.
const FOLLOW: f64 = 1.0 / 60.0;
const FASTEST: f64 = 20.0;

/// A node that a hand holds.
#[derive(Debug)]
pub(crate) struct Hand {
    pub(crate) strand: usize,
    /// The node, as the world counts.
    pub(crate) node: usize,
    to: [f64; 3],
    how: Grasp,
}

#[derive(Debug)]
enum Grasp {
    /// By the last of the scene's hands.
    Pulls { is_new: bool },
    /// A fixed node is carried; the last of the scene's holds ends at this time, s.
    Carries { until: f64 },
}

impl Hand {
    /// Takes hold of a point of a strand, if there is such a point.
    pub(crate) fn take(
        scene: &mut Scene,
        world: &World,
        (strand, point): (usize, usize),
        to: [f64; 3],
        dt: f64,
    ) -> Option<Self> {
        let node = node(world, strand, point)?;
        // Springs count their nodes as a whole.
        let strand = if scene.mass_spring.is_some() { 0 } else { strand };
        if world.stepper().is_held(node) {
            return Some(Self { strand, node, to, how: Grasp::Carries { until: 0.0 } });
        }
        let (mass, most) = match &scene.mass_spring {
            Some(springs) => {
                let all = springs.mass * world.nodes() as f64;
                (springs.mass, SPRING_FORCE * all * WEIGHT)
            }
            None => {
                let fiber = world.assembly().fibers().get(strand)?;
                let all = fiber.mass();
                (all / fiber.segments() as f64, FIBER_FORCE * all * WEIGHT)
            }
        };
        scene.grips.push(Grip {
            fiber: strand,
            node,
            stiffness: STIFFNESS * mass / (dt * dt),
            damping: DAMPING * mass / dt,
            most,
            path: Vec::new(),
            until: None,
        });
        Some(Self { strand, node, to, how: Grasp::Pulls { is_new: true } })
    }

    /// Moves the hand.
    pub(crate) fn lead(&mut self, to: [f64; 3]) {
        if to != self.to {
            self.to = to;
            if let Grasp::Pulls { is_new } = &mut self.how {
                *is_new = true;
            }
        }
    }

    /// Writes what the hand does from now on into the scene and the world, before a step of `dt`.
    pub(crate) fn act(
        &mut self,
        scene: &mut Scene,
        world: &mut World,
        dt: f64,
    ) -> Result<(), SimError> {
        let time = world.time();
        match &mut self.how {
            Grasp::Pulls { is_new } => {
                if std::mem::take(is_new)
                    && let Some(grip) = scene.grips.last_mut()
                {
                    // Not twice at one time, as before the first step.
                    grip.path.retain(|place| place.time < time);
                    grip.path.push(GripPlace { time, position: self.to });
                    world.set_grips(scene.grips.clone())?;
                }
                Ok(())
            }
            Grasp::Carries { until } => {
                if time < *until {
                    return Ok(());
                }
                let way =
                    nalgebra::Vector3::from(self.to) - world.node(0, Some(self.node)).0.coords;
                let steps = (FOLLOW / dt).ceil().max(1.0);
                let velocity = (way / (steps * dt)).cap_magnitude(FASTEST);
                if velocity.norm() < 1e-9 {
                    return Ok(());
                }
                // The last of these steps begins before, and the next one after.
                *until = time + (steps - 0.5) * dt;
                hold(scene, world, self.node, (time, *until), velocity.into(), false)
            }
        }
    }

    /// Lets go.
    pub(crate) fn let_go(self, scene: &mut Scene, world: &mut World) -> Result<(), SimError> {
        match self.how {
            Grasp::Pulls { .. } => {
                let time = world.time();
                if let Some(grip) = scene.grips.last_mut() {
                    grip.until = Some(time);
                }
                scene.grips.retain(|grip| !grip.path.is_empty());
                world.set_grips(scene.grips.clone())
            }
            Grasp::Carries { until } if until > world.time() => {
                let time = world.time();
                hold(scene, world, self.node, (time, time), [0.0; 3], false)
            }
            Grasp::Carries { .. } => Ok(()),
        }
    }
}

/// Fixes a point of a strand where it is, or releases it.
pub(crate) fn fix(
    scene: &mut Scene,
    world: &mut World,
    (strand, point): (usize, usize),
    fixed: bool,
) -> Result<(), SimError> {
    let Some(node) = node(world, strand, point) else { return Ok(()) };
    let time = world.time();
    hold(scene, world, node, (time, time), [0.0; 3], !fixed)
}

/// Holds a node of a mass-spring system from one time to another.
fn hold(
    scene: &mut Scene,
    world: &mut World,
    node: usize,
    (from, until): (f64, f64),
    velocity: [f64; 3],
    release: bool,
) -> Result<(), SimError> {
    let hold = Hold { node, from, until, velocity, release };
    world.add_hold(hold.clone())?;
    scene.mass_spring.iter_mut().for_each(|springs| springs.holds.push(hold.clone()));
    Ok(())
}

/// The node at a point of a strand, if there is such a point.
fn node(world: &World, strand: usize, point: usize) -> Option<usize> {
    let points = world.stepper().strand_nodes().get(strand).copied()?;
    (point < points).then(|| world.stepper().node_of(strand, point))
}
