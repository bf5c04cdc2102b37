use super::contacts::{SegmentContact, parting, resolve};
use super::joints::{JointSums, Joints};
use super::link::ChainLink;
use super::{ChainForm, CylinderChain, JointMethod, half_way};
use crate::thesis::Response;
use crate::thesis::projection::Form;
use crate::{ContactError, Report, RigidBody, closing};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rayon::prelude::*;

/// Order of the projections in Alg. 7.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LastWord {
    /// Joints, then contacts: contacts hold, joints open a little (the thesis's choice, 8.6.5.3).
    #[default]
    JointsFirst,
    /// Contacts, then joints: joints hold, lying fibers sag through each other.
    ContactsFirst,
}

/// Settings of [`step`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Length of the step, s.
    pub dt: f64,
    /// Acceleration of gravity, world, m/s^2.
    pub gravity: Vector3<f64>,
    /// Method by which joints are closed.
    pub method: JointMethod,
    /// Order of the projections.
    pub order: LastWord,
    /// Number of times that both projections are done, at least 1; the thesis does 1 to 3.
    pub harmonizations: usize,
    /// Coefficient of restitution, 0 to 1; see [`ChainForm::rebound`].
    pub restitution: f64,
    /// Text that the chains follow.
    pub form: ChainForm,
}

/// Result of a [`step`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HarmonizationReport {
    /// Most linear solves that a chain's joints needed at once.
    pub iterations: usize,
    /// Widest gap of a joint after the step, m.
    pub widest_gap: f64,
    /// Report of the last solution of the contacts; `None` where there is none.
    pub contacts: Option<Report>,
}

/// Impulses on the segments of one chain in a step.
struct ChainImpulses {
    /// Angular impulses of the springs, by segment, N m s, world.
    springs: Vec<Vector3<f64>>,
    /// Impulses of the joints, by segment.
    joints: JointSums,
    /// Impulses of the contacts, by segment.
    contacts: JointSums,
}

/// One step of all `chains`: Alg. 7 with the contacts given, which the segments answer by
/// `response`. Parallel over the chains, and over the touched segments where these are projected by
/// themselves; the result does not depend on the number of threads. Costs O(segments) but for the
/// contacts.
///
/// # Errors
/// [`ContactError::Joint`] where a chain's joints cannot be closed (turns of a radian and more in a
/// step), [`ContactError::Invalid`] for the step's length and the restitution, and the errors of
/// [`Response::collide`]. The chains are then as before.
pub fn step(
    chains: &mut [CylinderChain],
    contacts: &[SegmentContact],
    settings: &Settings,
    response: &mut dyn Response,
) -> Result<HarmonizationReport, ContactError> {
    let dt = settings.dt;
    if !(dt > 0.0 && dt.is_finite()) {
        let why = "must be > 0 s";
        return Err(ContactError::Invalid { what: "length of a step", value: dt, why });
    }
    if !(0.0..=1.0).contains(&settings.restitution) {
        let (why, value) = ("must be between 0 and 1", settings.restitution);
        return Err(ContactError::Invalid { what: "restitution", value, why });
    }
    let mut acting: Vec<ChainImpulses> = chains
        .iter()
        .map(|chain| {
            let none = vec![[Vector3::zeros(); 2]; chain.segments.len()];
            let springs = chain.spring_impulses(dt, &settings.form);
            ChainImpulses { springs, joints: none.clone(), contacts: none }
        })
        .collect();
    let (mut iterations, mut report) = (0, None);
    for _ in 0..settings.harmonizations.max(1) {
        if settings.order == LastWord::JointsFirst {
            iterations = iterations.max(close_joints(chains, &mut acting, settings)?);
            report = meet_contacts(chains, &mut acting, contacts, settings, response)?;
        } else {
            report = meet_contacts(chains, &mut acting, contacts, settings, response)?;
            iterations = iterations.max(close_joints(chains, &mut acting, settings)?);
        }
    }
    let gaps: Vec<f64> = chains
        .par_iter_mut()
        .zip(&acting)
        .map(|(chain, acting)| {
            integrate(chain, acting, settings);
            chain.widest_gap().0
        })
        .collect();
    let widest_gap = gaps.into_iter().fold(0.0, f64::max);
    Ok(HarmonizationReport { iterations, widest_gap, contacts: report })
}

fn links(chain: &CylinderChain, acting: &ChainImpulses, settings: &Settings) -> Vec<ChainLink> {
    let link = |(i, segment): (usize, &RigidBody)| {
        let force = segment.mass() * settings.gravity;
        let (half, springs) = (chain.half_lengths[i], &acting.springs[i]);
        let contact = &acting.contacts[i];
        ChainLink::new(segment, half, &force, springs, contact, settings.dt, &settings.form)
    };
    chain.segments.iter().enumerate().map(link).collect()
}

fn close_joints(
    chains: &[CylinderChain],
    acting: &mut [ChainImpulses],
    settings: &Settings,
) -> Result<usize, ContactError> {
    let counts: Vec<usize> = chains
        .par_iter()
        .zip(acting)
        .enumerate()
        .map(|(index, (chain, acting))| {
            let links = links(chain, acting, settings);
            let mut joints = Joints::new(chain, links, settings.dt, &settings.form);
            let (sums, iterations) = joints.close(settings.method, index)?;
            acting.joints = sums;
            Ok(iterations)
        })
        .collect::<Result<_, ContactError>>()?;
    Ok(counts.into_iter().max().unwrap_or(0))
}

fn meet_contacts(
    chains: &[CylinderChain],
    acting: &mut [ChainImpulses],
    contacts: &[SegmentContact],
    settings: &Settings,
    response: &mut dyn Response,
) -> Result<Option<Report>, ContactError> {
    let (dt, form) = (settings.dt, &settings.form);
    let whole = form.contact_time.is_corrected();
    let ahead = |chain: usize, i: usize| {
        let (segment, acting) = (&chains[chain].segments[i], &acting[chain]);
        let [linear, angular] = acting.joints[i];
        let (mut body, force) =
            if whole { (segment.clone(), 0.5 * dt) } else { (half_way(segment, dt), dt) };
        body.velocity += force * settings.gravity + linear / body.mass();
        body.angular_momentum += angular + acting.springs[i];
        body
    };
    let time = if whole { dt } else { 0.5 * dt };
    let fall = settings.gravity.norm() * dt;
    // Restitution of the velocity at the start, and of the velocity that the response finds.
    let [first, found] = match form.rebound {
        Form::Corrected => [settings.restitution, 0.0],
        Form::AsPrinted => [0.0, settings.restitution],
    };
    let may_close = |contact: &SegmentContact| {
        closing(contact.gap.max(0.0) / time, first, fall, || parting(chains, contact))
    };
    let (changes, report) = resolve(chains, contacts, may_close, found, response, ahead)?;
    for change in changes {
        acting[change.chain].contacts[change.segment] = [change.linear, change.angular];
    }
    Ok(report)
}

fn integrate(chain: &mut CylinderChain, acting: &ChainImpulses, settings: &Settings) {
    let links = links(chain, acting, settings);
    let printed = !settings.form.curvature.is_corrected();
    let before = printed.then(|| chain.segments.clone());
    for (i, (segment, mut link)) in chain.segments.iter_mut().zip(links).enumerate() {
        let ([linear, angular], [c, c_angular]) = (acting.joints[i], acting.contacts[i]);
        let (omega, inverse) = (segment.angular_velocity(), segment.inverse_inertia());
        link.move_on(&linear, &angular);
        let (turn, spin) = link.step_turn(&angular);
        let spin = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), spin);
        let turn = UnitQuaternion::from_scaled_axis(turn);
        segment.pose.rotation = turn * segment.pose.rotation * spin;
        segment.pose.rotation.renormalize();
        segment.pose.translation = Translation3::from(link.center);
        segment.velocity += settings.dt * settings.gravity + (linear + c) / link.mass;
        let gained = angular + c_angular + acting.springs[i];
        if settings.form.gyroscopic.is_corrected() {
            segment.angular_momentum += gained;
        } else {
            segment.set_angular_velocity(&(omega + inverse * gained));
        }
    }
    if let Some(before) = before {
        chain.print_curvatures(&before, settings.dt);
    }
}
