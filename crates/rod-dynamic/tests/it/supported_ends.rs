//! Ends whose six freedoms are held, sprung, free or loaded one by one.

use Restraint::{Free, Held, Sprung};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rapunzel_fiber::{Fiber, Material, Section};
use rapunzel_rod_dynamic::{
    Conditions, End, EndSupport, Instant, Ledger, Load, Restraint, Rod, RodIntegrator,
    RodStepReport, Staggered, StaggeredBatch, Steady, StepError, elastic_moments, equilibrium,
};
use std::f64::consts::TAU;

pub(crate) const LENGTH: f64 = 0.1;
const RADIUS: f64 = 5e-4;
const MATTER: Material = Material { density: 1000.0, youngs_modulus: 1e7, shear_modulus: 4e6 };

/// A straight rod along the world's z from the origin on.
pub(crate) fn rod(segments: usize, damping_time: f64) -> Rod {
    let fiber = Fiber::uniform(LENGTH, segments, Section::Circle { radius: RADIUS }, &MATTER)
        .expect("a valid fibre");
    Rod::damped(fiber, damping_time)
}

fn bending() -> f64 {
    MATTER.youngs_modulus * TAU / 8.0 * RADIUS.powi(4)
}

fn torsion() -> f64 {
    MATTER.shear_modulus * TAU / 4.0 * RADIUS.powi(4)
}

/// A support at a place on the z axis, with the world's axes.
pub(crate) fn support(
    z: f64,
    translations: [Restraint; 3],
    rotations: [Restraint; 3],
) -> EndSupport {
    EndSupport {
        pose: Isometry3::translation(0.0, 0.0, z),
        axes: UnitQuaternion::identity(),
        translations,
        rotations,
        force: Load::ZERO,
        moment: Load::ZERO,
    }
}

pub(crate) fn weightless() -> Instant {
    Instant::clamped(Isometry3::identity(), Vector3::zeros())
}

/// Takes steps with a ledger; returns the sum of its entries, and the share of all that was turned
/// over that its books miss.
fn booked(
    batch: &mut StaggeredBatch,
    dt: f64,
    steps: usize,
    conditions: &dyn Conditions,
) -> (Ledger, f64) {
    batch.keep_ledgers(true);
    let (mut sum, mut turned) = (Ledger::default(), 0.0);
    for _ in 0..steps {
        batch.step(dt, &[conditions], &mut [RodStepReport::default()]).expect("a step");
        let one = batch.ledger(0).expect("kept");
        turned += one.kinetic.abs() + one.elastic.abs() + one.supports.abs() + one.loads.abs();
        sum += one;
    }
    (sum, (sum.gain() - sum.work()).abs() / turned)
}

/// A rod on a spring along its axis is a mass on a spring: the phase after a period is wrong by the
/// square of the step only, and what it gains is what the spring gives.
#[test]
fn a_rod_on_an_axial_spring_swings_as_a_mass() {
    let own = rod(8, 0.0);
    let (mass, stiffness) = (own.fiber.mass(), 0.5);
    let omega = (stiffness / mass).sqrt();
    let along = [Held, Held, Sprung(stiffness)];
    let start = 1e-3;
    let error = |steps: u32| {
        let root = End::Supported(support(-start, along, [Held; 3]));
        let conditions = Steady(Instant { root, ..weightless() });
        let mut batch = StaggeredBatch::new(vec![own.clone()], 0.9).expect("a batch");
        let dt = TAU / omega / f64::from(steps);
        // A quarter of a period takes it through the spring's rest.
        let (sum, missed) = booked(&mut batch, dt, steps as usize / 4, &conditions);
        assert!(missed < 1e-10, "{missed:e}");
        let state = batch.state(0);
        // Springs work as they lose energy. Of the first step only the force after it is known,
        // whose work is off by that of the spring along the way of the step, `x (omega dt)^2 / 2`.
        let lost = 0.5 * stiffness * (start.powi(2) - (state.positions[0].z + start).powi(2));
        let first = 0.25 * (omega * dt).powi(4);
        assert!((sum.supports - lost).abs() < 1.1 * first * lost, "{} {lost}", sum.supports);
        (state.positions[0].z + start) / start
    };
    let (coarse, fine) = (error(100), error(200));
    println!("displacement after a quarter period: {coarse:e}, {fine:e}");
    assert!(fine.abs() < 1e-3 && (coarse / fine - 4.0).abs() < 0.5, "{coarse:e} {fine:e}");
}

/// A cantilever whose tip hangs on a spring: with the compliance of the beam and of the spring, and
/// with a moment spring too, as beam theory has it.
#[test]
fn a_sprung_tip_bears_its_share() {
    let (force, ei) = (1e-6, bending());
    let cantilever = 3.0 * ei / LENGTH.powi(3);
    let deflection = |segments: usize, spring: f64, turn: f64| {
        let own = rod(segments, 0.0);
        let mut tip = support(LENGTH, [Sprung(spring), Free, Free], [Free, Sprung(turn), Free]);
        tip.force = Load::World(force * Vector3::x());
        let conditions = Instant { tip: End::Supported(tip), ..weightless() };
        let start = Staggered::new(own.clone()).expect("valid").state();
        let (state, _) = equilibrium(&own, &conditions, &start).expect("an equilibrium");
        state.positions[segments].x
    };
    for (spring, turn) in [(cantilever, 0.0), (0.3 * cantilever, 2.0 * ei / LENGTH)] {
        // [x, theta] of a beam's end by [force, moment], with springs on both.
        let beam = nalgebra::Matrix2::new(
            12.0 * ei / LENGTH.powi(3),
            -6.0 * ei / LENGTH.powi(2),
            -6.0 * ei / LENGTH.powi(2),
            4.0 * ei / LENGTH,
        );
        let springs = nalgebra::Matrix2::new(spring, 0.0, 0.0, turn);
        let right = (beam + springs)
            .lu()
            .solve(&nalgebra::Vector2::new(force, 0.0))
            .expect("a regular matrix")
            .x;
        let error = |segments| deflection(segments, spring, turn) / right - 1.0;
        let (coarse, fine) = (error(20), error(40));
        println!("springs {spring:e} {turn:e}: errors {coarse:e} {fine:e}");
        // The chain is of second order in its segments; the beam is linear to (x / L)^2.
        assert!(fine.abs() < 1e-3 && (coarse / fine - 4.0).abs() < 0.3, "{coarse:e} {fine:e}");
    }
}

/// A hinge turns about its axis, and about no other: beside a weight across the axis it hangs as a
/// clamped rod, about the axis its moment speeds the rod up.
#[test]
fn a_hinge_turns_about_its_axis_only() {
    let own = rod(10, 0.0);
    let hinge = support(0.0, [Held; 3], [Free, Held, Held]);
    let solve = |root: End, gravity: Vector3<f64>| {
        let conditions = Instant { root, gravity, ..weightless() };
        let start = Staggered::new(own.clone()).expect("valid").state();
        equilibrium(&own, &conditions, &start).expect("an equilibrium").0
    };
    let weight = Vector3::new(0.05, 0.0, 1.0);
    let clamped = solve(End::Held(Isometry3::identity()), weight);
    let hinged = solve(End::Supported(hinge), weight);
    for (a, b) in clamped.positions.iter().zip(&hinged.positions) {
        assert!((a - b).norm() < 1e-10 * LENGTH, "{a:?} {b:?}");
    }
    // A moment about the axis: the rod gains the angular momentum `M t` about the hinge.
    let moment = 1e-6;
    let turned = EndSupport { moment: Load::World(moment * Vector3::x()), ..hinge };
    let conditions = Steady(Instant { root: End::Supported(turned), ..weightless() });
    let mut batch = StaggeredBatch::new(vec![own.clone()], 0.9).expect("a batch");
    let (dt, steps) = (1e-4, 400);
    let (_, missed) = booked(&mut batch, dt, steps, &conditions);
    assert!(missed < 1e-10, "{missed:e}");
    let (gained, given) = (batch.momentum(0).angular, moment * dt * steps as f64);
    println!("{gained:?} for {given:e}");
    assert!((gained.x / given - 1.0).abs() < 1e-3, "{gained:?} for {given:e}");
    assert!(gained.y.abs() + gained.z.abs() < 1e-9 * given, "{gained:?}");
}

/// The machine that twists: the tip is pulled by a dead force along the axis, along which it is
/// free, while its frame is turned about it. Before the rod leaves the axis, the torque is
/// `GJ angle / L` and the tension is the force.
#[test]
fn a_tip_turned_under_tension_has_its_torque() {
    let own = rod(12, 0.02);
    let (tension, angle, time) = (2e-2, 2.0, 4.0);
    let conditions = |t: f64| {
        let mut tip = support(LENGTH, [Held, Held, Free], [Held; 3]);
        tip.pose.rotation =
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle * t.min(time) / time);
        tip.force = Load::World(tension * Vector3::z());
        Instant { tip: End::Supported(tip), ..weightless() }
    };
    let mut batch = StaggeredBatch::new(vec![own.clone()], 0.5).expect("a batch");
    let (_, missed) = booked(&mut batch, 2e-3, 2500, &conditions);
    assert!(missed < 1e-10, "{missed:e}");
    let state = batch.state(0);
    let right = torsion() * angle / LENGTH;
    for moment in elastic_moments(&own.fiber, &state) {
        assert!((moment - right * Vector3::z()).norm() < 1e-8 * right, "{moment:?} for {right:e}");
    }
    let pull: Vector3<f64> = tension * Vector3::z();
    for force in &state.forces {
        assert!((force - pull).norm() < 1e-9 * tension, "{force:?}");
    }
}

/// Both ends supported, led and sprung in oblique axes: the books close, and what is held is where
/// it is led.
#[test]
fn the_books_of_led_and_sprung_ends_close() {
    let bent = rod(16, 1e-3).fiber.with_natural_curvature(|_| Vector3::new(8.0, 0.0, 3.0));
    let own = Rod::damped(bent.expect("valid"), 1e-3);
    let start = Staggered::new(own.clone()).expect("valid").state();
    let axes = UnitQuaternion::from_euler_angles(0.3, -0.5, 0.9);
    let place = start.positions[16].coords;
    let frame = UnitQuaternion::from_rotation_matrix(&start.frames[15]);
    let conditions = |t: f64| {
        let s = (40.0 * t).sin();
        let root = EndSupport {
            pose: Isometry3::from_parts(
                Translation3::from(1e-3 * s * Vector3::new(1.0, -1.0, 0.5)),
                UnitQuaternion::from_scaled_axis(0.2 * s * Vector3::new(0.3, 1.0, -0.5)),
            ),
            axes,
            translations: [Held, Sprung(0.1), Free],
            rotations: [Sprung(1e-5), Held, Held],
            force: Load::Follower(Vector3::new(1e-5, 0.0, -2e-5)),
            moment: Load::ZERO,
        };
        let tip = EndSupport {
            pose: Isometry3::from_parts(
                Translation3::from(place + 2e-3 * (1.0 - (30.0 * t).cos()) * Vector3::x()),
                UnitQuaternion::from_scaled_axis(0.3 * s * Vector3::y()) * frame,
            ),
            axes: axes.inverse(),
            translations: [Held, Free, Sprung(0.05)],
            rotations: [Sprung(2e-6), Free, Sprung(1e-6)],
            force: Load::World(Vector3::new(0.0, 1e-5, 0.0)),
            moment: Load::Follower(Vector3::new(0.0, 3e-7, 0.0)),
        };
        let gravity = Vector3::new(0.0, 0.0, -9.81);
        Instant {
            root: End::Supported(root),
            tip: End::Supported(tip),
            ..Instant::clamped(Isometry3::identity(), gravity)
        }
    };
    let second_order = StaggeredBatch::new(vec![own.clone()], 0.5);
    for batch in [second_order, StaggeredBatch::backward_euler(vec![own])] {
        let mut batch = batch.expect("a batch");
        let (sum, missed) = booked(&mut batch, 1e-3, 300, &conditions);
        println!("{sum:?}, missed {missed:e}");
        assert!(missed < 1e-10, "{missed:e}");
        assert!(sum.supports.abs() > 1e-7 && sum.solver.abs() < 1e-6 * sum.supports.abs());
        let (state, now) = (batch.state(0), conditions(batch.time()));
        for (end, node) in [(now.root, 0), (now.tip, 16)] {
            let End::Supported(support) = end else { panic!("a support") };
            let away = state.positions[node].coords - support.pose.translation.vector;
            let along = support.axes.inverse_transform_vector(&away);
            assert!(along.x.abs() < 1e-13 && along.y.abs() > 1e-7, "{along:?}");
        }
    }
}

/// With all freedoms held, or free, or only those of the frame free, a support is a clamp, a loaded
/// end, or a ball joint, to the bit.
#[test]
fn supports_of_whole_ends_are_the_usual_ends() {
    let bent = rod(10, 0.0).fiber.with_natural_curvature(|_| Vector3::new(9.0, 0.0, 2.0));
    let own = Rod::damped(bent.expect("valid"), 1e-3);
    let load = Load::World(Vector3::new(1e-4, 0.0, 2e-4));
    let moment = Load::World(Vector3::new(1e-6, 0.0, 0.0));
    let run = |tip: End| {
        let gravity = Vector3::new(0.0, -9.81, 0.0);
        let conditions = Steady(Instant { tip, gravity, ..weightless() });
        let mut integrator = Staggered::new(own.clone()).expect("valid");
        for _ in 0..20 {
            integrator.step(1e-3, &conditions).expect("a step");
        }
        integrator.state()
    };
    let pose = Staggered::new(own.clone()).expect("valid").state().tip(&own.fiber);
    let of = |translations, rotations| {
        let whole = support(0.0, [translations; 3], [rotations; 3]);
        run(End::Supported(EndSupport { pose, force: load, moment, ..whole }))
    };
    let pinned = End::Pinned { position: pose.translation.vector.into(), moment };
    assert!(of(Held, Held) == run(End::Held(pose)));
    assert!(of(Held, Free) == run(pinned));
    assert!(of(Free, Free) == run(End::Loaded { force: load, moment }));
}

/// A fibre with a supported tip does not change what others in its batch do, to the bit.
#[test]
fn a_support_leaves_the_neighbours_alone() {
    let gravity = Vector3::new(9.81, 0.0, 0.0);
    let plain = Steady(Instant { gravity, ..weightless() });
    let tip = support(LENGTH, [Held, Free, Free], [Free, Held, Sprung(1e-6)]);
    let held = Steady(Instant { tip: End::Supported(tip), ..plain.0 });
    let run = |first: &dyn Conditions| {
        let mut batch = StaggeredBatch::new(vec![rod(10, 0.0); 2], 0.5).expect("a batch");
        for _ in 0..30 {
            let mut reports = [RodStepReport::default(); 2];
            batch.step(1e-3, &[first, &plain], &mut reports).expect("a step");
        }
        batch.state(1)
    };
    assert!(run(&held) == run(&plain));
}

#[test]
fn supports_out_of_reach_and_springs_that_push_are_refused() {
    let refused = |tip: EndSupport| {
        let conditions = Steady(Instant { tip: End::Supported(tip), ..weightless() });
        let mut integrator = Staggered::new(rod(4, 0.0)).expect("valid");
        match integrator.step(1e-3, &conditions) {
            Err(StepError::Conditions { why, .. }) => why,
            other => panic!("{other:?}"),
        }
    };
    let far = support(1.01 * LENGTH, [Free, Free, Held], [Free; 3]);
    assert!(refused(far).contains("closer"));
    let soft = support(LENGTH, [Free, Free, Sprung(-1.0)], [Free; 3]);
    assert!(refused(soft).contains("stiffness"));
}

/// A free rod that hangs by its tip is the rod turned round that hangs by its root.
#[test]
fn a_free_root_hangs_on_a_held_tip() {
    let gravity = Vector3::new(2.0, 0.0, -9.81);
    let own = rod(10, 1e-3);
    let run = |conditions: Instant, root: Isometry3<f64>| {
        let hung = Rod::damped(own.fiber.clone().with_root(root), 1e-3);
        let mut batch = StaggeredBatch::new(vec![hung], 0.5).expect("a batch");
        let (_, missed) = booked(&mut batch, 1e-3, 100, &Steady(conditions));
        assert!(missed < 1e-10, "{missed:e}");
        batch.state(0).positions
    };
    let tip = Isometry3::translation(0.0, 0.0, LENGTH);
    let held = Instant { root: End::FREE, tip: End::Held(tip), gravity, ..weightless() };
    let by_tip = run(held, Isometry3::identity());
    let turned = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI);
    let root = Isometry3::from_parts(Translation3::new(0.0, 0.0, LENGTH), turned);
    let by_root = run(Instant::clamped(root, gravity), root);
    let apart = by_tip.iter().zip(by_root.iter().rev()).map(|(a, b)| (a - b).norm());
    let apart = apart.fold(0.0, f64::max);
    assert!((by_tip[0] - Vector3::zeros()).coords.norm() > 0.05 * LENGTH);
    assert!(apart < 1e-9 * LENGTH, "{apart:e}");
}
