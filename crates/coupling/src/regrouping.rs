//! Which fibres move side by side.

use crate::{FiberGroup, Fibers};
use rapunzel_rod_dynamic::{Rod, RodError, SectionLaws, StaggeredBatch};
use std::cmp::Reverse;

/// Beside the fewest groups that busy fibres would fill, one for so many of these may be at work,
/// and some more: a group that is put together anew costs as much as some steps of one at work.
const GROUPS_A_SPARE: usize = 4;
const SPARE_GROUPS: usize = 2;

/// What fibres have in common that may take each other's places: their segments, and whether they
/// are damped and have laws of their own.
type RodKind = (usize, bool, bool);

fn kind(rod: &Rod) -> RodKind {
    (rod.fiber.segments(), rod.damping_time > 0.0, rod.laws != SectionLaws::Linear)
}

impl FiberGroup<StaggeredBatch> {
    /// What all fibres of the group have in common, if they do.
    fn kind(&self) -> Option<RodKind> {
        let mut kinds = self.batch.rods().iter().map(kind);
        let first = kinds.next()?;
        kinds.all(|other| other == first).then_some(first)
    }
}

/// Lists of groups among which fibres may move.
pub(crate) struct GroupClasses(Vec<Vec<usize>>);

impl GroupClasses {
    pub(crate) fn new(fibers: &Fibers<StaggeredBatch>) -> Self {
        let mut classes: Vec<(RodKind, Vec<usize>)> = Vec::new();
        for (number, group) in fibers.groups.iter().enumerate() {
            let Some(kind) = group.kind() else { continue };
            match classes.iter_mut().find(|(other, _)| *other == kind) {
                Some((_, groups)) => groups.push(number),
                None => classes.push((kind, vec![number])),
            }
        }
        Self(classes.into_iter().map(|(_, groups)| groups).collect())
    }

    /// The order of fibres in which those that are `busy`, by their numbers, fill the fewest groups
    /// with the fewest moves; none where that is hardly better than it is.
    pub(crate) fn with_busy_together(
        &self,
        fibers: &Fibers<StaggeredBatch>,
        busy: &[bool],
    ) -> Option<Vec<Vec<usize>>> {
        let mut order: Option<Vec<Vec<usize>>> = None;
        for class in &self.0 {
            let members = |group: &usize| &fibers.groups[*group].fibers;
            let count = |group: &usize| members(group).iter().filter(|&&f| busy[f]).count();
            let mut groups: Vec<_> = class.iter().map(|group| (count(group), *group)).collect();
            groups.sort_by_key(|&(count, group)| (Reverse(count), group));
            let all: usize = groups.iter().map(|(count, _)| count).sum();
            let at_work = groups.iter().filter(|(count, _)| *count > 0).count();
            // The fewest groups, fullest first, that have room for all.
            let (mut room, mut fewest) = (0, 0);
            while room < all {
                room += members(&groups[fewest].1).len();
                fewest += 1;
            }
            if at_work <= fewest + fewest / GROUPS_A_SPARE + SPARE_GROUPS {
                continue;
            }
            let order = order.get_or_insert_with(|| {
                fibers.groups.iter().map(|group| group.fibers.clone()).collect()
            });
            let places = |groups: &[(usize, usize)], which: bool| -> Vec<(usize, usize)> {
                let lanes = |&(_, group): &(usize, usize)| {
                    let own = members(&group).iter().enumerate();
                    own.filter(move |(_, fiber)| busy[**fiber] == which)
                        .map(move |(lane, _)| (group, lane))
                };
                groups.iter().flat_map(lanes).collect()
            };
            let (first, others) = groups.split_at(fewest);
            for (a, b) in places(first, false).into_iter().zip(places(others, true)) {
                let (idle, moved) = (order[a.0][a.1], order[b.0][b.1]);
                order[a.0][a.1] = moved;
                order[b.0][b.1] = idle;
            }
        }
        order
    }
}

impl Fibers<StaggeredBatch> {
    /// The numbers of the fibres, group by group.
    pub(crate) fn order(&self) -> impl Iterator<Item = usize> {
        self.groups.iter().flat_map(|group| group.fibers.iter().copied())
    }

    /// Lets fibres move side by side in another order, group by group, from the next step on. How a
    /// fibre moves by itself does not depend on that, what contacts do only within tolerances.
    ///
    /// # Errors
    /// [`RodError::Invalid`] unless every fibre is there once, among others of its kind. All are
    /// then as before.
    pub(crate) fn arrange(&mut self, mut order: &[usize]) -> Result<(), RodError> {
        let (what, why) =
            ("order of fibers", "must have every fibre once, among others of its kind");
        let wrong = || Err(RodError::Invalid { what, why });
        let mut seen = vec![false; self.assembly().fibers().len()];
        if order.len() != seen.len() {
            return wrong();
        }
        for &fiber in order {
            if seen.get_mut(fiber).is_none_or(|seen| std::mem::replace(seen, true)) {
                return wrong();
            }
        }
        let mut changed = Vec::new();
        for (number, group) in self.groups.iter().enumerate() {
            let own;
            (own, order) = order.split_at(group.fibers.len());
            if own != group.fibers {
                let kind = |&fiber: &usize| self.groups[self.lane(fiber).0].kind();
                if group.kind().is_none() || own.iter().any(|fiber| kind(fiber) != group.kind()) {
                    return wrong();
                }
                changed.push((number, own));
            }
        }
        let mut taken: Vec<_> = seen.iter().map(|_| None).collect();
        for (number, _) in &changed {
            let group = &mut self.groups[*number];
            let lanes = group.batch.moving_rods().into_iter().zip(group.lanes.drain(..));
            group.fibers.iter().zip(lanes).for_each(|(fiber, lane)| taken[*fiber] = Some(lane));
        }
        for (number, own) in changed {
            let group = &mut self.groups[number];
            let (rods, lanes) = own.iter().filter_map(|fiber| taken[*fiber].take()).unzip();
            group.batch.replace_rods(rods)?;
            (group.lanes, group.fibers) = (lanes, own.to_vec());
            for (lane, &fiber) in own.iter().enumerate() {
                self.lanes[fiber] = (number, lane);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BundleConditions, FiberConditions, Surroundings};
    use nalgebra::{Isometry3, Vector3};
    use proptest::prelude::*;
    use rapunzel_fiber::{Assembly, Fiber, Material, Section};
    use rapunzel_rod_dynamic::{End, Load};
    use rapunzel_scene::Scene;
    use std::sync::Arc;

    const SCENE: &str = "(format: 1, duration: 1.0, fibers: [(length: 0.03, segments: 3,
        section: Circle(radius: 3.5e-5), root: (orientation: Along(direction: (0, 1, 0))))],
        environment: (gravity: (5, 0, 0)), stepper: (dt: 1e-3))";

    /// Fibres with some numbers of segments, each longer than the one before.
    fn fibers(segments: &[usize]) -> Fibers<StaggeredBatch> {
        let scene = Scene::from_ron(SCENE).expect("a sound scene");
        let bundle = BundleConditions::new(&scene, &scene.fibers[0], 0.03, 3.5e-5);
        let bundle = Arc::new(bundle.expect("slender"));
        let fiber = |(i, &n): (usize, &usize)| {
            let length = 0.03 + 1e-3 * i as f64;
            let section = Section::Circle { radius: 3.5e-5 };
            Fiber::uniform(length, n, section, &Material::HAIR).expect("valid")
        };
        let assembly = Assembly::new(segments.iter().enumerate().map(fiber).collect());
        let group = |fibers: &[usize]| {
            let rod = |&fiber: &usize| Rod::new(assembly.fibers()[fiber].clone());
            let rods = fibers.iter().map(rod).collect();
            let lane = |&fiber: &usize| FiberConditions {
                bundle: Arc::clone(&bundle),
                segments: segments[fiber],
                root: Isometry3::identity(),
                tip: Isometry3::identity(),
                end_load: End::Loaded { force: Load::ZERO, moment: Load::ZERO },
                taken: Vec::new(),
                pulls: None,
            };
            FiberGroup {
                fibers: fibers.to_vec(),
                batch: Box::new(StaggeredBatch::hybrid(rods, 0.3).expect("valid")),
                lanes: fibers.iter().map(lane).collect(),
            }
        };
        let groups = assembly.groups().map(group).collect();
        Fibers::new(assembly, groups, false)
    }

    /// How many groups have busy fibres, by the number of segments.
    fn at_work(fibers: &Fibers<StaggeredBatch>, busy: &[bool], segments: usize) -> usize {
        let of_kind =
            fibers.groups.iter().filter(|g| g.batch.rods()[0].fiber.segments() == segments);
        of_kind.filter(|group| group.fibers.iter().any(|&fiber| busy[fiber])).count()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        /// Busy fibres fill the fewest groups, or few more, and every fibre stays among its kind.
        #[test]
        fn busy_fibers_fill_the_fewest_groups(
            all in prop::collection::vec((2..4_usize, prop::bool::weighted(0.2)), 1..120),
        ) {
            let (segments, busy): (Vec<_>, Vec<_>) = all.into_iter().unzip();
            let mut fibers = fibers(&segments);
            let classes = GroupClasses::new(&fibers);
            let order = classes.with_busy_together(&fibers, &busy);
            if let Some(order) = order {
                fibers.arrange(&order.concat()).expect("every fibre once");
                prop_assert!(classes.with_busy_together(&fibers, &busy).is_none());
            }
            for n in 2..4 {
                let count = (0..busy.len()).filter(|&f| busy[f] && segments[f] == n).count();
                let (fewest, found) = (count.div_ceil(8), at_work(&fibers, &busy, n));
                // A group that is not full may be among the fullest.
                prop_assert!(4 * found <= 5 * (fewest + 1) + 8, "{found} for {fewest}");
            }
            let mut seen: Vec<_> = fibers.order().collect();
            seen.sort_unstable();
            prop_assert!(seen.into_iter().eq(0..busy.len()));
            for (fiber, n) in segments.iter().enumerate() {
                prop_assert_eq!(fibers.state(fiber).positions.len(), n + 1);
            }
        }
    }

    /// An order tells where fibres move, not how.
    #[test]
    fn fibers_move_alike_in_any_order() {
        let segments = [[3; 20], [2; 20]].concat();
        let (mut fibers, mut moved) = (fibers(&segments), fibers(&segments));
        let scene = Scene::from_ron(SCENE).expect("a sound scene");
        let step = |fibers: &mut Fibers<StaggeredBatch>, start: f64| {
            let (environment, objects) = (&scene.environment, &mut [][..]);
            let around = Surroundings { environment, objects, start, end: start + 1e-3 };
            fibers.step(&around, 1e-3).expect("a step");
        };
        let reversed: Vec<_> = (20..40).rev().chain((0..20).rev()).collect();
        for i in 0..10 {
            let start = 1e-3 * f64::from(i);
            if i == 5 {
                moved.arrange(&reversed).expect("every fibre once");
                assert!(moved.order().eq(reversed.iter().copied()));
            }
            step(&mut fibers, start);
            step(&mut moved, start);
        }
        for fiber in 0..40 {
            assert_eq!(fibers.state(fiber).positions, moved.state(fiber).positions, "{fiber}");
            assert!(fibers.state(fiber).velocities[2] != Vector3::zeros());
        }
        let wrong: [&[usize]; 4] = [&[], &[0; 40], &[40; 40], &reversed[1..]];
        let swapped: Vec<_> = (0..40).collect();
        for order in wrong.into_iter().chain([&swapped[..]]) {
            assert!(moved.arrange(order).is_err(), "{order:?}");
            assert!(moved.order().eq(reversed.iter().copied()));
        }
    }
}
