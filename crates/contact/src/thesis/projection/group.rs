use super::touch::effective_mass;
use super::{Differences, Form, Partner, PolygonalCone, Touch};
use crate::rigid::{angular, linear, stack};
use crate::{ContactError, RigidBody};
use nalgebra::{DMatrix, Matrix3, Vector3, Vector6};

/// A direction at a contact as a linear form on the twists of a group's bodies.
pub(super) struct TwistForm {
    /// Body of the group, and the wrench `(d, r x d)` that a unit impulse exerts on it.
    sides: Vec<(usize, Vector6<f64>)>,
    /// Velocity along the direction that is taken off: that of the other side.
    pub(super) given: f64,
}

impl TwistForm {
    /// The form applied to one vector per body.
    pub(super) fn apply(&self, vectors: &[Vector6<f64>]) -> f64 {
        self.sides.iter().map(|(body, wrench)| wrench.dot(&vectors[*body])).sum()
    }

    /// Relative velocity along the direction, m/s.
    pub(super) fn velocity(&self, twists: &[Vector6<f64>]) -> f64 {
        self.apply(twists) - self.given
    }

    /// Norm of the form, the 6D norm of (8.65).
    pub(super) fn norm(&self) -> f64 {
        self.sides.iter().map(|(_, wrench)| wrench.norm_squared()).sum::<f64>().sqrt()
    }

    fn scale(&mut self, factor: f64) {
        for (_, wrench) in &mut self.sides {
            *wrench *= factor;
        }
    }
}

/// A contact as a group sees it.
pub(super) struct GroupContact<'a> {
    pub(super) normal: TwistForm,
    pub(super) tangents: [TwistForm; 2],
    /// The normal row is the contact's unit normal times this: 1, or the inverse norm of (8.65).
    pub(super) normal_scale: f64,
    pub(super) closing: f64,
    pub(super) friction: &'a PolygonalCone,
}

/// Bodies that are projected together, with their contacts.
pub(super) struct ProjectionGroup<'a> {
    /// Indices among all bodies.
    pub(super) members: Vec<usize>,
    masses: Vec<(f64, Matrix3<f64>, Matrix3<f64>)>,
    pub(super) links: Vec<GroupContact<'a>>,
}

impl<'a> ProjectionGroup<'a> {
    /// The bodies `members` (by rising index) with the contacts of `touches` that are on one of
    /// them. What is not a member moves as given or, a body, as a plastic impact would have it
    /// (8.67).
    pub(super) fn new(
        bodies: &[RigidBody],
        touches: impl Iterator<Item = (usize, &'a Touch)>,
        members: Vec<usize>,
        form: &Differences,
    ) -> Result<Self, ContactError> {
        let mut links = Vec::new();
        for (index, touch) in touches {
            let [normal, t1, t2] = touch.frame(index)?.map(|d| row(bodies, touch, &members, &d));
            let mut normal = normal;
            let normal_scale = match form.normal {
                Form::AsPrinted => 1.0 / normal.norm(),
                Form::Corrected => 1.0,
            };
            normal.scale(normal_scale);
            links.push(GroupContact {
                normal,
                tangents: [t1, t2],
                normal_scale,
                closing: touch.closing,
                friction: &touch.friction,
            });
        }
        let masses = members
            .iter()
            .map(|&i| (bodies[i].mass(), bodies[i].inertia(), bodies[i].inverse_inertia()))
            .collect();
        Ok(Self { members, masses, links })
    }

    /// `M v` for one vector per body.
    pub(super) fn mass(&self, vectors: &[Vector6<f64>]) -> Vec<Vector6<f64>> {
        self.masses
            .iter()
            .zip(vectors)
            .map(|((mass, inertia, _), v)| stack(&(*mass * linear(v)), &(inertia * angular(v))))
            .collect()
    }

    /// `M^-1 sum_i x_i J_i^T`, or without the masses for the Euclidean metric.
    pub(super) fn answer<'r>(
        &self,
        metric: Form,
        impulses: impl Iterator<Item = (&'r TwistForm, f64)>,
    ) -> Vec<Vector6<f64>> {
        let mut sums = vec![Vector6::zeros(); self.members.len()];
        for (row, impulse) in impulses {
            for (body, wrench) in &row.sides {
                sums[*body] += impulse * wrench;
            }
        }
        for (body, sum) in sums.iter_mut().enumerate() {
            *sum = self.divide(metric, body, sum);
        }
        sums
    }

    /// `J_a M^-1 J_b^T`, or `J_a J_b^T`, for all pairs of rows.
    pub(super) fn gram(&self, metric: Form, a: &[&TwistForm], b: &[&TwistForm]) -> DMatrix<f64> {
        let mut gram = DMatrix::zeros(a.len(), b.len());
        for (j, second) in b.iter().enumerate() {
            for (body, wrench) in &second.sides {
                let answer = self.divide(metric, *body, wrench);
                for (i, first) in a.iter().enumerate() {
                    for (_, row) in first.sides.iter().filter(|side| side.0 == *body) {
                        gram[(i, j)] += row.dot(&answer);
                    }
                }
            }
        }
        gram
    }

    /// `J M^-1 J^T` of one row.
    pub(super) fn own(&self, row: &TwistForm) -> f64 {
        let square = |(body, wrench): &(usize, Vector6<f64>)| {
            wrench.dot(&self.divide(Form::Corrected, *body, wrench))
        };
        row.sides.iter().map(square).sum()
    }

    fn divide(&self, metric: Form, body: usize, wrench: &Vector6<f64>) -> Vector6<f64> {
        match metric {
            Form::AsPrinted => *wrench,
            Form::Corrected => {
                let (mass, _, inverse) = &self.masses[body];
                stack(&(linear(wrench) / *mass), &(inverse * angular(wrench)))
            }
        }
    }
}

fn row(
    bodies: &[RigidBody],
    touch: &Touch,
    members: &[usize],
    direction: &Vector3<f64>,
) -> TwistForm {
    let wrench =
        |body: usize| stack(direction, &(touch.point - bodies[body].center()).cross(direction));
    let mut sides = Vec::with_capacity(2);
    if let Ok(local) = members.binary_search(&touch.body) {
        sides.push((local, wrench(touch.body)));
    }
    let given = match touch.partner {
        Partner::Given(velocity) => velocity.dot(direction),
        Partner::Body(other) => {
            if let Ok(local) = members.binary_search(&other) {
                sides.push((local, -wrench(other)));
            }
            match sides[..] {
                [_, _] => 0.0,
                // The common velocity, seen from the body that is a member.
                _ if members.binary_search(&touch.body).is_ok() => {
                    common(bodies, touch, other, direction)
                }
                _ => -common(bodies, touch, other, direction),
            }
        }
    };
    TwistForm { sides, given }
}

/// (8.67), for any direction: the mean of both sides' velocities at the contact, weighted by their
/// effective masses (8.68).
fn common(bodies: &[RigidBody], touch: &Touch, other: usize, direction: &Vector3<f64>) -> f64 {
    let [a, b] = [&bodies[touch.body], &bodies[other]].map(|body| {
        let mass = effective_mass(body, &touch.point, direction);
        (mass, mass * body.velocity_at(&touch.point).dot(direction))
    });
    (a.1 + b.1) / (a.0 + b.0)
}
