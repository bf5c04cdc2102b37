//! The smallest sphere around spheres.

use nalgebra::{Point3, Vector3};

/// A bounding sphere (thesis, 7.3.7.4), around other spheres the smallest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    pub(super) center: Point3<f64>,
    pub(super) radius: f64,
}

/// The smallest sphere around at least one sphere, to rounding, and the places of the 1 to 4 that
/// determine it.
///
/// Pivoting as of Gaertner (1999): of all spheres the one that sticks out farthest joins the basis,
/// and the smallest sphere around the at most five is found among all of their subsets. That
/// replaces the recursion of Welzl (1991), which is wrong for spheres of different radii (Fischer
/// and Gaertner 2003). The radius grows in each round, so it ends; in practice after about ten,
/// each of one pass.
pub(super) fn minimal_sphere(spheres: &[Sphere]) -> (Sphere, Vec<u32>) {
    let mut basis = vec![0];
    let mut best = spheres[0];
    loop {
        let (farthest, reach) = farthest(&best.center, spheres);
        let mut trial = basis.clone();
        if reach <= best.radius || basis.contains(&farthest) {
            return (Sphere { radius: reach, ..best }, places(&basis));
        }
        trial.push(farthest);
        let (next, chosen) = around_few(spheres, &trial);
        if next.radius <= best.radius {
            return (Sphere { radius: reach, ..best }, places(&basis));
        }
        (best, basis) = (next, chosen);
    }
}

fn places(basis: &[usize]) -> Vec<u32> {
    let mut places: Vec<u32> = basis.iter().filter_map(|&b| u32::try_from(b).ok()).collect();
    places.sort_unstable();
    places
}

/// The sphere that reaches farthest from `center`, and how far; infinity where that is no number.
fn farthest(center: &Point3<f64>, spheres: &[Sphere]) -> (usize, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, sphere) in spheres.iter().enumerate() {
        let reach = (sphere.center - center).norm() + sphere.radius;
        if reach.is_nan() {
            return (i, f64::INFINITY);
        }
        if reach > best.1 {
            best = (i, reach);
        }
    }
    best
}

/// The smallest sphere around the at most five spheres at `places`, and those that determine it.
///
/// The sphere that touches a subset from outside, with its center between theirs, is a candidate;
/// each is made large enough for all, and the smallest is right, because the reach from a center is
/// a convex function whose least value is at one of the candidates. Subsets without such a sphere,
/// or nearly so, need no care: another candidate is as small.
fn around_few(spheres: &[Sphere], places: &[usize]) -> (Sphere, Vec<usize>) {
    let all: Vec<Sphere> = places.iter().map(|&p| spheres[p]).collect();
    let mut best = (Sphere { radius: f64::INFINITY, ..all[0] }, vec![places[0]]);
    for mask in 1..1_usize << all.len() {
        let members = || (0..all.len()).filter(move |i| mask >> i & 1 == 1);
        if members().count() > 4 {
            continue;
        }
        let subset: Vec<Sphere> = members().map(|i| all[i]).collect();
        for center in touching(&subset) {
            let (_, radius) = farthest(&center, &all);
            if radius < best.0.radius {
                best = (Sphere { center, radius }, members().map(|i| places[i]).collect());
            }
        }
    }
    best
}

/// Centers, in the plane of the centers of `subset`, of spheres that touch all of it from outside.
///
/// With x from the first center and s the radius less the first one's, `|x| = s` and
/// `|x - q_i| = s - d_i` give `q_i x = (q_i^2 - d_i^2) / 2 + s d_i`, linear in s, and a quadratic
/// equation for s.
fn touching(subset: &[Sphere]) -> impl Iterator<Item = Point3<f64>> {
    let first = subset[0];
    // An orthonormal basis of the plane, and x = a + s b solved along it.
    let mut directions: Vec<Vector3<f64>> = Vec::new();
    let (mut a, mut b) = (Vector3::zeros(), Vector3::zeros());
    let mut solvable = true;
    for sphere in &subset[1..] {
        let q = sphere.center - first.center;
        let d = sphere.radius - first.radius;
        let rest = directions.iter().fold(q, |v, e| v - e * e.dot(&v));
        let norm = rest.norm();
        solvable &= norm > 1e-12 * q.norm();
        let e = rest / norm;
        let along = e.dot(&q);
        a += e * ((0.5 * (q.norm_squared() - d * d) - q.dot(&a)) / along);
        b += e * ((d - q.dot(&b)) / along);
        directions.push(e);
    }
    // (b^2 - 1) s^2 + 2 a b s + a^2 = 0.
    let (p, h, c) = (b.norm_squared() - 1.0, a.dot(&b), a.norm_squared());
    let root = (h * h - p * c).max(0.0).sqrt();
    // Both roots without cancellation; where the sign of h is that of the root, it is in `large`.
    let large = -(h + root.copysign(h));
    [large / p, c / large]
        .into_iter()
        .map(move |s| first.center + if subset.len() == 1 { Vector3::zeros() } else { a + s * b })
        .filter(move |center| solvable && center.iter().all(|x| x.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn spheres() -> impl Strategy<Value = Vec<Sphere>> {
        let x = || prop_oneof![(-2..=2_i8).prop_map(f64::from), -2.0..2.0_f64];
        let radius = prop_oneof![Just(0.0), Just(0.5), 0.0..2.0_f64];
        let sphere = (prop::array::uniform3(x()), radius)
            .prop_map(|(center, radius)| Sphere { center: center.into(), radius });
        prop::collection::vec(sphere, 1..9)
    }

    /// Least reach from any center: the convex function is minimized by ever shorter steps along
    /// the axes and toward the farthest sphere, which needs none of the algebra above.
    fn searched(spheres: &[Sphere]) -> f64 {
        let mut center = Point3::origin();
        let mut least = farthest(&center, spheres).1;
        let mut step = 1.0;
        while step > 1e-7 {
            let away = (spheres[farthest(&center, spheres).0].center - center) * step;
            let moves = (0..3).flat_map(|d| [1.0, -1.0].map(|s| Vector3::ith(d, s * step)));
            let better = moves.chain([away]).find(|m| farthest(&(center + m), spheres).1 < least);
            if let Some(m) = better {
                center += m;
                least = farthest(&center, spheres).1;
            } else {
                step *= 0.8;
            }
        }
        least
    }

    /// Smallest of the spheres that touch a subset and hold all: brute force over all subsets.
    fn brute_force(spheres: &[Sphere]) -> f64 {
        let mut least = f64::INFINITY;
        for mask in 1..1_usize << spheres.len() {
            if mask.count_ones() <= 4 {
                let subset: Vec<_> =
                    (0..spheres.len()).filter(|i| mask >> i & 1 == 1).map(|i| spheres[i]).collect();
                for center in touching(&subset) {
                    least = least.min(farthest(&center, spheres).1);
                }
            }
        }
        least
    }

    proptest! {
        #[test]
        fn no_subset_spans_a_smaller_sphere(spheres in spheres()) {
            let (sphere, basis) = minimal_sphere(&spheres);
            let expected = brute_force(&spheres);
            prop_assert!((sphere.radius - expected).abs() <= 1e-9, "{} {expected}", sphere.radius);
            prop_assert!(sphere.radius <= searched(&spheres) + 1e-12);
            for s in &spheres {
                prop_assert!((s.center - sphere.center).norm() + s.radius <= sphere.radius);
            }
            prop_assert!((1..=4).contains(&basis.len()));
            let few: Vec<_> = basis.iter().map(|&b| spheres[b as usize]).collect();
            prop_assert!((minimal_sphere(&few).0.radius - sphere.radius).abs() <= 1e-9);
        }
    }

    #[test]
    fn corners_of_a_cube_and_their_duplicates() {
        let mut spheres = Vec::new();
        for i in 0..16 {
            let center = [0, 1, 2].map(|d| f64::from(i >> d & 1)).into();
            spheres.push(Sphere { center, radius: 0.25 });
        }
        let (sphere, _) = minimal_sphere(&spheres);
        assert!((sphere.radius - (0.75_f64.sqrt() + 0.25)).abs() < 1e-15);
        let (point, basis) = minimal_sphere(&[spheres[3]; 5]);
        assert_eq!((point, basis), (spheres[3], vec![0]));
    }
}
