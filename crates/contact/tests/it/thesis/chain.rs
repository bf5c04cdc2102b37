//! Kinematic chains: joints, springs, conservation.

use super::chains::{G, cantilever, momenta, run, settings, shake, springs, step, straight};
use nalgebra::{DMatrix, Point3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rapunzel_contact::ContactError;
use rapunzel_contact::thesis::chain::{Coupling, CylinderChain, JointMethod, Root, Settings};

#[test]
fn a_hanging_chain_rests() {
    let mut chain = straight(30, 0.3, -Vector3::z(), Root::Hinged(Point3::origin()));
    let start: Vec<_> = chain.segments().iter().map(|s| s.pose).collect();
    run(&mut chain, 2000, &settings(1e-3));
    for (segment, pose) in chain.segments().iter().zip(start) {
        let moved = (segment.pose.translation.vector - pose.translation.vector).norm();
        assert!(moved < 1e-12, "{moved:e}");
        assert!(segment.angular_velocity().norm() < 1e-9);
    }
}

/// The exact frequencies of `n` hinged rods: `det(K - w^2 M) = 0` with `M_ij = m l^2 (n - 1/2 -
/// max(i, j))`, less `m l^2 / 6` on the diagonal, `K_ii = m g l (n - 1/2 - i)`.
fn lowest_mode(n: usize, mass: f64, length: f64, inertia: f64) -> (f64, Vec<f64>) {
    let rest = |i: usize| n as f64 - 0.5 - i as f64;
    let ml2 = mass * length * length;
    let m = DMatrix::from_fn(n, n, |i, j| {
        if i == j { ml2 * (rest(i) - 0.25) + inertia } else { ml2 * rest(i.max(j)) }
    });
    let stiffness =
        DMatrix::from_fn(n, n, |i, j| if i == j { mass * G * length * rest(i) } else { 0.0 });
    let root = m.cholesky().expect("positive definite").l();
    let inverse = root.try_inverse().expect("regular");
    let modes = (&inverse * stiffness * inverse.transpose()).symmetric_eigen();
    let lowest = modes.eigenvalues.imin();
    let shape = inverse.transpose() * modes.eigenvectors.column(lowest);
    let scale = shape[n - 1];
    (modes.eigenvalues[lowest].sqrt(), shape.iter().map(|x| x / scale).collect())
}

#[test]
fn a_chain_swings_at_its_exact_frequency() {
    let (n, length) = (5, 0.5);
    let l = length / n as f64;
    let mass = 0.1 * l;
    // The rods are cylinders: m (3 r^2 + l^2) / 12 about their centers.
    let (omega, shape) = lowest_mode(n, mass, l, mass * (3e-6 + l * l) / 12.0);
    let mut nodes = vec![Point3::origin()];
    for angle in shape.iter().map(|x| 1e-3 * x) {
        let last = *nodes.last().expect("not empty");
        nodes.push(last + l * Vector3::new(angle.sin(), 0.0, -angle.cos()));
    }
    let root = Root::Hinged(Point3::origin());
    let mut chain = CylinderChain::new(&nodes, 0.1, 1e-3, &Vector3::y(), root).expect("valid");
    let dt = 1e-3;
    let tip = |chain: &CylinderChain| chain.ends(n - 1)[1].x;
    // Ten half periods between crossings, each interpolated.
    let (mut crossings, mut before, mut i) = (Vec::new(), tip(&chain), 0);
    while crossings.len() < 11 {
        run(&mut chain, 1, &settings(dt));
        let now = tip(&chain);
        if before * now < 0.0 {
            crossings.push((f64::from(i) + before / (before - now)) * dt);
        }
        (before, i) = (now, i + 1);
    }
    let measured = 10.0 * std::f64::consts::PI / (crossings[10] - crossings[0]);
    // Leapfrog is fast by (w dt)^2 / 24 = 1e-6, the start at rest is met half a step late.
    assert!((measured / omega - 1.0).abs() < 5e-6, "{measured} {omega}");
}

#[test]
fn method_one_has_no_drift_and_method_two_little() {
    let drift = |method: JointMethod, dt: f64, steps: usize| {
        let mut chain = straight(20, 0.2, Vector3::x(), Root::Hinged(Point3::origin()));
        run(&mut chain, steps, &Settings { method, ..settings(dt) })
    };
    let one = drift(JointMethod::ImpulseCorrection, 1e-3, 500);
    let two = drift(JointMethod::Linearized, 1e-3, 500);
    let finer = drift(JointMethod::Linearized, 2.5e-4, 2000);
    println!(
        "widest gap of a falling chain: I {one:e} m, II {two:e} m, at a quarter step {finer:e}"
    );
    assert!(one < 1e-14);
    assert!(two < 1e-4, "{two:e}");
    assert!(two / finer > 10.0, "of second order or better: {two:e} {finer:e}");
}

#[test]
fn newton_needs_few_solves_however_long_the_chain() {
    let solves = [25, 400].map(|n| {
        let length = 0.01 * n as f64;
        let mut chain = straight(n, length, Vector3::x(), Root::Hinged(Point3::origin()));
        let mut most = 0;
        for _ in 0..50 {
            let report = step(std::slice::from_mut(&mut chain), &settings(1e-3));
            most = most.max(report.expect("closed").iterations);
        }
        most
    });
    assert!(solves[0] <= 5 && solves[1] <= 5, "{solves:?}");
}

#[test]
fn a_free_chain_keeps_its_momenta() {
    for coupling in
        [None, Some(Coupling::Explicit), Some(Coupling::Implicit), Some(Coupling::Rigid)]
    {
        let mut chain = straight(12, 0.24, Vector3::x(), Root::Free);
        shake(&mut chain, 0.5, 3);
        if let Some(coupling) = coupling {
            chain = chain.with_springs(springs(1e-4, 11, coupling)).expect("valid");
        }
        let free = Settings { gravity: Vector3::zeros(), ..settings(1e-4) };
        // The first step takes what was shaken apart out of the velocities.
        run(&mut chain, 1, &free);
        let before = momenta(&chain);
        let size: f64 = chain.segments().iter().map(|s| s.mass() * s.velocity.norm()).sum();
        run(&mut chain, 2000, &free);
        let after = momenta(&chain);
        let linear = (after.0 - before.0).norm() / size;
        let angular = (after.1 - before.1).norm() / (size * 0.24);
        assert!(linear < 1e-12 && angular < 1e-12, "{coupling:?}: {linear:e} {angular:e}");
    }
}

#[test]
fn springs_reach_the_cantilevers_sag() {
    let (length, stiffness) = (0.2, 0.1 * G * 0.2_f64.powi(3) / 0.01);
    let sag = |n: usize| {
        let chain = cantilever(n, length);
        let mut chain =
            chain.with_springs(springs(stiffness, n, Coupling::Implicit)).expect("valid");
        // Large steps: implicit springs damp what they cannot resolve.
        run(&mut chain, 400, &settings(0.02));
        (-chain.ends(n - 1)[1].z, chain)
    };
    let load = 0.1 * G;
    let exact = load * length.powi(4) / (8.0 * stiffness);
    let ((coarse, _), (fine, chain)) = (sag(10), sag(20));
    // Small deflections: G = w L^3 / EI = 0.01, so the theory of first order is good to 1e-4 of it.
    let errors = [coarse, fine].map(|sag| (sag / exact - 1.0).abs());
    assert!(errors[1] < 1.1 / 400.0 && errors[0] / errors[1] > 3.5, "of second order: {errors:?}");

    // The explicit springs have the same equilibrium.
    let mut explicit =
        chain.with_springs(springs(stiffness, 20, Coupling::Explicit)).expect("valid");
    for segment in explicit.segments_mut() {
        segment.velocity = Vector3::new(0.0, 0.0, -0.5 * G * 1e-6);
        segment.angular_momentum = Vector3::zeros();
    }
    run(&mut explicit, 500, &settings(1e-6));
    let moved = (-explicit.ends(19)[1].z / fine - 1.0).abs();
    assert!(moved < 1e-6, "{moved:e}");
}

#[test]
fn explicit_springs_swing_at_the_beams_frequency() {
    let (n, length, stiffness) = (16, 0.2, 1e-2);
    let chain = cantilever(n, length);
    let mut chain = chain.with_springs(springs(stiffness, n, Coupling::Explicit)).expect("valid");
    for i in 0..n {
        // Near the first mode: quadratic in the arc length.
        let s = (i as f64 + 0.5) / n as f64;
        chain.segments_mut()[i].velocity.z = 1e-3 * s * s;
    }
    let swing = Settings { gravity: Vector3::zeros(), ..settings(1e-5) };
    let (mut crossings, mut before, mut i) = (Vec::new(), 0.0, 0);
    while crossings.len() < 5 {
        run(&mut chain, 1, &swing);
        let now = chain.ends(n - 1)[1].z;
        if before * now < 0.0 {
            crossings.push((f64::from(i) + before / (before - now)) * swing.dt);
        }
        (before, i) = (now, i + 1);
    }
    let measured = 4.0 * std::f64::consts::PI / (crossings[4] - crossings[0]);
    let exact = 1.875_104_068_711_961_f64.powi(2) / length.powi(2) * (stiffness / 0.1_f64).sqrt();
    // Discretization 1 / n^2, and a few percent of the third mode in the crossings.
    assert!((measured / exact - 1.0).abs() < 0.02, "{measured} {exact}");
}

#[test]
fn orientation_joints_make_a_rigid_body() {
    let nodes = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.1, 0.1, 0.1]];
    let nodes = nodes.map(Point3::from);
    let chain = CylinderChain::new(&nodes, 0.1, 1e-2, &Vector3::new(0.3, 0.5, 1.0), Root::Free)
        .expect("valid");
    let mut rigid = springs(1.0, 2, Coupling::Rigid);
    rigid.natural = chain.curvatures();
    let mut chain = chain.with_springs(rigid).expect("valid");
    let shape = |chain: &CylinderChain| {
        let [a, b] = [chain.ends(0)[0], chain.ends(2)[1]];
        (b - a).norm()
    };
    let (omega, before) = (Vector3::new(1.0, 4.0, 2.0), shape(&chain));
    for segment in chain.segments_mut() {
        segment.velocity = omega.cross(&segment.center().coords);
        segment.set_angular_velocity(&omega);
    }
    run(&mut chain, 500, &Settings { gravity: Vector3::zeros(), ..settings(1e-3) });
    assert!((shape(&chain) - before).abs() < 1e-13);
    assert!(chain.curvatures()[0].norm() > 1.0);
}

/// A hair's segment that rolls turns about its own axis by radians in a step: the axis must not
/// care.
#[test]
fn a_spinning_segment_precesses_exactly() {
    let nodes = [Point3::origin(), Point3::new(0.003, 0.0, 0.0)];
    let mut chain =
        CylinderChain::new(&nodes, 5e-6, 3.5e-5, &Vector3::y(), Root::Free).expect("valid");
    let dt = 1e-3;
    let segment = &mut chain.segments_mut()[0];
    segment.set_angular_velocity(&(Vector3::new(7.0, 0.2, 0.4) / dt));
    let (start, momentum) = (segment.pose.rotation, segment.angular_momentum);
    let omega = segment.angular_velocity();
    let steps = 50;
    run(&mut chain, steps, &Settings { gravity: Vector3::zeros(), ..settings(dt) });
    let time = dt * steps as f64;
    // Of a thin cylinder, m (3 r^2 + l^2) / 12 across and m r^2 / 2 along.
    let across = 1.5e-8 * (3.0 * 3.5e-5_f64.powi(2) + 9e-6) / 12.0;
    let along = 1.5e-8 * 0.5 * 3.5e-5_f64.powi(2);
    assert!((momentum.x / (along * omega.x) - 1.0).abs() < 1e-12);
    let spin = momentum.x * (1.0 / along - 1.0 / across) * time;
    let exact = UnitQuaternion::from_scaled_axis(momentum * (time / across))
        * start
        * UnitQuaternion::from_scaled_axis(Vector3::z() * spin);
    let error = chain.segments()[0].pose.rotation.angle_to(&exact);
    // Of 350 radians in 50 steps.
    assert!(error < 1e-7, "{error:e}");
    let axis = chain.segments()[0].pose.rotation * Vector3::z();
    assert!((axis - exact * Vector3::z()).norm() < 1e-12);
    assert!((chain.segments()[0].angular_momentum - momentum).norm() < 1e-12 * momentum.norm());
}

/// Torsion springs as stiff as a hair's and segments that spin against each other close all the
/// same.
#[test]
fn twisted_joints_close() {
    let mut chain = straight(12, 0.036, Vector3::x() + Vector3::z(), Root::Free);
    chain = chain.with_springs(springs(1e-6, 11, Coupling::Implicit)).expect("valid");
    let dt = 1e-3;
    for (i, segment) in chain.segments_mut().iter_mut().enumerate() {
        let axis = segment.pose.rotation * Vector3::z();
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        segment.set_angular_velocity(&(side * (1.2 * axis + Vector3::new(0.1, 0.2, 0.0)) / dt));
    }
    let widest = run(&mut chain, 50, &settings(dt));
    assert!(widest < 1e-12, "{widest:e}");
    let twist = chain.curvatures().iter().map(|k| k.norm() * 0.003).fold(0.0, f64::max);
    assert!(twist < 0.2, "springs take it out: {twist}");
}

#[test]
fn axial_moments_change_no_other() {
    let plain = straight(5, 0.1, Vector3::y() + Vector3::x(), Root::Free);
    let mut chain = plain.clone();
    shake(&mut chain, 1.0, 7);
    let before = chain.clone();
    let chain = chain.with_axial_moments(0.5).expect("valid");
    for (heavy, light) in chain.segments().iter().zip(before.segments()) {
        let axis = light.pose.rotation * Vector3::z();
        let across = light.pose.rotation * Vector3::x();
        let moment = across.dot(&(light.inertia() * across));
        assert!((axis.dot(&(heavy.inertia() * axis)) / (0.5 * moment) - 1.0).abs() < 1e-12);
        assert!((across.dot(&(heavy.inertia() * across)) / moment - 1.0).abs() < 1e-12);
        assert_eq!(
            (heavy.mass(), heavy.velocity, heavy.pose),
            (light.mass(), light.velocity, light.pose)
        );
        let turned = heavy.angular_velocity() - light.angular_velocity();
        assert!(turned.norm() < 1e-12 * light.angular_velocity().norm());
    }
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(plain.clone().with_axial_moments(bad).is_err());
    }
}

#[test]
fn bad_chains_and_steps_are_refused() {
    let up = Vector3::z();
    let p = |x: f64| Point3::new(x, 0.0, 0.0);
    let new = |nodes: &[Point3<f64>], density: f64, radius: f64| {
        CylinderChain::new(nodes, density, radius, &up, Root::Free)
    };
    assert!(new(&[p(0.0)], 1.0, 1.0).is_err());
    assert!(new(&[p(0.0), p(0.0)], 1.0, 1.0).is_err());
    assert!(new(&[p(0.0), p(1.0), p(0.5)], 1.0, 1.0).is_err());
    assert!(new(&[p(0.0), p(f64::NAN)], 1.0, 1.0).is_err());
    assert!(new(&[p(0.0), p(1.0)], 0.0, 1.0).is_err());
    assert!(new(&[p(0.0), p(1.0)], 1.0, -1.0).is_err());
    assert!(CylinderChain::new(&[p(0.0), p(1.0)], 1.0, 1.0, &Vector3::x(), Root::Free).is_err());
    let chain = new(&[p(0.0), p(1.0), p(2.0)], 1.0, 0.1).expect("valid");
    assert!(chain.clone().with_springs(springs(1.0, 2, Coupling::Explicit)).is_err());
    assert!(chain.clone().with_springs(springs(0.0, 1, Coupling::Explicit)).is_err());
    let mut sprung =
        chain.clone().with_springs(springs(1.0, 1, Coupling::Explicit)).expect("valid");
    assert!(sprung.set_root(Root::Hinged(Point3::origin())).is_err(), "one more joint");
    assert_eq!(sprung.root(), Root::Free);
    let mut chains = [chain];
    assert!(step(&mut chains, &settings(0.0)).is_err());
    assert!(step(&mut chains, &Settings { restitution: 1.1, ..settings(1e-3) }).is_err());
    chains[0].segments_mut()[0].velocity.z = f64::INFINITY;
    let before = chains.clone();
    let result = step(&mut chains, &settings(1e-3));
    let Err(ContactError::Joint { chain: 0, gap, .. }) = result else { panic!("{result:?}") };
    assert_eq!(gap, f64::INFINITY);
    assert_eq!(chains, before);
}

#[test]
fn threads_do_not_change_a_bit() {
    let runs = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut chains: Vec<CylinderChain> = (0..8)
            .map(|i| {
                let mut chain = straight(10, 0.2, Vector3::x(), Root::Hinged(Point3::origin()));
                shake(&mut chain, 0.3, 100 + i);
                chain
            })
            .collect();
        pool.install(|| {
            for _ in 0..20 {
                step(&mut chains, &settings(1e-3)).expect("closed");
            }
        });
        chains
    });
    assert_eq!(runs[0], runs[1]);
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 64,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]
    /// Whatever moves a chain, its joints are closed after every step, free or held, and a held or
    /// a free chain's segments keep their lengths.
    #[test]
    fn joints_close(seed in 1..u64::MAX, n in 1..20_usize, speed in 0.0..2.0_f64, held: bool) {
        let root = if held { Root::Hinged(Point3::origin()) } else { Root::Free };
        let mut chain = straight(n, 0.02 * n as f64, Vector3::y() + Vector3::x(), root);
        shake(&mut chain, speed, seed);
        let widest = run(&mut chain, 20, &settings(5e-4));
        prop_assert!(widest < 1e-13, "{widest:e}");
        for segment in chain.segments() {
            prop_assert!(segment.velocity.iter().all(|x| x.is_finite()));
        }
    }
}
