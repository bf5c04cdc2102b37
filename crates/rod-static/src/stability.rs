use crate::goal::{EndPlace, EndTurning};
use crate::mesh::MeshElement;
use crate::shooting::{Shooting, propagate};
use crate::step::ShootingNode;
use nalgebra::{Matrix3, Vector3};

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
    of: &Shooting<'_>,
    elements: &[MeshElement],
    nodes: &[ShootingNode],
) -> Option<usize> {
    let tangent = nodes.last()?.q * Vector3::z();
    // Directions in which the rotation of the end is held; along the others it takes no moment.
    let held = match of.goal.turning {
        EndTurning::Free { .. } => Matrix3::zeros(),
        EndTurning::Tangent { .. } => Matrix3::identity() - tangent * tangent.transpose(),
        EndTurning::Held { .. } => Matrix3::identity(),
    };
    let loose = Matrix3::identity() - held;
    // The part beyond a node: its moment is stiffness * rotation + coupling * force, and the end
    // moves, relative to the node, by arm * rotation + compliance * force. There is none beyond the
    // end, where held rotations stand in for the moment.
    let [mut stiffness, mut coupling, mut arm, mut compliance] = [Matrix3::<f64>::zeros(); 4];
    let mut count = 0;
    let last = elements.len() - 1;
    for (i, (element, node)) in elements.iter().zip(nodes).enumerate().rev() {
        let (_, by) = propagate(of.rod, element, node, of.factor)?;
        let block = |row: usize, column: usize| -> Matrix3<f64> {
            by.fixed_view::<3, 3>(3 * row, 3 * column).into_owned()
        };
        let [r, rotation, m] = [0, 1, 2].map(|row| [1, 2, 3].map(|column| block(row, column)));
        // How the condition at the end of the element depends on the state at its start.
        let balance = |column: usize| {
            if i == last {
                held * rotation[column] + loose * m[column]
            } else {
                m[column] - stiffness * rotation[column]
            }
        };
        let pivot = balance(1);
        let soft = rotation[1].try_inverse()?;
        // Held directions, as those of infinite stiffness, are not negative.
        let kept = if i == last { loose * m[1] * soft * loose } else { pivot * soft };
        count += negative(&kept, STABILITY_ROUNDING);
        let inverse = pivot.try_inverse()?;
        let before = -inverse * balance(0);
        let beyond = inverse * (coupling - balance(2));
        let (turned, pulled) =
            (rotation[0] + rotation[1] * before, rotation[2] + rotation[1] * beyond);
        compliance += r[2] + r[1] * beyond + arm * pulled;
        arm = r[0] + r[1] * before + arm * turned;
        (stiffness, coupling) = (before, beyond);
    }
    if of.root.hinged {
        // The root turns too; about itself it may be neutral.
        count += negative(&-stiffness, NEUTRAL_MODE);
        let soft = NEUTRAL_MODE * stiffness.amax();
        compliance -= arm * stiffness.pseudo_inverse(soft).ok()? * coupling;
    }
    let taken = match of.goal.place {
        EndPlace::Free { .. } => 0,
        EndPlace::Held { .. } => 3 - negative(&-compliance, NEUTRAL_MODE),
        EndPlace::OnLine { along, .. } => {
            let across = Matrix3::identity() - along * along.transpose();
            2 - negative(&-(across * compliance * across), NEUTRAL_MODE)
        }
    };
    Some(count.saturating_sub(taken))
}

/// Number of negative eigenvalues of the symmetric part; eigenvalues whose size relative to the
/// largest one is below `zero` do not count.
fn negative(m: &Matrix3<f64>, zero: f64) -> usize {
    let eigenvalues = (0.5 * (m + m.transpose())).symmetric_eigenvalues();
    let zero = zero * eigenvalues.amax();
    eigenvalues.iter().filter(|e| **e < -zero).count()
}
