//! What motion keeps: energy, momentum, time's direction, the static states.

use approx::assert_relative_eq;
use nalgebra::{Point2, Point3, Vector2, Vector3};
use rapunzel_mass_spring::{
    Cells, Element, ImplicitEuler, Lattice, Leapfrog, NodeVectors, PlaceMatrix, RigidChain, Rope,
    SpringEnergy, SpringError, System, runge_kutta,
};
use std::f64::consts::{PI, TAU};

/// A free triangular net that turns and swings.
fn flying() -> System<2> {
    let place = PlaceMatrix::free(4, 5).expect("a size");
    let mut net = Lattice::net(place, 5.0, Cells::Triangular);
    net.element = Element::unit(5.0);
    let mut system = net.build(Point2::origin()).expect("a net");
    let velocity = |n: usize| Vector2::new((n as f64).sin(), 0.4 * (1.3 * n as f64).cos());
    let velocities: Vec<_> = (0..system.nodes()).map(velocity).collect();
    system.set_velocities(&NodeVectors::of(&velocities)).expect("finite");
    system
}

fn rope(frequency: f64) -> System<2> {
    let rope = Rope { element: Element::unit(frequency), ..Rope::of_the_text(frequency) };
    let mut system = rope.build(Point2::origin(), -Vector2::y()).expect("a rope");
    system.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
    system
}

/// Largest deviation of the energy from the start, over many steps.
fn wander(system: &mut System<2>, dt: f64, steps: usize) -> f64 {
    let start = system.energy().total();
    let mut leapfrog = Leapfrog::new();
    let deviation = |_| {
        leapfrog.advance(system, dt, 10).expect("stable");
        (system.energy().total() - start).abs()
    };
    (0..steps / 10).map(deviation).fold(0.0, f64::max)
}

#[test]
fn the_leapfrog_keeps_energy_with_an_error_of_second_order() {
    let dt = 0.1 * flying().stability_limit();
    let coarse = wander(&mut flying(), dt, 2000);
    let fine = wander(&mut flying(), 0.5 * dt, 4000);
    let ratio = coarse / fine;
    assert!(
        (3.4..4.7).contains(&ratio),
        "{coarse} and {fine}: halving the step divides by {ratio}"
    );
}

#[test]
fn the_leapfrog_does_not_drift_in_a_million_steps() {
    let mut system = flying();
    let dt = 0.1 * system.stability_limit();
    let early = wander(&mut system, dt, 20_000);
    let mut leapfrog = Leapfrog::new();
    let start = flying().energy().total();
    leapfrog.advance(&mut system, dt, 960_000).expect("stable");
    let mut late: f64 = 0.0;
    for _ in 0..2000 {
        leapfrog.advance(&mut system, dt, 10).expect("stable");
        late = late.max((system.energy().total() - start).abs());
    }
    assert!(late < 1.5 * early, "energy wanders by {early} J at first and by {late} J at last");
}

#[test]
fn the_leapfrog_goes_back_the_way_it_came() {
    let (mut system, start) = (flying(), flying());
    let dt = 0.2 * system.stability_limit();
    let mut leapfrog = Leapfrog::new();
    leapfrog.advance(&mut system, dt, 500).expect("stable");
    let back: Vec<_> = (0..system.nodes()).map(|n| -system.velocity(n)).collect();
    system.set_velocities(&NodeVectors::of(&back)).expect("finite");
    leapfrog.advance(&mut system, dt, 500).expect("stable");
    for node in 0..system.nodes() {
        // Rounding errors of 500 steps, which chaos enlarges.
        assert_relative_eq!(system.position(node), start.position(node), epsilon = 1e-9);
    }
}

#[test]
fn momentum_is_kept_without_pins() {
    let before = flying().momentum();
    let mut system = flying();
    let dt = 0.3 * system.stability_limit();
    Leapfrog::new().advance(&mut system, dt, 5000).expect("stable");
    assert_relative_eq!(system.momentum(), before, epsilon = 1e-10);
    let mut system = flying();
    runge_kutta(&mut system, 1e-3, 1000).expect("finite");
    assert_relative_eq!(system.momentum(), before, epsilon = 1e-10);
}

#[test]
fn runge_kutta_is_of_fourth_order_also_in_wind() {
    let end = |steps: usize| {
        let mut system = flying();
        system.set_drag(0.5).expect("positive");
        let mut wind = rapunzel_mass_spring::WindField::steady(Vector2::new(1.0, 0.0));
        (wind.pulse, wind.period) = (Vector2::new(0.0, 3.0), 0.4);
        system.set_wind(wind).expect("finite");
        runge_kutta(&mut system, 0.5 / steps as f64, steps).expect("finite");
        system.position(7).coords
    };
    let [a, b, c] = [100, 200, 400].map(end);
    let order = ((a - b).norm() / (b - c).norm()).log2();
    assert!((3.8..4.3).contains(&order), "order {order}");
}

#[test]
fn the_leapfrog_is_of_second_order_in_drag_and_wind() {
    let end = |steps: usize| {
        let mut system = flying();
        system.set_drag(2.0).expect("positive");
        let mut wind = rapunzel_mass_spring::WindField::steady(Vector2::new(1.0, 0.0));
        (wind.pulse, wind.period) = (Vector2::new(0.0, 3.0), 0.4);
        system.set_wind(wind).expect("finite");
        Leapfrog::new().advance(&mut system, 0.5 / steps as f64, steps).expect("stable");
        system.position(7).coords
    };
    let [a, b, c] = [400, 800, 1600].map(end);
    let order = ((a - b).norm() / (b - c).norm()).log2();
    assert!((1.9..2.1).contains(&order), "order {order}");
}

#[test]
fn one_mass_on_one_spring_swings_at_its_frequency() {
    let rope = Rope { nodes: 2, element: Element::unit(2.0), ..Rope::of_the_text(2.0) };
    let mut system = rope.build(Point2::origin(), Vector2::x()).expect("a rope");
    let omega = 2.0 * TAU;
    let mut x = system.positions().clone();
    x.set(1, &Vector2::new(0.06, 0.0));
    system.set_positions(&x).expect("finite");
    let (dt, mut crossings, mut last) = (0.05 / omega, Vec::new(), 0.01);
    let mut leapfrog = Leapfrog::new();
    for step in 1..20_000 {
        leapfrog.advance(&mut system, dt, 1).expect("stable");
        let now = system.position(1).x - 0.05;
        if last > 0.0 && now <= 0.0 {
            crossings.push((step as f64 - now / (now - last)) * dt);
        }
        last = now;
    }
    let periods = (crossings.len() - 1) as f64;
    let found = TAU * periods / (crossings[crossings.len() - 1] - crossings[0]);
    // The leapfrog is fast by (omega dt)^2 / 24.
    let expected = 1.0 + (omega * dt).powi(2) / 24.0;
    assert!((found / omega - expected).abs() < 1e-6, "{} not {expected}", found / omega);
}

#[test]
fn above_the_limit_only_the_implicit_step_holds() {
    // One node is nudged sideways in a net at rest.
    let place = PlaceMatrix::flag(6, 6).expect("a size");
    let net = Lattice::net(place, 20.0, Cells::Triangular).build(Point3::origin()).expect("a net");
    let mut nudge = net.velocities().clone();
    nudge.set(20, &Vector3::new(0.01, 0.02, -0.01));
    let limit = net.stability_limit();
    let run = |dt: f64| {
        let mut system = net.clone();
        system.set_velocities(&nudge).expect("finite");
        Leapfrog::new().advance(&mut system, dt, 20_000).map(|()| system.energy().total())
    };
    let start = 0.5 * 0.01 * nudge.get(20).norm_squared();
    assert!(run(0.98 * limit).expect("stable") < 10.0 * start);
    assert_eq!(net.warn_of_step(0.98 * limit), None);
    let warning = net.warn_of_step(1.02 * limit).expect("above the limit");
    assert!(warning.to_string().contains(&format!("{limit:e}")), "{warning}");
    // Springs that are stretched soften the growth into chaos; far above nothing is left.
    match run(1.02 * limit) {
        Ok(energy) => assert!(energy > 100.0 * start, "{energy}"),
        Err(error) => assert!(matches!(error, SpringError::BlownUp { .. }), "{error}"),
    }
    let blown = run(3.0 * limit).expect_err("far above the limit");
    assert!(matches!(blown, SpringError::BlownUp { step: 2.., .. }), "{blown}");
    let mut system = net.clone();
    system.set_velocities(&nudge).expect("finite");
    for _ in 0..50 {
        let before = system.energy().total();
        ImplicitEuler::default().step(&mut system, 50.0 * limit).expect("any step");
        assert!(system.energy().total() <= before * (1.0 + 1e-9));
    }
}

/// Energy of a damped system.
fn settled(mut system: System<2>) -> (System<2>, SpringEnergy) {
    system.find_equilibrium(1e-11).expect("a hanging rope");
    let energy = system.energy();
    (system, energy)
}

#[test]
fn every_integrator_comes_to_the_same_rest() {
    let (equilibrium, energy) = settled(rope(5.0));
    let damped = || {
        let mut system = rope(5.0);
        system.set_drag(2.0).expect("positive");
        system
    };
    let mut explicit = damped();
    // The slowest mode is nearly at the critical damping: it decays as exp(-t).
    Leapfrog::new().advance(&mut explicit, 0.02, 1500).expect("stable");
    let mut classical = damped();
    runge_kutta(&mut classical, 0.02, 1500).expect("stable");
    let mut implicit = rope(5.0);
    for _ in 0..400 {
        ImplicitEuler { tolerance: 1e-12 }.step(&mut implicit, 0.5).expect("converges");
    }
    for (what, system) in
        [("leapfrog", explicit), ("Runge-Kutta", classical), ("implicit", implicit)]
    {
        let excess = system.energy().total() - energy.total();
        assert!(excess.abs() < 1e-9 * energy.total().abs(), "{what}: {excess} J");
        for node in 0..system.nodes() {
            let away = (system.position(node) - equilibrium.position(node)).norm();
            assert!(away < 1e-9, "{what}: node {node} is {away} m off");
        }
    }
}

#[test]
fn dampers_take_energy_and_no_momentum() {
    let mut net = Lattice::net(PlaceMatrix::free(4, 5).expect("a size"), 5.0, Cells::Triangular);
    net.element = Element { damping_ratio: 0.2, ..Element::unit(5.0) };
    let mut system = net.build(Point2::origin()).expect("a net");
    system.set_velocities(flying().velocities()).expect("finite");
    let (momentum, energy) = (system.momentum(), system.energy().total());
    let mut implicit = system.clone();
    let dt = 0.5 * system.stability_limit();
    Leapfrog::new().advance(&mut system, dt, 1000).expect("stable");
    // Only turning as a whole is left, which no damper sees.
    assert!(system.energy().kinetic < 0.7 * energy && system.energy().elastic < 0.02 * energy);
    assert_relative_eq!(system.momentum(), momentum, epsilon = 1e-11);
    let before = implicit.energy().total();
    ImplicitEuler { tolerance: 1e-10 }.step(&mut implicit, 0.01).expect("converges");
    assert!(implicit.energy().total() < before);
    assert_relative_eq!(implicit.momentum(), momentum, epsilon = 1e-9);
    // The limit with dampers is one: a little above it, motion grows.
    let (mut below, mut above) = (system.clone(), system.clone());
    let limit = system.stability_limit();
    let size = |system: &System<2>| system.energy().total();
    Leapfrog::new().advance(&mut below, 0.97 * limit, 3000).expect("stable");
    assert!(size(&below) < 1.1 * size(&system));
    let grown = Leapfrog::new().advance(&mut above, 1.1 * limit, 3000);
    assert!(grown.is_err() || size(&above) > 10.0 * size(&system));
}

#[test]
fn a_chain_swings_without_stretching() {
    let rope = Rope { nodes: 11, rigid: true, ..Rope::of_the_text(1.0) };
    let mut system = rope.build(Point2::origin(), Vector2::x()).expect("a chain");
    system.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
    let start = system.energy().total();
    let wander = |dt: f64, steps: usize| {
        let mut system = system.clone();
        let mut chain = RigidChain::new();
        let deviation = |_| {
            chain.advance(&mut system, dt, 1).expect("a chain");
            for k in 0..10 {
                let length = (system.position(k + 1) - system.position(k)).norm();
                assert!((length / 0.05 - 1.0).abs() < 1e-12, "segment {k} is {length} m long");
            }
            (system.energy().total() - start).abs()
        };
        (0..steps).map(deviation).fold(0.0, f64::max)
    };
    let ratio = wander(1e-3, 300) / wander(5e-4, 600);
    assert!((3.0..5.0).contains(&ratio), "halving the step divides the error by {ratio}");
}

#[test]
fn a_chain_of_one_link_is_a_pendulum() {
    let rope = Rope { nodes: 2, spacing: 0.5, rigid: true, ..Rope::of_the_text(1.0) };
    let amplitude = PI / 3.0;
    let direction = Vector2::new(amplitude.sin(), -amplitude.cos());
    let mut system = rope.build(Point2::origin(), direction).expect("a chain");
    system.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
    // A quarter of the period: K(sin 30 degrees) / omega, with K from the arithmetic-geometric
    // mean.
    let (mut a, mut b) = (1.0_f64, (0.5 * amplitude).cos());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    let quarter = PI / (2.0 * a) * (0.5_f64 / 9.81).sqrt();
    let steps = 2000;
    let mut chain = RigidChain::new();
    chain.advance(&mut system, quarter / f64::from(steps), 2000).expect("a chain");
    assert!(system.position(1).x.abs() < 1e-6, "{}", system.position(1));
    // At the lowest point it carries its weight and turns with the energy of the fall.
    let tension = 0.01 * 9.81 * (1.0 + 2.0 * (1.0 - amplitude.cos()));
    assert_relative_eq!(chain.tensions(&system)[0], tension, max_relative = 1e-5);
}

#[test]
fn stiff_springs_tend_to_the_chain() {
    let end = |frequency: f64| {
        let rope = Rope { nodes: 4, element: Element::unit(frequency), ..Rope::of_the_text(1.0) };
        let mut system = rope.build(Point2::origin(), Vector2::x()).expect("a rope");
        system.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
        let dt = 2e-6;
        Leapfrog::new().advance(&mut system, dt, 40_000).expect("stable");
        system.position(3)
    };
    let rope =
        Rope { nodes: 4, element: Element::unit(1.0), rigid: true, ..Rope::of_the_text(1.0) };
    let mut system = rope.build(Point2::origin(), Vector2::x()).expect("a chain");
    system.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
    RigidChain::new().advance(&mut system, 1e-5, 8000).expect("a chain");
    let [soft, stiff] = [500.0, 1000.0].map(|f| (end(f) - system.position(3)).norm());
    // Stretch goes as 1 / k.
    assert!(stiff < 1e-5 && (3.0..5.0).contains(&(soft / stiff)), "{soft} and {stiff}");
}

#[test]
fn a_chain_hangs_from_two_neighbors_that_are_held() {
    // From there on it is a chain that is held by one node.
    let rope = Rope { nodes: 6, rigid: true, ..Rope::of_the_text(10.0) };
    let mut held: System<2> = rope.build(Point2::origin(), Vector2::x()).expect("a chain");
    held.pin(1).expect("there");
    let shorter = Rope { nodes: 5, ..rope };
    let mut short = shorter.build(Point2::new(rope.spacing, 0.0), Vector2::x()).expect("a chain");
    for system in [&mut held, &mut short] {
        system.set_gravity(Vector2::new(0.0, -9.81)).expect("finite");
        RigidChain::new().advance(system, 1e-3, 500).expect("of the right length");
    }
    for node in 0..5 {
        assert_relative_eq!(held.position(node + 1), short.position(node), epsilon = 1e-12);
    }
}

#[test]
fn a_guided_node_that_blows_up_is_named() {
    let spring = rapunzel_mass_spring::Spring::new([0, 1], 1e6, 1.0);
    let positions = [Point2::origin(), Point2::new(1.1, 0.0)];
    let mut system = System::new(&positions, &[1.0; 2], &[spring]).expect("a spring");
    system.pin(0).expect("there");
    system.hold_axis(1, 1, 0.0).expect("there");
    let error = Leapfrog::new().advance(&mut system, 1.0, 1000).expect_err("far above the limit");
    assert!(matches!(error, SpringError::BlownUp { node: 1, .. }), "{error}");
}
