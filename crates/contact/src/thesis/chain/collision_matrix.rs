use crate::RigidBody;
use crate::thesis::projection::Form;
use nalgebra::{Matrix3, Matrix6, Point3};
use rapunzel_fiber::so3::hat;

/// The collision matrix (8.96) of two bodies at `point` (world): the relative velocity, linear and
/// angular, that a unit impulse pair `(p, L*)` there causes. Symmetric and positive definite; its
/// upper left block is the K of method II and of Newton's Jacobian (8.98).
///
/// As printed the angular velocity is projected on the lever, (8.92), and its lower right block has
/// rank two at most, one for collinear segments: the matrix has no inverse. (The angular velocity
/// of a rigid body is the same at all of its points.) The sign of `r~ I^-1 L` in (8.94) is as
/// printed as well.
#[must_use]
pub fn collision_matrix(
    first: &RigidBody,
    second: &RigidBody,
    point: &Point3<f64>,
    form: Form,
) -> Matrix6<f64> {
    [first, second].iter().fold(Matrix6::zeros(), |sum, body| {
        let lever = point - body.center();
        let (skew, inverse) = (hat(&lever), body.inverse_inertia());
        let mass = Matrix3::from_diagonal_element(1.0 / body.mass());
        let mut matrix = Matrix6::zeros();
        let mut put = |i, j, block: Matrix3<f64>| matrix.view_mut((i, j), (3, 3)).copy_from(&block);
        match form {
            Form::Corrected => {
                put(0, 0, mass - skew * inverse * skew);
                put(0, 3, -skew * inverse);
                put(3, 0, inverse * skew);
                put(3, 3, inverse);
            }
            Form::AsPrinted => {
                put(0, 0, mass);
                put(0, 3, skew * inverse);
                put(3, 3, lever * lever.transpose() * inverse / lever.norm_squared());
            }
        }
        sum + matrix
    })
}
