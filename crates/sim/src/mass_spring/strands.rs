//! Springs as lines: what frames show.

use nalgebra::{Point3, Rotation3, Vector3};
use rapunzel_export::{Strand, usd};
use std::collections::{BTreeMap, BTreeSet};

/// Springs that follow each other.
pub(crate) struct Polyline {
    /// The nodes, one more than springs.
    nodes: Vec<usize>,
    springs: Vec<usize>,
}

impl Polyline {
    /// The nodes at all points of the line.
    pub(crate) fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// The node at a point of the line.
    pub(crate) fn node(&self, point: usize) -> usize {
        self.nodes[point]
    }
}

/// Lines along springs that go on from node to node by the same number: the rows, columns and
/// diagonals of a lattice.
pub(crate) fn polylines(springs: impl Iterator<Item = [usize; 2]>) -> Vec<Polyline> {
    let springs: Vec<[usize; 2]> = springs.collect();
    let mut open: BTreeMap<(usize, isize), usize> = BTreeMap::new();
    let mut lines: Vec<Polyline> = Vec::new();
    for (s, &[i, j]) in springs.iter().enumerate() {
        let stride = j.cast_signed() - i.cast_signed();
        let line = match open.remove(&(i, stride)) {
            Some(line) => line,
            None => {
                lines.push(Polyline { nodes: vec![i], springs: Vec::new() });
                lines.len() - 1
            }
        };
        lines[line].nodes.push(j);
        lines[line].springs.push(s);
        open.insert((j, stride), line);
    }
    lines
}

/// A line as it is now.
pub(crate) fn strand(
    line: &Polyline,
    node: impl Fn(usize) -> (Point3<f64>, Vector3<f64>),
    force: impl Fn(usize) -> Vector3<f64>,
    radius: f64,
) -> Strand {
    let (points, velocities): (Vec<_>, Vec<_>) = line.nodes.iter().map(|&n| node(n)).unzip();
    let frames = points.windows(2).map(|ends| frame(&(ends[1] - ends[0]))).collect();
    Strand {
        radii: vec![radius; points.len()],
        curvatures: vec![Vector3::zeros(); points.len()],
        frames,
        forces: line.springs.iter().map(|&s| force(s)).collect(),
        contact_forces: vec![Vector3::zeros(); points.len()],
        charges: vec![0.0; points.len()],
        points,
        velocities,
    }
}

/// The strand of every node of the lines, the first of them, and its number there.
pub(crate) fn places(lines: &[Polyline]) -> BTreeMap<usize, [usize; 2]> {
    let mut places = BTreeMap::new();
    for (l, line) in lines.iter().enumerate() {
        for (point, &node) in line.nodes.iter().enumerate() {
            places.entry(node).or_insert([l, point]);
        }
    }
    places
}

/// The faces, of nodes that have places, as a surface of points of strands; `None` without faces.
pub(crate) fn surface(
    places: &BTreeMap<usize, [usize; 2]>,
    faces: &[Vec<usize>],
) -> Option<usd::PrimShape> {
    let nodes: BTreeSet<usize> = faces.iter().flatten().copied().collect();
    let vertices: BTreeMap<usize, usize> = nodes.into_iter().zip(0..).collect();
    let face = |face: &Vec<usize>| face.iter().map(|node| vertices[node]).collect();
    let shape = usd::PrimShape::Surface {
        vertices: vertices.keys().map(|node| places[node]).collect(),
        faces: faces.iter().map(face).collect(),
    };
    (!faces.is_empty()).then_some(shape)
}

/// A frame with its d3 along a direction; that of the world for none.
fn frame(direction: &Vector3<f64>) -> Rotation3<f64> {
    let back = || Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    if direction.norm() == 0.0 {
        return Rotation3::identity();
    }
    Rotation3::rotation_between(&Vector3::z(), direction).unwrap_or_else(back)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lattice_is_drawn_in_rows_and_columns() {
        // Two rows of three.
        let springs = [[0, 1], [1, 2], [0, 3], [1, 4], [2, 5], [3, 4], [4, 5]];
        let lines = polylines(springs.into_iter());
        let nodes: Vec<_> = lines.iter().map(|line| line.nodes.clone()).collect();
        assert_eq!(nodes, [vec![0, 1, 2], vec![0, 3], vec![1, 4], vec![2, 5], vec![3, 4, 5]]);
        assert_eq!(lines.iter().map(|line| line.springs.len()).sum::<usize>(), springs.len());
        let faces = [vec![1, 4, 5, 2]];
        let vertices = vec![[0, 1], [0, 2], [2, 1], [3, 1]];
        let expected = usd::PrimShape::Surface { vertices, faces: vec![vec![0, 2, 3, 1]] };
        assert_eq!(surface(&places(&lines), &faces), Some(expected));
        assert_eq!(surface(&places(&lines), &[]), None);
    }
}
