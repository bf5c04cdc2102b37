//! What is shown on demand: contacts with their forces, bounding volumes, electric field lines.

use crate::field_lines::FieldLine;
use crate::frame::{count, single};
use nalgebra::{Point3, Vector3};
use rapunzel_export::Strand;
use rapunzel_sim::{ContactForce, bounding_boxes};
use serde::Deserialize;

/// Boxes of a frame at most; where there are more, those of the next level are shown.
const MOST_BOXES: usize = 8192;
/// Contacts of a frame at most, the first ones; their number is told in any case.
const MOST_CONTACTS: usize = 50_000;

/// What is to be shown besides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Shows {
    /// Contacts with their forces.
    pub(crate) contacts: bool,
    /// Bounding volumes of a level: 0 for those of segments.
    pub(crate) volumes: Option<usize>,
    /// Electric field lines.
    pub(crate) field: bool,
}

/// A place at which something touches, m, and the force there on the first of the two, N, world.
pub(crate) type Push = (Point3<f64>, Vector3<f64>);

/// What a frame shows besides.
#[derive(Debug, Default)]
pub(crate) struct Extras {
    pub(crate) pushes: Vec<Push>,
    pub(crate) boxes: Vec<[Point3<f64>; 2]>,
    pub(crate) lines: Vec<FieldLine>,
}

impl Extras {
    /// Appends to a frame, little-endian: numbers of contacts, boxes, lines and points of all lines
    /// (4 u32); place and force of every contact, two corners of every box (6 f32 each), number of
    /// points of every line (u32), and the points (3 f32).
    pub(crate) fn write(&self, bytes: &mut Vec<u8>) {
        let points = self.lines.iter().map(Vec::len).sum();
        for of in [self.pushes.len(), self.boxes.len(), self.lines.len(), points] {
            bytes.extend(count(of).to_le_bytes());
        }
        let mut put = |x: &f64| {
            let x = single(*x);
            bytes.extend((if x.is_finite() { x } else { 0.0 }).to_le_bytes());
        };
        for (place, force) in &self.pushes {
            place.iter().chain(force.iter()).for_each(&mut put);
        }
        self.boxes.iter().flatten().for_each(|corner| corner.iter().for_each(&mut put));
        for line in &self.lines {
            bytes.extend(count(line.len()).to_le_bytes());
        }
        for x in self.lines.iter().flatten().flat_map(|point| point.iter()) {
            bytes.extend(single(*x).to_le_bytes());
        }
    }
}

/// Where things touch, m, and the forces, N.
pub(crate) fn pushes(touches: impl Iterator<Item = ContactForce>) -> Vec<Push> {
    touches.map(|touch| (touch.place, touch.force)).take(MOST_CONTACTS).collect()
}

/// Forces of contacts at the nodes of a recorded frame.
pub(crate) fn node_pushes(strands: &[Strand]) -> Vec<Push> {
    let of = |strand: &Strand| -> Vec<Push> {
        let nodes = strand.points.iter().zip(&strand.contact_forces);
        nodes.filter(|(_, force)| force.norm() > 0.0).map(|(p, f)| (*p, *f)).collect()
    };
    strands.iter().flat_map(of).take(MOST_CONTACTS).collect()
}

/// The bounding volumes of a level, or of the first above it that has not too many.
pub(crate) fn boxes(strands: &[Strand], level: usize) -> Vec<[Point3<f64>; 2]> {
    // Eight levels of sixteen hold more segments than 32 bits can count.
    let levels = (level.min(8)..=8).map(|level| bounding_boxes(strands, level));
    levels.into_iter().find(|boxes| boxes.len() <= MOST_BOXES).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    fn strand() -> Strand {
        let points: Vec<_> = (0..4).map(|k| Point3::new(f64::from(k), 0.0, 0.0)).collect();
        let n = points.len();
        let mut contact_forces = vec![Vector3::zeros(); n];
        contact_forces[2] = Vector3::z();
        Strand {
            radii: vec![0.1; n],
            velocities: vec![Vector3::zeros(); n],
            frames: vec![Rotation3::identity(); n - 1],
            curvatures: vec![Vector3::zeros(); n],
            forces: vec![Vector3::zeros(); n - 1],
            contact_forces,
            charges: vec![0.0; n],
            points,
        }
    }

    #[test]
    fn forces_of_a_recorded_frame_are_at_its_nodes() {
        let nodes = node_pushes(&[strand()]);
        assert_eq!(nodes, [(Point3::new(2.0, 0.0, 0.0), Vector3::z())]);
    }

    #[test]
    fn boxes_are_of_segments_or_of_groups_and_never_too_many() {
        let one = [strand()];
        assert_eq!(boxes(&one, 0).len(), 3);
        assert_eq!(boxes(&one, 1).len(), 1);
        let many = vec![strand(); 3000];
        let shown = boxes(&many, 0).len();
        assert!(shown > 100 && shown <= MOST_BOXES, "{shown}");
        assert!(boxes(&[], 0).is_empty());
    }

    #[test]
    fn what_is_no_number_is_written_as_zero() {
        let pushes = vec![(Point3::origin(), Vector3::repeat(f64::NAN))];
        let mut bytes = Vec::new();
        Extras { pushes, ..Extras::default() }.write(&mut bytes);
        assert_eq!(bytes.len(), 16 + 24);
        assert!(bytes[16..].iter().all(|byte| *byte == 0));
    }
}
