//! What the integration tests share: the oracle file.
use rapunzel_mass_spring::System;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A case of `f_mass_spring.json`; which fields there are tells its kind. Masses are 1, the spring
/// constant is the square of `2 pi f0` or of `w0`.
#[derive(Debug, Deserialize)]
pub(crate) struct Case {
    pub(crate) name: String,
    #[serde(rename = "f0_Hz")]
    pub(crate) frequency: Option<f64>,
    pub(crate) w0: Option<f64>,
    pub(crate) rest_length: Option<f64>,
    pub(crate) g: Option<f64>,
    // Ropes and chains.
    pub(crate) moving_nodes: Option<usize>,
    pub(crate) node_depths_static: Option<Vec<f64>>,
    pub(crate) total_length_static: Option<f64>,
    pub(crate) extension: Option<f64>,
    pub(crate) longitudinal_omega: Option<Vec<f64>>,
    pub(crate) transverse_omega: Option<Vec<f64>>,
    pub(crate) leapfrog_dt_limit: Option<f64>,
    #[serde(rename = "dt_limit_60Hz_substeps")]
    pub(crate) substeps: Option<usize>,
    pub(crate) span: Option<f64>,
    pub(crate) horizontal_tension: Option<f64>,
    pub(crate) spring_lengths: Option<Vec<f64>>,
    pub(crate) x: Option<Vec<f64>>,
    pub(crate) y: Option<Vec<f64>>,
    pub(crate) max_sag: Option<f64>,
    // Nets.
    pub(crate) nodes: Option<[usize; 2]>,
    pub(crate) prestretch: Option<f64>,
    pub(crate) omega_sorted: Option<Vec<f64>>,
    pub(crate) omega_max: Option<f64>,
    pub(crate) fixed: Option<String>,
    pub(crate) positions_row_major: Option<Vec<[f64; 2]>>,
    pub(crate) lowest_eigenvalue: Option<f64>,
    // Beams.
    pub(crate) rows: Option<usize>,
    pub(crate) cols: Option<usize>,
    pub(crate) kd_over_k: Option<f64>,
    pub(crate) linear_displacement: Option<Vec<[f64; 2]>>,
    pub(crate) linear_tip_mean: Option<[f64; 2]>,
    pub(crate) nonlinear_positions: Option<Vec<[f64; 2]>>,
    pub(crate) nonlinear_lowest_eigenvalue: Option<f64>,
    pub(crate) nonlinear_tip_mean: Option<[f64; 2]>,
    pub(crate) right_x: Option<f64>,
    pub(crate) mid_deflection: Option<f64>,
    // Rings.
    #[serde(rename = "J")]
    pub(crate) count: Option<usize>,
    #[serde(rename = "R0")]
    pub(crate) radius: Option<f64>,
    pub(crate) k_surface: Option<f64>,
    pub(crate) k_radial: Option<f64>,
    #[serde(rename = "A0_polygon")]
    pub(crate) rest_area: Option<f64>,
    #[serde(rename = "A0_over_circle")]
    pub(crate) over_circle: Option<f64>,
    pub(crate) held_nodes: Option<BTreeMap<usize, [f64; 2]>>,
    pub(crate) area_ratio_without_control: Option<f64>,
    #[serde(rename = "radial_rest_length_for_A0")]
    pub(crate) radial_rest_length: Option<f64>,
    #[serde(rename = "positions_at_A0")]
    pub(crate) controlled: Option<Vec<[f64; 2]>>,
    pub(crate) tau: Option<f64>,
    pub(crate) quasi_static_area_ratio: Option<Vec<f64>>,
}

/// All cases.
pub(crate) fn cases() -> Vec<Case> {
    rapunzel_oracles::cases("f_mass_spring.json").expect("the oracle")
}

/// Largest relative difference of two lists, by the largest entry.
pub(crate) fn difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(f64::MIN_POSITIVE, |a, b| a.max(b.abs()));
    found.iter().zip(expected).fold(0.0, |a: f64, (f, e)| a.max((f - e).abs())) / scale
}

/// Largest distance of nodes from where they should be.
pub(crate) fn distance(system: &System<2>, expected: &[[f64; 2]]) -> f64 {
    assert_eq!(system.nodes(), expected.len());
    let away = |(node, e): (usize, &[f64; 2])| {
        (system.position(node).coords - nalgebra::Vector2::from(*e)).norm()
    };
    expected.iter().enumerate().map(away).fold(0.0, f64::max)
}
