use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

/// A rotation, a scale and a translation: `x -> s R x + t`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// The factor `s`.
    pub scale: f64,
    /// The rotation `R`.
    pub rotation: Rotation3<f64>,
    /// The translation `t`, m.
    pub translation: Vector3<f64>,
}

impl Similarity {
    /// The identity.
    pub const IDENTITY: Self = Self {
        scale: 1.0,
        rotation: Rotation3::from_matrix_unchecked(Matrix3::new(
            1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0,
        )),
        translation: Vector3::new(0.0, 0.0, 0.0),
    };

    /// The image of a point.
    #[must_use]
    pub fn apply(&self, point: &Point3<f64>) -> Point3<f64> {
        Point3::from(self.rotation * point.coords * self.scale + self.translation)
    }

    /// The similarity that brings points nearest to their partners in least squares (Umeyama 1991).
    /// `None` of fewer than three points, or points on one line.
    #[must_use]
    pub fn between(pairs: &[[Point3<f64>; 2]]) -> Option<Self> {
        if pairs.len() < 3 {
            return None;
        }
        let count = pairs.len() as f64;
        let mean = |side: usize| pairs.iter().map(|p| p[side].coords).sum::<Vector3<f64>>() / count;
        let [from, to] = [mean(0), mean(1)];
        let mut covariance = Matrix3::zeros();
        let mut spread = 0.0;
        for [a, b] in pairs {
            let (a, b) = (a.coords - from, b.coords - to);
            covariance += b * a.transpose() / count;
            spread += a.norm_squared() / count;
        }
        let svd = covariance.svd(true, true);
        let (u, v_t) = (svd.u?, svd.v_t?);
        if svd.singular_values[1] <= 1e-12 * svd.singular_values[0] || spread <= 0.0 {
            return None;
        }
        // A reflection is no rotation: the least direction is turned.
        let mut signs = Vector3::repeat(1.0);
        signs.z = (u.determinant() * v_t.determinant()).signum();
        let rotation = u * Matrix3::from_diagonal(&signs) * v_t;
        let scale = svd.singular_values.component_mul(&signs).sum() / spread;
        let rotation = Rotation3::from_matrix_unchecked(rotation);
        Some(Self { scale, rotation, translation: to - rotation * from * scale })
    }
}
