//! What holds for every system.

use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;
use rapunzel_mass_spring::{
    BendResistance, ImplicitEuler, Leapfrog, NodeVectors, RigidChain, Spring, System,
};

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    [-size..size, -size..size, -size..size].prop_map(Vector3::from)
}

/// A chain at rest in any shape, of links and masses that differ.
fn chains() -> impl Strategy<Value = System<3>> {
    let link = (vector(1.0).prop_filter("a direction", |d| d.norm() > 0.1), 0.05..1.0, 0.1..10.0);
    prop::collection::vec(link, 1..10).prop_map(|links| {
        let (mut positions, mut springs) = (vec![Point3::origin()], Vec::new());
        for (i, (direction, length, _)) in links.iter().enumerate() {
            positions.push(positions[i] + direction.normalize() * *length);
            springs.push(Spring::new([i, i + 1], 0.0, *length));
        }
        let masses: Vec<f64> = [1.0].into_iter().chain(links.iter().map(|link| link.2)).collect();
        System::new(&positions, &masses, &springs).expect("sound numbers")
    })
}

fn angular_momentum(system: &System<3>) -> Vector3<f64> {
    let spin = |n| system.position(n).coords.cross(&(system.velocity(n) * system.masses()[n]));
    (0..system.nodes()).map(spin).sum()
}

/// A random net of springs, dampers and bends in motion, with nodes apart from each other.
fn systems() -> impl Strategy<Value = System<3>> {
    (3_usize..9).prop_flat_map(|count| {
        let places = prop::collection::vec(vector(0.3), count);
        let speeds = prop::collection::vec(vector(1.0), count);
        let masses = prop::collection::vec(0.1..10.0, count);
        let springs =
            prop::collection::vec((0..count, 1..count, 0.0..50.0, 0.2..2.0, 0.0..1.0), 1..20);
        (places, speeds, masses, springs).prop_map(move |(places, speeds, masses, springs)| {
            let at = |(n, offset): (usize, &Vector3<f64>)| {
                let corner = Vector3::new((n % 2) as f64, (n / 2 % 2) as f64, (n / 4) as f64);
                Point3::from(corner + offset)
            };
            let positions: Vec<_> = places.iter().enumerate().map(at).collect();
            let spring =
                |&(i, away, stiffness, length, damping): &(usize, usize, f64, f64, f64)| {
                    let nodes = [i, (i + away) % count];
                    Spring { damping, ..Spring::new(nodes, stiffness, length) }
                };
            let mut springs: Vec<_> = springs.iter().map(spring).collect();
            // A bend needs segments that keep their length.
            springs.extend([[0, 1], [1, 2]].map(|nodes| Spring::new(nodes, 50.0, 1.0)));
            let bends = vec![BendResistance { nodes: [0, 1, 2], stiffness: 3.0 }];
            let mut system = System::new(&positions, &masses, &springs)
                .and_then(|system| system.with_bends(bends))
                .expect("sound numbers");
            system.set_velocities(&NodeVectors::of(&speeds)).expect("finite");
            system
        })
    })
}

fn map(
    system: &System<3>,
    of: &NodeVectors<3>,
    f: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> NodeVectors<3> {
    NodeVectors::of(&(0..system.nodes()).map(|n| f(of.get(n))).collect::<Vec<_>>())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn forces_turn_with_the_system_and_do_not_see_where_it_is(
        system in systems(), axis in vector(3.0), shift in vector(5.0),
    ) {
        let turn = Rotation3::new(axis);
        let (x, v) = (system.positions(), system.velocities());
        let moved_x = map(&system, x, |p| turn * p + shift);
        let moved_v = map(&system, v, |v| turn * v + shift);
        let forces = system.internal_forces(x, v);
        let moved = system.internal_forces(&moved_x, &moved_v);
        for n in 0..system.nodes() {
            prop_assert!((turn * forces.get(n) - moved.get(n)).norm() < 1e-9);
        }
    }

    #[test]
    fn action_is_reaction(system in systems()) {
        let forces = system.internal_forces(system.positions(), system.velocities());
        let (mut sum, mut torque) = (Vector3::zeros(), Vector3::zeros());
        for n in 0..system.nodes() {
            sum += forces.get(n);
            torque += system.position(n).coords.cross(&forces.get(n));
        }
        prop_assert!(sum.norm() < 1e-10 && torque.norm() < 1e-10, "{sum} {torque}");
    }

    #[test]
    fn the_matrices_are_symmetric_and_those_of_the_forces(system in systems()) {
        let linear = system.linearized().expect("small");
        let (k, d) = (&linear.stiffness, &linear.damping);
        prop_assert!((k - k.transpose()).amax() < 1e-11 * k.amax().max(1.0));
        prop_assert!((d - d.transpose()).amax() < 1e-11);
        // Translations cost nothing.
        for row in k.row_iter() {
            for axis in 0..3 {
                let sum: f64 = row.iter().skip(axis).step_by(3).sum();
                prop_assert!(sum.abs() < 1e-9);
            }
        }
        let still = NodeVectors::zeros(system.nodes());
        let h = 1e-6;
        for column in 0..k.ncols() {
            let force = |sign: f64| {
                let mut x = system.positions().clone();
                let mut by = Vector3::zeros();
                by[column % 3] = sign * h;
                x.add(column / 3, &by);
                system.internal_forces(&x, &still)
            };
            let (plus, minus) = (force(1.0), force(-1.0));
            for row in 0..k.nrows() {
                let slope = (minus.get(row / 3)[row % 3] - plus.get(row / 3)[row % 3]) / (2.0 * h);
                // The second difference, by the third derivatives where springs are short.
                prop_assert!((slope - k[(row, column)]).abs() < 1e-4 * k.amax().max(1.0));
            }
        }
    }

    #[test]
    fn an_implicit_step_gains_no_energy(system in systems(), dt in 1e-3..1.0) {
        let mut moved = system.clone();
        let before = system.energy().total();
        ImplicitEuler { tolerance: 1e-8 }.step(&mut moved, dt).expect("converges");
        prop_assert!(moved.energy().total() <= before * (1.0 + 1e-9));
        let change = moved.momentum() - system.momentum();
        prop_assert!(change.norm() < 1e-5, "momentum changes by {change}");
    }

    #[test]
    fn momentum_is_kept_and_pins_stay(system in systems(), pinned in 0_usize..3) {
        let mut free = system.clone();
        let dt = 0.2 * free.stability_limit().min(0.1);
        Leapfrog::new().advance(&mut free, dt, 50).expect("finite");
        prop_assert!((free.momentum() - system.momentum()).norm() < 1e-9);
        let mut held = system.clone();
        held.pin(pinned).expect("there");
        Leapfrog::new().advance(&mut held, dt, 50).expect("finite");
        prop_assert_eq!(held.position(pinned), system.position(pinned));
    }

    /// Springs pull along their line: a kick of the leapfrog has no moment, and a drift keeps it.
    #[test]
    fn angular_momentum_is_kept(system in systems()) {
        let mut moved = system.clone();
        let dt = 0.2 * moved.stability_limit().min(0.1);
        Leapfrog::new().advance(&mut moved, dt, 50).expect("finite");
        let change = angular_momentum(&moved) - angular_momentum(&system);
        prop_assert!(change.norm() < 1e-9, "changes by {change}");
    }

    #[test]
    fn forces_of_springs_superpose(system in systems(), cut in 1_usize..20) {
        let springs: Vec<_> = (0..system.springs()).map(|s| system.spring(s)).collect();
        let positions: Vec<_> = (0..system.nodes()).map(|n| system.position(n)).collect();
        let forces = |springs: &[Spring]| {
            let own = System::new(&positions, system.masses(), springs).expect("sound numbers");
            own.internal_forces(system.positions(), system.velocities())
        };
        let (some, others) = springs.split_at(cut.min(springs.len()));
        let (all, some, others) = (forces(&springs), forces(some), forces(others));
        for n in 0..system.nodes() {
            prop_assert!((all.get(n) - some.get(n) - others.get(n)).norm() < 1e-11);
        }
    }

    /// A chain that falls from one end keeps the length of its links, to the tolerance of its
    /// lengths (1e-13) and the rounding of places that are up to ten links from the origin;
    /// nor does a link stretch at the end of a step.
    #[test]
    fn a_chain_is_inextensible(chain in chains(), gravity in vector(10.0)) {
        let mut chain = chain;
        chain.pin(0).expect("there");
        chain.set_gravity(gravity).expect("finite");
        let mut scheme = RigidChain::new();
        for _ in 0..20 {
            scheme.advance(&mut chain, 1e-3, 1).expect("converges");
            for s in 0..chain.springs() {
                let Spring { nodes: [i, j], rest_length, .. } = chain.spring(s);
                let edge = chain.position(j) - chain.position(i);
                let strain = edge.norm() / rest_length - 1.0;
                prop_assert!(strain.abs() < 1e-12, "strain {strain:e} of link {s}");
                let rate = edge.dot(&(chain.velocity(j) - chain.velocity(i))) / rest_length;
                prop_assert!(rate.abs() < 1e-9, "link {s} stretches at {rate:e} m/s");
            }
        }
    }
}
