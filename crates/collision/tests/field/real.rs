//! Scans of real surfaces, where they are at hand.

use crate::common::data;
use crate::random::Random;
use crate::scan::{distance, winding};
use rapunzel_collision::field::{DistanceField, Grid, Mesh, Soup};
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
