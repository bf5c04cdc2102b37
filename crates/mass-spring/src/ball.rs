use crate::error::positive;
use crate::{Element, Enclosure, Spring, SpringError, System};
use nalgebra::{Point2, Point3, Vector2};
use rapunzel_collision::field::shapes;
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// The incompressible body of the second text: masses on a circle or a sphere, springs between
/// neighbors, and one spring from each mass to a central mass.
///
/// Node 0 is the central mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundBody {
    /// Radius of the circle or sphere, m.
    pub radius: f64,
    /// Parameters of the masses, and of the springs on the surface.
    pub element: Element,
    /// Ratio of the stiffness of the radial springs to that of the springs on the surface.
    pub radial: f64,
    /// Strength of the [`Enclosure`] controller, between 0 and 1.
    pub tau: f64,
}

impl RoundBody {
    /// The body of the text: tau is 0.2 and all springs are alike; masses of 10 g.
    #[must_use]
    pub fn of_the_text(radius: f64, frequency: f64) -> Self {
        let element = Element { mass: 0.01, ..Element::unit(frequency) };
        Self { radius, element, radial: 1.0, tau: 0.2 }
    }

    /// A ring of `count` masses around `center` (world), m; the text has 14. Node `1 + i` is at the
    /// angle `2 pi i / count`.
    ///
    /// # Errors
    /// [`SpringError::Parameter`]; [`SpringError::Count`] for fewer than three.
    pub fn ring(
        &self,
        center: Point2<f64>,
        count: usize,
    ) -> Result<(System<2>, Enclosure<2>), SpringError> {
        if count < 3 {
            let expected = "at least three".to_owned();
            return Err(SpringError::Count { what: "masses of a ring", found: count, expected });
        }
        let angle = |i: usize| TAU * i as f64 / count as f64;
        let around = |i| center + Vector2::new(angle(i).cos(), angle(i).sin()) * self.radius;
        let positions: Vec<_> = std::iter::once(center).chain((0..count).map(around)).collect();
        let edges: Vec<_> = (0..count).map(|i| [1 + i, 1 + (i + 1) % count]).collect();
        self.build(&positions, &edges, edges.clone())
    }

    /// A sphere around `center` (world), m: an octahedron with every face cut into `n^2` triangles.
    ///
    /// # Errors
    /// [`SpringError::Parameter`].
    pub fn sphere(
        &self,
        center: Point3<f64>,
        n: u8,
    ) -> Result<(System<3>, Enclosure<3>), SpringError> {
        positive("the radius of a ball (m)", self.radius)?;
        let soup = shapes::sphere(self.radius, i32::from(n));
        let around = soup.vertices.iter().map(|vertex| center + vertex.coords);
        let positions: Vec<_> = std::iter::once(center).chain(around).collect();
        let facets: Vec<[usize; 3]> =
            soup.triangles.iter().map(|t| t.map(|vertex| 1 + vertex as usize)).collect();
        let sides = |&[a, b, c]: &[usize; 3]| [[a, b], [b, c], [c, a]];
        let edges: BTreeSet<[usize; 2]> =
            facets.iter().flat_map(sides).filter(|[a, b]| a < b).collect();
        self.build(&positions, &edges.into_iter().collect::<Vec<_>>(), facets)
    }

    fn build<const D: usize>(
        &self,
        positions: &[nalgebra::Point<f64, D>],
        edges: &[[usize; 2]],
        facets: Vec<[usize; D]>,
    ) -> Result<(System<D>, Enclosure<D>), SpringError> {
        self.element.check()?;
        positive("the radius of a ball (m)", self.radius)?;
        positive("the stiffness of radial springs by that of the surface", self.radial)?;
        let (stiffness, damping) = (self.element.stiffness(), self.element.damping());
        let spring = |nodes: [usize; 2], stiffness| {
            let length = (positions[nodes[1]] - positions[nodes[0]]).norm();
            Spring { damping, ..Spring::new(nodes, stiffness, length) }
        };
        let mut springs: Vec<_> = edges.iter().map(|&nodes| spring(nodes, stiffness)).collect();
        springs.extend((1..positions.len()).map(|i| spring([0, i], self.radial * stiffness)));
        let masses = vec![self.element.mass; positions.len()];
        let mut system = System::new(positions, &masses, &springs)?;
        system.set_drag(self.element.drag)?;
        let enclosure = Enclosure::new(&system, facets, edges.len()..springs.len(), self.tau)?;
        Ok((system, enclosure))
    }
}
