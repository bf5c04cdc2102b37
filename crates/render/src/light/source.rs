use nalgebra::{Point3, Vector3};

/// A light, as a scene describes it; all is in the frame of the world. Radiance and what else tells
/// how bright it is are for red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// A rectangle that shines to one side: that of the cross product of its half edges. From the
    /// other it is not seen. Edges of any other angle make it a parallelogram.
    Rectangle {
        /// Its middle, m.
        center: Point3<f64>,
        /// From the middle to those of two neighboring edges, m.
        half_edges: [Vector3<f64>; 2],
        /// Radiance, W/(m^2 sr).
        radiance: Vector3<f64>,
    },
    /// A ball that shines outward; from inside it is not seen.
    Sphere {
        /// Its middle, m.
        center: Point3<f64>,
        /// Its radius, m.
        radius: f64,
        /// Radiance, W/(m^2 sr).
        radiance: Vector3<f64>,
    },
    /// A disc so far away that it looks the same from everywhere, like the sun.
    Distant {
        /// The direction to its middle, of any length.
        toward: Vector3<f64>,
        /// Irradiance of a plane across `toward`, W/m^2.
        irradiance: Vector3<f64>,
        /// Angle between its middle and its rim, rad, in `[1e-6, pi/2]`, or 0: it is then met by no
        /// ray.
        angular_radius: f64,
    },
    /// A point, which is met by no ray.
    Point {
        /// Its place, m.
        position: Point3<f64>,
        /// Radiant intensity, W/sr.
        intensity: Vector3<f64>,
    },
}
