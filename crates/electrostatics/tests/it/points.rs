//! Point charges: the methods against each other and against exact fields.

use crate::common::{charges, cube, hair, normal, random, relative, sphere, unit};
use nalgebra::{Point3, Vector3};
use rapunzel_electrostatics::{
    Accuracy, BarnesHut, COULOMB_CONSTANT, Direct, ElectrostaticsError, Method, Multipole,
    MultipolePlan,
};

/// Barnes and Hut's method and the multipole method converge to the direct sum as the order grows.
#[test]
fn methods_converge_to_the_direct_sum() {
    for points in [cube(5000, 1), hair(50, 100, 2).concat()] {
        let charges = charges(points.len(), false, 3);
        let exact = Direct.fields(&points, &charges, &points).expect("valid");
        let mut last = [1.0; 2];
        for order in [2, 5, 8, 11, 14, 17] {
            let methods: [&dyn Method; 2] = [
                &Multipole { accuracy: Accuracy::Order(order) },
                &BarnesHut { opening: 0.5, order },
            ];
            for (k, method) in methods.iter().enumerate() {
                let fields = method.fields(&points, &charges, &points).expect("valid");
                let error = relative(&fields.fields, &exact.fields);
                assert!(error < 0.3 * last[k], "method {k}, order {order}: {error}");
                let potentials = fields.potentials.iter().zip(&exact.potentials);
                let worst = potentials.map(|(a, e)| (a / e - 1.0).abs()).fold(0.0, f64::max);
                assert!(
                    worst < 3.0 * error,
                    "potentials of one sign are smoother than fields: {worst}"
                );
                last[k] = error;
            }
        }
        assert!(last[0] < 1e-6 && last[1] < 1e-5, "{last:?}");
    }
}

/// Sets of some thousand points: ten kinds.
fn sets(seed: u64) -> Vec<(&'static str, Vec<Point3<f64>>)> {
    let mut r = random(seed);
    let clusters: Vec<_> = (0..4000)
        .map(|k| {
            let center = Vector3::new((k % 7) as f64, (k % 11) as f64, (k % 5) as f64);
            let size = 0.3 / f64::from(1 + k % 13);
            Point3::from(center + size * Vector3::from_fn(|_, _| normal(&mut r)))
        })
        .collect();
    let gauss = (0..4000).map(|_| Vector3::from_fn(|_, _| normal(&mut r)).into()).collect();
    let powers: Vec<Point3<f64>> = (0..4000)
        .map(|_| {
            let x = Vector3::from_fn(|_, _| normal(&mut r)).normalize();
            (x * 10f64.powf(-4.0 * unit(&mut r))).into()
        })
        .collect();
    let mut coincident = cube(2000, seed + 1);
    coincident.extend_from_within(..);
    let line = |_: usize| Point3::new(0.0, 0.0, unit(&mut r));
    let line = (0..4000).map(line).collect();
    let plane =
        cube(4000, seed + 3).into_iter().map(|x| Point3::new(x.x, 0.2 * x.y, 0.0)).collect();
    vec![
        ("cube", cube(4000, seed)),
        ("sphere", sphere(4000, seed)),
        ("line", line),
        ("plane", plane),
        ("bundle", hair(40, 100, seed).concat()),
        ("thick bundle", hair(270, 15, seed).concat()),
        ("clusters", clusters),
        ("gauss", gauss),
        ("powers", powers),
        ("coincident", coincident),
    ]
}

/// The tolerance that is asked for holds over all targets of 60 sets, and is not beaten by more
/// than ten times, save by expansions of the lowest degree and by the direct sum.
#[test]
fn tolerances_are_met_and_not_beaten() {
    let mut failures = Vec::new();
    for (seed, tolerance) in [(1, 1e-3), (2, 1e-5), (3, 1e-7)] {
        for (name, points) in sets(seed) {
            for mixed in [false, true] {
                let charges = charges(points.len(), mixed, seed + 10);
                let plan = MultipolePlan::new(&points, &points, Accuracy::Tolerance(tolerance));
                let (fields, certificate) =
                    plan.and_then(|plan| plan.fields(&charges)).expect("met");
                let exact = Direct.fields(&points, &charges, &points).expect("valid");
                let error = relative(&fields.fields, &exact.fields);
                let lazy = error < 0.1 * tolerance && certificate.order.is_some_and(|p| p > 1);
                if error > tolerance || lazy {
                    failures.push(format!(
                        "{name}, {mixed}, {tolerance:e}: {error:e}, {certificate:?}"
                    ));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// What no degree reaches is refused, and the error says how far it got: the fields of an evenly
/// charged sphere cancel within, so what is left of them has fewer digits than their terms, by the
/// ratio of both.
#[test]
fn tolerances_beyond_reach_are_refused() {
    let place = |k: usize| {
        let (z, angle) = (1.0 - (2 * k + 1) as f64 / 6000.0, 2.399_963_229_728_653 * k as f64);
        let radius = (1.0 - z * z).sqrt();
        Point3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    let shell: Vec<_> = (0..6000).map(place).collect();
    let targets: Vec<_> = cube(5000, 1)
        .iter()
        .map(|x| Point3::from(0.2 * (x.coords - Vector3::repeat(0.5))))
        .collect();
    let multipole = Multipole { accuracy: Accuracy::Tolerance(1e-12) };
    let charges = vec![1e-12; 6000];
    let left = Direct.fields(&shell, &charges, &targets).expect("valid").fields;
    let left = (left.iter().map(Vector3::norm_squared).sum::<f64>() / 5000.0).sqrt();
    let cancelled = COULOMB_CONSTANT * charges.iter().sum::<f64>() / left;
    let result = multipole.fields(&shell, &charges, &targets);
    let Err(ElectrostaticsError::OutOfReach { tolerance, reached, order }) = result else {
        panic!("most of the digits cancel");
    };
    // Between the rounding of a number and the 6e-13 by which inverse roots of terms may err.
    let possible = f64::EPSILON * cancelled..6e-13 * cancelled;
    assert!(tolerance == 1e-12 && possible.contains(&reached), "{reached}, not in {possible:?}");
    assert!(order > 10, "{order}");
}

/// Results have equal bits with one thread, two and three, also at other targets than sources.
#[test]
fn threads_change_no_bit() {
    let (points, targets) = (hair(80, 200, 5).concat(), cube(3000, 6));
    let charges = charges(points.len(), true, 7);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let multipole = Multipole { accuracy: Accuracy::Tolerance(1e-4) };
        pool.install(|| [&points, &targets].map(|t| multipole.fields(&points, &charges, t)))
    };
    let one = run(1);
    assert!(one == run(2) && one == run(3));
    let exact = Direct.fields(&points, &charges, &targets).expect("valid");
    let error = relative(&one[1].as_ref().expect("met").fields, &exact.fields);
    assert!(error < 1e-4, "{error}");
}

/// T4: the axis of a ring. T7: the field of points on a line beside the continuous line. T5: the
/// force of a ring of points on itself.
#[test]
fn fields_of_rings_and_lines_are_exact() {
    let k = COULOMB_CONSTANT;
    let (n, radius, q) = (4000, 0.07, 2e-13);
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
    let ring: Vec<_> = (0..n)
        .map(|i| Point3::new(radius * angle(i).cos(), radius * angle(i).sin(), 0.0))
        .collect();
    let charges = vec![q; n];
    let axis = [-0.2, -0.01, 0.03, 0.5].map(|z| Point3::new(0.0, 0.0, z));
    let fields = Direct.fields(&ring, &charges, &axis).expect("valid");
    for (field, z) in fields.fields.iter().zip(axis.map(|x| x.z)) {
        let exact = k * q * n as f64 * z / (z * z + radius * radius).powf(1.5);
        assert!((field.z / exact - 1.0).abs() < 1e-12, "{} V/m, not {exact}", field.z);
    }
    let own = Direct.fields(&ring, &charges, &ring).expect("valid");
    let density = q * n as f64 / (std::f64::consts::TAU * radius);
    let euler = 0.577_215_664_901_532_9;
    let exact = k * density / radius * ((2.0 * n as f64 / std::f64::consts::PI).ln() + euler);
    assert!(
        (own.fields[17].norm() / exact - 1.0).abs() < 1e-8,
        "{}",
        own.fields[17].norm() / exact
    );

    let h = 1.0 / 330.0;
    let line: Vec<_> =
        (-200_000..=200_000).map(|i| Point3::new(0.0, 0.0, f64::from(i) * h)).collect();
    let field = |d: f64| {
        let charges = vec![h; line.len()];
        Direct.fields(&line, &charges, &[Point3::new(d, 0.0, 0.0)]).expect("valid").fields[0].x
    };
    // The ripple is the sum of 2 x K1(x) over multiples of x = 2 pi d/h, K1 by its asymptotic
    // series.
    let term = |n: f64| {
        let x = std::f64::consts::TAU * n;
        let series = 1.0 + 3.0 / (8.0 * x) - 15.0 / (128.0 * x * x) + 315.0 / (3072.0 * x.powi(3))
            - 14_175.0 / (98_304.0 * x.powi(4));
        2.0 * x * (std::f64::consts::PI / (2.0 * x)).sqrt() * (-x).exp() * series
    };
    let ripple = field(h) / (2.0 * k / h) - 1.0;
    assert!((ripple / (term(1.0) + term(2.0)) - 1.0).abs() < 1e-4, "{ripple}");
}

/// T20: what is degenerate is defined, what is nonsense is refused.
#[test]
fn degenerate_input_is_answered() {
    for tolerance in [1e-3, 1e-9] {
        let method = Multipole { accuracy: Accuracy::Tolerance(tolerance) };
        for count in 0..3 {
            let points = cube(count, 1);
            let exact = Direct.fields(&points, &vec![1e-12; count], &points);
            assert_eq!(method.fields(&points, &vec![1e-12; count], &points), exact);
        }
        let same = vec![Point3::new(1.0, 2.0, 3.0); 3000];
        let fields = method.fields(&same, &vec![1.0; 3000], &same).expect("defined");
        assert!(fields.fields.iter().all(|e| *e == Vector3::zeros()));
        let tiny = vec![1e-300; 3000];
        let fields = method.fields(&cube(3000, 2), &tiny, &cube(3000, 2)).expect("defined");
        assert!(fields.fields.iter().all(|e| e.amax() > 0.0));
        for scale in [1e-50, 1e50] {
            let points: Vec<_> = cube(3000, 2).into_iter().map(|x| x * scale).collect();
            let charges = charges(3000, true, 4);
            let exact = Direct.fields(&points, &charges, &points).expect("valid").fields;
            let fields = method.fields(&points, &charges, &points).expect("met").fields;
            // In units of the scale, since squares of fields underflow.
            let unit = |fields: &[Vector3<f64>]| -> Vec<_> {
                fields.iter().map(|field| field * scale * scale).collect()
            };
            let error = relative(&unit(&fields), &unit(&exact));
            assert!(error < tolerance, "{scale:e}: {error}");
        }
        let none = method.fields(&cube(3000, 2), &vec![0.0; 3000], &cube(3000, 2));
        assert!(none.expect("defined").fields.iter().all(|e| *e == Vector3::zeros()));
    }
    let points = cube(2, 1);
    let nowhere = [points[0], Point3::new(f64::NAN, 0.0, 0.0)];
    let far = [points[0], Point3::new(1e200, 0.0, 0.0)];
    for method in [&Direct as &dyn Method, &BarnesHut { opening: 0.5, order: 3 }] {
        for bad in [nowhere, far] {
            let result = method.fields(&bad, &[1.0, 1.0], &points);
            assert!(matches!(result, Err(ElectrostaticsError::Position { index: 1, .. })));
        }
        let result = method.fields(&points, &[1.0, f64::INFINITY], &points);
        assert!(matches!(result, Err(ElectrostaticsError::Charge { index: 1, .. })));
        let result = method.fields(&points, &[1.0], &points);
        assert!(matches!(result, Err(ElectrostaticsError::Count { given: 1, needed: 2, .. })));
    }
    for accuracy in [Accuracy::Tolerance(0.0), Accuracy::Tolerance(f64::NAN), Accuracy::Order(99)] {
        let result = MultipolePlan::new(&points, &points, accuracy);
        assert!(matches!(result, Err(ElectrostaticsError::Setting { .. })));
    }
}

/// T8, T9: inside a uniform ball the field is `Q r/R^3`, inside a long elliptic bundle of lines
/// `4 lambda/(a+b) (x/a, y/b)`, lambda of all lines together; beside sampling errors, which fall as
/// the root of the number.
#[test]
fn fields_inside_of_uniform_charges_are_linear() {
    let k = COULOMB_CONSTANT;
    let mut ball = cube(60_000, 8);
    ball.iter_mut().for_each(|x| *x = (2.0 * x.coords - Vector3::repeat(1.0)).into());
    ball.retain(|x| x.coords.norm() < 1.0);
    let (count, q) = (ball.len(), 1e-12);
    let targets: Vec<_> = sphere(400, 9).iter().map(|x| Point3::from(0.6 * x.coords)).collect();
    let method = Multipole { accuracy: Accuracy::Tolerance(1e-5) };
    let fields = method.fields(&ball, &vec![q; count], &targets).expect("met").fields;
    let total: f64 = fields.iter().zip(&targets).map(|(e, x)| e.dot(&x.coords) / 0.6).sum();
    let exact = k * q * count as f64 * 0.6;
    // The charge within 0.6 is binomial; three deviations.
    let deviation = 3.0 * ((1.0 / 0.216 - 1.0) / count as f64).sqrt();
    let mean = total / targets.len() as f64;
    assert!((mean / exact - 1.0).abs() < deviation, "{mean} V/m, not {exact}");

    let (a, b, lines, steps, half) = (2.0, 1.0, 2000, 200, 40.0);
    let place = |i: usize| {
        let (radius, angle) = (((i as f64 + 0.5) / lines as f64).sqrt(), i as f64 * 2.399_963);
        [a * radius * angle.cos(), b * radius * angle.sin()]
    };
    let point = |i: usize| {
        let [x, y] = place(i / steps);
        let z = half * (2.0 * ((i % steps) as f64 + 0.5) / steps as f64 - 1.0);
        Point3::new(x, y, z)
    };
    let bundle: Vec<_> = (0..lines * steps).map(point).collect();
    let density = q * steps as f64 / (2.0 * half) * lines as f64;
    // Lines of points are lines from a spacing on, so the field is that of means over places.
    let targets: Vec<_> = (0..300)
        .map(|i| {
            let [x, y] = place(i * lines / 300);
            Point3::new(0.7 * x, 0.7 * y, 0.0)
        })
        .collect();
    let fields = method.fields(&bundle, &vec![q; bundle.len()], &targets).expect("met").fields;
    let exact = |x: &Point3<f64>| 4.0 * k * density / (a + b) * Vector3::new(x.x / a, x.y / b, 0.0);
    let along: f64 = fields.iter().zip(&targets).map(|(e, x)| e.dot(&exact(x))).sum();
    let squares: f64 = targets.iter().map(|x| exact(x).norm_squared()).sum();
    assert!((along / squares - 1.0).abs() < 2e-2, "{}", along / squares);
}
