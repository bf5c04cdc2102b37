//! The closed form against the reference values.

use crate::common::rotation;
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::euler::EulerAngles;
use rapunzel_oracles::cases;
use rapunzel_rod_static::{Lagrange, State};
use serde::Deserialize;

/// A case of `a_kirchhoff_lagrange.json`, all divided by the bending stiffness, force along z.
#[derive(Debug, Deserialize)]
struct Case {
    name: String,
    n: f64,
    m3: f64,
    mz: f64,
    z0: f64,
    theta0_prime: f64,
    b: f64,
    #[serde(default)]
    phi0: f64,
    #[serde(default)]
    psi0: f64,
    #[serde(default)]
    kappa3_0: f64,
    hamiltonian: f64,
    stations: Vec<Station>,
    closed_form: Option<ClosedForm>,
}

#[derive(Debug, Deserialize)]
struct Station {
    s: f64,
    r: [f64; 3],
    #[serde(rename = "R")]
    frame: [[f64; 3]; 3],
    kappa_bend_body: [f64; 2],
    euler_zyz_continuous: Option<Angles>,
}

#[derive(Debug, Deserialize)]
struct Angles {
    phi: f64,
    theta: f64,
    psi: f64,
}

#[derive(Debug, Deserialize)]
struct ClosedForm {
    z1: f64,
    z2: f64,
    z3: f64,
    k: f64,
    lam: f64,
    period_z: f64,
}

impl Case {
    /// The state at the start, from the thesis's parameters.
    fn start(&self) -> State {
        let (phi, theta, psi) = (self.phi0, self.z0.acos(), self.psi0);
        let angles = EulerAngles { phi, theta, psi };
        let frame = angles.to_rotation();
        let sin2 = 1.0 - self.z0 * self.z0;
        let turn = if sin2 > 0.0 { (self.mz - self.m3 * self.z0) / sin2 } else { 0.0 };
        let bent = angles.darboux(&Vector3::new(turn, self.theta0_prime, 0.0));
        State {
            position: Point3::origin(),
            frame,
            force: Vector3::new(0.0, 0.0, self.n),
            moment: frame * Vector3::new(bent.x, bent.y, self.m3),
        }
    }
}

/// All cases: 1e-10 of the length or the curvature, 1e-7 within 1e-6 of the separatrix.
#[test]
fn every_station_of_the_reference() {
    for case in cases::<Case>("a_kirchhoff_lagrange.json").expect("the oracle") {
        let rod = Lagrange::new(1.0, case.b, case.kappa3_0, &case.start()).expect("a rod");
        let (k, _) = rod.modulus().expect("a rod that is not straight");
        let tolerance = if 1.0 - k < 1e-6 { 1e-7 } else { 1e-10 };
        let mut worst = [0.0_f64; 4];
        for station in &case.stations {
            let at = rod.at(station.s);
            let frame = rotation(&station.frame);
            let bent = at.frame.inverse() * at.moment;
            let length = station.s.max(1.0);
            let scale = station.kappa_bend_body[0].hypot(station.kappa_bend_body[1]).max(1.0);
            let energy = 0.5 * (bent.x.powi(2) + bent.y.powi(2) + bent.z.powi(2) / case.b)
                + at.force.dot(&(at.frame * Vector3::z()));
            worst[0] =
                worst[0].max((at.position.coords - Vector3::from(station.r)).norm() / length);
            worst[1] = worst[1].max((at.frame.matrix() - frame.matrix()).norm());
            let bending = station.kappa_bend_body;
            worst[2] = worst[2].max((bent.x - bending[0]).hypot(bent.y - bending[1]) / scale);
            worst[3] = worst[3].max((energy - case.hamiltonian).abs() / case.hamiltonian.abs());
        }
        assert!(worst.iter().all(|&w| w < tolerance), "{}: {worst:?}", case.name);
    }
}

/// The roots, the modulus, the period and the continuous angles where the reference has them.
#[test]
fn roots_and_angles_of_the_reference() {
    for case in cases::<Case>("a_kirchhoff_lagrange.json").expect("the oracle") {
        let rod = Lagrange::new(1.0, case.b, case.kappa3_0, &case.start()).expect("a rod");
        let Some(form) = &case.closed_form else { continue };
        let [z1, z2, z3] = rod.roots().expect("a rod that is not straight");
        let (k, lambda) = rod.modulus().expect("a rod that is not straight");
        let period = rod.period().expect("a rod that is not straight");
        // Close to the separatrix k stands for a difference of z3 - z2 that is known to 1e-10.
        let tolerance = if 1.0 - k < 1e-6 { 1e-7 } else { 1e-10 };
        let pairs = [
            (z1, form.z1),
            (z2, form.z2),
            (z3, form.z3),
            (k, form.k),
            (lambda, form.lam),
            (period, form.period_z),
        ];
        for (i, (found, exact)) in pairs.iter().enumerate() {
            let error = (found / exact - 1.0).abs();
            assert!(error < tolerance, "{}, value {i}: {found} for {exact}", case.name);
        }
        let first = rod.euler_angles(0.0).expect("a rod that is not straight");
        for station in &case.stations {
            let Some(angles) = &station.euler_zyz_continuous else { continue };
            let found = rod.euler_angles(station.s).expect("a rod that is not straight");
            let error = (found.theta - angles.theta)
                .abs()
                .max((found.phi - first.phi - angles.phi + case.phi0).abs())
                .max((found.psi - first.psi - angles.psi + case.psi0).abs());
            assert!(error < 100.0 * tolerance, "{} at {}: {error:e}", case.name, station.s);
        }
    }
}
