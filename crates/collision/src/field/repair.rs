//! Treatment of meshes that are not closed and oriented.

use super::mesh::{Mesh, Soup, TriangleSide, index};
use crate::CollisionError;
use nalgebra::{Point3, Vector3};
use std::fmt;

/// What was done to a mesh.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Vertices at the place of another one that were merged with it.
    pub merged_vertices: usize,
    /// Triangles removed because two of their corners were one vertex.
    pub degenerate_faces: usize,
    /// Triangles removed because they met more than one other at an edge.
    pub non_manifold_faces: usize,
    /// Triangles whose corners were put in the other order.
    pub reversed_faces: usize,
    /// Holes that were closed by triangles around their centroid.
    pub closed_holes: usize,
}

impl fmt::Display for Repairs {
    /// What was done, one after the other; nothing if that is so.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let done = [
            (self.merged_vertices, "vertices merged"),
            (self.degenerate_faces, "folded faces removed"),
            (self.non_manifold_faces, "faces at edges of more than two removed"),
            (self.reversed_faces, "faces turned"),
            (self.closed_holes, "holes closed"),
        ];
        let done = done.iter().filter(|(count, _)| *count > 0);
        let told: Vec<_> = done.map(|(count, what)| format!("{what}: {count}")).collect();
        f.write_str(&told.join(", "))
    }
}

impl Mesh {
    /// A mesh from triangles that need not be closed or oriented, and what was done to them.
    ///
    /// In this order: vertices at exactly one place are merged, and triangles with a corner twice
    /// removed; all triangles at an edge of more than two are removed; neighbors are oriented
    /// alike, each connected part as its first triangle; every hole, also an intended one such as
    /// that of an open neck, is closed by a fan around the centroid of its rim; parts that had to
    /// be turned in places, and all parts together if the volume is not positive, are turned
    /// outward.
    ///
    /// # Errors
    /// As [`Mesh::new`] for what this does not repair: [`CollisionError::Edge`] of a part that
    /// cannot be oriented, [`CollisionError::Face`] of a triangle without area.
    pub fn repaired(mut soup: Soup) -> Result<(Self, Repairs), CollisionError> {
        let mut repairs = soup.weld()?;
        let mut crowded = vec![false; soup.triangles.len()];
        for sides in soup.sides().chunk_by(|a, b| a.ends == b.ends).filter(|s| s.len() > 2) {
            sides.iter().for_each(|side| crowded[side.face as usize] = true);
        }
        repairs.non_manifold_faces = soup.keep(|face, _| !crowded[face]);
        repairs.reversed_faces = soup.orient()?;
        repairs.closed_holes = soup.close();
        if soup.volume() < 0.0 {
            soup.turn_over(&mut repairs);
        }
        Ok((Self::new(soup)?, repairs))
    }
}

impl Soup {
    /// An open surface from triangles that need not share vertices or be oriented, and what was
    /// done to them: as [`Mesh::repaired`], but holes stay, and so do triangles at an edge of more
    /// than two. `outward` is the outward direction (world) at a place, of any length: most of the
    /// surface faces there.
    ///
    /// # Errors
    /// As [`SurfaceTree::new`](super::SurfaceTree::new), and [`CollisionError::Edge`] of a part
    /// that cannot be oriented.
    pub fn repaired(
        mut self,
        outward: impl Fn(&Point3<f64>) -> Vector3<f64>,
    ) -> Result<(Self, Repairs), CollisionError> {
        let mut repairs = self.weld()?;
        repairs.reversed_faces = self.orient()?;
        let facing = |&triangle: &[u32; 3]| {
            let [a, b, c] = self.corners(triangle);
            let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
            (b - a).cross(&(c - a)).dot(&outward(&middle))
        };
        if self.triangles.iter().map(facing).sum::<f64>() < 0.0 {
            self.turn_over(&mut repairs);
        }
        Ok((self, repairs))
    }

    /// Merges vertices and removes folded triangles.
    fn weld(&mut self) -> Result<Repairs, CollisionError> {
        self.check()?;
        let merged_vertices = self.merge_vertices();
        let degenerate_faces = self.keep(|_, [a, b, c]| a != b && b != c && c != a);
        Ok(Repairs { merged_vertices, degenerate_faces, ..Repairs::default() })
    }

    /// Turns all triangles, after some have been.
    fn turn_over(&mut self, repairs: &mut Repairs) {
        self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        repairs.reversed_faces = self.triangles.len() - repairs.reversed_faces;
    }

    /// Keeps the triangles that are wanted, and returns how many are not.
    fn keep(&mut self, wanted: impl Fn(usize, [u32; 3]) -> bool) -> usize {
        let before = self.triangles.len();
        let mut face = 0;
        self.triangles.retain(|&triangle| {
            face += 1;
            wanted(face - 1, triangle)
        });
        before - self.triangles.len()
    }

    /// Lets all triangles use the first of the vertices at one place; the others stay, unused.
    fn merge_vertices(&mut self) -> usize {
        let place = |&v: &u32| self.vertices[v as usize].coords.map(|x| (x + 0.0).to_bits());
        let mut order: Vec<u32> = (0..index(self.vertices.len())).collect();
        order.sort_by_key(|v| <[u64; 3]>::from(place(v)));
        let mut first = vec![0; order.len()];
        let mut merged = 0;
        for group in order.chunk_by(|a, b| place(a) == place(b)) {
            group.iter().for_each(|&v| first[v as usize] = group[0]);
            merged += group.len() - 1;
        }
        for vertex in self.triangles.as_flattened_mut() {
            *vertex = first[*vertex as usize];
        }
        merged
    }

    /// Orients neighbors alike, and returns how many triangles were turned. At most two triangles
    /// are at each edge.
    fn orient(&mut self) -> Result<usize, CollisionError> {
        let mut neighbors = vec![Vec::new(); self.triangles.len()];
        let sides = self.sides();
        for pair in sides.chunk_by(|a, b| a.ends == b.ends) {
            if let [a, b] = pair {
                let same = a.forward == b.forward;
                neighbors[a.face as usize].push((b, same));
                neighbors[b.face as usize].push((a, same));
            }
        }
        let mut turned: Vec<Option<bool>> = vec![None; self.triangles.len()];
        let mut count = 0;
        for start in 0..self.triangles.len() {
            if turned[start].is_some() {
                continue;
            }
            turned[start] = Some(false);
            let mut part = vec![start];
            let mut next = 0;
            while let Some(&face) = part.get(next) {
                next += 1;
                for &(side, same) in &neighbors[face] {
                    let there = side.face as usize;
                    let needed = turned[face] != Some(same);
                    match turned[there] {
                        None => {
                            turned[there] = Some(needed);
                            part.push(there);
                        }
                        Some(is) if is != needed => return Err(one_sided(side)),
                        Some(_) => {}
                    }
                }
            }
            count += self.turn(&part, &turned);
        }
        Ok(count)
    }

    /// Turns the triangles of a part that are to be turned, or, if then the part faces inward, the
    /// others. A part with none to be turned stays: it may be a cavity.
    fn turn(&mut self, part: &[usize], turned: &[Option<bool>]) -> usize {
        let wanted = |&&face: &&usize| turned[face] == Some(true);
        if !part.iter().any(|face| wanted(&face)) {
            return 0;
        }
        part.iter().filter(wanted).for_each(|&face| self.triangles[face].swap(1, 2));
        let triangles: Vec<_> = part.iter().map(|&face| self.triangles[face]).collect();
        if self.volume_of(&triangles) < 0.0 {
            part.iter().for_each(|&face| self.triangles[face].swap(1, 2));
            return part.len() - part.iter().filter(wanted).count();
        }
        part.iter().filter(wanted).count()
    }

    /// Closes all holes of an oriented surface with at most two triangles at each edge, and returns
    /// how many there were.
    fn close(&mut self) -> usize {
        // The rim runs against the sides of the triangles.
        let mut rim: Vec<[u32; 2]> = self
            .sides()
            .chunk_by(|a, b| a.ends == b.ends)
            .filter(|sides| sides.len() == 1)
            .map(|sides| {
                let [a, b] = sides[0].ends;
                if sides[0].forward { [b, a] } else { [a, b] }
            })
            .collect();
        rim.sort_unstable_by(|a, b| b.cmp(a));
        let mut holes = 0;
        while let Some([first, mut last]) = rim.pop() {
            let mut path = vec![first];
            loop {
                // Where the rim meets itself, what lies between is a hole of its own.
                if let Some(k) = path.iter().position(|&v| v == last) {
                    self.fan(&path.split_off(k));
                    holes += 1;
                    if k == 0 {
                        break;
                    }
                }
                path.push(last);
                // Sorted backward: the sides from `last` are together.
                let from = rim.partition_point(|side| side[0] > last);
                match rim.get(from) {
                    Some(side) if side[0] == last => last = rim.remove(from)[1],
                    _ => break,
                }
            }
        }
        holes
    }

    /// Closes a hole with triangles from its centroid to the sides of its rim.
    fn fan(&mut self, hole: &[u32]) {
        if let &[a, b, c] = hole {
            self.triangles.push([a, b, c]);
            return;
        }
        let sum: Vector3<f64> = hole.iter().map(|&v| self.vertices[v as usize].coords).sum();
        let center = index(self.vertices.len());
        self.vertices.push(Point3::from(sum / hole.len() as f64));
        for k in 0..hole.len() {
            self.triangles.push([hole[k], hole[(k + 1) % hole.len()], center]);
        }
    }
}

fn one_sided(side: &TriangleSide) -> CollisionError {
    CollisionError::Edge {
        face: side.face as usize,
        vertices: side.ends,
        problem: "is on a part that has only one side and bounds nothing; remove it",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::shapes;

    fn cuboid() -> Soup {
        shapes::cuboid(Vector3::new(1.0, 2.0, 3.0))
    }

    #[test]
    fn a_good_mesh_stays_as_it_is() {
        let soup = shapes::torus(3.0, 1.0, [9, 7]);
        let (mesh, repairs) = Mesh::repaired(soup.clone()).expect("a mesh");
        assert_eq!((repairs, repairs.to_string().as_str()), (Repairs::default(), ""));
        assert_eq!(mesh, Mesh::new(soup).expect("a mesh"));
    }

    #[test]
    fn triangles_in_any_order_are_turned_outward() {
        for turned in
            [[0, 3, 8].as_slice(), &[0, 1, 2, 3, 5, 6, 7, 8, 9], &(0..12).collect::<Vec<_>>()]
        {
            let mut soup = cuboid();
            turned.iter().for_each(|&face| soup.triangles[face].swap(0, 1));
            let (mesh, repairs) = Mesh::repaired(soup).expect("a mesh");
            assert_eq!(repairs.reversed_faces, turned.len());
            assert!((mesh.volume() - 48.0).abs() <= 1e-12);
        }
    }

    #[test]
    fn holes_are_closed() {
        // A side of two triangles, and a triangle elsewhere.
        let mut soup = cuboid();
        soup.triangles.remove(3);
        soup.triangles.drain(0..2);
        let (mesh, repairs) = Mesh::repaired(soup).expect("a mesh");
        assert_eq!(repairs.closed_holes, 2);
        assert!((mesh.volume() - 48.0).abs() <= 1e-12);
    }

    #[test]
    fn a_soup_without_neighbors_is_welded() {
        let soup = cuboid();
        let vertices = soup.triangles.as_flattened().iter().map(|&v| soup.vertices[v as usize]);
        let loose = Soup {
            vertices: vertices.collect(),
            triangles: (0..12).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        };
        let (mesh, repairs) = Mesh::repaired(loose).expect("a mesh");
        assert_eq!(repairs, Repairs { merged_vertices: 28, ..Repairs::default() });
        assert!((mesh.volume() - 48.0).abs() <= 1e-12);
    }

    #[test]
    fn fins_and_folded_triangles_are_removed() {
        let mut soup = cuboid();
        soup.vertices.push(Point3::new(9.0, 9.0, 9.0));
        soup.triangles.push([0, 4, 8]);
        soup.triangles.push([3, 3, 5]);
        let (mesh, repairs) = Mesh::repaired(soup).expect("a mesh");
        assert_eq!((repairs.degenerate_faces, repairs.non_manifold_faces), (1, 3));
        let told =
            "folded faces removed: 1, faces at edges of more than two removed: 3, holes closed: 1";
        assert_eq!(repairs.to_string(), told);
        // The two faces at the edge of the fin were removed with it, and their place filled with a
        // fan that cuts off half of the tetrahedron of their corners.
        assert_eq!(repairs.closed_holes, 1);
        assert!((mesh.volume() - 44.0).abs() <= 1e-12);
    }

    /// The upper half of a ball, inside out, in places turned again, without neighbors.
    #[test]
    fn an_open_surface_stays_open_and_faces_outward() {
        let ball = shapes::sphere(1.0, 4);
        let is_upper = |t: &[u32; 3]| t.iter().all(|&v| ball.vertices[v as usize].y > -1e-9);
        let upper: Vec<_> = ball.triangles.iter().copied().filter(is_upper).collect();
        let mut inward = upper.clone();
        inward.iter_mut().for_each(|t| t.swap(0, 1));
        inward[7].swap(1, 2);
        let vertices = inward.as_flattened().iter().map(|&v| ball.vertices[v as usize]);
        let loose = Soup {
            vertices: vertices.collect(),
            triangles: (0..index(inward.len())).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        };
        let (mended, repairs) = loose.repaired(|p| p.coords).expect("a surface");
        assert_eq!(mended.triangles.len(), upper.len());
        assert_eq!((repairs.reversed_faces, repairs.closed_holes), (upper.len() - 1, 0));
        for &triangle in &mended.triangles {
            let [a, b, c] = mended.corners(triangle);
            assert!((b - a).cross(&(c - a)).dot(&a.coords) > 0.0);
        }
        let good = Soup { triangles: upper, ..ball };
        let (same, repairs) = good.clone().repaired(|p| p.coords).expect("a surface");
        assert_eq!((same, repairs), (good, Repairs::default()));
    }

    #[test]
    fn a_moebius_strip_is_refused() {
        let vertices = (0..10).map(|k| {
            let angle = f64::from(k / 2) * std::f64::consts::TAU / 5.0;
            let half = if k % 2 == 0 { 0.3 } else { -0.3 };
            let radius = 1.0 + half * (0.5 * angle).cos();
            Point3::new(radius * angle.cos(), radius * angle.sin(), half * (0.5 * angle).sin())
        });
        let strip = |k: u32| [[k, k + 1, k + 2], [k + 1, k + 3, k + 2]];
        let mut triangles: Vec<_> = (0..4).flat_map(|k| strip(2 * k)).collect();
        triangles.extend([[8, 9, 1], [9, 0, 1]]);
        let error = Mesh::repaired(Soup { vertices: vertices.collect(), triangles });
        assert!(matches!(error, Err(CollisionError::Edge { .. })));
    }
}
