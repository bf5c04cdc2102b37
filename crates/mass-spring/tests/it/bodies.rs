//! Nets and bodies: cells that fold, beams that bend and buckle, balls that keep their volume.

use approx::assert_relative_eq;
use nalgebra::{DVector, Point2, Point3, Vector2, Vector3};
use rapunzel_collision::field::HalfSpace;
use rapunzel_mass_spring::{
    Cells, Contacts, Element, Lattice, LatticeBody, Leapfrog, NodeVectors, Obstacle, PlaceMatrix,
    RoundBody, Spring, SpringError, Surface, System,
};
use std::f64::consts::TAU;

fn unit_beam(body: LatticeBody) -> (Lattice, System<2>) {
    let lattice = body.lattice(1.0, Element::unit(1.0 / TAU)).expect("a body");
    let system = lattice.build(Point2::origin()).expect("a body");
    (lattice, system)
}

#[test]
fn a_rectangular_cell_stays_folded_and_a_triangular_one_does_not() {
    let folded = |cells: Cells| {
        let place = PlaceMatrix::free(10, 10).expect("a size");
        let mut net = Lattice::net(place, 5.0, cells);
        net.element = Element { drag: 5.0, ..Element::unit(5.0) };
        let mut system: System<2> = net.build(Point2::origin()).expect("a net");
        let mut x = system.positions().clone();
        // The corner goes nearly to the other side of its two neighbors.
        x.set(0, &Vector2::new(0.9 * 0.075, -0.9 * 0.075));
        system.set_positions(&x).expect("finite");
        Leapfrog::new().advance(&mut system, 0.005, 6000).expect("stable");
        (system.position(0) - system.position(11)).norm() / 0.075
    };
    // Folded, it lies on the node across the cell, without any force; as it was, sqrt(2) away.
    assert!(folded(Cells::Rectangular) < 1e-6);
    assert_relative_eq!(folded(Cells::Triangular), 2.0_f64.sqrt(), epsilon = 1e-6);
}

#[test]
fn every_corner_of_a_triangular_net_has_a_diagonal() {
    for (rows, columns) in [(2, 2), (3, 3), (2, 7), (10, 10), (9, 10), (9, 11)] {
        let place = PlaceMatrix::free(rows, columns).expect("a size");
        let net: System<2> =
            Lattice::net(place, 5.0, Cells::Triangular).build(Point2::origin()).expect("a net");
        let sides = rows * (columns - 1) + columns * (rows - 1);
        assert_eq!(net.springs(), sides + (rows - 1) * (columns - 1));
        let corners = [0, columns - 1, rows * columns - 1, (rows - 1) * columns];
        let touched =
            |node| (0..net.springs()).filter(|&s| net.spring(s).nodes.contains(&node)).count();
        if rows > 2 && columns > 2 {
            assert!(corners.into_iter().all(|node| touched(node) == 3), "{rows} x {columns}");
        }
    }
}

/// The compression by which the guided thin beam is shortened, and its force, when it buckles in
/// the linear theory of its own stiffness: at the load where the second derivative of the energy of
/// the straight beam under it is singular.
fn euler_load() -> f64 {
    let (lattice, system) = unit_beam(LatticeBody::ThinBeamGuided);
    let lowest = |load: f64| {
        let loaded = straight(&lattice, &system, load);
        loaded.linearized().expect("small").modes().expect("modes").squares[0]
    };
    let (mut low, mut high) = (0.0, 0.6);
    assert!(lowest(low) > 0.0 && lowest(high) < 0.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if lowest(middle) > 0.0 { low = middle } else { high = middle }
    }
    low
}

/// The beam under a load along it, its middle kept from going sideways until that is found.
fn straight(lattice: &Lattice, system: &System<2>, load: f64) -> System<2> {
    let mut loaded = system.clone();
    for row in 0..3 {
        let force = Vector2::new(-load / 3.0, 0.0);
        loaded.set_load(lattice.node(row, 15), force).expect("there");
    }
    let mut guided = loaded.clone();
    for column in 1..15 {
        guided.hold_axis(lattice.node(1, column), 1, 0.0).expect("there");
    }
    guided.find_equilibrium(1e-10).expect("an equilibrium");
    loaded.set_positions(guided.positions()).expect("finite");
    loaded
}

#[test]
fn a_thin_beam_buckles_at_the_load_of_euler() {
    // The stiffness against bending of the discrete beam, from its own linear deflection: fixed and
    // guided at the ends in one case, free in the other.
    let (lattice, system) = unit_beam(LatticeBody::ThinBeam);
    let force = 1e-6;
    let linear = system.linearized().expect("small");
    let mut load = DVector::zeros(2 * system.nodes());
    (0..3).for_each(|row| load[2 * lattice.node(row, 15) + 1] = force / 3.0);
    let modes = linear.modes().expect("modes");
    let mut bent = DVector::zeros(load.len());
    for (shape, square) in modes.shapes.column_iter().zip(&modes.squares) {
        bent += shape * (shape.dot(&load) / square);
    }
    let tip = bent[2 * lattice.node(1, 15) + 1];
    // Of the deflection F L^3 / (3 B) + F L / S, the part of shear is known from half the length.
    let half = bent[2 * lattice.node(1, 8) + 1];
    let (l, x) = (15.0_f64, 8.0_f64);
    // w(x) = F x^2 (3 L - x) / (6 B) + F x / S: two equations; only 1/B is wanted.
    let bend = |x: f64| force * x * x * (3.0 * l - x) / 6.0;
    let shear = |x: f64| force * x;
    let determinant = bend(l) * shear(x) - bend(x) * shear(l);
    let flexibility = (tip * shear(x) - half * shear(l)) / determinant;
    // Clamped at both ends.
    let euler = (TAU / l).powi(2) / flexibility;
    let found = euler_load();
    assert!((found / euler - 1.0).abs() < 0.05, "buckles at {found}, Euler says {euler}");

    // And it does: a nudge grows above the load, and not below.
    let (lattice, system) = unit_beam(LatticeBody::ThinBeamGuided);
    let middle = lattice.node(1, 8);
    let deflected = |load: f64| {
        let mut beam = straight(&lattice, &system, load);
        beam.set_drag(0.05).expect("positive");
        let mut x = beam.positions().clone();
        for node in 0..beam.nodes() {
            let along = (node % 16) as f64 / 15.0;
            x.add(node, &Vector2::new(0.0, 1e-3 * (1.0 - (TAU * along).cos())));
        }
        beam.set_positions(&x).expect("finite");
        Leapfrog::new().advance(&mut beam, 0.2, 3000).expect("stable");
        (beam.position(middle).y + 1.0).abs()
    };
    assert!(deflected(0.9 * found) < 1e-4);
    let buckled = deflected(1.1 * found);
    assert!(buckled > 0.5, "deflected by {buckled}");
}

#[test]
fn a_moving_clamp_presses_the_beam() {
    let (lattice, mut system) = unit_beam(LatticeBody::ThinBeamGuided);
    let edge = lattice.node(0, 15);
    // One node is held, and its edge follows.
    system.hold(edge, Vector2::new(-0.01, 0.0)).expect("there");
    system.set_drag(0.1).expect("positive");
    Leapfrog::new().advance(&mut system, 0.1, 500).expect("stable");
    for row in 0..3 {
        assert_relative_eq!(
            system.position(lattice.node(row, 15)),
            Point2::new(15.0 - 0.5, -(row as f64)),
            epsilon = 1e-9
        );
    }
    system.release(edge).expect("there");
    Leapfrog::new().advance(&mut system, 0.1, 5000).expect("stable");
    assert!((system.position(edge).x - 15.0).abs() < 0.01, "{}", system.position(edge));
}

#[test]
fn a_cube_under_its_lid_is_compressed_evenly() {
    let (lattice, mut system) = unit_beam(LatticeBody::CubeUnderLid);
    for column in 0..10 {
        system.set_load(lattice.node(0, column), Vector2::new(0.0, -0.01)).expect("there");
    }
    system.find_equilibrium(1e-11).expect("a pressed cube");
    let lid: Vec<_> = (0..10).map(|column| system.position(lattice.node(0, column))).collect();
    assert!(lid.iter().all(|p| (p.y - lid[0].y).abs() < 1e-12));
    assert!(lid[0].y < -0.01);
    // The ground carries it all.
    let lift: f64 = (0..system.springs())
        .filter(|&s| {
            let [i, j] = system.spring(s).nodes;
            (i / 10 == 8) && (j / 10 == 9)
        })
        .map(|s| system.spring_force(s).y)
        .chain((0..system.springs()).filter_map(|s| {
            let [i, j] = system.spring(s).nodes;
            (i / 10 == 9 && j / 10 == 8).then(|| -system.spring_force(s).y)
        }))
        .sum();
    assert_relative_eq!(lift, 0.1, epsilon = 1e-9);
}

#[test]
fn all_five_bodies_stand_in_gravity() {
    for body in [
        LatticeBody::ThinBeamGuided,
        LatticeBody::ThinBeam,
        LatticeBody::Cube,
        LatticeBody::CubeUnderLid,
        LatticeBody::ThickBeam,
    ] {
        let (_, mut system) = unit_beam(body);
        system.set_gravity(Vector2::new(0.0, -2e-5)).expect("finite");
        let rest = system.energy().total();
        system.find_equilibrium(1e-10).unwrap_or_else(|error| panic!("{body:?}: {error}"));
        assert!(system.energy().total() < rest, "{body:?}");
        assert!(
            system.linearized().expect("small").modes().expect("modes").squares[0] > 0.0,
            "{body:?}"
        );
    }
}

/// The half of the world below z = 0.
fn ground() -> HalfSpace {
    HalfSpace { point: Point3::origin(), normal: Vector3::z_axis() }
}

fn touching<const D: usize>(system: &System<D>, friction: f64) -> Contacts {
    let surface = Surface { radius: 0.01, restitution: 0.0, friction };
    Contacts::new(system, surface, false).expect("a surface")
}

#[test]
fn a_ring_on_the_ground_keeps_its_area() {
    let mut ball = RoundBody::of_the_text(0.5, 15.0);
    ball.element.damping_ratio = 0.1;
    let (mut ring, area) = ball.ring(Point2::new(0.0, 0.8), 14).expect("a ring");
    ring.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
    let (mut contacts, ground) = (touching(&ring, 0.5), ground());
    let mut leapfrog = Leapfrog::new();
    // Frames of 1/60 s with four steps each, as in the text.
    for _ in 0..6 * 60 {
        for _ in 0..4 {
            leapfrog.advance(&mut ring, 1.0 / 240.0, 1).expect("stable");
            contacts.resolve(&mut ring, &[Obstacle::at_rest(&ground)]).expect("finite");
        }
        area.control(&mut ring).expect("rest lengths stay positive");
    }
    assert!(
        ring.position(0).y < 0.52 && ring.position(0).y > 0.3,
        "{}, area {}",
        ring.position(0),
        area.measure(&ring) / area.rest_measure()
    );
    assert!((area.measure(&ring) / area.rest_measure() - 1.0).abs() < 1e-3);
    assert!((1..15).all(|node| ring.position(node).y >= 0.01 - 1e-3));
}

#[test]
fn a_ball_that_is_pressed_keeps_its_volume() {
    let mut ball = RoundBody::of_the_text(0.5, 10.0);
    ball.element.drag = 20.0;
    let (mut system, volume) = ball.sphere(Point3::origin(), 4).expect("a ball");
    assert!((volume.rest_measure() / (0.125 * TAU * 2.0 / 3.0) - 1.0).abs() < 0.1);
    // The poles are pressed together.
    let pole = |system: &System<3>, sign: f64| {
        (1..system.nodes()).max_by(|&a, &b| {
            (sign * system.position(a).z).total_cmp(&(sign * system.position(b).z))
        })
    };
    for sign in [1.0, -1.0] {
        let node = pole(&system, sign).expect("nodes");
        let mut x = system.positions().clone();
        x.set(node, &Vector3::new(0.0, 0.0, 0.4 * sign));
        system.set_positions(&x).expect("finite");
        system.pin(node).expect("there");
    }
    system.find_equilibrium(1e-10).expect("a pressed ball");
    let pressed = volume.measure(&system) / volume.rest_measure();
    assert!(pressed < 0.995, "without control it loses volume: {pressed}");
    for _ in 0..60 {
        volume.control(&mut system).expect("positive");
        system.find_equilibrium(1e-9).expect("a pressed ball");
    }
    let kept = volume.measure(&system) / volume.rest_measure();
    assert!((kept - 1.0).abs() < 3e-4, "{kept}");
}

#[test]
fn springs_beyond_their_limit_stay_longer() {
    let spring = Spring { yield_strain: 0.1, ..Spring::new([0, 1], 100.0, 1.0) };
    let positions = [Point2::origin(), Point2::new(1.0, 0.0)];
    let mut system = System::new(&positions, &[1.0, 1.0], &[spring]).expect("a spring");
    let stretch = |system: &mut System<2>, length: f64| {
        let mut x = system.positions().clone();
        x.set(1, &Vector2::new(length, 0.0));
        system.set_positions(&x).expect("finite");
        system.give_way()
    };
    assert_eq!(stretch(&mut system, 1.09), 0);
    assert_eq!(stretch(&mut system, 1.32), 1);
    // The elastic strain is at the limit, and so is the force.
    assert_relative_eq!(system.spring(0).rest_length, 1.2, epsilon = 1e-12);
    assert_relative_eq!(system.spring_force(0).x, 12.0, epsilon = 1e-9);
    assert_eq!(stretch(&mut system, 1.2), 0);
    assert_eq!(stretch(&mut system, 0.9), 1);
    assert_relative_eq!(system.spring(0).rest_length, 1.0, epsilon = 1e-12);
}

#[test]
fn a_node_fixed_to_another_follows_it() {
    let place = PlaceMatrix::flag(3, 3).expect("a size");
    let net = Lattice::net(place, 5.0, Cells::Triangular);
    let mut system: System<2> = net.build(Point2::origin()).expect("a net");
    system.pin_to(8, 4).expect("there");
    system.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
    let offset = system.position(8) - system.position(4);
    Leapfrog::new().advance(&mut system, 0.002, 1000).expect("stable");
    assert_relative_eq!(system.position(8) - system.position(4), offset, epsilon = 1e-12);
    let momentum = system.velocity(8) - system.velocity(4);
    assert_eq!(momentum, Vector2::zeros());
}

#[test]
fn nonsense_is_refused_by_name() {
    let unknown = PlaceMatrix::new(&["1t2", "lxr", "4b3"]).expect_err("x is no letter");
    assert_eq!(
        unknown.to_string(),
        "the place matrix has 'x' in row 1, column 1; the letters are f m t b l r 1 2 3 4 h v"
    );
    let shape = PlaceMatrix::new(&["1t2", "lr", "4b3"]).expect_err("a short row");
    assert_eq!(
        shape.to_string(),
        "the place matrix has 2 letters in row 1, but needs 3 in every row and at least two rows"
    );
    assert!(
        PlaceMatrix::new(&["12"]).is_err()
            && PlaceMatrix::new(&[]).is_err()
            && PlaceMatrix::new(&["1"]).is_err()
    );
    let rim = PlaceMatrix::new(&["mm", "mm"]).expect_err("no neighbors above");
    assert!(rim.to_string().contains("above"), "{rim}");
    // A slit down the middle is none: both sides agree.
    let slit = PlaceMatrix::new(&["1212", "4343"]).expect("letters that agree");
    let two = Lattice {
        place: slit,
        ..Lattice::net(PlaceMatrix::free(2, 4).expect("a size"), 1.0, Cells::Triangular)
    };
    assert_eq!(two.build::<2>(Point2::origin()).expect("two nets").springs(), 10);

    let points = [Point2::origin(), Point2::new(1.0, 0.0)];
    let system = |masses: &[f64], spring: Spring| System::new(&points, masses, &[spring]);
    let sound = Spring::new([0, 1], 1.0, 1.0);
    let missing = system(&[1.0, 1.0], Spring::new([0, 2], 1.0, 1.0)).expect_err("two nodes");
    assert_eq!(missing.to_string(), "spring 0 names node 2, but the nodes are numbered 0 to 1");
    let itself = system(&[1.0, 1.0], Spring::new([1, 1], 1.0, 1.0)).expect_err("a loop");
    assert!(itself.to_string().starts_with("spring 0 has both ends at node 1"), "{itself}");
    let massless = system(&[1.0, 0.0], sound).expect_err("no mass");
    assert_eq!(
        massless.to_string(),
        "the mass of node 1 is 0.0 kg, but must be positive and finite"
    );
    for length in [0.0, -1.0, f64::NAN] {
        let short = system(&[1.0, 1.0], Spring::new([0, 1], 1.0, length)).expect_err("no length");
        let text = short.to_string();
        assert!(text.starts_with("spring 0: ") && text.contains(&format!("{length:?}")), "{text}");
    }
    let mut two = system(&[1.0, 1.0], sound).expect("a spring");
    assert!(matches!(two.pin(2), Err(SpringError::MissingNode { node: 2, .. })));
    assert!(two.set_gravity(Vector2::new(f64::NAN, 0.0)).is_err());
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = Leapfrog::new().advance(&mut two, dt, 1);
        assert!(matches!(refused, Err(SpringError::Parameter { .. })), "{refused:?}");
    }
    two.set_velocities(&NodeVectors::of(&[Vector2::zeros(), Vector2::new(1e308, 0.0)]))
        .expect("finite");
    let blown = Leapfrog::new().advance(&mut two, 1e3, 5).expect_err("too fast");
    let text = blown.to_string();
    assert!(text.contains("left all bounds in step 1") && text.starts_with("node "), "{text}");
}

/// A ring pressed between two points, which starts symmetric: of its equilibria that an independent
/// minimizer finds from 60 starts, by energy, the two stable ones; the saddle that keeps the
/// symmetry has 0.255258.
#[test]
fn a_pressed_ring_leaves_its_saddle() {
    let element = Element::unit(3.0_f64.sqrt() / TAU);
    let ball = RoundBody { radius: 1.0, element, radial: 1.0 / 3.0, tau: 0.2 };
    let (mut ring, _) = ball.ring(Point2::origin(), 20).expect("a ring");
    let mut x = ring.positions().clone();
    x.set(6, &Vector2::new(0.0, 0.55));
    x.set(16, &Vector2::new(0.0, -0.55));
    ring.set_positions(&x).expect("finite");
    ring.pin(6).expect("there");
    ring.pin(16).expect("there");
    ring.find_equilibrium(1e-10).expect("a pressed ring");
    let elastic = ring.energy().elastic;
    assert!([0.238_426, 0.244_443].iter().any(|e| (elastic - e).abs() < 1e-6), "{elastic}");
    let softest =
        ring.linearized().expect("a small system").modes().expect("modes").angular_frequencies()[0];
    assert!(softest > 0.0);
}
