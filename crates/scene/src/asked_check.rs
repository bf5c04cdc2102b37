//! Whether what is asked of a case makes sense.

use crate::asked::Parameter;
use crate::case::Case;
use crate::case_end::{CaseEnd, CaseRoot, SlidingHold, TURNS};
use crate::{Allowed, Check, LoadFrame};

impl Case {
    /// The longest length that is asked about, m.
    pub(crate) fn longest(&self) -> f64 {
        let swept = match (&self.sweep, &self.critical) {
            (Some(sweep), _) if sweep.of == Parameter::Length => sweep.from.max(sweep.to),
            (_, Some(critical)) if critical.of == Parameter::Length => critical.up_to,
            _ => self.length,
        };
        self.wish.map_or(swept, |wish| wish.longest)
    }

    /// Reports what makes no sense of what is asked.
    pub(crate) fn check_asked(&self, check: &mut Check) {
        if let Some(wish) = self.wish {
            check.within("wish", |c| wish.check(c, self.length));
        }
        if let Some(sweep) = &self.sweep {
            check.within("sweep", |c| {
                self.check_range(c, sweep.of, ["from", "to"], [sweep.from, sweep.to]);
                c.count("steps", sweep.steps, 1, 10_000);
                c.count("shapes", sweep.shapes, 2, 1000);
            });
        }
        if let Some(critical) = &self.critical {
            check.within("critical", |c| {
                let values = [critical.first(self.length), critical.up_to];
                self.check_range(c, critical.of, ["from", "up_to"], values);
                let moment =
                    matches!(self.end, CaseEnd::Free { moment, .. } if moment != [0.0; 3]);
                if moment {
                    let message = "is not found: a moment on the end that keeps its direction is not \
                                   conservative, so the rod may flutter before it buckles; run it \
                                   as a scene";
                    c.refuse("of", message.into());
                }
            });
        }
        let asked = [
            ("wish", self.wish.is_some()),
            ("sweep", self.sweep.is_some()),
            ("critical", self.critical.is_some()),
            ("all_with_turns", self.all_with_turns.is_some()),
        ];
        let mut asked = asked.iter().filter(|(_, is)| *is);
        if let (Some((first, _)), Some((second, _))) = (asked.next(), asked.next()) {
            check.refuse(second, format!("does not go together with `{first}`: ask one of them"));
        }
        let chain = self.needs_chain();
        for (field, is) in [
            ("start", self.start.is_some()),
            ("sweep", self.sweep.is_some()),
            ("critical", self.critical.is_some()),
        ] {
            if chain && is && !self.is_in_contact() {
                let follower = self.forces.iter().any(|f| f.frame == LoadFrame::Follower);
                let message = if follower {
                    "does not go together with a force that follows the rod: that is not \
                     conservative, so the rod may flutter before it buckles; run it as a scene"
                } else {
                    "does not go together with places on the way; take them out"
                };
                check.refuse(field, message.into());
            }
        }
        let loose = self.root == CaseRoot::Joint && !self.is_in_contact();
        if loose && matches!(self.end, CaseEnd::Free { .. }) {
            let message = "is a joint and the far end is free, so the rod has no definite place: \
                           clamp it, or hold the far end";
            check.refuse("root", message.into());
        }
        if self.root == CaseRoot::Joint && matches!(self.end, CaseEnd::Ring { .. }) {
            check.refuse("root", "is a joint, but a ring is clamped to its root".into());
        }
        if matches!(self.end, CaseEnd::Ring { .. }) && self.all_with_turns.is_some() {
            check.refuse("all_with_turns", "is not found of rings: give them a `start`".into());
        }
    }

    /// Reports a range of a parameter that is none, and a parameter that the case does not have.
    fn check_range(&self, check: &mut Check, of: Parameter, names: [&str; 2], values: [f64; 2]) {
        let allowed = match of {
            Parameter::Length => Allowed::Within(1e-6, 1e3),
            Parameter::EndTurn(_) | Parameter::EndTwist => TURNS,
            _ => Allowed::Finite,
        };
        for (name, value) in names.into_iter().zip(values) {
            check.number(name, value, allowed, of.unit());
        }
        if values[0] == values[1] {
            let message = format!("is {:?} as `{}` is: give a range", values[1], names[0]);
            check.refuse(names[1], message);
        }
        if let Some(why) = self.lacks(of) {
            check.refuse("of", why);
        }
        let shortest = values[0].min(values[1]);
        let on_the_way = self.masses.iter().map(|mass| mass.at);
        let last = on_the_way
            .chain(self.forces.iter().map(|force| force.at))
            .chain(self.joined.iter().map(|part| part.from))
            .fold(0.0, f64::max);
        if of == Parameter::Length && last >= shortest {
            let message = format!(
                "reaches {shortest:?} m, but something is at {last:?} m along the rod: begin beyond it"
            );
            check.refuse(names[0], message);
        }
    }

    /// Why the case has no such parameter.
    fn lacks(&self, of: Parameter) -> Option<String> {
        let zero = [0.0; 3];
        let loaded = match self.end {
            CaseEnd::Free { force, .. } => force != zero,
            CaseEnd::Sliding { force, .. } => force != 0.0,
            _ => false,
        };
        let clamped = match self.end {
            CaseEnd::Clamped { .. } | CaseEnd::Ring { .. } => true,
            CaseEnd::Sliding { hold, .. } => matches!(hold, SlidingHold::Clamped { .. }),
            _ => false,
        };
        let bearing = match self.end {
            CaseEnd::Bearing { .. } => true,
            CaseEnd::Sliding { hold, .. } => matches!(hold, SlidingHold::Bearing { .. }),
            _ => false,
        };
        let ring = matches!(self.end, CaseEnd::Ring { .. });
        let (has, why) = match of {
            Parameter::Loads | Parameter::Length => (true, ""),
            Parameter::Gravity => {
                (self.gravity != zero, "is gravity, but there is none: give `gravity` a value")
            }
            Parameter::EndForce => (
                loaded,
                "is the force on the end, but the end bears none: give `end: Free(force: ...)` or \
                 `end: Sliding(..., force: ...)`",
            ),
            Parameter::EndMoment => (
                matches!(self.end, CaseEnd::Free { moment, .. } if moment != zero),
                "is the moment on the end, but the end bears none: give `end: Free(moment: ...)`",
            ),
            Parameter::Force(i) => {
                let count = self.forces.len();
                let why = format!("is force {i}, counted from 0, but `forces` has {count}");
                return (i >= count).then_some(why);
            }
            Parameter::EndMove(way) => (
                !matches!(self.end, CaseEnd::Free { .. }) && !ring && way != zero,
                "moves the end, but the end is not held at a place, or the way is zero",
            ),
            Parameter::EndTurn(axis) => (
                (clamped || bearing) && !ring && axis != zero,
                "turns the end, but the end has no held direction, or the axis is zero",
            ),
            Parameter::EndTwist => (
                clamped,
                "turns the end about its tangent, but the end is not clamped: give `end: Clamped(...)`",
            ),
        };
        (!has).then(|| why.to_owned())
    }
}
