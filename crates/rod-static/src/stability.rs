use crate::goal::Goal;
use crate::mesh::{Element, Scaled};
use crate::shooting::propagate;
use crate::step::Node;

/// Counts the points conjugate to the far end: arc lengths at which a variation that meets the
/// conditions of the far end has neither displacement nor rotation. An equilibrium without such a
/// point is a minimum of the energy (Manning, Rogers and Maddocks 1998). `None` if a derivative is
/// singular.
///
/// The basis of the variations is made orthonormal at each node; what counts is the sign of the
/// determinant of its upper half, from the first node away from the end.
pub(crate) fn conjugate_points(
    rod: &Scaled,
    elements: &[Element],
    nodes: &[Node],
    goal: &Goal,
    factor: f64,
) -> Option<usize> {
    let mut basis = goal.variations(nodes.last()?);
    let mut sign = 0.0;
    let mut count = 0;
    for (element, node) in elements.iter().zip(nodes).rev() {
        let (_, by) = propagate(rod, element, node, factor);
        let qr = by.lu().solve(&basis)?.qr();
        basis = qr.q();
        if qr.r().diagonal().product() < 0.0 {
            // Orthonormal columns that are the true ones but for a positive determinant.
            let mut first = basis.column_mut(0);
            first *= -1.0;
        }
        let now = basis.fixed_view::<6, 6>(0, 0).into_owned().determinant().signum();
        if sign != 0.0 && now != sign {
            count += 1;
        }
        sign = now;
    }
    Some(count)
}
