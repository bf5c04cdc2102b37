//! The law of some contacts as equations, and a step of Newton's method.

use crate::gauss_seidel::Delassus;
use crate::limit_curve::NearestFriction;
use crate::residual::report;
use crate::{Contact, ErrorMasses, FreeMasses, Report};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Vector2, Vector3};

/// Added to the diagonal of the answers, relative to what a contact answers to itself: contacts may
/// share what they bear in many ways, and of these the nearest to the given one is taken. It leaves
/// a part as small of each step undone.
const STEP_SOFTNESS: f64 = 1e-6;

/// Impulses and relative velocities of some contacts, and how these answer those.
pub(super) struct ContactEquations<'a> {
    contacts: &'a [Contact],
    /// Masses by which errors are judged.
    masses: Vec<ErrorMasses>,
    /// `rho` of the normal and of both tangents of each contact, kg.
    scales: Vec<[f64; 2]>,
    /// Answers of the velocities to the impulses, 1/kg, in the contacts' frames, with compliance.
    response: DMatrix<f64>,
    /// Impulses, N s, three a contact, in their frames.
    impulses: DVector<f64>,
    /// Relative velocities while these act, m/s, in the same order.
    velocities: DVector<f64>,
}

/// The piece of a contact's equations that its impulse and velocity are on.
enum ContactPiece {
    /// It bears nothing.
    Open,
    /// It is pressed, with this nearest friction.
    Pressed(NearestFriction),
    /// It is a joint.
    Joint,
}

impl<'a> ContactEquations<'a> {
    /// Equations of contacts with their `impulses`, N s, in their frames, and the answers and
    /// velocities of their points.
    pub(super) fn new(
        contacts: &'a [Contact],
        delassus: &Delassus,
        free: &FreeMasses,
        impulses: &[Vector3<f64>],
    ) -> Self {
        let count = contacts.len();
        let mut response = DMatrix::zeros(3 * count, 3 * count);
        for (i, of) in contacts.iter().enumerate() {
            for (j, to) in contacts.iter().enumerate().skip(i + 1) {
                let block = delassus.response(of, to);
                response.fixed_view_mut::<3, 3>(3 * i, 3 * j).copy_from(&block);
                response.fixed_view_mut::<3, 3>(3 * j, 3 * i).copy_from(&block.transpose());
            }
            let mut own = delassus.own_response(of);
            own += Matrix3::from_diagonal_element(of.compliance);
            response.fixed_view_mut::<3, 3>(3 * i, 3 * i).copy_from(&own);
        }
        let velocity = |(contact, impulse): (&Contact, &Vector3<f64>)| {
            delassus.relative_velocity(contact) + impulse * contact.compliance
        };
        let all: Vec<_> = contacts.iter().zip(impulses).map(velocity).collect();
        let stacked = |vectors: &[Vector3<f64>]| {
            DVector::from_iterator(3 * count, vectors.iter().flatten().copied())
        };
        // What nothing moves has no inertia to compare with: any mass will do.
        let heavy = |answer: f64| if answer > 0.0 { 1.0 / answer } else { 1.0 };
        let diagonal = response.diagonal();
        let own = |i: usize| diagonal.fixed_rows::<3>(3 * i).into_owned();
        let masses = |(i, contact): (usize, &Contact)| {
            let own = heavy(own(i).sum() / 3.0);
            ErrorMasses { own, moved: own.max(free.of(contact)) }
        };
        Self {
            masses: contacts.iter().enumerate().map(masses).collect(),
            scales: (0..count)
                .map(|i| [heavy(own(i).x), heavy(0.5 * (own(i).y + own(i).z))])
                .collect(),
            contacts,
            impulses: stacked(impulses),
            velocities: stacked(&all),
            response,
        }
    }

    /// Writes the impulses, N s, in the contacts' frames.
    pub(super) fn write(&self, impulses: &mut [Vector3<f64>]) {
        for (i, impulse) in impulses.iter_mut().enumerate() {
            *impulse = of(&self.impulses, i);
        }
    }

    /// How far the contacts are from the law.
    pub(super) fn report(&self) -> Report {
        report(self.contacts.len(), |i| {
            let contact = &self.contacts[i];
            (contact, of(&self.velocities, i), of(&self.impulses, i), self.masses[i])
        })
    }

    /// Takes a step of Newton's method. Returns whether there is one.
    ///
    /// Always a whole one: behind corners of the equations it may lead far away, but shorter ones
    /// end before them.
    pub(super) fn step(&mut self) -> bool {
        let (pieces, errors) = self.pieces();
        let Some(step) = self.direction(&pieces, &errors) else { return false };
        self.velocities += &self.response * &step;
        self.impulses += step;
        self.velocities.iter().all(|x| x.is_finite())
    }

    /// Pieces of the equations at the present impulses and velocities, and what is wrong there,
    /// N s.
    fn pieces(&self) -> (Vec<ContactPiece>, DVector<f64>) {
        let mut errors = DVector::zeros(self.impulses.len());
        let piece = |(i, contact): (usize, &Contact)| {
            let (r, u) = (of(&self.impulses, i), of(&self.velocities, i));
            let [normal, tangent] = self.scales[i];
            if contact.is_joint() {
                errors.fixed_rows_mut::<3>(3 * i).copy_from(&(u * tangent));
                return ContactPiece::Joint;
            }
            let (load, q) = (r.x + contact.adhesion, r.yz() - u.yz() * tangent);
            let pressed = load - normal * u.x;
            if pressed <= 0.0 {
                errors.fixed_rows_mut::<3>(3 * i).copy_from(&Vector3::new(load, r.y, r.z));
                return ContactPiece::Open;
            }
            let nearest = contact.friction.nearest(&q, pressed);
            let apart = r.yz() - nearest.point;
            let error = Vector3::new(normal * u.x, apart.x, apart.y);
            errors.fixed_rows_mut::<3>(3 * i).copy_from(&error);
            ContactPiece::Pressed(nearest)
        };
        let pieces = self.contacts.iter().enumerate().map(piece).collect();
        (pieces, errors)
    }

    /// Step of all impulses to where the present pieces have no error, N s.
    fn direction(&self, pieces: &[ContactPiece], errors: &DVector<f64>) -> Option<DVector<f64>> {
        let bearing: Vec<usize> =
            (0..pieces.len()).filter(|&i| !matches!(pieces[i], ContactPiece::Open)).collect();
        let mut step = -errors;
        bearing.iter().for_each(|&i| step.fixed_rows_mut::<3>(3 * i).fill(0.0));
        // What opens lets go of all it bears; what that changes the others have to answer.
        let opened = &self.response * &step;
        let size = 3 * bearing.len();
        let (mut matrix, mut right) = (DMatrix::zeros(size, size), DVector::zeros(size));
        for (row, &i) in bearing.iter().enumerate() {
            let [normal, tangent] = self.scales[i];
            let scales = Vector3::new(normal, tangent, tangent);
            // By the velocity, and by the impulse itself.
            let mut by_velocity = Matrix3::from_diagonal(&scales);
            let mut by_impulse = Matrix3::zeros();
            if let ContactPiece::Pressed(NearestFriction { slope, growth, .. }) = &pieces[i] {
                set_tangents(&mut by_velocity, &(growth * normal), &(slope * tangent));
                set_tangents(&mut by_impulse, &-growth, &(Matrix2::identity() - slope));
            }
            for (column, &j) in bearing.iter().enumerate() {
                let mut answer = self.response.fixed_view::<3, 3>(3 * i, 3 * j).into_owned();
                if i == j {
                    answer += Matrix3::from_diagonal_element(STEP_SOFTNESS * answer.trace());
                }
                let mut block = by_velocity * answer;
                if i == j {
                    block += by_impulse;
                }
                matrix.fixed_view_mut::<3, 3>(3 * row, 3 * column).copy_from(&block);
            }
            let known = of(errors, i) + by_velocity * of(&opened, i);
            right.fixed_rows_mut::<3>(3 * row).copy_from(&-known);
        }
        if bearing.is_empty() {
            return Some(step);
        }
        let solved = matrix.lu().solve(&right)?;
        for (row, &i) in bearing.iter().enumerate() {
            step.fixed_rows_mut::<3>(3 * i).copy_from(&solved.fixed_rows::<3>(3 * row));
        }
        step.iter().all(|x| x.is_finite()).then_some(step)
    }
}

/// Sets the rows of the tangents.
fn set_tangents(matrix: &mut Matrix3<f64>, by_normal: &Vector2<f64>, by_tangents: &Matrix2<f64>) {
    matrix.fixed_view_mut::<2, 1>(1, 0).copy_from(by_normal);
    matrix.fixed_view_mut::<2, 2>(1, 1).copy_from(by_tangents);
}

/// Vector of contact number `i`.
fn of(stacked: &DVector<f64>, i: usize) -> Vector3<f64> {
    stacked.fixed_rows::<3>(3 * i).into_owned()
}
