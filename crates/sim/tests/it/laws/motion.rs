//! How touches bounce and slide, and what becomes of the energy.

use super::{G, GROUND, RADIUS, hair, run_of, weight};
use crate::common::Run;
use nalgebra::Vector3;

/// What is left of the height from which a hair falls flat on the ground, and the height after it
/// has come to rest, m.
fn bounce(object: &str, laws: &str) -> [f64; 2] {
    let height = 2e-3;
    let start = Vector3::new(0.0, 0.0, RADIUS + height);
    let mut run = run_of(&hair(&start, &Vector3::x()), object, laws, -G, 5e-5);
    let (mut energy, mut struck, mut highest) = (run.world.energy().total(), false, 0.0_f64);
    let scale = 1e-9 * energy;
    for _ in 0..2000 {
        run.step();
        let now = run.world.energy().total();
        assert!(now <= energy + scale, "energy is gained: {now} after {energy}");
        energy = now;
        let (velocity, above) =
            (run.world.state(0).velocities[2].z, run.positions(0)[2].z - RADIUS);
        struck |= velocity >= 0.0;
        if struck {
            highest = highest.max(above);
        }
    }
    [highest / height, run.positions(0)[2].z - RADIUS]
}

#[test]
fn a_hair_bounces_by_its_restitution() {
    let [share, end] = bounce(GROUND, "friction: Isotropic(0.3), restitution: 0.5");
    println!("rebound {share:.5} of the height for 0.25; at rest {end:.1e} m above the ground");
    assert!((share / 0.25 - 1.0).abs() < 0.02, "{share}");
    // 0.1 s hold the fall, 20.2 ms, and all bounces, 2 e / (1 - e) times as long.
    assert!(end.abs() < 0.02 * 2.0 * RADIUS, "{end}");

    let [share, _] = bounce(GROUND, "friction: Isotropic(0.3)");
    assert!(share < 0.02 * 2.0 * RADIUS / 2e-3, "{share}");

    let own = "(shape: Plane(normal: (0.0, 0.0, 1.0)), restitution: 0.8)";
    let [share, _] = bounce(own, "friction: Isotropic(0.3), restitution: 0.1");
    assert!((share / 0.64 - 1.0).abs() < 0.02, "{share}");
}

/// With all of its velocity a hair bounces for ever: its kinetic energy is the same before and
/// after each step that strikes. In that step it goes as far up with its new velocity as it would
/// have gone down with the old one, and so is too high by the way of a step at most; as it flies,
/// backward Euler takes as much.
#[test]
fn a_hair_that_loses_nothing_bounces_on() {
    let (height, dt) = (2e-3, 5e-5);
    let start = hair(&Vector3::new(0.0, 0.0, RADIUS + height), &Vector3::x());
    let laws = "friction: Isotropic(0.3), restitution: 1.0, residual: 1e-6";
    let mut run = run_of(&start, GROUND, laws, -G, dt);
    let way = (2.0 * G * height).sqrt() * dt;
    let falling = |run: &Run| run.world.state(0).velocities[2].z < 0.0;
    let (first, floor) = (run.world.energy().total(), weight() * RADIUS);
    let mut bounces = 0;
    for _ in 0..12_000 {
        let (fell, before) = (falling(&run), run.world.energy());
        run.step();
        let now = run.world.energy();
        if fell && !falling(&run) {
            bounces += 1;
            // Answers of rods are of single precision.
            let gained = now.kinetic / before.kinetic - 1.0;
            assert!(gained.abs() < 1e-6, "bounce {bounces}: {gained:e}");
        } else {
            assert!(now.total() <= before.total() + 1e-9 * first, "{now:?} after {before:?}");
        }
        let share = (now.total() - floor) / (first - floor);
        assert!(
            (share - 1.0).abs() < way / height,
            "{share} of its energy after {bounces} bounces"
        );
    }
    // One in 40 ms.
    assert_eq!(bounces, 15);
}

/// A hair that flies along itself at the ground, 45 degrees down, and bounces with all of its
/// normal velocity. What it bears is twice its momentum along the normal, which brakes it by the
/// coefficient times that, until it sticks: friction takes energy, and nothing comes back.
#[test]
fn an_oblique_bounce_is_braked() {
    for (mu, kept) in [(0.3, 1.0 - 2.0 * 0.3), (0.8, 0.0)] {
        let speed = 0.3;
        let start = Vector3::new(0.0, 0.0, RADIUS + 1e-4);
        let flying = hair(&start, &Vector3::x()).replace(
            "root_joint: Free",
            &format!("root_joint: Free, velocity: ({speed:?}, 0.0, -{speed:?})"),
        );
        let laws = format!("friction: Isotropic({mu:?}), restitution: 1.0");
        let mut run = run_of(&flying, GROUND, &laws, 0.0, 1e-4);
        let mut energy = run.world.energy().total();
        let scale = 1e-12 * energy;
        for _ in 0..20 {
            run.step();
            let now = run.world.energy().total();
            assert!(now <= energy + scale, "{mu}: {now} after {energy}");
            energy = now;
        }
        // Sticking is to within 40 um/s, and the solver's residual is a thousandth of the impulses.
        for velocity in &run.world.state(0).velocities {
            let expected: Vector3<f64> = speed * Vector3::new(kept, 0.0, 1.0);
            let error = (velocity - expected).norm();
            assert!(error < 4e-5 + 1e-3 * 2.0 * speed, "{mu}: {velocity}");
        }
    }
}

/// How far a hair that starts at rest slides along itself in `steps` steps of 1 ms on a slope.
fn slid(slope: f64, friction: &str, steps: usize) -> f64 {
    let (sin, cos) = slope.atan().sin_cos();
    let (up, down) = (Vector3::new(sin, 0.0, cos), Vector3::new(cos, 0.0, -sin));
    let plane = format!("(shape: Plane(normal: ({sin:?}, 0.0, {cos:?})))");
    let lying = hair(&(up * (RADIUS + 1e-7)), &down);
    let mut run = run_of(&lying, &plane, &format!("friction: {friction}"), -G, 1e-3);
    let start = run.positions(0)[2];
    for _ in 0..steps {
        run.step();
    }
    (run.positions(0)[2] - start).dot(&down)
}

/// A hair at rest stays on a slope that it could not stop on, and once it slides it slides with the
/// lesser coefficient.
#[test]
fn resting_friction_is_overcome_once() {
    let friction = "Resting(resting: 0.4, sliding: 0.3)";
    let steps = 100;
    let still = 4e-5 * 1e-3 * steps as f64;
    assert!(slid(0.35, friction, steps).abs() < still);
    // The step that tears it off still has the greater coefficient; backward Euler.
    let acceleration = |mu: f64| G * (0.45_f64.atan().sin() - mu * 0.45_f64.atan().cos());
    let n = steps as f64;
    let way = 1e-6 * (acceleration(0.4) * n + acceleration(0.3) * 0.5 * n * (n - 1.0));
    let found = slid(0.45, friction, steps);
    println!("slid {:.4} mm for {:.4} mm", 1e3 * found, 1e3 * way);
    assert!((found - way).abs() < still, "{found} for {way}");
    assert!((slid(0.45, "Isotropic(0.4)", steps) - way).abs() > 10.0 * still);
}

/// A short hair moves as one body on slope and belt, and upright as it bounces on its root. In
/// every step its energy changes by the work of the contacts, less what backward Euler takes: that
/// of the change of its velocities, spins included, and of its curvatures.
#[test]
fn contacts_account_for_the_energy() {
    let (sin, cos) = 0.45_f64.atan().sin_cos();
    let slope = format!("(shape: Plane(normal: ({sin:?}, 0.0, {cos:?})))");
    let belt = "(shape: Plane(normal: (0.0, 0.0, 1.0)), \
                motion: Translate(velocity: (0.1, 0.0, 0.0), until: 1.0))";
    let laws = "friction: Resting(resting: 0.4, sliding: 0.3)";
    let flat = Vector3::z() * (RADIUS + 1e-7);
    for (name, object, laws, start, way) in [
        (
            "slope",
            &*slope,
            laws,
            Vector3::new(sin, 0.0, cos) * (RADIUS + 1e-7),
            Vector3::new(cos, 0.0, -sin),
        ),
        ("belt", belt, laws, flat, Vector3::x()),
        (
            "ground",
            GROUND,
            "friction: Isotropic(0.3), restitution: 0.5",
            flat + Vector3::z() * 1e-3,
            Vector3::z(),
        ),
    ] {
        let mut run = run_of(&hair(&start, &way), object, laws, -G, 1e-3);
        let masses = {
            let fiber = &run.world.assembly().fibers()[0];
            [0.5, 1.0, 1.0, 1.0, 0.5].map(|share| share * fiber.mass() / 4.0)
        };
        let (inertia, stiffness) = {
            let fiber = &run.world.assembly().fibers()[0];
            let (node, length) = (&fiber.nodes()[0], fiber.segment_lengths()[0]);
            (length * node.rotary_inertia.x, length * node.stiffness)
        };
        let spins = |run: &Run| {
            let state = run.world.state(0);
            let turned = state.frames.into_iter().zip(state.angular_velocities);
            turned.map(|(frame, spin)| frame * spin).collect::<Vec<_>>()
        };
        let mass: f64 = masses.iter().sum();
        let mut worst = 0.0_f64;
        for _ in 0..60 {
            let (energy, work) = (run.world.energy(), run.world.contact_work());
            let (before, spun) = (run.world.state(0).velocities, spins(&run));
            let bent = run.world.state(0).curvatures;
            run.step();
            let (later, done) = (run.world.energy(), run.world.contact_work());
            let after = run.world.state(0).velocities;
            let moved: f64 =
                (0..5).map(|a| 0.5 * masses[a] * (after[a] - before[a]).norm_squared()).sum();
            let turned = spins(&run).into_iter().zip(spun);
            let turned: f64 =
                turned.map(|(now, then)| 0.5 * inertia * (now - then).norm_squared()).sum();
            let curvatures = run.world.state(0).curvatures.into_iter().zip(bent);
            let bent: f64 = curvatures
                .map(|(now, then)| 0.5 * (now - then).component_mul(&stiffness).dot(&(now - then)))
                .sum();
            let lost = moved + turned + bent;
            let terms = [
                later.kinetic - energy.kinetic,
                later.elastic - energy.elastic,
                later.gravitational - energy.gravitational,
                work.total() - done.total(),
                lost,
            ];
            // Places are rounded to 1e-14 of the way of a step, and so are mean velocities; where
            // nothing moves nothing but roundings is left.
            let scale = terms.iter().map(|x| x.abs()).sum::<f64>()
                + 1e-7 * (later.kinetic + mass * G * RADIUS);
            worst = worst.max(terms.iter().sum::<f64>().abs() / scale);
        }
        println!(
            "{name}: closes to {worst:.1e} of the work of a step; {:?}",
            run.world.contact_work()
        );
        assert!(worst < 1e-6, "{name}: {worst:e}");
        let work = run.world.contact_work();
        assert!(work.friction < 0.0 || name == "ground", "{name}: {work:?}");
        assert!((work.restitution > 0.0) == (name == "ground"), "{name}: {work:?}");
        assert!(work.closing <= 0.0 && work.adhesion == 0.0, "{name}: {work:?}");
        let [x, z] = [run.world.state(0).velocities[2].x, run.world.contact_work().kinematic];
        if name == "belt" {
            assert!((x - 0.1).abs() < 4e-5, "{x}: it goes with the belt");
            assert!(
                (z / (0.1 * mass * 0.1) - 1.0).abs() < 1e-3,
                "{z}: momentum times belt velocity"
            );
        }
    }
}
