use nalgebra::{Matrix3, Rotation3, Vector3};
use rapunzel_rod_static::State;
use serde::Serialize;

/// What is found of a case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseAnswer {
    /// The title of the case.
    pub name: String,
    /// Length of the rod, m: that of the case, or that which was wished for.
    pub length: f64,
    /// Radius of the rod where it is thickest, m.
    pub radius: f64,
    /// How the length was found, if that was asked.
    pub wish: Option<Length>,
    /// The equilibria along the way of a parameter, if one was swept or its critical value asked
    /// for.
    pub branch: Option<CaseBranch>,
    /// The equilibria in the order of their energies: one that is stable, or all that were found;
    /// of a sweep those along its way that are shown, of a critical value the one at it; of rods
    /// in contact each rod in the order of the case, its own first.
    pub equilibria: Vec<CaseEquilibrium>,
    /// What pushes where, if the rod touches something.
    pub contact: Option<CaseContact>,
}

impl CaseAnswer {
    /// Whether one of the equilibria is stable, or following forces leave that open.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.equilibria.iter().any(|found| !matches!(found.stability, Stability::Unstable(_)))
    }
}

/// The answer to "how long must it be".
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Length {
    /// The shortest length that does what is wished, m.
    pub length: f64,
    /// What the rod of that length does, in the unit of the wish.
    pub reached: f64,
}

/// One equilibrium.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseEquilibrium {
    /// Whether a small push brings it away.
    pub stability: Stability,
    /// Elastic energy, J.
    pub elastic_energy: f64,
    /// Potential energy of the dead loads from the world's origin, J.
    pub load_energy: f64,
    /// What the clamp carries: the force of the rod on it, N, world frame.
    pub clamp_force: [f64; 3],
    /// The moment of the rod on it, N m, world frame.
    pub clamp_moment: [f64; 3],
    /// What holds the far end: its force on the rod, N, world frame.
    pub end_force: [f64; 3],
    /// Moment of the support on the rod, N m, world frame.
    pub end_moment: [f64; 3],
    /// Forces on the rod at the places on the way, N, world frame.
    pub place_forces: Vec<[f64; 3]>,
    /// Where it bends most.
    pub sharpest: Peak,
    /// How far it hangs, along gravity, below the lower one of its ends, m.
    pub sag: f64,
    /// The rod from the clamp to the end.
    pub stations: Vec<Station>,
}

/// Whether an equilibrium is a minimum of the energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Stability {
    /// The equilibrium is stable.
    Stable,
    /// The equilibrium is unstable; so many independent ways lead down.
    Unstable(usize),
    /// Not told: forces that follow the rod have no energy.
    Unknown,
}

/// The sharpest bend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Peak {
    /// Arc length from the clamp, m.
    pub at: f64,
    /// Curvature of the center line, 1/m.
    pub curvature: f64,
}

/// The rod at one arc length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Station {
    /// Arc length from the clamp, m.
    pub s: f64,
    /// Position, m, world frame.
    pub position: [f64; 3],
    /// Material frame: d1, d2 and the tangent d3, world frame.
    pub frame: [[f64; 3]; 3],
    /// Force of the part beyond on the part before, N, world frame.
    pub force: [f64; 3],
    /// Moment of the part beyond on the part before, N m, world frame.
    pub moment: [f64; 3],
    /// Darboux vector in the material frame, 1/m.
    pub curvature: [f64; 3],
}

/// The equilibria along the way of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseBranch {
    /// Unit of the parameter, `m` or `degrees`; nothing for a factor.
    pub unit: &'static str,
    /// The equilibria in the order in which they are met.
    pub points: Vec<BranchRow>,
    /// Points where the stability changes, in the same order.
    pub limits: Vec<CaseLimit>,
    /// Why the way ends.
    pub ended: Ended,
    /// Index of the first point of the other branch, if the way goes over to one at a bifurcation.
    pub switched: Option<usize>,
    /// Indices among the points of those that are given as shapes.
    pub shown: Vec<usize>,
}

/// Why a way of equilibria ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Ended {
    /// It has reached the end of the range.
    Reached,
    /// Past a fold it has come back to the start of the range.
    Returned,
    /// It has lost its stability, where that was asked for.
    Lost,
    /// It was followed for twenty times the steps that were asked for.
    Long,
    /// No equilibrium was found beyond.
    Stuck,
}

/// An equilibrium at a value of the parameter, in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BranchRow {
    /// Value of the parameter, in its unit.
    pub parameter: f64,
    /// Number of independent ways that lead down; none for a stable equilibrium.
    pub ways_down: usize,
    /// Elastic energy, J.
    pub elastic_energy: f64,
    /// Potential energy of the dead loads, J.
    pub load_energy: f64,
    /// What the clamp carries: the force of the rod on it, N, world frame.
    pub clamp_force: [f64; 3],
    /// The moment of the rod on it, N m, world frame.
    pub clamp_moment: [f64; 3],
    /// What acts on the far end: force, N, world frame.
    pub end_force: [f64; 3],
    /// Moment on the far end, N m, world frame.
    pub end_moment: [f64; 3],
    /// Position of the far end, m.
    pub end_position: [f64; 3],
}

/// A point where the stability changes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseLimit {
    /// Whether the parameter turns back there (a limit load); else other equilibria branch off.
    pub is_fold: bool,
    /// Value of the parameter, in its unit.
    pub parameter: f64,
    /// Numbers of ways that lead down before and behind it.
    pub ways_down: [usize; 2],
    /// The equilibrium there.
    pub equilibrium: CaseEquilibrium,
    /// The variation in which it is neutral, at the stations of the equilibrium.
    pub mode: Vec<ModeStation>,
}

/// A mode at one arc length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ModeStation {
    /// Arc length from the clamp, m.
    pub s: f64,
    /// Displacement, world frame; the largest along the rod is 1 in size, or, where nothing is
    /// displaced, the largest rotation.
    pub displacement: [f64; 3],
    /// Rotation vector, world frame, for that displacement in m: rad.
    pub rotation: [f64; 3],
}

impl Station {
    /// The state there.
    pub(super) fn state(&self) -> State {
        let axes = Matrix3::from_columns(&self.frame.map(Vector3::from));
        State {
            position: self.position.into(),
            frame: Rotation3::from_matrix_unchecked(axes),
            force: self.force.into(),
            moment: self.moment.into(),
        }
    }
}

/// The contacts of rods at rest, and how well what they obey holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CaseContact {
    /// Every contact that pushes.
    pub touches: Vec<CaseTouch>,
    /// How deep something is in something else, m, at most: no gap is less than minus this.
    pub penetration: f64,
    /// The largest product of a force and its gap, N m.
    pub slackness: f64,
    /// The largest moment on a node of a rod that nothing balances, N m.
    pub unbalanced: f64,
    /// Number of steps of Newton's method.
    pub iterations: usize,
}

/// A contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CaseTouch {
    /// Index of the rod: 0 for that of the case, and on from 1 in the order of its `rods`.
    pub rod: usize,
    /// Arc length along it from its root, m.
    pub at: f64,
    /// What pushes it.
    pub by: TouchedBy,
    /// Place between the two surfaces, m.
    pub position: [f64; 3],
    /// Direction in which the rod is pushed.
    pub normal: [f64; 3],
    /// Distance of the surfaces, m; below zero by rounding and by what the method leaves.
    pub gap: f64,
    /// Force, N; never below zero.
    pub force: f64,
}

/// What pushes a rod.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum TouchedBy {
    /// An object, by its index among `objects`.
    Object(usize),
    /// A rod, by its index, at this arc length, m.
    Rod(usize, f64),
}
