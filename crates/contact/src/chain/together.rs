use crate::projection::{Partner, Touch};
use crate::solver::on_points;
use crate::{
    Body, Contact, ContactError, GaussSeidel, Report, RigidBody, RigidPoints, Tolerance, impact,
};
use nalgebra::{Matrix3, Point3, Vector3};

/// Replaces the velocities of `bodies` by those after the impacts `touches`, all of them together: the
/// law of contacts to `tolerance`, by [`GaussSeidel`], with the restitution of [`impact`].
pub(super) fn collide(
    bodies: &mut [RigidBody],
    touches: &[Touch],
    restitution: f64,
    tolerance: Tolerance,
) -> Result<Report, ContactError> {
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
        .map(|(index, (touch, (first, second)))| contact(index, touch, at(*first), second.map(at)))
        .collect::<Result<_, ContactError>>()?;
    let velocities: Vec<Vector3<f64>> = bodies
        .iter()
        .zip(&on_body)
        .flat_map(|(body, points)| points.iter().map(|point| body.velocity_at(point)))
        .collect();
    let mut seen: Vec<&mut dyn Body> = points.iter_mut().map(|points| points as _).collect();
    let shares = vec![restitution; contacts.len()];
    let found =
        impact(&mut seen, &contacts, &shares, &velocities, &mut GaussSeidel::new(tolerance))?;
    let on_points = on_points(&contacts, &found.impulses, velocities.len());
    for ((body, points), start) in bodies.iter_mut().zip(&points).zip(&starts) {
        body.apply_wrench(&points.wrench(&on_points[*start..][..points.points()]));
    }
    Ok(found.report)
}

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
