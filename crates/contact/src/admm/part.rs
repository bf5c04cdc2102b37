//! What one thread does at a time: some bodies, and some contacts, which need not be between them.

use super::alone::{Act, Alone};
use super::anderson::{self, Onward, Products, Turn};
use super::crew::Lead;
use super::descent::Step;
use super::shared::Shared;
use super::sides::Sides;
use super::wide::{Eight, Group};
use crate::residual::ResidualSums;
use crate::{Body, Contact, ContactError, Report};
use nalgebra::Vector3;
use pulp::Arch;
use rapunzel_lanes::LANES;
use std::ops::Range;
use std::sync::LazyLock;

/// What all parts see.
pub(super) struct Common<'a> {
    pub(super) contacts: &'a [Contact],
    pub(super) sides: &'a Sides,
    /// Velocities of the points with the impulses that were given.
    pub(super) velocities: &'a [Vector3<f64>],
    /// Metric of every side at a point, kg.
    pub(super) masses: &'a [f64],
    /// Traces of the points' answers to impulses on themselves, 1/kg.
    pub(super) traces: &'a [f64],
    /// Whether most points are in a crowd.
    pub(super) crowded: bool,
    /// By which the metric was chosen.
    pub(super) weight: f64,
    pub(super) relaxation: f64,
    /// State, by side. Where descent comes to the end there is none.
    pub(super) h: LazyLock<Shared, Box<dyn FnOnce() -> Shared + Send>>,
    /// By how much impulses on the first points of contacts have changed, world.
    pub(super) impulses: Shared,
    /// By how much velocities of points have, where they are looked at.
    pub(super) v: Shared,
}

/// Where a part works.
#[derive(Default)]
pub(super) struct Room {
    /// Impulses to answer, and the answers, by point.
    asked: Vec<Vector3<f64>>,
    answer: Vec<Vector3<f64>>,
    /// How far a step leads, and what steps are mixed in.
    pub(super) ways: Vec<f64>,
    pub(super) mixed: Vec<f64>,
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
    /// Tells the impulses.
    End,
}

/// Some bodies and some contacts.
pub(super) struct Part<'a, 'b> {
    bodies: &'a mut [&'b mut dyn Body],
    points: Range<usize>,
    /// State at the start of a step of the splitting, by side, and what is remembered of steps.
    start: Vec<Vector3<f64>>,
    steps: &'a mut anderson::Part,
    pub(super) descents: &'a mut anderson::Part,
    pub(super) products: Products,
    pub(super) contacts: Range<usize>,
    /// Where impulses were given, and are told.
    told: &'a mut [Vector3<f64>],
    pub(super) groups: Vec<Group>,
    /// Impulses in the frames of the contacts, and relative velocities that these want, by group.
    pub(super) impulses: Vec<Eight>,
    pub(super) wanted: Vec<Eight>,
    pub(super) sums: ResidualSums,
    /// Why a body does not take the metric.
    pub(super) refused: Option<ContactError>,
}

impl<'a, 'b> Part<'a, 'b> {
    /// The bodies are those of the `points`, the impulses those of the `contacts`.
    pub(super) fn new(
        common: &Common,
        (bodies, points): (&'a mut [&'b mut dyn Body], Range<usize>),
        (told, contacts): (&'a mut [Vector3<f64>], Range<usize>),
        [steps, descents]: [&'a mut anderson::Part; 2],
    ) -> Self {
        let Common { sides, masses, .. } = common;
        let group = |start: usize| {
            let part = start..contacts.end.min(start + LANES);
            let own = &common.contacts[part.clone()];
            let (mut at_points, mut at_sides) = ([[0; LANES]; 2], [[0; LANES]; 2]);
            for (lane, (contact, sides)) in own.iter().zip(sides.of_contacts(&part)).enumerate() {
                let points = [contact.first, contact.second.unwrap_or(masses.len())];
                for side in 0..2 {
                    at_points[side][lane] = index(points[side]);
                    at_sides[side][lane] = sides[side];
                }
            }
            let velocities = own.iter().map(|contact| common.relative(contact));
            let impulses = &told[start - contacts.start..];
            let responses = own.iter().map(|contact| common.response(contact));
            let weights = own.iter().map(|contact| common.weight_of(contact));
            Group::new(own, velocities, impulses, responses, weights, [at_points, at_sides])
        };
        let groups: Vec<_> = contacts.clone().step_by(LANES).map(group).collect();
        Self {
            impulses: groups.iter().map(|group| group.impulses).collect(),
            groups,
            products: Products::default(),
            wanted: Vec::new(),
            sums: ResidualSums::default(),
            refused: None,
            start: Vec::new(),
            bodies,
            points,
            steps,
            descents,
            contacts,
            told,
        }
    }

    pub(super) fn act(&mut self, order: &Order, common: &Common, room: &mut Room) {
        match order {
            Order::SetOut => self.set_out(common),
            Order::Obey { looked_at } => self.alone(common, Act::Obey { looked_at: *looked_at }),
            Order::Respond { sets_out, turn, looked_at } => {
                self.respond(common, *sets_out, *turn, *looked_at, room);
            }
            Order::Onward(onward) => self.go_on(common, onward, room),
            Order::Compare => self.alone(common, Act::Compare),
            Order::Tell => self.tell(common, room),
            Order::Judge => self.alone(common, Act::Judge),
            Order::Descent(step) => self.descent(common, step, room),
            Order::End => self.end(),
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
        self.wanted.resize(self.groups.len(), Eight::default());
        for point in self.points.clone() {
            let (v, mass) = (common.v.get(point), common.masses[point]);
            for side in common.sides.at(point) {
                common.h.set(side, &(v - common.impulse(side) / mass));
            }
        }
    }

    /// Lets the bodies move as near to `2 z - h` as they can.
    fn respond(
        &mut self,
        common: &Common,
        sets_out: bool,
        turn: Turn,
        looked_at: bool,
        room: &mut Room,
    ) {
        let Common { sides, masses, h, .. } = common;
        let asked = |point: usize| {
            let of_side = |side| h.get(side) * masses[point] + common.impulse(side) * 2.0;
            sides.at(point).map(of_side).sum()
        };
        self.answer(asked, room, |body, asked, answer| body.weighted_respond(asked, answer));
        if sets_out {
            self.start.clear();
        }
        let looks = matches!(turn, Turn::Look(_));
        if looks {
            self.steps.image().clear();
            room.ways.clear();
        }
        let first = common.sides.of(&self.points).start;
        for (point, v) in self.points.clone().zip(&room.answer) {
            let (lightness, root) = (1.0 / masses[point], masses[point].sqrt());
            for side in sides.at(point) {
                let before = h.get(side);
                let z = before + common.impulse(side) * lightness;
                let next = before + (v - z) * common.relaxation;
                if sets_out {
                    self.start.push(before);
                }
                if looks {
                    self.steps.image().extend_from_slice(next.as_slice());
                    let way = (next - self.start[side - first]) * root;
                    room.ways.extend_from_slice(way.as_slice());
                } else {
                    h.set(side, &next);
                }
            }
            if looked_at {
                common.v.set(point, v);
            }
        }
        if let Turn::Look(place) = turn {
            self.products = self.steps.look(&room.ways, place);
        }
    }

    fn go_on(&mut self, common: &Common, onward: &Onward, room: &mut Room) {
        let state = self.steps.onward(onward, &mut room.mixed).as_chunks::<3>().0;
        for (side, next) in common.sides.of(&self.points).zip(state) {
            common.h.set(side, &(*next).into());
        }
    }

    fn tell(&mut self, common: &Common, room: &mut Room) {
        let asked = |point: usize| {
            let mut sides = common.sides.at(point).map(|side| common.impulse(side));
            let first = sides.next().unwrap_or_default();
            sides.fold(first, |sum, impulse| sum + impulse)
        };
        self.answer(asked, room, |body, asked, answer| body.respond(asked, answer));
        self.points.clone().zip(&room.answer).for_each(|(point, v)| common.v.set(point, v));
    }

    fn end(&mut self) {
        let all = self.impulses.iter().flat_map(|[n, s, t]| n.iter().zip(s).zip(t));
        for (told, ((n, s), t)) in self.told.iter_mut().zip(all) {
            *told = Vector3::new(*n, *s, *t);
        }
    }

    /// Has every contact do something by itself.
    pub(super) fn alone(&mut self, common: &Common, act: Act) {
        Arch::new().dispatch(Alone { part: self, common, act });
    }

    /// Lets all bodies answer what is asked of each point.
    fn answer(
        &mut self,
        of_point: impl Fn(usize) -> Vector3<f64>,
        Room { asked, answer, .. }: &mut Room,
        how: impl Fn(&mut dyn Body, &[Vector3<f64>], &mut [Vector3<f64>]),
    ) {
        asked.clear();
        asked.extend(self.points.clone().map(of_point));
        answer.resize(asked.len(), Vector3::zeros());
        let mut start = 0;
        for body in &mut *self.bodies {
            let own = start..start + body.points();
            how(&mut **body, &asked[own.clone()], &mut answer[own.clone()]);
            start = own.end;
        }
    }
}

/// How far the velocities that have been told are from the law.
pub(super) fn judge<'a, 'b, A>(lead: &Lead<'_, '_, Part<'a, 'b>, Order, Room, A>) -> Report
where
    A: Fn(&Order, &mut Part<'a, 'b>, &mut Room) + Sync,
{
    lead.order(Order::Judge);
    together(lead)
}

/// What all parts have found, together.
pub(super) fn together<'a, 'b, A>(lead: &Lead<'_, '_, Part<'a, 'b>, Order, Room, A>) -> Report
where
    A: Fn(&Order, &mut Part<'a, 'b>, &mut Room) + Sync,
{
    let mut parts = Vec::new();
    lead.each(|part| parts.push(part.sums));
    ResidualSums::together(&parts).report()
}

impl Common<'_> {
    /// By how much the impulse of a side on its point has changed.
    #[inline]
    fn impulse(&self, side: usize) -> Vector3<f64> {
        let (contact, sign) = self.sides.contact(side);
        self.impulses.get(contact).map(|x| f64::from_bits(x.to_bits() ^ sign))
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

    /// By how much the first point of a contact is faster than the second with the impulses that were given.
    fn relative(&self, &Contact { first, second, .. }: &Contact) -> Vector3<f64> {
        let second = second.map_or(Vector3::zeros(), |point| self.velocities[point]);
        self.velocities[first] - second
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
