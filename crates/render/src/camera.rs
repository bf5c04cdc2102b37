use crate::check::{check, check_point, check_positive, unit};
use crate::{Ray, RenderError};
use nalgebra::{Point3, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Part of the picture that stays free on each of its sides when a camera frames points.
const FRAME_MARGIN: f64 = 0.05;

/// Least distance of a camera that frames points from the nearest of them, over their extent.
const STANDOFF: f64 = 0.1;

/// How a camera maps space to its picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// All lines of sight meet in the place of the camera.
    Perspective {
        /// Angle between the left and the right edge of the picture, rad, inside `(0, pi)`.
        field_of_view: f64,
    },
    /// All lines of sight are parallel.
    Orthographic {
        /// Width of what is seen, m.
        width: f64,
    },
}

/// An ideal camera with a thin lens.
///
/// Pixels are square, so the height of what is seen follows from the size of the picture; row 0 is
/// its top. Without a lens all is sharp.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    position: Point3<f64>,
    /// To the right, upward and forward, of unit length.
    axes: [Vector3<f64>; 3],
    projection: Projection,
    /// Half of the width of the picture: m, or over the distance.
    half_width: f64,
    /// Radius of the aperture, m.
    aperture: f64,
    /// Distance of what is sharp, along the axis, m.
    focus: f64,
}

impl Camera {
    /// A camera without a lens at `position` (world, m) that looks at `target` (world, m), with
    /// `up` (world, of any length) upward in its picture.
    ///
    /// # Errors
    /// [`RenderError::Parameter`] if the target is where the camera is, `up` runs along the line of
    /// sight, the field of view or the width is outside its range, or a number is not finite.
    pub fn new(
        position: Point3<f64>,
        target: &Point3<f64>,
        up: &Vector3<f64>,
        projection: Projection,
    ) -> Result<Self, RenderError> {
        check_point("a coordinate of the camera (m)", &position)?;
        check_point("a coordinate of what the camera looks at (m)", target)?;
        let axes = axes_along(&(target - position), up)?;
        let half_width = match projection {
            Projection::Perspective { field_of_view } => {
                let allowed = field_of_view > 0.0 && field_of_view < PI;
                check("the field of view (rad)", field_of_view, "inside (0, pi)", allowed)?;
                (0.5 * field_of_view).tan()
            }
            Projection::Orthographic { width } => {
                check_positive("the width of the view (m)", width)?;
                0.5 * width
            }
        };
        Ok(Self { position, axes, projection, half_width, aperture: 0.0, focus: 1.0 })
    }

    /// This camera with a thin lens: `aperture` is its radius, m, and all at the distance `focus`
    /// along the line of sight, m, is sharp.
    ///
    /// # Errors
    /// [`RenderError::Parameter`] if `aperture` is negative or not finite, or `focus` is outside
    /// `[1e-6, 1e9]`.
    pub fn with_lens(self, aperture: f64, focus: f64) -> Result<Self, RenderError> {
        let allowed = aperture >= 0.0 && aperture.is_finite();
        check("the radius of the aperture (m)", aperture, "finite and not negative", allowed)?;
        let allowed = (1e-6..=1e9).contains(&focus);
        check("the distance of focus (m)", focus, "in [1e-6, 1e9]", allowed)?;
        Ok(Self { aperture, focus, ..self })
    }

    /// A camera that looks along `direction` (world, of any length) from as near as it can while
    /// all `points` (world, m) are inside its picture, 5 % of whose width and height stay free on
    /// each side; `aspect` is the width of the picture over its height.
    ///
    /// The points bound the place of the camera by half spaces, so the answer is exact. It stays at
    /// a tenth of their extent before the nearest, where all fit into a cone from that. Costs a few
    /// passes over the points.
    ///
    /// # Errors
    /// [`RenderError::Parameter`] if there are no two different points, `up` runs along
    /// `direction`, an angle is outside its range, or a number is not finite.
    pub fn framing(
        points: &[Point3<f64>],
        direction: &Vector3<f64>,
        up: &Vector3<f64>,
        field_of_view: f64,
        aspect: f64,
    ) -> Result<Self, RenderError> {
        let Some(first) = points.first() else {
            let (what, must) = ("the number of points to frame", "at least 1");
            return Err(RenderError::Parameter { what, value: 0.0, must });
        };
        points.iter().try_for_each(|p| check_point("a coordinate of a point to frame (m)", p))?;
        check_positive("the width of the picture over its height", aspect)?;
        let forward = unit("the largest component of the direction of sight", direction)?;
        let projection = Projection::Perspective { field_of_view };
        let camera = Self::new(*first, &(first + forward), up, projection)?;
        let [right, up, forward] = camera.axes;
        let slope = (1.0 - 2.0 * FRAME_MARGIN) * camera.half_width;

        // |x - c_x| <= slope (z - c_z) for every point, from the first on.
        let span = |axis: &Vector3<f64>, slope: f64| {
            let range = |of: &dyn Fn(f64, f64) -> f64| {
                let along = points.iter().map(|p| p - first);
                range_of(along.map(|p| of(p.dot(axis), p.dot(&forward))))
            };
            let (low, high) = (range(&|x, z| x - slope * z)[1], range(&|x, z| x + slope * z)[0]);
            let extent = range(&|x, _| x);
            (0.5 * (low + high), 0.5 * (high - low) / slope, extent[1] - extent[0])
        };
        let (x, z_across, width) = span(&right, slope);
        let (y, z_along, height) = span(&up, slope / aspect);
        let [nearest, farthest] = range_of(points.iter().map(|p| (p - first).dot(&forward)));
        let extent = width.max(height).max(farthest - nearest);
        check_positive("the extent of the points to frame (m)", extent)?;
        let z = z_across.min(z_along).min(nearest - STANDOFF * extent);
        Ok(Self { position: first + right * x + up * y + forward * z, ..camera })
    }

    /// The place of the camera (world), m.
    #[must_use]
    pub fn position(&self) -> Point3<f64> {
        self.position
    }

    /// The direction to the right in the picture, that upward, and the line of sight (world), of
    /// unit length.
    #[must_use]
    pub fn axes(&self) -> [Vector3<f64>; 3] {
        self.axes
    }

    /// The ray of a pixel (column and row) of a picture of `size` (width and height): `within` is
    /// its place in the pixel from the left and from the top, `lens` chooses a point of the
    /// aperture, and `time` is passed on; all are numbers in `[0, 1)`, drawn evenly for a sharp box
    /// of the pixel and an even shutter.
    #[must_use]
    pub fn ray(
        &self,
        size: [u32; 2],
        pixel: [u32; 2],
        within: [f64; 2],
        lens: [f64; 2],
        time: f64,
    ) -> Ray {
        let [width, height] = size.map(|n| f64::from(n.max(1)));
        let scale = self.half_width / width;
        let x = (2.0 * (f64::from(pixel[0]) + within[0]) - width) * scale;
        let y = (height - 2.0 * (f64::from(pixel[1]) + within[1])) * scale;
        let [right, up, forward] = self.axes;
        let across = right * x + up * y;
        let (through, sight) = match self.projection {
            Projection::Perspective { .. } => (self.position, across + forward),
            Projection::Orthographic { .. } => (self.position + across, forward),
        };
        let [a, b] = in_disc(lens);
        let shift = (right * a + up * b) * self.aperture;
        let direction = (sight * self.focus - shift).normalize();
        Ray { origin: through + shift, direction, time }
    }
}

/// The axes of a camera: to the right, upward, and along `sight`.
fn axes_along(sight: &Vector3<f64>, up: &Vector3<f64>) -> Result<[Vector3<f64>; 3], RenderError> {
    let forward = unit("the largest component of the way to what the camera looks at (m)", sight)?;
    let right = forward.cross(&unit("the largest component of the camera's up", up)?);
    let sine = right.norm();
    let what = "the sine of the angle between the camera's up and its line of sight";
    check(what, sine, "at least 1e-9", sine >= 1e-9)?;
    let right = right / sine;
    Ok([right, right.cross(&forward), forward])
}

/// The smallest and the largest of some numbers.
fn range_of(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    let wider = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
    numbers.fold([f64::INFINITY, f64::NEG_INFINITY], wider)
}

/// The point of the unit disc that belongs to a point of the unit square, areas in proportion
/// (Shirley and Chiu 1997).
fn in_disc(square: [f64; 2]) -> [f64; 2] {
    let [a, b] = square.map(|x| 2.0 * x - 1.0);
    let (radius, angle) = if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else if b == 0.0 {
        (0.0, 0.0)
    } else {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    };
    [radius * angle.cos(), radius * angle.sin()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PathRandom;

    const UP: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);
    const SIZE: [u32; 2] = [400, 200];

    fn along_y(projection: Projection) -> Camera {
        let position = Point3::new(1.0, 2.0, 3.0);
        Camera::new(position, &Point3::new(1.0, 9.0, 3.0), &UP, projection).expect("a camera")
    }

    fn corner(camera: &Camera, pixel: [u32; 2], within: [f64; 2]) -> Ray {
        camera.ray(SIZE, pixel, within, [0.5, 0.5], 0.25)
    }

    #[test]
    fn the_top_left_is_up_and_left_and_the_angle_is_that_of_the_width() {
        let camera = along_y(Projection::Perspective { field_of_view: FRAC_PI_2 });
        let ray = corner(&camera, [0, 0], [0.0, 0.0]);
        assert!((ray.direction - Vector3::new(-1.0, 1.0, 0.5).normalize()).norm() < 1e-15);
        assert_eq!((ray.origin, ray.time), (camera.position(), 0.25));
        let ray = corner(&camera, [399, 199], [1.0, 1.0]);
        assert!((ray.direction - Vector3::new(1.0, 1.0, -0.5).normalize()).norm() < 1e-15);
        let ray = corner(&camera, [200, 100], [0.0, 0.0]);
        assert!((ray.direction - Vector3::y()).norm() < 1e-15);
    }

    #[test]
    fn parallel_rays_begin_on_the_plane_of_the_camera() {
        let camera = along_y(Projection::Orthographic { width: 8.0 });
        let ray = corner(&camera, [0, 199], [0.0, 1.0]);
        assert!((ray.origin - Point3::new(-3.0, 2.0, 1.0)).norm() < 1e-14);
        assert!((ray.direction - Vector3::y()).norm() < 1e-15);
    }

    #[test]
    fn what_is_in_focus_is_one_point_and_the_aperture_is_filled_evenly() {
        for projection in [
            Projection::Perspective { field_of_view: 1.0 },
            Projection::Orthographic { width: 3.0 },
        ] {
            let pinhole = corner(&along_y(projection), [30, 60], [0.3, 0.4]);
            let sharp = pinhole.at(5.0 / pinhole.direction.y);
            let camera = along_y(projection).with_lens(0.2, 5.0).expect("a lens");
            let mut random = PathRandom::new(1, 2, 3);
            let samples = 10_000;
            let mut second = 0.0;
            for _ in 0..samples {
                let ray = camera.ray(SIZE, [30, 60], [0.3, 0.4], random.pair(), 0.0);
                assert!((ray.at((sharp - ray.origin).norm()) - sharp).norm() < 1e-14);
                let shift = (ray.origin - pinhole.origin).norm() / 0.2;
                assert!(shift <= 1.0 + 1e-14);
                second += shift * shift / f64::from(samples);
            }
            // r^2 is even in [0, 1]: its mean has the variance 1 / (12 N).
            assert!((second - 0.5).abs() < 6.0 / (12.0 * f64::from(samples)).sqrt());
        }
    }

    /// Place of a point in the picture over half of its width and half of its height.
    fn place(camera: &Camera, p: &Point3<f64>, aspect: f64) -> [f64; 2] {
        let [x, y, z] = camera.axes.map(|axis| (p - camera.position).dot(&axis));
        assert!(z > 0.0, "{p} is behind the camera");
        [x / (z * camera.half_width), y * aspect / (z * camera.half_width)]
    }

    #[test]
    fn framed_points_touch_the_margin_from_inside() {
        let mut random = PathRandom::new(5, 0, 0);
        let mut touching = 0;
        for trial in 0..200 {
            let mut number = |scale: f64| (random.number() - 0.5) * scale;
            let (direction, view) = ([0; 3].map(|_| number(2.0)).into(), 1.2 + number(2.0));
            let stretch = [0; 3].map(|_| 10.0_f64.powf(number(4.0)));
            let mut point = || Point3::from([0, 1, 2].map(|k| 7.0 + number(stretch[k])));
            let points: Vec<_> = (0..20).map(|_| point()).collect();
            let aspect = 10.0_f64.powf(number(1.0));
            let camera = Camera::framing(&points, &direction, &UP, view, aspect).expect("a camera");
            let places: Vec<_> = points.iter().map(|p| place(&camera, p, aspect)).collect();
            let end = |k: usize, side: f64| places.iter().map(|p| side * p[k]).fold(-9.0, f64::max);
            let ends = [[end(0, 1.0), end(0, -1.0)], [end(1, 1.0), end(1, -1.0)]];
            let inside = 1.0 - 2.0 * FRAME_MARGIN;
            assert!(ends.iter().flatten().all(|e| *e < inside + 1e-9), "{trial}: {ends:?}");
            let touched = |[a, b]: &[f64; 2]| a.min(*b) > inside - 1e-9;
            let depth = |p: &Point3<f64>| (p - camera.position).dot(&camera.axes[2]);
            let ranges =
                camera.axes.map(|axis| range_of(points.iter().map(|p| p.coords.dot(&axis))));
            let extent = ranges.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
            let nearest = range_of(points.iter().map(depth))[0];
            assert!(nearest > STANDOFF * extent - 1e-9, "{trial}: {nearest}");
            let is_nearest = nearest < STANDOFF * extent + 1e-9;
            assert!(is_nearest || ends.iter().any(touched), "{trial}: {ends:?}");
            touching += u32::from(!is_nearest);
        }
        assert!(touching > 100, "{touching}");
    }

    #[test]
    fn what_no_camera_can_do_is_refused() {
        let (here, there) = (Point3::origin(), Point3::new(0.0, 1.0, 0.0));
        let view = Projection::Perspective { field_of_view: 1.0 };
        let of = |target: &Point3<f64>, up: Vector3<f64>, projection| {
            Camera::new(here, target, &up, projection)
        };
        assert!(of(&here, UP, view).is_err());
        assert!(of(&there, Vector3::y(), view).is_err());
        assert!(of(&Point3::new(f64::NAN, 0.0, 0.0), UP, view).is_err());
        assert!(of(&there, Vector3::repeat(f64::INFINITY), view).is_err());
        for field_of_view in [0.0, PI, f64::NAN] {
            assert!(of(&there, UP, Projection::Perspective { field_of_view }).is_err());
        }
        assert!(of(&there, UP, Projection::Orthographic { width: 0.0 }).is_err());
        let camera = of(&there, UP, view).expect("a camera");
        for (aperture, focus) in [(-1.0, 1.0), (f64::NAN, 1.0), (0.1, 0.0), (0.1, f64::INFINITY)] {
            assert!(camera.clone().with_lens(aperture, focus).is_err(), "{aperture} {focus}");
        }
        let framed = |points: &[Point3<f64>]| Camera::framing(points, &there.coords, &UP, 1.0, 1.0);
        assert!(framed(&[]).is_err());
        assert!(framed(&[here, here]).is_err());
        assert!(framed(&[here, there]).is_ok());
        assert!(framed(&[here, Point3::new(f64::NAN, 0.0, 1.0)]).is_err());
        assert!(framed(&[here, Point3::new(1.0, 0.0, 1.0)]).is_ok());
    }
}
