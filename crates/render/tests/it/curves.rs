use crate::wavy::{RADIUS, wavy};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use rapunzel_render::{CurveForm, Curves, FiberCurve, PathRandom, Ray, RenderError};

const ALL: [f64; 2] = [0.0, f64::INFINITY];

fn curves(ratio: Option<f64>, fibers: &[FiberCurve]) -> Curves {
    Curves::new(CurveForm::Cubic, ratio, fibers).expect("sound fibres")
}

fn ray(origin: Point3<f64>, towards: &Point3<f64>, time: f64) -> Ray {
    Ray { origin, direction: (towards - origin).normalize(), time }
}

fn cube() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-1.0..1.0_f64).prop_map(Vector3::from)
}

/// Nodes of a fibre that wanders, a few millimetres at a time.
fn wandering() -> impl Strategy<Value = Vec<Point3<f64>>> {
    prop::collection::vec(cube(), 4..9).prop_map(|steps| {
        let mut at = Point3::origin();
        let node = |(k, step): (usize, Vector3<f64>)| {
            at += 5e-3 * (Vector3::z() + 0.6 * step) * f64::from(u8::from(k > 0));
            at
        };
        steps.into_iter().enumerate().map(node).collect()
    })
}

/// Where a ray comes into a cylinder around the axis z, of any length.
fn cylinder(ray: &Ray, radius: f64) -> Option<f64> {
    let (o, d) = (ray.origin.coords.xy(), ray.direction.xy());
    let a = d.norm_squared();
    let nearest = -o.dot(&d) / a;
    let within = radius * radius - (o + nearest * d).norm_squared();
    (within >= 0.0).then(|| nearest - (within / a).sqrt())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// A straight fibre of 35 micrometres is the quadric, seen from a metre away.
    #[test]
    fn a_straight_fiber_is_a_cylinder(
        from in cube(), aside in -1.2..1.2_f64, height in 0.01..0.09_f64, basis in any::<bool>(),
    ) {
        prop_assume!(from.xy().norm() > 0.1);
        let nodes = (0..11).map(|k| Point3::new(0.0, 0.0, 0.01 * f64::from(k))).collect();
        let basis = if basis { CurveForm::Cubic } else { CurveForm::Linear };
        let fiber = [FiberCurve::round(nodes, RADIUS)];
        let tubes = Curves::new(basis, None, &fiber).expect("sound");
        let across = Vector3::new(-from.y, from.x, 0.0).normalize();
        let ray = ray(from.into(), &Point3::from(across * (aside * RADIUS) + Vector3::z() * height), 0.0);
        let hit = tubes.hit(&ray, ALL);
        // Radii are kept in single precision.
        let radius: f64 = f64::from(format!("{RADIUS}").parse::<f32>().expect("a number"));
        let exact = cylinder(&ray, radius);
        // A grazing ray comes in within the root of what is rounded off, of the radius.
        prop_assume!((aside.abs() - 1.0).abs() > 1e-9);
        prop_assert_eq!(hit.is_some(), exact.is_some());
        if let (Some(hit), Some(exact)) = (hit, exact) {
            let point = ray.at(hit.distance);
            let on = point.coords.xy().norm() / radius - 1.0;
            prop_assert!(on.abs() < 1e-9, "{on}");
            prop_assert!((hit.distance - exact).abs() < 1e-6 * radius);
            let at = tubes.at(&ray, &hit);
            prop_assert!((at.position - point).norm() < 1e-15);
            prop_assert!((at.normal - point.coords.xy().push(0.0) / RADIUS).norm() < 1e-6);
            prop_assert!((at.node - 100.0 * point.z).abs() < 1e-6);
            // The offset by its definition: x . (w x d3), in the plane, over the radius.
            let (w, x) = ((-ray.direction).xy().normalize(), point.coords.xy() / RADIUS);
            prop_assert!((at.offset - x.perp(&w)).abs() < 1e-6, "{} {}", at.offset, x.perp(&w));
        }
    }

    /// What is hit lies in the normal plane of the curve, on the ellipse around it, and nothing of
    /// the tube is in front of it.
    #[test]
    fn a_hit_is_on_the_section(
        nodes in wandering(), from in cube(), place in 0.0..1.0_f64, aside in cube(),
        ratio in prop_oneof![Just(None), (0.3..2.0_f64).prop_map(Some)],
    ) {
        let radius = 2e-4;
        let last = nodes.len() - 1;
        let axes: Vec<_> = (0..=last).map(|k| {
            let angle = 0.4 * k as f64;
            Vector3::new(angle.cos(), angle.sin(), 0.0)
        }).collect();
        let fiber = FiberCurve { axes, ..FiberCurve::round(nodes.clone(), radius) };
        let tubes = curves(ratio, std::slice::from_ref(&fiber));
        let aim = axis_point(&nodes, place * last as f64) + 1.5 * radius * aside;
        let ray = ray(Point3::from(0.2 * from), &aim, 0.0);
        if let Some(hit) = tubes.hit(&ray, ALL) {
            let at = tubes.at(&ray, &hit);
            let [a, b] = ratio.map_or([radius; 2], |q| [radius / q.sqrt(), radius * q.sqrt()]);
            let [d1, d2, d3] = at.frame;
            let axis = axis_point(&nodes, at.node);
            let x = at.position - axis;
            let along = x.dot(&d3) / radius;
            prop_assert!(along.abs() < 1e-7, "{along}");
            let on = (x.dot(&d1) / a).hypot(x.dot(&d2) / b);
            // Radii in single precision, and the last step of the iterations as the section turns.
            prop_assert!((on - 1.0).abs() < 4.0 * f64::from(f32::EPSILON), "{on}");
            prop_assert!(at.normal.dot(&ray.direction) <= 1e-6);
            prop_assert!((-1.0..=1.0).contains(&at.offset));
            prop_assert!(!tubes.hides(&ray, [0.0, hit.distance * (1.0 - 1e-12)]));
            prop_assert!(tubes.hides(&ray, ALL));
        }
    }

    /// A ray in the middle of an exposure sees fibres in the middle of their ways.
    #[test]
    fn a_moving_fiber_is_where_it_is_at_the_time(
        nodes in wandering(), way in cube(), from in cube(), time in 0.0..1.0_f64, k in 0_usize..4,
    ) {
        let ways: Vec<_> = (0..nodes.len()).map(|k| 2e-3 * way * (k as f64)).collect();
        let then: Vec<_> = nodes.iter().zip(&ways).map(|(x, way)| x + time * way).collect();
        let aim = then[k] + 1e-4 * way;
        let ray = ray(Point3::from(0.1 * from), &aim, time);
        let moving = FiberCurve { ways, ..FiberCurve::round(nodes, 2e-4) };
        let still = [FiberCurve::round(then, 2e-4)];
        let [moving, still] = [curves(None, &[moving]), curves(None, &still)].map(|t| t.hit(&ray, ALL));
        // Ways are kept in single precision.
        match (moving, still) {
            (Some(a), Some(b)) => prop_assert!((a.distance - b.distance).abs() < 1e-6),
            (a, b) => prop_assert_eq!(a.is_some(), b.is_some()),
        }
    }
}

/// The point of the natural spline through nodes; by its moments, which is another way.
fn axis_point(nodes: &[Point3<f64>], node: f64) -> Point3<f64> {
    let n = nodes.len();
    // Second derivatives by Jacobi's iteration: m[i-1] + 4 m[i] + m[i+1] = 6 (second difference).
    let mut m = vec![Vector3::zeros(); n];
    for _ in 0..200 {
        let old = m.clone();
        for i in 1..n - 1 {
            let bend = nodes[i - 1].coords - 2.0 * nodes[i].coords + nodes[i + 1].coords;
            m[i] = (6.0 * bend - old[i - 1] - old[i + 1]) / 4.0;
        }
    }
    let k = (0..n - 1).rev().find(|k| *k as f64 <= node).unwrap_or(0);
    let (t, u) = (node - k as f64, 1.0 - (node - k as f64));
    let straight = nodes[k].coords * u + nodes[k + 1].coords * t;
    Point3::from(straight + (m[k] * (u * u * u - u) + m[k + 1] * (t * t * t - t)) / 6.0)
}

/// The tree finds what every fibre by itself finds, also for rays from inside the hair.
#[test]
fn the_tree_misses_nothing() {
    let fibers = wavy(300, 24);
    let all = curves(None, &fibers);
    let each: Vec<_> =
        fibers.iter().map(|fiber| curves(None, std::slice::from_ref(fiber))).collect();
    let mut random = PathRandom::new(7, 0, 0);
    let mut point = || Vector3::from_fn(|_, _| random.number() - 0.5);
    let mut hits = 0;
    for k in 0..4000 {
        let (from, size) = (point(), if k % 2 == 0 { 0.15 } else { 1.0 });
        let origin = Point3::new(from.x * size, from.y * size, 0.15 + from.z * size);
        let direction = if k % 5 == 0 { Vector3::ith(k / 5 % 3, 1.0) } else { point().normalize() };
        let ray = Ray { origin, direction, time: 0.0 };
        let hit = all.hit(&ray, ALL).map(|hit| hit.distance);
        let nearest = each.iter().filter_map(|one| one.hit(&ray, ALL)).map(|hit| hit.distance);
        let nearest = nearest.min_by(f64::total_cmp);
        assert_eq!(hit.is_some(), nearest.is_some(), "{ray:?}");
        if let (Some(a), Some(b)) = (hit, nearest) {
            hits += 1;
            // What is left of the iterations, more where a ray grazes.
            assert!((a - b).abs() < 1e-6 * RADIUS, "{a} {b}");
        }
        assert_eq!(all.hides(&ray, ALL), hit.is_some());
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn what_is_no_fiber_is_refused_or_not_seen() {
    let line = vec![Point3::origin(), Point3::new(0.0, 0.0, 1.0)];
    let refused = |fiber: FiberCurve, ratio: Option<f64>| {
        let error = Curves::new(CurveForm::Cubic, ratio, &[fiber]).expect_err("refused");
        assert!(matches!(error, RenderError::Curve { fiber: 0, .. }), "{error}");
    };
    refused(FiberCurve::round(vec![Point3::origin()], 1e-3), None);
    refused(FiberCurve::round(line.clone(), f64::NAN), None);
    refused(FiberCurve::round(line.clone(), -1.0), None);
    refused(FiberCurve::round(vec![Point3::new(f64::INFINITY, 0.0, 0.0); 2], 1e-3), None);
    refused(FiberCurve { radii: vec![1e-3], ..FiberCurve::round(line.clone(), 1e-3) }, None);
    refused(FiberCurve::round(line.clone(), 1e-3), Some(0.8));
    let axes = vec![Vector3::zeros(); 2];
    refused(FiberCurve { axes, ..FiberCurve::round(line.clone(), 1e-3) }, Some(0.8));
    let wrong = Curves::new(CurveForm::Cubic, Some(-1.0), &[FiberCurve::round(line.clone(), 1e-3)]);
    assert!(matches!(wrong, Err(RenderError::Parameter { .. })));

    let at = ray(Point3::new(1.0, 0.0, 0.5), &Point3::new(0.0, 0.0, 0.5), 0.0);
    let thin = curves(None, &[FiberCurve::round(line.clone(), 0.0)]);
    assert_eq!(thin.hit(&at, ALL), None);
    let none = curves(None, &[]);
    assert!(none.is_empty() && none.bounds().is_none() && none.hit(&at, ALL).is_none());
    // Pieces without length are passed over; those beside them are there.
    let twice = [0.0, 0.3, 0.3, 0.3, 1.0].map(|z| Point3::new(0.0, 0.0, z)).to_vec();
    for basis in [CurveForm::Cubic, CurveForm::Linear] {
        let tubes =
            Curves::new(basis, None, &[FiberCurve::round(twice.clone(), 1e-3)]).expect("sound");
        assert!(tubes.hit(&at, ALL).is_some_and(|hit| (hit.distance - 0.999).abs() < 1e-9));
    }
    let point = curves(None, &[FiberCurve::round(vec![Point3::origin(); 3], 1e-3)]);
    assert_eq!(point.hit(&at, ALL), None);
    // From inside nothing comes in, nor along the axis.
    let tube = curves(None, &[FiberCurve::round(line, 0.1)]);
    assert_eq!(tube.hit(&ray(Point3::new(0.01, 0.0, 0.5), &at.origin, 0.0), ALL), None);
    let along = ray(Point3::new(0.0, 0.0, -1.0), &Point3::origin(), 0.0);
    assert_eq!(tube.hit(&along, ALL), None);
}
