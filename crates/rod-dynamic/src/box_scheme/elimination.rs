use nalgebra::Matrix3;
use pulp::{Arch, Simd, WithSimd};

/// Unknowns per node.
pub(super) const N: usize = 12;
/// Rows carried from segment to segment: the root conditions, reduced by every elimination.
const CARRIED: usize = 6;
/// Rows among which pivots are sought.
const ACTIVE: usize = CARRIED + N;
/// Rows that follow passively: the rotation of the node in terms of its unknowns.
const PASSIVE: usize = 3;
/// Columns: the unknowns of both ends of the segment.
const WIDTH: usize = 2 * N;

/// The increments of one node: v, omega, kappa, n.
pub(super) type Increment = [f64; N];

/// The equations of one end: six rows in the end's unknowns, their coefficients on its rotation
/// increment, and the right-hand sides.
#[derive(Debug, Clone, Copy)]
pub(super) struct EndRows {
    pub(super) unknowns: [[f64; N]; 6],
    pub(super) rotation: [[f64; 3]; 6],
    pub(super) rhs: [f64; 6],
}

/// The window of the matrix in which one segment is eliminated. Rows are three cache lines long;
/// the alignment keeps every vector of eight within one.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(super) struct Panel {
    rows: [[f64; WIDTH]; ACTIVE + PASSIVE],
    rhs: [f64; ACTIVE + PASSIVE],
}

impl Panel {
    /// Sets a 3 x 3 block of the segment's twelve equations: rows from `row`, columns from `col`
    /// (0 to 11 the first node, 12 to 23 the second).
    pub(super) fn set(&mut self, row: usize, col: usize, block: &Matrix3<f64>) {
        for i in 0..3 {
            for j in 0..3 {
                self.rows[CARRIED + row + i][col + j] = block[(i, j)];
            }
        }
    }

    /// Sets the right-hand sides of the segment's equations.
    pub(super) fn set_rhs(&mut self, rhs: &[f64; N]) {
        self.rhs[CARRIED..ACTIVE].copy_from_slice(rhs);
    }
}

/// How the rotation increments theta of the two ends of a segment enter:
/// `force` is the coefficient of `theta_a` in the first three equations, and
/// `theta_b = turn theta_a + lever (d kappa_a + d kappa_b) / 2`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turning {
    pub(super) force: Matrix3<f64>,
    pub(super) turn: Matrix3<f64>,
    pub(super) lever: Matrix3<f64>,
}

/// The pivot rows of one segment: the columns of the triangle in the first node's unknowns, the
/// inverse pivots, and the rows in the second node's (from column 8 on, so whole vectors).
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct PivotRows {
    columns: [[f64; 16]; N],
    rows: [[f64; 16]; N],
    inverse: [f64; 16],
    rhs: [f64; 16],
}

impl PivotRows {
    const ZERO: Self =
        Self { columns: [[0.0; 16]; N], rows: [[0.0; 16]; N], inverse: [0.0; 16], rhs: [0.0; 16] };

    #[inline(always)]
    fn store(&mut self, panel: &Panel) {
        for k in 0..N {
            let row = &panel.rows[k];
            for c in k + 1..N {
                self.columns[c][k] = row[c];
            }
            self.rows[k].copy_from_slice(&row[8..]);
            self.inverse[k] = 1.0 / row[k];
            self.rhs[k] = panel.rhs[k];
        }
    }
}

/// Solves the almost-block-diagonal system of one Newton iteration: six equations at the root,
/// twelve per segment that couple its two nodes, six at the tip.
///
/// Rows are pivoted among the 18 of a segment (six carried on, twelve new), which is all that is
/// needed for stability. The rotation increments of the nodes, which depend on all curvatures
/// before them, do not enlarge the system: they are kept as three passive rows
/// `theta = T x + t` in the unknowns of the current node and substituted during the elimination.
///
/// Cost: 6.7e3 multiplications and additions per segment. No allocation after the first solve.
#[derive(Debug, Clone)]
pub(super) struct Elimination {
    arch: Arch,
    panel: Box<Panel>,
    factors: Vec<PivotRows>,
    solution: Vec<Increment>,
}

impl Elimination {
    pub(super) fn new(segments: usize) -> Self {
        Self {
            arch: Arch::new(),
            panel: Box::new(Panel {
                rows: [[0.0; WIDTH]; ACTIVE + PASSIVE],
                rhs: [0.0; ACTIVE + PASSIVE],
            }),
            factors: vec![PivotRows::ZERO; segments],
            solution: vec![[0.0; N]; segments + 1],
        }
    }

    /// Solves for the increments of all nodes, root first. `root_rotation` is d theta / d omega at
    /// the root; `segment(i, panel)` writes the equations of segment `i`, blocks that are always
    /// zero left out. Where the system is singular the increments are not finite.
    pub(super) fn solve(
        &mut self,
        root: &EndRows,
        root_rotation: &Matrix3<f64>,
        tip: &EndRows,
        mut segment: impl FnMut(usize, &mut Panel) -> Turning,
    ) -> &[Increment] {
        let panel = &mut *self.panel;
        // The passive rows hold [T | ...] with right-hand side -t, and start with the root's.
        let mut theta = [[0.0; N]; 3];
        let mut minus_t = [0.0; 3];
        for i in 0..3 {
            for j in 0..3 {
                theta[i][3 + j] = root_rotation[(i, j)];
            }
        }
        // Conditions of the root with its rotation substituted.
        let mut carried = close(root, &theta, &minus_t);
        for i in 0..self.factors.len() {
            // Assemble the panel: new equations, carried rows, and the rotation of the first node.
            for row in &mut panel.rows {
                *row = [0.0; WIDTH];
            }
            let turning = segment(i, panel);
            for (r, (row, rhs)) in carried.iter().enumerate() {
                panel.rows[r][..N].copy_from_slice(row);
                panel.rhs[r] = *rhs;
            }
            panel.turn(&turning, &theta, &minus_t);
            // Eliminate the first node's unknowns, and carry what is left to the next segment.
            self.arch.dispatch(Reduce { panel, factor: &mut self.factors[i] });
            for r in 0..CARRIED {
                carried[r].0.copy_from_slice(&panel.rows[N + r][N..]);
                carried[r].1 = panel.rhs[N + r];
            }
            for r in 0..PASSIVE {
                theta[r].copy_from_slice(&panel.rows[ACTIVE + r][N..]);
                minus_t[r] = panel.rhs[ACTIVE + r];
            }
        }
        // The last node from carried rows and tip conditions, then back substitution.
        let last = solve_corner(&carried, &close(tip, &theta, &minus_t));
        let nodes = self.solution.len();
        self.solution[nodes - 1] = last;
        self.arch.dispatch(BackSubstitute { factors: &self.factors, solution: &mut self.solution });
        &self.solution
    }
}

type PivotRow = ([f64; N], f64);

/// Rows of an end's conditions with its rotation increment substituted.
fn close(end: &EndRows, theta: &[[f64; N]; 3], minus_t: &[f64; 3]) -> [PivotRow; 6] {
    std::array::from_fn(|r| {
        let (mut row, mut rhs) = (end.unknowns[r], end.rhs[r]);
        for k in 0..3 {
            let w = end.rotation[r][k];
            row.iter_mut().zip(&theta[k]).for_each(|(x, t)| *x += w * t);
            rhs += w * minus_t[k];
        }
        (row, rhs)
    })
}

impl Panel {
    /// Substitutes the rotation of the first node in the segment's equations and sets up the
    /// passive rows of the second.
    fn turn(&mut self, turning: &Turning, theta: &[[f64; N]; 3], minus_t: &[f64; 3]) {
        for r in 0..3 {
            let (equation, passive) = (CARRIED + r, ACTIVE + r);
            self.rhs[passive] = 0.0;
            for k in 0..3 {
                let (f, t) = (turning.force[(r, k)], turning.turn[(r, k)]);
                for c in 0..N {
                    self.rows[equation][c] += f * theta[k][c];
                    self.rows[passive][c] += t * theta[k][c];
                }
                self.rhs[equation] += f * minus_t[k];
                self.rhs[passive] += t * minus_t[k];
                let lever = 0.5 * turning.lever[(r, k)];
                self.rows[passive][6 + k] += lever;
                self.rows[passive][N + 6 + k] += lever;
            }
        }
    }
}

/// Gaussian elimination of the first node's unknowns, rows pivoted.
struct Reduce<'a> {
    panel: &'a mut Panel,
    factor: &'a mut PivotRows,
}

impl WithSimd for Reduce<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // Columns already eliminated need no more work; whole vectors of them are left out.
        for k in 0..8 {
            self.panel.eliminate::<S, 0>(simd, k);
        }
        for k in 8..N {
            self.panel.eliminate::<S, 8>(simd, k);
        }
        self.factor.store(self.panel);
    }
}

impl Panel {
    /// Eliminates column `k` from all rows after the `k`th; columns before `START` are left alone.
    #[inline(always)]
    fn eliminate<S: Simd, const START: usize>(&mut self, simd: S, k: usize) {
        let Self { rows, rhs } = self;
        let mut pivot = k;
        let mut largest = rows[k][k].abs();
        for r in k + 1..ACTIVE {
            let size = rows[r][k].abs();
            if size > largest {
                (pivot, largest) = (r, size);
            }
        }
        rows.swap(k, pivot);
        rhs.swap(k, pivot);
        let (pivot_row, pivot_rhs) = (rows[k], rhs[k]);
        let inverse = 1.0 / pivot_row[k];
        let (source, _) = S::as_simd_f64s(&pivot_row[START..]);
        for (row, b) in rows[k + 1..].iter_mut().zip(&mut rhs[k + 1..]) {
            let factor = row[k] * inverse;
            if factor != 0.0 {
                let minus = simd.splat_f64s(-factor);
                let (target, _) = S::as_mut_simd_f64s(&mut row[START..]);
                for (x, p) in target.iter_mut().zip(source) {
                    *x = simd.mul_add_f64s(minus, *p, *x);
                }
                *b = (-factor).mul_add(pivot_rhs, *b);
            }
        }
    }
}

struct BackSubstitute<'a> {
    factors: &'a [PivotRows],
    solution: &'a mut [Increment],
}

impl WithSimd for BackSubstitute<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for i in (0..self.factors.len()).rev() {
            let factor = &self.factors[i];
            // Columns 8 to 11 belong to the first node and are not found yet: zero.
            let mut next = [0.0; 16];
            next[4..].copy_from_slice(&self.solution[i + 1]);
            let mut rest = factor.rhs;
            for (row, rest) in factor.rows.iter().zip(&mut rest) {
                // Eight partial sums in a fixed order: the same bits on every machine.
                let mut sums = [0.0; 8];
                for l in 0..8 {
                    sums[l] = row[8 + l].mul_add(next[8 + l], row[l] * next[l]);
                }
                let pairs =
                    [sums[0] + sums[4], sums[1] + sums[5], sums[2] + sums[6], sums[3] + sums[7]];
                *rest -= (pairs[0] + pairs[2]) + (pairs[1] + pairs[3]);
            }
            for k in (0..N).rev() {
                let x = rest[k] * factor.inverse[k];
                self.solution[i][k] = x;
                // Below row k the column is zero, so whole columns can be taken.
                for (rest, column) in rest.iter_mut().zip(&factor.columns[k]) {
                    *rest = (-x).mul_add(*column, *rest);
                }
            }
        }
    }
}

/// Solves for the last node, from six carried rows and six rows of the tip.
fn solve_corner(carried: &[PivotRow; 6], tip: &[PivotRow; 6]) -> Increment {
    let mut rows: [PivotRow; N] =
        std::array::from_fn(|r| if r < CARRIED { carried[r] } else { tip[r - CARRIED] });
    for k in 0..N {
        let mut pivot = k;
        for r in k + 1..N {
            if rows[r].0[k].abs() > rows[pivot].0[k].abs() {
                pivot = r;
            }
        }
        rows.swap(k, pivot);
        let (pivot_row, pivot_rhs) = rows[k];
        for (row, rhs) in &mut rows[k + 1..] {
            let factor = row[k] / pivot_row[k];
            for c in k..N {
                row[c] -= factor * pivot_row[c];
            }
            *rhs -= factor * pivot_rhs;
        }
    }
    let mut x = [0.0; N];
    for k in (0..N).rev() {
        let sum: f64 = (k + 1..N).map(|c| rows[k].0[c] * x[c]).sum();
        x[k] = (rows[k].1 - sum) / rows[k].0[k];
    }
    x
}
