//! The growth region.

mod disc_map;
mod geodesic;
pub(crate) mod image;
mod pores;
mod region;
mod scalp;

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rapunzel_collision::field::Soup;
use rapunzel_hairgen::growth::ScalpMesh;
use rapunzel_oracles::data;
use std::fs::File;
use std::io::BufReader;

/// A surface of revolution about y: a pole, and rings of as many vertices, each with its radius and
/// height.
fn bowl(spokes: u32, rings: &[[f64; 2]]) -> Soup {
    let mut vertices = vec![Point3::new(0.0, rings[0][1], 0.0)];
    let mut triangles = Vec::new();
    for (ring, [radius, height]) in (0..).zip(rings) {
        for spoke in 0..spokes {
            let angle = std::f64::consts::TAU * f64::from(spoke) / f64::from(spokes);
            vertices.push(Point3::new(radius * angle.sin(), *height, radius * angle.cos()));
            let next = (spoke + 1) % spokes;
            let [c, d] = [spoke, next].map(|k| 1 + ring * spokes + k);
            if ring == 0 {
                triangles.push([0, c, d]);
            } else {
                let [a, b] = [c - spokes, d - spokes];
                triangles.extend([[a, c, d], [a, d, b]]);
            }
        }
    }
    Soup { vertices, triangles }
}

/// A flat disc of radius 1, y up.
fn flat(spokes: u32, rings: u32) -> Soup {
    let ring = |k: u32| [f64::from(k) / f64::from(rings), 0.0];
    bowl(spokes, &(1..=rings).map(ring).collect::<Vec<_>>())
}

/// A part of a sphere around the origin, from its top down to an angle.
fn cap(radius: f64, angle: f64, spokes: u32, rings: u32) -> Soup {
    let ring = |k: u32| {
        let (sin, cos) = (angle * f64::from(k) / f64::from(rings)).sin_cos();
        [radius * sin, radius * cos]
    };
    let mut soup = bowl(spokes, &(1..=rings).map(ring).collect::<Vec<_>>());
    soup.vertices[0].y = radius;
    soup
}

/// A lattice of squares along x and z, each cut along one of its diagonals, its inner vertices
/// moved by at most a quarter of a square each way, all lifted by heights.
#[derive(Debug, Clone)]
struct Cloth {
    /// Squares along x and z.
    squares: [usize; 2],
    moves: Vec<[f64; 3]>,
    cuts: Vec<bool>,
}

impl Cloth {
    fn soup(&self) -> Soup {
        let [columns, rows] = self.squares;
        let mut soup = Soup::default();
        for k in 0..(columns + 1) * (rows + 1) {
            let (i, j) = (k % (columns + 1), k / (columns + 1));
            let inner = 0 < i && i < columns && 0 < j && j < rows;
            let [x, height, z] = self.moves[k];
            let part = if inner { 0.25 } else { 0.0 };
            let (i, j) = (i as f64, j as f64);
            soup.vertices.push(Point3::new(i + part * x, height, -j - part * z));
        }
        for k in 0..columns * rows {
            let at = |right: usize, down: usize| {
                let v = (k / columns + down) * (columns + 1) + k % columns + right;
                u32::try_from(v).expect("few")
            };
            let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            let cut = self.cuts[k];
            soup.triangles.extend(if cut {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            });
        }
        soup
    }
}

/// Cloths with heights up to some squares.
fn cloth(height: f64) -> impl Strategy<Value = Cloth> {
    (1..9_usize, 1..9_usize).prop_flat_map(move |(columns, rows)| {
        let count = (columns + 1) * (rows + 1);
        let one = (-1.0..1.0_f64, -1.0..=1.0_f64, -1.0..1.0_f64);
        let one = one.prop_map(move |(x, y, z)| [x, height * y, z]);
        let cuts = prop::collection::vec(any::<bool>(), columns * rows);
        (prop::collection::vec(one, count), cuts).prop_map(move |(moves, cuts)| Cloth {
            squares: [columns, rows],
            moves,
            cuts,
        })
    })
}

fn mesh(soup: Soup) -> ScalpMesh {
    ScalpMesh::new(soup).expect("a disc")
}

/// A scalp of the data that is not shipped.
fn scan(name: &str) -> Option<ScalpMesh> {
    let file = File::open(data(name)?).expect("readable");
    Some(mesh(Soup::read_ply(BufReader::new(file)).expect("a PLY")))
}

const SCALPS: [&str; 2] = ["head/scalp.ply", "beethoven/scalp.ply"];

/// Numbers in `[0, 1)` of a sequence of low discrepancy in three dimensions (R. Kronecker; the
/// constants of M. Roberts).
fn spread(k: usize) -> Vector3<f64> {
    let g = 1.220_744_084_605_759_5_f64;
    Vector3::new(1.0, 2.0, 3.0).map(|power| (0.5 + k as f64 * g.powf(-power)).fract())
}
