//! Which fibres can be fed through a nozzle, and how fast.

use super::check::Check;
use super::{Bundle, FiberShape, Initial, JointKind, Law, Plan, Scene};

impl Scene {
    /// Reports what cannot be fed, and a feed that a step cannot follow.
    pub(super) fn check_feed(&self, bundle: &Bundle, check: &mut Check) {
        let Some(feed) = &bundle.feed else { return };
        check.within("feed", |c| feed.check_numbers(c));
        let mut refuse = |given: bool, field: &str, message: &str| {
            if given {
                check.refuse(field, message.into());
            }
        };
        let clamped = "must be Clamped where the fibre is fed: the nozzle holds it";
        refuse(bundle.root_joint != JointKind::Clamped, "root_joint", clamped);
        refuse(bundle.groom.is_some(), "feed", "is not for the hairs of a groom: leave it out");
        let straight = bundle.initial == Initial::Straight
            || bundle.initial == Initial::Natural && bundle.shape == FiberShape::Straight;
        let start = "must be Straight, or left out with a straight shape, where the fibre is fed: it \
                     starts straight through the nozzle";
        refuse(!straight && bundle.groom.is_none(), "initial", start);
        refuse(bundle.law() != Law::Elastic, "material.law", "must be Elastic to be fed");
        refuse(
            self.has_joints(),
            "feed",
            "is not for scenes with fibres that are joined or closed",
        );
        refuse(self.charging.is_some(), "feed", "has no meaning with charging: leave it out");
        if !self.stepper.keeps_ledgers() {
            let message = "is for the methods Staggered and BackwardEuler without a tolerance";
            check.refuse("feed", message.into());
        }
        let segment = bundle.length / bundle.segments as f64;
        let dt = Plan::new(self).dt;
        let way = feed.largest_speed() * dt;
        if way > segment {
            let message = format!(
                "feeds {way:.3e} m in a step of {dt:.3e} s, more than a segment of {segment:.3e} m, \
                 which a step cannot follow: feed more slowly, or take a shorter `stepper.dt`"
            );
            check.refuse("feed", message);
        }
        let times = feed.lengths.iter().map(|one| one.time).filter(|time| *time < self.duration);
        for time in [0.0, self.duration].into_iter().chain(times) {
            let inside = feed.inside(time);
            if inside < 0.0 {
                let message = format!(
                    "has paid out {:.6} m at {time:.6} s, but only {:.6} m are inside at the start: \
                     end it before, or make fibre and `inside` longer",
                    feed.fed(time),
                    feed.inside
                );
                check.refuse("feed", message);
                return;
            }
            if inside > bundle.length - segment {
                let message = format!(
                    "has {inside:.6} m inside at {time:.6} s, but the last segment of the fibre of \
                     {:.6} m must stay outside: end it before, or make the fibre longer",
                    bundle.length
                );
                check.refuse("feed", message);
                return;
            }
        }
    }
}
