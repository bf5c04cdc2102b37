//! The nearest point of many triangles, by a hierarchy of boxes.

use super::Soup;
use super::mesh::index;
use crate::CollisionError;
use crate::triangle::nearest_weights;
use nalgebra::{Point3, Vector3};
use std::f64::consts::PI;

/// Triangles of a leaf.
const LEAF: usize = 4;

/// The place of a surface that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPoint {
    /// Index of the triangle.
    pub face: usize,
    /// Weights of its corners; exactly zero where the place lies on the opposite side.
    pub weights: [f64; 3],
    /// The place (world), m.
    pub point: Point3<f64>,
    /// Distance from the point that was asked about, m.
    pub distance: f64,
}

/// Triangles in a binary hierarchy of axis-parallel boxes. They need not be closed, connected or
/// oriented.
#[derive(Debug, Clone)]
pub struct SurfaceTree {
    corners: Vec<[Point3<f64>; 3]>,
    /// Triangles in the order of the leaves.
    order: Vec<u32>,
    boxes: Vec<TreeBox>,
}

#[derive(Debug, Clone, Copy)]
struct TreeBox {
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Triangles of a leaf, from and to in `order`; for an inner box both are the place of its
    /// second child. The first child follows the box.
    range: [u32; 2],
}

impl TreeBox {
    fn squared_distance(&self, p: &Vector3<f64>) -> f64 {
        (self.low - p).sup(&(p - self.high)).sup(&Vector3::zeros()).norm_squared()
    }
}

impl SurfaceTree {
    /// The hierarchy of the triangles of `soup`. Cost: `n log n`.
    ///
    /// # Errors
    /// [`CollisionError::NoTriangles`], [`CollisionError::Vertex`], [`CollisionError::Face`].
    pub fn new(soup: &Soup) -> Result<Self, CollisionError> {
        soup.check()?;
        Ok(Self::of(soup))
    }

    /// The hierarchy of triangles that have been checked.
    pub(super) fn of(soup: &Soup) -> Self {
        let corners: Vec<_> = soup.triangles.iter().map(|&t| soup.corners(t)).collect();
        let order = (0..index(corners.len())).collect();
        let mut tree = Self { corners, order, boxes: Vec::new() };
        tree.split(0, tree.order.len());
        tree
    }

    /// Adds the box of the triangles at `from..to` of the order, and all below it.
    fn split(&mut self, from: usize, to: usize) {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(-f64::INFINITY));
        for &face in &self.order[from..to] {
            for p in &self.corners[face as usize] {
                low = low.inf(&p.coords);
                high = high.sup(&p.coords);
            }
        }
        let here = self.boxes.len();
        self.boxes.push(TreeBox { low, high, range: [index(from), index(to)] });
        if to - from <= LEAF {
            return;
        }
        let axis = (high - low).imax();
        let corners = &self.corners;
        let middle = |face: u32| corners[face as usize].iter().map(|p| p[axis]).sum::<f64>();
        let half = (to - from) / 2;
        self.order[from..to]
            .select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
        self.split(from, from + half);
        self.boxes[here].range = [index(self.boxes.len()); 2];
        self.split(from + half, to);
    }

    /// The triangles in an order in which near ones are near each other.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Corners of the triangles (world), m.
    pub(super) fn corners(&self) -> &[[Point3<f64>; 3]] {
        &self.corners
    }

    /// What is found first at the triangles of the leaves that meet the box from `low` to `high`
    /// (world), m.
    pub(super) fn find_near<T>(
        &self,
        low: &Vector3<f64>,
        high: &Vector3<f64>,
        find: impl Fn(u32) -> Option<T>,
    ) -> Option<T> {
        let mut stack = vec![0];
        while let Some(at) = stack.pop() {
            let node: &TreeBox = &self.boxes[at];
            if (node.high - low).min() < 0.0 || (high - node.low).min() < 0.0 {
                continue;
            }
            let [from, to] = node.range.map(|i| i as usize);
            if from == to {
                stack.extend([at + 1, from]);
                continue;
            }
            let found = self.order[from..to].iter().find_map(|&face| find(face));
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// The nearest point of all triangles. Cost: about the logarithm of their number.
    #[must_use]
    pub fn nearest(&self, point: &Point3<f64>) -> NearestPoint {
        self.nearest_within(point, f64::INFINITY).unwrap_or(NearestPoint {
            face: 0,
            weights: [1.0, 0.0, 0.0],
            point: self.corners[0][0],
            distance: f64::INFINITY,
        })
    }

    /// The nearest point of all triangles, if it is closer than `limit`, m.
    #[must_use]
    pub fn nearest_within(&self, point: &Point3<f64>, limit: f64) -> Option<NearestPoint> {
        let p = point.coords;
        let mut best = None;
        let mut least = limit * limit;
        // Boxes to look into with their distances; the nearer one of two is on top.
        let mut stack = Vec::with_capacity(64);
        stack.push((0_usize, self.boxes[0].squared_distance(&p)));
        while let Some((at, bound)) = stack.pop() {
            if bound >= least {
                continue;
            }
            let node = &self.boxes[at];
            let [from, to] = node.range.map(|i| i as usize);
            if from == to {
                let mut children = [at + 1, from].map(|c| (c, self.boxes[c].squared_distance(&p)));
                if children[0].1 < children[1].1 {
                    children.swap(0, 1);
                }
                stack.extend(children);
                continue;
            }
            for &face in &self.order[from..to] {
                let corners = self.corners[face as usize].map(|c| c - point);
                let weights = nearest_weights(&corners);
                let way: Vector3<f64> = (0..3).map(|k| weights[k] * corners[k]).sum();
                if way.norm_squared() < least {
                    least = way.norm_squared();
                    best = Some((face as usize, weights, way));
                }
            }
        }
        best.map(|(face, weights, way)| NearestPoint {
            face,
            weights,
            point: point + way,
            distance: least.sqrt(),
        })
    }

    /// How often the triangles wind around a point: the sum of their solid angles over `4 pi` (van
    /// Oosterom and Strackee 1983). Of a closed surface 1 inside and 0 outside; of one with holes
    /// or crossings about that. Cost: all triangles.
    #[must_use]
    pub fn winding_number(&self, point: &Point3<f64>) -> f64 {
        let angles = self.corners.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| corner - point);
            let [x, y, z] = [a.norm(), b.norm(), c.norm()];
            let below = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
            2.0 * a.dot(&b.cross(&c)).atan2(below)
        });
        angles.sum::<f64>() / (4.0 * PI)
    }
}
