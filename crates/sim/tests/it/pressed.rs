//! A strip that is clamped above a plane and pressed onto it, for tests and for the chapter of
//! validation: its elastica, and its scene. The setup is that of T. G. Sano, T. Yamaguchi and
//! H. Wada, Slip morphology of elastic strips on frictional rigid substrates, Phys. Rev. Lett. 118
//! (2017), which V. Romero et al., Physical validation of simulators in computer graphics, ACM
//! Trans. Graph. 40 (2021), made a protocol.
//!
//! Lengths are in that of the strip, forces in `B / L^2`. Its tip is round: where it sticks, it
//! rolls on the plane as it turns.

use nalgebra::{Matrix3, Point3, Vector3, Vector4};

/// A strip whose clamp leans against the normal of the plane by an angle (rad), and which is curved
/// by nature, further away from it. Its weight is `w L^3 / B`, with the weight `w` per length.
#[derive(Clone, Copy)]
pub(crate) struct Strip {
    pub(crate) lean: f64,
    pub(crate) curvature: f64,
    pub(crate) weight: f64,
}

/// Angle of the tip to the normal, and force of the plane on it along the plane and along the
/// normal.
type Tip = Vector3<f64>;

/// A strip whose tip sticks.
#[derive(Clone, Copy)]
pub(crate) struct Stuck {
    /// How far the clamp has come down since the tip touched.
    pub(crate) way: f64,
    pub(crate) tip: Tip,
}

impl Stuck {
    /// The coefficient of friction below which it slips.
    pub(crate) fn critical(&self) -> f64 {
        -self.tip[1] / self.tip[2]
    }
}

/// What counts as sticking, in lengths in a second.
pub(crate) const SLIP: f64 = 1e-6;
/// Radius of the strip, in its length.
const RADIUS: f64 = 1e-3;
/// Length of a step, s.
pub(crate) const DT: f64 = 0.05;
/// Steps in which it comes to hang at rest, and in which it is pressed.
pub(crate) const HANGING: u32 = 100;
pub(crate) const PRESSING: u32 = 200;

impl Strip {
    /// Angle, curvature and place at the clamp, as seen from the tip: `angle'' = -f . n` and `r' =
    /// t` with the tangent `t = (sin, -cos)`, `n = (cos, sin)` and the force `f` on what is beyond,
    /// by the classical method of Runge and Kutta.
    fn clamp(&self, tip: &Tip) -> Vector4<f64> {
        const PIECES: u32 = 200;
        let slope = |s: f64, y: &Vector4<f64>| {
            let (sin, cos) = y[0].sin_cos();
            let up = tip[2] - self.weight * (1.0 - s);
            Vector4::new(y[1], -(tip[1] * cos + up * sin), sin, -cos)
        };
        let h = -1.0 / f64::from(PIECES);
        // The plane pushes at the foot of the round tip.
        let mut y = Vector4::new(tip[0], self.curvature + RADIUS * tip[1], 0.0, 0.0);
        for piece in 0..PIECES {
            let s = 1.0 + h * f64::from(piece);
            let a = slope(s, &y);
            let b = slope(s + 0.5 * h, &(y + 0.5 * h * a));
            let c = slope(s + 0.5 * h, &(y + 0.5 * h * b));
            let d = slope(s + h, &(y + h * c));
            y += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
        y
    }

    /// How it hangs before it touches.
    fn hanging(&self) -> Tip {
        // The more its tip turns out, the more its clamp does: the heavier, the faster.
        let (mut low, mut high) = (self.lean.min(0.0), self.lean + self.curvature);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let out = self.clamp(&Vector3::new(middle, 0.0, 0.0))[0] > self.lean;
            *(if out { &mut high } else { &mut low }) = middle;
        }
        Vector3::new(0.5 * (low + high), 0.0, 0.0)
    }

    /// The tip near another one, once the clamp has come down so far from where it hung and the tip
    /// has stuck, by Newton's method; `None` where it finds none.
    fn stuck(&self, hanging: &Tip, way: f64, near: Tip) -> Option<Tip> {
        let start = self.clamp(hanging);
        let miss = |tip: &Tip| {
            let y = self.clamp(tip);
            let rolled = RADIUS * (tip[0] - hanging[0]);
            Vector3::new(y[0] - self.lean, y[2] - rolled - start[2], y[3] - start[3] + way)
        };
        let mut tip = near;
        for _ in 0..12 {
            let off = miss(&tip);
            if off.norm() < 1e-10 {
                return Some(tip);
            }
            let column = |k: usize| {
                let mut step = Vector3::zeros();
                step[k] = 1e-6 * tip[k].abs().max(1.0);
                (miss(&(tip + step)) - miss(&(tip - step))) / (2.0 * step[k])
            };
            let slopes = Matrix3::from_columns(&[column(0), column(1), column(2)]);
            tip -= slopes.lu().solve(&off)?;
        }
        None
    }

    /// How it is pressed, from where its tip touches until the clamp has come down so far; `None`
    /// if it lies down on the plane before, or no elastica is found.
    pub(crate) fn pressed(&self, most: f64) -> Option<Vec<Stuck>> {
        let hanging = self.hanging();
        let mut all = vec![Stuck { way: 0.0, tip: hanging }];
        let mut step: f64 = 1e-5;
        while all[all.len() - 1].way < most - 1e-12 {
            let last = all[all.len() - 1];
            let way = (last.way + step).min(most);
            let guess = match all[..] {
                [.., before, _] => {
                    last.tip
                        + (last.tip - before.tip) * ((way - last.way) / (last.way - before.way))
                }
                _ => last.tip,
            };
            // A tip that turns by more has come to another branch.
            match self.stuck(&hanging, way, guess) {
                Some(tip) if (tip[0] - last.tip[0]).abs() < 0.1 => all.push(Stuck { way, tip }),
                _ if step > 1e-9 => {
                    step *= 0.25;
                    continue;
                }
                _ => return None,
            }
            if all[all.len() - 1].tip[0] > std::f64::consts::FRAC_PI_2 {
                return None;
            }
            step = (1.5 * step).min(0.01);
        }
        all.remove(0);
        Some(all)
    }

    /// A strip of 1 m and 1 N m^2 that hangs at rest before it is pressed so far, at a constant
    /// pace. It is stiff across its plane.
    pub(crate) fn scene(&self, segments: usize, way: f64, mu: f64) -> String {
        let y = self.clamp(&self.hanging());
        let [hang, end] = [HANGING, HANGING + PRESSING].map(|steps| DT * f64::from(steps));
        format!(
            "(format: 1, duration: 100.0, fibers: [(length: 1.0, segments: {segments},
                section: Circle(radius: {RADIUS:?}), material: Measured(bending: (100, 1),
                torsion: 100, linear_density: 0.01),
                shape: Curved(curvature: (0, {:?}, 0)), root: (position: ({:?}, 0, {:?}),
                orientation: Euler(degrees: (0, {:?}, 0))),
                motion: Keyframes(points: [(time: 0), (time: {hang:?}),
                    (time: {end:?}, translation: (0, 0, {:?}))]))],
            objects: [(shape: Plane(normal: (0, 0, 1)))],
            contact: (friction: Isotropic({mu:?}), residual: 1e-6, slip: {SLIP:?}, depth: 1e-4),
            environment: (gravity: (0, 0, -{:?}), gravity_ramp: {:?}), stepper: (dt: {DT:?}))",
            -self.curvature,
            y[2],
            y[3] + RADIUS + GAP,
            180.0 - self.lean.to_degrees(),
            -way - GAP,
            100.0 * self.weight,
            0.5 * hang,
        )
    }
}

/// How far along the plane a tip has slid, from the nodes where it hung and now. Where it sticks,
/// the round tip rolls on as far back as it turns.
pub(crate) fn slid(hung: &[Point3<f64>], now: &[Point3<f64>]) -> f64 {
    let place = |nodes: &[Point3<f64>]| {
        let [.., before, tip] = nodes else { return 0.0 };
        let last = tip - before;
        tip.x + RADIUS * last.x.atan2(-last.z)
    };
    place(now) - place(hung)
}

/// How far above the plane it hangs.
const GAP: f64 = 1e-4;
