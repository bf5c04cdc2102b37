use crate::ScatteringError;
use crate::error::check;
use crate::refraction::{check_index, cosine};
use nalgebra::Vector2;
use std::f64::consts::FRAC_PI_2;

/// Tilt of the lobes by the scales of the cuticle: `theta_i + theta_r` at the peak of R, TT and
/// TRT, rad, positive towards the tip. Each is free, as `alpha_p` in (6.13) of the thesis, where it
/// is half of this, the shift of `theta_h`: one angle of scales fits measured R or TRT, not both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CuticleTilt {
    /// Shifts of R, TT and TRT, rad.
    pub shift: [f64; 3],
}

impl CuticleTilt {
    /// No scales.
    pub const NONE: Self = Self { shift: [0.0; 3] };

    /// The shifts that flat scales at the angle `alpha`, rad, cause in level light, by
    /// [`Self::trace`]: `-2 alpha`, `1.10 alpha` and `4.24 alpha` at `n = 1.55` and 3 degrees. For
    /// small angles the order `p` is shifted by `2 (p n - 1) alpha`.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if `n` is not in `[1, 10]` or a ray cannot leave under that
    /// tilt.
    pub fn of_scales(n: f64, alpha: f64) -> Result<Self, ScatteringError> {
        Ok(Self { shift: Self::trace(n, alpha, 0.0)? })
    }

    /// Inclinations at which R, TT and TRT leave flat scales at the angle `alpha`, rad, for light
    /// from the inclination `theta_i`, rad, in the plane of the fibre: all rad, positive towards
    /// the tip.
    ///
    /// # Errors
    /// [`ScatteringError::Parameter`] if `n` is not in `[1, 10]`, `theta_i` not inside
    /// `(-pi/2, pi/2)`, or the scales are too steep for a ray to hit or to leave them.
    pub fn trace(n: f64, alpha: f64, theta_i: f64) -> Result<[f64; 3], ScatteringError> {
        check_index(n)?;
        let level = theta_i.abs() < FRAC_PI_2;
        check("the inclination (rad)", theta_i, "inside (-pi/2, pi/2)", level)?;
        let steep = "so small that light hits the scales and leaves them";
        let told = |ray: Option<Vector2<f64>>| {
            let leaves = ray.is_some();
            check(
                "the angle of the scales (rad)",
                alpha,
                steep,
                leaves && alpha.abs() < FRAC_PI_2,
            )?;
            Ok::<f64, ScatteringError>(ray.map_or(0.0, |ray| ray.y.atan2(ray.x.abs())))
        };
        // Components: away from the axis on the side of the light, and towards the tip. Scales are
        // farther from the axis at their tip side, so their normals lean to the root, on both
        // sides.
        let normal = |side: f64| Vector2::new(side * alpha.cos(), -alpha.sin());
        let incoming = -Vector2::new(theta_i.cos(), theta_i.sin());
        let reflected = incoming - normal(1.0) * (2.0 * incoming.dot(&normal(1.0)));
        let facing = incoming.dot(&normal(1.0)) < 0.0;
        let inside = refract(&incoming, &-normal(1.0), n.recip()).filter(|_| facing);
        let tt = inside.and_then(|ray| refract(&ray, &normal(-1.0), n));
        let back = inside.map(|ray| ray - normal(-1.0) * (2.0 * ray.dot(&normal(-1.0))));
        let trt = back.and_then(|ray| refract(&ray, &normal(1.0), n));
        Ok([told(Some(reflected))?, told(tt)?, told(trt)?])
    }
}

/// A ray refracted at a surface whose `normal` points along it, where the ratio of the index behind
/// to that before is `1 / eta`; `None` under total reflection.
fn refract(ray: &Vector2<f64>, normal: &Vector2<f64>, eta: f64) -> Option<Vector2<f64>> {
    let along = ray.dot(normal);
    let across = (ray - normal * along) * eta;
    let sin = across.norm();
    (sin < 1.0 && along > 0.0).then(|| across + normal * cosine(sin))
}
