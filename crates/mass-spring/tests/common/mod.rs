//! What the integration tests share: the oracle file.
#![allow(dead_code, unreachable_pub, reason = "every test file uses its own part")]

use rapunzel_mass_spring::System;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

#[derive(Debug, Deserialize)]
pub struct Oracle {
    pub cases: Vec<Case>,
}

/// A case of `f_mass_spring.json`; which fields there are tells its kind. Masses are 1, the spring
/// constant is the square of `2 pi f0` or of `w0`.
#[derive(Debug, Deserialize)]
pub struct Case {
    pub name: String,
    #[serde(rename = "f0_Hz")]
    pub frequency: Option<f64>,
    pub w0: Option<f64>,
    pub rest_length: Option<f64>,
    pub g: Option<f64>,
    // Ropes and chains.
    pub moving_nodes: Option<usize>,
    pub node_depths_static: Option<Vec<f64>>,
    pub total_length_static: Option<f64>,
    pub extension: Option<f64>,
    pub longitudinal_omega: Option<Vec<f64>>,
    pub transverse_omega: Option<Vec<f64>>,
    pub leapfrog_dt_limit: Option<f64>,
    #[serde(rename = "dt_limit_60Hz_substeps")]
    pub substeps: Option<usize>,
    pub span: Option<f64>,
    pub horizontal_tension: Option<f64>,
    pub spring_lengths: Option<Vec<f64>>,
    pub x: Option<Vec<f64>>,
    pub y: Option<Vec<f64>>,
    pub max_sag: Option<f64>,
    // Nets.
    pub nodes: Option<[usize; 2]>,
    pub prestretch: Option<f64>,
    pub omega_sorted: Option<Vec<f64>>,
    pub omega_max: Option<f64>,
    pub fixed: Option<String>,
    pub positions_row_major: Option<Vec<[f64; 2]>>,
    pub lowest_eigenvalue: Option<f64>,
    // Beams.
    pub rows: Option<usize>,
    pub cols: Option<usize>,
    pub kd_over_k: Option<f64>,
    pub linear_displacement: Option<Vec<[f64; 2]>>,
    pub linear_tip_mean: Option<[f64; 2]>,
    pub nonlinear_positions: Option<Vec<[f64; 2]>>,
    pub nonlinear_lowest_eigenvalue: Option<f64>,
    pub nonlinear_tip_mean: Option<[f64; 2]>,
    pub right_x: Option<f64>,
    pub mid_deflection: Option<f64>,
    // Rings.
    #[serde(rename = "J")]
    pub count: Option<usize>,
    #[serde(rename = "R0")]
    pub radius: Option<f64>,
    pub k_surface: Option<f64>,
    pub k_radial: Option<f64>,
    #[serde(rename = "A0_polygon")]
    pub rest_area: Option<f64>,
    #[serde(rename = "A0_over_circle")]
    pub over_circle: Option<f64>,
    pub held_nodes: Option<BTreeMap<usize, [f64; 2]>>,
    pub area_ratio_without_control: Option<f64>,
    #[serde(rename = "radial_rest_length_for_A0")]
    pub radial_rest_length: Option<f64>,
    #[serde(rename = "positions_at_A0")]
    pub controlled: Option<Vec<[f64; 2]>>,
    pub tau: Option<f64>,
    pub quasi_static_area_ratio: Option<Vec<f64>>,
}

/// All cases, from the folder `RAPUNZEL_ORACLES` or the copy in `tests/data`.
pub fn cases() -> Vec<Case> {
    let folder = std::env::var_os("RAPUNZEL_ORACLES").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data"),
        PathBuf::from,
    );
    let path = folder.join("f_mass_spring.json");
    let text = std::fs::read_to_string(&path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let oracle: Oracle =
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(!oracle.cases.is_empty());
    oracle.cases
}

/// Largest relative difference of two lists, by the largest entry.
pub fn difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(f64::MIN_POSITIVE, |a, b| a.max(b.abs()));
    found.iter().zip(expected).fold(0.0, |a: f64, (f, e)| a.max((f - e).abs())) / scale
}

/// Largest distance of nodes from where they should be.
pub fn distance(system: &System<2>, expected: &[[f64; 2]]) -> f64 {
    assert_eq!(system.nodes(), expected.len());
    let away = |(node, e): (usize, &[f64; 2])| {
        (system.position(node).coords - nalgebra::Vector2::from(*e)).norm()
    };
    expected.iter().enumerate().map(away).fold(0.0, f64::max)
}
