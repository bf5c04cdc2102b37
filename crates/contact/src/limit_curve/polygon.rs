use crate::ContactError;
use nalgebra::Vector2;
use std::sync::Arc;

/// A convex polygon that contains the origin, inside or on its border; it may be a segment or a
/// point.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Counterclockwise, none repeated, no three on a line; shared by all clones.
    vertices: Arc<[Vector2<f64>]>,
}

impl Polygon {
    /// The convex hull of `points`, thesis (8.48): `mu_beta d_beta` with directions `d_beta` and
    /// coefficients `mu_beta`. The order starts at the first point that is a vertex.
    ///
    /// # Errors
    /// [`ContactError::Invalid`] for no points, a point that is not finite and a hull that does not
    /// contain the origin.
    pub fn new(points: &[Vector2<f64>]) -> Result<Self, ContactError> {
        let size = points.iter().map(Vector2::amax).fold(0.0, f64::max);
        if points.is_empty() || points.iter().any(|p| !(p.x.is_finite() && p.y.is_finite())) {
            let value = points.iter().map(Vector2::sum).find(|x| !x.is_finite()).unwrap_or(0.0);
            return Err(ContactError::Invalid {
                what: "vertex of a limit polygon",
                value,
                why: "there must be at least one, and all finite",
            });
        }
        let polygon = Self { vertices: hull(points).into() };
        let nearest = polygon.project(&Vector2::zeros(), 1.0).norm();
        if nearest > 1e-12 * size {
            return Err(ContactError::Invalid {
                what: "distance of a limit polygon from the origin",
                value: nearest,
                why: "the origin must be inside: a contact can always do without friction",
            });
        }
        Ok(polygon)
    }

    /// The vertices, counterclockwise.
    #[must_use]
    pub fn vertices(&self) -> &[Vector2<f64>] {
        &self.vertices
    }

    /// Every vertex and the next; a segment has two edges, a point one.
    fn edges(&self) -> impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> + '_ {
        let count = self.vertices.len();
        (0..count).map(move |i| (self.vertices[i], self.vertices[(i + 1) % count]))
    }

    pub(super) fn reflected(&self) -> Self {
        Self { vertices: self.vertices.iter().map(|v| -v).collect() }
    }

    pub(super) fn project(&self, p: &Vector2<f64>, scale: f64) -> Vector2<f64> {
        let mut inside = self.vertices.len() > 2 && scale > 0.0;
        let (mut nearest, mut distance) = (*p, f64::INFINITY);
        for (a, b) in self.edges() {
            let (edge, to) = ((b - a) * scale, p - a * scale);
            inside &= edge.perp(&to) >= 0.0;
            let length_squared = edge.norm_squared();
            let along = if length_squared > 0.0 {
                (edge.dot(&to) / length_squared).clamp(0.0, 1.0)
            } else {
                0.0
            };
            // From the nearer end, so that the end itself is met exactly.
            let candidate = if along < 0.5 {
                a * scale + edge * along
            } else {
                b * scale - edge * (1.0 - along)
            };
            let square = (p - candidate).norm_squared();
            if square < distance {
                (nearest, distance) = (candidate, square);
            }
        }
        if inside { *p } else { nearest }
    }

    pub(super) fn support(&self, direction: &Vector2<f64>) -> Vector2<f64> {
        if direction.amax() <= 0.0 {
            return Vector2::zeros();
        }
        let mut best = self.vertices[0];
        for vertex in &self.vertices[1..] {
            if direction.dot(vertex) > direction.dot(&best) {
                best = *vertex;
            }
        }
        best
    }

    /// Every edge's line bounds the scale from below; an edge through the origin allows none or any.
    pub(super) fn gauge(&self, p: &Vector2<f64>) -> f64 {
        if p.amax() <= 0.0 {
            return 0.0;
        }
        let size = self.vertices.iter().map(Vector2::amax).fold(0.0, f64::max);
        let mut gauge: f64 = 0.0;
        for (a, b) in self.edges() {
            let edge = b - a;
            let (outside, offset) = (-edge.perp(p), a.perp(&b));
            if offset > 1e-13 * size * edge.norm() {
                gauge = gauge.max(outside / offset);
            } else if outside > 1e-13 * edge.norm() * p.norm() || size <= 0.0 {
                return f64::INFINITY;
            }
        }
        if self.vertices.len() == 2 {
            // Both edges pass through the origin: what remains is how far the ends are.
            let end = self.support(p).dot(p);
            gauge = if end > 0.0 { p.norm_squared() / end } else { f64::INFINITY };
        }
        gauge
    }
}

/// Vertices of the convex hull, counterclockwise from the point that was given first (monotone
/// chain, Andrew 1979).
fn hull(points: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&i, &j| {
        let (p, q) = (points[i], points[j]);
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(i.cmp(&j))
    });
    order.dedup_by(|j, i| points[*i] == points[*j]);
    if order.len() < 3 {
        order.sort_unstable();
        return order.into_iter().map(|i| points[i]).collect();
    }
    let half = |order: &mut dyn Iterator<Item = usize>| {
        let mut chain: Vec<usize> = Vec::new();
        for i in order {
            while let [.., a, b] = chain[..] {
                let (edge, to) = (points[b] - points[a], points[i] - points[b]);
                if edge.perp(&to) > 1e-14 * edge.norm() * to.norm() {
                    break;
                }
                chain.pop();
            }
            chain.push(i);
        }
        chain.pop();
        chain
    };
    let mut ring = half(&mut order.iter().copied());
    ring.extend(half(&mut order.iter().rev().copied()));
    let start = (0..ring.len()).min_by_key(|&k| ring[k]).unwrap_or(0);
    ring.rotate_left(start);
    ring.into_iter().map(|i| points[i]).collect()
}
