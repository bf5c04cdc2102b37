//! Parallel views of surfaces and hairs.

use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::{Mesh, Soup};
use rapunzel_repro::plot::{Drawing, Image, Images};

/// Side of a pixel, m: where a hair crosses it, it is covered.
const PIXEL: f64 = 0.5e-3;
/// No height is lower.
pub(crate) const LOWEST: f64 = f64::NEG_INFINITY;
/// Colors of what is seen: red, green and blue, from 0 to 1.
pub(crate) const SKIN: [f64; 3] = [0.86, 0.76, 0.70];
pub(crate) const HAIR: [f64; 3] = [0.50, 0.33, 0.20];
pub(crate) const HULL: [f64; 3] = [0.70, 0.74, 0.80];
const SECTION: [f64; 3] = [0.93, 0.89, 0.86];
const WHITE: [f64; 3] = [1.0; 3];
/// Direction toward the light, to the right, up and toward the viewer.
const LIGHT: Vector3<f64> = Vector3::new(-0.35, 0.75, 0.56);
/// What lines and open surfaces are nearer to the viewer than solids of the same place, m; lines
/// are farther where a cut shows the inside of these.
const LIFT: f64 = 0.5e-3;

/// A direction of view, in the frame of the head: y up, the face along z.
#[derive(Clone, Copy)]
pub(crate) struct View {
    pub(crate) name: &'static str,
    /// Directions on the page to the right and up; of unit length and orthogonal.
    right: Vector3<f64>,
    up: Vector3<f64>,
}

impl View {
    pub(crate) const FRONT: Self =
        Self { name: "front", right: Vector3::new(1.0, 0.0, 0.0), up: UP };
    /// From the person's left.
    pub(crate) const SIDE: Self =
        Self { name: "side", right: Vector3::new(0.0, 0.0, -1.0), up: UP };
    pub(crate) const BACK: Self =
        Self { name: "back", right: Vector3::new(-1.0, 0.0, 0.0), up: UP };
    /// The face is below.
    pub(crate) const TOP: Self =
        Self { name: "top", right: Vector3::new(1.0, 0.0, 0.0), up: Vector3::new(0.0, 0.0, -1.0) };

    /// From half front and half left, a little from above.
    pub(crate) fn oblique() -> Self {
        let toward = Vector3::new(0.72, 0.3, 0.62).normalize();
        let right = UP.cross(&toward).normalize();
        Self { name: "half front", right, up: toward.cross(&right) }
    }

    fn toward(&self) -> Vector3<f64> {
        self.right.cross(&self.up)
    }

    /// Places to the right, up and toward the viewer, m.
    fn seen(&self, p: &Point3<f64>) -> [f64; 3] {
        [self.right, self.up, self.toward()].map(|axis| axis.dot(&p.coords))
    }
}

const UP: Vector3<f64> = Vector3::new(0.0, 1.0, 0.0);

/// What is seen of surfaces and hairs in a view: the nearest of them in each pixel.
pub(crate) struct Canvas {
    view: View,
    /// Upper left corner, m to the right and up.
    corner: [f64; 2],
    size: [usize; 2],
    /// Distances toward the viewer, m, row by row from the top.
    depths: Vec<f64>,
    colors: Vec<[f64; 3]>,
    /// Of what is nearer to the viewer than this, m, nothing is seen.
    nearest: f64,
    /// Of what is lower than this (world), m, nothing is seen.
    lowest: f64,
}

impl Canvas {
    /// An empty canvas with room for some points that are not lower than a height, m. Of what is
    /// lower nothing will be seen.
    pub(crate) fn around(view: View, points: &[Point3<f64>], lowest: f64) -> Self {
        let far = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let bounds = points.iter().filter(|p| p.y >= lowest).fold(far, |bounds, p| {
            let seen = view.seen(p);
            [0, 1].map(|i| [bounds[i][0].min(seen[i]), bounds[i][1].max(seen[i])])
        });
        let margin = 4.0 * PIXEL;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few hundred"
        )]
        let size = bounds.map(|[low, high]| ((high - low + 2.0 * margin) / PIXEL).ceil() as usize);
        let count = size[0] * size[1];
        Self {
            view,
            corner: [bounds[0][0] - margin, bounds[1][1] + margin],
            size,
            depths: vec![f64::NEG_INFINITY; count],
            colors: vec![WHITE; count],
            nearest: f64::INFINITY,
            lowest,
        }
    }

    /// The canvas on which nothing is seen that is nearer to the viewer than a plane, m from the
    /// origin.
    pub(crate) fn cut_at(self, nearest: f64) -> Self {
        Self { nearest, ..self }
    }

    /// A canvas of the same place with nothing on it.
    pub(crate) fn blank(&self) -> Self {
        let count = self.depths.len();
        Self { depths: vec![f64::NEG_INFINITY; count], colors: vec![WHITE; count], ..*self }
    }

    /// Pixels to the right and down from the corner.
    fn on_canvas(&self, seen: &[f64; 3]) -> [f64; 2] {
        [(seen[0] - self.corner[0]) / PIXEL, (self.corner[1] - seen[1]) / PIXEL]
    }

    /// The pixel at a place on the canvas.
    fn pixel_at(&self, place: [f64; 2]) -> Option<usize> {
        #[expect(clippy::cast_possible_truncation, reason = "what is outside is left out")]
        let [column, row] = place.map(|x| x.floor() as i64);
        let column = usize::try_from(column).ok().filter(|c| *c < self.size[0])?;
        let row = usize::try_from(row).ok().filter(|r| *r < self.size[1])?;
        Some(row * self.size[0] + column)
    }

    /// Colors a pixel if nothing nearer is seen there.
    fn put(&mut self, pixel: usize, depth: f64, color: [f64; 3]) {
        if depth > self.depths[pixel] {
            self.depths[pixel] = depth;
            self.colors[pixel] = color;
        }
    }

    /// Draws triangles; `paint` tells the color of each. Where a solid is cut its inside is flat.
    pub(crate) fn faces(
        &mut self,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        paint: impl Fn(usize) -> [f64; 3],
    ) {
        for (face, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(|v| vertices[v as usize]);
            let seen = corners.map(|p| self.view.seen(&p));
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let facing = normal.try_normalize(0.0).map_or(0.0, |n| n.dot(&self.view.toward()));
            let outside = facing > 0.0;
            let color = if outside || self.nearest.is_infinite() {
                let normal = normal.try_normalize(0.0).unwrap_or(UP);
                shaded(paint(face), self.lit(&normal).abs())
            } else {
                SECTION
            };
            self.triangle(corners.map(|p| p.y), seen, color);
        }
    }

    /// Cosine between a direction and that toward the light.
    fn lit(&self, direction: &Vector3<f64>) -> f64 {
        let axes = [self.view.right, self.view.up, self.view.toward()];
        (0..3).map(|i| LIGHT[i] * axes[i].dot(direction)).sum()
    }

    fn triangle(&mut self, heights: [f64; 3], seen: [[f64; 3]; 3], color: [f64; 3]) {
        let [a, b, c] = seen.map(|corner| self.on_canvas(&corner));
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if twice == 0.0 {
            return;
        }
        let size = self.size;
        let range = |i: usize| {
            let (low, high) = (a[i].min(b[i]).min(c[i]), a[i].max(b[i]).max(c[i]));
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "on canvas"
            )]
            let ends = [low.max(0.0) as usize, (high + 1.0).clamp(0.0, size[i] as f64) as usize];
            ends[0]..ends[1]
        };
        for row in range(1) {
            for column in range(0) {
                let at = [column as f64 + 0.5, row as f64 + 0.5];
                let part = |p: [f64; 2], q: [f64; 2]| {
                    ((q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0])) / twice
                };
                let weights = [part(b, c), part(c, a), part(a, b)];
                if weights.iter().any(|w| *w < 0.0) {
                    continue;
                }
                let mix = |values: [f64; 3]| (0..3).map(|k| weights[k] * values[k]).sum::<f64>();
                let depth = mix(seen.map(|corner| corner[2]));
                if depth <= self.nearest && mix(heights) >= self.lowest {
                    self.put(row * self.size[0] + column, depth, color);
                }
            }
        }
    }

    /// Draws a head and hairs, each in a shade of its own.
    pub(crate) fn haired<'h>(
        mut self,
        head: &Mesh,
        hairs: impl Iterator<Item = &'h [Point3<f64>]>,
    ) -> Self {
        self.solid(head, SKIN);
        hairs.enumerate().for_each(|(number, hair)| self.hair(hair, tinted(HAIR, number)));
        self
    }

    /// Draws a solid.
    pub(crate) fn solid(&mut self, mesh: &Mesh, color: [f64; 3]) {
        self.faces(mesh.vertices(), mesh.triangles(), |_| color);
    }

    /// Draws an open surface, over a solid that it lies on.
    pub(crate) fn surface(&mut self, surface: &Soup, color: [f64; 3]) {
        let lift = self.view.toward() * LIFT;
        let lifted: Vec<_> = surface.vertices.iter().map(|p| p + lift).collect();
        self.faces(&lifted, &surface.triangles, |_| color);
    }

    /// Draws a hair, lit as a thin cylinder (Kajiya and Kay 1989).
    pub(crate) fn hair(&mut self, points: &[Point3<f64>], color: [f64; 3]) {
        let half = (LIGHT + Vector3::z()).normalize();
        let axes = [self.view.right, self.view.up, self.view.toward()];
        for ends in points.windows(2) {
            let Some(along) = (ends[1] - ends[0]).try_normalize(0.0) else { continue };
            let along = Vector3::from(axes.map(|axis| axis.dot(&along)));
            let sine =
                |direction: &Vector3<f64>| (1.0 - along.dot(direction).powi(2)).max(0.0).sqrt();
            let gloss = 0.25 * sine(&half).powi(40);
            let color = color.map(|c| c * (0.25 + 0.85 * sine(&LIGHT).powi(2)) + gloss);
            self.segment(ends, color);
        }
    }

    /// Draws a line of one color.
    pub(crate) fn line(&mut self, points: &[Point3<f64>], color: [f64; 3]) {
        for ends in points.windows(2) {
            self.segment(ends, color);
        }
    }

    fn segment(&mut self, ends: &[Point3<f64>], color: [f64; 3]) {
        let way = ends[1] - ends[0];
        let lift = if self.nearest.is_finite() { -LIFT } else { LIFT };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few")]
        let steps = (2.0 * way.norm() / PIXEL).ceil().max(1.0) as usize;
        for step in 0..=steps {
            let point = ends[0] + way * (step as f64 / steps as f64);
            let seen = self.view.seen(&point);
            if seen[2] > self.nearest || point.y < self.lowest {
                continue;
            }
            if let Some(pixel) = self.pixel_at(self.on_canvas(&seen)) {
                self.put(pixel, seen[2] + lift, color);
            }
        }
    }

    /// Whether something is seen in a pixel, row by row from the top.
    pub(crate) fn covered(&self) -> impl Iterator<Item = bool> {
        self.depths.iter().map(|depth| depth.is_finite())
    }

    /// The canvas with the pixels colored as `color` tells.
    pub(crate) fn painted(&self, color: impl Fn(usize) -> [f64; 3], caption: String) -> Image {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let byte = |x: f64| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
        let pixels = (0..self.colors.len()).map(|pixel| color(pixel).map(byte)).collect();
        Image { caption, width: self.size[0], pixels }
    }

    /// The canvas as it is.
    pub(crate) fn image(&self, caption: impl Into<String>) -> Image {
        self.painted(|pixel| self.colors[pixel], caption.into())
    }
}

/// The color of a surface on which light falls with the given cosine.
fn shaded(color: [f64; 3], cosine: f64) -> [f64; 3] {
    color.map(|c| c * (0.55 + 0.45 * cosine))
}

/// A color of its own for each hair, about that of all.
pub(crate) fn tinted(color: [f64; 3], number: usize) -> [f64; 3] {
    // Multiples of the golden ratio are spread evenly.
    let shade = 0.75 + 0.5 * (0.618_034 * number as f64).fract();
    color.map(|c| c * shade)
}

/// Images of one scale side by side.
pub(crate) fn images(title: &str, legend: &str, columns: usize, images: Vec<Image>) -> Drawing {
    let (title, legend) = (title.to_owned(), legend.to_owned());
    Drawing::Images(Images { title, legend, pixel: PIXEL, columns, images })
}
