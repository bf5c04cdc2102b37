//! A strip that is clamped above a plane and pressed onto it sticks with its tip until friction
//! cannot hold it, and slips. The curve of V. Romero et al., Physical validation of simulators in
//! computer graphics, ACM Trans. Graph. 40 (2021), is that of a heavy strip; here it is one of no
//! weight, whose own elastica says when it slips.

use crate::common::Run;
use nalgebra::{Matrix3, Vector3, Vector4};
use std::f64::consts::PI;

/// A strip of unit length and stiffness, whose clamp leans against the normal of the plane by an
/// angle, and which is curved by nature, further away from it.
#[derive(Clone, Copy)]
struct Strip {
    lean: f64,
    curvature: f64,
}

/// Angle of the tip to the normal, and force of the plane on it along the plane and along the
/// normal.
type Tip = Vector3<f64>;

impl Strip {
    /// Angle, curvature and place at the clamp, as seen from the tip: `angle'' = -f . n` and `r' =
    /// t` with the tangent `t = (sin, -cos)` and `n = (cos, sin)`, by the classical method of Runge
    /// and Kutta.
    fn clamp(&self, tip: &Tip) -> Vector4<f64> {
        const STEPS: u32 = 200;
        let slope = |y: &Vector4<f64>| {
            let (sin, cos) = y[0].sin_cos();
            Vector4::new(y[1], -(tip[1] * cos + tip[2] * sin), sin, -cos)
        };
        let h = -1.0 / f64::from(STEPS);
        let mut y = Vector4::new(tip[0], self.curvature, 0.0, 0.0);
        for _ in 0..STEPS {
            let a = slope(&y);
            let b = slope(&(y + 0.5 * h * a));
            let c = slope(&(y + 0.5 * h * b));
            let d = slope(&(y + h * c));
            y += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
        y
    }

    /// Without load.
    fn natural(&self) -> Tip {
        Vector3::new(self.lean + self.curvature, 0.0, 0.0)
    }

    /// Where its clamp is when its tip touches, as seen from there.
    fn start(&self) -> [f64; 2] {
        let y = self.clamp(&self.natural());
        [y[2], y[3]]
    }

    /// The tip once the clamp has come down so far and it has stuck, by Newton's method from a near
    /// one.
    fn stuck(&self, way: f64, near: Tip) -> Tip {
        let [x, z] = self.start();
        let miss = |tip: &Tip| {
            let y = self.clamp(tip);
            Vector3::new(y[0] - self.lean, y[2] - x, y[3] - z + way)
        };
        let mut tip = near;
        for _ in 0..50 {
            let off = miss(&tip);
            if off.norm() < 1e-10 {
                return tip;
            }
            let column = |k: usize| {
                let mut step = Vector3::zeros();
                step[k] = 1e-6 * tip[k].abs().max(1.0);
                (miss(&(tip + step)) - miss(&(tip - step))) / (2.0 * step[k])
            };
            let slopes = Matrix3::from_columns(&[column(0), column(1), column(2)]);
            let change = slopes.lu().solve(&off).expect("regular");
            // The angle changes by half a radian at most.
            tip -= change * (0.5 / change[0].abs().max(0.5));
        }
        panic!("no strip at {way} from {near}");
    }

    /// The coefficient of friction with which it slips when its clamp has come down by so many per
    /// cent.
    fn critical(&self, percent: u32) -> f64 {
        let (mut tip, mut ratio) = (self.natural(), 0.0);
        for way in 1..=percent {
            tip = self.stuck(0.01 * f64::from(way), tip);
            assert!(tip[0] < 0.5 * PI, "it touches with its tip alone");
            assert!(-tip[1] / tip[2] > ratio, "it needs ever more friction");
            ratio = -tip[1] / tip[2];
        }
        ratio
    }

    /// How far along the plane its tip has slid once its clamp has come down so far, a
    /// two-hundredth a step: as one of 1 m and 1 N m^2. Where it sticks, the round tip rolls on as
    /// far back as it turns.
    fn gone(&self, way: f64, mu: f64) -> f64 {
        let (radius, segments) = (0.001_f64, 50);
        let modulus = 4.0 / (PI * radius.powi(4));
        let density = 0.01 / (PI * radius * radius);
        let (sin, cos) = self.lean.sin_cos();
        let [x, z] = self.start();
        let (dt, steps) = (0.05, 200);
        let until = dt * f64::from(steps);
        let mut run = Run::read(&format!(
            "(format: 1, duration: 100.0, fibers: [(length: 1.0, segments: {segments},
                section: Circle(radius: {radius:?}), material: Elastic(density: {density:?},
                youngs_modulus: {modulus:?}, shear_modulus: {modulus:?}),
                shape: Curved(curvature: (0, {:?}, 0)), root: (position: ({x:?}, 0, {:?}),
                orientation: Along(direction: ({sin:?}, 0, {:?}))),
                motion: Translate(velocity: (0, 0, {:?}), until: {until:?}))],
            objects: [(shape: Plane(normal: (0, 0, 1)))],
            contact: (friction: Isotropic({mu:?}), residual: 1e-6, slip: {SLIP:?}, depth: 1e-4),
            environment: (gravity: (0, 0, 0)), stepper: (dt: {dt:?}))",
            -self.curvature,
            z + radius + 1e-4,
            -cos,
            -(way + 1e-4) / until
        ));
        run.steps(steps as usize);
        let nodes = run.positions(0);
        let last = nodes[segments] - nodes[segments - 1];
        let turned = last.x.atan2(-last.z) - self.natural()[0];
        nodes[segments].x + radius * turned
    }
}

/// What counts as sticking, m/s; the clamp comes down in 10 s.
const SLIP: f64 = 1e-6;

#[test]
fn a_strip_sticks_until_friction_cannot_hold_its_tip() {
    for (lean, curvature, percent) in [(-10.0_f64, 1.0, 15), (-10.0, 0.6, 20), (5.0, 0.6, 10)] {
        let strip = Strip { lean: lean.to_radians(), curvature };
        let critical = strip.critical(percent);
        let [slips, sticks] =
            [0.98, 1.02].map(|share| strip.gone(0.01 * f64::from(percent), share * critical));
        println!(
            "at {percent} %: slips below {critical:.4}; {slips:.2e} with 2 % less, {sticks:.2e} with 2 % more"
        );
        assert!(sticks.abs() < 10.0 * SLIP, "{sticks}");
        assert!(slips > 1e-3, "{slips}");
    }
}
