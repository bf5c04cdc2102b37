//! What is told of a limit of stability.

use crate::equilibrium::Equilibrium;
use crate::shooting::Variation;
use nalgebra::Vector3;

/// Kind of a point where the stability changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// The branch turns back in the parameter: a limit load.
    Fold,
    /// Another branch crosses it.
    Bifurcation,
}

/// A point of a branch where the number of directions of falling energy changes.
#[derive(Debug, Clone)]
pub struct LimitPoint {
    /// What happens there.
    pub kind: LimitKind,
    /// Value of the parameter there.
    pub parameter: f64,
    /// Numbers of points conjugate to the end before and after it.
    pub conjugate_points: [usize; 2],
    /// The equilibrium there, with its mode.
    pub mode: LimitMode,
}

/// An equilibrium at a limit of its stability, and the variation in which it is neutral.
#[derive(Debug, Clone)]
pub struct LimitMode {
    pub(crate) equilibrium: Equilibrium,
    pub(crate) variations: Vec<Variation>,
}

impl LimitMode {
    /// The equilibrium.
    #[must_use]
    pub fn equilibrium(&self) -> &Equilibrium {
        &self.equilibrium
    }

    /// Displacement (m) of the point at arc length `s` (m), and its rotation vector (rad), both in
    /// the world frame, at one scale for the whole rod.
    #[must_use]
    pub fn at(&self, s: f64) -> [Vector3<f64>; 2] {
        let length = self.equilibrium.rod.length;
        let change = self.equilibrium.varied(&self.variations, s / length);
        let part = |row: usize| change.fixed_rows::<3>(row).into_owned();
        [part(0) * length, part(3)]
    }
}
