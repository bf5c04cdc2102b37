//! What Coulomb's law gives for any point charges, and the multipole method to its tolerance.

use crate::common::{charges, cube, hair, normal, random, relative, sphere, unit};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;
use rapunzel_electrostatics::{
    Accuracy, COULOMB_CONSTANT, Direct, ElectrostaticsError, Method, Multipole,
};

/// Relative error of the inverse roots of the direct sum, as its unit tests allow.
const INVERSE_ROOT: f64 = 6e-13;

/// Points in a cube of 2 m, each with a charge of up to 1 pC of either sign.
fn small_cloud() -> impl Strategy<Value = Vec<([f64; 3], f64)>> {
    vec((proptest::array::uniform3(-1.0..1.0), -1e-12..1e-12), 1..60)
}

/// Positions (world, m) and charges (C).
fn split(cloud: &[([f64; 3], f64)]) -> (Vec<Point3<f64>>, Vec<f64>) {
    cloud.iter().map(|(x, q)| (Point3::from(*x), *q)).unzip()
}

/// A rotation and a shift of up to 3 m along each axis.
fn motion() -> impl Strategy<Value = Isometry3<f64>> {
    (proptest::array::uniform3(-3.0..3.0), proptest::array::uniform3(-3.0..3.0)).prop_map(
        |(shift, turn)| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
            Isometry3::from_parts(Translation3::from(Vector3::from(shift)), turn)
        },
    )
}

/// For each point the sum of the magnitudes of the fields (V/m) of all others, each times what `of`
/// makes of its distance (m).
fn magnitudes(points: &[Point3<f64>], charges: &[f64], of: impl Fn(f64) -> f64) -> Vec<f64> {
    let at = |x: &Point3<f64>| {
        let fields = points.iter().zip(charges).map(|(y, q)| ((x - y).norm(), q));
        let fields = fields.filter(|(r, _)| *r > 0.0);
        fields.map(|(r, q)| COULOMB_CONSTANT * q.abs() / (r * r) * of(r)).sum()
    };
    points.iter().map(at).collect()
}

/// Enough points for expansions: 4200 to 5000 of one of six kinds.
fn large_cloud() -> impl Strategy<Value = Vec<Point3<f64>>> {
    (0..6_usize, 4200..5000_usize, 0..1000_u64).prop_map(|(kind, count, seed)| {
        let mut r = random(seed);
        match kind {
            0 => cube(count, seed),
            1 => sphere(count, seed),
            2 => hair(count / 100, 100, seed).concat(),
            3 => (0..count).map(|_| Point3::from(unit(&mut r) * Vector3::z())).collect(),
            4 => {
                let grid = |k: usize| Point3::new((k % 7) as f64, (k % 5) as f64, 0.0);
                let spot = |k: usize| grid(k) + 0.1 * Vector3::from_fn(|_, _| normal(&mut r));
                (0..count).map(spot).collect()
            }
            _ => {
                (0..count).map(|_| Point3::from(Vector3::from_fn(|_, _| normal(&mut r)))).collect()
            }
        }
    })
}

/// A tolerance of each kind of arithmetic: coarse and fine coordinates in single precision, and
/// double precision.
fn tolerance() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1e-3), Just(1e-5), Just(1e-7), Just(1e-9)]
}

fn multipole(
    tolerance: f64,
    points: &[Point3<f64>],
    charges: &[f64],
) -> Result<Vec<Vector3<f64>>, ElectrostaticsError> {
    let method = Multipole { accuracy: Accuracy::Tolerance(tolerance) };
    Ok(method.fields(points, charges, points)?.fields)
}

/// Root of the sum of the squares of vectors.
fn norm(vectors: &[Vector3<f64>]) -> f64 {
    vectors.iter().map(Vector3::norm_squared).sum::<f64>().sqrt()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Newton's third law in the direct sum: forces have no sum and no moment.
    ///
    /// A distance is the same from both of its ends, with the error of its inverse root. What is
    /// left is the rounding of at most 60 additions and of some ten products of each force.
    #[test]
    fn direct_forces_have_no_sum_and_no_moment(cloud in small_cloud()) {
        let (points, charges) = split(&cloud);
        let fields = Direct.fields(&points, &charges, &points).expect("valid").fields;
        let sums = magnitudes(&points, &charges, |_| 1.0);
        let forces: Vec<_> = fields.iter().zip(&charges).map(|(e, q)| *q * e).collect();
        let size: f64 = sums.iter().zip(&charges).map(|(e, q)| e * q.abs()).sum();
        let rounding = (points.len() + 10) as f64 * f64::EPSILON * size;
        let sum: Vector3<f64> = forces.iter().sum();
        let moment: Vector3<f64> =
            forces.iter().zip(&points).map(|(f, x)| x.coords.cross(f)).sum();
        prop_assert!(sum.norm() <= rounding, "{} N, of {size} N", sum.norm());
        // No arm is longer than the half diagonal of the cube; a cross product has two terms.
        let arm = 2.0 * 3f64.sqrt();
        prop_assert!(moment.norm() <= arm * rounding, "{} N m, of {size} N", moment.norm());
    }

    /// The fields of two sets of charges add up, to the rounding of sums of up to 60 terms:
    /// distances and their inverse roots are the same in all three sums.
    #[test]
    fn direct_fields_are_superposed(cloud in small_cloud(), factor in -3.0..3.0_f64) {
        let (points, first) = split(&cloud);
        let second: Vec<_> = first.iter().rev().copied().collect();
        let both: Vec<_> = first.iter().zip(&second).map(|(a, b)| a + factor * b).collect();
        let solve = |charges: &[f64]| Direct.fields(&points, charges, &points).expect("valid");
        let [a, b, sum] = [&first, &second, &both].map(|charges| solve(charges).fields);
        let sizes = [&first, &second].map(|charges| magnitudes(&points, charges, |_| 1.0));
        for i in 0..points.len() {
            let size = sizes[0][i] + factor.abs() * sizes[1][i];
            let error = (sum[i] - a[i] - factor * b[i]).norm();
            prop_assert!(error <= 2.0 * 70.0 * f64::EPSILON * size, "{error} V/m, of {size} V/m");
        }
    }

    /// Fields turn with the points and do not depend on where these are.
    ///
    /// Moved coordinates, of up to 7 m, are rounded, which changes the square of a distance r by 7
    /// m/r roundings times some factor of directions, and inverse roots err for each distance on
    /// its own, three times in a field.
    #[test]
    fn direct_fields_move_with_the_points(cloud in small_cloud(), motion in motion()) {
        let (points, charges) = split(&cloud);
        let moved: Vec<_> = points.iter().map(|x| motion * x).collect();
        let at = Direct.fields(&points, &charges, &points).expect("valid").fields;
        let there = Direct.fields(&moved, &charges, &moved).expect("valid").fields;
        let allowed = magnitudes(&points, &charges, |r| {
            6.0 * INVERSE_ROOT + 3.0 * 3f64.sqrt() * 7.0 * f64::EPSILON * 8.0 / r
        });
        for ((at, there), allowed) in at.iter().zip(&there).zip(allowed) {
            let error = (motion * at - there).norm();
            prop_assert!(error <= allowed, "{error} V/m, more than {allowed} V/m");
        }
    }

    /// Charges of zero make nothing, one point feels nothing, and points at one place do not feel
    /// each other: two halves of a charge at a place are the charge.
    ///
    /// Terms are halved exactly, so only sums of up to 120 of them are rounded otherwise.
    #[test]
    fn coincident_points_are_one(cloud in small_cloud()) {
        let (points, charges) = split(&cloud);
        let zero = Direct.fields(&points, &vec![0.0; points.len()], &points).expect("valid");
        prop_assert!(zero.fields.iter().all(|e| *e == Vector3::zeros()));
        let one = Direct.fields(&points[..1], &charges[..1], &points[..1]).expect("valid");
        prop_assert!(one.fields == [Vector3::zeros()] && one.potentials == [0.0]);
        let halves: Vec<_> = charges.iter().map(|q| 0.5 * q).collect();
        let (twice, halves) = (points.repeat(2), halves.repeat(2));
        let at = Direct.fields(&points, &charges, &points).expect("valid").fields;
        let there = Direct.fields(&twice, &halves, &twice).expect("valid").fields;
        let sizes = magnitudes(&points, &charges, |_| 1.0);
        for (k, there) in there.iter().enumerate() {
            let i = k % points.len();
            let error = (at[i] - there).norm();
            prop_assert!(error <= 2.0 * 130.0 * f64::EPSILON * sizes[i], "{error} V/m at {i}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// The error against the direct sum is within the tolerance over all points; forces then have
    /// no sum and no moment to what Cauchy and Schwarz leave of it, the tolerance of the fields
    /// times the root of the squares of charges, or of charges times arms.
    #[test]
    fn tolerances_are_met(points in large_cloud(), mixed: bool, tolerance in tolerance()) {
        let charges = charges(points.len(), mixed, 5);
        let fields = multipole(tolerance, &points, &charges).expect("met");
        let exact = Direct.fields(&points, &charges, &points).expect("valid").fields;
        let error = relative(&fields, &exact);
        prop_assert!(error <= tolerance, "{error}, more than {tolerance}");

        let forces = || fields.iter().zip(&charges).map(|(e, q)| *q * e);
        let moments = || forces().zip(&points).map(|(f, x)| x.coords.cross(&f));
        let squares: f64 = charges.iter().map(|q| q * q).sum();
        let arms = points.iter().zip(&charges).map(|(x, q)| (q * x.coords.norm()).powi(2));
        let arms: f64 = arms.sum();
        let (sum, moment): (Vector3<f64>, Vector3<f64>) = (forces().sum(), moments().sum());
        let allowed = tolerance * norm(&exact);
        prop_assert!(sum.norm() <= allowed * squares.sqrt(), "{sum} N");
        prop_assert!(moment.norm() <= allowed * arms.sqrt(), "{moment} N m");
    }

    /// Fields add up to the tolerance of each of the three.
    #[test]
    fn fields_are_superposed(points in large_cloud(), tolerance in tolerance()) {
        let [first, second] = [false, true].map(|mixed| charges(points.len(), mixed, 6));
        let both: Vec<_> = first.iter().zip(&second).map(|(a, b)| a - 2.0 * b).collect();
        let [a, b, sum] = [&first, &second, &both]
            .map(|charges| multipole(tolerance, &points, charges).expect("met"));
        let terms = a.iter().zip(&b).zip(&sum);
        let errors: Vec<_> = terms.map(|((a, b), sum)| sum - a + 2.0 * b).collect();
        let allowed = tolerance * (norm(&a) + 2.0 * norm(&b) + norm(&sum));
        // Norms of what was found are those of the exact fields but for a tolerance of theirs.
        prop_assert!(norm(&errors) <= (1.0 + tolerance) * allowed, "{} V/m", norm(&errors));
    }

    /// Fields turn with the points to the tolerance of both: the tree and its cells are others.
    #[test]
    fn fields_move_with_the_points(
        points in large_cloud(),
        motion in motion(),
        tolerance in tolerance(),
    ) {
        let charges = charges(points.len(), true, 7);
        let moved: Vec<_> = points.iter().map(|x| motion * x).collect();
        let at = multipole(tolerance, &points, &charges).expect("met");
        let there = multipole(tolerance, &moved, &charges).expect("met");
        let errors: Vec<_> = at.iter().zip(&there).map(|(a, b)| motion * a - b).collect();
        let allowed = tolerance * (norm(&at) + norm(&there));
        // Beside them there is the rounding of moved coordinates, of up to 10 m, in pairs that are
        // close.
        let rounding = magnitudes(&points, &charges, |r| 100.0 * f64::EPSILON / r);
        let rounding = rounding.iter().map(|x| x * x).sum::<f64>().sqrt();
        let error = norm(&errors);
        prop_assert!(error <= (1.0 + tolerance) * allowed + rounding, "{error} V/m");
    }
}

/// A pair that is so close that it makes nearly all of the field is not lost, on whichever sides of
/// a border of cells its points lie.
#[test]
fn close_pairs_in_different_cells_are_seen() {
    for distance in [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13] {
        for tolerance in [1e-3, 1e-4, 1e-5, 1e-7, 1e-9] {
            let mut points = cube(5000, 3);
            // Points at opposite corners put the first border at the origin.
            points.extend([Point3::new(2.0, 2.0, 2.0), Point3::new(-2.0, -2.0, -2.0)]);
            points.extend([0.5, -0.5].map(|side| Point3::new(side * distance, 0.3, 0.2)));
            let charges = charges(points.len(), true, 5);
            let fields = multipole(tolerance, &points, &charges).expect("met");
            let exact = Direct.fields(&points, &charges, &points).expect("valid").fields;
            let error = relative(&fields, &exact);
            assert!(error <= tolerance, "{error}, more than {tolerance}, at {distance} m");
        }
    }
}

/// Clouds of a few cells are the hardest: few targets have cells at the least distance for their
/// radii, and samples may miss them.
#[test]
fn tolerances_are_met_in_clouds_of_few_cells() {
    for (count, seed) in (4100..5000).step_by(75).zip(0..) {
        let points = cube(count, seed);
        let charges = charges(points.len(), true, 7);
        let mut r = random(seed);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| normal(&mut r)));
        let points: Vec<_> = points.iter().map(|x| turn * x).collect();
        let exact = Direct.fields(&points, &charges, &points).expect("valid").fields;
        for tolerance in [1e-3, 1e-5, 1e-7, 1e-9] {
            let fields = multipole(tolerance, &points, &charges).expect("met");
            let error = relative(&fields, &exact);
            assert!(error <= tolerance, "{error}, more than {tolerance}, with seed {seed}");
        }
    }
}
