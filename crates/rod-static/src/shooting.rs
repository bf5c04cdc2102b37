use crate::goal::Goal;
use crate::mesh::{MeshElement, Scaled};
use crate::step::{Propagator, ShootingNode};
use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3};
use std::cell::Cell;

/// Largest number of Newton steps of one attempt.
const MOST_SHOTS: usize = 12;
/// Size of a correction after which the iteration ends: the next one is its square.
const SMALL: f64 = 1e-8;
/// Size of a correction, in radians and lengths, from which an attempt is given up.
const FAR_SHOT: f64 = 3.0;
/// Most iterations of a singular value decomposition; six values take about ten.
const MOST_ROTATIONS: usize = 300;
/// Fraction of the largest singular value below which a singular value belongs to a neutral
/// direction.
const NEUTRAL_SHOT: f64 = 1e-10;
/// Relative residual of the end conditions that neutral directions may leave.
const CONSISTENT: f64 = 1e-8;

/// Number of steps along elements that one query may cost: half a minute.
const EFFORT: usize = 2_000_000;

type Variation = SVector<f64, 12>;

/// Number of steps along elements that are left to one query.
#[derive(Debug)]
pub(crate) struct Effort(Cell<usize>);

impl Effort {
    pub(crate) fn new() -> Self {
        Self(Cell::new(EFFORT))
    }

    /// Subtracts `steps` from the budget; `None` once it is spent.
    pub(crate) fn spend(&self, steps: usize) -> Option<()> {
        let left = self.0.get().checked_sub(steps);
        self.0.set(left.unwrap_or(0));
        left.map(|_| ())
    }
}

/// Newton's method for all nodes at once (multiple shooting): each element's end must be the next
/// node, and the last node meet `goal`. `None` if it does not converge; `nodes` are then
/// meaningless.
///
/// The linear system is solved by propagating an orthonormal basis of the variations that the clamp
/// leaves free (Godunov 1961, Scott and Watts 1977): modes that grow along the rod do no harm.
pub(crate) fn newton(
    rod: &Scaled,
    elements: &[MeshElement],
    nodes: &mut [ShootingNode],
    goal: &Goal,
    factor: f64,
    effort: &Effort,
) -> Option<()> {
    let mut before = f64::INFINITY;
    for iteration in 0..MOST_SHOTS {
        effort.spend(elements.len())?;
        let corrections = corrections(rod, elements, nodes, goal, factor)?;
        let mut size = 0.0_f64;
        for (node, correction) in nodes.iter().zip(&corrections) {
            size = size.max(relative(node, correction));
        }
        // Give up where corrections are too large or do not fall.
        let diverges = iteration > 1 && size > 0.7 * before && size > SMALL;
        if !size.is_finite() || size > FAR_SHOT || diverges {
            return None;
        }
        for (node, correction) in nodes.iter_mut().zip(&corrections) {
            node.correct(correction);
        }
        if size < SMALL {
            return Some(());
        }
        before = size;
    }
    None
}

/// Size of a correction: its largest part in lengths, radians, and relative to the moment and force
/// of the node.
fn relative(node: &ShootingNode, c: &Variation) -> f64 {
    let part = |row: usize| c.fixed_rows::<3>(row).norm();
    let (m, n) = (part(6) / (1.0 + node.m.norm()), part(9) / (1.0 + node.n.norm()));
    part(0).max(part(3)).max(m).max(n)
}

impl ShootingNode {
    fn correct(&mut self, c: &Variation) {
        self.r += c.fixed_rows::<3>(0);
        let turn: Vector3<f64> = c.fixed_rows::<3>(3).into_owned();
        self.q = UnitQuaternion::new_normalize(
            (UnitQuaternion::from_scaled_axis(turn) * self.q).into_inner(),
        );
        self.m += c.fixed_rows::<3>(6);
        self.n += c.fixed_rows::<3>(9);
    }

    /// The variation that takes `other` to `self`.
    fn minus(&self, other: &Self) -> Variation {
        let mut difference = Variation::zeros();
        difference.fixed_rows_mut::<3>(0).copy_from(&(self.r - other.r));
        let turn = (self.q * other.q.inverse()).scaled_axis();
        difference.fixed_rows_mut::<3>(3).copy_from(&turn);
        difference.fixed_rows_mut::<3>(6).copy_from(&(self.m - other.m));
        difference.fixed_rows_mut::<3>(9).copy_from(&(self.n - other.n));
        difference
    }
}

/// State at the end of an element, and its derivatives by the state at the start; `None` if the
/// element is too long.
pub(crate) fn propagate(
    rod: &Scaled,
    element: &MeshElement,
    node: &ShootingNode,
    factor: f64,
) -> Option<(ShootingNode, Propagator)> {
    let properties = rod.properties(element, factor);
    let (reached, by) = node.step_with_derivatives(element.from, element.to, properties)?;
    let n = reached.node.n - element.end_load * factor;
    Some((ShootingNode { n, ..reached.node }, by))
}

/// The Newton corrections of all nodes.
fn corrections(
    rod: &Scaled,
    elements: &[MeshElement],
    nodes: &[ShootingNode],
    goal: &Goal,
    factor: f64,
) -> Option<Vec<Variation>> {
    // Scale moments and forces by the sharpest bends, else forces would hide all other rows.
    let strongest = nodes.iter().map(|node| node.n.norm()).fold(0.0, f64::max);
    let bend = (1.0 + strongest).sqrt();
    let units = Variation::from_fn(|i, _| [1.0, 1.0, bend, bend * bend][i / 3]);
    let scaled = |mut by: Propagator| {
        for (i, j) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
            by[(i, j)] *= units[j] / units[i];
        }
        by
    };
    // A correction of node i is basis_i p_i + rest_i; the clamp leaves moment and force free.
    let mut basis = SMatrix::<f64, 12, 6>::zeros();
    basis.fixed_view_mut::<6, 6>(6, 0).fill_with_identity();
    let mut rest = Variation::zeros();
    let mut passed = Vec::with_capacity(elements.len());
    // Forward sweep: propagate the basis through each element, orthonormalise it by QR, and split
    // the inhomogeneous part into one along the new basis and the rest.
    for (i, element) in elements.iter().enumerate() {
        let (end, by) = propagate(rod, element, &nodes[i], factor)?;
        let by = scaled(by);
        let moved = by * rest + end.minus(&nodes[i + 1]).component_div(&units);
        let qr = (by * basis).qr();
        let next = qr.q();
        let along = next.tr_mul(&moved);
        passed.push((basis, rest, qr.r(), along));
        (basis, rest) = (next, moved - next * along);
    }
    // The six conditions at the end, each row scaled by its largest entry.
    let (mut missed, mut by) = goal.missed(nodes.last()?)?;
    for (row, mut conditions) in by.row_iter_mut().enumerate() {
        conditions.component_mul_assign(&units.transpose());
        let largest = conditions.amax();
        conditions /= largest;
        missed[row] /= largest;
    }
    // Solve for p at the end. Neutral directions, such as a closed ring turning about its tangent,
    // are left out. The iterations are bounded, since after an overflow they would not end.
    let onto = (by * basis).try_svd(true, true, 5.0 * f64::EPSILON, MOST_ROTATIONS)?;
    let neutral = NEUTRAL_SHOT * onto.singular_values.max();
    let wanted = -(missed + by * rest);
    let mut p = onto.solve(&wanted, neutral).ok()?;
    // Written so that NaN counts as inconsistent.
    let consistent = (by * basis * p - wanted).norm() <= CONSISTENT * (1.0 + wanted.norm());
    if !consistent {
        return None;
    }
    let mut corrections = vec![(basis * p + rest).component_mul(&units)];
    for (basis, rest, triangle, along) in passed.iter().rev() {
        // Backward sweep. The triangle leads from p there to p here: modes that grow forward shrink
        // backward.
        p = triangle.solve_upper_triangular(&(p - along))?;
        corrections.push((basis * p + rest).component_mul(&units));
    }
    corrections.reverse();
    Some(corrections)
}
