//! The box scheme of the thesis (3.4): the equations of motion of an inextensible, unshearable
//! rod, averaged over boxes in space and time.
//!
//! **Unknowns.** At every node the velocity v, angular velocity omega, curvature kappa and
//! internal force n, all in the material frame: (3.61) to (3.64), with the gyroscopic terms and
//! signs of the errata. In space all weights are 1/2 (midpoint of each segment, second order); in
//! time the generalised-alpha weights of (3.148), or any others, see [`Coefficients`].
//!
//! **One stage.** All nonlinear terms are taken at one averaged state of the step, with one force
//! n per step, rather than averaged between the old and the new time as (3.153) prints it. This
//! form conserves energy by structure at `rho_infinity = 1`, needs no consistent force to start
//! from, and survives in space where the printed form gains energy. The first step from a given
//! state is a midpoint step, which needs no old time derivative.
//!
//! **Frames** are rebuilt from the curvatures along the rod in every iteration and never
//! integrated by themselves (the thesis's 3.4.5 does; in space the two drift apart by radians).
//! World-frame loads therefore depend on all curvatures before them. Rather than leaving that out
//! of the Jacobian, which costs two iterations a step, or adding three unknowns to the twelve of
//! each node, which doubles the work, the rotation increment of the current node is carried
//! through the elimination as three rows in that node's unknowns. The matrix stays block
//! bidiagonal, the Jacobian is exact, and Newton's method takes four to five iterations a step for
//! a hair at 1/30 s (3.8 in the mean of a minute; 4.4 for a curly one in space), at a quarter more
//! work than without.
//!
//! **Positions** follow from the frames, each segment straight along its middle frame, so that
//! segments keep their length to rounding and the shape is exact to second order.
//!
//! **Ends.** A held root is where it is prescribed, exactly; its velocity is that of the parabola
//! through its poses in the step. A free or pinned root's frame is integrated by the scheme. A
//! held or pinned tip has its velocity prescribed; since its pose follows from the curvatures, a
//! share of the distance to its support is added to the velocity, which keeps that distance at
//! the truncation error of a few steps while the support moves and removes it once it rests. A
//! perfectly straight rod between two prescribed positions has no unique answer to being
//! shortened: give it a curl, a load or a motion to buckle along.
//!
//! **Robustness.** Newton's method starts from the old state (extrapolation saves little and
//! fails on whips), with Armijo's line search; a step that fails is halved, up to twelve times.
//!
//! **Not conserved.** Momentum balances hold in material components: in the world frame momentum
//! drifts by the truncation error, `O(h^2)` and `O(dt^2)`.
//!
//! Cost: for 100 segments 0.1 to 0.15 ms per iteration. Steps do not allocate.

mod coefficients;
mod elimination;
mod ends;
mod integrator;
mod motion;
mod newton;
mod setup;
mod span;
mod stage;
mod state;
mod units;
mod unknowns;
mod update;

pub use coefficients::Coefficients;
pub use integrator::{BoxIntegrator, BoxOptions};
