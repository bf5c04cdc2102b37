//! What the live page reads of what moves: points and colors alone, to the bits of whole strands.

use crate::common::Run;
use nalgebra::Point3;
use rapunzel_export::Strand;
use rapunzel_sim::World;
use rapunzel_studio::Coloring;

const COLORINGS: [Coloring; 7] = [
    Coloring::Strain,
    Coloring::Curvature,
    Coloring::Tension,
    Coloring::Speed,
    Coloring::Contact,
    Coloring::Charge,
    Coloring::Fiber,
];

/// Points and colors are those of the strands, and the points of fibres those of their states.
fn assert_read_alike(world: &World, name: &str) {
    let stepper = world.stepper();
    let strands: Vec<Strand> = stepper.strands().collect();
    // What is read goes behind what is there.
    let first = Point3::new(1.0, 2.0, 3.0);
    let mut points = vec![first];
    stepper.points(&mut points);
    let expected: Vec<_> = strands.iter().flat_map(|strand| strand.points.clone()).collect();
    assert!(expected.len() > 2, "{name}");
    assert_eq!((points[0], &points[1..]), (first, &expected[..]), "{name}");
    let fibers = 0..world.assembly().fibers().len();
    let states: Vec<_> = fibers.flat_map(|fiber| world.state(fiber).positions).collect();
    assert!(states.is_empty() || states == expected, "{name}");
    for of in COLORINGS {
        let mut values = vec![7.0];
        stepper.values(of, &mut values);
        let strands = strands.iter().enumerate();
        let expected = strands.flat_map(|(index, strand)| of.of_strand(index, strand));
        let expected: Vec<_> = [7.0].into_iter().chain(expected).collect();
        assert_eq!(values, expected, "{name}, {of:?}");
    }
}

/// A scene after some steps.
fn moved(name: &str, text: &str, steps: usize) -> World {
    let mut run = Run::read(text);
    run.steps(steps);
    assert_read_alike(&run.world, name);
    run.world
}

/// Whether a color is more than one value.
fn varies(world: &World, of: Coloring) -> bool {
    let mut values = Vec::new();
    world.stepper().values(of, &mut values);
    values.iter().any(|value| *value != values[0])
}

/// Fibres of several lengths, so that those of a group are not beside each other, swung in air.
fn swung(method: &str) -> World {
    let fiber = |segments: usize| {
        format!(
            "(length: 0.1, segments: {segments}, section: Circle(radius: 4e-5),
              shape: Helix(radius: 0.02, pitch: 0.3),
              arrangement: Ellipse(semi_axes: (0.02, 0.02), count: 5))"
        )
    };
    let text = format!(
        "(format: 1, duration: 1, fibers: [{}, {}, {}],
          environment: (viscosity: 1.8e-5), stepper: (dt: 1e-3, {method}))",
        fiber(9),
        fiber(4),
        fiber(9)
    );
    moved(method, &text, 4)
}

#[test]
fn free_fibers_are_read_alike() {
    for method in ["", "tolerance: 0.1", "method: BackwardEuler", "method: Box()"] {
        let world = swung(method);
        for of in [Coloring::Strain, Coloring::Tension, Coloring::Speed, Coloring::Fiber] {
            assert!(varies(&world, of), "{method} {of:?}");
        }
    }
}

#[test]
fn fibers_in_contact_are_read_alike() {
    let lying = |name, law| {
        let text = format!(
            "(format: 1, duration: 1, fibers: [(length: 0.05, segments: 10, {law}
              root: (position: (-0.02, 0, 1e-4), orientation: Along(direction: (1, 0, 0))),
              root_joint: Free)], objects: [(shape: Plane(normal: (0, 0, 1)))],
              contact: (friction: Isotropic(0.3)), stepper: (dt: 1e-3))"
        );
        moved(name, &text, 30)
    };
    let world = lying("round", "section: Circle(radius: 1e-4), ");
    assert!(varies(&world, Coloring::Contact));
    let closed = "(format: 1, duration: 1, fibers: [(
        length: 0.06283185307179587, segments: 20, section: Circle(radius: 5e-4),
        initial: Helix(radius: 0.01, pitch: 0.0), root_joint: Free, closed: (turns: 1.0))],
        stepper: (dt: 1e-4))";
    moved("closed", closed, 5);
}

#[test]
fn charged_fibers_are_read_alike() {
    let text = "(format: 1, duration: 1, stepper: (dt: 1), charging: (),
        fibers: [(length: 0.1, segments: 12, section: Circle(radius: 4e-5),
        arrangement: Ellipse(semi_axes: (0.01, 0.01), count: 3),
        charge: (amount: StatcoulombPerCentimeter(-7.7e-4)))])";
    let world = moved("charged", text, 1);
    assert!(varies(&world, Coloring::Charge));
}

#[test]
fn springs_are_read_alike() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/mass-spring");
    for name in ["ring", "rope", "cube", "cloth-on-a-line"] {
        let text = std::fs::read_to_string(folder.join(format!("{name}.ron"))).expect("it ships");
        moved(name, &text, 3);
    }
}
