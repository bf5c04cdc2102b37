use super::group::{GroupContact, ProjectionGroup, TwistForm};
use super::{Differences, Form, PolygonalCone, active_set, program};
use crate::ContactError;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Vector6};

/// Share of a diagonal entry that must be left after elimination for the fast solver to be used.
const REGULAR: f64 = 1e-7;

/// Share of the diagonal by which proximal steps make a singular matrix regular.
const PROXIMITY: f64 = 1e-3;

/// Most proximal steps; five are usual.
const PROXIMAL_STEPS: usize = 40;

/// Cosine, in the mass metric, below which a normal and a tangent are orthogonal.
const UNCOUPLED: f64 = 1e-12;

/// Lines 8 and 9 of Alg. 6: the change of the twists by the friction that dissipates most.
///
/// `plus` are the twists after the normal impulses, `bouncing` those after restitution. The
/// unknowns are the impulses `p` along the contacts' tangents, as (8.58) has it; the printed half
/// planes on `M u` alone would leave four of a body's six directions unbounded.
pub(super) fn project(
    group: &ProjectionGroup<'_>,
    plus: &[Vector6<f64>],
    bouncing: &[Vector6<f64>],
    impulses: &[f64],
    form: &Differences,
) -> Result<Vec<Vector6<f64>>, ContactError> {
    let loaded: Vec<usize> = (0..group.links.len())
        .filter(|&i| impulses[i] > 0.0 && !group.links[i].friction.is_frictionless())
        .collect();
    let tangents: Vec<&TwistForm> = loaded.iter().flat_map(|&i| &group.links[i].tangents).collect();
    if tangents.is_empty() {
        return Ok(vec![Vector6::zeros(); plus.len()]);
    }
    let velocity = match form.friction_velocity {
        Form::AsPrinted => plus,
        Form::Corrected => bouncing,
    };
    let normals: Vec<&TwistForm> = group.links.iter().map(|link| &link.normal).collect();
    let room = |link: &GroupContact<'_>| match form.objective {
        // Asked of friction's own change of velocity.
        Form::AsPrinted => 0.0,
        Form::Corrected => link.normal.velocity(velocity) + link.closing,
    };
    let limit = |&i: &usize| (impulses[i], group.links[i].friction);
    let friction = TangentialProgram {
        answers: group.gram(Form::Corrected, &tangents, &tangents),
        coupling: group.gram(Form::Corrected, &normals, &tangents),
        normals: normals.iter().map(|row| group.own(row)).collect(),
        slip: DVector::from_iterator(
            tangents.len(),
            tangents.iter().map(|row| row.velocity(velocity)),
        ),
        room: group.links.iter().map(room).collect(),
        limits: loaded.iter().map(limit).collect(),
        set: form.friction_set,
    };
    let p = match form.objective {
        Form::AsPrinted => {
            let twists = |row: &TwistForm| {
                let answer = group.answer(Form::Corrected, std::iter::once((row, 1.0)));
                answer.iter().zip(velocity).map(|(a, u)| a.dot(u)).sum()
            };
            let slope =
                DVector::from_iterator(tangents.len(), tangents.iter().map(|row| twists(row)));
            let (a, b) = friction.constraints();
            program::solve(&DMatrix::zeros(slope.len(), slope.len()), &slope, &a, &b)?
        }
        Form::Corrected => friction.solve()?,
    };
    Ok(group.answer(Form::Corrected, tangents.iter().copied().zip(p.iter().copied())))
}

/// Friction of contacts that bear impulses, in their own coordinates: two unknowns for each.
pub(super) struct TangentialProgram<'a> {
    /// Velocities along the tangents per impulse along them, `D^T M^-1 D`, 1/kg.
    pub(super) answers: DMatrix<f64>,
    /// Velocities along the normals of all contacts per impulse along the tangents, `J M^-1 D`,
    /// 1/kg.
    pub(super) coupling: DMatrix<f64>,
    /// Velocity along each normal per impulse along it, 1/kg.
    pub(super) normals: Vec<f64>,
    /// Velocities along the tangents without friction, m/s.
    pub(super) slip: DVector<f64>,
    /// Amount by which each normal velocity may fall, m/s; less than zero is none.
    pub(super) room: Vec<f64>,
    /// Normal impulses, and the limit curves for a unit of each.
    pub(super) limits: Vec<(f64, &'a PolygonalCone)>,
    /// Text whose half planes bound the friction.
    pub(super) set: Form,
}

impl TangentialProgram<'_> {
    /// Impulses along the tangents that leave the least energy, N s.
    pub(super) fn solve(&self) -> Result<DVector<f64>, ContactError> {
        let (a, b) = self.constraints();
        match least_energy(&self.answers, &self.slip, &a, &b) {
            Some(p) => Ok(p),
            None => program::solve(&self.answers, &self.slip, &a, &b),
        }
    }

    /// `a p <= b`: every contact's limit curve, and no contact pushed together by friction.
    fn constraints(&self) -> (DMatrix<f64>, DVector<f64>) {
        let mut curves = Vec::new();
        for (k, (impulse, curve)) in self.limits.iter().enumerate() {
            let planes = curve.half_planes(self.set).iter();
            curves.extend(planes.map(|(direction, bound)| (k, *direction, bound * impulse)));
        }
        let (count, unknowns) = (curves.len() + self.normals.len(), self.slip.len());
        let (mut a, mut b) = (DMatrix::zeros(count, unknowns), DVector::zeros(count));
        for (i, (k, direction, bound)) in curves.iter().enumerate() {
            a[(i, 2 * k)] = direction.x;
            a[(i, 2 * k + 1)] = direction.y;
            b[i] = bound.max(0.0);
        }
        for (i, (normal, room)) in self.normals.iter().zip(&self.room).enumerate() {
            for j in 0..unknowns {
                // Rounding in what should be orthogonal must not forbid to slide.
                let (coupling, size) = (self.coupling[(i, j)], normal * self.answers[(j, j)]);
                if coupling.powi(2) > UNCOUPLED * UNCOUPLED * size {
                    a[(curves.len() + i, j)] = -coupling;
                }
            }
            b[curves.len() + i] = room.max(0.0);
        }
        (a, b)
    }
}

/// `argmin 1/2 p^T h p + g^T p` such that `a p <= b` by the active set on the dual: exact to
/// rounding, and exactly the free minimum where that is allowed. Where `h` is singular, as for two
/// points on the axis of a segment, by proximal steps of the same kind, which converge to one of
/// the minima at the rate [`PROXIMITY`]. `None` where they do not.
fn least_energy(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    a: &DMatrix<f64>,
    b: &DVector<f64>,
) -> Option<DVector<f64>> {
    if let Some(factor) = factorize(h) {
        return constrained(&factor, g, a, b);
    }
    let proximity = DMatrix::from_diagonal(&(h.diagonal() * PROXIMITY));
    let factor = factorize(&(h + &proximity))?;
    let mut p = DVector::zeros(g.len());
    for _ in 0..PROXIMAL_STEPS {
        let next = constrained(&factor, &(g - &proximity * &p), a, b)?;
        // What the step leaves of the slope, a velocity.
        let left = (&proximity * (&next - &p)).amax();
        p = next;
        if left <= 1e-14 * g.amax() {
            return Some(p);
        }
    }
    None
}

fn factorize(h: &DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    let factor = Cholesky::new(h.clone())?;
    let lower = factor.l_dirty();
    let regular = (0..h.nrows()).all(|i| lower[(i, i)].powi(2) >= REGULAR * h[(i, i)]);
    regular.then_some(factor)
}

/// With the dual, `min 1/2 y^T G y + y^T (b + a h^-1 g)` over `y >= 0`, `G = a h^-1 a^T`.
fn constrained(
    factor: &Cholesky<f64, Dyn>,
    g: &DVector<f64>,
    a: &DMatrix<f64>,
    b: &DVector<f64>,
) -> Option<DVector<f64>> {
    let free = -factor.solve(g);
    let slack = b - a * &free;
    if slack.min() >= 0.0 {
        return Some(free);
    }
    let spread = factor.solve(&a.transpose());
    let y = active_set::minimize(&(a * &spread), &slack)?;
    Some(free - spread * y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A random program of friction: `h` regular or of rank one, `p = 0` feasible, the set bounded
    /// by a box.
    fn programs() -> impl Strategy<Value = (DMatrix<f64>, DVector<f64>, DMatrix<f64>, DVector<f64>)>
    {
        (1..4_usize, 0..8_usize, any::<bool>()).prop_flat_map(|(contacts, extra, regular)| {
            let n = 2 * contacts;
            let numbers = |count: usize| prop::collection::vec(-1.0..1.0_f64, count);
            (
                numbers(n * n),
                numbers(n),
                numbers(extra * n),
                prop::collection::vec(0.0..1.0_f64, extra),
            )
                .prop_map(move |(root, g, rows, bounds)| {
                    let root = DMatrix::from_vec(n, n, root);
                    let h = if regular {
                        &root * root.transpose() + DMatrix::identity(n, n) * 0.05
                    } else {
                        // As masses are: no tangent that hardly moves.
                        let rank_one = root.column(0).map(|x| x + 0.3_f64.copysign(x));
                        &rank_one * rank_one.transpose()
                    };
                    let mut a = DMatrix::zeros(2 * n + extra, n);
                    let mut b = DVector::from_element(2 * n + extra, 0.5);
                    for i in 0..n {
                        a[(2 * i, i)] = 1.0;
                        a[(2 * i + 1, i)] = -1.0;
                    }
                    for i in 0..extra {
                        a.row_mut(2 * n + i).copy_from_slice(&rows[i * n..(i + 1) * n]);
                        b[2 * n + i] = bounds[i];
                    }
                    (h, DVector::from_vec(g), a, b)
                })
        })
    }

    proptest! {
        #[test]
        fn active_set_meets_the_interior_point((h, g, a, b) in programs()) {
            let Some(fast) = least_energy(&h, &g, &a, &b) else {
                prop_assert!(factorize(&h).is_none());
                return Ok(());
            };
            let slow = program::solve(&h, &g, &a, &b).expect("feasible and bounded");
            let rounding = if factorize(&h).is_some() { 1e-12 } else { 1e-16 / PROXIMITY };
            prop_assert!((&a * &fast - &b).max() < 100.0 * rounding);
            let cost = |p: &DVector<f64>| 0.5 * p.dot(&(&h * p)) + g.dot(p);
            prop_assert!((cost(&fast) - cost(&slow)).abs() < 1e-7);
            prop_assert!(factorize(&h).is_none() || (&fast - &slow).norm() < 1e-4, "{fast} {slow}");
        }
    }
}
