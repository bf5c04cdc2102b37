//! Nodes against each other and obstacles that rest or move, and nodes on guides.

use approx::assert_relative_eq;
use nalgebra::{Isometry3, Point2, Point3, Translation3, Unit, UnitQuaternion, Vector2, Vector3};
use rapunzel_collision::field::HalfSpace;
use rapunzel_mass_spring::{
    Contacts, Leapfrog, NodeVectors, Obstacle, SpringError, Surface, System, runge_kutta,
};

fn below(normal: Vector3<f64>) -> HalfSpace {
    HalfSpace { point: Point3::origin(), normal: Unit::new_normalize(normal) }
}

fn contacts<const D: usize>(
    system: &System<D>,
    restitution: f64,
    friction: f64,
    mutual: bool,
) -> Contacts {
    let surface = Surface { radius: 0.01, restitution, friction };
    Contacts::new(system, surface, mutual).expect("a surface")
}

fn moved(way: Vector3<f64>) -> Isometry3<f64> {
    Translation3::from(way).into()
}

#[test]
fn a_block_slides_its_stopping_distance() {
    // v^2 / (2 mu g), with an error of first order in the step: at most the way of one step.
    for (speed, friction) in [(2.0, 0.3), (1.0, 0.1), (3.0, 1.2)] {
        let dt = 1e-4;
        let mut block = System::new(&[Point2::new(0.0, 0.01)], &[2.0], &[]).expect("a mass");
        block.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
        block.set_velocities(&NodeVectors::of(&[Vector2::new(speed, 0.0)])).expect("finite");
        let (mut contacts, ground) = (contacts(&block, 0.0, friction, false), below(Vector3::z()));
        let expected = speed * speed / (2.0 * friction * 9.81);
        let stopped = speed / (friction * 9.81);
        while block.time() < 1.2 * stopped {
            Leapfrog::new().advance(&mut block, dt, 1).expect("finite");
            contacts.resolve(&mut block, &[Obstacle::at_rest(&ground)]).expect("finite");
        }
        assert!((block.position(0).x - expected).abs() < speed * dt, "{}", block.position(0));
        assert_relative_eq!(block.velocity(0), Vector2::zeros(), epsilon = 1e-12);
    }
}

#[test]
fn a_moving_plane_pushes_a_node_at_its_own_speed() {
    // At rest in its way: it leaves at (1 + e) times the normal velocity of the plane.
    let (plane, way, dt) = (below(Vector3::z()), Vector3::new(0.3, 0.0, 0.5), 1e-3);
    for (restitution, friction, expected) in [
        (0.0, 0.0, Vector3::new(0.0, 0.0, 0.5)),
        (0.4, 0.0, Vector3::new(0.0, 0.0, 0.7)),
        // The plane drags it along: by no more than mu of what it presses, and no faster than
        // itself.
        (0.0, 0.2, Vector3::new(0.1, 0.0, 0.5)),
        (0.0, 5.0, Vector3::new(0.3, 0.0, 0.5)),
    ] {
        let mut node = System::new(&[Point3::new(0.0, 0.0, 0.01)], &[0.2], &[]).expect("a mass");
        let mut contacts = contacts(&node, restitution, friction, false);
        let poses = [moved(2.0 * way * dt), moved(3.0 * way * dt)];
        let obstacle = Obstacle { field: &plane, poses, dt };
        assert_eq!(contacts.resolve(&mut node, &[obstacle]).expect("finite"), 1);
        assert_relative_eq!(node.velocity(0), expected, epsilon = 1e-12);
        assert_relative_eq!(node.position(0).z, 0.01 + 3.0 * 0.5 * dt, epsilon = 1e-15);
        // What moves away from it is not held back.
        let obstacle = Obstacle { field: &plane, poses: [poses[1], poses[0]], dt };
        assert_eq!(contacts.resolve(&mut node, &[obstacle]).expect("finite"), 0);
    }
}

#[test]
fn a_turning_paddle_hits_with_the_speed_of_its_place() {
    // By a small angle about y, the half-space below z = 0 rises where x is negative.
    let (plane, angle, dt) = (below(Vector3::z()), 1e-4, 1e-3);
    let mut node = System::new(&[Point3::new(-2.0, 0.0, 0.01)], &[1.0], &[]).expect("a mass");
    let turned = Isometry3::from_parts(
        Translation3::identity(),
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle),
    );
    let poses = [Isometry3::identity(), turned];
    let mut contacts = contacts(&node, 0.0, 0.0, false);
    let obstacle = Obstacle { field: &plane, poses, dt };
    assert_eq!(contacts.resolve(&mut node, &[obstacle]).expect("finite"), 1);
    assert_relative_eq!(node.velocity(0).z, 2.0 * angle / dt, max_relative = 1e-2 * angle + 1e-6);
    let broken = Obstacle { field: &plane, poses: [Isometry3::identity(), turned], dt: 0.0 };
    let mut low = System::new(&[Point3::new(-2.0, 0.0, 0.0)], &[1.0], &[]).expect("a mass");
    let refused = contacts.resolve(&mut low, &[broken]);
    assert!(matches!(refused, Err(SpringError::Parameter { .. })), "{refused:?}");
}

#[test]
fn guided_nodes_stop_at_obstacles_along_their_guide() {
    // Guided along x, into a slope: only x may change, and the node ends at the surface.
    let slope = below(Vector3::new(-1.0, 0.0, 1.0));
    for tied in [false, true] {
        let positions = [Point3::new(0.1, 0.0, 0.0), Point3::new(-5.0, 0.0, 0.0)];
        let mut system = System::new(&positions, &[1.0, 3.0], &[]).expect("two masses");
        for (node, axis) in [(0, 1), (0, 2), (1, 1), (1, 2)] {
            system.hold_axis(node, axis, 0.0).expect("there");
        }
        if tied {
            system.tie(&[0, 1], 0).expect("there");
        }
        system.set_velocities(&NodeVectors::of(&[Vector3::x(), Vector3::x()])).expect("finite");
        let mut contacts = contacts(&system, 0.0, 0.5, false);
        let count = contacts.resolve(&mut system, &[Obstacle::at_rest(&slope)]);
        assert_eq!(count.expect("finite"), 1);
        let stopped = Point3::new(-0.01 * 2.0_f64.sqrt(), 0.0, 0.0);
        assert_relative_eq!(system.position(0), stopped, epsilon = 1e-15);
        assert_relative_eq!(system.velocity(0), Vector3::zeros(), epsilon = 1e-15);
        let offset = if tied { stopped.x - 0.1 } else { 0.0 };
        assert_relative_eq!(system.position(1).x, -5.0 + offset, epsilon = 1e-14);
        assert_relative_eq!(system.velocity(1).x, f64::from(u8::from(!tied)), epsilon = 1e-15);
    }
    // A guide along the surface yields to nothing, and neither does a pin.
    let mut system = System::new(&[Point3::origin()], &[1.0], &[]).expect("a mass");
    system.hold_axis(0, 2, 0.0).expect("there");
    let mut contacts = contacts(&system, 0.0, 0.5, false);
    let ground = below(Vector3::new(1e-9, 0.0, 1.0));
    let count = contacts.resolve(&mut system, &[Obstacle::at_rest(&ground)]).expect("finite");
    assert_eq!((count, system.position(0)), (0, Point3::origin()));
}

#[test]
fn nodes_at_the_same_point_part() {
    let mut system = System::new(&[Point3::origin(); 2], &[1.0, 3.0], &[]).expect("two masses");
    let mut contacts = contacts(&system, 0.0, 0.0, true);
    assert_eq!(contacts.resolve(&mut system, &[]).expect("finite"), 1);
    let apart = system.position(1) - system.position(0);
    assert_relative_eq!(apart, Vector3::new(0.02, 0.0, 0.0), epsilon = 1e-15);
    // The center of mass stays.
    assert_relative_eq!(system.position(0).x, -0.015, epsilon = 1e-15);
    // Where x is barred they part along y; where all is, not at all.
    let mut system = System::new(&[Point2::origin(); 2], &[1.0; 2], &[]).expect("two masses");
    system.hold_axis(0, 0, 0.0).expect("there");
    system.tie(&[0, 1], 0).expect("there");
    assert_eq!(contacts.resolve(&mut system, &[]).expect("finite"), 1);
    assert_relative_eq!(system.position(1) - system.position(0), 0.02 * Vector2::y());
    let mut system = System::new(&[Point2::origin(); 2], &[1.0; 2], &[]).expect("two masses");
    system.pin_to(0, 1).expect("there");
    assert_eq!(contacts.resolve(&mut system, &[]).expect("finite"), 0);
}

#[test]
fn nodes_that_meet_exchange_their_momentum() {
    let positions = [Point3::new(-0.1, 0.0, 0.0), Point3::new(0.1, 0.0, 0.0)];
    let mut system = System::new(&positions, &[1.0, 1.0], &[]).expect("two masses");
    let velocities = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(-0.5, 0.0, 0.0)];
    system.set_velocities(&NodeVectors::of(&velocities)).expect("finite");
    let surface = Surface { radius: 0.02, restitution: 1.0, friction: 0.0 };
    let mut contacts = Contacts::new(&system, surface, true).expect("a surface");
    let mut count = 0;
    for _ in 0..300 {
        runge_kutta(&mut system, 1e-3, 1).expect("finite");
        count += contacts.resolve(&mut system, &[]).expect("finite");
    }
    assert_eq!(count, 1);
    assert_relative_eq!(system.velocity(0), velocities[1], epsilon = 1e-12);
    assert_relative_eq!(system.velocity(1), velocities[0], epsilon = 1e-12);
}

#[test]
fn friction_holds_on_a_slope_below_its_angle() {
    // Gravity leans by 20 degrees; friction holds up to atan(0.5), 26.6 degrees.
    for (friction, holds) in [(0.5, true), (0.2, false)] {
        let mut system = System::new(&[Point2::new(0.0, 0.01)], &[1.0], &[]).expect("a mass");
        let lean = 20.0_f64.to_radians();
        system.set_gravity(9.81 * Vector2::new(lean.sin(), -lean.cos())).expect("finite");
        let (mut contacts, ground) = (contacts(&system, 0.0, friction, false), below(Vector3::z()));
        for _ in 0..1000 {
            Leapfrog::new().advance(&mut system, 1e-3, 1).expect("finite");
            contacts.resolve(&mut system, &[Obstacle::at_rest(&ground)]).expect("finite");
        }
        let slid = if holds { 0.0 } else { 9.81 * (lean.sin() - 0.2 * lean.cos()) };
        assert!((system.velocity(0).x - slid).abs() < 1e-2, "{}", system.velocity(0));
        assert_relative_eq!(system.position(0).y, 0.01, epsilon = 1e-4);
    }
}

#[test]
fn friction_between_nodes_turns_sliding_into_half_of_it() {
    // The second glances off the first from above: the impulse along the line of centers is 1 / 2
    // for a normal velocity of 1, and friction takes at most its part of it.
    for (friction, rubbed) in [(0.1, 0.05), (10.0, 0.5)] {
        let positions = [Point3::origin(), Point3::new(0.0, 0.0, 0.0401)];
        let mut system = System::new(&positions, &[1.0, 1.0], &[]).expect("two masses");
        let velocities = [Vector3::zeros(), Vector3::new(1.0, 0.0, -1.0)];
        system.set_velocities(&NodeVectors::of(&velocities)).expect("finite");
        let surface = Surface { radius: 0.02, restitution: 0.0, friction };
        let mut contacts = Contacts::new(&system, surface, true).expect("a surface");
        runge_kutta(&mut system, 2e-4, 1).expect("finite");
        assert_eq!(contacts.resolve(&mut system, &[]).expect("finite"), 1);
        // The line of centers leans by 2e-4 / 0.04.
        assert_relative_eq!(system.velocity(0), Vector3::new(rubbed, 0.0, -0.5), epsilon = 6e-3);
        assert_relative_eq!(system.momentum(), Vector3::new(1.0, 0.0, -1.0), epsilon = 1e-14);
    }
}
