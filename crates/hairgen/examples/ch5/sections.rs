//! Figure 5.7: sections through a head with its hair.

use crate::canvas::{Canvas, LOWEST, View, images};
use crate::grown::{Size, grow, shipped, voxels};
use crate::silhouettes::kept;
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::{DistanceField, MeshDistance, Soup};
use rapunzel_hairgen::style::{Hairstyle, Style};
use rapunzel_hairgen::{DensityModel, HairDensity};
use rapunzel_repro::plot::Image;
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rayon::prelude::*;

/// Side of a voxel of the density, m.
const VOXEL: f64 = 4e-3;
/// Colors of voxels without hair: of the head, and between it and the surface.
const HEAD: [f64; 3] = [0.82, 0.88, 0.94];
const EMPTY: [f64; 3] = [1.0, 0.85, 0.65];
/// Depth of the scalp below the triangles of the head at most, m: both have their corners on the
/// same surface, whose radius is small at the ears.
const CHORD: f64 = 0.5e-3;

/// Cuts along three planes, and the density in the plane of symmetry.
pub(crate) fn cuts(size: Size) -> Fallible<Figure> {
    let (hairs, guides) = (Some(size.of(90_000, 20_000)), size.of(3000, 400));
    let grown = grow(&Style { hairs, guides, ..shipped("bob")? })?;
    let (density, densities) = density(&grown)?;
    let pictures = vec![
        cut(&grown, View::SIDE, "along the plane of symmetry"),
        cut(&grown, View::FRONT, "from ear to ear"),
        cut(&grown, View::TOP, "above the ears"),
        density,
    ];
    let distance = MeshDistance::new(&grown.surfaces.head);
    let hairs: Vec<_> = grown.hairs.iter().collect();
    let deepest = hairs.par_iter().map(|hair| {
        hair.iter().skip(1).map(|point| -distance.value(point)).fold(f64::NEG_INFINITY, f64::max)
    });
    let deepest: Vec<f64> = deepest.collect();
    let mut checks = vec![
        check(
            "deepest node below the head's surface, by the exact distance",
            1e3 * deepest.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            "mm",
            Criterion::AtMost(1e3 * CHORD),
            "no fibers are seen in the head",
        ),
        check(
            "voxels of the head with hair, in the plane of symmetry",
            densities.in_head as f64,
            "",
            Criterion::AtMost(0.0),
            "the density in the head is zero",
        ),
        check(
            "voxels between head and surface with hair, in the plane of symmetry",
            100.0 * densities.filled,
            "%",
            Criterion::Told,
            "the density is homogeneous",
        ),
    ];
    checks.extend(kept("bob", &grown));
    Ok(Figure {
        scene: "scenes/style/bob.ron",
        parameters: "20,000 hairs of 400 guides, --full 90,000 of 3,000; cuts through the origin",
        drawings: vec![images(
            "5.7 Sections",
            "density: grey, black the largest; orange: no hair; blue: the head",
            2,
            pictures,
        )],
        checks,
    })
}

/// What is behind the plane through the origin that faces the viewer.
fn cut(grown: &Hairstyle, view: View, caption: &str) -> Image {
    let canvas = Canvas::around(view, &grown.surfaces.hull.vertices, LOWEST).cut_at(0.0);
    canvas.haired(&grown.surfaces.head, grown.hairs.iter()).image(caption)
}

/// Voxels in the plane of symmetry.
struct Densities {
    /// Number of those wholly in the head that have hair.
    in_head: usize,
    /// Part of those between head and surface that have hair.
    filled: f64,
}

/// The density of all hairs in the plane of symmetry.
fn density(grown: &Hairstyle) -> Fallible<(Image, Densities)> {
    let frame = voxels(&grown.surfaces.hull.vertices, VOXEL)?;
    let mut density = HairDensity::new(frame, DensityModel::Continuous { most: 1.0 });
    grown.hairs.iter().for_each(|hair| density.add(hair));
    let most = density.cells().iter().copied().fold(0.0, f64::max);
    let distance = MeshDistance::new(&grown.surfaces.head);
    let half = 0.5 * VOXEL;
    let mut canvas = Canvas::around(View::SIDE, &grown.surfaces.hull.vertices, LOWEST);
    let (mut in_head, mut between, mut filled) = (0, 0_usize, 0_usize);
    for (voxel, cell) in density.cells().iter().enumerate() {
        let center = frame.center(voxel);
        if !(-half..half).contains(&center.x) {
            continue;
        }
        let depth = -distance.value(&center);
        let (has_hair, inside) = (*cell > 0.0, depth > half * 3.0_f64.sqrt());
        let admissible = depth < 0.0 && grown.surfaces.hull_field.value(&center) < 0.0;
        in_head += usize::from(has_hair && inside);
        between += usize::from(admissible);
        filled += usize::from(admissible && has_hair);
        let color = match (has_hair, depth > 0.0, admissible) {
            (true, ..) => [0.9 - 0.9 * (cell / most).sqrt(); 3],
            (false, true, _) => HEAD,
            (false, false, true) => EMPTY,
            _ => continue,
        };
        canvas.surface(&square(&center, half), color);
    }
    let filled = filled as f64 / between.max(1) as f64;
    Ok((canvas.image("density of hair, plane of symmetry"), Densities { in_head, filled }))
}

/// A square that faces the person's left.
fn square(center: &Point3<f64>, half: f64) -> Soup {
    let corner = |y: f64, z: f64| center + Vector3::new(0.0, y * half, z * half);
    let vertices = vec![corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)];
    Soup { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] }
}
