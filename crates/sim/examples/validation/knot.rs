//! The overhand knot's friction.
//!
//! In a loose knot two strands wind about each other where they touch. They are weakly bent, and
//! the vector between them is, in units of the diameter `2 h` and along the length in `sqrt(2 h R)`
//! with the radius `R` of the loop, a plane curve `v` that stays out of the unit circle and makes
//! `|v''|^2` least. Far to one side one strand is straight and the other one the loop, far to the
//! other side it is the other way round: `v''` is a unit vector there and its opposite here, and
//! `v` winds by three half turns between. All contact forces together are `P = s B / sqrt(h R^3)`,
//! with `s` the integral of `|v''''|` over `2^(3/2)`. Of a knot that is drawn tight by `d` the pull
//! works against the loop, `B d / 2 R^2`, and against friction, `mu P d`: so `s` is what the
//! friction of a knot goes with, 0.492 (Audoly, Clauvelin and Neukirch 2007).

use nalgebra::{DMatrix, DVector, Matrix2, Point3, Vector2, Vector3};
use rapunzel_repro::plot::{Chart, Curve, Drawing};
use rapunzel_repro::{Criterion, Fallible, Figure, check};
use rapunzel_sim::{Scene, World};
use std::f64::consts::PI;

/// Half of the winding, which is symmetric, in scaled length, and its parts.
const HALF: f64 = 4.0;
const PARTS: usize = 160;
/// Stiffnesses of the wall about the circle, one after the other.
const WALLS: [f64; 7] = [30.0, 120.0, 480.0, 1920.0, 7680.0, 30_720.0, 122_880.0];
/// Most steps of Newton's method for each; the first ones leave the wall convex.
const MOST: usize = 200;
const CONVEX: usize = 25;
/// Longest step, and the one at which it ends.
const LONGEST: f64 = 0.2;
const SMALL: f64 = 1e-9;

/// `s`, of the curve between the strands.
fn winding() -> Fallible<f64> {
    let h = HALF / PARTS as f64;
    // Of the part from the middle, where `v` is `-x`, to the side where `v''` is `-y`.
    let mut v = DVector::zeros(2 * (PARTS + 1));
    for i in 0..=PARTS {
        let s = i as f64 * h;
        let angle = PI - 1.5 * PI * (s / 3.0).min(1.0);
        let r = 1.0 + 0.5 * (s - 3.0).max(0.0).powi(2);
        let at = Vector2::new(angle.cos(), angle.sin()) * r;
        v.fixed_rows_mut::<2>(2 * i).copy_from(&at);
    }
    let mut pressed = 0.0;
    for wall in WALLS {
        pressed = settle(&mut v, h, wall)?;
    }
    Ok(pressed / 8.0_f64.sqrt())
}

/// Newton's method for the least energy with a wall of a stiffness; the force of the wall.
fn settle(v: &mut DVector<f64>, h: f64, wall: f64) -> Fallible<f64> {
    let count = v.len();
    for step in 0..MOST {
        let mut force = DVector::<f64>::zeros(count);
        let mut matrix = DMatrix::<f64>::identity(count, count) * 1e-9;
        // Second differences; in the middle that along `x` alone, and of half a part.
        let mut bend = |row: &[(usize, f64)], weight: f64| {
            let bent: f64 = row.iter().map(|(i, c)| c * v[*i]).sum();
            for (i, c) in row {
                force[*i] -= weight * bent * c;
                for (j, d) in row {
                    matrix[(*i, *j)] += weight * c * d;
                }
            }
        };
        let square = 1.0 / (h * h);
        bend(&[(0, -2.0 * square), (2, 2.0 * square)], 0.5 * h);
        for i in 2..count - 2 {
            bend(&[(i - 2, square), (i, -2.0 * square), (i + 2, square)], h);
        }
        // The couple on the far end.
        force[count - 1] -= 1.0 / h;
        force[count - 3] += 1.0 / h;
        let mut pressed = 0.0;
        for i in (0..count).step_by(2) {
            let at = Vector2::new(v[i], v[i + 1]);
            let (r, weight) = (at.norm(), if i == 0 { 0.5 * h } else { h });
            if r >= 1.0 {
                continue;
            }
            let (out, push) = (at / r, weight * wall * (1.0 - r));
            pressed += 2.0 * push;
            let along = out * out.transpose();
            let across = Matrix2::identity() - along;
            let convex = if step < CONVEX { 0.0 } else { push / r };
            let mut own = matrix.fixed_view_mut::<2, 2>(i, i);
            own += along * (weight * wall) - across * convex;
            let mut own = force.fixed_rows_mut::<2>(i);
            own += out * push;
        }
        // The middle stays on the axis.
        matrix.row_mut(1).fill(0.0);
        matrix.column_mut(1).fill(0.0);
        (matrix[(1, 1)], force[1]) = (1.0, -v[1]);
        let moved = matrix.lu().solve(&force).ok_or("the winding has no stiffness")?;
        let size = moved.amax();
        *v += moved * (LONGEST / size).min(1.0);
        if size < SMALL {
            return Ok(pressed);
        }
    }
    Err("the winding does not come to rest".into())
}

/// Of a knot at rest with a loop of some 15 mm, without friction, whose pull tells the radius of
/// the loop, `T = B / 2 R^2`: `sqrt(h / R)`, and the contact forces in `B / sqrt(h R^3)`. It
/// settles in oil.
fn rests(thickness: f64) -> Fallible<[f64; 2]> {
    let scene = Scene::from_ron(&format!(
        "(format: 1, duration: 1.0, fibers: [(
            length: 0.2, segments: 800, section: Circle(radius: {thickness:?}),
            initial: Overhand(radius: 0.01, spacing: {:?}),
            root: (orientation: Along(direction: (0, 0, 1))), root_joint: Ball(),
            tip: Driven(velocity: (0, 0, 0), until: 1.0, joint: Ball()),
        )],
        contact: (friction: Isotropic(0.0), depth: 1e-3, residual: 1e-6),
        environment: (gravity: (0.0, 0.0, 0.0), viscosity: 1e-2), stepper: (dt: 5e-3))",
        3.0 * thickness
    ))?;
    let mut world = World::build(&scene)?;
    for _ in 0..120 {
        world.step(5e-3)?;
    }
    let stiffness = 3.8e9 * PI / 4.0 * thickness.powi(4);
    let radius = (0.5 * stiffness / world.state(0).forces[2].norm()).sqrt();
    let pressed: f64 = world.contacts().map(|contact| contact.force.norm()).sum();
    Ok([(thickness / radius).sqrt(), pressed * (thickness * radius.powi(3)).sqrt() / stiffness])
}

/// Coefficients of friction of knots that are drawn.
const FRICTIONS: [f64; 2] = [0.02, 0.05];
/// Bending stiffness of their rods, N m^2, and number of segments.
const STIFFNESS: f64 = 1e-6;
const SEGMENTS: usize = 800;
/// Steps of 1 ms in which one is drawn by 4 mm, and the last ones, in which it draws evenly.
const DRAWN: usize = 400;
const EVEN: usize = 100;

/// Of a knot with a coefficient of friction whose tip is drawn: means of `sqrt(h / R)` with the
/// radius of the top of the loop, of the pull in `B / R^2`, and of the contact forces together in
/// `B / sqrt(h R^3)`. In oil that the drawing hardly feels, the loop does not swing.
fn draws(thickness: f64, friction: f64) -> Fallible<[f64; 3]> {
    let scene = Scene::from_ron(&format!(
        "(format: 1, duration: 1.0, fibers: [(
            length: 0.2, segments: {SEGMENTS}, section: Circle(radius: {thickness:?}),
            material: Measured(bending: ({STIFFNESS:?}, {STIFFNESS:?}), torsion: 8e-7,
                linear_density: 1e-3),
            initial: Overhand(radius: 0.015, spacing: {:?}),
            root: (orientation: Along(direction: (0, 0, 1))), root_joint: Ball(),
            tip: Driven(velocity: (0, 0, 0.01), until: 1.0, joint: Ball()),
        )],
        contact: (friction: Isotropic({friction:?}), depth: 1e-3),
        environment: (gravity: (0.0, 0.0, 0.0), viscosity: 1e-2), stepper: (dt: 1e-3))",
        3.0 * thickness
    ))?;
    let mut world = World::build(&scene)?;
    let mut sums = Vector3::zeros();
    for step in 0..DRAWN {
        world.step(1e-3)?;
        if step < DRAWN - EVEN {
            continue;
        }
        let state = world.state(0);
        let radius = circle(&[0, 20, 40].map(|k| state.positions[SEGMENTS / 2 - 20 + k]));
        let ends = [2, SEGMENTS - 3].map(|e| state.forces[e].norm());
        let pressed: f64 = world.contacts().map(|contact| contact.force.norm()).sum();
        sums += Vector3::new(
            (thickness / radius).sqrt(),
            0.5 * (ends[0] + ends[1]) * radius * radius / STIFFNESS,
            pressed * (thickness * radius.powi(3)).sqrt() / STIFFNESS,
        );
    }
    Ok((sums / EVEN as f64).into())
}

/// Radius of the circle through three points, m.
fn circle([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let (p, q) = (b - a, c - a);
    p.norm() * q.norm() * (q - p).norm() / (2.0 * p.cross(&q).norm())
}

/// A knot that is drawn tight against friction: what friction adds to the pull.
pub(crate) fn drawn() -> Fallible<Figure> {
    let right = winding()?;
    let (mut checks, mut points) = (Vec::new(), Vec::new());
    for thickness in [3.6e-5, 1.44e-4] {
        let [mu, nu] = FRICTIONS;
        let [ratio, less, loose] = draws(thickness, mu)?;
        let [_, more, tight] = draws(thickness, nu)?;
        let name = format!("pull of friction over its contact forces, sqrt(h / R) = {ratio:.3}");
        let work = (more - less) * ratio / (nu * tight - mu * loose);
        // Segments that come to the winding and leave it let the pull vary while it is watched: by
        // 0.7 per cent of itself where `sqrt(h / R)` is 0.078, seen for the smaller coefficient.
        // Of the difference of two pulls that is some 3 per cent at an instant; four segments come.
        checks.push(check(name, work, "", Criterion::Within(0.95, 1.05), "mu P d, the work of it"));
        points.push([ratio, (more - less) * ratio / (nu - mu)]);
    }
    let [[a, thin], [b, thick]] = [points[0], points[1]];
    let slope = (thick - thin) / (b - a);
    let limit = thin - a * slope;
    // Theory is that of thin rods. The line leaves of the next order the product of both roots,
    // times what the square of the first order lets expect, and the segments some per cent.
    let room = (0.03 + (slope / limit).powi(2) * a * b) * right;
    let criterion = Criterion::Within(right - room, right + room);
    let name = "pull of friction, in the limit of a thin rod";
    checks.push(check(name, limit, "", criterion, "contact forces along the winding"));
    let line = [0.0, 0.1].map(|x| [x, limit + x * slope]);
    let chart = Chart {
        title: "What friction adds to the pull on an overhand knot".into(),
        x: "sqrt(h / R)",
        y: "pull of a coefficient of one, in B / sqrt(h R^3)",
        log_from: None,
        curves: vec![
            Curve { name: "800 segments".into(), points },
            Curve { name: "line through both".into(), points: line.into() },
            Curve { name: "theory".into(), points: vec![[0.0, right], [0.1, right]] },
        ],
    };
    Ok(Figure {
        scene: "an overhand knot that is drawn by one end, with two coefficients of friction",
        parameters: "radii of 36 and 144 um, loops of some 20 mm, coefficients of 0.02 and 0.05; \
                     drawn at 10 mm/s",
        checks,
        drawings: vec![Drawing::Chart(chart)],
    })
}

/// The friction of the overhand knot.
pub(crate) fn overhand() -> Fallible<Figure> {
    let right = winding()?;
    let found = [3.6e-5, 7.2e-5, 1.44e-4].map(rests);
    let found = found.into_iter().collect::<Fallible<Vec<_>>>()?;
    let [[a, thin], [b, thick]] = [found[0], found[2]];
    let limit = thin - a * (thick - thin) / (b - a);
    // The winding is a dozen segments long, by whose chords either number is off by a per cent; the
    // line through both leaves two to three times that, and of the next order the product of both
    // roots, half a per cent, times a constant of some units.
    let room = 0.05 * right;
    // Published to three digits; the parts leave one in the last of them.
    let published = Criterion::Within(0.491, 0.494);
    let criterion = Criterion::Within(right - room, right + room);
    let name = "contact forces along the winding, by its equations";
    let checks = vec![
        check(name, right, "", published, "0.492, published"),
        check("contact forces in a knot, in the limit of a thin rod", limit, "", criterion, name),
    ];
    let line = [0.0, 0.1].map(|x| [x, limit + x * (thick - thin) / (b - a)]);
    let chart = Chart {
        title: "Contact forces in an overhand knot".into(),
        x: "sqrt(h / R)",
        y: "sum of contact forces, in B / sqrt(h R^3)",
        log_from: None,
        curves: vec![
            Curve { name: "800 segments".into(), points: found },
            Curve { name: "line through the outer two".into(), points: line.into() },
            Curve { name: "theory".into(), points: vec![[0.0, right], [0.1, right]] },
        ],
    };
    Ok(Figure {
        scene: "a loose overhand knot at rest without friction: its contact forces together are \
                what its friction goes with",
        parameters: "radii of 36, 72 and 144 um, loops of some 15 mm",
        checks,
        drawings: vec![Drawing::Chart(chart)],
    })
}
