//! The one source of random numbers.

use nalgebra::Vector3;

/// The generator of Steele, Lea and Flood (2014): one word of state, one output a step.
pub(crate) struct SplitMix64(pub(crate) u64);

impl SplitMix64 {
    /// Uniform in `[0, 1)`.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 * (-53f64).exp2()
    }

    /// Uniform in `[-1, 1)`.
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// Uniform in the ball of radius 1.
    pub(crate) fn in_ball(&mut self) -> Vector3<f64> {
        loop {
            let v = Vector3::from_fn(|_, _| self.signed());
            if v.norm_squared() <= 1.0 {
                return v;
            }
        }
    }

    /// A direction, uniform on the sphere.
    pub(crate) fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = self.in_ball();
            if v.norm_squared() > 1e-6 {
                return v.normalize();
            }
        }
    }
}
