//! Stick and slip on a belt.

use crate::common::Run;
use std::f64::consts::PI;

/// A hair that is pinned at its root lies on a belt that turns about that pin, and a force at its
/// tip draws it back: an oscillator of one degree of freedom, for angles as small as these. With
/// the coefficient at rest it is carried along until the force wins, with that of sliding it swings
/// back, by the period `2 D / V + (2 / w) (pi - atan(w D / V))`.
///
/// The moment of friction about the pin is known whatever the pressure along the hair: that of the
/// weight, which no other moment bears. The hair is stiff, so that it slips everywhere at once, and
/// an arc that lies flat, which cannot roll as a straight one would: 0.3 mm high, ten radii. And
/// `slip` is small against the belt's velocity, as what slips less counts as sticking.
#[test]
fn a_belt_makes_a_hair_stick_and_slip() {
    const RADIUS: f64 = 3.5e-5;
    let (length, segments, g) = (0.01, 4_u32, 9.81);
    let (rest, slide) = (0.4, 0.3);
    // The same in units of the angular frequency as 1 g on 1 N/m and a belt of 1 cm/s.
    let frequency = 200.0;
    let mass = 1300.0 * PI * RADIUS * RADIUS * length;
    // Distances from the pin, and masses.
    let bend = 24.0;
    let lumps: Vec<[f64; 2]> = (0..=segments)
        .map(|a| {
            let share = if a == 0 || a == segments { 0.5 } else { 1.0 };
            let arc = length * f64::from(a) / f64::from(segments);
            [(0.5 * bend * arc).sin() * 2.0 / bend, share * mass / f64::from(segments)]
        })
        .collect();
    let sum = |power: i32| lumps.iter().map(|[x, m]| m * x.powi(power)).sum::<f64>();
    // Directors of the segments turn too, but a thin section adds nothing.
    let far = lumps[segments as usize][0];
    let force = frequency * frequency * sum(2) / far;
    let pressure = g * sum(1) / far;
    let swing = (rest - slide) * pressure / force;
    let pace = frequency * swing / 3.1;
    let period = 2.0 * swing / pace + 2.0 / frequency * (PI - (frequency * swing / pace).atan());
    let dt = 1e-3 / frequency;
    let scene = |aside: f64| {
        format!(
            "(format: 1, duration: 10.0, fibers: [(
            length: {length:?}, segments: {segments}, section: Circle(radius: {RADIUS:?}),
            shape: Curved(curvature: (-{bend:?}, 0, 0)),
            material: Elastic(density: 1300.0, youngs_modulus: 3.8e13, shear_modulus: 1.3e13),
            root: (position: (0, 0, {RADIUS:?}), orientation: Along(direction: ({:?}, {:?}, 0))),
            root_joint: Ball(), tip: Loaded(force: (value: ({force:?}, 0.0, 0.0))),
        )],
        objects: [(shape: Plane(normal: (0, 0, 1)),
            motion: Rotate(axis: (0, 0, 1), rate: {:?}, until: 10.0))],
        contact: (friction: Resting(resting: {rest:?}, sliding: {slide:?}),
            slip: {:?}, residual: 1e-5, depth: 5e-3),
        environment: (gravity: (0.0, 0.0, -{g:?})), stepper: (dt: {dt:?}))",
            aside.cos(),
            -aside.sin(),
            pace.to_degrees(),
            1e-4 * pace * length
        )
    };
    let tip_angle = |run: &Run| {
        let tip = run.positions(0)[segments as usize];
        tip.y.atan2(tip.x)
    };
    // Its tip is where the force leads straight away from the pin.
    let mut run = Run::read(&scene(tip_angle(&Run::read(&scene(0.0)))));
    #[expect(clippy::cast_possible_truncation, reason = "some thousand")]
    let steps = (2.7 * period / dt) as usize;
    // When it is carried through the middle of what it swings about.
    let middle = slide * pressure / force;
    let (mut before, mut times) = (0.0, Vec::new());
    for step in 0..steps {
        run.step();
        let angle = tip_angle(&run);
        if before < middle && angle >= middle {
            times.push(dt * (step as f64 + (middle - before) / (angle - before)));
        }
        before = angle;
    }
    let found = times[1] - times[0];
    println!("{:.4} ms for {:.4} ms", 1e3 * found, 1e3 * period);
    assert!((found / period - 1.0).abs() < 5e-3, "{found} for {period}");
}
