//! What a scene takes of memory, told before anything is built.

use crate::assemble::{matter, strand_count};
use crate::objects::{Sizes, read_mesh};
use crate::scene::{MassSpring, ObjectShape, RodMethod};
use crate::style::head_mesh;
use crate::{Scene, SimError};
use rapunzel_collision::field::Grid;

// Bytes that building and running takes, rounded up: a touching node takes 1.85 kB in a lock of
// 10^6 of them, a charged one 1.1 kB; the others are estimates.
/// Memory of a node of a fibre that touches nothing, bytes.
const NODE: f64 = 1500.0;
/// Memory of a node by a method that moves rods one by one, bytes.
const SINGLE_NODE: f64 = 3000.0;
/// Memory of a node where fibres touch, besides, bytes; contacts come on top.
const TOUCHING_NODE: f64 = 2000.0;
/// Memory of a node of a charged fibre, bytes.
const CHARGED_NODE: f64 = 3000.0;
/// Memory of a node of a mass-spring system, bytes.
const SPRING_NODE: f64 = 2000.0;
/// Memory of a height of a terrain, bytes.
const HEIGHT: f64 = 800.0;
/// Memory of a triangle of a mesh beside its field, bytes.
const TRIANGLE: f64 = 800.0;
/// Memory of a point at which the electric field is written, bytes.
const FIELD_POINT: f64 = 300.0;
/// A mesh with a side of more than this, m, may be in millimetres.
const LARGE: f64 = 5.0;

/// What a scene takes of memory, and what is strange about its files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MemoryEstimate {
    /// By what asks for it.
    pub parts: Vec<MemoryShare>,
    /// What a user should know about meshes that were repaired or seem to be in another unit.
    pub notes: Vec<String>,
}

/// What a field of a scene asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct MemoryShare {
    /// Path of the field, like `fibers[0]`.
    pub path: String,
    /// What it makes.
    pub what: String,
    /// Memory, bytes.
    pub bytes: f64,
}

impl MemoryEstimate {
    /// All memory, bytes.
    #[must_use]
    pub fn bytes(&self) -> f64 {
        self.parts.iter().map(|part| part.bytes).sum()
    }

    /// Whether no more than `most` bytes are taken.
    ///
    /// # Errors
    /// [`SimError::Memory`] with what asks for most.
    pub fn within(&self, most: f64) -> Result<(), SimError> {
        let bytes = self.bytes();
        match self.parts.iter().max_by(|a, b| a.bytes.total_cmp(&b.bytes)) {
            Some(MemoryShare { path, what, .. }) if bytes > most => {
                Err(SimError::Memory { path: path.clone(), what: what.clone(), bytes, most })
            }
            _ => Ok(()),
        }
    }

    fn add(&mut self, path: &str, what: String, bytes: f64) {
        self.parts.push(MemoryShare { path: path.to_owned(), what, bytes });
    }
}

impl MemoryEstimate {
    /// What building and running a scene takes of memory, from its numbers and meshes alone; what
    /// contacts take grows with what touches, and is not known before.
    ///
    /// # Errors
    /// [`SimError::Scene`] if the scene makes no sense, [`SimError::Io`] and [`SimError::Mesh`] for
    /// a mesh.
    pub fn new(scene: &Scene) -> Result<Self, SimError> {
        scene.validate()?;
        let mut estimate = Self::default();
        let around = Sizes { roundest: scene.roundest(), ..sizes(scene)? };
        for (i, bundle) in scene.fibers.iter().enumerate() {
            let segments = bundle.segments;
            let count = match &bundle.groom {
                Some(groom) => strand_count(groom, i)?,
                None => bundle.arrangement.fibers(),
            };
            let nodes = count as f64 * (segments + 1) as f64;
            let what = format!("{count} fibres of {segments} segments");
            estimate.add(&format!("fibers[{i}]"), what, nodes * bytes_of_node(scene));
        }
        if let Some(springs) = &scene.mass_spring {
            let nodes = springs.nodes();
            estimate.add("mass_spring", format!("{nodes} nodes"), nodes as f64 * SPRING_NODE);
        }
        for (i, object) in scene.objects.iter().enumerate() {
            estimate.object(i, &object.shape, &around)?;
        }
        if let Some(grid) = scene.charging.as_ref().and_then(|charging| charging.grid) {
            let points: f64 = grid.counts.iter().map(|&count| count as f64).product();
            let what = format!("{points} points of the electric field");
            estimate.add("charging.grid", what, points * FIELD_POINT);
        }
        Ok(estimate)
    }

    fn object(
        &mut self,
        index: usize,
        shape: &ObjectShape,
        around: &Sizes,
    ) -> Result<(), SimError> {
        let path = format!("objects[{index}]");
        match shape {
            ObjectShape::HeightField { sides, spacing, .. } => {
                let [columns, rows] = sides.map(|side| (side / spacing).ceil() + 1.0);
                let what = format!("{columns} x {rows} heights");
                self.add(&path, what, columns * rows * HEIGHT);
            }
            ObjectShape::Mesh { file, spacing, scale, repair } => {
                let (mesh, repairs) = read_mesh(index, file, *scale, *repair)?;
                let [low, high] = mesh.bounds();
                let size = high - low;
                let told = format!("{:.3} x {:.3} x {:.3} m", size.x, size.y, size.z);
                let bytes = Grid::memory(&mesh, *spacing, around.band(*spacing))
                    + TRIANGLE * mesh.triangles().len() as f64;
                let unit = " (in millimetres? then give `scale: 0.001`)";
                let unit = if *scale == 1.0 && size.max() > LARGE { unit } else { "" };
                let what = format!("distances of a mesh of {told}{unit} every {spacing:?} m");
                self.add(&path, what, bytes);
                if !unit.is_empty() {
                    self.notes.push(format!("{path}: the mesh has {told}{unit}"));
                }
                let told = repairs.to_string();
                if !told.is_empty() {
                    self.notes.push(format!("{path}: the mesh was repaired; {told}"));
                }
            }
            ObjectShape::Head { style, spacing } => {
                let mesh = head_mesh(style)?;
                let bytes = Grid::memory(&mesh, *spacing, around.band(*spacing));
                self.add(&path, format!("distances of a head every {spacing:?} m"), bytes);
            }
            _ => {}
        }
        Ok(())
    }
}

fn bytes_of_node(scene: &Scene) -> f64 {
    let touch = scene.contact.is_some();
    let own = match scene.stepper.method() {
        _ if scene.charging.is_some() => CHARGED_NODE,
        RodMethod::Box { .. } => SINGLE_NODE,
        _ if scene.stepper.tolerance.is_some() => SINGLE_NODE,
        _ => NODE,
    };
    own + if touch { TOUCHING_NODE } else { 0.0 }
}

/// The longest and the thickest of what meets objects.
fn sizes(scene: &Scene) -> Result<Sizes, SimError> {
    let mut around = Sizes { longest: 0.0, thickest: 0.0, roundest: None };
    if let Some(MassSpring { contacts: Some(contacts), .. }) = &scene.mass_spring {
        around.thickest = contacts.radius;
    }
    for (i, bundle) in scene.fibers.iter().enumerate() {
        let (matter, _) = matter(scene, bundle, i, 0.0)?;
        around.longest = around.longest.max(bundle.length);
        around.thickest = around.thickest.max(matter.thickest());
    }
    Ok(around)
}
