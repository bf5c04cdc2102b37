//! Nearest points of many triangles.

use nalgebra::{Point3, Vector3};
use rapunzel_collision::nearest_weights;
use std::ops::{Add, Mul};

/// Triangles in a leaf at most.
const LEAF: usize = 4;

/// A point of a mesh of triangles: a face and the weights of its corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    face: u32,
    weights: [f64; 3],
}

impl SurfacePoint {
    /// The point of `face` with these weights, not negative and of sum 1.
    pub(super) fn new(face: u32, weights: [f64; 3]) -> Self {
        Self { face, weights }
    }

    /// Index of the triangle.
    #[must_use]
    pub fn face(&self) -> u32 {
        self.face
    }

    /// Weights of its corners (barycentric coordinates): not negative, of sum 1.
    #[must_use]
    pub fn weights(&self) -> [f64; 3] {
        self.weights
    }

    /// The value here of what is linear in the triangle and has these values at its corners.
    #[must_use]
    pub fn mix<T: Mul<f64, Output = T> + Add<Output = T>>(&self, [a, b, c]: [T; 3]) -> T {
        let [u, v, w] = self.weights;
        a * u + b * v + c * w
    }
}

/// A binary tree of boxes around triangles.
#[derive(Debug, Clone)]
pub(super) struct FaceTree {
    /// In the order of the leaves: the number and the corners.
    faces: Vec<(u32, [Point3<f64>; 3])>,
    /// A node before its descendants; its first child follows it.
    nodes: Vec<FaceNode>,
}

#[derive(Debug, Clone, Copy)]
struct FaceNode {
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Its faces.
    start: usize,
    end: usize,
    /// Its second child, or zero for a leaf.
    second: usize,
}

impl FaceTree {
    /// The tree of triangles, of which there is at least one. Cost: `n log n`.
    pub(super) fn new(triangles: impl Iterator<Item = [Point3<f64>; 3]>) -> Self {
        let faces = (0..).zip(triangles).collect();
        let mut tree = Self { faces, nodes: Vec::new() };
        tree.split(0, tree.faces.len());
        tree
    }

    /// Makes the node of some faces and all below.
    fn split(&mut self, start: usize, end: usize) {
        let far = Vector3::repeat(f64::INFINITY);
        let (mut low, mut high) = (far, -far);
        for p in self.faces[start..end].iter().flat_map(|(_, corners)| corners) {
            (low, high) = (low.inf(&p.coords), high.sup(&p.coords));
        }
        let node = self.nodes.len();
        self.nodes.push(FaceNode { low, high, start, end, second: 0 });
        if end - start > LEAF {
            let (axis, middle) = ((high - low).imax(), (end - start) / 2);
            let center = |corners: &[Point3<f64>; 3]| -> f64 {
                corners.iter().map(|p| p.coords[axis]).sum()
            };
            self.faces[start..end]
                .select_nth_unstable_by(middle, |a, b| center(&a.1).total_cmp(&center(&b.1)));
            self.split(start, start + middle);
            self.nodes[node].second = self.nodes.len();
            self.split(start + middle, end);
        }
    }

    /// The numbers of the triangles in an order in which near ones are near each other.
    pub(super) fn order(&self) -> impl Iterator<Item = u32> + '_ {
        self.faces.iter().map(|(face, _)| *face)
    }

    /// The point of all triangles that is nearest to a point; of several the first found. A point
    /// that is not finite has one all the same. Cost: logarithmic near the triangles.
    pub(super) fn nearest(&self, point: &Point3<f64>) -> SurfacePoint {
        let mut best = SurfacePoint { face: self.faces[0].0, weights: [1.0, 0.0, 0.0] };
        let mut least = f64::INFINITY;
        let mut stack = vec![(0, self.nodes[0].squared_distance(point))];
        while let Some((at, bound)) = stack.pop() {
            let node = self.nodes[at];
            if bound >= least {
                continue;
            }
            if node.second == 0 {
                for (face, corners) in &self.faces[node.start..node.end] {
                    let corners = corners.map(|p| p - point);
                    let weights = nearest_weights(&corners);
                    let candidate = SurfacePoint { face: *face, weights };
                    let squared = candidate.mix(corners).norm_squared();
                    if squared < least {
                        (least, best) = (squared, candidate);
                    }
                }
                continue;
            }
            // The nearer one is looked into first.
            let mut children =
                [at + 1, node.second].map(|i| (i, self.nodes[i].squared_distance(point)));
            if children[0].1 < children[1].1 {
                children.swap(0, 1);
            }
            stack.extend(children);
        }
        best
    }
}

impl FaceNode {
    fn squared_distance(&self, point: &Point3<f64>) -> f64 {
        (point.coords - point.coords.sup(&self.low).inf(&self.high)).norm_squared()
    }
}
