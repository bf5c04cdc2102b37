use super::Wind;
use super::check::{Allowed, Check};
use rapunzel_mass_spring::{Element, LatticeBody};
use serde::{Deserialize, Serialize};

/// A mass-spring system, in place of fibres: one model and what acts on it.
///
/// Models in the plane lie in that of x and z. Probes see one fibre, number 0, whose nodes are
/// those of the model. Of the environment, gravity acts; drag and wind are given here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MassSpring {
    /// What it is.
    pub model: Model,
    /// Where it starts: the fixed end of a rope, the top left corner of a net or body, the center
    /// of a ring or ball (world), m.
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
    /// Ratio of the dampers of the springs to critical ones.
    #[serde(default)]
    pub damping_ratio: f64,
    /// Elastic strain beyond which springs give way for good; left out, they never do.
    #[serde(default)]
    pub yield_strain: Option<f64>,
    /// The wind.
    #[serde(default)]
    pub wind: Wind,
    /// How it is moved in time.
    #[serde(default)]
    pub integrator: Integrator,
    /// Sub-steps of every step.
    #[serde(default = "one")]
    pub substeps: usize,
    /// Nodes that are fixed relative to others.
    #[serde(default)]
    pub ties: Vec<Tie>,
    /// Nodes that are taken and moved: what a mouse does.
    #[serde(default)]
    pub holds: Vec<Hold>,
    /// Constant forces on nodes.
    #[serde(default)]
    pub loads: Vec<NodeLoad>,
    /// What nodes do when they touch something; left out, they pass through all.
    #[serde(default)]
    pub contacts: Option<NodeContacts>,
}

fn one() -> usize {
    1
}

/// What a mass-spring system is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Model {
    /// Masses in a row, the first one fixed.
    Rope {
        /// Number of nodes.
        nodes: usize,
        /// Rest length of a segment, m.
        spacing: f64,
        /// Where it runs at the start (world).
        direction: [f64; 3],
        /// Bending stiffness, N m^2.
        #[serde(default)]
        bending_stiffness: f64,
        /// A chain: segments do not stretch, whatever the frequency.
        #[serde(default)]
        inextensible: bool,
    },
    /// A net in space, hung up in the plane of x and z.
    Net {
        /// What every node is.
        place: NodePlaces,
        /// Side of a cell, m.
        spacing: f64,
        /// Cells with one diagonal, which do not fold over.
        #[serde(default)]
        triangular: bool,
    },
    /// A compressible body in the plane.
    Body {
        /// Which one.
        shape: SpringBodyShape,
        /// Side of a cell, m.
        spacing: f64,
    },
    /// An incompressible body in the plane, node 0 in its middle.
    Ring {
        /// Masses around.
        count: usize,
        /// Radius, m.
        radius: f64,
        /// Strength of the controller of the area, per step.
        #[serde(default = "tau")]
        tau: f64,
    },
    /// An incompressible body in space, node 0 in its middle.
    Ball {
        /// Radius, m.
        radius: f64,
        /// Cuts of an edge of the octahedron that it is made of.
        fineness: u8,
        /// Strength of the controller of the volume, per step.
        #[serde(default = "tau")]
        tau: f64,
    },
}

fn tau() -> f64 {
    0.2
}

/// What the nodes of a net are.
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
    /// Free.
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

/// A compressible body of the second text.
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

/// A method in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Integrator {
    /// Second order, conserves energy; stable below a limit of the step.
    #[default]
    Leapfrog,
    /// Fourth order.
    RungeKutta,
    /// First order, stable for any step.
    ImplicitEuler,
}

/// A node that keeps its offset from another one: both move as one body without rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tie {
    /// The node.
    pub node: usize,
    /// The other one.
    pub to: usize,
}

/// A node that is taken, moved, and let go or kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// The node; the nodes of its clamp follow.
    pub node: usize,
    /// When it is taken, s.
    #[serde(default)]
    pub from: f64,
    /// When the motion ends, s.
    pub until: f64,
    /// Velocity, m/s, world frame.
    pub velocity: [f64; 3],
    /// It is let go then, and not kept where it is.
    #[serde(default)]
    pub release: bool,
}

/// A constant force on a node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodeLoad {
    /// The node.
    pub node: usize,
    /// Force, N, world frame.
    pub force: [f64; 3],
}

/// Contacts of nodes as balls, with each other, with a level ground and with the objects of the
/// scene, which are led on their ways.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NodeContacts {
    /// Radius of the nodes, m.
    pub radius: f64,
    /// Part of the normal velocity that comes back.
    #[serde(default)]
    pub restitution: f64,
    /// Coulomb's coefficient of friction.
    #[serde(default)]
    pub friction: f64,
    /// Nodes touch each other too.
    #[serde(default)]
    pub mutual: bool,
    /// Height of a level ground, m.
    #[serde(default)]
    pub ground: Option<f64>,
}

impl MassSpring {
    /// Masses and springs as the crate takes them.
    pub fn element(&self) -> Element {
        Element {
            mass: self.mass,
            frequency: self.frequency,
            drag: self.drag,
            damping_ratio: self.damping_ratio,
        }
    }

    /// Number of nodes.
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

    /// The most segments that a line of springs has in frames, where no limit bounds them, and the
    /// field that says so.
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

    /// Notes what makes no sense by itself; building the model finds the rest.
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
    /// The body of the crate.
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
