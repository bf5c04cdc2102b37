//! As many contacts at once as a register holds.
//!
//! A projection onto a circle or its cone is a root, a quotient and a choice; one after another these wait
//! for each other. Other curves are projected onto one by one.

use super::shared::Shared;
use crate::{Contact, LimitCurve};
use nalgebra::Vector3;
use pulp::Simd;
use rapunzel_lanes::{LANES, Lane};
use std::array::from_fn;
use std::ops::Range;

type Numbers = [f64; LANES];

/// A vector of each contact of a group, by component.
pub(super) type Eight = [Numbers; 3];

/// Those of a register.
pub(super) type Vectors<S> = [Lane<S>; 3];

/// What it takes to solve eight contacts. Lanes that are left are of contacts that bear nothing and stay so.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(super) struct Group {
    /// Normals and first tangents, by component. To find the second anew is less than to read it.
    axes: [Eight; 2],
    /// Relative velocities, bias included, and impulses that were given, in the frames.
    velocities: Eight,
    pub(super) impulses: Eight,
    /// Answers to their own impulses in the metric, 1/kg.
    responses: Numbers,
    /// Of what is wrong with velocities in reports, kg.
    weights: Numbers,
    pub(super) points: Places,
    pub(super) sides: Places,
    /// Coefficients of friction, if for all of them they are the same in all directions.
    circles: Option<Numbers>,
    /// Adhesion and compliance, if any has some.
    soft: Option<Box<[Numbers; 2]>>,
}

/// Where something of the first side of each contact is, and of the second.
pub(super) type Places = [[u32; LANES]; 2];

impl Group {
    /// At most eight contacts with the relative velocities of their sides, m/s, world, and impulses, N s, in their
    /// frames, that were given; responses, 1/kg, and weights, kg.
    pub(super) fn new(
        contacts: &[Contact],
        velocities: impl Iterator<Item = Vector3<f64>>,
        impulses: &[Vector3<f64>],
        responses: impl Iterator<Item = f64>,
        weights: impl Iterator<Item = f64>,
        [points, sides]: [Places; 2],
    ) -> Self {
        let mut group = Self {
            axes: Default::default(),
            velocities: Default::default(),
            impulses: Default::default(),
            soft: None,
            responses: [1.0; LANES],
            weights: [1.0; LANES],
            circles: Some(Default::default()),
            points,
            sides,
        };
        let given = velocities.zip(impulses);
        let own = responses.zip(weights);
        for (lane, ((contact, given), own)) in contacts.iter().zip(given).zip(own).enumerate() {
            let velocity = contact.frame.tr_mul(&given.0) + contact.bias;
            for k in 0..3 {
                for i in 0..2 {
                    group.axes[i][k][lane] = contact.frame[(k, i)];
                }
                (group.velocities[k][lane], group.impulses[k][lane]) = (velocity[k], given.1[k]);
            }
            if contact.adhesion != 0.0 || contact.compliance != 0.0 {
                let [adhesion, compliance] = &mut **group.soft.get_or_insert_default();
                (adhesion[lane], compliance[lane]) = (contact.adhesion, contact.compliance);
            }
            (group.responses[lane], group.weights[lane]) = own;
            match (&mut group.circles, &contact.friction) {
                (Some(circles), LimitCurve::Circle { mu }) => circles[lane] = *mu,
                (circles, _) => *circles = None,
            }
        }
        group
    }
}

/// Those of a group that share a register.
#[derive(Clone, Copy)]
pub(super) struct Wide<'a, S: Simd> {
    simd: S,
    pub(super) group: &'a Group,
    contacts: &'a [Contact],
    /// Which group, and which register of it.
    pub(super) number: usize,
    register: usize,
    /// The first, and how many there are.
    first: usize,
    count: usize,
}

impl<'a, S: Simd> Wide<'a, S> {
    /// How many registers so many contacts fill.
    #[inline(always)]
    pub(super) fn registers(contacts: usize) -> usize {
        contacts.div_ceil(S::F64_LANES)
    }

    /// Those of some contacts and their groups that share this register of all.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        groups: &'a [Group],
        contacts: &'a [Contact],
        register: usize,
    ) -> Self {
        let in_group = LANES / S::F64_LANES;
        let (number, first) = (register / in_group, register * S::F64_LANES);
        let (group, register) = (&groups[number], register % in_group);
        let count = (contacts.len() - first).min(S::F64_LANES);
        Self { simd, group, contacts, number, register, first, count }
    }

    /// Which contacts these are.
    #[inline(always)]
    pub(super) fn range(&self) -> Range<usize> {
        self.first..self.first + self.count
    }

    #[inline(always)]
    fn lane(&self, numbers: &Numbers) -> Lane<S> {
        Lane::load(self.simd, numbers, self.register)
    }

    #[inline(always)]
    pub(super) fn splat(&self, x: f64) -> Lane<S> {
        Lane::splat(self.simd, x)
    }

    #[inline(always)]
    pub(super) fn adhesion(&self) -> Lane<S> {
        self.group.soft.as_ref().map_or(self.splat(0.0), |soft| self.lane(&soft[0]))
    }

    #[inline(always)]
    pub(super) fn compliance(&self) -> Lane<S> {
        self.group.soft.as_ref().map_or(self.splat(0.0), |soft| self.lane(&soft[1]))
    }

    #[inline(always)]
    pub(super) fn weights(&self) -> Lane<S> {
        self.lane(&self.group.weights)
    }

    #[inline(always)]
    pub(super) fn responses(&self) -> Lane<S> {
        self.lane(&self.group.responses)
    }

    /// Those of this register.
    #[inline(always)]
    pub(super) fn load(&self, [x, y, z]: &Eight) -> Vectors<S> {
        [self.lane(x), self.lane(y), self.lane(z)]
    }

    /// Puts vectors where [`Self::load`] finds them.
    #[inline(always)]
    pub(super) fn store(&self, vectors: Vectors<S>, into: &mut Eight) {
        vectors.into_iter().zip(into).for_each(|(x, into)| x.store(into, self.register));
    }

    /// Vectors one after another, side by side.
    #[inline(always)]
    fn pack(&self, vectors: &[Vector3<f64>; LANES]) -> Vectors<S> {
        let mut numbers = [[0.0; LANES]; 3];
        for (lane, vector) in vectors.iter().take(S::F64_LANES).enumerate() {
            for k in 0..3 {
                numbers[k][lane] = vector[k];
            }
        }
        let [x, y, z] = &numbers;
        [Lane::load(self.simd, x, 0), Lane::load(self.simd, y, 0), Lane::load(self.simd, z, 0)]
    }

    /// Vectors side by side, one after another.
    #[inline(always)]
    pub(super) fn unpack(&self, vectors: Vectors<S>) -> [Vector3<f64>; LANES] {
        let mut numbers = [[0.0; LANES]; 3];
        for k in 0..3 {
            vectors[k].store(&mut numbers[k], 0);
        }
        let [x, y, z] = numbers;
        from_fn(|lane| Vector3::new(x[lane], y[lane], z[lane]))
    }

    /// The impulses that were given.
    #[inline(always)]
    pub(super) fn given(&self) -> Vectors<S> {
        self.load(&self.group.impulses)
    }

    /// The relative velocities, bias included, where those at the places have changed so from what was given.
    #[inline(always)]
    pub(super) fn relative(&self, changes: &Shared, places: &Places) -> Vectors<S> {
        let from = self.register * S::F64_LANES;
        let mut between = [Vector3::zeros(); LANES];
        for lane in 0..S::F64_LANES {
            let [first, second] = [places[0][from + lane], places[1][from + lane]];
            between[lane] = changes.get(first as usize) - changes.get(second as usize);
        }
        let [x, y, z] = self.pack(&between);
        let (frame, mut relative) = (self.frame(), [self.splat(0.0); 3]);
        for i in 0..3 {
            let [a, b, c] = frame[i];
            relative[i] = a * x + b * y + c * z + self.lane(&self.group.velocities[i]);
        }
        relative
    }

    /// Normals and both tangents.
    #[inline(always)]
    fn frame(&self) -> [Vectors<S>; 3] {
        let [[a, b, c], [x, y, z]] = [0, 1].map(|axis| self.load(&self.group.axes[axis]));
        [[a, b, c], [x, y, z], [b * z - c * y, c * x - a * z, a * y - b * x]]
    }

    /// Out of the frames.
    #[inline(always)]
    pub(super) fn world(&self, [n, s, t]: Vectors<S>) -> Vectors<S> {
        let [a, b, c] = self.frame();
        let mut world = [self.splat(0.0); 3];
        for k in 0..3 {
            world[k] = a[k] * n + b[k] * s + c[k] * t;
        }
        world
    }

    /// [`LimitCurve::dissipation`].
    #[inline(always)]
    pub(super) fn dissipation(&self, [s, t]: [Lane<S>; 2]) -> Lane<S> {
        if let Some(circles) = &self.group.circles {
            return self.lane(circles) * norm([s, t]);
        }
        let mut all = self.unpack([s, t, s]);
        for (found, contact) in all.iter_mut().zip(&self.contacts[self.range()]) {
            found.z = contact.friction.dissipation(&found.xy());
        }
        let [_, _, power] = self.pack(&all);
        power
    }

    /// [`LimitCurve::project`].
    #[inline(always)]
    pub(super) fn project(&self, [s, t]: [Lane<S>; 2], scale: Lane<S>) -> [Lane<S>; 2] {
        if let Some(circles) = &self.group.circles {
            let (zero, one) = (self.splat(0.0), self.splat(1.0));
            let (radius, size) = (self.lane(circles) * scale, norm([s, t]));
            let share = size.less_or_equal(radius).select(one, radius / size);
            let share = scale.less_or_equal(zero).select(zero, share);
            return [s * share, t * share];
        }
        let mut all = self.unpack([s, t, scale]);
        for (found, contact) in all.iter_mut().zip(&self.contacts[self.range()]) {
            let nearest = contact.friction.project(&found.xy(), found.z);
            (found.x, found.y) = (nearest.x, nearest.y);
        }
        let [s, t, _] = self.pack(&all);
        [s, t]
    }

    /// [`LimitCurve::project_cone`].
    #[inline(always)]
    pub(super) fn project_cone(&self, [n, s, t]: Vectors<S>) -> Vectors<S> {
        if let Some(circles) = &self.group.circles {
            let (zero, one, mu) = (self.splat(0.0), self.splat(1.0), self.lane(circles));
            let size = norm([s, t]);
            let (inside, outer) = (mu * n, n + mu * size);
            let normal = outer / (one + mu * mu);
            let share = size.less_or_equal(inside).select(one, mu * normal / size);
            let normal = size.less_or_equal(inside).select(n, normal);
            return [
                outer.less_or_equal(zero).select(zero, normal),
                outer.less_or_equal(zero).select(zero, s * share),
                outer.less_or_equal(zero).select(zero, t * share),
            ];
        }
        let mut all = self.unpack([n, s, t]);
        for (found, contact) in all.iter_mut().zip(&self.contacts[self.range()]) {
            *found = contact.friction.project_cone(found);
        }
        self.pack(&all)
    }
}

#[inline(always)]
pub(super) fn norm<S: Simd>([s, t]: [Lane<S>; 2]) -> Lane<S> {
    (s * s + t * t).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Polygon;
    use proptest::prelude::*;
    use pulp::{Arch, Scalar, WithSimd};
    use std::iter::repeat;

    /// What eight vectors become: projected onto cones, onto curves as large as the first number, and what
    /// is dissipated.
    struct All<'a>(&'a [Group], &'a [Contact], &'a [Vector3<f64>]);

    impl WithSimd for All<'_> {
        type Output = [Vec<Vector3<f64>>; 2];

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let Self(groups, contacts, q) = self;
            let mut found = [q.to_vec(), q.to_vec()];
            for register in 0..Wide::<S>::registers(contacts.len()) {
                let wide = Wide::new(simd, groups, contacts, register);
                let own = &q[wide.range()];
                let [n, s, t] = wide.pack(&from_fn(|i| own.get(i).copied().unwrap_or_default()));
                let cone = wide.unpack(wide.project_cone([n, s, t]));
                let power = wide.dissipation([s, t]);
                let [s, t] = wide.project([s, t], n);
                let others = wide.unpack([power, s, t]);
                for (found, all) in found.iter_mut().zip([cone, others]) {
                    found[wide.range()].copy_from_slice(&all[..own.len()]);
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
        /// Whatever the curves, and one by one or in registers, contacts are projected as each would be.
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
                    Group::new(some, zeros, &given, ones.clone(), ones, Default::default())
                })
                .collect();
            let both = [
                Arch::new().dispatch(All(&groups, &contacts, &q)),
                Scalar::new().vectorize(All(&groups, &contacts, &q)),
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
