//! Fibres that touch: the coupling of implicit rods with nonsmooth contact.
//!
//! Impulses of contacts act through the rods' own implicit step. A step is solved by Newton's
//! method, and every iteration solves all contacts together with the linearised rods:
//!
//! 1. the step sets out to where the motion leads, with the impulses of the step before;
//! 2. touches are found where that would lead, as well as on the way there (`detect`, `passing`). A touch
//!    that has changed sides beside one of its pair that has not is none;
//! 3. the rods are linearised where they are, all impulses are solved for (`case`) as well as that
//!    is of use (`effort`), and the rods take the increment that belongs to them;
//! 4. 3 repeats, with places and normals of the contacts kept, until rods and law agree, or until it is
//!    seen that others are missing;
//! 5. touches are looked for where the fibres really are. Those that are too deep replace or join
//!    the list, and 3 to 5 repeat.
//!
//! Normals are those of where the list was made: in the end, weighted with impulses, off by a hundredth of
//! a radian where hair strikes, and by a third of that at rest. Gaps are looked at where fibres are.
//!
//! Only contacts that bear something or would close are solved for: others would hold the solver
//! back. After some lists none is dropped any more, so that no two take turns for ever. Of long lists
//! most are not even looked at: they open faster than anything near them has changed (`case::openings`).
//!
//! Solving contacts within Newton's method, not around it, is what makes violent steps converge: a
//! rod that buckles under given forces is held by the very contacts that press it. A step that does
//! not end so is taken in halves (`stepper`).
//!
//! Objects are led on a way of their own or move freely (`free`): then they are bodies of the solver
//! as the fibres are, and touch other objects too (`pair`).
//!
//! Contacts act on the axes of fibres: friction does not spin them.

mod body;
mod case;
mod cut;
mod detect;
mod effort;
mod explicit;
mod fiber_touch;
mod film;
mod gather;
mod in_contact;
mod law;
mod leaps;
mod memory;
mod part;
mod passing;
mod report;
mod start;
mod stepper;
mod system;
mod times;
mod velocities;
mod work;

pub use in_contact::FibersInContact;
pub use memory::Bearing;
pub use report::{ContactReport, Unresolved};
pub use times::{ContactTimes, Stopwatch};
pub use work::ContactWork;
