//! Fibres that touch: the coupling of implicit rods with nonsmooth contact.
//!
//! Impulses of contacts act through the rods' own implicit step. A step is solved by Newton's
//! method, and every iteration solves all contacts together with the linearised rods:
//!
//! 1. the step sets out to where the motion leads, with the impulses of the step before;
//! 2. contact points are found where that would lead, as well as on the way there (`detection`,
//!    `object_detector`, `tunnelling`). A contact point that has changed sides beside one of its
//!    pair that has not is none. Fibres that flew and have contact points set out anew, as those
//!    that bear (`flight`), and theirs are found again;
//! 3. the rods are linearised where they are, all impulses are solved for (`problem`) as well as
//!    that is of use (`forcing_term`), and the rods take the increment that belongs to them. Rods
//!    that have hardly turned since they were linearised are not again (`substep`);
//! 4. 3 repeats, with places and normals of the contacts kept, until rods and law agree, or until
//!    it is seen that others are missing;
//! 5. contact points are looked for where the fibres really are. Those that are too deep replace or
//!    join the list, and 3 to 5 repeat.
//!
//! Normals are those of where the list was made: in the end, weighted with impulses, off by a
//! hundredth of a radian where hair strikes, and by a third of that at rest. Gaps are looked at
//! where fibres are.
//!
//! Only contacts that bear something or would close are solved for: others would hold the solver
//! back. After some lists none is dropped any more, so that no two take turns for ever. Of long
//! lists most are not even looked at: they open faster than anything near them has changed
//! (`problem::culling`).
//!
//! Solving contacts within Newton's method, not around it, is what makes violent steps converge: a
//! rod that buckles under given forces is held by the very contacts that press it. A step that does
//! not end so is taken in halves (`stepper`).
//!
//! Objects are kinematic (they follow a given motion) or move freely (`free_body`): then they are
//! bodies of the solver as the fibres are, and touch other objects too (`pair`).
//!
//! Where fibres rest on objects, contacts stay where they are (`crate::held_places`), and what
//! slips there against the law goes back in later steps: what friction holds does not creep.
//!
//! Contacts act at the surfaces of fibres: an impulse has a moment about the axis, and the slip is
//! that of surfaces, spin included. A fibre without a clamp, which nothing keeps from spinning, is
//! touched on its axis: it would turn many times in a step, which directors do not follow.

mod adhesive_film;
mod ball_joints;
mod closest_surfaces;
mod contact_work;
mod delassus;
mod detection;
mod fiber_contacts;
mod flight;
mod forcing_term;
mod group_body;
mod in_contact;
mod initial_overlaps;
mod junctions;
mod laws;
mod leaps;
mod listing;
mod newton;
mod node_arrays;
mod node_motion;
mod object_detector;
mod pair_lists;
mod problem;
mod rooted;
mod sections;
mod separation;
mod stepper;
mod substep;
mod substep_failure;
mod system;
mod touched_parts;
mod tunnelling;
mod velocities;
mod warm_start;

pub use ball_joints::{BallJoint, ContactJoints};
pub use contact_work::ContactWork;
pub use in_contact::FibersInContact;
pub use separation::{Separation, separate};
pub use warm_start::ActiveContact;
