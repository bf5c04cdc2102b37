use super::elimination::{Panel, Turning};
use super::ends::{self, StageEnd};
use super::unknowns::{NodeLaw, Scales, Unknowns};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rapunzel_fiber::so3;

/// Frames are brought back to orthogonality after this many products.
const PRODUCTS: usize = 64;

/// Known properties of a segment: length, mass and rotary inertia per length (means of its ends)
/// and force per length (world), in units of the solver.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub(super) h: f64,
    pub(super) rho: f64,
    pub(super) inertia: Vector3<f64>,
    pub(super) force: Vector3<f64>,
}

/// Frame of the root at the stage.
#[derive(Debug, Clone, Copy)]
pub(super) enum RootFrame {
    /// A prescribed frame.
    Fixed(Rotation3<f64>),
    /// A free frame, `start exp(phi)` with `phi = (omega - b) / c`: the rotation of the step in the
    /// chart at its start, advanced by the scheme itself.
    Free { start: Rotation3<f64>, b: Vector3<f64> },
}

/// The nonlinear equations of one step: everything known, in units of the solver.
///
/// With stage values y and stage derivatives c y + b, per segment of length h with means over
/// its ends written in bars and differences D, all in material components
/// ((3.61) to (3.64), gyroscopic terms after erratum):
///
/// ```text
/// rho (c v + b + omega x v) - Dn/h - kappa x n - R^T f + drag (v - R^T wind) = 0
/// J (c omega + b) + omega x J omega - Dm/h - kappa x m - d3 x n            = 0
/// c kappa + b - D omega/h - kappa x omega                                  = 0
/// Dv/h + kappa x v - omega x d3                                            = 0
/// ```
#[derive(Debug, Clone)]
pub(super) struct StageEquations {
    pub(super) c: f64,
    pub(super) nodes: Vec<NodeLaw>,
    pub(super) segments: Vec<Segment>,
    /// Drag coefficients along d1, d2, d3.
    pub(super) drag: Vector3<f64>,
    pub(super) wind: Vector3<f64>,
    pub(super) root: StageEnd,
    pub(super) tip: StageEnd,
    pub(super) root_frame: RootFrame,
    pub(super) scales: Scales,
}

/// A trial solution of a [`StageEquations`] and the quantities that follow from it.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    pub(super) x: Vec<Unknowns>,
    pub(super) frames: Vec<Rotation3<f64>>,
    /// Rotation over half of each segment, `exp(h kappa / 2)`.
    halves: Vec<Rotation3<f64>>,
    /// Frames at the midpoints of the segments.
    pub(super) middles: Vec<Rotation3<f64>>,
    pub(super) residuals: Vec<[f64; 12]>,
    pub(super) ends: [[f64; 6]; 2],
    /// Sum of the squared relative residuals; the merit of the line search.
    pub(super) merit: f64,
}

impl Trial {
    pub(super) fn new(segments: usize) -> Self {
        let e = Rotation3::identity();
        Self {
            x: vec![Unknowns::zero(); segments + 1],
            frames: vec![e; segments + 1],
            halves: vec![e; segments],
            middles: vec![e; segments],
            residuals: vec![[0.0; 12]; segments],
            ends: [[0.0; 6]; 2],
            merit: f64::INFINITY,
        }
    }
}

fn mean(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    0.5 * (a + b)
}

/// Rebuilds the frames of nodes and segment midpoints from the root's frame and the curvatures.
pub(super) fn rebuild_frames(
    root: Rotation3<f64>,
    half_turns: impl Iterator<Item = Rotation3<f64>>,
    mut put: impl FnMut(usize, Rotation3<f64>, Rotation3<f64>, Rotation3<f64>),
) {
    let mut frame = root;
    for (i, half) in half_turns.enumerate() {
        let middle = frame * half;
        frame = middle * half;
        if i % PRODUCTS == PRODUCTS - 1 {
            frame = so3::quaternion(&frame).to_rotation_matrix();
        }
        put(i, half, middle, frame);
    }
}

impl StageEquations {
    /// Rotation vector of a free root from the start of the step to the stage.
    pub(super) fn root_turn(&self, omega: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
        (omega - b) / self.c
    }

    /// Derivative d theta / d omega of the root's rotation by its angular velocity.
    pub(super) fn root_rotation(&self, x: &Unknowns) -> Matrix3<f64> {
        match &self.root_frame {
            RootFrame::Fixed(_) => Matrix3::zeros(),
            RootFrame::Free { b, .. } => so3::right_jacobian(&self.root_turn(&x.omega, b)) / self.c,
        }
    }

    /// Fills everything in `trial` that follows from its unknowns.
    pub(super) fn evaluate(&self, trial: &mut Trial) {
        let Trial { x, frames, halves, middles, residuals, ends, merit } = trial;
        let segments = &self.segments;
        // Frames of nodes and midpoints, from the root's frame and the curvatures.
        frames[0] = match &self.root_frame {
            RootFrame::Fixed(frame) => *frame,
            RootFrame::Free { start, b } => *start * so3::exp(&self.root_turn(&x[0].omega, b)),
        };
        rebuild_frames(
            frames[0],
            segments
                .iter()
                .zip(x.windows(2))
                .map(|(s, x)| so3::exp(&(0.25 * s.h * (x[0].kappa + x[1].kappa)))),
            |i, half, middle, frame| {
                halves[i] = half;
                middles[i] = middle;
                frames[i + 1] = frame;
            },
        );
        // Residuals of the segments and the ends, and the merit, their weighted sum of squares.
        *merit = 0.0;
        let scales = self.scales.segment;
        for (i, s) in segments.iter().enumerate() {
            residuals[i] = self.segment_residual(i, s, x, &middles[i]);
            let weighted: f64 =
                residuals[i].iter().enumerate().map(|(r, f)| (f / scales[r / 3]).powi(2)).sum();
            *merit += weighted / s.h;
        }
        let last = segments.len();
        let law = &self.nodes;
        *ends = [
            ends::residual(&self.root, -1.0, &x[0], &law[0], &frames[0]),
            ends::residual(&self.tip, 1.0, &x[last], &law[last], &frames[last]),
        ];
        for (end, f) in [&self.root, &self.tip].into_iter().zip(ends) {
            let scale = end.scales(&self.scales);
            *merit += f.iter().enumerate().map(|(r, f)| (f / scale[r / 3]).powi(2)).sum::<f64>();
        }
    }

    fn segment_residual(
        &self,
        i: usize,
        s: &Segment,
        x: &[Unknowns],
        middle: &Rotation3<f64>,
    ) -> [f64; 12] {
        let (a, b) = (&x[i], &x[i + 1]);
        let (la, lb) = (&self.nodes[i], &self.nodes[i + 1]);
        let (v, omega) = (mean(&a.v, &b.v), mean(&a.omega, &b.omega));
        let (kappa, n) = (mean(&a.kappa, &b.kappa), mean(&a.n, &b.n));
        let (ma, mb) = (la.moment(&a.kappa), lb.moment(&b.kappa));
        let c = self.c;
        // Balance of momentum.
        let force = middle.inverse() * s.force
            - self.drag.component_mul(&(v - middle.inverse() * self.wind));
        let momentum = c * v + mean(&la.b_v, &lb.b_v) + omega.cross(&v);
        let f_v = s.h * (s.rho * momentum - kappa.cross(&n) - force) - (b.n - a.n);
        // Balance of angular momentum.
        let spin = s.inertia.component_mul(&(c * omega + mean(&la.b_omega, &lb.b_omega)))
            + omega.cross(&s.inertia.component_mul(&omega));
        let d3_n = Vector3::new(-n.y, n.x, 0.0);
        let f_omega = s.h * (spin - kappa.cross(&mean(&ma, &mb)) - d3_n) - (mb - ma);
        // Compatibility of curvature and angular velocity.
        let f_kappa = s.h * (c * kappa + mean(&la.b_kappa, &lb.b_kappa) - kappa.cross(&omega))
            - (b.omega - a.omega);
        let omega_d3 = Vector3::new(omega.y, -omega.x, 0.0);
        // Inextensibility.
        let f_n = (b.v - a.v) + s.h * (kappa.cross(&v) - omega_d3);
        let mut rows = [0.0; 12];
        for (r, f) in [f_v, f_omega, f_kappa, f_n].iter().enumerate() {
            rows[3 * r..3 * r + 3].copy_from_slice(f.as_slice());
        }
        rows
    }

    /// Boundary conditions of root and tip, linearised at `trial`.
    pub(super) fn end_rows(&self, trial: &Trial) -> [super::elimination::EndRows; 2] {
        let last = self.segments.len();
        let law = &self.nodes;
        [
            ends::rows(&self.root, -1.0, &trial.ends[0], &law[0], &trial.frames[0]),
            ends::rows(&self.tip, 1.0, &trial.ends[1], &law[last], &trial.frames[last]),
        ]
    }

    /// Writes the equations of segment `i`, linearised at `trial`, into `panel`. Returns how the
    /// rotation increments of its ends enter.
    pub(super) fn linearise(&self, trial: &Trial, i: usize, panel: &mut Panel) -> Turning {
        let s = &self.segments[i];
        let (a, b) = (&trial.x[i], &trial.x[i + 1]);
        let (la, lb) = (&self.nodes[i], &self.nodes[i + 1]);
        let (middle, half) = (&trial.middles[i], trial.halves[i].matrix());
        let k = 0.5 * s.h;
        let one = Matrix3::identity();
        let d3 = so3::hat(&Vector3::z());
        let (v, omega) = (mean(&a.v, &b.v), mean(&a.omega, &b.omega));
        let (kappa, n) = (mean(&a.kappa, &b.kappa), mean(&a.n, &b.n));
        let m = mean(&la.moment(&a.kappa), &lb.moment(&b.kappa));
        let (kappa_hat, omega_hat) = (k * so3::hat(&kappa), k * so3::hat(&omega));

        // theta at the middle = half^T theta_a + (h/2) J d kappa.
        let lever = k * so3::right_jacobian(&(k * kappa));
        let force = so3::hat(&(middle.inverse() * s.force))
            + Matrix3::from_diagonal(&self.drag) * so3::hat(&(middle.inverse() * self.wind));
        let force = -s.h * force;

        // Derivatives of the four equations by the unknowns of a node, named equation_unknown.
        let v_v =
            k * (self.c * s.rho * one + Matrix3::from_diagonal(&self.drag)) + s.rho * omega_hat;
        let v_omega = -k * s.rho * so3::hat(&v);
        let v_kappa = k * so3::hat(&n) + 0.5 * force * lever;
        let inertia = Matrix3::from_diagonal(&s.inertia);
        let omega_omega = k * (self.c * inertia - so3::hat(&s.inertia.component_mul(&omega)))
            + omega_hat * inertia;
        let moment_hat = k * so3::hat(&m);
        let kappa_kappa = k * self.c * one + omega_hat;
        let n_kappa = -k * so3::hat(&v);
        // Both nodes have the same blocks but for the sign of the differences.
        for (col, sign, law) in [(0, -1.0, la), (12, 1.0, lb)] {
            let e = Matrix3::from_diagonal(&law.stiffness);
            panel.set(0, col, &v_v);
            panel.set(0, col + 3, &v_omega);
            panel.set(0, col + 6, &v_kappa);
            panel.set(0, col + 9, &(-kappa_hat - sign * one));
            panel.set(3, col + 3, &omega_omega);
            panel.set(3, col + 6, &(moment_hat - kappa_hat * e - sign * e));
            panel.set(3, col + 9, &(-k * d3));
            panel.set(6, col + 3, &(-kappa_hat - sign * one));
            panel.set(6, col + 6, &kappa_kappa);
            panel.set(9, col, &(kappa_hat + sign * one));
            panel.set(9, col + 3, &(k * d3));
            panel.set(9, col + 6, &n_kappa);
        }
        panel.set_rhs(&trial.residuals[i].map(|f| -f));
        let half_back = half.transpose();
        Turning {
            force: force * half_back,
            turn: half_back * half_back,
            lever: (half_back + one) * lever,
        }
    }
}
