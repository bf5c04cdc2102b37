//! Fibres as swept curves: tubes around cubics or straight pieces, round or elliptical.

mod capsules;
mod cubic;
mod fiber;
mod tube;

use crate::check::check;
use crate::tree::{Tree, TreeRay, Walk, rounding, short, single, walk};
use crate::{Ray, RenderError};
use capsules::{Capsule, CapsuleBlock, CapsuleLeaves, MovingEnds, Part};
use cubic::Cubic;
pub use fiber::FiberCurve;
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::spline::control_points;
use rayon::prelude::*;
use tube::Tube;
pub(crate) use tube::across;
pub use tube::{CurveHit, TubePoint};

/// How a curve runs through the nodes of a fibre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveBasis {
    /// A cubic spline with continuous curvature, a uniform B-spline.
    Cubic,
    /// Straight from node to node; the tubes of neighbours are open at a bend.
    Linear,
}

/// Fibres as tubes, in a tree that finds where rays meet them.
///
/// A point of a tube lies in the normal plane of a point of its curve, on the section around it. A
/// tube is open at its ends, and only where a ray comes in from outside it is met: light that a
/// fibre scatters goes on from where it came in.
#[derive(Debug, Clone)]
pub struct Curves {
    basis: CurveBasis,
    /// Semi-axes of the section over the radius; none if it is round.
    aspect: Option<[f64; 2]>,
    /// First control point of each fibre, and the number of all.
    starts: Vec<u32>,
    /// Control points (world), m; a piece is named by the first of its four (two if linear).
    control: Vec<Point3<f64>>,
    /// What is given at nodes, at the places of control points.
    radii: Vec<f32>,
    axes: Vec<Vector3<f32>>,
    ways: Vec<Vector3<f32>>,
    tree: Tree,
    blocks: Vec<CapsuleBlock>,
    /// Ways of both ends of the capsules, where something moves.
    moving: Vec<MovingEnds>,
    middle: Point3<f64>,
    extent: f64,
}

impl Curves {
    /// Tubes around fibres; `ratio` is that of the second semi-axis of their elliptical sections to
    /// the first, none for round ones. Cost: see the bench `rays`.
    ///
    /// # Errors
    /// [`RenderError::Curve`] names the fibre that has too few nodes, lists of other lengths, or
    /// what is not finite or not positive; [`RenderError::Parameter`] refuses a ratio.
    pub fn new(
        basis: CurveBasis,
        ratio: Option<f64>,
        fibers: &[FiberCurve],
    ) -> Result<Self, RenderError> {
        if let Some(ratio) = ratio {
            check(
                "the ratio of semi-axes",
                ratio,
                "positive and finite",
                ratio > 0.0 && ratio.is_finite(),
            )?;
        }
        let aspect = ratio.map(|ratio| [ratio.sqrt().recip(), ratio.sqrt()]);
        let moves = fibers.iter().any(|fiber| !fiber.ways.is_empty());
        let mut curves = Self {
            basis,
            aspect,
            starts: vec![0],
            control: Vec::new(),
            radii: Vec::new(),
            axes: Vec::new(),
            ways: Vec::new(),
            tree: Tree::new(Vec::new()).0,
            blocks: Vec::new(),
            moving: Vec::new(),
            middle: Point3::origin(),
            extent: 0.0,
        };
        for (index, fiber) in fibers.iter().enumerate() {
            fiber.check(index, aspect.is_some())?;
            curves.add(fiber, moves);
        }
        let count = curves.control.len();
        check("the number of all nodes", count as f64, "at most 2^27", count <= Part::PIECES)?;
        curves.enclose();
        curves.plant();
        Ok(curves)
    }

    /// Number of fibres.
    #[must_use]
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of nodes of all fibres.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.control.len() - self.len() * self.phantoms()
    }

    /// Control points of a fibre that are no nodes.
    fn phantoms(&self) -> usize {
        match self.basis {
            CurveBasis::Cubic => 2,
            CurveBasis::Linear => 0,
        }
    }

    /// What is given at the nodes of all fibres, one after another, at a point of a tube.
    pub(crate) fn between(&self, point: &TubePoint, at_nodes: &[Vector3<f32>]) -> Vector3<f32> {
        let first = self.starts[point.fiber] as usize - point.fiber * self.phantoms();
        let last = self.starts[point.fiber + 1] as usize - (point.fiber + 1) * self.phantoms() - 1;
        let whole = point.node.floor();
        let [t] = single(&[point.node - whole]);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place")]
        let node = (first + whole.max(0.0) as usize).min(last - 1);
        at_nodes[node] * (1.0 - t) + at_nodes[node + 1] * t
    }

    /// Whether there is no fibre.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Two corners of a box that holds all tubes (world), m; none if there is no fibre.
    #[must_use]
    pub fn bounds(&self) -> Option<[Point3<f64>; 2]> {
        let widest = self.radii.iter().fold(0.0_f32, |a, b| a.max(*b));
        let reach = Vector3::repeat(f64::from(widest) * self.aspect.map_or(1.0, |[a, b]| a.max(b)));
        let moved = self.control.iter().zip(&self.ways).map(|(point, way)| point + way.cast());
        let all = self.control.iter().copied().chain(moved);
        let hull = all.fold(None, |hull: Option<[Point3<f64>; 2]>, p| {
            let [low, high] = hull.unwrap_or([p; 2]);
            Some([low.inf(&p), high.sup(&p)])
        });
        hull.map(|[low, high]| [low - reach, high + reach])
    }

    /// Memory of all, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.control.as_slice())
            + size_of_val(self.radii.as_slice())
            + size_of_val(self.axes.as_slice())
            + size_of_val(self.ways.as_slice())
            + size_of_val(self.blocks.as_slice())
            + size_of_val(self.moving.as_slice())
            + self.tree.bytes()
    }

    /// The first place where a ray comes into a tube, farther than `range[0]` and nearer than
    /// `range[1]`, m. Cost: see the bench `rays`.
    #[must_use]
    pub fn hit(&self, ray: &Ray, range: [f64; 2]) -> Option<CurveHit> {
        self.walk(ray, range, Walk::Nearest)
    }

    /// Whether a ray comes into any tube between two distances, m.
    #[must_use]
    pub fn hides(&self, ray: &Ray, range: [f64; 2]) -> bool {
        self.walk(ray, range, Walk::Any).is_some()
    }

    fn walk(&self, ray: &Ray, range: [f64; 2], until: Walk) -> Option<CurveHit> {
        let mut in_tree = TreeRay::new(ray, range, &self.middle, self.extent)?;
        let across = across(&ray.direction).map(|axis| single(&axis.into()));
        let mut leaves = CapsuleLeaves { curves: self, ray, range, across };
        walk(&self.tree, &mut leaves, &mut in_tree, until)
    }

    /// What is at a hit of a ray.
    #[must_use]
    pub fn at(&self, ray: &Ray, hit: &CurveHit) -> TubePoint {
        let CurveHit { distance, piece, parameter } = *hit;
        let tube = self.tube(piece as usize, ray.time, &ray.origin);
        let fiber = self.starts.partition_point(|start| *start <= piece).saturating_sub(1);
        let first = self.starts.get(fiber).map_or(0, |start| *start);
        let node = f64::from(piece - first) + parameter;
        tube.point(ray, distance, parameter, fiber, node)
    }

    fn add(&mut self, fiber: &FiberCurve, moves: bool) {
        let control = |nodes: &[Point3<f64>]| match self.basis {
            CurveBasis::Cubic => control_points(nodes),
            CurveBasis::Linear => nodes.to_vec(),
        };
        let points = control(&fiber.nodes);
        if moves {
            let way = |k: usize| fiber.ways.get(k).copied().unwrap_or_default();
            let moved: Vec<_> = fiber.nodes.iter().enumerate().map(|(k, x)| x + way(k)).collect();
            let ways = control(&moved).into_iter().zip(&points).map(|(b, a)| (b - a).cast());
            self.ways.extend(ways);
        }
        let at_nodes = |k: usize| {
            let before = usize::from(self.basis == CurveBasis::Cubic);
            k.saturating_sub(before).min(fiber.nodes.len() - 1)
        };
        let places = || (0..points.len()).map(at_nodes);
        self.radii.extend(places().map(|k| single(&[fiber.radii[k]])[0]));
        if self.aspect.is_some() {
            self.axes.extend(places().map(|k| fiber.axes[k].normalize().cast::<f32>()));
        }
        self.control.extend(points);
        self.starts.push(short(self.control.len()));
    }

    /// Finds the middle and the extent of all.
    fn enclose(&mut self) {
        if let Some([low, high]) = self.bounds() {
            self.middle = nalgebra::center(&low, &high);
            // What is flat still has an inside.
            self.extent = (0.5 * (high - low).amax()).max(f64::MIN_POSITIVE) * (1.0 + 1e-6);
        }
    }

    /// Makes the tree.
    fn plant(&mut self) {
        let behind = short(Cubic::points(self.basis)) - 1;
        let of_fiber = |ends: &[u32]| {
            let pieces = ends[0]..ends[1] - behind;
            pieces.flat_map(|piece| Part::all(piece, &self.tube(piece as usize, 0.0, &self.middle)))
        };
        let parts: Vec<Part> = self.starts.par_windows(2).flat_map_iter(of_fiber).collect();
        let spare = rounding(self.extent);
        let capsule = |part: Part| {
            let tube = |time| self.tube(part.piece(), time, &self.middle);
            let start = tube(0.0);
            let end = if self.ways.is_empty() { start } else { tube(1.0) };
            Capsule::new(part, &[start, end], spare)
        };
        let boxes = parts.par_iter().map(|part| capsule(*part).bounds()).collect();
        let (tree, leaves) = Tree::new(boxes);
        let of = |index: u32| capsule(parts[index as usize]);
        let blocks = leaves.par_iter().map(|leaf| CapsuleBlock::new(leaf, of)).collect();
        let moving = if self.ways.is_empty() {
            Vec::new()
        } else {
            leaves.par_iter().map(|leaf| MovingEnds::new(leaf, of)).collect()
        };
        (self.tree, self.blocks, self.moving) = (tree, blocks, moving);
    }

    /// The piece that begins at a control point, at a time of the exposure, from `origin`.
    #[inline(always)]
    fn tube(&self, piece: usize, time: f64, origin: &Point3<f64>) -> Tube {
        let count = Cubic::points(self.basis);
        let control = &self.control[piece..piece + count];
        let cubic = if self.ways.is_empty() {
            Cubic::new(self.basis, control, origin)
        } else {
            let mut moved = [Point3::origin(); 4];
            for (k, moved) in moved[..count].iter_mut().enumerate() {
                *moved = control[k] + time * self.ways[piece + k].cast();
            }
            Cubic::new(self.basis, &moved[..count], origin)
        };
        let node = piece + usize::from(self.basis == CurveBasis::Cubic);
        let radii = [f64::from(self.radii[node]), f64::from(self.radii[node + 1])];
        let (axes, aspect) = match self.aspect {
            Some(aspect) => (Some([self.axes[node].cast(), self.axes[node + 1].cast()]), aspect),
            None => (None, [1.0; 2]),
        };
        Tube { cubic, radii, axes, aspect }
    }
}
