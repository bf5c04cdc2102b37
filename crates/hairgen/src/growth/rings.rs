//! What a vertex of an open, oriented mesh has around it.

use crate::HairgenError;
use rapunzel_collision::CollisionError;

/// The neighbors of every vertex, counter-clockwise seen from outside. At the border they begin
/// with the next vertex of the border and end with the one before.
#[derive(Debug, Clone)]
pub(super) struct Rings {
    starts: Vec<usize>,
    neighbors: Vec<u32>,
    open: Vec<bool>,
}

impl Rings {
    /// Rings of the vertices `0..count`, each of which is in a triangle; `sources` are the numbers
    /// by which errors call them.
    pub(super) fn new(
        count: usize,
        triangles: &[[u32; 3]],
        sources: &[u32],
    ) -> Result<Self, HairgenError> {
        check_edges(triangles, sources)?;
        // A triangle a b c has the link from b to c in the ring of a.
        let mut links: Vec<[u32; 3]> = Vec::with_capacity(3 * triangles.len());
        for &[a, b, c] in triangles {
            links.extend([[a, b, c], [b, c, a], [c, a, b]]);
        }
        links.sort_unstable();
        let (mut starts, mut neighbors) = (vec![0], Vec::with_capacity(links.len() + count));
        let mut open = Vec::with_capacity(count);
        for links in links.chunk_by(|a, b| a[0] == b[0]) {
            // What no link leads to is the beginning; in a closed ring all are.
            let mut targets: Vec<u32> = links.iter().map(|link| link[2]).collect();
            targets.sort_unstable();
            let first = links.iter().map(|link| link[1]);
            let first = first.clone().find(|from| targets.binary_search(from).is_err());
            let mut at = first.unwrap_or(links[0][1]);
            neighbors.push(at);
            for step in 1..=links.len() {
                let found = links.binary_search_by_key(&at, |link| link[1]);
                let Ok(next) = found.map(|place| links[place][2]) else {
                    return Err(pinch(links[0][0], sources));
                };
                at = next;
                let closed = first.is_none() && at == links[0][1];
                if closed && step < links.len() {
                    return Err(pinch(links[0][0], sources));
                }
                if !closed {
                    neighbors.push(at);
                }
            }
            starts.push(neighbors.len());
            open.push(first.is_some());
        }
        Ok(Self { starts, neighbors, open })
    }

    /// The neighbors of a vertex.
    pub(super) fn of(&self, vertex: u32) -> &[u32] {
        &self.neighbors[self.starts[vertex as usize]..self.starts[vertex as usize + 1]]
    }

    /// Whether a vertex is at the border.
    pub(super) fn is_open(&self, vertex: u32) -> bool {
        self.open[vertex as usize]
    }

    /// The sides opposite to a vertex in its triangles, each with its two ends.
    pub(super) fn opposite_sides(&self, vertex: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        let ring = self.of(vertex);
        let sides = if self.is_open(vertex) { ring.len() - 1 } else { ring.len() };
        (0..sides).map(move |k| [ring[k], ring[(k + 1) % ring.len()]])
    }

    /// Number of connected parts, and a vertex that is not in the first.
    pub(super) fn parts(&self) -> (usize, u32) {
        let mut seen = vec![false; self.open.len()];
        let (mut parts, mut second) = (0, 0);
        for start in (0..).take(self.open.len()) {
            if seen[start as usize] {
                continue;
            }
            parts += 1;
            if parts == 2 {
                second = start;
            }
            seen[start as usize] = true;
            let mut stack = vec![start];
            while let Some(vertex) = stack.pop() {
                for &next in self.of(vertex) {
                    if !std::mem::replace(&mut seen[next as usize], true) {
                        stack.push(next);
                    }
                }
            }
        }
        (parts, second)
    }

    /// All borders, each with its vertices in order.
    pub(super) fn borders(&self) -> Vec<Vec<u32>> {
        let mut seen = vec![false; self.open.len()];
        let mut borders = Vec::new();
        for start in (0..).take(self.open.len()).filter(|&v| self.is_open(v)) {
            let (mut border, mut at) = (Vec::new(), start);
            while !std::mem::replace(&mut seen[at as usize], true) {
                border.push(at);
                at = self.of(at)[0];
            }
            if !border.is_empty() {
                borders.push(border);
            }
        }
        borders
    }
}

/// Every edge is of at most two triangles, which run through it in opposite directions.
fn check_edges(triangles: &[[u32; 3]], sources: &[u32]) -> Result<(), HairgenError> {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (face, &[a, b, c]) in triangles.iter().enumerate() {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            sides.push(([a.min(b), a.max(b)], face, a < b));
        }
    }
    sides.sort_unstable();
    for sides in sides.chunk_by(|a, b| a.0 == b.0) {
        let problem = match sides {
            [_] => continue,
            [first, second] if first.2 != second.2 => continue,
            [_, _] => "is between faces of opposite orientation; turn one of them",
            _ => "is between more than two faces; remove all but two",
        };
        let (ends, face, _) = sides[0];
        let vertices = ends.map(|v| sources[v as usize]);
        return Err(HairgenError::scalp(CollisionError::Edge { face, vertices, problem }));
    }
    Ok(())
}

fn pinch(vertex: u32, sources: &[u32]) -> HairgenError {
    HairgenError::ScalpPinch { vertex: sources[vertex as usize] }
}
