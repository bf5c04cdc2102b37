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
    /// The equilibria in the order of their energies: one that is stable, or all that were found.
    pub equilibria: Vec<CaseEquilibrium>,
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
