//! What a contact point obeys, by the scene, its partner and what it did when the step began.

use super::adhesive_film::AdhesiveFilm;
use crate::body_ref::BodyRef;
use crate::contact_point::ContactPoint;
use crate::object::CollisionObject;
use nalgebra::Vector3;
use rapunzel_contact::{Bond, ContactError, LimitCurve, closing};
use rapunzel_fiber::Assembly;
use rapunzel_scene::{Adhesion, ContactSettings, FrictionLaw};

/// The laws of contact in one part of a step.
pub(super) struct ContactLaws<'a> {
    settings: &'a ContactSettings,
    film: Option<&'a AdhesiveFilm>,
    objects: &'a [CollisionObject],
    /// What gravity adds to a velocity in the part, m/s.
    fall: f64,
    /// Length of the part, s.
    dt: f64,
}

impl<'a> ContactLaws<'a> {
    /// Laws of contact in a substep of `dt` seconds under `gravity`, m/s^2.
    pub(super) fn new(
        settings: &'a ContactSettings,
        film: Option<&'a AdhesiveFilm>,
        objects: &'a [CollisionObject],
        gravity: f64,
        dt: f64,
    ) -> Self {
        Self { settings, film, objects, fall: gravity * dt, dt }
    }

    /// Largest slip of a contact that sticks, m/s.
    pub(super) fn slip(&self) -> f64 {
        self.settings.slip
    }

    /// Whether any law is by the velocities at the start of the part.
    pub(super) fn look_back(&self) -> bool {
        let rests = |friction: &FrictionLaw| matches!(friction, FrictionLaw::Resting { .. });
        let own = |object: &CollisionObject| {
            object.friction.as_ref().is_some_and(rests)
                || object.restitution.is_some_and(|restitution| restitution > 0.0)
        };
        let ContactSettings { restitution, friction, .. } = self.settings;
        *restitution > 0.0 || rests(friction) || self.objects.iter().any(own)
    }

    /// By how much more slowly two that touch come together for an impulse between them, 1/kg.
    pub(super) fn compliance(&self) -> f64 {
        self.settings.compliance / (self.dt * self.dt)
    }

    /// [`closing`] of a contact point in the part. `gap` is that at the start over the length of
    /// the part, `before` tells the relative velocity then, in the frame of the contact point.
    pub(super) fn closing(
        &self,
        point: &ContactPoint,
        gap: f64,
        before: impl Fn() -> Vector3<f64>,
    ) -> f64 {
        let own = self.own(point, |object| object.restitution);
        let restitution = own.unwrap_or(self.settings.restitution);
        closing(gap, restitution, self.fall, || before().x)
    }

    /// The limit curve of a contact point whose relative velocity at the start of the part, m/s, in
    /// its frame, `before` tells. Backward Euler ends with its mean velocity: the slip at the start
    /// is that of the part before.
    pub(super) fn friction(
        &self,
        point: &ContactPoint,
        before: impl Fn() -> Vector3<f64>,
    ) -> Result<LimitCurve, ContactError> {
        let between_objects = matches!(point.sides[0], BodyRef::Object(_));
        let own = self.own(point, |object| {
            object.friction.filter(|friction| !(between_objects && friction.needs_axis()))
        });
        let sticks = || before().yz().norm() <= self.settings.slip;
        limit_curve(&own.unwrap_or(self.settings.friction), point, sticks)
    }

    /// Tensile impulses that contact points bear, N s; `gaps` are those at the start, as in
    /// [`Self::closing`]. Sorted by pair and place; none where nothing pulls.
    pub(super) fn adhesion(
        &self,
        assembly: &Assembly,
        points: &[ContactPoint],
        gaps: impl Iterator<Item = f64>,
    ) -> Result<Vec<f64>, ContactError> {
        if let Some(bonds) = self.settings.adhesion.and_then(Adhesion::bonds) {
            let bears = Bond::new(bonds.strength)?.adhesion(self.dt);
            return Ok(points.iter().map(|t| if t.bonded { bears } else { 0.0 }).collect());
        }
        let Some(film) = self.film else { return Ok(Vec::new()) };
        let gaps: Vec<_> = gaps.map(|gap| gap * self.dt).collect();
        let forces = film.forces(assembly, points, &gaps);
        Ok(forces.into_iter().map(|force| force * self.dt).collect())
    }

    /// What an object says of its own, the second side before the first.
    fn own<T>(
        &self,
        point: &ContactPoint,
        of: impl Fn(&CollisionObject) -> Option<T>,
    ) -> Option<T> {
        point.sides.iter().rev().find_map(|side| match side {
            BodyRef::Object(object) => of(&self.objects[*object as usize]),
            BodyRef::Fiber(_) => None,
        })
    }
}

/// The limit curve of a contact point, which `sticks` or slides. Of two fibres that touch, both
/// have this friction, each by its own axis; with an object the axis is the fibre's.
fn limit_curve(
    friction: &FrictionLaw,
    point: &ContactPoint,
    sticks: impl Fn() -> bool,
) -> Result<LimitCurve, ContactError> {
    match *friction {
        FrictionLaw::Isotropic(mu) => Ok(LimitCurve::Circle { mu }),
        FrictionLaw::Keratin { on, wetness } => match on.friction(wetness) {
            Ok(mu) => Ok(LimitCurve::Circle { mu }),
            Err(_) => Err(ContactError::Invalid {
                what: "the coefficient of friction",
                value: f64::NAN,
                why: "the table has none for this surface, dry; the scene must not ask for it",
            }),
        },
        FrictionLaw::Resting { resting, sliding } => {
            Ok(LimitCurve::Circle { mu: if sticks() { resting } else { sliding } })
        }
        FrictionLaw::Cuticle { with, against, across } => {
            let curve = LimitCurve::cuticle(with, against, across);
            match point.sides[1] {
                BodyRef::Object(_) => Ok(curve),
                BodyRef::Fiber(_) => LimitCurve::between(&curve, &curve, point.turn()),
            }
        }
    }
}
