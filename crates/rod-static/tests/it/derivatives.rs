//! The derivatives of the energy of a chain.

use crate::common::Random;
use nalgebra::{Complex, Isometry3, Matrix3, Point3, Vector3};
use rapunzel_fiber::so3;
use rapunzel_rod_static::{Chain, Piece, Properties, Shape, Target};

type C = Complex<f64>;

/// A curved and twisted rod of varying section in twelve segments, bent at random.
fn bent(random: &mut Random, size: f64) -> (Chain, Shape) {
    let clamp = Isometry3::new(random.direction(), random.direction());
    let load = random.direction() * 4.0;
    let piece = Piece::varying(1.3, move |s| Properties {
        stiffness: Vector3::new(1.0 + s, 0.6, 0.8 - 0.2 * s),
        natural_curvature: Vector3::new(2.0, -s, 1.0 + 3.0 * s),
        load,
    });
    let piece = piece.with_end_load(random.direction());
    let mut chain = Chain::new(&clamp, &[piece], 12).expect("a chain");
    let natural = chain.natural_shape();
    let steps: Vec<_> = (0..12).map(|_| random.direction() * (size * random.unit())).collect();
    let shape = chain.turned(&natural, &steps).expect("a shape");
    chain.set_targets(&[Target::pulled(7, Point3::new(0.3, 0.1, -0.2), 5.0)]).expect("a target");
    (chain, shape)
}

fn hat(u: &Vector3<C>) -> Matrix3<C> {
    let o = C::new(0.0, 0.0);
    Matrix3::new(o, -u.z, u.y, u.z, o, -u.x, -u.y, u.x, o)
}

/// The energy by complex numbers, from the rotation vectors of the segments: sums of powers, and
/// nothing of the crate's.
fn energy(chain: &Chain, turns: &[Vector3<C>]) -> C {
    let real = |v: &Vector3<f64>| v.map(|x| C::new(x, 0.0));
    let (at, clamp) = (chain.arc_lengths(), chain.clamp());
    let mut frame = clamp.rotation.to_rotation_matrix().matrix().map(|x| C::new(x, 0.0));
    let mut position = real(&clamp.translation.vector);
    let mut energy = -real(&chain.forces()[0]).dot(&position);
    for (i, turn) in turns.iter().enumerate() {
        let l = at[i + 1] - at[i];
        let s = 0.5 * (at[i + 1] + at[i]);
        let stiffness = Vector3::new(1.0 + s, 0.6, 0.8 - 0.2 * s);
        let natural = Vector3::new(2.0, -s, 1.0 + 3.0 * s);
        let strain = turn.map(|x| x / l) - real(&natural);
        energy += 0.5 * l * strain.dot(&real(&stiffness).component_mul(&strain));
        let (mut power, mut exp, mut mean) =
            (Matrix3::<C>::identity(), Matrix3::<C>::zeros(), Matrix3::<C>::zeros());
        for k in 1..40 {
            exp += power;
            mean += power.map(|x| x / f64::from(k));
            power *= hat(turn).map(|x| x / f64::from(k));
        }
        position += (frame * mean).column(2).map(|x| x * l);
        frame *= exp;
        energy -= real(&chain.forces()[i + 1]).dot(&position);
        for target in chain.targets() {
            if target.node == i + 1 {
                let gap = position - real(&target.place.coords);
                energy += 0.5 * target.stiffness * gap.dot(&gap);
            }
        }
    }
    energy
}

#[test]
fn the_gradient_is_that_of_a_complex_step() {
    let mut random = Random::new(7);
    for size in [0.0, 1e-3, 0.3, 1.2] {
        let (chain, shape) = bent(&mut random, size);
        let at = chain.arc_lengths();
        let turns: Vec<Vector3<f64>> = chain
            .curvatures(&shape)
            .iter()
            .zip(at.windows(2))
            .map(|(curvature, at)| curvature * (at[1] - at[0]))
            .collect();
        let complex: Vec<Vector3<C>> =
            turns.iter().map(|turn| turn.map(|x| C::new(x, 0.0))).collect();
        let own = chain.energy(&shape).expect("an energy");
        assert!((energy(&chain, &complex).re - own).abs() < 1e-13 * (1.0 + own.abs()));
        let gradient = chain.gradient(&shape).expect("a gradient");
        let largest = gradient.iter().map(Vector3::norm).fold(1.0, f64::max);
        for (j, turn) in turns.iter().enumerate() {
            for axis in 0..3 {
                let mut varied = complex.clone();
                varied[j][axis].im = 1e-30;
                let exact = energy(&chain, &varied).im / 1e-30;
                // The change of this segment turns all nodes beyond.
                let rate = shape.frames()[j + 1] * so3::right_jacobian(turn).column(axis);
                let found: f64 = gradient[j..]
                    .iter()
                    .zip(&shape.frames()[j + 1..])
                    .map(|(moment, frame)| (frame * moment).dot(&rate))
                    .sum();
                let error = (found - exact).abs() / largest;
                assert!(error < 1e-12, "size {size}, segment {j}, axis {axis}: {error:e}");
            }
        }
    }
}

/// Along a geodesic the slope of the energy is the gradient times the direction.
#[test]
fn the_hessian_is_the_change_of_the_gradient() {
    let mut random = Random::new(8);
    for size in [0.0, 1e-3, 0.3, 1.2] {
        let (chain, shape) = bent(&mut random, size);
        let by: Vec<_> = (0..12).map(|_| random.direction()).collect();
        let slope = |h: f64| -> f64 {
            let steps: Vec<_> = by.iter().map(|b| b * h).collect();
            let moved = chain.turned(&shape, &steps).expect("a shape");
            let gradient = chain.gradient(&moved).expect("a gradient");
            gradient.iter().zip(&by).map(|(g, b)| g.dot(b)).sum()
        };
        let numeric = |h: f64| (slope(h) - slope(-h)) / (2.0 * h);
        let exact = chain.hessian_product(&shape, &by).expect("a product");
        let exact: f64 = exact.iter().zip(&by).map(|(x, b)| x.dot(b)).sum();
        // Extrapolated differences: the error is of order h^4.
        let numeric = (4.0 * numeric(1e-3) - numeric(2e-3)) / 3.0;
        assert!((exact / numeric - 1.0).abs() < 1e-8, "size {size}: {exact} {numeric}");
    }
}
