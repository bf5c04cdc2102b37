use super::fiber::FiberCurve;
use super::piece::{CurveForm, CurvePiece};
use super::tube::{CurveHit, Tube, TubePoint};
use crate::Ray;
use crate::tree::{short, single};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::spline::control_points;

/// A control point of a curve, and what a ray needs beside it: both in half a line of the cache.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
struct CurveControl {
    /// World, m.
    position: Point3<f64>,
    /// Radius at the node at this place, m.
    radius: f64,
}

/// Curves with their sections, fibre after fibre.
#[derive(Debug, Clone)]
pub(super) struct CurveStore {
    form: CurveForm,
    /// Semi-axes of the section over the radius; none if it is round.
    aspect: Option<[f64; 2]>,
    /// First control point of each fibre, and the number of all.
    starts: Vec<u32>,
    /// A piece is named by the first of its four control points (two if linear).
    control: Vec<CurveControl>,
    /// What is given at nodes, at the places of control points.
    axes: Vec<Vector3<f32>>,
    ways: Vec<Vector3<f32>>,
}

impl CurveStore {
    /// No curve yet, but room for some fibres with so many nodes in all.
    pub(super) fn new(form: CurveForm, aspect: Option<[f64; 2]>, room: [usize; 2]) -> Self {
        let [fibers, nodes] = room;
        let (starts, control) = (vec![0], Vec::with_capacity(nodes + 2 * fibers));
        Self { form, aspect, starts, control, axes: Vec::new(), ways: Vec::new() }
    }

    /// Adds a fibre that was checked; `moves` if any of all moves.
    pub(super) fn add(&mut self, fiber: &FiberCurve, moves: bool) {
        let control = |nodes: &[Point3<f64>]| match self.form {
            CurveForm::Cubic => control_points(nodes),
            CurveForm::Linear => nodes.to_vec(),
        };
        let points = control(&fiber.nodes);
        if moves {
            let way = |k: usize| fiber.ways.get(k).copied().unwrap_or_default();
            let moved: Vec<_> = fiber.nodes.iter().enumerate().map(|(k, x)| x + way(k)).collect();
            let ways = control(&moved).into_iter().zip(&points).map(|(b, a)| (b - a).cast());
            self.ways.extend(ways);
        }
        let before = self.before();
        let last = fiber.nodes.len() - 1;
        let places = || (0..points.len()).map(|k| k.saturating_sub(before).min(last));
        if self.aspect.is_some() {
            self.axes.extend(places().map(|k| fiber.axes[k].normalize().cast::<f32>()));
        }
        let radii = places().map(|k| fiber.radii[k]);
        let point = |(position, radius)| CurveControl { position, radius };
        self.control.extend(points.into_iter().zip(radii).map(point));
        self.starts.push(short(self.control.len()));
    }

    /// Number of fibres.
    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of control points of all fibres.
    pub(super) fn points(&self) -> usize {
        self.control.len()
    }

    /// Number of nodes of all fibres.
    pub(super) fn nodes(&self) -> usize {
        self.control.len() - self.len() * 2 * self.before()
    }

    /// Whether anything moves during the exposure.
    pub(super) fn moves(&self) -> bool {
        !self.ways.is_empty()
    }

    /// Control points of a fibre before its first node, and behind its last.
    fn before(&self) -> usize {
        usize::from(self.form == CurveForm::Cubic)
    }

    /// The first pieces and the ends of the pieces of all fibres.
    pub(super) fn pieces(&self) -> impl Iterator<Item = [u32; 2]> {
        let behind = short(CurvePiece::points(self.form)) - 1;
        self.starts.windows(2).map(move |ends| [ends[0], ends[1] - behind])
    }

    /// Two corners of a box that holds all tubes at all times (world), m.
    pub(super) fn bounds(&self) -> Option<[Point3<f64>; 2]> {
        let widest = self.control.iter().fold(0.0, |widest: f64, point| widest.max(point.radius));
        let reach = Vector3::repeat(widest * self.aspect.map_or(1.0, |[a, b]| a.max(b)));
        let points = || self.control.iter().map(|point| point.position);
        let all = points().chain(points().zip(&self.ways).map(|(point, way)| point + way.cast()));
        let hull = all.fold(None, |hull: Option<[Point3<f64>; 2]>, p| {
            let [low, high] = hull.unwrap_or([p; 2]);
            Some([low.inf(&p), high.sup(&p)])
        });
        hull.map(|[low, high]| [low - reach, high + reach])
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.control.as_slice())
            + size_of_val(self.axes.as_slice())
            + size_of_val(self.ways.as_slice())
    }

    /// The piece that begins at a control point, at a time of the exposure, from `origin`.
    #[inline(always)]
    pub(super) fn tube(&self, piece: usize, time: f64, origin: &Point3<f64>) -> Tube {
        let count = CurvePiece::points(self.form);
        let control = &self.control[piece..piece + count];
        let mut from = [Vector3::zeros(); 4];
        for (k, from) in from[..count].iter_mut().enumerate() {
            *from = control[k].position - origin;
        }
        if !self.ways.is_empty() {
            for (k, from) in from[..count].iter_mut().enumerate() {
                *from += time * self.ways[piece + k].cast();
            }
        }
        let curve = CurvePiece::new(self.form, &from);
        let before = self.before();
        let node = piece + before;
        let radii = [control[before].radius, control[before + 1].radius];
        let (axes, aspect) = match self.aspect {
            Some(aspect) => (Some([self.axes[node].cast(), self.axes[node + 1].cast()]), aspect),
            None => (None, [1.0; 2]),
        };
        Tube { curve, radii, axes, aspect }
    }

    /// What is at a hit of a ray.
    pub(super) fn at(&self, ray: &Ray, hit: &CurveHit) -> TubePoint {
        let CurveHit { distance, piece, parameter } = *hit;
        let tube = self.tube(piece as usize, ray.time, &ray.origin);
        let fiber = self.starts.partition_point(|start| *start <= piece).saturating_sub(1);
        let first = self.starts.get(fiber).map_or(0, |start| *start);
        let node = f64::from(piece - first) + parameter;
        tube.point(ray, distance, parameter, fiber, node)
    }

    /// What is given at the nodes of all fibres, one after another, at a point of a tube.
    pub(super) fn between(&self, point: &TubePoint, at_nodes: &[Vector3<f32>]) -> Vector3<f32> {
        let node = |fiber: usize| self.starts[fiber] as usize - fiber * 2 * self.before();
        let (first, last) = (node(point.fiber), node(point.fiber + 1) - 1);
        let whole = point.node.floor();
        let [t] = single(&[point.node - whole]);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place")]
        let node = (first + whole.max(0.0) as usize).min(last - 1);
        at_nodes[node] * (1.0 - t) + at_nodes[node + 1] * t
    }
}
