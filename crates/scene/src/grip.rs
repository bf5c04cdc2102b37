//! Hands that pull at nodes.

use super::check::{Allowed, Check};
use serde::{Deserialize, Serialize};

/// A hand that pulls a node towards a place by a spring whose force is bounded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grip {
    /// Index of the fibre, counted over all bundles; 0 for a mass-spring system.
    #[serde(default)]
    pub fiber: usize,
    /// Node of the fibre, or of the mass-spring system.
    pub node: usize,
    /// Stiffness of the spring, N/m.
    pub stiffness: f64,
    /// Damping of the node's velocity, N s/m.
    #[serde(default)]
    pub damping: f64,
    /// Largest force, N.
    pub most: f64,
    /// Places of the hand, in the order of time: from each time on it is there until the next.
    pub path: Vec<GripPlace>,
    /// Time at which the hand lets go, s; left out, it never does.
    #[serde(default)]
    pub until: Option<f64>,
}

/// Where a hand is from a time on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripPlace {
    /// Time, s.
    pub time: f64,
    /// Position, m, world frame.
    pub position: [f64; 3],
}

impl Grip {
    /// Where the hand is at time `t`, s; `None` before it takes hold and after it lets go.
    #[must_use]
    pub fn at(&self, t: f64) -> Option<[f64; 3]> {
        let last = self.path.partition_point(|place| place.time <= t);
        let held = self.until.is_none_or(|until| t < until);
        self.path[..last].last().filter(|_| held).map(|place| place.position)
    }

    /// Reports problems of the hand; `segments` are those of its fibre, if there is one.
    pub(crate) fn check(&self, check: &mut Check, segments: Option<usize>) {
        match segments {
            None => check.refuse("fiber", format!("is {}, but there is no such fibre", self.fiber)),
            Some(last) if self.node > last => {
                let message = format!("is {}, but the nodes are numbered 0 to {last}", self.node);
                check.refuse("node", message);
            }
            Some(_) => {}
        }
        check.number("stiffness", self.stiffness, Allowed::NonNegative, "N/m");
        check.number("damping", self.damping, Allowed::NonNegative, "N s/m");
        check.number("most", self.most, Allowed::NonNegative, "N");
        if let Some(until) = self.until {
            check.number("until", until, Allowed::NonNegative, "s");
        }
        check.each("path", &self.path, |c, place| {
            c.number("time", place.time, Allowed::NonNegative, "s");
            c.vector("position", &place.position, "m");
        });
        for (i, pair) in self.path.windows(2).enumerate() {
            if pair[1].time <= pair[0].time {
                let message = format!(
                    "is {:?}, but must be later than {:?}, the time of the place before (s)",
                    pair[1].time, pair[0].time
                );
                check.refuse(&format!("path[{}].time", i + 1), message);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_is_where_it_was_last_put_until_it_lets_go() {
        let place = |time, x| GripPlace { time, position: [x, 0.0, 0.0] };
        let grip = Grip {
            fiber: 0,
            node: 3,
            stiffness: 1.0,
            damping: 0.0,
            most: 1.0,
            path: vec![place(1.0, 0.1), place(2.0, 0.2)],
            until: Some(3.0),
        };
        let x = |t| grip.at(t).map(|position| position[0]);
        let seen = [0.9, 1.0, 1.9, 2.0, 2.9, 3.0].map(x);
        assert_eq!(seen, [None, Some(0.1), Some(0.1), Some(0.2), Some(0.2), None]);
        let mut check = Check::default();
        grip.check(&mut check, Some(3));
        assert!(check.finish(None).is_empty());
        let wrong = Grip { path: vec![place(2.0, 0.2), place(1.0, 0.1)], ..grip };
        let mut check = Check::default();
        wrong.check(&mut check, Some(2));
        let paths: Vec<_> = check.finish(None).into_iter().map(|problem| problem.path).collect();
        assert_eq!(paths, ["node", "path[1].time"]);
    }
}
