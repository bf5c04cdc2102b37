//! What does not change from frame to frame: strands with their thickness and colors, surfaces.

use crate::frame::{count, single, sixteen};
use rapunzel_export::Strand;
use rapunzel_export::surface::Placed;
use rapunzel_export::usd::{Prim, PrimShape};
use rapunzel_studio::sheet::Support;

/// The first bytes of a layout.
const MARK: &[u8; 4] = b"RPL1";
/// Color of strands that no prim has: a brown hair, linear.
const HAIR: [f64; 3] = [0.25, 0.13, 0.06];
/// Color of the strands of the second of two runs: a blue that no hair has, linear.
const SECOND: [f64; 3] = [0.05, 0.16, 0.42];

/// What a layout is made of.
pub(crate) struct Parts<'a> {
    pub(crate) number: u32,
    pub(crate) strands: &'a [Strand],
    pub(crate) prims: &'a [Prim],
    pub(crate) supports: &'a [Support],
    pub(crate) objects: &'a [Placed],
    /// Whether the strands are springs, which one sees from close by, and not hair.
    pub(crate) springs: bool,
    /// Strands of the first of two runs that are shown together.
    pub(crate) first_of_two: Option<usize>,
}

/// The bytes of a layout, little-endian: mark, number (u32), whether the strands are springs (u32),
/// numbers of strands, points, triangles, supports and objects (5 u32); points of each strand
/// (u32), color of each strand (3 u8 of the square root of linear values, and 0), radius of each
/// point (f32), corners of triangles as points (u32), supports as points with their kind (2 u32);
/// of each object numbers of vertices and triangles (2 u32), vertices in its own frame (3 f32) and
/// corners (3 u32).
pub(crate) fn layout(parts: &Parts) -> Vec<u8> {
    let Parts { number, strands, prims, supports, objects, springs, first_of_two } = parts;
    let starts: Vec<usize> = strands
        .iter()
        .scan(0, |end, strand| {
            let start = *end;
            *end += strand.points.len();
            Some(start)
        })
        .collect();
    let points = strands.iter().map(|strand| strand.points.len()).sum();
    let point = |[strand, point]: [usize; 2]| count(starts.get(strand).map_or(0, |s| s + point));
    let triangles = triangles(prims);
    let mut bytes = Vec::new();
    let mut put = |number: u32| bytes.extend(number.to_le_bytes());
    put(u32::from_le_bytes(*MARK));
    put(*number);
    put((*springs).into());
    for of in [strands.len(), points, triangles.len(), supports.len(), objects.len()] {
        put(count(of));
    }
    strands.iter().for_each(|strand| put(count(strand.points.len())));
    for index in 0..strands.len() {
        let is_second = first_of_two.is_some_and(|first| index >= first);
        let linear = if is_second { SECOND } else { color(prims, index) };
        put(u32::from_le_bytes(seen(linear)));
    }
    for radius in strands.iter().flat_map(|strand| &strand.radii) {
        put(single(*radius).to_bits());
    }
    triangles.iter().flatten().for_each(|corner| put(point(*corner)));
    for support in *supports {
        put(point([support.strand, support.point]));
        put(support.clamped.into());
    }
    for Placed { pose, surface } in *objects {
        put(count(surface.vertices.len()));
        put(count(surface.triangles.len()));
        for vertex in &surface.vertices {
            let own = pose.inverse_transform_point(vertex);
            own.iter().for_each(|x| put(single(*x).to_bits()));
        }
        surface.triangles.iter().flatten().for_each(|corner| put(count(*corner as usize)));
    }
    bytes
}

/// The triangles of all surfaces, as fans of their faces, of points of strands.
fn triangles(prims: &[Prim]) -> Vec<[[usize; 2]; 3]> {
    let of = |prim: &Prim| match &prim.shape {
        PrimShape::Curves { .. } => Vec::new(),
        PrimShape::Surface { vertices, faces } => {
            let fan = |face: &Vec<usize>| {
                let corner = |k: usize| vertices[face[k]];
                let last = face.len().saturating_sub(1);
                (1..last).map(|k| [corner(0), corner(k), corner(k + 1)]).collect::<Vec<_>>()
            };
            faces.iter().flat_map(fan).collect()
        }
    };
    prims.iter().flat_map(of).collect()
}

/// The color of a strand, linear.
fn color(prims: &[Prim], index: usize) -> [f64; 3] {
    let has = |prim: &&Prim| match &prim.shape {
        PrimShape::Curves { strands, .. } => strands.contains(&index),
        PrimShape::Surface { .. } => false,
    };
    prims.iter().find(has).map_or(HAIR, |prim| prim.color)
}

/// Red, green and blue of a linear color as square roots, which is nearly what eyes see.
fn seen(linear: [f64; 3]) -> [u8; 4] {
    let [r, g, b] = linear.map(|x| sixteen(x.max(0.0).sqrt() * 255.0).min(255).to_le_bytes()[0]);
    [r, g, b, 0]
}
