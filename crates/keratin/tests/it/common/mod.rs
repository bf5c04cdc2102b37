//! Fibres at rest, as every instrument needs them.

use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Fiber;
use rapunzel_rod_static::{EndCondition, Equilibrium, Piece, Problem, Properties};

/// Acceleration of free fall, m/s^2.
pub(crate) const GRAVITY: f64 = 9.81;

/// A hair of uniform properties, clamped at its root, with a force at its tip, under its own weight
/// in parts of the real one.
pub(crate) fn at_rest(fiber: &Fiber, force: Vector3<f64>, weight: f64) -> Equilibrium {
    let node = fiber.nodes()[0];
    let properties = Properties {
        stiffness: node.stiffness,
        natural_curvature: node.natural_curvature,
        load: -weight * node.linear_density * GRAVITY * Vector3::z(),
    };
    let end = EndCondition::Free { force, moment: Vector3::zeros() };
    let piece = Piece::uniform(fiber.length(), properties);
    Problem::new(fiber.root(), vec![piece], end)
        .and_then(|problem| problem.solve())
        .expect("an equilibrium")
}

/// The center line at `count` + 1 equal distances.
pub(crate) fn center_line(found: &Equilibrium, length: f64, count: u32) -> Vec<Point3<f64>> {
    (0..=count).map(|i| found.at(length * f64::from(i) / f64::from(count)).position).collect()
}
