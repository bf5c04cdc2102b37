use crate::error::positive;
use crate::{FiberError, Section, so3};
use nalgebra::{Isometry3, Point3, Rotation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A homogeneous, linearly elastic material.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Mass density, kg/m^3.
    pub density: f64,
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Shear modulus, Pa.
    pub shear_modulus: f64,
}

impl Material {
    /// Dry human hair: 1300 kg/m^3, 3.8 GPa, a third of it in shear.
    pub const HAIR: Self =
        Self { density: 1300.0, youngs_modulus: 3.8e9, shear_modulus: 3.8e9 / 3.0 };

    /// Checks that all moduli are positive and finite.
    ///
    /// # Errors
    /// [`FiberError::NotPositive`] names the one that is not.
    pub fn validate(&self) -> Result<(), FiberError> {
        positive("density (kg/m^3)", self.density)?;
        positive("Young's modulus (Pa)", self.youngs_modulus)?;
        positive("shear modulus (Pa)", self.shear_modulus)
    }
}

/// Properties of a fibre at one node.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NodeProperties {
    /// Cross section, its axes along d1 and d2.
    pub section: Section,
    /// Mass per length, kg/m.
    pub linear_density: f64,
    /// Rotary inertia per length about d1, d2, d3: `rho (I1, I2, I1 + I2)`, kg m.
    pub rotary_inertia: Vector3<f64>,
    /// Bending stiffness about d1 and d2 and torsional stiffness: `(E I1, E I2, G J)`, N m^2.
    pub stiffness: Vector3<f64>,
    /// Darboux vector of the unloaded fibre in the material frame, 1/m.
    pub natural_curvature: Vector3<f64>,
}

impl NodeProperties {
    /// A straight, homogeneous node of the given section and material.
    #[must_use]
    pub fn new(section: Section, material: &Material) -> Self {
        let [i1, i2, i3] = section.second_moments();
        let e = material.youngs_modulus;
        Self {
            section,
            linear_density: material.density * section.area(),
            rotary_inertia: material.density * Vector3::new(i1, i2, i3),
            stiffness: Vector3::new(
                e * i1,
                e * i2,
                material.shear_modulus * section.torsion_constant(),
            ),
            natural_curvature: Vector3::zeros(),
        }
    }

    fn validate(&self, index: usize) -> Result<(), FiberError> {
        self.section.validate()?;
        positive("linear density (kg/m)", self.linear_density)?;
        for i in 0..3 {
            positive("rotary inertia (kg m)", self.rotary_inertia[i])?;
            positive("stiffness (N m^2)", self.stiffness[i])?;
        }
        if self.natural_curvature.iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            Err(FiberError::NotFinite { quantity: "natural curvature", index })
        }
    }
}

/// A fibre in its natural state: segments of fixed length between nodes that carry its
/// properties, and the pose of its root.
///
/// A fibre of `n` segments has `n + 1` nodes. The root pose maps the material frame at the root
/// (columns d1, d2, d3, the tangent last) and the position of node 0 to the world.
///
/// Copies share their segments and nodes, also with other roots: copies in a bundle cost little
/// memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Fiber {
    root: Isometry3<f64>,
    segment_lengths: Arc<[f64]>,
    nodes: Arc<[NodeProperties]>,
}

impl Fiber {
    /// A fibre from its parts.
    ///
    /// # Errors
    /// Refuses an empty fibre, mismatched counts, and numbers that are not finite or, where they
    /// must be, not positive.
    pub fn new(
        root: Isometry3<f64>,
        segment_lengths: Vec<f64>,
        nodes: Vec<NodeProperties>,
    ) -> Result<Self, FiberError> {
        if segment_lengths.is_empty() {
            return Err(FiberError::NoSegments);
        }
        if nodes.len() != segment_lengths.len() + 1 {
            return Err(FiberError::NodeCount {
                segments: segment_lengths.len(),
                nodes: nodes.len(),
            });
        }
        segment_lengths.iter().try_for_each(|&l| positive("segment length (m)", l))?;
        nodes.iter().enumerate().try_for_each(|(i, n)| n.validate(i))?;
        let pose = root.translation.vector.iter().chain(root.rotation.coords.iter());
        if pose.clone().any(|x| !x.is_finite()) {
            return Err(FiberError::NotFinite { quantity: "root pose", index: 0 });
        }
        Ok(Self { root, segment_lengths: segment_lengths.into(), nodes: nodes.into() })
    }

    /// A straight fibre of equal segments and constant properties, its root at the origin and its
    /// tangent along the world's z axis.
    ///
    /// # Errors
    /// As [`Fiber::new`].
    pub fn uniform(
        length: f64,
        segments: usize,
        section: Section,
        material: &Material,
    ) -> Result<Self, FiberError> {
        positive("length (m)", length)?;
        section.validate()?;
        material.validate()?;
        if segments == 0 {
            return Err(FiberError::NoSegments);
        }
        let node = NodeProperties::new(section, material);
        Self::new(
            Isometry3::identity(),
            vec![length / segments as f64; segments],
            vec![node; segments + 1],
        )
    }

    /// Moves the root of the fibre to `root`.
    #[must_use]
    pub fn with_root(mut self, root: Isometry3<f64>) -> Self {
        self.root = root;
        self
    }

    /// Replaces the natural curvature by `kappa(s)` (material frame, 1/m), `s` the arc length in
    /// metres.
    ///
    /// # Errors
    /// [`FiberError::NotFinite`] where `kappa` is not finite.
    pub fn with_natural_curvature(
        self,
        kappa: impl Fn(f64) -> Vector3<f64>,
    ) -> Result<Self, FiberError> {
        let kappas: Vec<_> = arc_lengths(&self.segment_lengths).map(kappa).collect();
        self.with_node_curvatures(&kappas)
    }

    /// Replaces the natural curvatures by one for each node (material frame, 1/m).
    ///
    /// # Errors
    /// Refuses a number of curvatures other than one for each node, and curvatures that are not
    /// finite.
    pub fn with_node_curvatures(self, kappas: &[Vector3<f64>]) -> Result<Self, FiberError> {
        if kappas.len() != self.nodes.len() {
            return Err(FiberError::NodeCount { segments: self.segments(), nodes: kappas.len() });
        }
        let bent = |(node, kappa): (&NodeProperties, &Vector3<f64>)| NodeProperties {
            natural_curvature: *kappa,
            ..*node
        };
        let nodes = self.nodes.iter().zip(kappas).map(bent).collect();
        Self::new(self.root, self.segment_lengths.to_vec(), nodes)
    }

    /// The pose of the root: node 0 and its material frame.
    #[must_use]
    pub fn root(&self) -> &Isometry3<f64> {
        &self.root
    }

    /// Number of segments, one less than the number of nodes.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.segment_lengths.len()
    }

    /// Rest lengths of the segments, m.
    #[must_use]
    pub fn segment_lengths(&self) -> &[f64] {
        &self.segment_lengths
    }

    /// Properties at the nodes, from root to tip.
    #[must_use]
    pub fn nodes(&self) -> &[NodeProperties] {
        &self.nodes
    }

    /// Total length of the fibre, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.segment_lengths.iter().sum()
    }

    /// Arc lengths of the nodes, m, starting at 0.
    #[must_use]
    pub fn arc_lengths(&self) -> Vec<f64> {
        arc_lengths(&self.segment_lengths).collect()
    }

    /// Mass of segment `i`, kg: its length times the mean linear density of its ends.
    #[must_use]
    pub fn segment_mass(&self, i: usize) -> f64 {
        let (a, b) = (self.nodes[i].linear_density, self.nodes[i + 1].linear_density);
        0.5 * self.segment_lengths[i] * (a + b)
    }

    /// Total mass of the fibre, kg.
    #[must_use]
    pub fn mass(&self) -> f64 {
        (0..self.segments()).map(|i| self.segment_mass(i)).sum()
    }

    /// The unloaded shape: positions of the nodes and material frames at them (world).
    ///
    /// Each segment carries the mean natural curvature of its ends and is the exact helix of that
    /// curvature; for constant natural curvature the shape is exact.
    #[must_use]
    pub fn rest_shape(&self) -> (Vec<Point3<f64>>, Vec<Rotation3<f64>>) {
        let mut frame = UnitQuaternion::to_rotation_matrix(self.root.rotation);
        let mut position = Point3::from(self.root.translation.vector);
        let mut positions = vec![position];
        let mut frames = vec![frame];
        for (i, &length) in self.segment_lengths.iter().enumerate() {
            let kappa =
                0.5 * (self.nodes[i].natural_curvature + self.nodes[i + 1].natural_curvature);
            let turn = kappa * length;
            // r(h) - r(0) = R int exp(s kappa) ds d3, whose matrix is the left Jacobian.
            position += frame * (so3::right_jacobian(&-turn) * Vector3::z() * length);
            frame *= so3::exp(&turn);
            positions.push(position);
            frames.push(frame);
        }
        (positions, frames)
    }
}

fn arc_lengths(segments: &[f64]) -> impl Iterator<Item = f64> {
    std::iter::once(0.0).chain(segments.iter().scan(0.0, |s, l| {
        *s += l;
        Some(*s)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    fn hair() -> Fiber {
        Fiber::uniform(0.3, 100, Section::Circle { radius: 35e-6 }, &Material::HAIR)
            .expect("valid hair")
    }

    #[test]
    fn hair_has_the_reference_case_numbers() {
        // The reference case of the field: EI = 4.479e-9 N m^2, weight 4.908e-5 N/m.
        let node = hair().nodes()[0];
        assert_relative_eq!(node.stiffness.x, 4.479e-9, max_relative = 1e-3);
        assert_relative_eq!(9.81 * node.linear_density, 4.908e-5, max_relative = 1e-3);
        assert_relative_eq!(hair().mass(), 0.3 * node.linear_density, max_relative = 1e-14);
    }

    #[test]
    fn constant_curvature_closes_a_circle() {
        let ring = hair()
            .with_natural_curvature(|_| Vector3::new(TAU / 0.3, 0.0, 0.0))
            .expect("finite curvature");
        let (positions, frames) = ring.rest_shape();
        assert_relative_eq!((positions[100] - positions[0]).norm(), 0.0, epsilon = 1e-15);
        assert_relative_eq!(frames[100].matrix(), frames[0].matrix(), epsilon = 1e-13);
        // A quarter turn about d1 takes the tangent from z to -y at radius L / 2 pi.
        assert_relative_eq!(positions[50].y, -0.3 / std::f64::consts::PI, max_relative = 1e-13);
    }

    #[test]
    fn nonsense_is_refused() {
        let section = Section::Circle { radius: 35e-6 };
        assert_eq!(Fiber::uniform(0.3, 0, section, &Material::HAIR), Err(FiberError::NoSegments));
        assert!(Fiber::uniform(-0.3, 10, section, &Material::HAIR).is_err(), "negative length");
        assert!(hair().with_natural_curvature(|_| Vector3::repeat(f64::NAN)).is_err(), "NaN");
    }
}
