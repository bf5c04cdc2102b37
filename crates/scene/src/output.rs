use super::check::{Allowed, Check};
use super::{Bundle, Law, Scene};
use rapunzel_export::hair;
use serde::{Deserialize, Serialize};

/// Output files of a run, in its folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Frames per second of simulated time. Frames fall on steps exactly: the step is made a little
    /// smaller where the interval is not a multiple of it. With `charging` every step is a frame.
    pub frame_rate: f64,
    /// File formats of the frames beside `frames/*.vtp` and `frames.pvd` (VTK poly data, for
    /// ParaView), which are always written.
    pub formats: Vec<Format>,
    /// Time between the rows of `energies.csv` and `probes.csv`, s, rounded to steps; 0 for a row
    /// at every step.
    pub record_interval: f64,
    /// Whether `energies.csv` has all work done on the fibres, which with the work of contacts sums
    /// up to the gain of kinetic and elastic energy. Needs the method `Staggered` or
    /// `BackwardEuler`, without a tolerance.
    pub ledger: bool,
    /// Columns of `probes.csv`.
    pub probes: Vec<Probe>,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            frame_rate: 30.0,
            formats: Vec::new(),
            record_interval: 0.0,
            ledger: false,
            probes: Vec::new(),
        }
    }
}

/// A file format for frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Format {
    /// One USD stage with all frames, of fibres, springs and objects, as text: for Blender,
    /// Houdini.
    Usd,
    /// Cem Yuksel's binary format, a file for each frame. It holds fibres and springs, no objects,
    /// and at most 65535 segments of each.
    Hair,
    /// POV-Ray scene description, a file for each frame, of fibres, springs and objects.
    Pov,
    /// Scene of Mitsuba 3 for each frame, of fibres, springs and objects: brown hair as smooth
    /// curves through the nodes.
    Mitsuba,
}

/// A quantity of one node, or of one fibre, over time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Index of the fibre, over all bundles in the order of the scene.
    #[serde(default)]
    pub fiber: usize,
    /// Node of the fibre; without meaning for `Energy` and `Contact`, which are of the whole fibre.
    #[serde(default)]
    pub node: ProbeNode,
    /// Quantity that is read.
    pub quantity: ProbeQuantity,
}

/// A node of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ProbeNode {
    /// The last node.
    #[default]
    Tip,
    /// The node with the given number from the root, which is 0.
    At {
        /// Number of the node.
        index: usize,
    },
}

/// Quantity that a probe reads. All but position and velocity are of fibres alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ProbeQuantity {
    /// Position, m, world frame.
    Position,
    /// Velocity, m/s, world frame.
    Velocity,
    /// Force of the part beyond on the part before, N, world frame: in the segment before the node,
    /// at the root in the first one.
    Force,
    /// Component of that force along its segment, N; negative where the fibre is compressed.
    Tension,
    /// Moment of the part beyond on the part before at the node, N m, world frame: its elastic
    /// part, without internal damping. Zero at an end that is not clamped. For the law `Elastic`.
    Moment,
    /// Curvature about d1 and d2 and twist about the tangent, 1/m: the Darboux vector in the
    /// material frame.
    Curvature,
    /// Twist about the tangent, rad/m: the last component of the curvature.
    Twist,
    /// Force (N) and moment (N m) of what holds an end on the fibre, world frame; the node must be
    /// an end. The inertia of half of the end's segment is left out: it is none where the end rests
    /// or moves evenly. So is the air on it. Zero at a free end. For the law `Elastic`.
    Reaction,
    /// Kinetic, elastic and gravitational energy of the fibre, J.
    Energy,
    /// Force of another fibre or of an object on the fibre, N, world frame: its mean over the last
    /// substep. Needs `contact`.
    Contact {
        /// What touches the fibre.
        with: ContactPartner,
    },
}

/// What a fibre can touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContactPartner {
    /// The fibre with this index, over all bundles in the order of the scene.
    Fiber(usize),
    /// The object with this index in the scene.
    Object(usize),
}

impl ProbeQuantity {
    /// Whether it is one of fibres alone.
    fn is_of_fibers(self) -> bool {
        !matches!(self, Self::Position | Self::Velocity)
    }
}

/// Largest number of probes of a scene; more is a typing error.
const MOST_PROBES: usize = 10_000;

impl Output {
    /// Reports problems of the output; `segments(i)` is the number of segments of fibre `i`, if
    /// there is one.
    pub(crate) fn check(&self, check: &mut Check, segments: impl Fn(usize) -> Option<usize>) {
        check.number("frame_rate", self.frame_rate, Allowed::Within(1e-3, 1e6), "1/s");
        check.number("record_interval", self.record_interval, Allowed::NonNegative, "s");
        check.count("probes", self.probes.len(), 0, MOST_PROBES);
        check.each("probes", &self.probes, |c, probe| match (segments(probe.fiber), probe.node) {
            (None, _) => {
                c.refuse("fiber", format!("is {}, but there is no such fibre", probe.fiber));
            }
            (Some(segments), ProbeNode::At { index }) if index > segments => {
                let message = format!("is {index}, but the nodes are numbered 0 to {segments}");
                c.refuse("node.index", message);
            }
            _ => {}
        });
    }
}

impl Scene {
    /// Reports probes of quantities that the scene does not have.
    pub(super) fn check_probes(&self, check: &mut Check) {
        check.each("output.probes", &self.output.probes, |c, probe| {
            let quantity = probe.quantity;
            if quantity.is_of_fibers() && self.mass_spring.is_some() {
                let message = "is of fibres alone: of a mass_spring system there are Position and \
                               Velocity";
                c.refuse("quantity", message.into());
                return;
            }
            if quantity == ProbeQuantity::Reaction {
                let last = self.segments_of(probe.fiber);
                let is_end = match probe.node {
                    ProbeNode::Tip => true,
                    ProbeNode::At { index } => index == 0 || last == Some(index),
                };
                if !is_end {
                    let message = "is no end, where a Reaction is; take At(index: 0) or Tip";
                    c.refuse("node", message.into());
                }
            }
            let needs_law = matches!(quantity, ProbeQuantity::Reaction | ProbeQuantity::Moment);
            if needs_law && self.charging.is_some() {
                let message = "is told of fibres that move: leave it out beside charging";
                c.refuse("quantity", message.into());
            }
            let law = self.bundle_of(probe.fiber).map(Bundle::law);
            if needs_law && law.is_some_and(|law| law != Law::Elastic) {
                let message = "is told of fibres with the law Elastic; other laws remember strains, \
                               so that their moment does not follow from the shape";
                c.refuse("quantity", message.into());
            }
            if let ProbeQuantity::Contact { with } = quantity {
                self.check_partner(c, probe.fiber, with);
            }
        });
    }

    /// Reports a probe of a contact that there cannot be.
    fn check_partner(&self, check: &mut Check, fiber: usize, with: ContactPartner) {
        if self.contact.is_none() {
            let message = "is a Contact, but the scene has no `contact`; give its settings";
            check.refuse("quantity", message.into());
        }
        let (field, index, is_there) = match with {
            ContactPartner::Fiber(i) => ("fibre", i, self.segments_of(i).is_some()),
            ContactPartner::Object(i) => ("object", i, i < self.objects.len()),
        };
        if !is_there {
            let message = format!("is the {field} {index}, but there is no such {field}");
            check.refuse("quantity.with", message);
        }
        if with == ContactPartner::Fiber(fiber) {
            let message = format!("is the fibre {fiber} itself; name another one");
            check.refuse("quantity.with", message);
        }
    }

    /// Reports data that a requested format cannot hold.
    pub(super) fn check_formats(&self, check: &mut Check) {
        if !self.output.formats.contains(&Format::Hair) {
            return;
        }
        let most = hair::MOST_SEGMENTS;
        let refuse = |check: &mut Check, field: &str, segments: usize| {
            if segments > most {
                let message = format!(
                    "makes a line of {segments} segments, but .hair holds at most {most}; take \
                     fewer, or leave Hair out of output.formats"
                );
                check.refuse(field, message);
            }
        };
        check.each("fibers", &self.fibers, |c, bundle| refuse(c, "segments", bundle.segments));
        if let Some((field, segments)) = self.mass_spring.as_ref().and_then(|s| s.longest_line()) {
            check.within("mass_spring", |c| refuse(c, field, segments));
        }
    }
}
