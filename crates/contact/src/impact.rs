use crate::gauss_seidel::Delassus;
use crate::{Body, Contact, ContactError, GaussSeidel, Report, solve_contact};
use nalgebra::Vector3;

/// What happens when several contacts are struck at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImpactLaw {
    /// Moreau: all contacts act together, once. Every contact that approached leaves, if it acts at
    /// all, with its restitution's share of the velocity of approach.
    Together,
    /// One contact after the other, always the one that approaches fastest, until none does.
    InTurn,
}

/// What an impact did.
#[derive(Debug, Clone, PartialEq)]
pub struct Impact {
    /// Impulse of every contact in its frame, N s.
    pub impulses: Vec<Vector3<f64>>,
    /// Change of the kinetic energy, J, not positive: as seen by what is not moved, where the bias
    /// of a contact is its velocity.
    pub energy: f64,
    /// The least share of its restitution that a contact was left with, one if no energy would have
    /// been gained.
    pub share: f64,
    /// How well the contacts were solved: for [`ImpactLaw::Together`] that of the solver, for
    /// [`ImpactLaw::InTurn`] the number of impacts and whether they came to an end.
    pub report: Report,
}

/// Approach slower than this, relative to the fastest contact, is none.
const STILL: f64 = 1e-12;

/// Energy less than this, relative to the work against the approach, is rounding.
const ROUNDING: f64 = 1e-14;

/// Lets bodies collide: Newton's law of restitution with Coulomb friction, without gain of energy.
///
/// `restitution` is the coefficient of every contact, from zero to one; `velocities` are those of
/// all points before. Friction is within the limit of the whole normal impulse, compression and
/// restitution together (thesis (8.30) with its erratum), and works against the slip afterwards.
///
/// Newton's law with friction can gain energy (Kane and Levinson 1985). The impact without
/// restitution cannot; where the one with it would, the two are mixed just so that no energy is
/// gained. The mixture is within the friction cones and leaves no contact approaching. Impulses of a
/// search that ends before its tolerance are cut down to gain no energy either.
///
/// # Errors
/// As [`crate::Solver::solve`]; [`ContactError::Invalid`] for a restitution outside of [0, 1].
pub fn impact(
    bodies: &mut [&mut dyn Body],
    contacts: &[Contact],
    restitution: &[f64],
    velocities: &[Vector3<f64>],
    law: ImpactLaw,
    solver: &GaussSeidel,
) -> Result<Impact, ContactError> {
    if restitution.len() != contacts.len() {
        return Err(ContactError::Length {
            what: "coefficients of restitution",
            expected: contacts.len(),
            found: restitution.len(),
        });
    }
    if let Some(&value) = restitution.iter().find(|e| !(0.0..=1.0).contains(*e)) {
        return Err(ContactError::Invalid {
            what: "coefficient of restitution",
            value,
            why: "it must be between zero and one",
        });
    }
    solver.validate()?;
    let mut delassus = Delassus::new(bodies, contacts, velocities)?;
    Ok(match law {
        ImpactLaw::Together => together(&mut delassus, contacts, restitution, solver),
        ImpactLaw::InTurn => in_turn(&mut delassus, contacts, restitution, solver),
    })
}

fn together(
    delassus: &mut Delassus,
    contacts: &[Contact],
    restitution: &[f64],
    solver: &GaussSeidel,
) -> Impact {
    let before: Vec<_> = contacts.iter().map(|c| delassus.relative_velocity(c)).collect();
    let mut returning = contacts.to_vec();
    for ((contact, u), e) in returning.iter_mut().zip(&before).zip(restitution) {
        contact.bias.x += e * u.x.min(0.0);
    }
    let mut impulses = vec![Vector3::zeros(); contacts.len()];
    let report = solver.sweep(delassus, &returning, &mut impulses);
    let after: Vec<_> = contacts.iter().map(|c| delassus.relative_velocity(c)).collect();
    let energy = work(&impulses, &before, &after);
    if energy <= ROUNDING * -dot(&impulses, &before) {
        return Impact { impulses, energy, share: 1.0, report };
    }
    let mut plastic = impulses.clone();
    let report = solver.sweep(delassus, contacts, &mut plastic);
    let rest: Vec<_> = contacts.iter().map(|c| delassus.relative_velocity(c)).collect();
    let loss = work(&plastic, &before, &rest);
    if loss > 0.0 {
        // Only a search that ended early gains energy here: as much of it as gains none.
        let change: Vec<_> = std::iter::zip(&rest, &before).map(|(a, b)| a - b).collect();
        let scale = (-2.0 * dot(&plastic, &before) / dot(&plastic, &change)).clamp(0.0, 1.0);
        let impulses = plastic.iter().map(|r| r * scale).collect();
        return Impact { impulses, energy: 0.0, share: 0.0, report };
    }
    let extra: Vec<_> = std::iter::zip(&impulses, &plastic).map(|(a, b)| a - b).collect();
    let response: Vec<_> = std::iter::zip(&after, &rest).map(|(a, b)| a - b).collect();
    let share = largest_share(loss, energy, 0.5 * dot(&extra, &response));
    let impulses = std::iter::zip(&plastic, &extra).map(|(p, d)| p + d * share).collect();
    Impact { impulses, energy: if share > 0.0 { 0.0 } else { loss }, share, report }
}

fn in_turn(
    delassus: &mut Delassus,
    contacts: &[Contact],
    restitution: &[f64],
    solver: &GaussSeidel,
) -> Impact {
    let speed = contacts.iter().map(|c| delassus.relative_velocity(c).norm()).fold(0.0, f64::max);
    let mut impulses = vec![Vector3::zeros(); contacts.len()];
    let (mut energy, mut least, mut report) = (0.0, 1.0_f64, Report::default());
    while report.iterations < solver.sweeps * contacts.len() {
        let mut fastest = (0, -STILL * speed);
        for (i, contact) in contacts.iter().enumerate() {
            let normal = delassus.relative_velocity(contact).x;
            if normal < fastest.1 {
                fastest = (i, normal);
            }
        }
        let (i, approach) = fastest;
        report.normal_error = approach.abs();
        report.converged = approach == -STILL * speed;
        if report.converged {
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
        if change > ROUNDING * -impulse.dot(&before) {
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
    Impact { impulses, energy, share: least, report }
}

/// Work of impulses that change the contacts' velocities from `before` to `after`.
fn work(impulses: &[Vector3<f64>], before: &[Vector3<f64>], after: &[Vector3<f64>]) -> f64 {
    0.5 * (dot(impulses, before) + dot(impulses, after))
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    std::iter::zip(a, b).map(|(a, b)| a.dot(b)).sum()
}

/// The largest share at which `loss + share b + share^2 curvature`, which is `gain > 0` at one, is
/// not positive.
fn largest_share(loss: f64, gain: f64, curvature: f64) -> f64 {
    let slope = gain - loss - curvature;
    let root = (slope * slope - 4.0 * curvature * loss).max(0.0).sqrt();
    let share =
        if slope > 0.0 { -2.0 * loss / (slope + root) } else { (root - slope) / (2.0 * curvature) };
    share.clamp(0.0, 1.0)
}
