use crate::{SpringError, System};
use std::ops::Range;

/// The area or volume that nodes enclose, and the controller that keeps it: the incompressibility
/// of the second text.
///
/// An integral controller changes the rest lengths of radial springs by
/// `tau R0 (1 - (A / A0)^(1/D))` in each call, so no error remains at rest. `A0` is the measure of
/// the polygon at rest, which is less than that of the circle (errata, section 9).
#[derive(Debug, Clone, PartialEq)]
pub struct Enclosure<const D: usize> {
    facets: Vec<[usize; D]>,
    radial: Range<usize>,
    /// Rest lengths of the radial springs at the start, m.
    rest_radii: Vec<f64>,
    rest_measure: f64,
    /// Strength of the controller, between 0 and 1; 0.2 in the text.
    pub tau: f64,
}

impl<const D: usize> Enclosure<D> {
    /// Facets are edges in the plane, counter-clockwise, and triangles in space, counter-clockwise
    /// from outside; `radial` are the springs that are controlled. The present measure is the one
    /// to keep.
    ///
    /// # Errors
    /// [`SpringError::MissingNode`]; [`SpringError::Parameter`] if `tau` is not between 0 and 1 or
    /// the facets enclose nothing; [`SpringError::Count`] for missing springs, and in other than
    /// two or three dimensions.
    pub fn new(
        system: &System<D>,
        facets: Vec<[usize; D]>,
        radial: Range<usize>,
        tau: f64,
    ) -> Result<Self, SpringError> {
        if !(D == 2 || D == 3) {
            let expected = "two or three".to_owned();
            return Err(SpringError::Count { what: "dimensions", found: D, expected });
        }
        if radial.end > system.springs() {
            let expected = format!("at most {}", system.springs());
            return Err(SpringError::Count { what: "radial springs", found: radial.end, expected });
        }
        let nodes = system.nodes();
        for (index, facet) in facets.iter().enumerate() {
            if let Some(&node) = facet.iter().find(|&&node| node >= nodes) {
                return Err(SpringError::MissingNode { what: "facet", index, node, nodes });
            }
        }
        if !(tau > 0.0 && tau < 1.0) {
            let (what, allowed) = ("the strength of the controller", "between 0 and 1");
            return Err(SpringError::Parameter { what, value: tau, allowed });
        }
        let rest_radii = system.springs.rest_length[radial.clone()].to_vec();
        let mut enclosure = Self { facets, radial, rest_radii, rest_measure: 1.0, tau };
        enclosure.rest_measure = enclosure.measure(system);
        crate::error::positive("the enclosed area or volume", enclosure.rest_measure)?;
        Ok(enclosure)
    }

    /// The facets that were given: nodes of edges or triangles.
    #[must_use]
    pub fn facets(&self) -> &[[usize; D]] {
        &self.facets
    }

    /// Area (m^2) or volume (m^3) enclosed in the present state: A.
    ///
    /// # Panics
    /// If the system has fewer nodes than the one it was made for.
    #[must_use]
    pub fn measure(&self, system: &System<D>) -> f64 {
        let facet = |facet: &[usize; D]| {
            let corner = |k: usize| system.positions.get(facet[k]);
            if D == 2 {
                let [a, b] = [corner(0), corner(1)];
                0.5 * (a[0] * b[1] - a[1] * b[0])
            } else {
                let [a, b, c] = [corner(0), corner(1), corner(2)];
                a.cross(&b).dot(&c) / 6.0
            }
        };
        self.facets.iter().map(facet).sum()
    }

    /// Area (m^2) or volume (m^3) enclosed at rest: A0.
    #[must_use]
    pub fn rest_measure(&self) -> f64 {
        self.rest_measure
    }

    /// Lets the controller change the radial springs once: once per frame in the text. It is stable
    /// where the breathing mode of the body decays faster than at the rate `tau` per interval
    /// between two calls.
    ///
    /// # Errors
    /// [`SpringError::Parameter`] if a rest length would vanish: the body is inflated or crushed
    /// beyond what its springs can do.
    ///
    /// # Panics
    /// If the system has fewer nodes or springs than the one it was made for.
    pub fn control(&self, system: &mut System<D>) -> Result<(), SpringError> {
        // A body turned inside out has no root; it is inflated at the full rate.
        let ratio = (self.measure(system) / self.rest_measure).max(0.0);
        let error = self.tau * (1.0 - ratio.powf(1.0 / D as f64));
        let lengths = self.radial.clone().zip(&self.rest_radii);
        let lengths: Vec<_> =
            lengths.map(|(s, r0)| (s, system.springs.rest_length[s] + error * r0)).collect();
        system.set_rest_lengths(lengths)
    }
}
