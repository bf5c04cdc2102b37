use crate::{StrandSet, StrandsError};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::Soup;
use rapunzel_collision::nearest_weights;

/// A surface of triangles, open or closed, that is searched for its nearest point.
#[derive(Debug, Clone)]
pub struct ScalpMesh {
    /// Corners of the triangles, in the order of the tree (world), m.
    triangles: Vec<[Point3<f64>; 3]>,
    /// Boxes of a binary tree, level by level: of all triangles, of both halves, and so on.
    boxes: Vec<[Point3<f64>; 2]>,
    /// Number of levels below the root.
    depth: u32,
}

/// Most triangles of a leaf of the tree.
const LEAF: usize = 8;

/// What snapping did to the roots of strands.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapped {
    /// Largest distance that a strand was moved, m.
    pub largest: f64,
    /// Mean distance that the strands were moved, m.
    pub mean: f64,
    /// Strands that stayed where they are, because their roots are too far from the scalp.
    pub far: Vec<usize>,
}

impl ScalpMesh {
    /// Builds the tree. Cost: a selection of the middle on each of its levels.
    ///
    /// # Errors
    /// [`StrandsError::Scalp`] without triangles, and for one with a corner that is not there or
    /// not finite.
    pub fn new(scalp: &Soup) -> Result<Self, StrandsError> {
        let refuse = |problem: String| StrandsError::Scalp { problem };
        let place = |(face, corners): (usize, &[u32; 3])| {
            let corners = corners.map(|v| scalp.vertices.get(v as usize).copied());
            let [Some(a), Some(b), Some(c)] = corners else {
                return Err(refuse(format!("triangle {face} has a corner that is not there")));
            };
            if [a, b, c].iter().all(|p| p.iter().all(|x| x.is_finite())) {
                Ok([a, b, c])
            } else {
                Err(refuse(format!("triangle {face} has a corner that is not finite; repair it")))
            }
        };
        let mut triangles =
            scalp.triangles.iter().enumerate().map(place).collect::<Result<Vec<_>, _>>()?;
        if triangles.is_empty() {
            return Err(refuse("it has no triangles; give a surface".into()));
        }
        let mut depth = 0;
        while triangles.len() > LEAF << depth {
            depth += 1;
        }
        // Every level halves its parts along the longest sides of their boxes.
        for level in 0..depth {
            for part in 0..1 << level {
                let start = first(part, level, triangles.len());
                let end = first(part + 1, level, triangles.len());
                let middle = first(2 * part + 1, level + 1, triangles.len());
                let [low, high] = hull(&triangles[start..end]);
                let axis = (high - low).imax();
                let key = |t: &[Point3<f64>; 3]| t[0][axis] + t[1][axis] + t[2][axis];
                triangles[start..end]
                    .select_nth_unstable_by(middle - start, |a, b| key(a).total_cmp(&key(b)));
            }
        }
        let nodes = (0..=depth).flat_map(|level| (0..1 << level).map(move |part| (part, level)));
        let count = triangles.len();
        let hull = |(part, level)| {
            hull(&triangles[first(part, level, count)..first(part + 1, level, count)])
        };
        let boxes = nodes.map(hull).collect();
        Ok(Self { triangles, boxes, depth })
    }

    /// The nearest point of the surface to a point (world), m. A point that is not finite has
    /// any. Cost: a few boxes on each level of the tree.
    #[must_use]
    pub fn nearest(&self, point: &Point3<f64>) -> Point3<f64> {
        let mut best = self.triangles[0][0];
        let mut least = (best - point).norm_squared();
        // Nodes to be searched, with their squared distances; the nearest is on top.
        let mut open = vec![(self.squared(0, point), 0, 0)];
        while let Some((squared, part, level)) = open.pop() {
            if squared >= least {
                continue;
            }
            if level < self.depth {
                let child = |part| (self.squared(part + (2 << level) - 1, point), part, level + 1);
                let [a, b] = [child(2 * part), child(2 * part + 1)];
                open.extend(if a.0 < b.0 { [b, a] } else { [a, b] });
                continue;
            }
            let count = self.triangles.len();
            for corners in &self.triangles[first(part, level, count)..first(part + 1, level, count)]
            {
                let relative = corners.map(|corner| corner - point);
                let weights = nearest_weights(&relative);
                let offset: Vector3<f64> = (0..3).map(|k| weights[k] * relative[k]).sum();
                if offset.norm_squared() < least {
                    (best, least) = (point + offset, offset.norm_squared());
                }
            }
        }
        best
    }

    /// Squared distance of a point from a box.
    fn squared(&self, node: usize, point: &Point3<f64>) -> f64 {
        let [low, high] = &self.boxes[node];
        let outside = (low - point).sup(&(point - high)).sup(&Vector3::zeros());
        outside.norm_squared()
    }
}

/// Index of the first of `count` triangles in a part of a level.
fn first(part: usize, level: u32, count: usize) -> usize {
    (part * count) >> level
}

/// The smallest box around triangles.
fn hull(triangles: &[[Point3<f64>; 3]]) -> [Point3<f64>; 2] {
    let corners = triangles.as_flattened();
    let start = [corners[0]; 2];
    corners.iter().fold(start, |[low, high], p| [low.inf(p), high.sup(p)])
}

impl StrandSet {
    /// Moves every strand as a whole so that its root is the nearest point of a scalp.
    ///
    /// Its shape and length stay as they are, which is what a rod is made of; fading the move out
    /// toward the tip would bend and stretch it. Strands whose roots are farther than `most`, m,
    /// from the scalp stay too, and are listed: a tail that starts at a band, or a scalp in other
    /// units.
    ///
    /// # Errors
    /// [`StrandsError::Option`] if `most` is negative or not a number.
    pub fn snap(&mut self, scalp: &ScalpMesh, most: f64) -> Result<Snapped, StrandsError> {
        if most.is_nan() || most < 0.0 {
            let (what, must) = ("the farthest distance of a root", "zero or more");
            return Err(StrandsError::Option { what, value: most.to_string(), must });
        }
        let mut out = Snapped { largest: 0.0, mean: 0.0, far: Vec::new() };
        let mut sum = 0.0;
        for strand in 0..self.len() {
            let points = self.strand_mut(strand);
            let root = scalp.nearest(&points[0]);
            let way = root - points[0];
            if way.norm() > most {
                out.far.push(strand);
                continue;
            }
            points.iter_mut().for_each(|point| *point += way);
            // Exactly, without rounding.
            points[0] = root;
            out.largest = out.largest.max(way.norm());
            sum += way.norm();
        }
        let moved = self.len() - out.far.len();
        out.mean = sum / moved.max(1) as f64;
        Ok(out)
    }
}
