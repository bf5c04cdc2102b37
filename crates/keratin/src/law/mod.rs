//! Constitutive laws beyond linear elasticity (thesis 2.4.1.2, 2.4.2, 2.4.4, 2.4.6).
//!
//! [`Relaxation`] and [`Creep`] are the functions of linear viscoelasticity, [`Viscoelastic`] the
//! law of a section (or of a strain in one dimension) that has them; [`Aging`] lets them change
//! with the age of the material and [`ThreeElement`] with the climate, which is how a water wave
//! holds; [`Tension`] yields; [`Breuer`] is the force of a network that melts.

mod aging;
mod breuer;
mod creep;
mod relaxation;
mod tension;
mod three_element;
mod viscoelastic;

pub use aging::Aging;
pub use breuer::Breuer;
pub use creep::Creep;
pub use relaxation::{MaxwellElement, Relaxation};
pub use tension::Tension;
pub use three_element::{ThreeElement, transitions};
pub use viscoelastic::{MaxwellModel, RelaxationStep, Viscoelastic};
