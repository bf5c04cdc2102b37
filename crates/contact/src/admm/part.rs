//! What one thread does at a time: some bodies, and some contacts, which need not be between them.

use super::alone::{Act, Alone};
use super::anderson::{self, Onward, Products, Turn};
use super::crew::Lead;
use super::descent::Step;
use super::shared::Shared;
use super::sides::Sides;
use super::wide::{Group, WIDTH};
use crate::residual::Sums;
use crate::{Body, Contact, ContactError, Report};
use nalgebra::Vector3;
use pulp::Arch;
use std::ops::Range;

/// What all parts see.
pub(super) struct Common<'a> {
    pub(super) contacts: &'a [Contact],
    pub(super) sides: &'a Sides,
    /// Velocities of the points with the impulses that were given.
    pub(super) base: &'a [Vector3<f64>],
    /// Metric of every side at a point, kg.
    pub(super) masses: &'a [f64],
    /// Traces of the points' answers to impulses on themselves, 1/kg.
    pub(super) traces: &'a [f64],
    /// Whether most points are in a crowd.
    pub(super) crowded: bool,
    /// By which the metric was chosen.
    pub(super) weight: f64,
    pub(super) relaxation: f64,
    /// State, by side.
    pub(super) h: Shared,
    /// Impulses on the first points of contacts, world.
    pub(super) impulses: Shared,
    /// Velocities of points, where they are looked at.
    pub(super) v: Shared,
}

/// What all parts are to do.
pub(super) enum Order {
    /// Adds the metric to the bodies, and begins where the contacts' impulses cause the velocities that have been told.
    SetOut,
    /// Solves every contact by itself, and notes the velocities it wants if these are looked at.
    Obey { looked_at: bool },
    /// Lets the bodies answer.
    Respond { sets_out: bool, turn: Turn, looked_at: bool },
    /// Finds the next state.
    Onward(Onward),
    /// Finds how far what the contacts want is from what the bodies do.
    Compare,
    /// Finds the velocities that the impulses really cause.
    Tell,
    /// Finds how far these are from the law.
    Judge,
    /// Does a step of the descent.
    Descent(Step),
}

/// Some bodies and some contacts.
pub(super) struct Part<'a, 'b> {
    bodies: &'a mut [&'b mut dyn Body],
    points: Range<usize>,
    /// Impulses that act in the given velocities, those to answer, and the answers, by point.
    given: Vec<Vector3<f64>>,
    asked: Vec<Vector3<f64>>,
    answer: Vec<Vector3<f64>>,
    /// Roots of the metric, by side.
    roots: Vec<f64>,
    /// State at the start of a step of the splitting, by side, and what is remembered of steps.
    start: Vec<Vector3<f64>>,
    steps: &'a mut anderson::Part,
    pub(super) descents: &'a mut anderson::Part,
    pub(super) products: Products,
    pub(super) contacts: Range<usize>,
    /// In the frames of the contacts.
    pub(super) impulses: &'a mut [Vector3<f64>],
    pub(super) groups: Vec<Group>,
    /// Roots of the answers of the contacts to their own impulses in the metric, 1/kg.
    pub(super) response_roots: Vec<f64>,
    /// Relative velocities that the contacts want.
    pub(super) wanted: Vec<Vector3<f64>>,
    pub(super) sums: Sums,
    /// Why a body does not take the metric.
    pub(super) refused: Option<ContactError>,
}

impl<'a, 'b> Part<'a, 'b> {
    /// The bodies are those of the `points`, the impulses those of the `contacts`.
    pub(super) fn new(
        common: &Common,
        (bodies, points): (&'a mut [&'b mut dyn Body], Range<usize>),
        (impulses, contacts): (&'a mut [Vector3<f64>], Range<usize>),
        [steps, descents]: [&'a mut anderson::Part; 2],
    ) -> Self {
        let Common { sides, masses, .. } = common;
        let given = |point: usize| sides.at(point).map(|side| common.impulse(side)).sum();
        let root = |point: usize| std::iter::repeat_n(masses[point].sqrt(), sides.at(point).len());
        let zeros = vec![Vector3::zeros(); points.len()];
        let responses: Vec<f64> =
            common.contacts[contacts.clone()].iter().map(|c| common.response(c)).collect();
        let group = |start: usize| {
            let part = start..contacts.end.min(start + WIDTH);
            let own = &common.contacts[part.clone()];
            let (mut at_points, mut at_sides) = ([[0; WIDTH]; 2], [[0; WIDTH]; 2]);
            for (lane, (contact, sides)) in own.iter().zip(sides.of_contacts(&part)).enumerate() {
                let points = [contact.first, contact.second.unwrap_or(masses.len())];
                for side in 0..2 {
                    at_points[side][lane] = index(points[side]);
                    at_sides[side][lane] = sides[side];
                }
            }
            let responses = &responses[start - contacts.start..];
            let weights = own.iter().map(|contact| common.weight_of(contact));
            Group::new(own, responses, weights, [at_points, at_sides])
        };
        Self {
            groups: contacts.clone().step_by(WIDTH).map(group).collect(),
            given: points.clone().map(given).collect(),
            asked: zeros.clone(),
            answer: zeros,
            roots: points.clone().flat_map(root).collect(),
            products: Products::default(),
            response_roots: responses.iter().map(|response| response.sqrt()).collect(),
            wanted: vec![Vector3::zeros(); contacts.len()],
            sums: Sums::default(),
            refused: None,
            start: Vec::new(),
            bodies,
            points,
            steps,
            descents,
            contacts,
            impulses,
        }
    }

    pub(super) fn act(&mut self, order: &Order, common: &Common) {
        match order {
            Order::SetOut => self.set_out(common),
            Order::Obey { looked_at } => self.alone(common, Act::Obey { looked_at: *looked_at }),
            Order::Respond { sets_out, turn, looked_at } => {
                self.respond(common, *sets_out, *turn, *looked_at);
            }
            Order::Onward(onward) => self.go_on(common, onward),
            Order::Compare => self.alone(common, Act::Compare),
            Order::Tell => self.tell(common),
            Order::Judge => self.alone(common, Act::Judge),
            Order::Descent(step) => self.descent(common, step),
        }
    }

    fn set_out(&mut self, common: &Common) {
        let weight = |point: usize| common.masses[point] * common.sides.at(point).len() as f64;
        let weights: Vec<f64> = self.points.clone().map(weight).collect();
        let mut rest = &weights[..];
        for body in &mut *self.bodies {
            let (own, behind) = rest.split_at(body.points());
            rest = behind;
            if let Err(error) = body.set_weights(own) {
                self.refused.get_or_insert(error);
            }
        }
        for point in self.points.clone() {
            let (v, lightness) = (common.v.get(point), 1.0 / common.masses[point]);
            for side in common.sides.at(point) {
                common.h.set(side, &(v - common.impulse(side) * lightness));
            }
        }
    }

    /// Lets the bodies move as near to `2 z - h` as they can.
    fn respond(&mut self, common: &Common, sets_out: bool, turn: Turn, looked_at: bool) {
        let Common { sides, base, masses, h, .. } = common;
        for ((point, asked), given) in self.points.clone().zip(&mut self.asked).zip(&self.given) {
            *asked = -given;
            for side in sides.at(point) {
                *asked += (h.get(side) - base[point]) * masses[point] + common.impulse(side) * 2.0;
            }
        }
        self.answer(|body, asked, answer| body.weighted_respond(asked, answer));
        if sets_out {
            self.start.clear();
        }
        let looks = matches!(turn, Turn::Look(_));
        if looks {
            self.steps.image().clear();
        }
        for (point, answer) in self.points.clone().zip(&self.answer) {
            let v = base[point] + answer;
            let lightness = 1.0 / masses[point];
            for side in sides.at(point) {
                let before = h.get(side);
                let z = before + common.impulse(side) * lightness;
                let next = before + (v - z) * common.relaxation;
                if sets_out {
                    self.start.push(before);
                }
                if looks {
                    self.steps.image().extend_from_slice(next.as_slice());
                } else {
                    h.set(side, &next);
                }
            }
            if looked_at {
                common.v.set(point, &v);
            }
        }
        if let Turn::Look(place) = turn {
            self.products = self.steps.look(&self.start, place, &self.roots);
        }
    }

    fn go_on(&mut self, common: &Common, onward: &Onward) {
        let state = self.steps.onward(onward).as_chunks::<3>().0;
        for (side, next) in common.sides.of(&self.points).zip(state) {
            common.h.set(side, &(*next).into());
        }
    }

    fn tell(&mut self, common: &Common) {
        for ((point, asked), given) in self.points.clone().zip(&mut self.asked).zip(&self.given) {
            *asked = -given;
            common.sides.at(point).for_each(|side| *asked += common.impulse(side));
        }
        self.answer(|body, asked, answer| body.respond(asked, answer));
        for (point, answer) in self.points.clone().zip(&self.answer) {
            common.v.set(point, &(common.base[point] + answer));
        }
    }

    /// Has every contact do something by itself.
    pub(super) fn alone(&mut self, common: &Common, act: Act) {
        Arch::new().dispatch(Alone { part: self, common, act });
    }

    /// Lets all bodies answer what is asked.
    fn answer(&mut self, how: impl Fn(&mut dyn Body, &[Vector3<f64>], &mut [Vector3<f64>])) {
        let (mut asked, mut answer) = (&self.asked[..], &mut self.answer[..]);
        for body in &mut *self.bodies {
            let points = body.points();
            let (own, rest) = std::mem::take(&mut answer).split_at_mut(points);
            how(&mut **body, &asked[..points], own);
            (asked, answer) = (&asked[points..], rest);
        }
    }
}

/// How far the velocities that have been told are from the law.
pub(super) fn judge<'a, 'b, A>(lead: &Lead<'_, '_, Part<'a, 'b>, Order, A>) -> Report
where
    A: Fn(&Order, &mut Part<'a, 'b>) + Sync,
{
    lead.order(Order::Judge);
    together(lead)
}

/// What all parts have found, together.
pub(super) fn together<'a, 'b, A>(lead: &Lead<'_, '_, Part<'a, 'b>, Order, A>) -> Report
where
    A: Fn(&Order, &mut Part<'a, 'b>) + Sync,
{
    let mut parts = Vec::new();
    lead.each(|part| parts.push(part.sums));
    Sums::together(&parts).report()
}

impl Common<'_> {
    /// The impulse of a side on its point.
    #[inline]
    fn impulse(&self, side: usize) -> Vector3<f64> {
        let (contact, sign) = self.sides.contact(side);
        self.impulses.get(contact) * sign
    }

    /// The mass, kg, with which a report compares what is wrong with impulses and with velocities. In a crowd that
    /// is the contact's own, as for [`crate::Violation`]: in the metric, which is up to eight times as heavy, small
    /// errors of velocities would be large ones of impulses, and a tolerance out of reach. Elsewhere it is that of
    /// the metric, and contacts are right to some digits more, by which the energies of rods close.
    fn weight_of(&self, contact: &Contact) -> f64 {
        if !self.crowded {
            return 1.0 / self.response(contact);
        }
        let of = |point: usize| self.traces[point];
        let trace = of(contact.first) + contact.second.map_or(0.0, of);
        // What nothing moves has no inertia to compare with.
        if trace > 0.0 { 3.0 / trace } else { 1.0 }
    }

    /// Answer of a contact to its own impulse in the metric, 1/kg.
    fn response(&self, contact: &Contact) -> f64 {
        let &Contact { first, second, .. } = contact;
        1.0 / self.masses[first] + second.map_or(0.0, |point| 1.0 / self.masses[point])
    }
}

#[expect(clippy::cast_possible_truncation, reason = "so many points fit nowhere")]
fn index(point: usize) -> u32 {
    point as u32
}
