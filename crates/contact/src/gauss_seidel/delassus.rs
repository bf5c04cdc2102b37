use crate::{Body, Contact, ContactError};
use nalgebra::{Matrix3, Vector3};

/// What all contacts of some bodies do to each other: every body's dense answer of its touched
/// points to impulses on them, and the velocities of these points.
#[derive(Debug)]
pub(crate) struct Delassus {
    patches: Vec<Patch>,
    /// By point of all bodies: its patch and its place there, where it is touched.
    places: Vec<Option<(usize, usize)>>,
}

/// What is left of the answers of two points less than this, relative to them, is rounding.
const ROUNDING: f64 = 1e-13;

/// The touched points of one body.
#[derive(Debug)]
struct Patch {
    velocities: Vec<Vector3<f64>>,
    /// Answer of point `i` to point `j` at `i + j * points`.
    responses: Vec<Matrix3<f64>>,
}

impl Delassus {
    /// Asks every body for three columns per touched point. Takes away weights.
    pub(crate) fn new(
        bodies: &mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
    ) -> Result<Self, ContactError> {
        let points = bodies.iter().map(|body| body.points()).sum();
        if velocities.len() != points {
            return Err(ContactError::Length {
                what: "velocities of points",
                expected: points,
                found: velocities.len(),
            });
        }
        finite("component of a velocity", velocities)?;
        let mut touched = vec![false; points];
        for (index, contact) in contacts.iter().enumerate() {
            contact.validate(index, points)?;
            touched[contact.first] = true;
            if let Some(second) = contact.second {
                touched[second] = true;
            }
        }
        let mut delassus = Self { patches: Vec::new(), places: vec![None; points] };
        let mut offset = 0;
        for (index, body) in bodies.iter_mut().enumerate() {
            let count = body.points();
            let of_body = offset..offset + count;
            let local: Vec<usize> = (0..count).filter(|&i| touched[offset + i]).collect();
            for (place, &i) in local.iter().enumerate() {
                delassus.places[offset + i] = Some((index, place));
            }
            let patch = Patch::new(*body, &local, &velocities[of_body])?;
            if !patch.responses.iter().all(|block| block.iter().all(|x| x.is_finite())) {
                return Err(ContactError::Body {
                    body: index,
                    why: "its answer is not finite".into(),
                });
            }
            delassus.patches.push(patch);
            offset += count;
        }
        Ok(delassus)
    }

    /// The contact's own answer, in its frame; zero where both points can only move together.
    pub(crate) fn own_response(&self, contact: &Contact) -> Matrix3<f64> {
        let block = |of: usize, to: usize| match (self.places[of], self.places[to]) {
            (Some((a, i)), Some((b, j))) if a == b => self.patches[a].response(i, j),
            _ => Matrix3::zeros(),
        };
        let first = contact.first;
        let mut world = block(first, first);
        if let Some(second) = contact.second {
            let apart = world + block(second, second);
            world = apart - block(first, second) - block(second, first);
            if world.trace() <= ROUNDING * apart.trace() {
                return Matrix3::zeros();
            }
        }
        let local = contact.frame.transpose() * world * contact.frame;
        0.5 * (local + local.transpose())
    }

    /// Velocity of the first point relative to the second, in the contact's frame, and its bias.
    pub(crate) fn relative_velocity(&self, contact: &Contact) -> Vector3<f64> {
        let second = contact.second.map_or_else(Vector3::zeros, |second| self.velocity(second));
        contact.frame.tr_mul(&(self.velocity(contact.first) - second)) + contact.bias
    }

    /// Lets `impulse`, in the contact's frame, act.
    pub(crate) fn apply(&mut self, contact: &Contact, impulse: &Vector3<f64>) {
        let world = contact.frame * impulse;
        self.push(contact.first, &world);
        if let Some(second) = contact.second {
            self.push(second, &-world);
        }
    }

    fn velocity(&self, point: usize) -> Vector3<f64> {
        self.places[point]
            .map_or_else(Vector3::zeros, |(patch, place)| self.patches[patch].velocities[place])
    }

    fn push(&mut self, point: usize, impulse: &Vector3<f64>) {
        if let Some((patch, place)) = self.places[point] {
            let Patch { velocities, responses } = &mut self.patches[patch];
            let count = velocities.len();
            let column = &responses[place * count..(place + 1) * count];
            for (velocity, response) in velocities.iter_mut().zip(column) {
                *velocity += response * impulse;
            }
        }
    }
}

impl Patch {
    fn new(
        body: &mut dyn Body,
        local: &[usize],
        velocities: &[Vector3<f64>],
    ) -> Result<Self, ContactError> {
        let (points, count) = (body.points(), local.len());
        let mut impulses = vec![Vector3::zeros(); points];
        let mut answer = vec![Vector3::zeros(); points];
        let mut responses = vec![Matrix3::zeros(); count * count];
        for (column, &j) in local.iter().enumerate() {
            for axis in 0..3 {
                impulses[j][axis] = 1.0;
                body.respond(&impulses, &mut answer);
                impulses[j][axis] = 0.0;
                for (row, &i) in local.iter().enumerate() {
                    responses[row + column * count].set_column(axis, &answer[i]);
                }
            }
        }
        Ok(Self { velocities: local.iter().map(|&i| velocities[i]).collect(), responses })
    }

    fn response(&self, of: usize, to: usize) -> Matrix3<f64> {
        self.responses[of + to * self.velocities.len()]
    }
}

/// # Errors
/// [`ContactError::Invalid`] for a component that is not finite.
pub(crate) fn finite(what: &'static str, vectors: &[Vector3<f64>]) -> Result<(), ContactError> {
    match vectors.iter().flat_map(|v| v.iter()).find(|x| !x.is_finite()) {
        Some(&value) => Err(ContactError::Invalid { what, value, why: "it must be finite" }),
        None => Ok(()),
    }
}
