//! Rays through a smooth round fibre, traced in space by the laws of refraction alone: no law of
//! Bravais, no formula of the thesis.

use nalgebra::Vector3;

/// Index of refraction of keratin (thesis 6.2).
pub(crate) const INDEX: f64 = 1.55;

/// A ray that leaves the fibre; lengths in its radii.
pub(crate) struct Exit {
    /// Where it leaves, if the light comes in at the height 0.
    pub(crate) at: Vector3<f64>,
    /// Where it goes, of unit length.
    pub(crate) direction: Vector3<f64>,
    /// Length of its way inside.
    pub(crate) inside: f64,
    /// All its points, from where it comes in.
    pub(crate) points: Vec<Vector3<f64>>,
}

impl Exit {
    /// Inclination of its direction, rad.
    pub(crate) fn inclination(&self) -> f64 {
        self.direction.z.asin()
    }

    /// Azimuth of its direction, rad; the light comes from the azimuth 0.
    pub(crate) fn azimuth(&self) -> f64 {
        self.direction.y.atan2(self.direction.x)
    }

    /// Distance of its line from the axis in the normal plane, with the sign of an offset.
    pub(crate) fn offset(&self) -> f64 {
        let side = self.direction.cross(&Vector3::z()).normalize();
        self.at.dot(&side)
    }
}

/// The direction to the light of an inclination, rad, at the azimuth 0.
pub(crate) fn light(theta: f64) -> Vector3<f64> {
    Vector3::new(theta.cos(), 0.0, theta.sin())
}

/// The ray of light from the inclination `theta`, rad, at the offset `h` that leaves after `order`
/// ways inside: R, TT and TRT are 0, 1 and 2.
pub(crate) fn exit(theta: f64, h: f64, order: u32) -> Exit {
    let incoming = -light(theta);
    // To the side of the light's direction times the axis: -y.
    let mut at = Vector3::new((1.0 - h * h).sqrt(), -h, 0.0);
    let mut points = vec![at];
    let normal = at;
    if order == 0 {
        let direction = incoming - normal * (2.0 * incoming.dot(&normal));
        return Exit { at, direction, inside: 0.0, points };
    }
    let (mut ray, mut inside) = (refracted(&incoming, &normal, INDEX.recip()), 0.0);
    for left in (0..order).rev() {
        // The chord of the circle, |at + t ray| = 1 in the normal plane.
        let length = -2.0 * at.xy().dot(&ray.xy()) / ray.xy().norm_squared();
        at += ray * length;
        inside += length;
        points.push(at);
        let outward = Vector3::new(at.x, at.y, 0.0);
        ray = if left == 0 {
            refracted(&ray, &-outward, INDEX)
        } else {
            ray - outward * (2.0 * ray.dot(&outward))
        };
    }
    Exit { at, direction: ray, inside, points }
}

/// A direction behind a surface whose normal points against it; `eta` is the index before over that
/// behind.
fn refracted(ray: &Vector3<f64>, normal: &Vector3<f64>, eta: f64) -> Vector3<f64> {
    let cos = -ray.dot(normal);
    let across = (ray + normal * cos) * eta;
    across - normal * (1.0 - across.norm_squared()).max(0.0).sqrt()
}
