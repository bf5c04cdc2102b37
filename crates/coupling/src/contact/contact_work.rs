use std::ops::AddAssign;

/// Work that contacts have done on fibres and free objects, J: impulses times the mean velocities
/// of the steps in which they acted, which backward Euler ends with. A rebound so does work, and
/// the integrator takes more than that: half the mass times the squared change of velocity.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContactWork {
    /// Work of friction against the slip, J; not positive but for the solver's tolerance.
    pub friction: f64,
    /// Work of what stops those that come together, J, as far as the gap lets them: not positive
    /// but for the solver's tolerance.
    pub closing: f64,
    /// Work, J, of what drives apart those that were in each other when the step began, and of
    /// joints that close.
    pub repair: f64,
    /// Work, J, of what lets those that meet rebound.
    pub restitution: f64,
    /// Work, J, of what holds together those that would part.
    pub adhesion: f64,
    /// Work, J, of what gives way under pressure and friction. It takes what it holds, and what
    /// backward Euler damps of it: it is not positive.
    pub compliance: f64,
    /// Work, J, of objects with a given motion: all of their impulses times the velocities of their
    /// surfaces.
    pub kinematic: f64,
}

impl ContactWork {
    /// The sum.
    #[must_use]
    pub fn total(&self) -> f64 {
        let along = self.closing + self.repair + self.restitution + self.adhesion;
        self.friction + along + self.compliance + self.kinematic
    }
}

impl ContactWork {
    /// All works, J, in the order of the fields.
    pub(crate) fn numbers(&self) -> [f64; 7] {
        let Self { friction, closing, repair, restitution, adhesion, compliance, kinematic } =
            *self;
        [friction, closing, repair, restitution, adhesion, compliance, kinematic]
    }

    /// The work with these parts, J, in the order of the fields.
    pub(crate) fn from_numbers(numbers: &[f64; 7]) -> Self {
        let [friction, closing, repair, restitution, adhesion, compliance, kinematic] = *numbers;
        Self { friction, closing, repair, restitution, adhesion, compliance, kinematic }
    }
}

impl AddAssign for ContactWork {
    fn add_assign(&mut self, other: Self) {
        self.friction += other.friction;
        self.closing += other.closing;
        self.repair += other.repair;
        self.restitution += other.restitution;
        self.adhesion += other.adhesion;
        self.compliance += other.compliance;
        self.kinematic += other.kinematic;
    }
}
