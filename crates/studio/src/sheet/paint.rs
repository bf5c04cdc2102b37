use super::frame::{Line, PreviewFrame};
use super::grid::SheetGrid;
use super::view::View;
use crate::StudioError;
use crate::canvas::{Canvas, Color};
use nalgebra::Vector3;
use rapunzel_export::surface::Placed;
use rapunzel_render::{CurveForm, Curves, FiberCurve, Ray, TriangleMesh};
use rayon::prelude::*;

/// Width of the thinnest line, pixels: thinner fibres would break up.
const THINNEST: f64 = 1.3;
/// Width of the thinnest line where fibres are few and need not leave room for each other, pixels.
const THINNEST_OF_FEW: f64 = 2.2;
/// Number of fibres that are few.
pub(super) const FEW: usize = 10;

pub(super) const PAPER: Color = [0.965, 0.96, 0.95];
const FIBER: Color = [0.33, 0.19, 0.10];
const GLOSS: Color = [0.75, 0.58, 0.38];
const SURFACE: Color = [0.66, 0.71, 0.76];
/// Angle, rad, at which an edge of a surface stays sharp.
const CREASE: f64 = 0.6;

/// Draws the fibres and the objects of a frame into a picture: by a ray through every corner of its
/// pixels, each of which shows the mean of its four.
pub(super) fn paint(
    canvas: &mut Canvas,
    frame: &PreviewFrame,
    objects: &[Placed],
    view: &View,
    grid: &SheetGrid,
    corner: [f64; 2],
) -> Result<(), StudioError> {
    let thinnest = if frame.lines.len() <= FEW { THINNEST_OF_FEW } else { THINNEST };
    let least = 0.5 * thinnest / grid.scale;
    let fiber = |line: &Line| FiberCurve {
        nodes: line.points().collect(),
        radii: line.radii.iter().map(|r| f64::from(*r).max(least)).collect(),
        axes: Vec::new(),
        ways: Vec::new(),
    };
    let fibers: Vec<_> = frame.lines.iter().map(fiber).collect();
    let curves = Curves::new(CurveForm::Linear, None, &fibers)?;
    let mesh = |object: &Placed| {
        let surface = &object.surface;
        TriangleMesh::new(surface.vertices.clone(), surface.triangles.clone(), CREASE)
    };
    let meshes = objects.iter().map(mesh).collect::<Result<Vec<_>, _>>()?;
    let scene = SheetScene { curves, meshes, view, before: least + view.size[0].max(view.size[1]) };

    let [width, height] = grid.picture.map(whole);
    let corners: Vec<Vec<Color>> = (0..=height)
        .into_par_iter()
        .map(|y| {
            let place = |x: usize| [x as f64 / grid.scale, y as f64 / grid.scale];
            (0..=width).map(|x| scene.color(place(x))).collect()
        })
        .collect();
    let [left, top] = corner.map(whole);
    for y in 0..height {
        for x in 0..width {
            let four = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
            let mean = |k: usize| 0.25 * four.iter().map(|[x, y]| corners[*y][*x][k]).sum::<f64>();
            canvas.set(left + x, top + y, [0, 1, 2].map(mean));
        }
    }
    Ok(())
}

struct SheetScene<'a> {
    curves: Curves,
    meshes: Vec<TriangleMesh>,
    view: &'a View,
    /// How far before the near side of the box rays begin, m.
    before: f64,
}

impl SheetScene<'_> {
    /// What is seen at a position in the picture, m from its upper left corner.
    fn color(&self, place: [f64; 2]) -> Color {
        let (origin, direction) = self.view.ray(place, self.before);
        let ray = Ray { origin, direction, time: 0.0 };
        let mut end = f64::INFINITY;
        let mut color = PAPER;
        for mesh in &self.meshes {
            if let Some(hit) = mesh.hit(&ray, [0.0, end]) {
                end = hit.distance;
                // Without haze, which would show how far the surface is.
                let bright =
                    0.45 + 0.55 * mesh.at(&ray, &hit).normal.dot(&self.view.half_way).abs();
                color = SURFACE.map(|x| bright * x);
            }
        }
        if let Some(hit) = self.curves.hit(&ray, [0.0, end]) {
            let point = self.curves.at(&ray, &hit);
            let [_, _, tangent] = point.frame;
            color = shade(&tangent, self.view, self.view.depth(&point.position));
        }
        color
    }
}

/// The colour of a fibre: Kajiya and Kay's highlight of a light at the upper left of the eye, and
/// haze with the depth (0 near, 1 far).
fn shade(tangent: &Vector3<f64>, view: &View, depth: f64) -> Color {
    let along = tangent.dot(&view.half_way);
    let gloss = (1.0 - along * along).max(0.0).powi(12);
    mix(mix(FIBER, GLOSS, 0.8 * gloss), PAPER, 0.5 * depth)
}

fn mix(a: Color, b: Color, t: f64) -> Color {
    [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]))
}

/// A position, rounded to a pixel.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within a sheet")]
fn whole(x: f64) -> usize {
    x.round().clamp(0.0, 16384.0) as usize
}
