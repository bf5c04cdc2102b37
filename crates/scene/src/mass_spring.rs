use super::Wind;
use super::check::{Allowed, Check};
use rapunzel_mass_spring::{Element, LatticeBody};
use serde::{Deserialize, Serialize};

/// A mass-spring system in place of fibres: one model and what acts on it.
///
/// Models in the plane lie in the plane of x and z. Probes see one fibre, number 0, whose nodes are
/// the nodes of the model. Of the environment, gravity acts; drag and wind are given here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MassSpring {
    /// The model.
    pub model: Model,
    /// Position at the start (world), m: of the fixed end of a rope, the top left corner of a net
    /// or body, the center of a ring or ball.
    #[serde(default)]
    pub position: [f64; 3],
    /// Mass of a node, kg.
    pub mass: f64,
    /// Natural frequency of one mass on one spring, Hz: springs have the stiffness
    /// `m (2 pi f)^2`.
    pub frequency: f64,
    /// Drag rate of the nodes, 1/s; the wind acts through it.
    #[serde(default)]
    pub drag: f64,
    /// Damping ratio of the springs: their damping constant over the critical one.
    #[serde(default)]
    pub damping_ratio: f64,
    /// Elastic strain beyond which springs give way for good; left out, they never do.
    #[serde(default)]
    pub yield_strain: Option<f64>,
    /// Wind, which acts through the drag.
    #[serde(default)]
    pub wind: Wind,
    /// Time integration method.
    #[serde(default)]
    pub integrator: Integrator,
    /// Number of sub-steps of every step.
    #[serde(default = "one")]
    pub substeps: usize,
    /// Nodes that are fixed relative to other nodes.
    #[serde(default)]
    pub ties: Vec<Tie>,
    /// Nodes that are moved at prescribed velocities, as by a mouse.
    #[serde(default)]
    pub holds: Vec<Hold>,
    /// Constant forces on nodes.
    #[serde(default)]
    pub loads: Vec<NodeLoad>,
    /// Contact parameters of the nodes; left out, there are no contacts.
    #[serde(default)]
    pub contacts: Option<NodeContacts>,
}

fn one() -> usize {
    1
}

/// The models of a mass-spring system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Model {
    /// Masses in a row, the first one fixed.
    Rope {
        /// Number of nodes.
        nodes: usize,
        /// Rest length of a segment, m.
        spacing: f64,
        /// Direction of the rope at the start (world).
        direction: [f64; 3],
        /// Bending stiffness, N m^2.
        #[serde(default)]
        bending_stiffness: f64,
        /// Whether segments keep their length, whatever the frequency: a chain.
        #[serde(default)]
        inextensible: bool,
    },
    /// A net in space, hung in the plane of x and z.
    Net {
        /// Supports and springs of the nodes.
        place: NodePlaces,
        /// Side of a cell, m.
        spacing: f64,
        /// Whether cells have one diagonal, so that they do not fold over.
        #[serde(default)]
        triangular: bool,
    },
    /// A compressible body in the plane.
    Body {
        /// Shape of the body.
        shape: SpringBodyShape,
        /// Side of a cell, m.
        spacing: f64,
    },
    /// An incompressible body in the plane, with node 0 in its middle.
    Ring {
        /// Number of masses on the ring.
        count: usize,
        /// Radius of the ring, m.
        radius: f64,
        /// Strength of the controller of the area, per step.
        #[serde(default = "tau")]
        tau: f64,
    },
    /// An incompressible body in space, with node 0 in its middle.
    Ball {
        /// Radius of the ball, m.
        radius: f64,
        /// Number of parts into which each edge of the initial octahedron is cut.
        fineness: u8,
        /// Strength of the controller of the volume, per step.
        #[serde(default = "tau")]
        tau: f64,
    },
}

fn tau() -> f64 {
    0.2
}

/// Supports and springs of the nodes of a net.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum NodePlaces {
    /// A cloth on a line: every third node of the top row is fixed.
    Line {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// A flag: the left column is fixed.
    Flag {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// A free net.
    Flying {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// A letter for every node: `f m t b l r 1 2 3 4 h v`, see `rapunzel_mass_spring::PlaceMatrix`.
    Matrix {
        /// Rows from the top.
        rows: Vec<String>,
    },
}

/// The compressible bodies of the second text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpringBodyShape {
    /// Thin beam, fixed at the left, guided along itself at the right.
    ThinBeamGuided,
    /// Thin beam, fixed at the left.
    ThinBeam,
    /// Cube, fixed on the ground.
    Cube,
    /// Cube, fixed on the ground, under a lid.
    CubeUnderLid,
    /// Thick beam, fixed at the left.
    ThickBeam,
}

/// Time integration method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Integrator {
    /// Leapfrog: second order, conserves energy; stable below a limit of the step.
    #[default]
    Leapfrog,
    /// Runge-Kutta: fourth order.
    RungeKutta,
    /// Implicit Euler: first order, stable for any step.
    ImplicitEuler,
}

/// A node that keeps its offset from another one: both move as one body without rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tie {
    /// Index of the node that is tied.
    pub node: usize,
    /// Index of the node that it is tied to.
    pub to: usize,
}

/// A node that is moved at a prescribed velocity for some time, and then released or held.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// Index of the node; the nodes of its clamp follow.
    pub node: usize,
    /// Start of the motion, s.
    #[serde(default)]
    pub from: f64,
    /// End of the motion, s.
    pub until: f64,
    /// Velocity, m/s, world frame.
    pub velocity: [f64; 3],
    /// Whether the node is released at the end of the motion, instead of being held where it is.
    #[serde(default)]
    pub release: bool,
}

/// A constant force on a node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodeLoad {
    /// Index of the node.
    pub node: usize,
    /// Force, N, world frame.
    pub force: [f64; 3],
}

/// Contacts of nodes as balls, with each other, with a level ground and with the objects of the
/// scene, which move kinematically.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodeContacts {
    /// Radius of the nodes, m.
    pub radius: f64,
    /// Coefficient of restitution.
    #[serde(default)]
    pub restitution: f64,
    /// Coulomb's coefficient of friction.
    #[serde(default)]
    pub friction: f64,
    /// Whether there are contacts among nodes.
    #[serde(default)]
    pub mutual: bool,
    /// Height of a level ground, m.
    #[serde(default)]
    pub ground: Option<f64>,
}

impl MassSpring {
    /// Mass, stiffness, drag and damping as `rapunzel-mass-spring` takes them.
    pub fn element(&self) -> Element {
        Element {
            mass: self.mass,
            frequency: self.frequency,
            drag: self.drag,
            damping_ratio: self.damping_ratio,
        }
    }

    /// Number of nodes of the model.
    pub fn nodes(&self) -> usize {
        match &self.model {
            Model::Rope { nodes, .. } => *nodes,
            Model::Net { place, .. } => place.nodes(),
            Model::Body { shape, .. } => shape.body().size().into_iter().product(),
            Model::Ring { count, .. } => count.saturating_add(1),
            // An octahedron with every edge cut into n has 4 n^2 + 2 vertices.
            Model::Ball { fineness, .. } => 4 * usize::from(*fineness).pow(2) + 3,
        }
    }

    /// Largest number of segments of a line of springs in frames, where no other limit bounds it,
    /// and the field that determines it.
    pub fn longest_line(&self) -> Option<(&'static str, usize)> {
        match &self.model {
            Model::Rope { nodes, .. } => Some(("model.nodes", nodes.saturating_sub(1))),
            Model::Ring { count, .. } => Some(("model.count", count.saturating_sub(1))),
            Model::Net { place: NodePlaces::Matrix { rows }, .. } => {
                let columns = rows.iter().map(|row| row.chars().count()).max().unwrap_or(0);
                Some(("model.place.rows", rows.len().max(columns).saturating_sub(1)))
            }
            Model::Net { .. } | Model::Body { .. } | Model::Ball { .. } => None,
        }
    }

    /// Reports problems that can be seen without building the model.
    pub(crate) fn check(&self, check: &mut Check) {
        check.vector("position", &self.position, "m");
        check.number("mass", self.mass, Allowed::Positive, "kg");
        check.number("frequency", self.frequency, Allowed::Positive, "Hz");
        check.number("drag", self.drag, Allowed::NonNegative, "1/s");
        check.number("damping_ratio", self.damping_ratio, Allowed::NonNegative, "");
        if let Some(strain) = self.yield_strain {
            check.number("yield_strain", strain, Allowed::Positive, "");
        }
        check.within("wind", |c| self.wind.check(c));
        if self.drag == 0.0 && self.wind != Wind::default() {
            check.refuse("drag", "is 0, but wind acts through the drag (1/s)".into());
        }
        check.count("substeps", self.substeps, 1, 1_000_000);
        check.each("holds", &self.holds, |c, hold| {
            c.number("from", hold.from, Allowed::NonNegative, "s");
            c.number("until", hold.until, Allowed::NonNegative, "s");
            if hold.until < hold.from {
                let message = format!("is {:?}, but must not be before `from` (s)", hold.until);
                c.refuse("until", message);
            }
            c.vector("velocity", &hold.velocity, "m/s");
        });
        check.each("loads", &self.loads, |c, load| c.vector("force", &load.force, "N"));
        if let Some(contacts) = &self.contacts {
            check.within("contacts", |c| contacts.check(c));
        }
        check.within("model", |c| match &self.model {
            Model::Rope { nodes, spacing, direction, bending_stiffness, .. } => {
                c.count("nodes", *nodes, 2, 1_000_000);
                c.number("spacing", *spacing, Allowed::Positive, "m");
                c.direction("direction", direction);
                c.number("bending_stiffness", *bending_stiffness, Allowed::NonNegative, "N m^2");
            }
            Model::Ring { count, radius, tau } => {
                c.count("count", *count, 3, 1_000_000);
                c.number("radius", *radius, Allowed::Positive, "m");
                c.number("tau", *tau, Allowed::NonNegative, "");
            }
            Model::Ball { fineness, radius, tau } => {
                c.count("fineness", (*fineness).into(), 1, 100);
                c.number("radius", *radius, Allowed::Positive, "m");
                c.number("tau", *tau, Allowed::NonNegative, "");
            }
            Model::Net { place, spacing, .. } => {
                place.check(c);
                c.number("spacing", *spacing, Allowed::Positive, "m");
            }
            Model::Body { spacing, .. } => c.number("spacing", *spacing, Allowed::Positive, "m"),
        });
    }
}

impl SpringBodyShape {
    /// The body as `rapunzel-mass-spring` has it.
    pub fn body(self) -> LatticeBody {
        match self {
            Self::ThinBeamGuided => LatticeBody::ThinBeamGuided,
            Self::ThinBeam => LatticeBody::ThinBeam,
            Self::Cube => LatticeBody::Cube,
            Self::CubeUnderLid => LatticeBody::CubeUnderLid,
            Self::ThickBeam => LatticeBody::ThickBeam,
        }
    }
}

impl NodePlaces {
    fn nodes(&self) -> usize {
        match self {
            Self::Line { rows, columns }
            | Self::Flag { rows, columns }
            | Self::Flying { rows, columns } => rows.saturating_mul(*columns),
            Self::Matrix { rows } => rows.iter().map(|row| row.chars().count()).sum(),
        }
    }

    fn check(&self, check: &mut Check) {
        if let Self::Line { rows, columns }
        | Self::Flag { rows, columns }
        | Self::Flying { rows, columns } = self
        {
            check.count("place.rows", *rows, 2, 3000);
            check.count("place.columns", *columns, 2, 3000);
        }
    }
}

impl NodeContacts {
    fn check(&self, check: &mut Check) {
        let radius = if self.mutual { Allowed::Positive } else { Allowed::NonNegative };
        check.number("radius", self.radius, radius, "m");
        check.number("restitution", self.restitution, Allowed::Within(0.0, 1.0), "");
        check.number("friction", self.friction, Allowed::NonNegative, "");
        if let Some(height) = self.ground {
            check.number("ground", height, Allowed::Finite, "m");
        }
    }
}
