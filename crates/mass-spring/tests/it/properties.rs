//! What holds for every system.

use nalgebra::{Point3, Rotation3, Vector3};
use proptest::prelude::*;
use rapunzel_mass_spring::{BendResistance, ImplicitEuler, Leapfrog, NodeVectors, Spring, System};

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    [-size..size, -size..size, -size..size].prop_map(Vector3::from)
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
}
