//! All cases of the reference file, told apart by their fields.

use crate::common::{Case, cases, difference, distance};
use nalgebra::{DVector, Point2, Vector2};
use rapunzel_mass_spring::{
    Cells, Element, Lattice, Leapfrog, NodeVectors, PlaceMatrix, Rope, RoundBody, System,
};
use std::f64::consts::{PI, TAU};

/// Equilibria are found to this part of the mean rest length.
const STATIC: f64 = 1e-11;

#[test]
fn every_case_holds() {
    for case in cases() {
        if case.node_depths_static.is_some() {
            hanging_rope(&case);
        } else if case.span.is_some() {
            chain_between_two_points(&case);
        } else if case.prestretch.is_some() {
            stretched_net(&case);
        } else if case.positions_row_major.is_some() {
            hanging_net(&case);
        } else if case.rows.is_some() {
            beam(&case);
        } else if case.count.is_some() {
            ring(&case);
        } else {
            panic!("{}: a case of no known kind", case.name);
        }
    }
}

fn element(case: &Case) -> Element {
    Element::unit(case.frequency.or(case.w0.map(|w| w / TAU)).expect("a frequency"))
}

fn settle(system: &mut System<2>, name: &str) {
    system.find_equilibrium(STATIC).unwrap_or_else(|error| panic!("{name}: {error}"));
}

fn rope(case: &Case, nodes: usize, direction: Vector2<f64>) -> System<2> {
    let rope = Rope {
        nodes,
        spacing: case.rest_length.expect("a rest length"),
        element: element(case),
        bending_stiffness: 0.0,
        rigid: false,
    };
    let mut system = rope.build(Point2::origin(), direction).expect("a rope");
    system.set_gravity(Vector2::new(0.0, -case.g.expect("gravity"))).expect("finite");
    system
}

fn hanging_rope(case: &Case) {
    let name = &case.name;
    let moving = case.moving_nodes.expect("a count");
    let mut system = rope(case, moving + 1, -Vector2::y());
    // The limit at rest is that of the longitudinal modes, which do not depend on gravity.
    let limit = case.leapfrog_dt_limit.expect("a limit");
    let found = system.stability_limit();
    assert!((found / limit - 1.0).abs() < 1e-6, "{name}: limit {found}, not {limit}");
    // Without a step at a multiple of the limit itself, this is the number of sub-steps.
    let substeps = case.substeps.expect("a count");
    let step = |n: usize| 1.0 / 60.0 / n as f64;
    assert!(step(substeps) < found && (substeps == 1 || step(substeps - 1) >= found), "{name}");

    settle(&mut system, name);
    let depths: Vec<_> = (1..=moving).map(|n| -system.position(n).y).collect();
    let expected = case.node_depths_static.as_ref().expect("depths");
    assert!(difference(&depths, expected) < 1e-11, "{name}: {}", difference(&depths, expected));
    let length = case.total_length_static.expect("a length");
    assert!((depths[moving - 1] / length - 1.0).abs() < 1e-11, "{name}");
    let extension = depths[moving - 1] - moving as f64 * case.rest_length.expect("a length");
    assert!((extension / case.extension.expect("one") - 1.0).abs() < 1e-10, "{name}");

    let mut expected = case.longitudinal_omega.clone().expect("frequencies");
    expected.extend(case.transverse_omega.as_ref().expect("frequencies"));
    expected.sort_by(f64::total_cmp);
    let found = system.linearized().expect("small").modes().expect("modes").angular_frequencies();
    assert!(difference(&found, &expected) < 1e-9, "{name}: {}", difference(&found, &expected));
}

fn chain_between_two_points(case: &Case) {
    let name = &case.name;
    let (moving, span) = (case.moving_nodes.expect("a count"), case.span.expect("a span"));
    let mut system = rope(case, moving + 2, Vector2::x());
    let at = |k: usize| {
        let along = k as f64 / (moving + 1) as f64;
        Vector2::new(span * along, -span * (PI * along).sin())
    };
    let start: Vec<_> = (0..moving + 2).map(at).collect();
    system.set_positions(&NodeVectors::of(&start)).expect("finite");
    system.pin(moving + 1).expect("there");
    let end = Vector2::new(span, 0.0);
    let mut placed = system.positions().clone();
    placed.set(moving + 1, &end);
    system.set_positions(&placed).expect("finite");
    settle(&mut system, name);
    let columns = |axis: usize| (1..=moving).map(|n| system.position(n)[axis]).collect::<Vec<_>>();
    for (axis, expected) in [(0, &case.x), (1, &case.y)] {
        let expected = expected.as_ref().expect("positions");
        let wrong = difference(&columns(axis), expected);
        assert!(wrong < 1e-9, "{name}: axis {axis} by {wrong}");
    }
    let lengths: Vec<_> =
        (0..=moving).map(|k| (system.position(k + 1) - system.position(k)).norm()).collect();
    assert!(difference(&lengths, case.spring_lengths.as_ref().expect("lengths")) < 1e-9, "{name}");
    let tension = system.spring_force(0).x;
    assert!((tension / case.horizontal_tension.expect("one") - 1.0).abs() < 1e-9, "{name}");
    let sag = columns(1).iter().fold(0.0, |a: f64, y| a.max(-y));
    assert!((sag / case.max_sag.expect("one") - 1.0).abs() < 1e-9, "{name}");
}

fn stretched_net(case: &Case) {
    let name = &case.name;
    let [rows, columns] = case.nodes.expect("a size");
    let place = PlaceMatrix::free(rows, columns).expect("a size");
    let mut net =
        Lattice { place, spacing: 1.0, element: element(case), cells: Cells::Rectangular };
    let letters: Vec<String> = (0..rows)
        .map(|row| {
            let rim = |column| row == 0 || row + 1 == rows || column == 0 || column + 1 == columns;
            (0..columns).map(|column| if rim(column) { 'f' } else { 'm' }).collect()
        })
        .collect();
    let letters: Vec<&str> = letters.iter().map(String::as_str).collect();
    net.place = PlaceMatrix::new(&letters).expect("letters that agree");
    let mut system = net.build(Point2::origin()).expect("a net");
    let stretch = case.prestretch.expect("a stretch");
    let stretched: Vec<_> =
        (0..system.nodes()).map(|n| system.position(n).coords * stretch).collect();
    system.set_positions(&NodeVectors::of(&stretched)).expect("finite");
    let found = system.linearized().expect("small").modes().expect("modes").angular_frequencies();
    let expected = case.omega_sorted.as_ref().expect("frequencies");
    assert!(difference(&found, expected) < 1e-9, "{name}: {}", difference(&found, expected));
    let largest = found.last().expect("modes") / case.omega_max.expect("one");
    assert!((largest - 1.0).abs() < 1e-10, "{name}");
    let limit = system.stability_limit() / case.leapfrog_dt_limit.expect("a limit");
    assert!((limit - 1.0).abs() < 1e-6, "{name}: limit off by {}", limit - 1.0);
}

fn hanging_net(case: &Case) {
    let name = &case.name;
    let [rows, columns] = case.nodes.expect("a size");
    let place = PlaceMatrix::free(rows, columns).expect("a size");
    let mut net = Lattice::net(place, case.frequency.expect("one"), Cells::Rectangular);
    net.spacing = case.rest_length.expect("a length");
    net.element = element(case);
    let mut system = net.build(Point2::origin()).expect("a net");
    let fixed = case.fixed.as_deref().expect("a rule");
    for column in 0..columns {
        if fixed == "top" || column == 0 || column + 1 == columns {
            system.pin(column).expect("there");
        }
    }
    assert!(["top", "corners"].contains(&fixed), "{name}: fixed {fixed}?");
    system.set_gravity(Vector2::new(0.0, -case.g.expect("one"))).expect("finite");
    settle(&mut system, name);
    let wrong = distance(&system, case.positions_row_major.as_ref().expect("positions"));
    assert!(wrong < 1e-10, "{name}: {wrong} m");
    let lowest = system.linearized().expect("small").modes().expect("modes").squares[0];
    assert!((lowest / case.lowest_eigenvalue.expect("one") - 1.0).abs() < 1e-7, "{name}: {lowest}");
}

fn beam(case: &Case) {
    let name = &case.name;
    let (rows, columns) = (case.rows.expect("rows"), case.cols.expect("columns"));
    let guided = case.right_x.is_some();
    let letters: Vec<String> = (0..rows)
        .map(|row| {
            let last = if guided {
                "v"
            } else {
                ["2", "r", "3"][usize::from(row > 0) + usize::from(row + 1 == rows)]
            };
            let middle = ["t", "m", "b"][usize::from(row > 0) + usize::from(row + 1 == rows)];
            format!("f{}{last}", middle.repeat(columns - 2))
        })
        .collect();
    let place = PlaceMatrix::new(&letters.iter().map(String::as_str).collect::<Vec<_>>());
    let cells = Cells::Braced { ratio: case.kd_over_k.expect("a ratio") };
    let lattice = Lattice {
        place: place.expect("letters that agree"),
        spacing: 1.0,
        element: Element { mass: 1.0, ..element_of_beam(case) },
        cells,
    };
    let mut system = lattice.build(Point2::origin()).expect("a beam");
    let gravity = Vector2::new(0.0, -case.g.expect("gravity"));
    system.set_gravity(gravity).expect("finite");

    // Small displacements: K s = F, within the supports, by the modes of K.
    let linear = system.linearized().expect("small");
    let modes = linear.modes().expect("modes");
    let weights = DVector::from_fn(2 * system.nodes(), |row, _| gravity[row % 2]);
    let mut displacement = DVector::zeros(weights.len());
    for (shape, square) in modes.shapes.column_iter().zip(&modes.squares) {
        displacement += shape * (shape.dot(&weights) / square);
    }
    let expected: Vec<f64> = case.linear_displacement.iter().flatten().flatten().copied().collect();
    let wrong = difference(displacement.as_slice(), &expected);
    assert!(wrong < 1e-9, "{name}: linear displacement by {wrong}");
    let node = |row, column| lattice.node(row, column);
    let mean = |of: &dyn Fn(usize) -> Vector2<f64>| {
        (0..rows).map(|row| of(node(row, columns - 1))).sum::<Vector2<f64>>() / rows as f64
    };
    let scale = displacement.amax();
    let moved = |n: usize| Vector2::new(displacement[2 * n], displacement[2 * n + 1]);
    if let Some(tip) = case.linear_tip_mean {
        assert!((mean(&moved) - Vector2::from(tip)).norm() < 1e-9 * scale, "{name}");
    }
    if let Some(right) = case.right_x {
        assert!((mean(&moved).x - right).abs() < 1e-9 * scale, "{name}");
        let middle = moved(node(rows / 2, columns / 2)).y;
        assert!(
            (middle - case.mid_deflection.expect("one")).abs() < 1e-9 * scale,
            "{name}: {middle}"
        );
    }

    if let Some(expected) = &case.nonlinear_positions {
        let start = system.clone();
        settle(&mut system, name);
        let wrong = distance(&system, expected);
        assert!(wrong < 1e-8, "{name}: {wrong}");
        let moved = |n: usize| system.position(n) - start.position(n);
        let tip = Vector2::from(case.nonlinear_tip_mean.expect("one"));
        assert!((mean(&moved) - tip).norm() < 1e-8, "{name}");
        let lowest = system.linearized().expect("small").modes().expect("modes").squares[0];
        let expected = case.nonlinear_lowest_eigenvalue.expect("one");
        assert!((lowest / expected - 1.0).abs() < 1e-6, "{name}: {lowest}");
    }
}

fn element_of_beam(case: &Case) -> Element {
    // Where it is left out, it is 1.
    Element::unit(case.w0.unwrap_or(1.0) / TAU)
}

fn ring(case: &Case) {
    let name = &case.name;
    let stiffness = case.k_surface.expect("a stiffness");
    let ball = RoundBody {
        radius: case.radius.expect("a radius"),
        element: Element::unit(stiffness.sqrt() / TAU),
        radial: case.k_radial.expect("a stiffness") / stiffness,
        tau: case.tau.expect("a strength"),
    };
    let count = case.count.expect("a count");
    let (mut system, area) = ball.ring(Point2::origin(), count).expect("a ring");
    let rest = area.rest_measure();
    assert!((rest / case.rest_area.expect("an area") - 1.0).abs() < 1e-12, "{name}");
    let circle = PI * ball.radius.powi(2);
    assert!((rest / circle - case.over_circle.expect("one")).abs() < 1e-12, "{name}");

    // The middle is node 0 here and the last one there.
    let ours = |theirs: usize| if theirs == count { 0 } else { theirs + 1 };
    let mut positions = system.positions().clone();
    for (&theirs, position) in case.held_nodes.iter().flatten() {
        positions.set(ours(theirs), &Vector2::from(*position));
        system.pin(ours(theirs)).expect("there");
    }
    system.set_positions(&positions).expect("finite");
    settle(&mut system, name);
    let ratio = area.measure(&system) / rest;
    let expected = case.area_ratio_without_control.expect("one");
    assert!((ratio - expected).abs() < 1e-10, "{name}: {ratio} without control");

    // Rings that are squashed much have several equilibria, and which one is met on the way is up
    // to the solver. So the state that is given, which may be a saddle, is looked at by itself:
    // nothing moves from it.
    let mut given = system.clone();
    for radial in system.springs() - count..system.springs() {
        given.set_rest_length(radial, case.radial_rest_length.expect("one")).expect("positive");
    }
    let controlled = case.controlled.as_ref().expect("positions");
    for (theirs, position) in controlled.iter().enumerate() {
        positions.set(ours(theirs), &Vector2::from(*position));
    }
    given.set_positions(&positions).expect("finite");
    // A force of 1e-8 on the unit masses would move them by 1e-10.
    Leapfrog::new().advance(&mut given, 0.1, 1).expect("a stable step");
    let moved = |(theirs, position): (usize, &[f64; 2])| {
        (given.position(ours(theirs)).coords - Vector2::from(*position)).norm()
    };
    let moved = controlled.iter().enumerate().map(moved).fold(0.0, f64::max);
    assert!(moved < 1e-10, "{name}: the given state moves by {moved}");
    assert!((area.measure(&given) / rest - 1.0).abs() < 1e-9, "{name}");

    let mut ratios = vec![ratio];
    for _ in 1..=60 {
        area.control(&mut system).expect("rest lengths stay positive");
        settle(&mut system, name);
        ratios.push(area.measure(&system) / rest);
    }
    let reference = case.quasi_static_area_ratio.as_ref().expect("ratios");
    assert!((ratios[1] - reference[1]).abs() < 1e-9, "{name}: {} after a step", ratios[1]);
    // What the integral controller promises.
    assert!((ratios[40] - 1.0).abs() < 2e-3, "{name}: {} after 40 steps", ratios[40]);
    assert!((ratios[60] - 1.0).abs() < 3e-4, "{name}: {} after 60 steps", ratios[60]);
}
