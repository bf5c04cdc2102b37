//! Alg. 7: chains in contact.

use nalgebra::{Isometry3, Point3, Vector3};
use rapunzel_contact::thesis::Response;
use rapunzel_contact::thesis::chain::{
    Coupling, CylinderChain, JointMethod, JointSprings, LastWord, Root, SegmentContact,
    SegmentPartner, Settings, step,
};
use rapunzel_contact::thesis::projection::{Differences, Form, PolygonalCone};
use rapunzel_contact::{ContactError, GaussSeidel, Tolerance};

const RADIUS: f64 = 1e-3;

fn settings(order: LastWord, harmonizations: usize) -> Settings {
    Settings {
        dt: 1e-3,
        gravity: Vector3::new(0.0, 0.0, -9.81),
        method: JointMethod::ImpulseCorrection,
        order,
        harmonizations,
        restitution: 0.0,
        form: Form::Corrected.into(),
    }
}

/// Alg. 6, corrected but for its scope.
fn alone() -> Differences {
    Differences { scope: Form::AsPrinted, ..Form::Corrected.into() }
}

/// All contacts by the law.
fn together() -> GaussSeidel {
    GaussSeidel::new(Tolerance::EXACT)
}

fn line(from: Point3<f64>, to: Point3<f64>, segments: usize, root: Root) -> CylinderChain {
    let node = |i: usize| from + (to - from) * (i as f64 / segments as f64);
    let nodes: Vec<_> = (0..=segments).map(node).collect();
    CylinderChain::new(&nodes, 0.01, RADIUS, &Vector3::new(0.1, 0.9, 0.4), root).expect("valid")
}

fn friction(mu: f64) -> PolygonalCone {
    PolygonalCone::regular(mu, 8).expect("valid")
}

/// The poses at which contacts are asked for.
fn poses(chain: &CylinderChain, settings: &Settings) -> Vec<Isometry3<f64>> {
    match settings.form.contact_time {
        Form::AsPrinted => chain.half_way(settings.dt),
        Form::Corrected => chain.segments().iter().map(|segment| segment.pose).collect(),
    }
}

/// Contacts with the plane z = 0 at both ends of every segment of chain 0.
fn on_plane(chain: &CylinderChain, settings: &Settings, mu: f64) -> Vec<SegmentContact> {
    let half = 0.5 * (chain.ends(0)[1] - chain.ends(0)[0]).norm();
    let ends = |(segment, pose): (usize, Isometry3<f64>)| {
        [-half, half].map(|z| {
            let end = pose * Point3::new(0.0, 0.0, z);
            SegmentContact {
                chain: 0,
                segment,
                point: Point3::new(end.x, end.y, end.z - RADIUS),
                normal: Vector3::z(),
                gap: end.z - RADIUS,
                partner: SegmentPartner::Given(Vector3::zeros()),
                friction: friction(mu),
            }
        })
    };
    let all = poses(chain, settings).into_iter().enumerate().flat_map(ends);
    all.filter(|contact| contact.gap < 0.1 * RADIUS).collect()
}

#[test]
fn a_chain_lies_still_on_a_plane() {
    let at = |x: f64| Point3::new(x, 0.0, RADIUS);
    let mut chains = [line(at(0.0), at(0.1), 10, Root::Free)];
    let start = chains[0].clone();
    let settings = settings(LastWord::JointsFirst, 1);
    for _ in 0..1000 {
        let contacts = on_plane(&chains[0], &settings, 0.3);
        assert_eq!(contacts.len(), 20);
        step(&mut chains, &contacts, &settings, &mut alone()).expect("solved");
    }
    for (now, then) in chains[0].segments().iter().zip(start.segments()) {
        assert!((now.center() - then.center()).norm() < 1e-10);
    }
}

#[test]
fn a_sliding_chain_is_braked_by_friction() {
    let at = |x: f64| Point3::new(x, 0.0, RADIUS);
    let mut chains = [line(at(0.0), at(0.1), 10, Root::Free)];
    for segment in chains[0].segments_mut() {
        segment.velocity.y = 1.0;
    }
    let settings = settings(LastWord::JointsFirst, 1);
    for _ in 0..100 {
        let contacts = on_plane(&chains[0], &settings, 0.3);
        step(&mut chains, &contacts, &settings, &mut alone()).expect("solved");
    }
    // Friction acts below the centers, where it would roll the segments: the full law would let
    // them roll, the second projection must not press an end into the plane.
    for segment in chains[0].segments() {
        let slip = segment.velocity.y + segment.angular_velocity().x * RADIUS;
        assert!(slip < 1.0 - 0.29 * 9.81 * 0.1, "{slip}");
    }
}

/// The fault that corrections leave (see `two_projections_do_not_hold_a_high_box`): along the axis
/// friction would press the front ends down, and is given up. A contact in the middle has it, and
/// so has the law.
#[test]
fn friction_along_the_axis_needs_contacts_without_a_lever() {
    let braked = |ends: bool, response: &mut dyn Response| {
        let at = |x: f64| Point3::new(x, 0.0, RADIUS);
        let mut chains = [line(at(0.0), at(0.1), 10, Root::Free)];
        for segment in chains[0].segments_mut() {
            segment.velocity.x = 1.0;
        }
        let settings = settings(LastWord::JointsFirst, 1);
        for _ in 0..100 {
            let mut contacts = on_plane(&chains[0], &settings, 0.3);
            if !ends {
                contacts = contacts.chunks_exact(2).map(|c| c[0].clone()).collect();
                for (contact, segment) in contacts.iter_mut().zip(chains[0].segments()) {
                    contact.point = segment.center() - RADIUS * Vector3::z();
                }
            }
            step(&mut chains, &contacts, &settings, response).expect("solved");
        }
        1.0 - chains[0].segments()[5].velocity.x
    };
    let (middle, ends) = (braked(false, &mut alone()), braked(true, &mut alone()));
    let law = braked(true, &mut together());
    println!(
        "braked in 0.1 s by {middle} m/s, with contacts at the ends by {ends}, {law} by the law"
    );
    // Less what the segments' pitching takes.
    assert!((middle / (0.3 * 9.81 * 0.1) - 1.0).abs() < 0.02, "{middle}");
    assert!(ends < 0.5 * middle, "{ends}");
    // The mean velocity of the first step, which contacts see, has half of its weight.
    assert!((law / (0.3 * 9.81 * 0.0995) - 1.0).abs() < 1e-9, "{law}");
}

/// A chain from a hinge over a bar along y: the widest gap of a joint and the deepest penetration.
fn over_a_bar(settings: &Settings) -> (f64, f64) {
    let (bar, segments) = (0.005, 20);
    let bar_center = Vector3::new(0.1, 0.0, -bar - RADIUS);
    let root = Root::Hinged(Point3::origin());
    let mut chains = [line(Point3::origin(), Point3::new(0.2, 0.0, 0.0), segments, root)];
    let half = 0.1 / segments as f64;
    let (mut widest, mut deepest) = (0.0_f64, 0.0_f64);
    for _ in 0..200 {
        let mut contacts = Vec::new();
        for (segment, pose) in poses(&chains[0], settings).into_iter().enumerate() {
            let local = pose.inverse_transform_point(&bar_center.into());
            let near = pose * Point3::new(0.0, 0.0, local.z.clamp(-half, half));
            let away = near.coords - bar_center;
            let normal = Vector3::new(away.x, 0.0, away.z).normalize();
            let gap = away.xz().norm() - bar - RADIUS;
            if gap < 0.5 * RADIUS {
                deepest = deepest.max(-gap);
                contacts.push(SegmentContact {
                    chain: 0,
                    segment,
                    point: near - RADIUS * normal,
                    normal,
                    gap,
                    partner: SegmentPartner::Given(Vector3::zeros()),
                    friction: friction(0.3),
                });
            }
        }
        let report = step(&mut chains, &contacts, settings, &mut alone()).expect("solved");
        widest = widest.max(report.widest_gap);
    }
    (widest, deepest)
}

/// 8.6.5.3: contacts first, and lying fibers sag; joints first, and joints open.
#[test]
fn the_order_decides_what_is_violated() {
    let run = |order, times, contact_time| {
        let mut settings = settings(order, times);
        settings.form.contact_time = contact_time;
        let (gap, depth) = over_a_bar(&settings);
        println!(
            "{contact_time:?}, {order:?} x {times}: joints {gap:.2e} m, sagging {depth:.2e} m"
        );
        (gap, depth)
    };
    for times in 1..=3 {
        run(LastWord::JointsFirst, times, Form::AsPrinted);
        run(LastWord::ContactsFirst, times, Form::AsPrinted);
        let joints_first = run(LastWord::JointsFirst, times, Form::Corrected);
        let contacts_first = run(LastWord::ContactsFirst, times, Form::Corrected);
        assert!(contacts_first.0 < 1e-14, "the last word is the joints'");
        assert!(joints_first.0 > 1e3 * contacts_first.0);
        assert!(contacts_first.1 > 3.0 * joints_first.1, "{joints_first:?} {contacts_first:?}");
    }
}

#[test]
fn chains_that_collide_keep_momentum_together_and_lose_it_alone() {
    let lost = |response: &mut dyn Response, tells: bool| {
        let upper = line(Point3::new(-0.05, 0.0, 0.0), Point3::new(0.05, 0.0, 0.0), 5, Root::Free);
        let lower = line(
            Point3::new(0.003, -0.05, -2.0 * RADIUS),
            Point3::new(0.003, 0.05, -2.0 * RADIUS),
            5,
            Root::Free,
        );
        let mut chains = [upper, lower];
        for segment in chains[0].segments_mut() {
            segment.velocity = Vector3::new(0.1, 0.2, -0.5);
        }
        let contact = |y: f64| SegmentContact {
            chain: 0,
            segment: 2,
            point: Point3::new(0.003, y, -RADIUS),
            normal: Vector3::z(),
            gap: 0.0,
            partner: SegmentPartner::Segment { chain: 1, segment: 2 },
            friction: friction(0.4),
        };
        let total = |chains: &[CylinderChain]| {
            let all = chains.iter().flat_map(CylinderChain::segments);
            let linear: Vector3<f64> = all.clone().map(|s| s.mass() * s.velocity).sum();
            let angular: Vector3<f64> =
                all.map(|s| s.angular_momentum_about(&Point3::origin())).sum();
            (linear, angular)
        };
        let before = total(&chains);
        let settings = Settings { gravity: Vector3::zeros(), ..settings(LastWord::JointsFirst, 1) };
        // Two points, of which one has a lever on the lower segment alone.
        let contacts = [contact(0.0), contact(0.004)];
        let report = step(&mut chains, &contacts, &settings, response).expect("solved");
        assert_eq!(report.contacts.map(|c| c.converged), tells.then_some(true));
        let after = total(&chains);
        let size = before.0.norm();
        ((after.0 - before.0).norm() / size).max((after.1 - before.1).norm() / (0.1 * size))
    };
    let projected = lost(&mut Differences::from(Form::Corrected), false);
    let (alone, law) = (lost(&mut alone(), false), lost(&mut together(), true));
    println!("momentum lost: together {projected:e}, each by itself {alone}, by the law {law:e}");
    assert!(projected < 1e-14 && law < 1e-14, "{projected:e} {law:e}");
    assert!(alone > 1e-3, "{alone}");
}

/// A chain that falls flat leaves with its share of the velocity with which it came, whoever
/// answers and whatever comes last; one that comes no faster than gravity makes it in two steps
/// stays.
#[test]
fn a_chain_rebounds_by_its_restitution() {
    let after = |speed: f64, order: LastWord, response: &mut dyn Response| {
        let at = |x: f64| Point3::new(x, 0.0, RADIUS);
        let mut chains = [line(at(0.0), at(0.1), 10, Root::Free)];
        for segment in chains[0].segments_mut() {
            segment.velocity.z = -speed;
        }
        let settings = Settings { restitution: 0.5, ..settings(order, 1) };
        let contacts = on_plane(&chains[0], &settings, 0.3);
        step(&mut chains, &contacts, &settings, response).expect("solved");
        chains[0].segments()[5].velocity.z
    };
    for order in [LastWord::JointsFirst, LastWord::ContactsFirst] {
        let (mut alone, mut together) = (alone(), together());
        for response in [&mut alone as &mut dyn Response, &mut together] {
            // The mean of the step rebounds; half of its fall is still to come.
            let fast = after(1.0, order, response) - 0.5;
            assert!((fast + 0.5 * 9.81e-3).abs() < 1e-9, "{order:?}: {fast}");
            let slow = after(1.9 * 9.81e-3, order, response);
            assert!((slow + 0.5 * 9.81e-3).abs() < 1e-9, "{order:?}: {slow}");
        }
    }
}

/// Joints that are open and close press segments on what they lie on. Reflected, that velocity
/// opens them again: a chain every other segment of which lies lower, as penetration is not
/// repaired, never rests.
#[test]
fn joints_that_close_do_not_rebound() {
    let jumps = |rebound: Form| {
        let at = |x: f64| Point3::new(x, 0.0, RADIUS);
        let mut chains = [line(at(0.0), at(0.1), 10, Root::Free)];
        let mut settings = Settings { restitution: 0.9, ..settings(LastWord::JointsFirst, 1) };
        settings.form.rebound = rebound;
        for (i, segment) in chains[0].segments_mut().iter_mut().enumerate() {
            let lift = if i % 2 == 0 { -1e-4 } else { 0.0 };
            segment.pose.translation.z += lift;
        }
        let (mut widest, mut fastest) = (0.0_f64, 0.0_f64);
        // It has come to rest, or never will.
        for i in 0..300 {
            let contacts = on_plane(&chains[0], &settings, 0.3);
            let report = step(&mut chains, &contacts, &settings, &mut together()).expect("solved");
            if i >= 100 {
                widest = widest.max(report.widest_gap);
                let speeds = chains[0].segments().iter().map(|segment| segment.velocity.norm());
                fastest = speeds.fold(fastest, f64::max);
            }
        }
        [widest, fastest]
    };
    let [printed, corrected] = [Form::AsPrinted, Form::Corrected].map(jumps);
    println!("gaps (m) and speeds (m/s) as printed {printed:?}, corrected {corrected:?}");
    // Velocities are those half a step of fall ahead of rest.
    let rest = 0.5 * 9.81e-3;
    assert!((corrected[1] - rest).abs() < 1e-9, "{corrected:?}");
    assert!(printed[1] > 2.0 * rest && printed[0] > corrected[0], "{printed:?}");
}

#[test]
fn bad_contacts_are_refused() {
    let mut chains = [line(Point3::origin(), Point3::new(0.1, 0.0, 0.0), 4, Root::Free)];
    let before = chains.clone();
    let settings = settings(LastWord::JointsFirst, 2);
    let good = on_plane(&chains[0], &settings, 0.3)[0].clone();
    for bad in [
        SegmentContact { chain: 1, ..good.clone() },
        SegmentContact { segment: 4, ..good.clone() },
        SegmentContact {
            partner: SegmentPartner::Segment { chain: 0, segment: 9 },
            ..good.clone()
        },
        SegmentContact { normal: Vector3::zeros(), ..good.clone() },
        SegmentContact { gap: f64::INFINITY, ..good.clone() },
    ] {
        let (mut alone, mut together) = (alone(), together());
        for response in [&mut alone as &mut dyn Response, &mut together] {
            let refused = step(&mut chains, &[good.clone(), bad.clone()], &settings, response);
            assert!(
                matches!(refused, Err(ContactError::Contact { contact: 1, .. })),
                "{refused:?}"
            );
            assert_eq!(chains, before);
        }
    }
}

#[test]
#[ignore = "slow: 3 s, prints the cost of a step of the thesis's reference size"]
fn cost_of_the_reference_size() {
    let chains = |coupling: Option<Coupling>| -> Vec<CylinderChain> {
        (0..355)
            .map(|i| {
                let y = 1e-4 * f64::from(i);
                let from = Point3::new(0.0, y, RADIUS);
                let root = Root::Hinged(from);
                let chain = line(from, Point3::new(0.3, y, RADIUS), 100, root);
                match coupling {
                    None => chain,
                    Some(coupling) => chain
                        .with_springs(JointSprings {
                            stiffness: Vector3::repeat(1e-9),
                            natural: vec![Vector3::zeros(); 100],
                            coupling,
                        })
                        .expect("valid"),
                }
            })
            .collect()
    };
    for (name, coupling, touching) in [
        ("no springs", None, false),
        ("explicit springs", Some(Coupling::Explicit), false),
        ("implicit springs", Some(Coupling::Implicit), false),
        ("no springs, 71,000 contacts with a plane", None, true),
    ] {
        let (mut chains, settings) = (chains(coupling), settings(LastWord::JointsFirst, 1));
        let mut spent = std::time::Duration::ZERO;
        let steps = 5;
        for _ in 0..steps {
            let contacts: Vec<SegmentContact> = chains
                .iter()
                .enumerate()
                .filter(|_| touching)
                .flat_map(|(chain, c)| {
                    let contacts = on_plane(c, &settings, 0.47).into_iter();
                    contacts.map(move |contact| SegmentContact { chain, ..contact })
                })
                .collect();
            let start = std::time::Instant::now();
            let report = step(&mut chains, &contacts, &settings, &mut alone()).expect("solved");
            spent += start.elapsed();
            assert!(touching || report.widest_gap < 1e-13);
        }
        println!(
            "355 x 100, {name}: {:.1} ms a step",
            spent.as_secs_f64() * 1e3 / f64::from(steps)
        );
    }
}
