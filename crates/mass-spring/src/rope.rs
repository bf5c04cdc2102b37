use crate::error::{non_negative, positive};
use crate::{BendResistance, Element, Spring, SpringError, System};
use nalgebra::{Point, SVector};

/// The rope of the first text: masses in a row, the first one fixed.
///
/// For a chain, which does not stretch, take [`rigid`](Self::rigid) springs and a
/// [`RigidChain`](crate::RigidChain) to move it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rope {
    /// Number of nodes including the fixed one, at least two.
    pub nodes: usize,
    /// Rest length of a segment, m.
    pub spacing: f64,
    /// Parameters of the masses and springs.
    pub element: Element,
    /// Bending stiffness, N m^2; the text has none.
    pub bending_stiffness: f64,
    /// Whether segments keep their length: springs then have no stiffness of their own.
    pub rigid: bool,
}

impl Rope {
    /// The rope of the text: 40 nodes, segments of 5 cm and 10 g, which the text does not give.
    #[must_use]
    pub fn of_the_text(frequency: f64) -> Self {
        let element = Element { mass: 0.01, ..Element::unit(frequency) };
        Self { nodes: 40, spacing: 0.05, element, bending_stiffness: 0.0, rigid: false }
    }

    /// The rope at rest from `start` (world), m, along `direction` (world).
    ///
    /// # Errors
    /// [`SpringError::Count`], [`SpringError::Parameter`].
    pub fn build<const D: usize>(
        &self,
        start: Point<f64, D>,
        direction: SVector<f64, D>,
    ) -> Result<System<D>, SpringError> {
        self.element.check()?;
        positive("the spacing of a rope (m)", self.spacing)?;
        non_negative("the bending stiffness (N m^2)", self.bending_stiffness)?;
        positive("the length of the direction of a rope", direction.norm())?;
        if self.nodes < 2 {
            let expected = "at least two".to_owned();
            return Err(SpringError::Count {
                what: "nodes of a rope",
                found: self.nodes,
                expected,
            });
        }
        let way = direction.normalize() * self.spacing;
        let positions: Vec<_> = (0..self.nodes).map(|k| start + way * k as f64).collect();
        let stiffness = if self.rigid { 0.0 } else { self.element.stiffness() };
        let damping = if self.rigid { 0.0 } else { self.element.damping() };
        let spring = |k| Spring { damping, ..Spring::new([k, k + 1], stiffness, self.spacing) };
        let springs: Vec<_> = (0..self.nodes - 1).map(spring).collect();
        let masses = vec![self.element.mass; self.nodes];
        let mut system = System::new(&positions, &masses, &springs)?;
        if self.bending_stiffness > 0.0 {
            let stiffness = self.bending_stiffness / self.spacing;
            let bend = |k| BendResistance { nodes: [k, k + 1, k + 2], stiffness };
            system = system.with_bends((0..self.nodes - 2).map(bend).collect())?;
        }
        system.set_drag(self.element.drag)?;
        system.pin(0)?;
        Ok(system)
    }
}
