use crate::goal::Goal;
use crate::mesh::{MeshElement, Scaled};
use crate::shooting::propagate;
use crate::step::ShootingNode;
use nalgebra::{Matrix3, Vector3};

/// Stiffness of held directions, in units of the rod's stiffness: practically rigid; the signs do
/// not depend on its value.
const RIGID: f64 = 1e9;

/// Fraction of the largest eigenvalue of a pivot below which an eigenvalue counts as zero, for
/// rounding.
const STABILITY_ROUNDING: f64 = 1e-10;
/// Fraction of the largest eigenvalue of the compliance below which an eigenvalue counts as zero,
/// for the error that Newton's method leaves in a neutral direction.
const NEUTRAL_MODE: f64 = 1e-7;

/// Number of independent variations that lower the energy: the number of points conjugate to the
/// end, counted with their multiplicity. `None` if a derivative is singular.
///
/// The variations are rotations along the rod; the second variation in them is eliminated element
/// by element from the end, and each pivot's negative eigenvalues are counted (the count of
/// Wittrick and Williams 1971). A prescribed position of the end excludes the variations that move
/// it, as many as its compliance has negative eigenvalues (the isoperimetric index of Maddocks
/// 1985; Manning, Rogers and Maddocks 1998), or none for a neutral direction.
pub(crate) fn index(
    rod: &Scaled,
    elements: &[MeshElement],
    nodes: &[ShootingNode],
    goal: &Goal,
    factor: f64,
) -> Option<usize> {
    let tangent = nodes.last()?.q * Vector3::z();
    // The part beyond a node: its moment is stiffness * rotation + coupling * force, and the end
    // moves, relative to the node, by arm * rotation + compliance * force.
    let mut stiffness = match goal {
        Goal::Free { .. } | Goal::Position { .. } => Matrix3::zeros(),
        Goal::Tangent { .. } => (tangent * tangent.transpose() - Matrix3::identity()) * RIGID,
        Goal::Held { .. } => Matrix3::identity() * -RIGID,
    };
    let [mut coupling, mut arm, mut compliance] = [Matrix3::<f64>::zeros(); 3];
    let mut count = 0;
    for (element, node) in elements.iter().zip(nodes).rev() {
        let (_, by) = propagate(rod, element, node, factor)?;
        let block = |row: usize, column: usize| -> Matrix3<f64> {
            by.fixed_view::<3, 3>(3 * row, 3 * column).into_owned()
        };
        let [r, rotation, m] = [0, 1, 2].map(|row| [1, 2, 3].map(|column| block(row, column)));
        let pivot = m[1] - stiffness * rotation[1];
        count += negative(&(pivot * rotation[1].try_inverse()?), STABILITY_ROUNDING);
        let inverse = pivot.try_inverse()?;
        let (before, beyond) = (
            inverse * (stiffness * rotation[0] - m[0]),
            inverse * (stiffness * rotation[2] + coupling - m[2]),
        );
        let (turned, pulled) =
            (rotation[0] + rotation[1] * before, rotation[2] + rotation[1] * beyond);
        compliance += r[2] + r[1] * beyond + arm * pulled;
        arm = r[0] + r[1] * before + arm * turned;
        (stiffness, coupling) = (before, beyond);
    }
    let held = if matches!(goal, Goal::Free { .. }) {
        0
    } else {
        3 - negative(&-compliance, NEUTRAL_MODE)
    };
    Some(count.saturating_sub(held))
}

/// Number of negative eigenvalues of the symmetric part; eigenvalues whose size relative to the
/// largest one is below `zero` do not count.
fn negative(m: &Matrix3<f64>, zero: f64) -> usize {
    let eigenvalues = (0.5 * (m + m.transpose())).symmetric_eigenvalues();
    let zero = zero * eigenvalues.amax();
    eigenvalues.iter().filter(|e| **e < -zero).count()
}
