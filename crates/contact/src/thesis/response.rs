use crate::solver::on_points;
use crate::thesis::projection::{Differences, Partner, Touch, project};
use crate::{Body, Contact, ContactError, Report, RigidBody, RigidPoints, Solver, impact};
use nalgebra::{Matrix3, Point3, Vector3};

/// Method by which rigid bodies answer what touches them: any [`Solver`], with the restitution of
/// [`impact`], or Alg. 6, as printed and corrected, which changes twists and is for rigid bodies
/// alone.
pub trait Response {
    /// Replaces the velocities of `bodies` by those after the impacts `touches`, with one
    /// coefficient of `restitution`, 0 to 1. Tells how well the law of contacts is obeyed where
    /// that is known.
    ///
    /// # Errors
    /// [`ContactError`] where [`impact`] or [`project`] fails. The bodies are then as before.
    fn collide(
        &mut self,
        bodies: &mut [RigidBody],
        touches: &[Touch],
        restitution: f64,
    ) -> Result<Option<Report>, ContactError>;
}

/// Alg. 6, by [`project`]: with `scope` corrected all contacts are one dense program, for a few
/// hundred at most; as printed each body has its own, in parallel: the partners of a contact feel
/// different impulses, and where a body is squeezed between others what it must not do may leave
/// nothing, [`ContactError::Program`].
impl Response for Differences {
    fn collide(
        &mut self,
        bodies: &mut [RigidBody],
        touches: &[Touch],
        restitution: f64,
    ) -> Result<Option<Report>, ContactError> {
        project(bodies, touches, restitution, self).map(|()| None)
    }
}

impl<S: Solver> Response for S {
    fn collide(
        &mut self,
        bodies: &mut [RigidBody],
        touches: &[Touch],
        restitution: f64,
    ) -> Result<Option<Report>, ContactError> {
        let mut on_body: Vec<Vec<Point3<f64>>> = vec![Vec::new(); bodies.len()];
        // Body, and place among its points, of the two sides.
        let mut sides = Vec::with_capacity(touches.len());
        for (index, touch) in touches.iter().enumerate() {
            touch.check(index, bodies.len())?;
            let mut point = |body: usize| {
                on_body[body].push(touch.point);
                (body, on_body[body].len() - 1)
            };
            let other = match touch.partner {
                Partner::Body(other) => Some(point(other)),
                Partner::Given(_) => None,
            };
            sides.push((point(touch.body), other));
        }
        let mut points: Vec<RigidPoints> = bodies
            .iter()
            .zip(&on_body)
            .map(|(body, points)| body.with_points(points))
            .collect::<Result<_, ContactError>>()?;
        let starts: Vec<usize> = on_body
            .iter()
            .scan(0, |end, points| {
                *end += points.len();
                Some(*end - points.len())
            })
            .collect();
        let at = |(body, point): (usize, usize)| starts[body] + point;
        let contacts: Vec<Contact> = touches
            .iter()
            .zip(&sides)
            .enumerate()
            .map(|(index, (touch, (first, second)))| {
                contact(index, touch, at(*first), second.map(at))
            })
            .collect::<Result<_, ContactError>>()?;
        let velocities: Vec<Vector3<f64>> = bodies
            .iter()
            .zip(&on_body)
            .flat_map(|(body, points)| points.iter().map(|point| body.velocity_at(point)))
            .collect();
        let mut seen: Vec<&mut dyn Body> = points.iter_mut().map(|points| points as _).collect();
        let shares = vec![restitution; contacts.len()];
        let found = impact(&mut seen, &contacts, &shares, &velocities, self)?;
        let on_points = on_points(&contacts, &found.impulses, velocities.len());
        for ((body, points), start) in bodies.iter_mut().zip(&points).zip(&starts) {
            body.apply_wrench(&points.wrench(&on_points[*start..][..points.points()]));
        }
        Ok(Some(found.report))
    }
}

/// Contact of a touch, as a solver takes it, between the points `first` and `second`.
fn contact(
    index: usize,
    touch: &Touch,
    first: usize,
    second: Option<usize>,
) -> Result<Contact, ContactError> {
    let frame = Matrix3::from_columns(&touch.frame(index)?);
    let given = match touch.partner {
        Partner::Given(velocity) => frame.tr_mul(&velocity),
        Partner::Body(_) => Vector3::zeros(),
    };
    Ok(Contact {
        first,
        second,
        frame,
        bias: touch.closing * Vector3::x() - given,
        friction: touch.friction.limit_curve()?,
        adhesion: 0.0,
        compliance: 0.0,
    })
}
