use super::check::Check;
use super::material::{Law, MaterialSpec, check_measured};
use super::section::check_section;
use rapunzel_fiber::Section;
use serde::{Deserialize, Serialize};

/// A point of a table of what a fibre is along itself.
///
/// Between two points all that they give changes linearly in the arc length; stiffness and mass of
/// a solid follow from the section there. The first point is the root, the last the tip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaperPoint {
    /// Arc length of the point as a fraction of the length, 0 at the root and 1 at the tip.
    pub at: f64,
    /// Cross section there, m; left out, the one that is given for the whole fibre.
    #[serde(default)]
    pub section: Option<Section>,
    /// Bending stiffnesses about d1 and d2 there, N m^2, of what is measured; left out, those of
    /// the whole fibre.
    #[serde(default)]
    pub bending: Option<[f64; 2]>,
    /// Torsion stiffness there, N m^2, of what is measured; left out, that of the whole fibre.
    #[serde(default)]
    pub torsion: Option<f64>,
    /// Mass per length there, kg/m, of what is measured; left out, that of the whole fibre.
    #[serde(default)]
    pub linear_density: Option<f64>,
    /// Rotary inertias per length about d1 and d2 there, kg m, of what is measured; left out, those
    /// of the whole fibre.
    #[serde(default)]
    pub rotary_inertia: Option<[f64; 2]>,
}

/// What a table of taper belongs to.
pub(crate) struct Tapered {
    /// Length of the fibre, m; zero where it is not known yet.
    pub(crate) length: f64,
    /// Whether stiffness and mass are given as numbers.
    pub(crate) measured: bool,
    /// Whether the whole fibre has a section.
    pub(crate) has_section: bool,
}

/// Reports problems of a table of taper.
pub(crate) fn check_taper(check: &mut Check, taper: &[TaperPoint], of: &Tapered) {
    if taper.is_empty() {
        return;
    }
    if taper.len() < 2 {
        check.refuse("taper", "has one point, but needs one at the root and one at the tip".into());
        return;
    }
    let (first, last) = (taper[0].at, taper[taper.len() - 1].at);
    if first != 0.0 {
        let message = format!("is {first:?}, but the table must begin at the root: give at: 0");
        check.refuse("taper[0].at", message);
    }
    if last != 1.0 {
        let message = format!(
            "is {last:?}, a fraction of the length, but the table must end at the tip: give at: 1"
        );
        check.refuse(&format!("taper[{}].at", taper.len() - 1), message);
    }
    for (i, pair) in taper.windows(2).enumerate() {
        // So that what is not a number is refused too.
        if !pair[1].at.total_cmp(&pair[0].at).is_gt() || !pair[1].at.is_finite() {
            let message = format!(
                "is {:?}, but the point before it is at {:?}: order the points from root to tip",
                pair[1].at, pair[0].at
            );
            check.refuse(&format!("taper[{}].at", i + 1), message);
        }
    }
    check.each("taper", taper, |c, point| point.check(c, of));
}

impl TaperPoint {
    fn check(&self, check: &mut Check, of: &Tapered) {
        match &self.section {
            Some(section) => check.within("section", |c| check_section(c, section, of.length)),
            None if of.has_section => {}
            None => check.refuse("section", "is missing, and the whole fibre has none".into()),
        }
        let Self { bending, torsion, linear_density, rotary_inertia, .. } = self;
        let given = [
            ("bending", bending.is_some()),
            ("torsion", torsion.is_some()),
            ("linear_density", linear_density.is_some()),
            ("rotary_inertia", rotary_inertia.is_some()),
        ];
        for (field, _) in given.iter().filter(|(_, given)| *given && !of.measured) {
            let message = "is for what is Measured: of a solid it follows from the section";
            check.refuse(field, message.into());
        }
        check_measured(check, bending.as_ref(), *torsion, *linear_density, rotary_inertia.as_ref());
    }
}

/// Reports a table of taper beside a law of sections that remember.
pub(crate) fn check_taper_law(check: &mut Check, material: &MaterialSpec) {
    if material.keratin().is_some_and(|keratin| keratin.law != Law::Elastic) {
        let message = "is for the law Elastic: the other laws are of one section all along; leave \
                       it out, or take `law: Elastic`";
        check.refuse("taper", message.into());
    }
}
