//! Two beams that cross, of linear theory: small deflections, supports that slide.
use crate::common::{Dense, circle, contact, exact, resolve};
use nalgebra::{DMatrix, DVector, Vector3};
use rapunzel_contact::{Admm, Contact, Solver, Tolerance};
use serde::Deserialize;

#[derive(Deserialize)]
pub(crate) struct Crossed {
    name: String,
    upper: Beam,
    lower: Beam,
    gap: f64,
    contact_force: f64,
    mid_deflection_upper: f64,
    mid_deflection_lower: f64,
}

#[derive(Deserialize)]
struct Beam {
    #[serde(rename = "L")]
    length: f64,
    #[serde(rename = "EI")]
    stiffness: f64,
    weight_per_length: f64,
}

/// Elements per beam.
const ELEMENTS: usize = 4;

impl Beam {
    /// The beam at rest under its weight, as a body with its middle for a point: deflections are
    /// its velocities and forces its impulses, as in a step of one second. Elements with cubic
    /// deflections give those of their nodes exactly.
    fn lie(&self) -> Dense {
        let h = self.length / ELEMENTS as f64;
        let size = 2 * (ELEMENTS + 1);
        let (mut stiffness, mut load) = (DMatrix::zeros(size, size), DVector::zeros(size));
        // Deflection and slope at one end, then at the other.
        let cubic = DMatrix::from_row_slice(
            4,
            4,
            &[
                12.0,
                6.0 * h,
                -12.0,
                6.0 * h,
                6.0 * h,
                4.0 * h * h,
                -6.0 * h,
                2.0 * h * h,
                -12.0,
                -6.0 * h,
                12.0,
                -6.0 * h,
                6.0 * h,
                2.0 * h * h,
                -6.0 * h,
                4.0 * h * h,
            ],
        ) * (self.stiffness / h.powi(3));
        let weight =
            [0.5, h / 12.0, 0.5, -h / 12.0].map(|share| -share * h * self.weight_per_length);
        for element in 0..ELEMENTS {
            let mut block = stiffness.view_mut((2 * element, 2 * element), (4, 4));
            block += &cubic;
            let mut part = load.rows_mut(2 * element, 4);
            part += DVector::from_row_slice(&weight);
        }
        let ends = [0, size - 2];
        let free = stiffness.remove_rows_at(&ends).remove_columns_at(&ends);
        let mut jacobian = DMatrix::zeros(3, size);
        jacobian[(2, ELEMENTS)] = 1.0;
        let compliance = free.cholesky().expect("a beam on two supports is stiff").inverse();
        let mut beam = Dense::new(compliance, jacobian.remove_columns_at(&ends));
        beam.push(load.remove_rows_at(&ends).as_slice());
        beam
    }
}

/// Closed forms, given to 1e-13.
pub(crate) fn crossed(case: &Crossed) {
    let reach = Contact {
        bias: Vector3::x() * case.gap,
        ..contact(0, Some(1), &Vector3::z(), circle(0.3))
    };
    let weight = case.upper.length * case.upper.weight_per_length;
    let mut splitting = Admm::new(Tolerance::EXACT);
    for solver in [&mut exact() as &mut dyn Solver, &mut splitting] {
        let mut beams = [&case.upper, &case.lower].map(Beam::lie);
        let mut impulses = [Vector3::zeros()];
        let report = resolve(&mut beams, std::slice::from_ref(&reach), &mut impulses, solver);
        assert!(report.converged, "{}: {report:?}", case.name);
        let force = impulses[0].x;
        assert!((force - case.contact_force).abs() < 1e-13 * weight, "{}: {force}", case.name);
        let expected = [case.mid_deflection_upper, case.mid_deflection_lower];
        for (beam, expected) in beams.iter().zip(expected) {
            let error = -beam.velocities()[0].z / expected - 1.0;
            assert!(error.abs() < 1e-13, "{}: {error:e}", case.name);
        }
    }
}
