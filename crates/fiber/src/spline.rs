//! Smooth curves through nodes.

use nalgebra::Point3;

/// The `n + 3` control points, m, of the uniform cubic B-spline that passes through `n + 1` nodes
/// (m, world), with natural ends: the second derivative is zero there, the first control point is
/// as far before the first node as the third is behind it. No points for fewer than two nodes.
///
/// Between four control points `a, b, c, d` in a row runs a segment from `(a + 4b + c) / 6` to
/// `(b + 4c + d) / 6`. Cost: linear in the nodes.
#[must_use]
pub fn control_points(nodes: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let [first, inner @ .., last] = nodes else { return Vec::new() };
    // Natural ends put the second and the last but one control point on the end nodes; for those
    // between, a + 4b + c = 6 P. Forward, each is a constant less a part of the next.
    let mut constant = first.coords;
    let mut part = 0.0;
    let eliminated: Vec<_> = inner
        .iter()
        .map(|node| {
            part = 1.0 / (4.0 - part);
            constant = part * (6.0 * node.coords - constant);
            (constant, part)
        })
        .collect();
    let mut next = last.coords;
    let mut points = vec![*last; nodes.len() + 2];
    for (point, (constant, part)) in points[2..].iter_mut().zip(&eliminated).rev() {
        next = constant - *part * next;
        *point = next.into();
    }
    points[1] = *first;
    let end = points.len() - 1;
    points[0] = points[1] + (points[1] - points[2]);
    points[end] = points[end - 1] + (points[end - 1] - points[end - 2]);
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Where the curve is between the second and third of four control points, at `[0, 1]`.
    fn at(points: &[Point3<f64>], t: f64) -> Point3<f64> {
        let weights = [
            (1.0 - t).powi(3),
            3.0 * t.powi(3) - 6.0 * t * t + 4.0,
            3.0 * (1.0 - t).powi(3) - 6.0 * (1.0 - t).powi(2) + 4.0,
            t.powi(3),
        ];
        let terms = points.iter().zip(weights).map(|(p, weight)| p.coords * (weight / 6.0));
        terms.sum::<nalgebra::Vector3<f64>>().into()
    }

    fn largest(points: &[Point3<f64>]) -> f64 {
        points.iter().map(|p| p.coords.amax()).fold(0.0, f64::max)
    }

    #[test]
    fn a_straight_line_stays_straight() {
        let node =
            |i: i32| Point3::new(0.1, -0.2, 0.3) + f64::from(i) * Point3::new(1.0, 2.0, 3.0).coords;
        for count in [2, 3, 4, 20] {
            let nodes: Vec<_> = (0..count).map(node).collect();
            let points = control_points(&nodes);
            assert_eq!(points.len(), nodes.len() + 2);
            for (point, i) in points.iter().zip(-1..) {
                assert!((point - node(i)).amax() <= 16.0 * f64::EPSILON * largest(&points));
            }
        }
        assert!(control_points(&[]).is_empty() && control_points(&[node(0)]).is_empty());
    }

    /// Between its nodes the curve is as near to a smooth one as cubics are: the fourth order of
    /// the spacing, away from the ends, where the curve is not straight.
    #[test]
    fn a_helix_is_followed_with_fourth_order() {
        let helix = |s: f64| Point3::new(s.cos(), s.sin(), 0.3 * s);
        let worst = |count: i32| {
            let h = 8.0 / f64::from(count);
            let nodes: Vec<_> = (0..=count).map(|i| helix(h * f64::from(i))).collect();
            let points = control_points(&nodes);
            let middle = |i: i32| {
                let first = usize::try_from(i).expect("a number");
                (at(&points[first..first + 4], 0.5) - helix(h * (f64::from(i) + 0.5))).norm()
            };
            (count / 4..3 * count / 4).map(middle).fold(0.0, f64::max)
        };
        let order = (worst(64) / worst(128)).log2();
        assert!((order - 4.0).abs() < 0.1, "{order}");
    }

    proptest! {
        #[test]
        fn the_curve_passes_through_its_nodes_with_natural_ends(
            nodes in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 2..40),
        ) {
            let nodes: Vec<_> = nodes.into_iter().map(Point3::from).collect();
            let points = control_points(&nodes);
            prop_assert_eq!(points.len(), nodes.len() + 2);
            // A handful of roundings of numbers of this size.
            let rounding = 16.0 * f64::EPSILON * largest(&points);
            for (four, ends) in points.windows(4).zip(nodes.windows(2)) {
                prop_assert!((at(four, 0.0) - ends[0]).amax() <= rounding);
                prop_assert!((at(four, 1.0) - ends[1]).amax() <= rounding);
            }
            let end = points.len() - 3;
            for three in [&points[..3], &points[end..]] {
                let bend = three[0].coords - 2.0 * three[1].coords + three[2].coords;
                prop_assert!(bend.amax() <= rounding);
            }
        }
    }
}
