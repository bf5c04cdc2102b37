//! What fibres are made of, all along them.

use super::case::{Case, CaseRod, JoinedRod};
use super::material::{Keratin, MaterialSpec};
use super::taper::TaperPoint;
use super::{Bundle, Scene};
use nalgebra::Vector3;
use rapunzel_fiber::{Material, NodeProperties, Section};
use rapunzel_keratin::{self as keratin, Hair, KeratinError};
use rapunzel_rod_dynamic::SectionLaws;

/// Stiffness, mass and section of a straight fibre, all along it.
#[derive(Debug, Clone, PartialEq)]
pub struct FiberMatter(MatterKind);

#[derive(Debug, Clone, PartialEq)]
enum MatterKind {
    /// The same everywhere.
    Uniform(NodeProperties),
    /// A solid with other sections elsewhere: fractions of the length, ascending from 0 to 1, and
    /// what is there.
    Solid(Material, Vec<(f64, Section)>),
    /// Numbers that change linearly, in the same way.
    Measured(Vec<(f64, NodeProperties)>),
    /// Rods end to end: the fractions of the length at which they begin, ascending from 0, and what
    /// they are.
    Joined(Vec<(f64, NodeProperties)>),
}

/// What is measured of a section.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MeasuredSection {
    /// Bending stiffnesses about d1 and d2, N m^2.
    bending: [f64; 2],
    /// Torsion stiffness, N m^2.
    torsion: f64,
    /// Mass per length, kg/m.
    linear_density: f64,
    /// Rotary inertias per length about d1 and d2, kg m; `None` for those of a homogeneous section.
    rotary_inertia: Option<[f64; 2]>,
}

impl MeasuredSection {
    /// What a point of a table has in place of what the whole fibre has.
    fn at(self, point: &TaperPoint) -> Self {
        Self {
            bending: point.bending.unwrap_or(self.bending),
            torsion: point.torsion.unwrap_or(self.torsion),
            linear_density: point.linear_density.unwrap_or(self.linear_density),
            rotary_inertia: point.rotary_inertia.or(self.rotary_inertia),
        }
    }

    fn node(self, section: Section) -> NodeProperties {
        let (a, b) = section.semi_axes();
        // Of a homogeneous ellipse.
        let own = [b, a].map(|axis| 0.25 * self.linear_density * axis * axis);
        let [first, second] = self.rotary_inertia.unwrap_or(own);
        NodeProperties {
            section,
            linear_density: self.linear_density,
            rotary_inertia: Vector3::new(first, second, first + second),
            stiffness: Vector3::new(self.bending[0], self.bending[1], self.torsion),
            natural_curvature: Vector3::zeros(),
        }
    }
}

impl FiberMatter {
    /// The same everywhere.
    fn uniform(node: NodeProperties) -> Self {
        Self(MatterKind::Uniform(node))
    }

    /// A solid of a material, of one section, or of those of a table, in which it is left out where
    /// it is that of the whole.
    fn solid(material: Material, section: Section, taper: &[TaperPoint]) -> Self {
        if taper.is_empty() {
            return Self::uniform(NodeProperties::new(section, &material));
        }
        let sections = taper.iter().map(|point| (point.at, point.section.unwrap_or(section)));
        Self(MatterKind::Solid(material, sections.collect()))
    }

    /// What is measured, everywhere the same or by a table.
    fn measured(own: MeasuredSection, section: Section, taper: &[TaperPoint]) -> Self {
        if taper.is_empty() {
            return Self::uniform(own.node(section));
        }
        let node = |point: &TaperPoint| own.at(point).node(point.section.unwrap_or(section));
        Self(MatterKind::Measured(taper.iter().map(|point| (point.at, node(point))).collect()))
    }

    /// The properties at a fraction of the length from the root, 0 to 1; naturally straight.
    #[must_use]
    pub fn at(&self, fraction: f64) -> NodeProperties {
        match &self.0 {
            MatterKind::Uniform(node) => *node,
            MatterKind::Solid(material, points) => {
                let ([a, b], t) = around(points, fraction);
                NodeProperties::new(between_sections(&a, &b, t), material)
            }
            MatterKind::Measured(points) => {
                let ([a, b], t) = around(points, fraction);
                NodeProperties {
                    section: between_sections(&a.section, &b.section, t),
                    linear_density: between(a.linear_density, b.linear_density, t),
                    rotary_inertia: a.rotary_inertia.zip_map(&b.rotary_inertia, mix(t)),
                    stiffness: a.stiffness.zip_map(&b.stiffness, mix(t)),
                    natural_curvature: Vector3::zeros(),
                }
            }
            MatterKind::Joined(parts) => {
                let next = parts.partition_point(|part| part.0 <= fraction);
                parts[next.saturating_sub(1)].1
            }
        }
    }

    /// The properties of all nodes of a fibre in segments of these lengths, m.
    #[must_use]
    pub fn along(&self, lengths: &[f64]) -> Vec<NodeProperties> {
        if let MatterKind::Uniform(node) = &self.0 {
            return vec![*node; lengths.len() + 1];
        }
        let whole: f64 = lengths.iter().sum();
        let ends = lengths.iter().scan(0.0, |s, length| {
            *s += length;
            Some(*s / whole)
        });
        std::iter::once(0.0).chain(ends).map(|fraction| self.at(fraction)).collect()
    }

    /// Fractions of the length between which the properties change smoothly, but for 0 and 1.
    pub fn kinks(&self) -> impl Iterator<Item = f64> {
        let all: Vec<f64> = match &self.0 {
            MatterKind::Uniform(_) => Vec::new(),
            MatterKind::Solid(_, points) => points.iter().map(|point| point.0).collect(),
            MatterKind::Measured(points) | MatterKind::Joined(points) => {
                points.iter().map(|point| point.0).collect()
            }
        };
        all.into_iter().filter(|at| *at > 0.0 && *at < 1.0)
    }

    /// Whether it is the same everywhere.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        matches!(self.0, MatterKind::Uniform(_))
    }

    /// An equivalent radius, m, that no section exceeds, and where there is one section its own.
    #[must_use]
    pub fn thickest(&self) -> f64 {
        let largest = |all: &mut dyn Iterator<Item = Section>| {
            let most = all.map(|section| section.semi_axes());
            let (a, b) = most.fold((0.0, 0.0), |m: (f64, f64), s| (m.0.max(s.0), m.1.max(s.1)));
            (a * b).sqrt()
        };
        match &self.0 {
            MatterKind::Uniform(node) => node.section.equivalent_radius(),
            MatterKind::Solid(_, points) => largest(&mut points.iter().map(|point| point.1)),
            MatterKind::Measured(points) | MatterKind::Joined(points) => {
                largest(&mut points.iter().map(|point| point.1.section))
            }
        }
    }

    /// Equivalent radius in the middle of the length, m: by it the air drags the whole fibre, whose
    /// drag depends on the logarithm of its radius only.
    #[must_use]
    pub fn middle_radius(&self) -> f64 {
        self.at(0.5).section.equivalent_radius()
    }
}

/// The two points about a fraction, and where between them it is, 0 to 1.
fn around<T: Copy>(points: &[(f64, T)], fraction: f64) -> ([T; 2], f64) {
    let after = points.partition_point(|point| point.0 <= fraction).clamp(1, points.len() - 1);
    let [a, b] = [points[after - 1], points[after]];
    ([a.1, b.1], ((fraction - a.0) / (b.0 - a.0)).clamp(0.0, 1.0))
}

/// A number between two, exactly the one or the other at the ends.
fn between(a: f64, b: f64, t: f64) -> f64 {
    if a == b { a } else { (1.0 - t) * a + t * b }
}

fn mix(t: f64) -> impl Fn(f64, f64) -> f64 {
    move |a, b| between(a, b, t)
}

fn between_sections(a: &Section, b: &Section, t: f64) -> Section {
    match (a, b) {
        (Section::Circle { radius: a }, Section::Circle { radius: b }) => {
            Section::Circle { radius: between(*a, *b, t) }
        }
        _ => {
            let (a, b) = (a.semi_axes(), b.semi_axes());
            Section::Ellipse { a: between(a.0, b.0, t), b: between(a.1, b.1, t) }
        }
    }
}

impl Scene {
    /// What the fibres of a bundle are made of, and the laws of their sections, at time `t`, s.
    ///
    /// # Errors
    /// [`KeratinError`] for hair that is not known in the climate at that time.
    pub fn matter(
        &self,
        bundle: &Bundle,
        t: f64,
    ) -> Result<(FiberMatter, SectionLaws), KeratinError> {
        let taper = &bundle.taper;
        if let Some(keratin) = bundle.material.keratin() {
            let climate = self.environment.climate.at(t)?;
            if taper.is_empty() {
                let (node, laws) = keratin.rod(&keratin.hair(bundle.section)?, &climate)?;
                return Ok((FiberMatter::uniform(node), laws));
            }
            let matter = tapered_hair(&keratin, bundle.section, taper, &climate)?;
            return Ok((matter, SectionLaws::Linear));
        }
        // Where it is needed and missing, the scene has been refused.
        let section = bundle.section.unwrap_or(Section::Circle { radius: 0.0 });
        let matter = bundle.material.matter(section, taper)?;
        Ok((matter, SectionLaws::Linear))
    }
}

impl Case {
    /// What the rod is made of, all along it.
    ///
    /// # Panics
    /// If the material is one that the [problems](Self::problems) of the case name.
    #[must_use]
    pub fn matter(&self) -> FiberMatter {
        let own = self.rod.matter(&self.taper);
        if self.joined.is_empty() {
            return own;
        }
        let other = |part: &JoinedRod| {
            let node = part.rod.matter(&[]).at(0.0);
            let natural_curvature = Vector3::from(part.natural_curvature);
            (part.from / self.length, NodeProperties { natural_curvature, ..node })
        };
        let natural_curvature = Vector3::from(self.natural_curvature);
        let first = (0.0, NodeProperties { natural_curvature, ..own.at(0.0) });
        let parts = [first].into_iter().chain(self.joined.iter().map(other));
        FiberMatter(MatterKind::Joined(parts.collect()))
    }
}

impl CaseRod {
    /// What it is made of; the case has been checked.
    fn matter(self, taper: &[TaperPoint]) -> FiberMatter {
        match self {
            Self::Solid { section, material } => {
                material.matter(section, taper).expect("the case has been checked")
            }
            Self::Measured { bending, torsion, linear_density, radius } => {
                let own =
                    MeasuredSection { bending, torsion, linear_density, rotary_inertia: None };
                FiberMatter::measured(own, Section::Circle { radius }, taper)
            }
        }
    }
}

impl MaterialSpec {
    /// What a fibre is made of; keratin in the standard climate, 65 % and 23 C.
    ///
    /// # Errors
    /// [`KeratinError`] for keratin with a property that is not measured.
    fn matter(&self, section: Section, taper: &[TaperPoint]) -> Result<FiberMatter, KeratinError> {
        Ok(match *self {
            Self::Measured { bending, torsion, linear_density, rotary_inertia } => {
                let own = MeasuredSection { bending, torsion, linear_density, rotary_inertia };
                FiberMatter::measured(own, section, taper)
            }
            _ => FiberMatter::solid(self.solid()?, section, taper),
        })
    }
}

/// Hair whose sections, at 65 % humidity, are those of a table.
fn tapered_hair(
    keratin: &Keratin,
    section: Option<Section>,
    taper: &[TaperPoint],
    climate: &keratin::Climate,
) -> Result<FiberMatter, KeratinError> {
    let hair: Hair = keratin.hair(section)?;
    // Neither density nor moduli depend on the diameters.
    let material = Material {
        density: hair.density(climate).value,
        youngs_modulus: hair.bending_modulus(climate)?.value,
        shear_modulus: hair.shear_modulus(climate)?.value,
    };
    let swollen = |point: &TaperPoint| {
        let own = keratin.hair(point.section.or(section))?.section(climate);
        Ok((point.at, own))
    };
    let sections: Vec<_> = taper.iter().map(swollen).collect::<Result<_, KeratinError>>()?;
    Ok(FiberMatter(MatterKind::Solid(material, sections)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(at: f64, section: Section) -> TaperPoint {
        TaperPoint {
            at,
            section: Some(section),
            bending: None,
            torsion: None,
            linear_density: None,
            rotary_inertia: None,
        }
    }

    #[test]
    fn a_cone_has_the_stiffness_of_its_radius_everywhere() {
        let table = [1e-4, 3e-5].map(|radius| Section::Circle { radius });
        let table = [point(0.0, table[0]), point(1.0, table[1])];
        let cone = FiberMatter::solid(Material::HAIR, Section::Circle { radius: 1.0 }, &table);
        for i in 0..=10 {
            let t = f64::from(i) / 10.0;
            let radius = 1e-4 - 7e-5 * t;
            let right = NodeProperties::new(Section::Circle { radius }, &Material::HAIR);
            let found = cone.at(t);
            // A fourth power of a rounded radius.
            assert!((found.stiffness - right.stiffness).norm() < 1e-14 * right.stiffness.norm());
            assert!((found.linear_density / right.linear_density - 1.0).abs() < 1e-14);
        }
        let nodes = cone.along(&[0.1, 0.3]);
        assert_eq!(nodes, [0.0, 0.25, 1.0].map(|t| cone.at(t)));
        assert_eq!((cone.thickest(), cone.kinks().count()), (1e-4, 0));
    }

    #[test]
    fn what_is_measured_changes_linearly_between_the_points_that_give_it() {
        let circle = Section::Circle { radius: 2e-3 };
        let own = MeasuredSection {
            bending: [1e-3, 2e-3],
            torsion: 5e-4,
            linear_density: 0.02,
            rotary_inertia: None,
        };
        let softer = TaperPoint { bending: Some([5e-4, 1e-3]), ..point(0.5, circle) };
        let table = [point(0.0, circle), softer, point(1.0, circle)];
        let cable = FiberMatter::measured(own, circle, &table);
        let [whole, quarter] = [0.0, 0.25].map(|t| cable.at(t));
        assert_eq!(whole.stiffness, Vector3::new(1e-3, 2e-3, 5e-4));
        assert_eq!(quarter.stiffness, Vector3::new(7.5e-4, 1.5e-3, 5e-4));
        assert_eq!(cable.kinks().collect::<Vec<_>>(), [0.5]);
        // A disc of radius r has mu r^2 / 4 about a diameter.
        assert_eq!(whole.rotary_inertia, Vector3::new(2e-8, 2e-8, 4e-8));
    }
}
