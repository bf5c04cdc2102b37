//! The ledger of energy: what loads, supports, drag, wind and dampers give and take.

use approx::assert_relative_eq;
use nalgebra::{Point2, Vector2};
use rapunzel_mass_spring::{
    Cells, Element, Lattice, Leapfrog, NodeVectors, PlaceMatrix, RigidChain, Rope, System,
};

#[test]
fn the_ledger_of_energy_closes_with_drag_wind_dampers_and_loads() {
    let error = |steps: u32| {
        let dt = 0.5 / f64::from(steps);
        let mut net =
            Lattice::net(PlaceMatrix::free(4, 5).expect("a size"), 5.0, Cells::Triangular);
        net.element = Element { damping_ratio: 0.1, drag: 0.5, ..Element::unit(5.0) };
        let mut system = net.build(Point2::origin()).expect("a net");
        system.set_velocities(&swinging(system.nodes())).expect("finite");
        system.set_gravity(Vector2::new(0.0, -1.0)).expect("finite");
        system.set_load(3, Vector2::new(0.2, 0.1)).expect("there");
        system.set_wind(rapunzel_mass_spring::WindField::steady(Vector2::x())).expect("finite");
        let (start, mut lost) = (system.energy().total(), 0.0);
        let mut leapfrog = Leapfrog::new();
        for _ in 0..steps {
            let before = system.dissipation();
            leapfrog.advance(&mut system, dt, 1).expect("stable");
            lost += 0.5 * dt * (before + system.dissipation());
        }
        assert!(lost.abs() > 1e-3, "{lost} J");
        (start - system.energy().total() - lost).abs()
    };
    // Of first order, because dampers use the velocity before the step.
    let [coarse, fine] = [5000, 10_000].map(error);
    assert!((1.9..2.1).contains(&(coarse / fine)), "{coarse} J and {fine} J are not accounted for");
    // Without the first order next to nothing is left.
    let rest = (2.0 * fine - coarse).abs();
    assert!(rest < 1e-5, "{rest} J are not accounted for at steps of no length");
}

#[test]
fn the_ledger_of_energy_closes_with_supports_that_move() {
    // One corner is led away, at once with its clamp, from a net that it pulls along.
    let error = |steps: u32| {
        let dt = 0.5 / f64::from(steps);
        let mut net =
            Lattice::net(PlaceMatrix::free(4, 5).expect("a size"), 5.0, Cells::Triangular);
        net.element = Element { drag: 0.5, ..Element::unit(5.0) };
        let mut system = net.build(Point2::origin()).expect("a net");
        system.set_gravity(Vector2::new(0.0, -1.0)).expect("finite");
        system.tie(&[0, 5], 0).expect("there");
        system.hold(0, Vector2::new(0.4, 0.3)).expect("there");
        let power = |system: &System<2>| system.support_power() - system.dissipation();
        let (start, mut given) = (system.energy().total(), 0.0);
        let mut leapfrog = Leapfrog::new();
        for _ in 0..steps {
            let before = power(&system);
            leapfrog.advance(&mut system, dt, 1).expect("stable");
            given += 0.5 * dt * (before + power(&system));
        }
        assert!(given > 1e-3, "{given} J");
        (system.energy().total() - start - given).abs()
    };
    let [coarse, fine] = [1250, 2500].map(error);
    assert!((3.9..4.1).contains(&(coarse / fine)), "{coarse} J and {fine} J are not accounted for");
}

#[test]
fn the_ledger_of_a_chain_counts_its_tensions() {
    // A hanging chain is drawn up evenly: the support lifts all of its weight.
    let rope = Rope { nodes: 5, rigid: true, ..Rope::of_the_text(10.0) };
    let mut system = rope.build(Point2::origin(), -Vector2::y()).expect("a chain");
    system.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
    system.set_velocities(&NodeVectors::of(&[Vector2::new(0.0, 0.5); 5])).expect("finite");
    system.hold(0, Vector2::new(0.0, 0.5)).expect("there");
    let mut chain = RigidChain::new();
    chain.advance(&mut system, 1e-3, 10).expect("of the right length");
    let power = system.support_power() + chain.support_power(&system);
    assert_relative_eq!(power, 0.05 * 9.81 * 0.5, max_relative = 1e-9);
}

/// Velocities that turn and swing a net of so many nodes.
fn swinging(nodes: usize) -> NodeVectors<2> {
    let velocity = |n: usize| Vector2::new((n as f64).sin(), 0.4 * (1.3 * n as f64).cos());
    NodeVectors::of(&(0..nodes).map(velocity).collect::<Vec<_>>())
}
