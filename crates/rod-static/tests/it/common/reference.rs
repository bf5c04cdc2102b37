//! Cases of the reference files that more than one test reads.

use super::rotation;
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::so3;
use rapunzel_rod_static::{Piece, Properties, State};
use serde::Deserialize;
use std::f64::consts::FRAC_PI_2;

/// The frame of a planar rod at the angle `theta` from x towards y: its tangent is in the plane
/// and d1 out of it.
pub(crate) fn planar(theta: f64) -> Rotation3<f64> {
    so3::exp(&(Vector3::z() * (theta - FRAC_PI_2)))
        * Rotation3::from_basis_unchecked(&[Vector3::z(), Vector3::x(), Vector3::y()])
}

pub(crate) fn pose(frame: Rotation3<f64>) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_rotation_matrix(&frame))
}

/// A case of `b_heavy_elastica_planar.json`: L = EI = 1, gravity -y.
#[derive(Debug, Deserialize)]
pub(crate) struct Elastica {
    pub(crate) name: String,
    #[serde(rename = "G")]
    pub(crate) g: f64,
    pub(crate) clamp_angle_deg: f64,
    pub(crate) kappa0: serde_json::Value,
    pub(crate) equilibria: Vec<PlanarEquilibrium>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct PlanarEquilibrium {
    pub(crate) root_moment: f64,
    pub(crate) stable: bool,
    #[serde(rename = "E_elastic")]
    pub(crate) elastic: f64,
    #[serde(rename = "E_total")]
    pub(crate) energy: f64,
    pub(crate) stations: Vec<PlanarStation>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct PlanarStation {
    pub(crate) s: f64,
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) theta: f64,
    pub(crate) kappa: f64,
}

impl Elastica {
    /// Natural curvature: a number or `a*sin(b*s)`.
    pub(crate) fn natural_curvature(&self) -> impl Fn(f64) -> f64 + Send + Sync + 'static {
        let text = self.kappa0.to_string();
        let text = text.trim_matches('"');
        let number = |t: &str| t.parse::<f64>().expect("a number");
        let (a, b) = match text.split_once("*sin(") {
            None => (number(text), None),
            Some((a, rest)) => (number(a), Some(number(rest.trim_end_matches("*s)")))),
        };
        move |s| b.map_or(a, |b| a * (b * s).sin())
    }

    /// The rod, stiff out of the plane: the reference's stability is that in the plane.
    pub(crate) fn piece(&self) -> Piece {
        let (kappa, g) = (self.natural_curvature(), self.g);
        Piece::varying(1.0, move |s| Properties {
            stiffness: Vector3::new(1.0, 1e3, 1e3),
            natural_curvature: Vector3::new(kappa(s), 0.0, 0.0),
            load: Vector3::new(0.0, -g, 0.0),
        })
    }

    pub(crate) fn clamp(&self) -> Isometry3<f64> {
        pose(planar(self.clamp_angle_deg.to_radians()))
    }

    pub(crate) fn states(&self, equilibrium: &PlanarEquilibrium) -> Vec<(f64, State)> {
        let natural = self.natural_curvature();
        let state = |at: &PlanarStation| State {
            position: Point3::new(at.x, at.y, 0.0),
            frame: planar(at.theta),
            force: Vector3::new(0.0, -self.g * (1.0 - at.s), 0.0),
            moment: Vector3::new(0.0, 0.0, at.kappa - natural(at.s)),
        };
        equilibrium.stations.iter().map(|at| (at.s, state(at))).collect()
    }
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
    #[serde(rename = "E_elastic")]
    pub(crate) elastic: f64,
    #[serde(rename = "E_total")]
    pub(crate) energy: f64,
    pub(crate) stable: bool,
    pub(crate) stations: Vec<HeavyStation>,
}

#[derive(Debug, Deserialize)]
pub(crate) struct HeavyStation {
    pub(crate) s: f64,
    pub(crate) r: [f64; 3],
    #[serde(rename = "R")]
    pub(crate) frame: [[f64; 3]; 3],
    pub(crate) m_fixed: [f64; 3],
}

impl HeavyRod {
    pub(crate) fn piece(&self) -> Piece {
        Piece::uniform(
            1.0,
            Properties {
                stiffness: Vector3::new(self.ei1, self.ei2, self.torsion),
                natural_curvature: Vector3::from(self.kappa0),
                load: Vector3::new(0.0, 0.0, -self.g),
            },
        )
    }

    pub(crate) fn clamp(&self) -> Isometry3<f64> {
        pose(rotation(&self.root))
    }
}

impl PlanarEquilibrium {
    pub(crate) fn tip(&self) -> Point3<f64> {
        let tip = self.stations.last().expect("a station");
        Point3::new(tip.x, tip.y, 0.0)
    }
}

impl Elastica {
    /// The equilibrium of the lowest energy.
    pub(crate) fn lowest(&self) -> &PlanarEquilibrium {
        self.equilibria.first().expect("an equilibrium")
    }
}
