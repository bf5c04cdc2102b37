//! What the integration tests share: reference cases, rods in scaled units.
use nalgebra::{DMatrix, Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, Material, NodeProperties, Section};
use rapunzel_rod_dynamic::{
    Conditions, Impulses, Point, PointAction, RodStepReport, StaggeredBatch, StepError,
};
use serde::Deserialize;

/// Checks a method of second order in its mesh by its errors on a mesh and on one twice as fine,
/// for any load: what is left of them by Richardson's extrapolation is a quarter of the finer one
/// at most, beside the `accuracy` of the reference.
pub(crate) fn assert_second_order(
    name: &str,
    coarse: &Vector3<f64>,
    fine: &Vector3<f64>,
    accuracy: f64,
) {
    let left = ((fine * 4.0 - coarse) / 3.0).norm();
    let allowed = 0.25 * fine.norm() + accuracy;
    assert!(left < allowed, "{name}: off by {coarse}, {fine}, extrapolated {left:e}");
}

/// A case of `d_planar_swing.json`: L = g = rho A = 1, EI = 1/G, gravity -y.
#[derive(Debug, Deserialize)]
pub(crate) struct Swing {
    pub(crate) name: String,
    #[serde(rename = "G")]
    pub(crate) g: f64,
    pub(crate) clamp_angle_deg: f64,
    #[serde(default)]
    pub(crate) kappa0: f64,
    #[serde(default)]
    pub(crate) eps: f64,
    #[serde(default)]
    pub(crate) damp: f64,
    #[serde(default)]
    pub(crate) ramp_time: f64,
    pub(crate) t: Vec<f64>,
    pub(crate) tip: Vec<[f64; 2]>,
    #[serde(rename = "max_self_difference")]
    pub(crate) accuracy: f64,
}

impl Swing {
    /// Gravity at time `t`, ramped as the oracle's note says.
    pub(crate) fn gravity(&self, t: f64) -> Vector3<f64> {
        let factor = if t < self.ramp_time {
            0.5 * (1.0 - (std::f64::consts::PI * t / self.ramp_time).cos())
        } else {
            1.0
        };
        Vector3::new(0.0, -factor, 0.0)
    }

    /// The fibre of the case; where the oracle has no rotary inertia, one too small to matter.
    pub(crate) fn fiber(&self, segments: usize) -> Fiber {
        let mut node = scaled(1.0 / self.g, 1.0 / self.g);
        node.rotary_inertia = Vector3::new(1.0, 1.0, 2.0) * self.eps.max(1e-8);
        node.natural_curvature.x = self.kappa0;
        chain(segments, |_| node).with_root(planar_clamp(self.clamp_angle_deg.to_radians()))
    }
}

/// A case of `d_linear_frequencies.json`; which fields there are depends on its kind.
#[derive(Debug, Deserialize)]
pub(crate) struct Frequencies {
    pub(crate) name: String,
    #[serde(rename = "E")]
    pub(crate) youngs_modulus: Option<f64>,
    pub(crate) rho: Option<f64>,
    pub(crate) radius: Option<f64>,
    #[serde(rename = "L")]
    pub(crate) length: Option<f64>,
    pub(crate) shear_modulus: Option<f64>,
    #[serde(rename = "freq_Hz_with_rotary_inertia")]
    pub(crate) bending_hz: Option<Vec<f64>>,
    #[serde(rename = "torsion_freq_Hz")]
    pub(crate) torsion_hz: Option<Vec<f64>>,
    #[serde(rename = "G")]
    pub(crate) gravity_parameter: Option<f64>,
    #[serde(rename = "omega_in_sqrt_EI_over_rhoA_L4")]
    pub(crate) omega_bending: Option<Vec<f64>>,
    #[serde(rename = "rhoI_over_rhoAL2")]
    pub(crate) rotary_inertia: Option<f64>,
    pub(crate) g: Option<f64>,
    pub(crate) omega: Option<Vec<f64>>,
}

/// A case of `b_heavy_elastica_planar.json`: L = EI = 1, G = rho A g L^3 / EI, gravity -y.
#[derive(Debug, Deserialize)]
pub(crate) struct Elastica {
    pub(crate) name: String,
    #[serde(rename = "G")]
    pub(crate) g: f64,
    pub(crate) clamp_angle_deg: f64,
    /// A number or a formula in s.
    pub(crate) kappa0: serde_json::Value,
    pub(crate) equilibria: Vec<Equilibrium>,
}

impl Elastica {
    /// How much a steep rod near the load that buckles an upright one (Greenhill 1881) makes of an
    /// error.
    pub(crate) fn sensitivity(&self) -> f64 {
        const GREENHILL: f64 = 7.837_347_439;
        if self.clamp_angle_deg > 60.0 { 1.0 + GREENHILL / (self.g - GREENHILL).abs() } else { 1.0 }
    }

    /// Natural curvature at `s`: the oracle has numbers and `a*sin(b*s)`.
    pub(crate) fn natural_curvature(&self, s: f64) -> f64 {
        let text = self.kappa0.to_string();
        let text = text.trim_matches('"');
        let number =
            |t: &str| t.parse::<f64>().unwrap_or_else(|e| panic!("{}: {t}: {e}", self.name));
        match text.split_once("*sin(") {
            None => number(text),
            Some((a, rest)) => number(a) * (number(rest.trim_end_matches("*s)")) * s).sin(),
        }
    }
}

#[derive(Debug, Deserialize)]
pub(crate) struct Equilibrium {
    pub(crate) tip: [f64; 2],
    pub(crate) stable: bool,
}

/// A case of `b_heavy_rod_3d.json`: L = 1, gravity -z.
#[derive(Debug, Deserialize)]
pub(crate) struct HeavyRod {
    pub(crate) name: String,
    #[serde(rename = "G")]
    pub(crate) g: f64,
    #[serde(rename = "EI1")]
    pub(crate) ei1: f64,
    #[serde(rename = "EI2")]
    pub(crate) ei2: f64,
    #[serde(rename = "Gmu")]
    pub(crate) torsion: f64,
    pub(crate) kappa0: [f64; 3],
    #[serde(rename = "R0")]
    pub(crate) root: [[f64; 3]; 3],
    pub(crate) tip: [f64; 3],
}

impl HeavyRod {
    /// The fibre of the case, of mass 1 per length.
    pub(crate) fn fiber(&self, segments: usize) -> Fiber {
        let mut node = scaled(self.ei1, self.torsion);
        node.stiffness.y = self.ei2;
        node.natural_curvature = Vector3::from(self.kappa0);
        let rows = self.root;
        let matrix = Matrix3::from_fn(|i, j| rows[i][j]);
        let frame = Rotation3::from_matrix_unchecked(matrix);
        chain(segments, |_| node).with_root(Isometry3::from_parts(
            Vector3::zeros().into(),
            UnitQuaternion::from_rotation_matrix(&frame),
        ))
    }
}

/// A case of `c_clamped_clamped.json`: L = 1, gravity -z, the root at the origin.
#[derive(Debug, Deserialize)]
pub(crate) struct Clamped {
    pub(crate) name: String,
    #[serde(rename = "G")]
    pub(crate) g: f64,
    #[serde(rename = "EI1")]
    pub(crate) ei1: f64,
    #[serde(rename = "EI2")]
    pub(crate) ei2: f64,
    #[serde(rename = "Gmu")]
    pub(crate) torsion: f64,
    pub(crate) kappa0: [f64; 3],
    pub(crate) start_moment: [f64; 3],
    pub(crate) path_from_start_state: Vec<Waypoint>,
    pub(crate) stations: Vec<Station>,
    #[serde(rename = "E_elastic")]
    pub(crate) elastic_energy: f64,
}

#[derive(Debug, Deserialize)]
pub(crate) struct Waypoint {
    pub(crate) r: [f64; 3],
    pub(crate) rotvec: [f64; 3],
}

#[derive(Debug, Deserialize)]
pub(crate) struct Station {
    pub(crate) s: f64,
    pub(crate) r: [f64; 3],
}

impl Clamped {
    /// The fibre of the case, of mass 1 per length.
    pub(crate) fn fiber(&self, segments: usize) -> Fiber {
        let mut node = scaled(self.ei1, self.torsion);
        node.stiffness.y = self.ei2;
        node.natural_curvature = Vector3::from(self.kappa0);
        chain(segments, |_| node)
    }
}

/// A node of mass 1 per length and the given stiffnesses, its rotary inertia negligible.
pub(crate) fn scaled(bending: f64, torsion: f64) -> NodeProperties {
    NodeProperties {
        section: Section::Circle { radius: 1e-3 },
        linear_density: 1.0,
        rotary_inertia: Vector3::new(1.0, 1.0, 2.0) * 1e-8,
        stiffness: Vector3::new(bending, bending, torsion),
        natural_curvature: Vector3::zeros(),
    }
}

/// A fibre of length 1 along z with the properties `node(s)`.
pub(crate) fn chain(segments: usize, node: impl Fn(f64) -> NodeProperties) -> Fiber {
    let h = 1.0 / segments as f64;
    let nodes = (0..=segments).map(|j| node(j as f64 * h)).collect();
    Fiber::new(Isometry3::identity(), vec![h; segments], nodes).expect("a valid chain")
}

/// A clamp at the origin whose tangent is at `angle` from the x axis in the xy plane, d1 along z,
/// so that positive curvature about d1 bends counterclockwise.
pub(crate) fn planar_clamp(angle: f64) -> Isometry3<f64> {
    let (s, c) = angle.sin_cos();
    let frame =
        Matrix3::from_columns(&[Vector3::z(), Vector3::new(s, -c, 0.0), Vector3::new(c, s, 0.0)]);
    let frame = Rotation3::from_matrix_unchecked(frame);
    Isometry3::from_parts(Vector3::zeros().into(), UnitQuaternion::from_rotation_matrix(&frame))
}

/// The reference hair of the field: 0.3 m long, 35 um thick in radius, clamped horizontally.
pub(crate) fn hair(segments: usize) -> Fiber {
    Fiber::uniform(0.3, segments, Section::Circle { radius: 35e-6 }, &Material::HAIR)
        .expect("a valid hair")
        .with_root(planar_clamp(0.0))
}

/// Standard gravity of the reference cases, -y.
pub(crate) const GRAVITY: Vector3<f64> = Vector3::new(0.0, -9.81, 0.0);

/// The slope of log(error) against log(step) between neighbours: measured orders.
pub(crate) fn orders(steps: &[f64], errors: &[f64]) -> Vec<f64> {
    steps
        .windows(2)
        .zip(errors.windows(2))
        .map(|(h, e)| (e[0] / e[1]).ln() / (h[0] / h[1]).ln())
        .collect()
}

/// The matrix of some responses of so many points or nodes to impulses, column by column.
pub(crate) fn response_matrix(
    count: usize,
    mut respond: impl FnMut(&[Vector3<f64>], &mut [Vector3<f64>]),
) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(3 * count, 3 * count);
    for column in 0..3 * count {
        let mut impulses = vec![Vector3::zeros(); count];
        let mut velocities = impulses.clone();
        impulses[column / 3][column % 3] = 1.0;
        respond(&impulses, &mut velocities);
        for (i, velocity) in velocities.iter().enumerate() {
            matrix.fixed_view_mut::<3, 1>(3 * i, column).copy_from(velocity);
        }
    }
    matrix
}

/// The nodes of fibres with so many segments each, fibre by fibre.
pub(crate) fn node_points(fibers: usize, segments: usize) -> Vec<Point> {
    let node = |(fiber, node): (usize, usize)| {
        let segment = node.min(segments - 1);
        Point::on_axis(number(fiber), number(segment), (node - segment) as f64)
    };
    (0..fibers).flat_map(|fiber| (0..=segments).map(move |a| (fiber, a))).map(node).collect()
}

/// The segments of a fibre, each with a couple.
pub(crate) fn couples(segments: usize) -> Vec<Point> {
    let action = PointAction::Couple { lever: Matrix3::identity() };
    (0..number(segments)).map(|segment| Point { fiber: 0, segment, action }).collect()
}

fn number(index: usize) -> u32 {
    u32::try_from(index).expect("few")
}

/// Sets a batch out on a step with `impulses` at its start and takes Newton's method to its end, as
/// a solver of contacts does with impulses that it changes meanwhile; what answers impulses is
/// linearised there.
pub(crate) fn set_out_and_solve(
    batch: &mut StaggeredBatch,
    dt: f64,
    conditions: &[&dyn Conditions],
    impulses: Impulses,
) -> Result<(), StepError> {
    let mut reports = vec![RodStepReport::default(); batch.rods().len()];
    batch.set_out(dt, conditions, impulses, &mut reports)?;
    let mut residuals = Vec::new();
    // What follows a turn this small is its square.
    while residuals.last().is_none_or(|turn| *turn > 1e-10) {
        if residuals.len() == 30 {
            batch.abandon();
            return Err(StepError::NotConverged { fiber: 0, time: batch.time(), dt, residuals });
        }
        batch.linearize()?;
        residuals.push(batch.advance(impulses)?);
    }
    batch.linearize().map(|_| ())
}
