use super::Scene;
use super::check::{Allowed, Check};
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

/// A quantity of one node over time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Index of the fibre, over all bundles in the order of the scene.
    #[serde(default)]
    pub fiber: usize,
    /// Node of the fibre.
    #[serde(default)]
    pub node: ProbeNode,
    /// Quantity of the node.
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

/// Quantity that a probe reads, in the world frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ProbeQuantity {
    /// Position, m.
    Position,
    /// Velocity, m/s.
    Velocity,
}

impl Output {
    /// Reports problems of the output; `segments(i)` is the number of segments of fibre `i`, if
    /// there is one.
    pub(crate) fn check(&self, check: &mut Check, segments: impl Fn(usize) -> Option<usize>) {
        check.number("frame_rate", self.frame_rate, Allowed::Within(1e-3, 1e6), "1/s");
        check.number("record_interval", self.record_interval, Allowed::NonNegative, "s");
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
