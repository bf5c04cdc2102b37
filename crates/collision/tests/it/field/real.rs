//! Scans of real surfaces, where they are at hand.

use super::scan::{distance, winding};
use crate::geometry::random::Random;
use nalgebra::Point3;
use rapunzel_collision::field::{DistanceField, Grid, HeightField, Mesh, Soup};
use rapunzel_oracles::data;
use std::fs::File;
use std::io::BufReader;
use std::time::Instant;

/// The grid against the distance to all triangles, and the winding number, near the surface.
fn check(name: &str, closed: usize) {
    let Some(path) = data(name) else { return };
    let file = File::open(path).expect("readable");
    let soup = Soup::read_ply(BufReader::new(file)).expect("a PLY");
    let (mesh, repairs) = Mesh::repaired(soup).expect("a mesh");
    assert_eq!(repairs.closed_holes, closed, "{repairs:?}");
    let start = Instant::now();
    let (spacing, band) = (2e-3, 8e-3);
    let grid = Grid::scan(&mesh, spacing, band).expect("a grid");
    let [stored, all] = grid.blocks();
    println!(
        "{name}: {} faces, {repairs:?}, {stored} of {all} blocks, {} MB, {:?}",
        mesh.triangles().len(),
        grid.bytes() / 1_000_000,
        start.elapsed(),
    );
    let mut random = Random::new(1);
    for triangle in mesh.triangles().iter().step_by(mesh.triangles().len() / 200) {
        let p = mesh.vertices()[triangle[0] as usize] + random.vector(0.5 * band);
        let (value, exact) = (grid.value(&p), distance(&mesh, &p));
        assert!((value.abs() - exact.min(band)).abs() <= grid.error(), "{value} for {exact}");
        if exact > grid.error() {
            assert_eq!(value < 0.0, winding(&mesh, &p) > 0.5);
        }
    }
}

#[test]
fn a_head_open_at_the_neck_is_closed() {
    check("head/head.ply", 1);
}

#[test]
fn scanned_busts_are_read() {
    check("bust_wreath/bust.ply", 2);
    check("beethoven/bust.ply", 10);
}

#[test]
fn closed_volumes_are_closed() {
    check("head/volume_bob01.ply", 0);
}

/// A stretch of the Appalachians as a table-top model: 0.4 m wide, 8 mm high.
#[test]
fn a_terrain_passes_through_its_posts() {
    const COLUMNS: usize = 403;
    let Some(path) = data("terrain/jacksboro_403x344.i16") else { return };
    let bytes = std::fs::read(path).expect("readable");
    let height = |two: &[u8]| 1e-5 * f64::from(i16::from_le_bytes([two[0], two[1]]));
    let heights: Vec<f64> = bytes.chunks_exact(2).map(height).collect();
    assert_eq!(heights.len(), COLUMNS * 344);
    let spacing = 1e-3;
    let field =
        HeightField::new([0.0; 2], spacing, COLUMNS, heights.clone(), 2e-3).expect("a terrain");
    for post in (0..heights.len()).step_by(97) {
        let [x, y] = [post % COLUMNS, post / COLUMNS].map(|i| spacing * i as f64);
        let at = |above: f64| field.value(&Point3::new(x, y, heights[post] + above));
        assert!(at(0.0).abs() < 1e-15);
        // No farther from the ground than from the post.
        let (up, down) = (at(0.5e-3), -at(-0.5e-3));
        assert!(0.0 < up.min(down) && up.max(down) <= 0.5e-3 + 1e-15, "{up} {down}");
    }
}
