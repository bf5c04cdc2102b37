use crate::Load;
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

/// What holds one freedom of a supported end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Restraint {
    /// Nothing: only loads act.
    Free,
    /// A linear spring of this stiffness, N/m along an axis and N m/rad about one.
    Sprung(f64),
    /// It is prescribed.
    Held,
}

impl Restraint {
    /// Stiffness of the spring, zero without one.
    #[must_use]
    pub fn stiffness(&self) -> f64 {
        if let Self::Sprung(stiffness) = self { *stiffness } else { 0.0 }
    }
}

/// A support that holds each of the six freedoms of an end by itself.
///
/// Freedoms are the coordinates of the end's displacement from `pose`, and of the rotation vector
/// from the frame of `pose` to that of the end, along `axes`. With one free rotation it is a hinge,
/// with one free translation a slider, and with springs an elastic support. Springs are part of the
/// support: their work is the support's. A rotation that a spring resists must stay below half a
/// turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndSupport {
    /// The pose that held freedoms have and that springs pull to, world.
    pub pose: Isometry3<f64>,
    /// The three axes: the rotation that takes the world's axes to them.
    pub axes: UnitQuaternion<f64>,
    /// Displacements along the axes.
    pub translations: [Restraint; 3],
    /// Rotations about the axes.
    pub rotations: [Restraint; 3],
    /// Force on the rod, N, along translations that are not held.
    pub force: Load,
    /// Moment on the rod, N m, about rotations that are not held.
    pub moment: Load,
}

/// How three freedoms together are held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Restraints {
    Free,
    Held,
    /// Some of them are sprung, or held beside others that are not.
    Mixed,
}

impl Restraints {
    pub(crate) fn of(three: &[Restraint; 3]) -> Self {
        if three.iter().all(|one| *one == Restraint::Held) {
            Self::Held
        } else if three.iter().all(|one| *one == Restraint::Free) {
            Self::Free
        } else {
            Self::Mixed
        }
    }
}

impl EndSupport {
    /// Of the whole force (N) and moment (N m) on an end, world, what is not its load; the material
    /// frame of the end is `frame`. The moment is zero where all rotations are free.
    #[must_use]
    pub fn reaction(
        &self,
        [force, moment]: [Vector3<f64>; 2],
        frame: &Rotation3<f64>,
    ) -> [Vector3<f64>; 2] {
        let world = |load: &Load| match load {
            Load::World(v) => *v,
            Load::Follower(v) => frame * v,
        };
        let open = Matrix3::identity() - self.held();
        let force = force - open * world(&self.force);
        match Restraints::of(&self.rotations) {
            Restraints::Free => [force, Vector3::zeros()],
            Restraints::Held => [force, moment],
            Restraints::Mixed => [force, moment - world(&self.moment)],
        }
    }

    /// The sum of `a a^T` over the axes `a` of those translations that `which` names.
    pub(crate) fn along(&self, which: impl Fn(&Restraint) -> f64) -> Matrix3<f64> {
        let axes = self.axes.to_rotation_matrix();
        let shares = Vector3::from(self.translations.map(|one| which(&one)));
        axes.matrix() * Matrix3::from_diagonal(&shares) * axes.matrix().transpose()
    }

    /// Projector on the directions of translations that are held.
    pub(crate) fn held(&self) -> Matrix3<f64> {
        self.along(|one| f64::from(*one == Restraint::Held))
    }

    /// The frame of the support that is nearest to `frame`: with the held rotations at zero.
    pub(crate) fn nearest(&self, frame: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        let away = (frame * self.pose.rotation.inverse()).scaled_axis();
        let mut along = self.axes.inverse_transform_vector(&away);
        for (x, restraint) in along.iter_mut().zip(&self.rotations) {
            if *restraint == Restraint::Held {
                *x = 0.0;
            }
        }
        UnitQuaternion::from_scaled_axis(self.axes * along) * self.pose.rotation
    }

    /// Whether all numbers are finite and no stiffness is negative.
    pub(crate) fn is_sound(&self) -> bool {
        let stiff = |one: &Restraint| one.stiffness() >= 0.0 && one.stiffness().is_finite();
        let loads = self.force.components().iter().chain(self.moment.components());
        let place = self.pose.translation.vector.iter().chain(&self.pose.rotation.coords);
        self.translations.iter().chain(&self.rotations).all(stiff)
            && loads.chain(place).chain(&self.axes.coords).all(|x| x.is_finite())
    }
}
