use crate::ContactError;
use nalgebra::Vector2;
use std::sync::Arc;

/// An edge this near to the origin, relative to the polygon, passes through it.
const ORIGIN_MARGIN: f64 = 1e-13;

/// A convex polygon that contains the origin, inside or on its border; it may be a segment or a
/// point.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Counterclockwise, none repeated, no three on a line; shared by all clones.
    vertices: Arc<[Vector2<f64>]>,
    /// Where the origin is inside, the number of vertices that are less than half a turn from the
    /// first; else zero.
    half: usize,
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
        let polygon = Self::with_vertices(hull(points).into());
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
        (0..self.vertices.len()).map(|i| self.edge(i))
    }

    /// The polygon reflected at the origin.
    pub(super) fn reflected(&self) -> Self {
        Self::with_vertices(self.vertices.iter().map(|v| -v).collect())
    }

    /// The polygon with these vertices, counterclockwise and convex.
    fn with_vertices(vertices: Arc<[Vector2<f64>]>) -> Self {
        let size = vertices.iter().map(Vector2::amax).fold(0.0, f64::max);
        let mut polygon = Self { vertices, half: 0 };
        let around =
            polygon.edges().all(|(a, b)| a.perp(&b) > ORIGIN_MARGIN * size * (b - a).norm());
        if around && size > 0.0 {
            let first = polygon.vertices[0];
            polygon.half = polygon.vertices.iter().filter(|v| first.perp(v) > 0.0).count() + 1;
        }
        polygon
    }

    /// Where the origin is inside: which edge the ray through `p` passes.
    fn sector(&self, p: &Vector2<f64>) -> usize {
        let (from, to) = if self.vertices[0].perp(p) >= 0.0 {
            (0, self.half)
        } else {
            (self.half, self.vertices.len())
        };
        let passed = self.vertices[from..to].partition_point(|v| v.perp(p) >= 0.0);
        (from + passed + self.vertices.len() - 1) % self.vertices.len()
    }

    /// Vertex number `i` and the next.
    fn edge(&self, i: usize) -> (Vector2<f64>, Vector2<f64>) {
        (self.vertices[i], self.vertices[(i + 1) % self.vertices.len()])
    }

    /// Point of the polygon scaled by `scale` that is nearest to `p`.
    pub(super) fn project(&self, p: &Vector2<f64>, scale: f64) -> Vector2<f64> {
        if self.half == 0 {
            return self.project_by_search(p, scale);
        }
        // From the edge that the ray through p passes, which p sees, along the border to where it
        // is nearest.
        let count = self.vertices.len();
        let mut i = self.sector(p);
        let (start, end) = self.edge(i);
        if (end - start).perp(&(p - start * scale)) >= 0.0 {
            return *p;
        }
        for _ in 0..2 * count {
            let (a, b) = self.edge(i);
            let edge = b - a;
            if edge.dot(&(p - b * scale)) > 0.0 {
                let (_, next) = self.edge((i + 1) % count);
                if (next - b).dot(&(p - b * scale)) <= 0.0 {
                    return b * scale;
                }
                i = (i + 1) % count;
            } else if edge.dot(&(p - a * scale)) < 0.0 {
                let (previous, _) = self.edge((i + count - 1) % count);
                if (a - previous).dot(&(p - a * scale)) >= 0.0 {
                    return a * scale;
                }
                i = (i + count - 1) % count;
            } else {
                return foot(p, &(a * scale), &(b * scale));
            }
        }
        self.project_by_search(p, scale)
    }

    /// Point of the scaled polygon that is nearest to `p`, by a look at every edge.
    fn project_by_search(&self, p: &Vector2<f64>, scale: f64) -> Vector2<f64> {
        let mut inside = self.vertices.len() > 2;
        let (mut nearest, mut distance) = (*p, f64::INFINITY);
        for (a, b) in self.edges() {
            inside &= (b - a).perp(&(p - a * scale)) >= 0.0;
            let candidate = foot(p, &(a * scale), &(b * scale));
            let square = (p - candidate).norm_squared();
            if square < distance {
                (nearest, distance) = (candidate, square);
            }
        }
        if inside { *p } else { nearest }
    }

    /// Vertex farthest along `direction`, the first if there are two; zero if that is zero.
    pub(super) fn support(&self, direction: &Vector2<f64>) -> Vector2<f64> {
        if direction.amax() <= 0.0 {
            return Vector2::zeros();
        }
        let along = |i: usize| direction.dot(&self.vertices[i]);
        let count = self.vertices.len();
        if self.half == 0 {
            let higher = |best, i| if along(i) > along(best) { i } else { best };
            return self.vertices[(1..count).fold(0, higher)];
        }
        // From where the ray along the direction leaves it rises to one vertex, or to two that are
        // alike.
        let mut best = self.sector(direction);
        loop {
            let beside = [(best + 1) % count, (best + count - 1) % count];
            let Some(higher) = beside.into_iter().find(|&i| along(i) > along(best)) else {
                let alike = beside.into_iter().filter(|&i| along(i) >= along(best));
                return self.vertices[alike.fold(best, usize::min)];
            };
            best = higher;
        }
    }

    /// Factor by which the polygon must be scaled to pass through `p`; infinite where none does.
    pub(super) fn gauge(&self, p: &Vector2<f64>) -> f64 {
        if p.amax() <= 0.0 {
            return 0.0;
        }
        if self.half > 0 {
            let (a, b) = self.edge(self.sector(p));
            return (p.perp(&(b - a)) / a.perp(&b)).max(0.0);
        }
        if self.vertices.len() == 2 {
            // What does not leave the segment's line is compared to the end on its side.
            let (a, b) = self.edge(0);
            let end = self.support(p).dot(p);
            let aside = (b - a).perp(p).abs() > ORIGIN_MARGIN * (b - a).norm() * p.norm();
            return if end > 0.0 && !aside { p.norm_squared() / end } else { f64::INFINITY };
        }
        // Every edge's line bounds the scale from below; an edge through the origin allows none or
        // any.
        let size = self.vertices.iter().map(Vector2::amax).fold(0.0, f64::max);
        let mut gauge: f64 = 0.0;
        for (a, b) in self.edges() {
            let edge = b - a;
            let (outside, offset) = (p.perp(&edge), a.perp(&b));
            if offset > ORIGIN_MARGIN * size * edge.norm() {
                gauge = gauge.max(outside / offset);
            } else if outside > ORIGIN_MARGIN * edge.norm() * p.norm() || size <= 0.0 {
                return f64::INFINITY;
            }
        }
        gauge
    }
}

/// The point between `a` and `b` nearest to `p`, from the nearer of the two so that it is met
/// exactly.
fn foot(p: &Vector2<f64>, a: &Vector2<f64>, b: &Vector2<f64>) -> Vector2<f64> {
    let edge = b - a;
    let length_squared = edge.norm_squared();
    let along = edge.dot(&(p - a));
    if along <= 0.0 || length_squared <= 0.0 {
        *a
    } else if along >= length_squared {
        *b
    } else if 2.0 * along < length_squared {
        a + edge * (along / length_squared)
    } else {
        b + edge * (edge.dot(&(p - b)) / length_squared)
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn component() -> impl Strategy<Value = f64> {
        prop_oneof![(-2..=2_i8).prop_map(f64::from), -1.0..1.0_f64]
    }

    proptest! {
        /// Also where vertices are alike along the direction.
        #[test]
        fn the_support_is_the_first_of_the_farthest_vertices(
            points in prop::collection::vec(prop::array::uniform2(-3..=3_i8), 3..40),
            direction in prop::array::uniform2(component()),
        ) {
            let points: Vec<_> =
                points.into_iter().map(|p| Vector2::from(p.map(f64::from))).collect();
            let Ok(polygon) = Polygon::new(&points) else { return Ok(()) };
            let direction = Vector2::from(direction);
            let far = |v: &Vector2<f64>| direction.dot(v);
            let most = polygon.vertices().iter().map(far).fold(f64::NEG_INFINITY, f64::max);
            let first = polygon.vertices().iter().find(|v| far(v) >= most);
            let expected =
                if direction.amax() > 0.0 { first.copied() } else { Some(Vector2::zeros()) };
            prop_assert_eq!(Some(polygon.support(&direction)), expected);
        }
    }
}
