//! A curve as a start of the search for an equilibrium.

use crate::StaticError;
use crate::equilibrium::Equilibrium;
use crate::goal::{EndPlace, EndTurning};
use crate::problem::Problem;
use crate::state::State;
use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;

/// Number of points at which the guess is given.
const GUESSED: usize = 200;
/// Part of the largest eigenvalue of the fit of the force that is added to all: where a rod is
/// straight, the force along it is left at zero.
const SOFT_FIT: f64 = 1e-9;

impl Problem {
    /// The equilibrium near a curve through `points` (m, world frame, from the root to the end), by
    /// Newton's method; it may be unstable. The curve is stretched to the length of the rod.
    ///
    /// Frames are carried along the curve without twist, and with an even twist where the frame of
    /// the end is held; moments follow from the curvature, and forces from the balance of moments.
    ///
    /// # Errors
    /// [`StaticError::NotFound`] for less than three different points, or if Newton's method does
    /// not converge.
    pub fn solve_along(&self, points: &[Point3<f64>]) -> Result<Equilibrium, StaticError> {
        self.solve_near(&self.along(points).ok_or(StaticError::NotFound)?)
    }

    /// The states of a rod along a curve.
    fn along(&self, points: &[Point3<f64>]) -> Option<Vec<(f64, State)>> {
        let mut at = vec![0.0];
        for pair in points.windows(2) {
            at.push(at[at.len() - 1] + (pair[1] - pair[0]).norm());
        }
        let whole = *at.last()?;
        if points.len() < 3 || whole.is_nan() || whole <= 0.0 {
            return None;
        }
        let h = self.rod.length / GUESSED as f64;
        let curve: Vec<Point3<f64>> =
            (0..=GUESSED).map(|i| on(points, &at, whole * i as f64 / GUESSED as f64)).collect();
        // Tangents at the points, by parabolas through three of them.
        let mut tangents = vec![self.root.q * Vector3::z()];
        tangents.extend(curve.windows(3).map(|p| p[2] - p[0]));
        let last = curve[GUESSED] - curve[GUESSED - 1];
        tangents.push(2.0 * last - tangents[GUESSED - 1] * 0.5);
        if self.root.hinged {
            tangents[0] = 2.0 * (curve[1] - curve[0]) - tangents[1] * 0.5;
        }
        let mut frames = vec![
            so3::quaternion(&so3::between(
                &(self.root.q * Vector3::z()),
                &tangents[0].try_normalize(0.0)?,
            )?) * self.root.q,
        ];
        for tangent in &tangents[1..] {
            let frame = frames[frames.len() - 1];
            let turn = so3::between(&(frame * Vector3::z()), &tangent.try_normalize(0.0)?)?;
            frames.push(so3::quaternion(&turn) * frame);
        }
        if let EndTurning::Held { frame } = self.goal.turning {
            let twist = (frames[GUESSED].inverse() * frame).scaled_axis().z;
            for (i, own) in frames.iter_mut().enumerate() {
                let turn = Vector3::z() * (twist * i as f64 / GUESSED as f64);
                *own *= UnitQuaternion::from_scaled_axis(turn);
            }
        }
        // Moments in the middles, then at the points, and what the loads leave of the force.
        let elements = self.rod.elements([0.0; 2]).ok()?;
        let properties = |s: f64| {
            let i = elements.partition_point(|e| e.to <= s).min(elements.len() - 1);
            self.rod.properties(&elements[i], 1.0)(s)
        };
        let middle = |i: usize| {
            let p = properties((i as f64 + 0.5) / GUESSED as f64);
            let curvature = (frames[i].inverse() * frames[i + 1]).scaled_axis() / h;
            let strain = curvature * self.rod.length - p.natural_curvature;
            frames[i] * strain.component_mul(&p.stiffness) * self.rod.energy()
        };
        let middles: Vec<Vector3<f64>> = (0..GUESSED).map(middle).collect();
        // Loads between a point and the end.
        let mut beyond = vec![Vector3::zeros(); GUESSED + 1];
        for i in (0..GUESSED).rev() {
            let s = (i as f64 + 0.5) / GUESSED as f64;
            let load = properties(s).load / GUESSED as f64 * self.rod.force();
            let hung = elements.iter().filter(|e| {
                e.to > i as f64 / GUESSED as f64 && e.to <= (i + 1) as f64 / GUESSED as f64
            });
            let hung = hung.fold(Vector3::zeros(), |sum, e| sum + e.end_load) * self.rod.force();
            beyond[i] = beyond[i + 1] + load + hung;
        }
        let end = self.force_on_end(&frames, &middles, &beyond, h);
        let states = (0..=GUESSED).map(|i| {
            let moment = match i {
                0 => 1.5 * middles[0] - 0.5 * middles[1],
                GUESSED => 1.5 * middles[GUESSED - 1] - 0.5 * middles[GUESSED - 2],
                i => 0.5 * (middles[i - 1] + middles[i]),
            };
            let state = State {
                position: curve[i],
                frame: frames[i].to_rotation_matrix(),
                force: end + beyond[i],
                moment,
            };
            (h * i as f64, state)
        });
        Some(states.collect())
    }

    /// The force on the end, N, that fits the balance of moments `m' + d3 x n = 0` best; on a free
    /// end what the condition says.
    fn force_on_end(
        &self,
        frames: &[UnitQuaternion<f64>],
        middles: &[Vector3<f64>],
        beyond: &[Vector3<f64>],
        h: f64,
    ) -> Vector3<f64> {
        if let EndPlace::Free { force } = self.goal.place {
            return force * self.rod.force();
        }
        let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for i in 1..frames.len() - 1 {
            let tangent = frames[i] * Vector3::z();
            let rate = (middles[i] - middles[i - 1]) / h;
            let across = Matrix3::identity() - tangent * tangent.transpose();
            matrix += across;
            right += tangent.cross(&rate) - across * beyond[i];
        }
        matrix += Matrix3::identity() * (SOFT_FIT * matrix.trace());
        matrix.lu().solve(&right).unwrap_or_default()
    }
}

/// The point of a broken line at an arc length, smooth to second order: on the parabola through the
/// three nearest points.
fn on(points: &[Point3<f64>], at: &[f64], s: f64) -> Point3<f64> {
    let after = at.partition_point(|x| *x <= s).clamp(1, points.len() - 1);
    let nearer = s - at[after - 1] < at[after] - s;
    let middle = if nearer { after - 1 } else { after }.clamp(1, points.len() - 2);
    let ids = [middle - 1, middle, middle + 1];
    ids.iter().fold(Point3::origin(), |sum, &i| {
        let others = ids.iter().filter(|j| **j != i);
        let weight: f64 = others.map(|&j| (s - at[j]) / (at[i] - at[j])).product();
        sum + points[i].coords * weight
    })
}
