use super::group::ProjectionGroup;
use super::{Differences, Form, Partner, Touch, friction, normal};
use crate::{ContactError, RigidBody};
use nalgebra::{Vector3, Vector6};
use rayon::prelude::*;

/// Replaces the velocities of `bodies` by those after the impacts `touches`, lines 5 to 10 of
/// Alg. 6, with the coefficient of `restitution` (0 to 1).
///
/// With `Differences::scope` corrected all touched bodies are one dense convex program, whose cost
/// grows with the cube of the number of contacts and faster; as printed every body has its own, and
/// all are solved in parallel from the velocities before.
///
/// # Errors
/// [`ContactError::Contact`] for contacts that make no sense, [`ContactError::Invalid`] for the
/// restitution, [`ContactError::Program`] where a convex program is not solved. The bodies are then
/// as before.
pub fn project(
    bodies: &mut [RigidBody],
    touches: &[Touch],
    restitution: f64,
    form: &Differences,
) -> Result<(), ContactError> {
    if !(0.0..=1.0).contains(&restitution) {
        let why = "must be between 0 and 1";
        return Err(ContactError::Invalid { what: "restitution", value: restitution, why });
    }
    let mut on_body: Vec<Vec<usize>> = vec![Vec::new(); bodies.len()];
    for (index, touch) in touches.iter().enumerate() {
        touch.check(index, bodies.len())?;
        on_body[touch.body].push(index);
        if let Partner::Body(other) = touch.partner {
            on_body[other].push(index);
        }
    }
    let touched: Vec<usize> = (0..bodies.len()).filter(|&b| !on_body[b].is_empty()).collect();
    let solve = |members: Vec<usize>, indices: &mut dyn Iterator<Item = usize>| {
        let touches = indices.map(|i| (i, &touches[i]));
        let group = ProjectionGroup::new(bodies, touches, members, form)?;
        let after = respond(&group, bodies, restitution, form)?;
        Ok(group.members.into_iter().zip(after).collect::<Vec<_>>())
    };
    let after: Vec<Vec<(usize, Vector6<f64>)>> = match form.scope {
        Form::AsPrinted => touched
            .into_par_iter()
            .map(|body| solve(vec![body], &mut on_body[body].iter().copied()))
            .collect::<Result<_, ContactError>>()?,
        Form::Corrected => vec![solve(touched, &mut (0..touches.len()))?],
    };
    for (body, twist) in after.into_iter().flatten() {
        bodies[body].set_twist(&twist);
    }
    Ok(())
}

fn respond(
    group: &ProjectionGroup<'_>,
    bodies: &[RigidBody],
    restitution: f64,
    form: &Differences,
) -> Result<Vec<Vector6<f64>>, ContactError> {
    let before: Vec<Vector6<f64>> =
        group.members.iter().map(|&body| bodies[body].twist()).collect();
    let normal = normal::project(group, &before, restitution, form)?;
    let sign = if form.restitution.is_corrected() { -1.0 } else { 1.0 };
    let bouncing: Vec<Vector6<f64>> = normal
        .twists
        .iter()
        .zip(&before)
        .map(|(plus, minus)| (1.0 + restitution) * plus + sign * restitution * minus)
        .collect();
    let change = friction::project(group, &normal.twists, &bouncing, &normal.impulses, form)?;
    Ok(bouncing.iter().zip(&change).map(|(u, du)| u + du).collect())
}

/// One step of Alg. 6: half a step of positions, the contacts there, all of the step's forces, the
/// projections, the second half of the positions.
///
/// `loads` are a force (N) and a moment about the center of mass (N m) for every body, world;
/// `contacts` is asked for the contacts of the bodies as they are half way. Forces are taken as
/// constant over the step, so that theta of (8.39) to (8.43), printed at the wrong ends, is of no
/// effect.
///
/// # Errors
/// [`ContactError`] where [`project`] fails or `contacts` does, and [`ContactError::Length`] for
/// loads that do not fit.
pub fn moreau_step(
    bodies: &mut [RigidBody],
    loads: &[Vector6<f64>],
    contacts: impl FnOnce(&[RigidBody]) -> Result<Vec<Touch>, ContactError>,
    dt: f64,
    restitution: f64,
    form: &Differences,
) -> Result<(), ContactError> {
    if loads.len() != bodies.len() {
        let (expected, found) = (bodies.len(), loads.len());
        return Err(ContactError::Length { what: "loads of bodies", expected, found });
    }
    for body in bodies.iter_mut() {
        half_step(body, 0.5 * dt, form.gyroscopic)?;
    }
    let touches = contacts(bodies)?;
    let mut share = vec![1.0; bodies.len()];
    if form.force == Form::AsPrinted {
        for touch in &touches {
            share[touch.body] = 0.5;
            if let Partner::Body(other) = touch.partner {
                share[other] = 0.5;
            }
        }
    }
    for ((body, load), share) in bodies.iter_mut().zip(loads).zip(share) {
        body.apply_wrench(&(share * dt * load));
    }
    project(bodies, &touches, restitution, form)?;
    for body in bodies.iter_mut() {
        half_step(body, 0.5 * dt, form.gyroscopic)?;
    }
    Ok(())
}

fn half_step(body: &mut RigidBody, dt: f64, gyroscopic: Form) -> Result<(), ContactError> {
    match gyroscopic {
        Form::Corrected => body.step(&Vector3::zeros(), &Vector3::zeros(), dt),
        Form::AsPrinted => {
            let twist = body.twist();
            body.drift(&body.velocity.clone(), &body.angular_velocity(), dt);
            body.set_twist(&twist);
            Ok(())
        }
    }
}
