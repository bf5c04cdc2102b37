//! Objects far heavier than those that they rest on, or that rest on them.

use crate::common::Run;

/// Of the contacts, as it is where a scene says nothing.
const RESIDUAL: f64 = 1e-4;
/// Gravity where a scene says nothing, m/s^2.
const G: f64 = 9.81;

/// Cubes on each other, turned and aside, each ten or ten thousand times as heavy as the next or as
/// light: the floor bears the weight of all in every step.
#[test]
fn heavy_rests_on_light_and_light_on_heavy() {
    let stacks: [(&[f64], usize); 6] = [
        (&[0.01, 0.1, 1.0, 10.0, 100.0], 30),
        (&[100.0, 10.0, 1.0, 0.1, 0.01], 60),
        (&[0.01, 100.0], 100),
        (&[100.0, 0.01], 100),
        (&[100.0, 0.01, 100.0], 60),
        (&[1.0, 100.0, 0.01, 100.0, 0.01], 60),
    ];
    for (solver, stacks) in [("Splitting", &stacks[..]), ("Polished", &stacks[2..4])] {
        for &(masses, steps) in stacks {
            let (worst, bound) = (unborne(masses, steps, solver), borne_to(masses));
            println!("{masses:?}, {solver}: {worst:.1e} of {bound:.1e}");
            assert!(worst < bound, "{masses:?}, {solver}: {worst:e} of {bound:e}");
        }
    }
}

/// The largest part of the weight of a stack of cubes that the floor does not bear, or bears too
/// much, in any step but the first ones.
fn unborne(masses: &[f64], steps: usize, solver: &str) -> f64 {
    const SIDE: f64 = 0.1;
    const FIRST: usize = 10;
    let one = |(i, mass): (usize, &f64)| {
        let z = SIDE * (i as f64 + 0.5);
        let (aside, turn) = (0.007 * (i % 2) as f64, 11 * i);
        format!(
            "(shape: Cuboid(sides: ({SIDE:?}, {SIDE:?}, {SIDE:?})), position: ({aside:?}, 0.003, {z:?}), \
             turn: (0, 0, {turn}), moves: Free(mass: Mass({mass:?})))"
        )
    };
    let mut objects: Vec<_> = masses.iter().enumerate().map(one).collect();
    objects.push("(shape: Plane(normal: (0, 0, 1)))".into());
    // A hair hangs aside.
    let mut run = Run::read(&format!(
        "(format: 1, duration: 1.0,
        fibers: [(length: 0.2, segments: 2, section: Circle(radius: 3.5e-5),
            root: (position: (5, 5, 5), orientation: Along(direction: (0, 0, -1))))],
        objects: [{}],
        contact: (friction: Isotropic(0.4), residual: {RESIDUAL:?}, solver: {solver}),
        stepper: (dt: 1e-3))",
        objects.join(", ")
    ));
    let weight = masses.iter().sum::<f64>() * G;
    run.steps(FIRST);
    let off = |_| {
        run.step();
        (run.world.force_on(masses.len()).z / -weight - 1.0).abs()
    };
    (FIRST..steps).map(off).fold(0.0, f64::max)
}

/// The residual bounds the norm of all errors of velocities, as if each were one of the heaviest,
/// relative to that of all forces, of which an interface has four that bear the weight at most:
/// half the root of the number of interfaces. Added up from the floor upward, the mean of each
/// interface being at most half its norm, the errors are the bodies'; twice those, as they close
/// the gaps that they left, and twice, as those of the step before.
fn borne_to(masses: &[f64]) -> f64 {
    let heaviest = masses.iter().copied().fold(0.0, f64::max);
    masses.len() as f64 * masses.iter().sum::<f64>() / heaviest * RESIDUAL
}
