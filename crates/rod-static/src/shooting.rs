use crate::goal::Goal;
use crate::mesh::{MeshElement, Scaled};
use crate::step::{Propagator, ShootingNode};
use nalgebra::{DMatrix, DVector, SMatrix, SVector, UnitQuaternion, Vector3};
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

/// A change of a node's state: position, rotation vector, moment and force.
pub(crate) type Variation = SVector<f64, 12>;

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
/// node, and the last node meet the conditions. `None` if it does not converge; `nodes` are then
/// meaningless.
pub(crate) fn newton(
    of: &Shooting<'_>,
    elements: &[MeshElement],
    nodes: &mut [ShootingNode],
    effort: &Effort,
) -> Option<()> {
    iterate(elements.len(), effort, || {
        let corrections = of.eliminated(elements, nodes, None)?.corrections()?;
        Some(corrected(nodes, &corrections))
    })
}

/// Iterates until a correction is small; `correct` makes one, at the cost of `steps`, and tells its
/// size. `None` if the corrections do not fall.
pub(crate) fn iterate(
    steps: usize,
    effort: &Effort,
    mut correct: impl FnMut() -> Option<f64>,
) -> Option<()> {
    let mut before = f64::INFINITY;
    for iteration in 0..MOST_SHOTS {
        effort.spend(steps)?;
        let size = correct()?;
        // Give up where corrections are too large or do not fall.
        let diverges = iteration > 1 && size > 0.7 * before && size > SMALL;
        if !size.is_finite() || size > FAR_SHOT || diverges {
            return None;
        }
        if size < SMALL {
            return Some(());
        }
        before = size;
    }
    None
}

/// Corrects all nodes, and tells how large the largest correction is.
pub(crate) fn corrected(nodes: &mut [ShootingNode], corrections: &[Variation]) -> f64 {
    let mut size = 0.0_f64;
    for (node, correction) in nodes.iter_mut().zip(corrections) {
        let one = relative(node, correction);
        // Not `max`, which would hide a NaN.
        size = if one > size || one.is_nan() { one } else { size };
        node.correct(correction);
    }
    size
}

/// Size of a correction: its largest part in lengths, radians, and relative to the moment and force
/// of the node.
fn relative(node: &ShootingNode, c: &Variation) -> f64 {
    let part = |row: usize| c.fixed_rows::<3>(row).norm();
    let (m, n) = (part(6) / (1.0 + node.m.norm()), part(9) / (1.0 + node.n.norm()));
    part(0).max(part(3)).max(m).max(n)
}

impl ShootingNode {
    pub(crate) fn correct(&mut self, c: &Variation) {
        self.r += c.fixed_rows::<3>(0);
        let turn: Vector3<f64> = c.fixed_rows::<3>(3).into_owned();
        self.q = UnitQuaternion::new_normalize(
            (UnitQuaternion::from_scaled_axis(turn) * self.q).into_inner(),
        );
        self.m += c.fixed_rows::<3>(6);
        self.n += c.fixed_rows::<3>(9);
    }

    /// The variation that takes `other` to `self`.
    pub(crate) fn minus(&self, other: &Self) -> Variation {
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

/// What holds the rod at the root: its pose, scaled, and whether it can turn there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RootHold {
    pub(crate) r: Vector3<f64>,
    pub(crate) q: UnitQuaternion<f64>,
    /// A ball joint, which takes no moment; the rotation is then where searches start from.
    pub(crate) hinged: bool,
}

impl RootHold {
    /// The correction of a node that takes it to the root.
    pub(crate) fn missed(&self, node: &ShootingNode) -> Variation {
        let held = ShootingNode { r: self.r, ..*node };
        let held = if self.hinged {
            ShootingNode { m: Vector3::zeros(), ..held }
        } else {
            ShootingNode { q: self.q, ..held }
        };
        held.minus(node)
    }
}

/// The boundary value problem: a rod between its root and the conditions on its end, under a
/// fraction of its loads.
#[derive(Clone, Copy)]
pub(crate) struct Shooting<'a> {
    pub(crate) rod: &'a Scaled,
    pub(crate) root: RootHold,
    pub(crate) goal: &'a Goal,
    pub(crate) factor: f64,
}

/// Derivatives of the equations by a parameter of the problem, at given nodes.
pub(crate) struct ParameterSlopes {
    /// Of the place and rotation of the root.
    pub(crate) root: Variation,
    /// Of the ends of the elements.
    pub(crate) ends: Vec<Variation>,
    /// Of the residual of the end conditions.
    pub(crate) goal: SVector<f64, 6>,
}

/// A row of the linear system after the elimination: the correction of its node is
/// `basis * p + rest * (1, change of the parameter)`.
struct Passed {
    basis: SMatrix<f64, 12, 6>,
    rest: SMatrix<f64, 12, 2>,
    /// `p` of the next node is `triangle * p + along * (1, change of the parameter)`.
    triangle: SMatrix<f64, 6, 6>,
    along: SMatrix<f64, 6, 2>,
}

/// The linear system of a Newton step after the sweep from the root to the end.
///
/// It is solved by propagating an orthonormal basis of the variations that the root leaves free
/// (Godunov 1961, Scott and Watts 1977): modes that grow along the rod do no harm.
pub(crate) struct Eliminated {
    passed: Vec<Passed>,
    basis: SMatrix<f64, 12, 6>,
    rest: SMatrix<f64, 12, 2>,
    units: Variation,
    /// Derivatives of the end conditions, each over its largest entry, by `p` at the end.
    pub(crate) onto: SMatrix<f64, 6, 6>,
    /// Their residuals, and their derivatives by the parameter.
    pub(crate) missed: SMatrix<f64, 6, 2>,
}

impl Shooting<'_> {
    /// The equations linearized at `nodes` and eliminated; `slopes` are those of a parameter that
    /// changes too, if there is one.
    pub(crate) fn eliminated(
        &self,
        elements: &[MeshElement],
        nodes: &[ShootingNode],
        slopes: Option<&ParameterSlopes>,
    ) -> Option<Eliminated> {
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
        // The root leaves moment or rotation free, and the force.
        let mut basis = SMatrix::<f64, 12, 6>::zeros();
        let free = if self.root.hinged { 3 } else { 6 };
        basis.fixed_view_mut::<3, 3>(free, 0).fill_with_identity();
        basis.fixed_view_mut::<3, 3>(9, 3).fill_with_identity();
        let mut rest = SMatrix::<f64, 12, 2>::zeros();
        rest.set_column(0, &self.root.missed(&nodes[0]).component_div(&units));
        if let Some(slopes) = slopes {
            rest.set_column(1, &slopes.root.component_div(&units));
        }
        let mut passed = Vec::with_capacity(elements.len());
        // Forward sweep: propagate the basis through each element, orthonormalise it by QR, and
        // split the inhomogeneous part into one along the new basis and the rest.
        for (i, element) in elements.iter().enumerate() {
            let (end, by) = propagate(self.rod, element, &nodes[i], self.factor)?;
            let by = scaled(by);
            let mut moved = by * rest;
            let mut gap = moved.column_mut(0);
            gap += end.minus(&nodes[i + 1]).component_div(&units);
            if let Some(slopes) = slopes {
                let mut slope = moved.column_mut(1);
                slope += slopes.ends[i].component_div(&units);
            }
            let qr = (by * basis).qr();
            let next = qr.q();
            let along = next.tr_mul(&moved);
            passed.push(Passed { basis, rest, triangle: qr.r(), along });
            (basis, rest) = (next, moved - next * along);
        }
        // The six conditions at the end, each row scaled by its largest entry.
        let (missed, mut by) = self.goal.missed(nodes.last()?)?;
        let mut both = SMatrix::<f64, 6, 2>::zeros();
        both.set_column(0, &missed);
        if let Some(slopes) = slopes {
            both.set_column(1, &slopes.goal);
        }
        for (row, mut conditions) in by.row_iter_mut().enumerate() {
            conditions.component_mul_assign(&units.transpose());
            let largest = conditions.amax();
            conditions /= largest;
            let mut sides = both.row_mut(row);
            sides /= largest;
        }
        Some(Eliminated { onto: by * basis, missed: both + by * rest, passed, basis, rest, units })
    }
}

impl Eliminated {
    /// The Newton corrections of all nodes; `None` if there are none.
    ///
    /// Neutral directions, such as a closed ring turning about its tangent, are left out.
    fn corrections(&self) -> Option<Vec<Variation>> {
        let p = least(&self.onto, &-self.missed.column(0))?;
        self.corrections_of(&p, 0.0)
    }

    /// The Newton corrections of all nodes and of the parameter, if the correction has the part
    /// `wanted` along a direction: the sum of its product with `along` over the nodes, and of the
    /// change of the parameter times `by_parameter`.
    pub(crate) fn corrections_along(
        &self,
        along: &[Variation],
        by_parameter: f64,
        wanted: f64,
    ) -> Option<(Vec<Variation>, f64)> {
        // The product over all nodes up to one is `row * p + sides * (1, change)`.
        let part = |i: usize, basis: &SMatrix<f64, 12, 6>, rest: &SMatrix<f64, 12, 2>| {
            let direction = along[i].component_mul(&self.units);
            (basis.tr_mul(&direction), rest.tr_mul(&direction))
        };
        let mut row = SVector::<f64, 6>::zeros();
        let mut sides = SVector::<f64, 2>::new(0.0, by_parameter);
        for (i, passed) in self.passed.iter().enumerate() {
            let (more, side) = part(i, &passed.basis, &passed.rest);
            row = passed.triangle.transpose().solve_lower_triangular(&(row + more))?;
            sides += side - passed.along.tr_mul(&row);
        }
        let (more, side) = part(self.passed.len(), &self.basis, &self.rest);
        (row, sides) = (row + more, sides + side);
        // What moves along neutral directions does not count, else it would be traded for a change
        // of the parameter.
        let svd = self.onto.try_svd(false, true, 5.0 * f64::EPSILON, MOST_ROTATIONS)?;
        let most = svd.singular_values.max();
        for (neutral, value) in svd.v_t?.row_iter().zip(svd.singular_values.iter()) {
            if *value < NEUTRAL_SHOT * most {
                row -= neutral.transpose() * (neutral * row)[0];
            }
        }
        let mut matrix = SMatrix::<f64, 7, 7>::zeros();
        matrix.fixed_view_mut::<6, 6>(0, 0).copy_from(&self.onto);
        matrix.fixed_view_mut::<6, 1>(0, 6).copy_from(&self.missed.column(1));
        matrix.fixed_view_mut::<1, 6>(6, 0).copy_from(&row.transpose());
        matrix[(6, 6)] = sides[1];
        let mut right = SVector::<f64, 7>::zeros();
        right.fixed_rows_mut::<6>(0).copy_from(&-self.missed.column(0));
        right[6] = wanted - sides[0];
        // Each row in its own size: that of the direction goes with the nodes.
        for i in 0..7 {
            let size = matrix.row(i).norm();
            if size > 0.0 {
                let mut one = matrix.row_mut(i);
                one /= size;
                right[i] /= size;
            }
        }
        let p = least(&matrix, &right)?;
        let change = p[6];
        Some((self.corrections_of(&p.fixed_rows::<6>(0).into_owned(), change)?, change))
    }

    /// The corrections of all nodes by `p` at the end and the `change` of the parameter.
    fn corrections_of(&self, p: &SVector<f64, 6>, change: f64) -> Option<Vec<Variation>> {
        let both = SVector::<f64, 2>::new(1.0, change);
        self.backward(p, &both)
    }

    /// The variation of all nodes without residuals by `p` at the end: one that meets all equations
    /// but the end's.
    pub(crate) fn variation(&self, p: &SVector<f64, 6>) -> Option<Vec<Variation>> {
        self.backward(p, &SVector::zeros())
    }

    /// The state at the end that belongs to `p` there, in the units of the elimination.
    pub(crate) fn end_variation(&self, p: &SVector<f64, 6>) -> Variation {
        self.basis * p
    }

    fn backward(&self, p: &SVector<f64, 6>, both: &SVector<f64, 2>) -> Option<Vec<Variation>> {
        let mut p = *p;
        let mut corrections = Vec::with_capacity(self.passed.len() + 1);
        corrections.push((self.basis * p + self.rest * both).component_mul(&self.units));
        for passed in self.passed.iter().rev() {
            // The triangle leads from p there to p here: modes that grow forward shrink backward.
            p = passed.triangle.solve_upper_triangular(&(p - passed.along * both))?;
            corrections.push((passed.basis * p + passed.rest * both).component_mul(&self.units));
        }
        corrections.reverse();
        Some(corrections)
    }
}

/// The smallest solution of a linear system, without its neutral directions; `None` if they are
/// asked for something. The iterations are bounded, since after an overflow they would not end.
fn least<const N: usize>(
    matrix: &SMatrix<f64, N, N>,
    right: &SVector<f64, N>,
) -> Option<SVector<f64, N>> {
    let dynamic = DMatrix::from_column_slice(N, N, matrix.as_slice());
    let svd = dynamic.try_svd(true, true, 5.0 * f64::EPSILON, MOST_ROTATIONS)?;
    let neutral = NEUTRAL_SHOT * svd.singular_values.max();
    let found = svd.solve(&DVector::from_column_slice(right.as_slice()), neutral).ok()?;
    let p = SVector::<f64, N>::from_column_slice(found.as_slice());
    // Written so that NaN counts as inconsistent.
    let consistent = (matrix * p - right).norm() <= CONSISTENT * (1.0 + right.norm());
    consistent.then_some(p)
}
