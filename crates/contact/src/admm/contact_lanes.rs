//! As many contacts at once as a register holds.
//!
//! A projection onto a circle or its cone is a root, a quotient and a choice; one after another
//! these wait for each other. Other curves are projected onto one by one.

use super::contact_group::{ContactGroup, ContactNumbers, SideIndices};
use super::shared_vectors::SharedVectors;
use crate::{Contact, VectorLanes};
use nalgebra::Vector3;
use pulp::Simd;
use rapunzel_lanes::{LANES, Lane, Mask, V3};
use std::array::from_fn;
use std::ops::Range;

/// Contacts of a group that share a register.
#[derive(Clone, Copy)]
pub(super) struct ContactLanes<'a, S: Simd> {
    simd: S,
    pub(super) group: &'a ContactGroup,
    contacts: &'a [Contact],
    /// Index of the group.
    pub(super) group_index: usize,
    /// Index of the register in the group.
    register: usize,
    /// Index of the first contact, and number of contacts.
    first: usize,
    count: usize,
}

impl<'a, S: Simd> ContactLanes<'a, S> {
    /// Number of registers that a number of contacts fills.
    #[inline(always)]
    pub(super) fn registers(contacts: usize) -> usize {
        contacts.div_ceil(S::F64_LANES)
    }

    /// Contacts of register number `register` among all of the `groups`.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        groups: &'a [ContactGroup],
        contacts: &'a [Contact],
        register: usize,
    ) -> Self {
        let in_group = LANES / S::F64_LANES;
        let (group_index, first) = (register / in_group, register * S::F64_LANES);
        let (group, register) = (&groups[group_index], register % in_group);
        let count = (contacts.len() - first).min(S::F64_LANES);
        Self { simd, group, contacts, group_index, register, first, count }
    }

    /// Indices of the contacts.
    #[inline(always)]
    pub(super) fn range(&self) -> Range<usize> {
        self.first..self.first + self.count
    }

    /// Numbers of this register, from those of the whole group.
    #[inline(always)]
    fn lane(&self, numbers: &ContactNumbers) -> Lane<S> {
        Lane::load(self.simd, numbers, self.register)
    }

    /// One number for all contacts.
    #[inline(always)]
    pub(super) fn splat(&self, x: f64) -> Lane<S> {
        Lane::splat(self.simd, x)
    }

    /// Tensile impulses that the contacts can bear, N s.
    #[inline(always)]
    pub(super) fn adhesion(&self) -> Lane<S> {
        self.group.soft.as_ref().map_or(self.splat(0.0), |soft| self.lane(&soft[0]))
    }

    /// Which contacts are joints, if any of the group is.
    #[inline(always)]
    pub(super) fn joint(&self) -> Option<Mask<S, f64>> {
        self.group.joints.as_ref().map(|joints| self.lane(joints).positive())
    }

    /// Least impulses along the normals that the contacts can bear, N s.
    #[inline(always)]
    pub(super) fn least_normal(&self) -> Lane<S> {
        let least = -self.adhesion();
        self.joint().map_or(least, |joint| joint.select(self.splat(f64::MIN), least))
    }

    /// Compliances, 1/kg.
    #[inline(always)]
    pub(super) fn compliance(&self) -> Lane<S> {
        self.group.soft.as_ref().map_or(self.splat(0.0), |soft| self.lane(&soft[1]))
    }

    /// Masses with which reports compare errors of velocities and of impulses, kg.
    #[inline(always)]
    pub(super) fn weights(&self) -> Lane<S> {
        self.lane(&self.group.weights)
    }

    /// Factors by which errors of impulses count more, as heavier bodies move too.
    #[inline(always)]
    pub(super) fn heavier(&self) -> Lane<S> {
        self.group.heavier.as_ref().map_or(self.splat(1.0), |heavier| self.lane(heavier))
    }

    /// Answers of the relative velocities to the contacts' own impulses in the metric, 1/kg.
    #[inline(always)]
    pub(super) fn responses(&self) -> Lane<S> {
        self.lane(&self.group.responses)
    }

    /// Vectors of this register, from those of the whole group.
    #[inline(always)]
    pub(super) fn load(&self, [x, y, z]: &VectorLanes<f64>) -> V3<S> {
        V3([self.lane(x), self.lane(y), self.lane(z)])
    }

    /// Puts vectors where [`Self::load`] finds them.
    #[inline(always)]
    pub(super) fn store(&self, vectors: V3<S>, into: &mut VectorLanes<f64>) {
        vectors.0.into_iter().zip(into).for_each(|(x, into)| x.store(into, self.register));
    }

    /// Lanes of vectors that lie one after another.
    #[inline(always)]
    fn pack(&self, vectors: &[Vector3<f64>; LANES]) -> V3<S> {
        let mut numbers = [[0.0; LANES]; 3];
        for (lane, vector) in vectors.iter().take(S::F64_LANES).enumerate() {
            for k in 0..3 {
                numbers[k][lane] = vector[k];
            }
        }
        let [x, y, z] = &numbers;
        V3([x, y, z].map(|numbers| Lane::load(self.simd, numbers, 0)))
    }

    /// Vectors one after another, from their lanes.
    #[inline(always)]
    pub(super) fn unpack(&self, vectors: V3<S>) -> [Vector3<f64>; LANES] {
        let mut numbers = [[0.0; LANES]; 3];
        for k in 0..3 {
            vectors.0[k].store(&mut numbers[k], 0);
        }
        let [x, y, z] = numbers;
        from_fn(|lane| Vector3::new(x[lane], y[lane], z[lane]))
    }

    /// Impulses that were given, N s, in the frames.
    #[inline(always)]
    pub(super) fn given_impulses(&self) -> V3<S> {
        self.load(&self.group.impulses)
    }

    /// Relative velocities in the frames, bias included, m/s, after these changes, m/s, world, from
    /// the given velocities at the sides or points of the `indices`.
    #[inline(always)]
    pub(super) fn relative_velocities(
        &self,
        changes: &SharedVectors,
        indices: &SideIndices,
    ) -> V3<S> {
        let from = self.register * S::F64_LANES;
        let mut between = [Vector3::zeros(); LANES];
        for lane in 0..S::F64_LANES {
            let [first, second] = [indices[0][from + lane], indices[1][from + lane]];
            between[lane] = changes.get(first as usize) - changes.get(second as usize);
        }
        let V3([x, y, z]) = self.pack(&between);
        let (frame, mut relative) = (self.frame(), V3::splat(self.simd, 0.0));
        for i in 0..3 {
            let [a, b, c] = frame[i].0;
            relative.0[i] = a * x + b * y + c * z + self.lane(&self.group.velocities[i]);
        }
        relative
    }

    /// Normals and both tangents, world.
    #[inline(always)]
    fn frame(&self) -> [V3<S>; 3] {
        let [normal, along] = [0, 1].map(|axis| self.load(&self.group.axes[axis]));
        let (V3([a, b, c]), V3([x, y, z])) = (normal, along);
        [normal, along, V3([b * z - c * y, c * x - a * z, a * y - b * x])]
    }

    /// Vectors in the world frame, from those in the contacts' frames.
    #[inline(always)]
    pub(super) fn in_world(&self, V3([n, s, t]): V3<S>) -> V3<S> {
        let [V3(a), V3(b), V3(c)] = self.frame();
        let mut world = V3::splat(self.simd, 0.0);
        for k in 0..3 {
            world.0[k] = a[k] * n + b[k] * s + c[k] * t;
        }
        world
    }

    /// Power per normal force that friction takes out of slips, m/s, as
    /// [`crate::LimitCurve::dissipation`].
    #[inline(always)]
    pub(super) fn dissipation(&self, [s, t]: [Lane<S>; 2]) -> Lane<S> {
        if let Some(circles) = &self.group.circles {
            return self.lane(circles) * norm([s, t]);
        }
        let mut all = self.unpack(V3([s, t, s]));
        for (found, contact) in all.iter_mut().zip(&self.contacts[self.range()]) {
            found.z = contact.friction.dissipation(&found.xy());
        }
        let V3([_, _, power]) = self.pack(&all);
        power
    }

    /// Friction within the curves scaled by `scale` nearest to another, as
    /// [`crate::LimitCurve::project`].
    #[inline(always)]
    pub(super) fn project(&self, [s, t]: [Lane<S>; 2], scale: Lane<S>) -> [Lane<S>; 2] {
        if let Some(circles) = &self.group.circles {
            // The disc: inside stays, outside shrinks onto the circle, without a load all is zero.
            let (zero, one) = (self.splat(0.0), self.splat(1.0));
            let (radius, size) = (self.lane(circles) * scale, norm([s, t]));
            let share = size.less_or_equal(radius).select(one, radius / size);
            let share = scale.less_or_equal(zero).select(zero, share);
            return [s * share, t * share];
        }
        let mut all = self.unpack(V3([s, t, scale]));
        for (found, contact) in all.iter_mut().zip(&self.contacts[self.range()]) {
            let nearest = contact.friction.project(&found.xy(), found.z);
            (found.x, found.y) = (nearest.x, nearest.y);
        }
        let V3([s, t, _]) = self.pack(&all);
        [s, t]
    }

    /// Impulses within the cones nearest to others, as [`crate::LimitCurve::project_cone`].
    #[inline(always)]
    pub(super) fn project_cone(&self, V3([n, s, t]): V3<S>) -> V3<S> {
        if let Some(circles) = &self.group.circles {
            let (zero, one, mu) = (self.splat(0.0), self.splat(1.0), self.lane(circles));
            // Coulomb's cone: inside stays, the polar cone goes to the tip, the rest onto the
            // border.
            let size = norm([s, t]);
            let (inside, outer) = (mu * n, n + mu * size);
            let normal = outer / (one + mu * mu);
            let share = size.less_or_equal(inside).select(one, mu * normal / size);
            let normal = size.less_or_equal(inside).select(n, normal);
            let border = V3([normal, s * share, t * share]);
            return outer.less_or_equal(zero).select(V3::splat(self.simd, 0.0), border);
        }
        let mut all = self.unpack(V3([n, s, t]));
        for (found, contact) in all.iter_mut().zip(&self.contacts[self.range()]) {
            *found = contact.friction.project_cone(found);
        }
        self.pack(&all)
    }
}

/// Norms of tangential vectors.
#[inline(always)]
pub(super) fn norm<S: Simd>([s, t]: [Lane<S>; 2]) -> Lane<S> {
    (s * s + t * t).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ErrorMasses, LimitCurve, Polygon};
    use proptest::prelude::*;
    use pulp::{Arch, Scalar, WithSimd};
    use std::iter::repeat;

    /// All projections of vectors: onto cones, onto curves scaled by the first component, and the
    /// dissipation.
    struct ProjectAll<'a>(&'a [ContactGroup], &'a [Contact], &'a [Vector3<f64>]);

    impl WithSimd for ProjectAll<'_> {
        type Output = [Vec<Vector3<f64>>; 2];

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let Self(groups, contacts, q) = self;
            let mut found = [q.to_vec(), q.to_vec()];
            for register in 0..ContactLanes::<S>::registers(contacts.len()) {
                let lanes = ContactLanes::new(simd, groups, contacts, register);
                let own = &q[lanes.range()];
                let V3([n, s, t]) =
                    lanes.pack(&from_fn(|i| own.get(i).copied().unwrap_or_default()));
                let cone = lanes.unpack(lanes.project_cone(V3([n, s, t])));
                let power = lanes.dissipation([s, t]);
                let [s, t] = lanes.project([s, t], n);
                let others = lanes.unpack(V3([power, s, t]));
                for (found, all) in found.iter_mut().zip([cone, others]) {
                    found[lanes.range()].copy_from_slice(&all[..own.len()]);
                }
            }
            found
        }
    }

    fn curve() -> impl Strategy<Value = LimitCurve> {
        let mu = || 0.0..2.0;
        let circle = mu().prop_map(|mu| LimitCurve::Circle { mu });
        let square =
            Polygon::new(&[[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]].map(Into::into));
        let square = LimitCurve::Polygon(square.expect("convex"));
        prop_oneof![
            6 => circle,
            1 => prop::array::uniform2(mu()).prop_map(|mu| LimitCurve::Ellipse { mu }),
            1 => prop::array::uniform4(mu()).prop_map(|mu| LimitCurve::Quarters { mu }),
            1 => Just(square),
        ]
    }

    fn vector() -> impl Strategy<Value = Vector3<f64>> {
        let number = || prop_oneof![4 => -1.0..1.0, 1 => Just(0.0), 1 => Just(1.0)];
        [number(), number(), number()].prop_map(Vector3::from)
    }

    proptest! {
        /// Whatever the curves, and one by one or in registers, contacts are projected as each
        /// would be.
        #[test]
        fn contacts_side_by_side_are_projected_as_each_is(
            all in prop::collection::vec((curve(), vector()), 1..20),
        ) {
            let contact = |(friction, _): &(LimitCurve, _)| Contact {
                first: 0,
                second: None,
                frame: nalgebra::Matrix3::identity(),
                bias: Vector3::zeros(),
                friction: friction.clone(),
                adhesion: 0.0,
                compliance: 0.0,
            };
            let contacts: Vec<_> = all.iter().map(contact).collect();
            let q: Vec<_> = all.iter().map(|(_, q)| *q).collect();
            let groups: Vec<_> = contacts
                .chunks(LANES)
                .map(|some| {
                    let zeros = repeat(Vector3::zeros());
                    let given = [Vector3::zeros(); LANES];
                    let ones = repeat(1.0);
                    let masses = ones.clone().map(ErrorMasses::from);
                    ContactGroup::new(some, zeros, &given, ones, masses, Default::default())
                })
                .collect();
            let both = [
                Arch::new().dispatch(ProjectAll(&groups, &contacts, &q)),
                Scalar::new().vectorize(ProjectAll(&groups, &contacts, &q)),
            ];
            for [cones, others] in both {
                for (i, (curve, q)) in all.iter().enumerate() {
                    prop_assert!((cones[i] - curve.project_cone(q)).norm() < 1e-14, "{}", cones[i]);
                    let nearest = curve.project(&q.yz(), q.x);
                    prop_assert!((others[i].yz() - nearest).norm() < 1e-14, "{}", others[i]);
                    prop_assert!((others[i].x - curve.dissipation(&q.yz())).abs() < 1e-14);
                }
            }
        }
    }
}
