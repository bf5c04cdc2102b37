use nalgebra::{Point3, Vector3};
use rapunzel_render::{Light, LightHit, LightSample, Lights, PathRandom, Ray, Sky, SkyMap};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const RED: Vector3<f64> = Vector3::new(3.0, 2.0, 1.0);
const UP: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);

fn lights(lights: &[Light], sky: Option<Sky>) -> Lights {
    Lights::new(lights, sky).expect("lights")
}

/// A rectangle 2 m above the origin that shines down.
fn ceiling() -> Light {
    let half_edges = [Vector3::new(0.0, 1.5, 0.0), Vector3::new(1.0, 0.0, 0.0)];
    Light::Rectangle { center: Point3::new(0.0, 0.0, 2.0), half_edges, radiance: RED }
}

fn ball(height: f64, radius: f64) -> Light {
    Light::Sphere { center: Point3::new(0.0, 0.0, height), radius, radiance: RED }
}

fn sun(angular_radius: f64) -> Light {
    let toward = Vector3::new(0.3, 0.2, 0.9);
    Light::Distant { toward, irradiance: RED, angular_radius }
}

fn gradient() -> Sky {
    let (zenith, horizon) = (Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 4.0, 4.0));
    Sky::Gradient { zenith, horizon, ground: Vector3::repeat(0.5), up: UP * 7.0 }
}

/// A map with light in all pixels, among them a bright one, upright along an odd direction.
fn map() -> Sky {
    let mut pixels: Vec<[f32; 3]> = (0..8 * 5).map(|k| [0.1, (k % 7) as f32, 0.3]).collect();
    pixels[19] = [90.0, 80.0, 70.0];
    Sky::Map(SkyMap::new(8, 5, pixels, &Vector3::new(0.2, -0.5, 1.0), 0.7).expect("a map"))
}

fn seen(lights: &Lights, from: &Point3<f64>, direction: &Vector3<f64>) -> LightHit {
    let ray = Ray { origin: *from, direction: *direction, time: 0.0 };
    lights.hit(&ray, f64::INFINITY).unwrap_or_else(|| lights.escaped(direction))
}

/// The mean of a function of samples, and its standard error.
fn mean(
    lights: &Lights,
    from: &Point3<f64>,
    samples: u32,
    of: impl Fn(&LightSample) -> f64,
) -> (f64, f64) {
    let mut random = PathRandom::new(1, 2, 3);
    let (mut sum, mut square) = (0.0, 0.0);
    for _ in 0..samples {
        let value = lights.sample(from, &mut random).map_or(0.0, |sample| of(&sample));
        sum += value;
        square += value * value;
    }
    let (mean, count) = (sum / f64::from(samples), f64::from(samples));
    (mean, ((square / count - mean * mean).max(0.0) / count).sqrt())
}

/// Asserts that a mean is right within six standard errors and the rounding of 10^6 additions.
fn assert_mean((mean, error): (f64, f64), expected: f64, what: &str) {
    let off = (mean - expected).abs();
    assert!(
        off <= 6.0 * error + 1e6 * f64::EPSILON * expected.abs(),
        "{what}: {mean} +- {error}, not {expected}"
    );
}

/// Irradiance of a plane with a normal, red.
fn irradiance(lights: &Lights, from: &Point3<f64>, normal: &Vector3<f64>) -> (f64, f64) {
    mean(lights, from, 200_000, |s| s.radiance.x * s.direction.dot(normal).max(0.0) / s.pdf)
}

/// The integral of a function over the sphere, and its standard error: two directions in each of
/// many strata, whose difference tells the error.
fn integral(of: impl Fn(&Vector3<f64>) -> f64) -> (f64, f64) {
    let (rows, columns) = (250, 500);
    let mut random = PathRandom::new(9, 8, 7);
    let mut drawn = |row: u32, column: u32| {
        let [u, v] = random.pair();
        let height = 1.0 - 2.0 * (f64::from(row) + u) / f64::from(rows);
        let (sin, cos) = (TAU * (f64::from(column) + v) / f64::from(columns)).sin_cos();
        let radius = (1.0 - height * height).sqrt();
        of(&Vector3::new(radius * cos, radius * sin, height))
    };
    let angle = 2.0 * TAU / f64::from(rows * columns);
    let (mut sum, mut variance) = (0.0, 0.0);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |c| (row, c))) {
        let (a, b) = (drawn(row, column), drawn(row, column));
        sum += 0.5 * (a + b) * angle;
        variance += (0.5 * (a - b) * angle).powi(2);
    }
    (sum, variance.sqrt())
}

/// One light of every kind that rays meet, and all together, one behind another.
fn all_kinds() -> [(&'static str, Lights); 8] {
    let many = [ceiling(), ball(2.5, 1.0), sun(0.4)];
    [
        ("rectangle", lights(&[ceiling()], None)),
        ("sphere", lights(&[ball(1.5, 0.7)], None)),
        ("disc", lights(&[sun(0.5)], None)),
        ("half of the sky", lights(&[sun(FRAC_PI_2)], None)),
        ("constant", lights(&[], Some(Sky::Constant(RED)))),
        ("gradient", lights(&[], Some(gradient()))),
        ("map", lights(&[], Some(map()))),
        ("all", lights(&many, Some(map()))),
    ]
}

#[test]
fn densities_have_the_integral_1() {
    let from = Point3::new(0.1, -0.2, 0.3);
    for (name, lights) in all_kinds() {
        assert_mean(integral(|direction| seen(&lights, &from, direction).pdf), 1.0, name);
    }
}

#[test]
fn samples_and_rays_find_the_same_irradiance() {
    let normal = Vector3::new(0.6, 0.0, 0.8);
    // Under the ceiling, and over it, from where its back is turned.
    for from in [Point3::new(0.1, -0.2, 0.3), Point3::new(0.1, 0.2, 4.0)] {
        for (name, lights) in all_kinds() {
            let of =
                |d: &Vector3<f64>| seen(&lights, &from, d).radiance.x * d.dot(&normal).max(0.0);
            let (expected, error) = integral(of);
            let (mean, own) = irradiance(&lights, &from, &normal);
            assert_mean((mean, own.hypot(error)), expected, name);
        }
    }
}

#[test]
fn samples_have_the_radiance_and_the_density_of_what_rays_meet() {
    let from = Point3::new(0.3, 0.1, -0.5);
    let all = [ceiling(), ball(2.5, 0.8), sun(0.1), ball(1.0, 0.2)];
    for lights in [lights(&all, Some(map())), lights(&all, Some(gradient())), lights(&all, None)] {
        let mut random = PathRandom::new(3, 1, 4);
        let mut met = 0;
        for _ in 0..20_000 {
            let Some(sample) = lights.sample(&from, &mut random) else { continue };
            let LightSample { direction, distance, radiance, pdf, delta } = sample;
            assert_eq!(LightHit { distance, radiance, pdf }, seen(&lights, &from, &direction));
            assert!(!delta && (direction.norm() - 1.0).abs() < 1e-14);
            let ray = Ray { origin: from, direction, time: 0.0 };
            assert_eq!(lights.hit(&ray, distance), None);
            met += u32::from(distance.is_finite());
        }
        assert!(met > 5000, "{met}");
    }
}

#[test]
fn a_point_and_a_beam_are_delta_lights() {
    let position = Point3::new(0.0, 3.0, 4.0);
    let point = lights(&[Light::Point { position, intensity: RED }], None);
    let (origin, mut random) = (Point3::origin(), PathRandom::new(0, 0, 0));
    let sample = point.sample(&origin, &mut random).expect("light");
    assert!((sample.radiance - RED / 25.0).norm() < 1e-15);
    assert!((sample.direction - Vector3::new(0.0, 0.6, 0.8)).norm() < 1e-15);
    assert_eq!((sample.distance, sample.pdf, sample.delta), (5.0, 1.0, true));
    assert_eq!(point.sample(&position, &mut random), None);
    let beam = lights(&[sun(0.0), ceiling()], None);
    let (below, aside) = (Point3::origin(), Point3::new(50.0, 0.0, 0.0));
    let delta = |from: &Point3<f64>, random: &mut PathRandom| {
        let of_beam = |_| beam.sample(from, random).filter(|sample| sample.delta);
        (0..100).filter_map(of_beam).collect::<Vec<_>>()
    };
    // The rectangle is in the way of the beam.
    assert_eq!(delta(&below, &mut random), []);
    let sample = delta(&aside, &mut random)[0];
    assert_eq!((sample.radiance, sample.distance, sample.pdf), (RED, f64::INFINITY, 0.5));
    assert_eq!(beam.escaped(&sample.direction).radiance, Vector3::zeros());
}

#[test]
fn irradiance_is_that_of_closed_formulas() {
    let origin = Point3::origin();
    // A ball over a plane: pi L sin^2 of its half angle.
    let one = lights(&[ball(2.0, 0.5)], None);
    assert_mean(irradiance(&one, &origin, &UP), PI * 3.0 / 16.0, "sphere");
    // A rectangle parallel to the plane, from below the corner of its quarters (Howell, C-1).
    let (x, y): (f64, f64) = (1.0 / 2.0, 1.5 / 2.0);
    let (a, b) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let factor = 2.0 / PI * (x / a * (y / a).atan() + y / b * (x / b).atan());
    let one = lights(&[ceiling()], None);
    assert_mean(irradiance(&one, &origin, &UP), 3.0 * PI * factor, "rectangle");
    assert_eq!(irradiance(&one, &Point3::new(0.0, 0.0, 3.0), &-UP).0, 0.0, "from behind");
    // Discs are given by the irradiance across them.
    for radius in [1e-6, 0.005, 0.5, FRAC_PI_2] {
        let toward = Vector3::new(0.3, 0.2, 0.9).normalize();
        let one = lights(&[sun(radius)], None);
        assert_mean(irradiance(&one, &origin, &toward), 3.0, "disc");
    }
    let sky = |sky: Sky| lights(&[], Some(sky));
    let side = Vector3::new(0.6, 0.0, 0.8);
    assert_mean(irradiance(&sky(Sky::Constant(RED)), &origin, &side), PI * 3.0, "constant");
    // The integral of (h + (z - h) s) s over the half space, s the sine of the elevation.
    let expected = TAU * (4.0 / 2.0 + (1.0 - 4.0) / 3.0);
    assert_mean(irradiance(&sky(gradient()), &origin, &UP), expected, "gradient");
    assert_mean(irradiance(&sky(gradient()), &origin, &-UP), PI * 0.5, "ground");
}

#[test]
fn lights_that_hide_each_other_are_weighed_right() {
    // All that is seen has one radiance, whatever hides what.
    let sky = Some(Sky::Constant(RED));
    let all = lights(&[ceiling(), ball(2.5, 1.0), ball(1.0, 0.3), ball(-1.0, 0.9)], sky);
    assert_mean(irradiance(&all, &Point3::origin(), &UP), PI * 3.0, "above");
    assert_mean(irradiance(&all, &Point3::new(0.1, 0.2, 3.6), &-UP), PI * 3.0, "from above");
}

#[test]
fn a_map_has_its_zenith_at_the_top_and_runs_to_the_right() {
    let mut pixels = vec![[0.0; 3]; 8 * 4];
    for (k, pixel) in pixels.iter_mut().enumerate() {
        *pixel = [k as f32 + 1.0; 3];
    }
    let map = SkyMap::new(8, 4, pixels, &UP, 0.0).expect("a map");
    let lights = lights(&[], Some(Sky::Map(map)));
    let pixel = |x: f64, y: f64, z: f64| {
        lights.escaped(&Vector3::new(x, y, z).normalize()).radiance.x - 1.0
    };
    assert_eq!(pixel(1.0, 0.1, 9.0), 3.0);
    assert_eq!(pixel(1.0, -0.1, 9.0), 4.0);
    assert_eq!(pixel(1.0, 0.1, 0.1), 8.0 + 3.0);
    // To the right of x is -y.
    assert_eq!(pixel(0.1, -1.0, 0.1), 8.0 + 5.0);
    assert_eq!(pixel(-1.0, -0.1, -0.1), 16.0 + 7.0);
    assert_eq!(pixel(-1.0, 0.1, -9.0), 24.0);
}

#[test]
fn the_one_bright_pixel_of_a_map_is_found() {
    let (width, height) = (64_u32, 32_u32);
    let mut pixels = vec![[0.0; 3]; 64 * 32];
    pixels[10 * 64 + 20] = [5.0, 6.0, 7.0];
    let map = SkyMap::new(width, height, pixels, &UP, 0.0).expect("a map");
    let lights = lights(&[], Some(Sky::Map(map)));
    let [top, bottom] = [10.0, 11.0].map(|k: f64| k * PI / 32.0);
    let angle = (top.cos() - bottom.cos()) * TAU / 64.0;
    let count = mean(&lights, &Point3::origin(), 10_000, |s| {
        assert_eq!(s.radiance, Vector3::new(5.0, 6.0, 7.0));
        assert!((s.pdf * angle - 1.0).abs() < 1e-12);
        1.0
    });
    assert_eq!(count.0, 1.0);
    // integral of cos sin = (sin^2 below - sin^2 above) / 2.
    let expected = 5.0 * TAU / 64.0 * 0.5 * (bottom.sin().powi(2) - top.sin().powi(2));
    assert_mean(irradiance(&lights, &Point3::origin(), &UP), expected, "one pixel");
}

#[test]
fn a_rotation_turns_the_map_counterclockwise() {
    let mut pixels = vec![[0.0; 3]; 64 * 32];
    pixels[16 * 64 + 32] = [1.0; 3];
    let map = SkyMap::new(64, 32, pixels, &UP, FRAC_PI_2).expect("a map");
    let lights = lights(&[], Some(Sky::Map(map)));
    assert_eq!(lights.escaped(&Vector3::new(0.01, 1.0, -0.01).normalize()).radiance.x, 1.0);
}

#[test]
fn what_is_no_light_is_refused() {
    let refused = |light: Light| assert!(Lights::new(&[light], None).is_err(), "{light:?}");
    let center = Point3::origin();
    for half_edges in [[Vector3::x(), Vector3::x()], [Vector3::x(), Vector3::y() * f64::NAN]] {
        refused(Light::Rectangle { center, half_edges, radiance: RED });
    }
    refused(Light::Sphere { center, radius: 0.0, radiance: RED });
    refused(Light::Sphere { center, radius: 1.0, radiance: -RED });
    refused(Light::Point { position: Point3::new(0.0, f64::NAN, 0.0), intensity: RED });
    for angular_radius in [-0.1, 1e-9, 1.6, f64::NAN] {
        refused(sun(angular_radius));
    }
    refused(Light::Distant { toward: Vector3::zeros(), irradiance: RED, angular_radius: 0.0 });
    assert!(Lights::new(&[], Some(Sky::Constant(RED * f64::INFINITY))).is_err());
    let map = |width, height, pixel: [f32; 3]| {
        SkyMap::new(width, height, vec![pixel; 8], &UP, 0.0).map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(map(4, 2, [1.0; 3]), Ok(()));
    assert!(map(4, 3, [1.0; 3]).is_err_and(|e| e.contains("8 pixels are given for 4 x 3")));
    assert!(map(4, 2, [0.0; 3]).is_err_and(|e| e.contains("black")));
    assert!(map(4, 2, [f32::NAN, 1.0, 1.0]).is_err_and(|e| e.contains("row 0, column 0")));
    assert!(map(0, 2, [1.0; 3]).is_err_and(|e| e.contains("0 x 2")));
}

#[test]
fn nothing_is_seen_without_lights_or_from_inside() {
    let (origin, mut random) = (Point3::origin(), PathRandom::new(0, 0, 0));
    let none = lights(&[], None);
    assert_eq!(none.sample(&origin, &mut random), None);
    assert_eq!(none.escaped(&UP).radiance, Vector3::zeros());
    let inside = lights(&[ball(0.1, 1.0)], None);
    assert_eq!(inside.sample(&origin, &mut random), None);
    let ray = Ray { origin, direction: UP, time: 0.0 };
    assert_eq!(inside.hit(&ray, f64::INFINITY), None);
    let hit = lights(&[ceiling()], None).hit(&ray, 2.1).expect("the ceiling");
    assert_eq!((hit.distance, hit.radiance), (2.0, RED));
    // r^2 over the area and the cosine.
    assert!((hit.pdf - 4.0 / 6.0).abs() < 1e-15);
    assert_eq!(lights(&[ceiling()], None).hit(&ray, 2.0), None);
}
