//! Fibres and surfaces as a picture shows them: what is nearest at the corners of its pixels.

use super::frame::Line;
use super::grid::{SheetGrid, whole};
use super::shade::{PAPER, fiber_color, hazy, surface_color};
use super::view::View;
use crate::StudioError;
use crate::canvas::Color;
use nalgebra::{Point3, Vector3};
use rapunzel_export::surface::Placed;
use rapunzel_render::{Ray, TriangleMesh};
use rayon::prelude::*;
use std::ops::Range;

/// Angle, rad, at which an edge of a surface stays sharp.
const CREASE: f64 = 0.6;
/// Rows that one thread draws fibres into at a time.
const BAND: usize = 32;
/// Overlap of segments, in their length: what is seen at a joint belongs to both rather than to
/// none.
const OVERLAP: f64 = 1e-6;
/// Squared sine of the angle with the direction of sight below which nothing of a segment is seen:
/// they are open at their ends.
const ALONG: f64 = 1e-12;

/// What is seen at the corners of all pixels, row by row.
#[derive(Clone)]
pub(super) struct Raster {
    /// Corners in a row.
    width: usize,
    /// Pixels per metre.
    scale: f64,
    corners: Vec<SeenCorner>,
}

/// What is seen at a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SeenCorner {
    /// How far it is behind the near side of the view, m; infinitely on paper.
    depth: f64,
    color: Color,
}

impl Raster {
    /// Paper, and surfaces before it: seen by a ray through every corner.
    pub(super) fn new(
        objects: &[Placed],
        view: &View,
        grid: &SheetGrid,
    ) -> Result<Self, StudioError> {
        let mesh = |object: &Placed| {
            let surface = &object.surface;
            TriangleMesh::new(surface.vertices.clone(), surface.triangles.clone(), CREASE)
        };
        let meshes = objects.iter().map(mesh).collect::<Result<Vec<_>, _>>()?;
        let ([width, height], scale) = (grid.picture.map(|pixels| whole(pixels) + 1), grid.scale);
        let look = |y: usize| {
            let place = move |x: usize| [x as f64 / scale, y as f64 / scale];
            let corner = |x| surface_at(&meshes, view, place(x));
            (0..width).map(corner).collect::<Vec<_>>()
        };
        let corners = (0..height).into_par_iter().flat_map_iter(look).collect();
        Ok(Self { width, scale, corners })
    }

    /// Draws fibres, not thinner than a `least` radius, m, where nothing is before them.
    pub(super) fn draw(&mut self, lines: &[Line], view: &View, least: f64) {
        let segments_of = |line: &Line| {
            let radii = line.radii.iter().map(|radius| f64::from(*radius).max(least));
            let nodes: Vec<_> = line.points().zip(radii).collect();
            let segments =
                nodes.windows(2).filter_map(|ends| SeenSegment::new([ends[0], ends[1]], view));
            segments.collect::<Vec<_>>()
        };
        let segments: Vec<SeenSegment> = lines.par_iter().flat_map_iter(segments_of).collect();
        let (width, scale) = (self.width, self.scale);
        let bands = self.corners.par_chunks_mut(BAND * width).enumerate();
        bands.for_each(|(band, corners)| {
            for segment in &segments {
                let rows = segment.rows(scale, band * BAND..band * BAND + corners.len() / width);
                for y in rows {
                    let row = &mut corners[(y - band * BAND) * width..][..width];
                    segment.draw(y as f64 / scale, scale, view, row);
                }
            }
        });
    }

    /// Gives the colors of all pixels, by their columns and rows: the means of their corners.
    pub(super) fn pixels(&self, mut set: impl FnMut([usize; 2], Color)) {
        let rows: Vec<_> = self.corners.chunks(self.width).collect();
        for (y, rows) in rows.windows(2).enumerate() {
            for x in 0..self.width - 1 {
                let four = [rows[0][x], rows[0][x + 1], rows[1][x], rows[1][x + 1]];
                let mean = |k: usize| 0.25 * four.iter().map(|corner| corner.color[k]).sum::<f64>();
                set([x, y], [0, 1, 2].map(mean));
            }
        }
    }
}

/// What is seen of surfaces at a place in the picture, m from its upper left corner.
fn surface_at(meshes: &[TriangleMesh], view: &View, place: [f64; 2]) -> SeenCorner {
    // Rays begin before all that is in the view.
    let before = view.size[0].max(view.size[1]);
    let (origin, direction) = view.ray(place, before);
    let ray = Ray { origin, direction, time: 0.0 };
    let (mut end, mut color) = (f64::INFINITY, PAPER);
    for mesh in meshes {
        if let Some(hit) = mesh.hit(&ray, [0.0, end]) {
            end = hit.distance;
            color = surface_color(&mesh.at(&ray, &hit).normal, view);
        }
    }
    SeenCorner { depth: end - before, color }
}

/// A segment of a fibre in the coordinates of a view, m: all points in the normal planes of its
/// axis that are one radius away from it, which changes evenly along it.
struct SeenSegment {
    start: Vector3<f64>,
    axis: Vector3<f64>,
    /// Of the squared length, 1/m^2.
    inverse: f64,
    /// At the start, and by how much it is larger at the end.
    radius: f64,
    growth: f64,
    color: Color,
}

impl SeenSegment {
    /// The segment between two nodes (world, m) with their radii, m; none if it has no length, or
    /// if it is seen from its end.
    fn new([(p, r), (q, end)]: [(Point3<f64>, f64); 2], view: &View) -> Option<Self> {
        let tangent = (q - p).try_normalize(0.0)?;
        let (start, color) = (view.coordinates(&p), fiber_color(&tangent, view));
        let axis = view.coordinates(&q) - start;
        let (inverse, growth) = (1.0 / axis.norm_squared(), end - r);
        let segment = Self { start, axis, inverse, radius: r, growth, color };
        (inverse.is_finite() && segment.steepness() > ALONG).then_some(segment)
    }

    fn widest(&self) -> f64 {
        self.radius + self.growth.max(0.0)
    }

    /// Coefficient of the square of a depth in the equation of the segment.
    fn steepness(&self) -> f64 {
        let slope = self.axis.z * self.inverse;
        1.0 - slope * self.axis.z - (self.growth * slope).powi(2)
    }

    /// Those of some rows of corners that it may be seen in, which are `scale` per metre.
    fn rows(&self, scale: f64, of: Range<usize>) -> Range<usize> {
        let (a, b) = (self.start.y, self.start.y + self.axis.y);
        within([a.min(b) - self.widest(), a.max(b) + self.widest()], scale, of)
    }

    /// Draws it into the row of corners at `y`, m, which are `scale` per metre.
    fn draw(&self, y: f64, scale: f64, view: &View, row: &mut [SeenCorner]) {
        let Self { start, axis, inverse, radius, growth, color } = *self;
        let wide = self.widest();
        // The part of the axis that is near the row.
        let crossings = [y - wide, y + wide].map(|y| (y - start.y) / axis.y);
        let part = if axis.y == 0.0 { [0.0, 1.0] } else { crossings };
        let ends = part.map(|at| start.x + at.clamp(0.0, 1.0) * axis.x);
        let columns = [ends[0].min(ends[1]) - wide, ends[0].max(ends[1]) + wide];
        let (slope, steepness) = (axis.z * inverse, self.steepness());
        for x in within(columns, scale, 0..row.len()) {
            // At the depth z from the start on the point is at (q + z axis.z) / |axis|^2 along the
            // axis; it is as far from there as the radius where
            // steepness z^2 + 2 half z + rest = 0.
            let (u, v) = (x as f64 / scale - start.x, y - start.y);
            let q = u * axis.x + v * axis.y;
            let here = radius + growth * q * inverse;
            let half = -slope * (q + growth * here);
            let rest = u * u + v * v - q * q * inverse - here * here;
            let discriminant = half * half - steepness * rest;
            if discriminant.is_nan() || discriminant <= 0.0 {
                continue;
            }
            let z = (-half - discriminant.sqrt()) / steepness;
            let along = (q + z * axis.z) * inverse;
            let depth = start.z + z;
            if (-OVERLAP..=1.0 + OVERLAP).contains(&along) && depth < row[x].depth {
                row[x] = SeenCorner { depth, color: hazy(color, view.haze(depth)) };
            }
        }
    }
}

/// Those of some whole numbers that lie between two lengths, m, at `scale` per metre.
fn within([low, high]: [f64; 2], scale: f64, of: Range<usize>) -> Range<usize> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in the range")]
    let place = |x: f64| (x * scale).ceil().clamp(of.start as f64, of.end as f64) as usize;
    place(low)..place(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapunzel_render::{CurveForm, Curves, FiberCurve};

    /// Coordinates that look random, in -1..1.
    fn coordinates(seed: u32) -> impl Iterator<Item = f32> {
        let next = |x: &u32| Some(x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
        let numbers = std::iter::successors(Some(seed), next);
        numbers.skip(1).map(|x| (x >> 8) as f32 / 8_388_608.0 - 1.0)
    }

    /// Every corner shows what a ray finds among the same segments: at random, tapered, of one
    /// point, along an axis of the picture, and along the direction of sight.
    #[test]
    fn corners_show_what_rays_find() {
        let mut at = coordinates(1);
        let mut point = || Point3::from([(); 3].map(|()| at.next().expect("endless")));
        let mut lines: Vec<_> = (0..40).map(|_| (0..4).map(|_| point()).collect()).collect();
        lines.push(vec![point(); 2]);
        let all = |lines: &[Vec<Point3<f32>>]| lines.concat().into_iter().map(|p| p.cast());
        let points: Vec<Point3<f64>> = all(&lines).collect();
        let view = View::of(points.iter().copied(), 0.05, true).expect("points");
        for way in [view.ray([0.0; 2], 0.0).1, Vector3::z(), Vector3::x()] {
            let start = point();
            lines.push(vec![start, start + way.cast()]);
        }
        let grid = SheetGrid::alone(&view, [160.0, 120.0]);
        let line = |(k, points): (usize, Vec<Point3<f32>>)| {
            let radii = (0..points.len()).map(|i| 0.01 * (1 + (i * k) % 3) as f32).collect();
            Line { points, radii }
        };
        let lines: Vec<Line> = lines.into_iter().enumerate().map(line).collect();
        let least = 0.015;
        let fiber = |line: &Line| FiberCurve {
            nodes: line.points().collect(),
            radii: line.radii.iter().map(|r| f64::from(*r).max(least)).collect(),
            axes: Vec::new(),
            ways: Vec::new(),
        };
        let fibers: Vec<_> = lines.iter().map(fiber).collect();
        let curves = Curves::new(CurveForm::Linear, None, &fibers).expect("sound fibres");

        let mut raster = Raster::new(&[], &view, &grid).expect("nothing to refuse");
        raster.draw(&lines, &view, least);
        let before = 10.0;
        let mut seen = 0;
        for (k, corner) in raster.corners.iter().enumerate() {
            let place = [k % raster.width, k / raster.width].map(|x| x as f64 / raster.scale);
            let (origin, direction) = view.ray(place, before);
            let ray = Ray { origin, direction, time: 0.0 };
            let hit = curves.hit(&ray, [0.0, f64::INFINITY]);
            let depth = hit.map_or(f64::INFINITY, |hit| hit.distance - before);
            // Rays end where a parameter changes by less than 1e-7, and with it a radius, by 0.02 m
            // at most along a segment; the depth by that over the half chord, in radii, which is
            // nowhere less than a hundredth.
            let same = corner.depth == depth || (corner.depth - depth).abs() < 2e-7;
            assert!(same, "{place:?}: {} in place of {depth}", corner.depth);
            seen += usize::from(depth.is_finite());
        }
        assert!(4 * seen > raster.corners.len(), "{seen} corners");
        assert!(seen < raster.corners.len(), "some paper");
    }
}
