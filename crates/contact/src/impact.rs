use crate::gauss_seidel::Delassus;
use crate::solver::respond;
use crate::{Body, Contact, ContactError, Report, Solver, solve_contact};
use nalgebra::Vector3;

/// Result of an impact.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactReport {
    /// Impulses by contact, N s, in the contacts' frames.
    pub impulses: Vec<Vector3<f64>>,
    /// Velocities of all points afterwards, m/s, world.
    pub velocities: Vec<Vector3<f64>>,
    /// Change of the kinetic energy, J, not positive: as seen by what is not moved, where the bias
    /// of a contact is its velocity.
    pub energy: f64,
    /// Least share of the restitution that a contact was left with, one if no energy would have
    /// been gained.
    pub share: f64,
    /// Report of the solver on how well the contacts were solved, or the number of single impacts
    /// and whether they came to an end.
    pub report: Report,
}

/// Speed at which a contact may close in a step, m/s: minus the least normal velocity, and a
/// contact's [bias](Contact::bias) along its normal. `gap` is the gap at the start over the length
/// of the step, m/s, `before` returns the normal velocity at the start, m/s, `fall` is what gravity
/// adds to a velocity in the step, m/s.
///
/// A contact that would close returns with its share, if there is a `restitution`, of the velocity
/// of approach (Newton). Whether it would is told by the start of the step, with what gravity may
/// add, so that it neither depends on the search nor is a fall stopped at the surface before it
/// bounces. What comes no faster than gravity drives it in two steps is at rest, and stays so.
pub fn closing(gap: f64, restitution: f64, fall: f64, before: impl FnOnce() -> f64) -> f64 {
    if restitution <= 0.0 {
        return gap;
    }
    let before = before();
    let bounces = before < -2.0 * fall && gap + before < fall;
    if bounces { gap.min(restitution * before) } else { gap }
}

/// Approach slower than this, relative to the fastest contact, is none.
const STILL: f64 = 1e-12;

/// Energy less than this, relative to the work against the approach, is rounding.
const ENERGY_ROUNDING: f64 = 1e-14;

/// Lets bodies collide, all contacts together (Moreau): Newton's law of restitution with Coulomb
/// friction, without gain of energy.
///
/// Every contact that approached leaves, if it acts at all, with its `restitution`'s share (from
/// zero to one) of the velocity of approach. `velocities` are those of all points before. Friction
/// is within the limit of the whole normal impulse, compression and restitution together (thesis
/// (8.30) with its erratum), and works against the slip afterwards.
///
/// Newton's law with friction can gain energy (Kane and Levinson 1985). The impact without
/// restitution cannot; where the one with it would, the two are mixed just so that no energy is
/// gained. The mixture is within the friction cones and leaves no contact approaching. Impulses of
/// a search that ends before its tolerance are cut down to gain no energy either.
///
/// Costs one solution, two where energy would be gained. Takes away weights of the bodies.
///
/// # Errors
/// [`ContactError`] where [`Solver::solve`] fails, and [`ContactError::Invalid`] for a restitution
/// outside of [0, 1].
pub fn impact(
    bodies: &mut [&mut dyn Body],
    contacts: &[Contact],
    restitution: &[f64],
    velocities: &[Vector3<f64>],
    solver: &mut dyn Solver,
) -> Result<ImpactReport, ContactError> {
    validate(bodies, contacts, restitution, velocities)?;
    // Newton's law of restitution as a bias along the normal.
    let before = relative(contacts, velocities);
    let mut returning = contacts.to_vec();
    for ((contact, u), e) in returning.iter_mut().zip(&before).zip(restitution) {
        contact.bias.x += e * u.x.min(0.0);
    }
    let mut impulses = vec![Vector3::zeros(); contacts.len()];
    let report = solver.solve(bodies, &returning, velocities, &mut impulses)?;
    let struck = respond(bodies, contacts, velocities, &impulses);
    let after = relative(contacts, &struck);
    let energy = work(&impulses, &before, &after);
    if energy <= ENERGY_ROUNDING * -dot(&impulses, &before) {
        return Ok(ImpactReport { impulses, velocities: struck, energy, share: 1.0, report });
    }
    // The impact without restitution, which cannot gain energy.
    let mut plastic = impulses.clone();
    let report = solver.solve(bodies, contacts, &struck, &mut plastic)?;
    let settled = respond(bodies, contacts, velocities, &plastic);
    let rest = relative(contacts, &settled);
    let loss = work(&plastic, &before, &rest);
    let unsure = rounding(bodies, contacts, &plastic);
    if loss + unsure > 0.0 {
        // Only a search that ended early gains energy here: as much of it as gains none.
        let change = mixed(&before, &rest, 1.0, -1.0);
        let curvature = unsure - 0.5 * dot(&plastic, &change);
        let scale = (-dot(&plastic, &before) / curvature).clamp(0.0, 1.0);
        return Ok(ImpactReport {
            impulses: plastic.iter().map(|r| r * scale).collect(),
            velocities: mixed(velocities, &settled, 1.0 - scale, scale),
            energy: -unsure * scale * scale,
            share: 0.0,
            report,
        });
    }
    // The mixture of the two that gains none.
    let extra = mixed(&impulses, &plastic, 1.0, -1.0);
    let response = mixed(&after, &rest, 1.0, -1.0);
    let unsure = unsure.max(rounding(bodies, contacts, &impulses));
    let curvature = 0.5 * dot(&extra, &response);
    let share = largest_share(loss + unsure, energy + unsure, curvature);
    Ok(ImpactReport {
        impulses: mixed(&impulses, &plastic, share, 1.0 - share),
        velocities: mixed(&struck, &settled, share, 1.0 - share),
        energy: if share > 0.0 { -unsure } else { loss },
        share,
        report,
    })
}

/// Lets bodies collide as [`impact`] does, but one contact after the other, always the one that
/// approaches fastest, until none does or there were `most` single impacts.
///
/// Setup grows with the square of the touched points of a body.
///
/// # Errors
/// [`ContactError`] where [`impact`] refuses its arguments.
pub fn impact_in_turn(
    bodies: &mut [&mut dyn Body],
    contacts: &[Contact],
    restitution: &[f64],
    velocities: &[Vector3<f64>],
    most: usize,
) -> Result<ImpactReport, ContactError> {
    validate(bodies, contacts, restitution, velocities)?;
    let mut delassus = Delassus::new(bodies, contacts, velocities)?;
    let speed = relative(contacts, velocities).iter().map(Vector3::norm).fold(0.0, f64::max);
    let mut impulses = vec![Vector3::zeros(); contacts.len()];
    let (mut energy, mut least, mut report) = (0.0, 1.0_f64, Report::default());
    loop {
        let approaches = contacts.iter().map(|c| delassus.relative_velocity(c).x).enumerate();
        let fastest = approaches.min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((i, approach)) = fastest.filter(|&(_, approach)| approach < -STILL * speed) else {
            report.converged = true;
            break;
        };
        if report.iterations == most {
            report.normal_error = approach.abs();
            break;
        }
        let contact = &contacts[i];
        let response = delassus.own_response(contact);
        let before = delassus.relative_velocity(contact);
        let solve = |e: f64| {
            let target = before + Vector3::new(e * approach, 0.0, 0.0);
            let impulse = solve_contact(contact, &response, &target);
            (impulse, impulse.dot(&(before + 0.5 * response * impulse)))
        };
        let (mut impulse, mut change) = solve(restitution[i]);
        if change > ENERGY_ROUNDING * -impulse.dot(&before) {
            let (plastic, loss) = solve(0.0);
            let extra = impulse - plastic;
            let share = largest_share(loss, change, 0.5 * extra.dot(&(response * extra)));
            (impulse, change) = (plastic + extra * share, if share > 0.0 { 0.0 } else { loss });
            least = least.min(share);
        }
        delassus.apply(contact, &impulse);
        impulses[i] += impulse;
        energy += change;
        report.iterations += 1;
    }
    let velocities = respond(bodies, contacts, velocities, &impulses);
    Ok(ImpactReport { impulses, velocities, energy, share: least, report })
}

/// Refuses arrays that do not fit and coefficients of restitution outside of [0, 1].
fn validate(
    bodies: &[&mut dyn Body],
    contacts: &[Contact],
    restitution: &[f64],
    velocities: &[Vector3<f64>],
) -> Result<(), ContactError> {
    let points = bodies.iter().map(|body| body.points()).sum();
    for (what, expected, found) in [
        ("coefficients of restitution", contacts.len(), restitution.len()),
        ("velocities of points", points, velocities.len()),
    ] {
        if expected != found {
            return Err(ContactError::Length { what, expected, found });
        }
    }
    if let Some(&value) = restitution.iter().find(|e| !(0.0..=1.0).contains(*e)) {
        return Err(ContactError::Invalid {
            what: "coefficient of restitution",
            value,
            why: "it must be between zero and one",
        });
    }
    contacts.iter().enumerate().try_for_each(|(i, contact)| contact.validate(i, points))
}

/// Relative velocities of the contacts, m/s, in their frames, bias included.
fn relative(contacts: &[Contact], velocities: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let of = |contact: &Contact| {
        let second = contact.second.map_or_else(Vector3::zeros, |i| velocities[i]);
        contact.frame.tr_mul(&(velocities[contact.first] - second)) + contact.bias
    };
    contacts.iter().map(of).collect()
}

/// Work, J, of impulses that change the contacts' velocities from `before` to `after`.
fn work(impulses: &[Vector3<f64>], before: &[Vector3<f64>], after: &[Vector3<f64>]) -> f64 {
    0.5 * (dot(impulses, before) + dot(impulses, after))
}

/// Sum of the products of all vectors.
fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    std::iter::zip(a, b).map(|(a, b)| a.dot(b)).sum()
}

/// Linear combination of vectors.
fn mixed(a: &[Vector3<f64>], b: &[Vector3<f64>], of_a: f64, of_b: f64) -> Vec<Vector3<f64>> {
    std::iter::zip(a, b).map(|(a, b)| a * of_a + b * of_b).collect()
}

/// Error that rounding may cause in the work of impulses, J: those that jam each other move their
/// points by little, which is the difference of what each does alone.
fn rounding(bodies: &mut [&mut dyn Body], contacts: &[Contact], impulses: &[Vector3<f64>]) -> f64 {
    let mut traces = Vec::new();
    for body in bodies {
        let start = traces.len();
        traces.resize(start + body.points(), 0.0);
        body.own_traces(&mut traces[start..]);
    }
    let of = |(contact, impulse): (&Contact, &Vector3<f64>)| {
        let trace = traces[contact.first] + contact.second.map_or(0.0, |second| traces[second]);
        trace * impulse.norm_squared()
    };
    f64::EPSILON * contacts.iter().zip(impulses).map(of).sum::<f64>()
}

/// Largest share at which `loss + share b + share^2 curvature`, which is `gain > 0` at one, is
/// not positive.
fn largest_share(loss: f64, gain: f64, curvature: f64) -> f64 {
    let slope = gain - loss - curvature;
    let root = (slope * slope - 4.0 * curvature * loss).max(0.0).sqrt();
    let share =
        if slope > 0.0 { -2.0 * loss / (slope + root) } else { (root - slope) / (2.0 * curvature) };
    share.clamp(0.0, 1.0)
}
