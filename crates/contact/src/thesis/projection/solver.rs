use super::friction::TangentialProgram;
use super::{Form, PolygonalCone, normal};
use crate::solver::{check, respond};
use crate::{Body, Contact, ContactError, LimitCurve, Report, Solver, Tolerance, report};
use nalgebra::{DMatrix, DVector, Vector2, Vector3};
use std::f64::consts::TAU;

/// The corrected Alg. 6 as a [`Solver`], for bodies of any kind: what they answer to impulses at
/// the contacts is all that its two projections need.
///
/// It does one pass and then looks how good that is. Normal impulses pull nothing, let
/// nothing approach and do not know of friction; friction is within the limits that they set and
/// leaves the least energy. Without biases and adhesion no energy is gained. Where impulses along
/// tangents do not move points along normals it is the law, of polygons; else it is not, and the
/// report says how far from it. Where nothing keeps all contacts apart, the impulses that were
/// given stay.
///
/// Only `friction_set` of [`Differences`](super::Differences) can be as printed here. `metric`,
/// `normal`, `impulse` and `objective` need inner products of twists, which no [`Body`] tells;
/// `scope` and `restitution` change velocities as no impulses on both sides of contacts do; `force`
/// and `gyroscopic` are the step's; `friction_velocity` is of restitution, which here is a
/// [bias](Contact::bias), each contact its own.
///
/// Asks all bodies three times per contact; the programs are as large as those of
/// [`project`](super::project).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoProjections {
    /// Tolerances within which the result is called converged; the number of iterations does not
    /// matter.
    pub tolerance: Tolerance,
    /// Set of frictions of line 9 and (8.63), see
    /// [`Differences::friction_set`](super::Differences::friction_set).
    pub friction_set: Form,
    /// Corners of the inner polygon (8.48) that stands for a curve that is none, at least three.
    pub corners: usize,
}

impl TwoProjections {
    /// Corrected, with eight corners.
    #[must_use]
    pub fn new(tolerance: Tolerance) -> Self {
        Self { tolerance, friction_set: Form::Corrected, corners: 8 }
    }

    fn polygon(&self, curve: &LimitCurve) -> Result<PolygonalCone, ContactError> {
        let around = |count: usize| {
            (0..count).map(move |i| {
                let angle = TAU * i as f64 / count as f64;
                let (sine, cosine) = angle.sin_cos();
                (angle, 1.0 / curve.gauge(&Vector2::new(cosine, sine)))
            })
        };
        let LimitCurve::Polygon(polygon) = curve else {
            return PolygonalCone::new(&around(self.corners).collect::<Vec<_>>());
        };
        let corners = polygon.vertices().iter().filter(|corner| **corner != Vector2::zeros());
        let mut spokes: Vec<_> = corners.map(|p| (p.y.atan2(p.x), p.norm())).collect();
        PolygonalCone::new(&spokes).or_else(|_| {
            // The curve has no corners on one side of the origin.
            spokes.extend(around(4));
            PolygonalCone::new(&spokes)
        })
    }

    /// Both projections, from the tips of the cones: `answers` of all contacts and their velocities
    /// before.
    fn project(
        &self,
        contacts: &[Contact],
        answers: &DMatrix<f64>,
        before: &DVector<f64>,
    ) -> Result<DVector<f64>, ContactError> {
        let normals: Vec<usize> = (0..contacts.len()).map(|i| 3 * i).collect();
        let all = answers.select_columns(&normals);
        let pressed =
            normal::multipliers(&all.select_rows(&normals), &before.select_rows(&normals))?;
        let mut impulses = DVector::zeros(before.len());
        let (mut tangents, mut loaded) = (Vec::new(), Vec::new());
        for ((&row, &impulse), contact) in normals.iter().zip(&pressed).zip(contacts) {
            impulses[row] = impulse;
            let curve = self.polygon(&contact.friction)?;
            if impulse > 0.0 && !curve.is_frictionless() {
                tangents.extend([row + 1, row + 2]);
                loaded.push((impulse, curve));
            }
        }
        if loaded.is_empty() {
            return Ok(impulses);
        }
        let after = before + &all * pressed;
        let sideways = answers.select_columns(&tangents);
        let friction = TangentialProgram {
            answers: sideways.select_rows(&tangents),
            coupling: sideways.select_rows(&normals),
            normals: normals.iter().map(|&i| answers[(i, i)]).collect(),
            slip: after.select_rows(&tangents),
            room: normals.iter().map(|&i| after[i]).collect(),
            limits: loaded.iter().map(|(impulse, curve)| (*impulse, curve)).collect(),
            set: self.friction_set,
        };
        for (row, impulse) in tangents.iter().zip(&friction.solve()?) {
            impulses[*row] = *impulse;
        }
        Ok(impulses)
    }
}

impl Solver for TwoProjections {
    fn solve(
        &mut self,
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
        impulses: &mut [Vector3<f64>],
    ) -> Result<Report, ContactError> {
        check(bodies, contacts, velocities, impulses)?;
        let mut answers = answers(bodies, contacts, velocities.len())?;
        let given = stacked(impulses.iter().copied());
        let mut before = stacked(contacts.iter().map(|contact| contact.relative(velocities)));
        before -= &answers * &given;
        for (i, contact) in contacts.iter().enumerate() {
            (3 * i..3 * i + 3).for_each(|k| answers[(k, k)] += contact.compliance);
        }
        let tips = stacked(contacts.iter().map(|contact| Vector3::x() * contact.adhesion));
        let found = match self.project(contacts, &answers, &(&before - &answers * &tips)) {
            Ok(from_tips) => from_tips - tips,
            Err(ContactError::Program { .. }) => given,
            Err(error) => return Err(error),
        };
        let after = before + &answers * &found;
        let at = |all: &DVector<f64>, i: usize| all.fixed_rows::<3>(3 * i).into_owned();
        for (i, impulse) in impulses.iter_mut().enumerate() {
            *impulse = at(&found, i);
        }
        let one = |i: usize| {
            let trace = answers.fixed_view::<3, 3>(3 * i, 3 * i).trace();
            let weight = if trace > 0.0 { 3.0 / trace } else { 1.0 };
            (&contacts[i], at(&after, i), at(&found, i), weight)
        };
        let found = Report { iterations: 1, ..report(contacts.len(), one) };
        Ok(Report { converged: self.tolerance.reached(&found), ..found })
    }
}

/// Relative velocities of all contacts per impulse at each, 1/kg, in the contacts' frames.
fn answers(
    bodies: &mut [&mut dyn Body],
    contacts: &[Contact],
    points: usize,
) -> Result<DMatrix<f64>, ContactError> {
    let still = vec![Vector3::zeros(); points];
    let mut unit = vec![Vector3::zeros(); contacts.len()];
    let mut answers = DMatrix::zeros(3 * contacts.len(), 3 * contacts.len());
    for column in 0..3 * contacts.len() {
        unit[column / 3][column % 3] = 1.0;
        let moved = respond(bodies, contacts, &still, &unit);
        unit[column / 3][column % 3] = 0.0;
        let relative = contacts.iter().map(|contact| contact.relative(&moved) - contact.bias);
        answers.set_column(column, &stacked(relative));
    }
    match answers.iter().find(|x| !x.is_finite()) {
        Some(&value) => {
            Err(ContactError::Invalid { what: "answer of a body", value, why: "it must be finite" })
        }
        None => Ok(0.5 * (&answers + answers.transpose())),
    }
}

fn stacked(vectors: impl ExactSizeIterator<Item = Vector3<f64>>) -> DVector<f64> {
    let size = 3 * vectors.len();
    DVector::from_iterator(size, vectors.flat_map(|v| [v.x, v.y, v.z]))
}
