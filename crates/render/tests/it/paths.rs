use crate::wavy::{RADIUS, wavy};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Section;
use rapunzel_render::{
    Camera, CurveForm, Curves, FiberCurve, FiberLook, Film, FilmKey, Hairs, Light, LightSearch,
    Lights, PathTracer, Projection, RenderScene, Sky, SkyMap, TriangleMesh,
};
use rapunzel_scattering::{
    ChiangField, CuticleTilt, FarField, FiberBsdf, FiberOptics, MarschnerField, NearField,
    ScatteringError,
};
use std::f64::consts::{FRAC_PI_4, PI};
use std::io::Cursor;

const UP: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);

fn grey(x: f64) -> Vector3<f64> {
    Vector3::repeat(x)
}

fn look(bsdf: Result<impl FiberBsdf + Send + Sync + 'static, ScatteringError>) -> FiberLook {
    FiberLook::Scattering { bsdf: Box::new(bsdf.expect("optics")), albedo: grey(0.5) }
}

fn optics(absorption: f64) -> FiberOptics {
    let sigma = Vector3::new(1.0, 1.5, 3.0) * absorption;
    FiberOptics::hair(sigma, 0.3, 0.3, 0.05).expect("in range")
}

/// A ball of triangles, smooth where it bends by less than a crease.
fn ball(center: Point3<f64>, radius: f64, fine: u32, crease: f64) -> TriangleMesh {
    let (rows, columns) = (fine, 2 * fine);
    let vertex = |k: u32, l: u32| {
        let (theta, phi) =
            (PI * f64::from(k) / f64::from(rows), PI * f64::from(l) / f64::from(fine));
        let flat = theta.sin();
        center + radius * Vector3::new(flat * phi.cos(), flat * phi.sin(), theta.cos())
    };
    let vertices = (0..=rows).flat_map(|k| (0..columns).map(move |l| vertex(k, l))).collect();
    let face = |k: u32, l: u32| {
        let [a, b] = [k * columns + l, k * columns + (l + 1) % columns];
        [[a, a + columns, b + columns], [a, b + columns, b]]
    };
    let faces = (0..rows).flat_map(|k| (0..columns).flat_map(move |l| face(k, l))).collect();
    TriangleMesh::new(vertices, faces, crease).expect("a ball")
}

fn ground(z: f64) -> TriangleMesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let vertices = corners.map(|[x, y]| Point3::new(x, y, z)).to_vec();
    TriangleMesh::new(vertices, vec![[0, 1, 2], [0, 2, 3]], 0.0).expect("a square")
}

fn hairs(look: FiberLook) -> Hairs {
    let curves = Curves::new(CurveForm::Cubic, None, &wavy(300, 24)).expect("sound");
    Hairs { curves, look }
}

fn camera() -> Camera {
    let view = Projection::Perspective { field_of_view: 0.3 };
    let (at, target) = (Point3::new(0.0, -0.48, 0.17), Point3::new(0.0, 0.0, 0.15));
    Camera::new(at, &target, &UP, view).expect("a camera")
}

fn tracer<'a>(scene: &'a RenderScene, camera: &'a Camera, order: Option<u32>) -> PathTracer<'a> {
    PathTracer { scene, camera, seed: 3, order, search: LightSearch::Both }
}

/// Mean luminance of a picture and its standard error.
fn mean(tracer: &PathTracer<'_>, samples: u32) -> [f64; 2] {
    let mut film = Film::new([16; 2]).expect("small");
    tracer.expose(&mut film, samples, &|| false);
    assert_eq!(film.rejected(), 0);
    let pixels = film.pixels();
    let of = |rgb: Vector3<f64>| rgb.dot(&Vector3::new(0.2126, 0.7152, 0.0722));
    let mean = pixels.iter().map(|p| of(p.radiance())).sum::<f64>() / pixels.len() as f64;
    let error = film.standard_error().expect("many samples") / (pixels.len() as f64).sqrt();
    [mean, error]
}

/// Scenes in which either way of looking for light finds all of it.
fn scenes() -> Vec<RenderScene> {
    let square = Light::Rectangle {
        center: Point3::new(0.1, -0.2, 0.3),
        half_edges: [Vector3::new(0.1, 0.0, 0.0), Vector3::new(0.0, -0.05, -0.1)],
        radiance: grey(9.0),
    };
    let bulb =
        Light::Sphere { center: Point3::new(-0.15, -0.1, 0.2), radius: 0.05, radiance: grey(6.0) };
    let behind =
        Light::Sphere { center: Point3::new(0.05, 0.2, 0.2), radius: 0.08, radiance: grey(6.0) };
    let sun = |angle| Light::Distant {
        toward: Vector3::new(1.0, -1.0, 1.0),
        irradiance: grey(2.0),
        angular_radius: angle,
    };
    let even = Sky::Constant(grey(0.5));
    let gradient =
        Sky::Gradient { zenith: grey(1.0), horizon: grey(0.3), ground: grey(0.05), up: UP };
    let spots = (0..128_u8).map(|k| [f32::from(k % 7), f32::from(k % 5), 0.5]).collect();
    let map = Sky::Map(SkyMap::new(16, 8, spots, &UP, 0.3).expect("a map"));
    let circle = Section::Circle { radius: RADIUS };
    let flat = Section::Ellipse { a: 30e-6, b: 40e-6 };
    let far = |absorption| look(FarField::new(optics(absorption)));
    let near = |absorption, section: &Section| look(NearField::new(optics(absorption), section));
    let chiang = |absorption| look(ChiangField::new(optics(absorption)));
    let lit = |lights: &[Light], sky: Option<Sky>| Lights::new(lights, sky).expect("lights");
    let hair = |look: FiberLook, lights: Lights| {
        RenderScene::new(vec![hairs(look)], Vec::new(), lights).expect("a scene")
    };
    let with = |look: FiberLook, bodies: Vec<(TriangleMesh, Vector3<f64>)>, lights: Lights| {
        RenderScene::new(vec![hairs(look)], bodies, lights).expect("a scene")
    };
    let head = || (ball(Point3::new(0.0, 0.05, 0.15), 0.04, 12, 1.0), grey(0.7));
    let colors = vec![Vector3::new(0.9, 0.5, 0.2); 300 * 24];
    vec![
        hair(far(0.0), lit(&[square], None)),
        hair(far(0.3), lit(&[bulb, square], None)),
        hair(near(0.1, &circle), lit(&[square], Some(even.clone()))),
        hair(near(0.1, &flat), lit(&[bulb], Some(gradient.clone()))),
        hair(chiang(0.1), lit(&[square], Some(even))),
        hair(chiang(0.5), lit(&[behind], None)),
        hair(look(MarschnerField::new(optics(0.2))), lit(&[sun(0.2)], Some(gradient))),
        with(far(0.1), vec![head(), (ground(0.0), grey(0.4))], lit(&[square, bulb], None)),
        with(chiang(0.1), vec![head()], lit(&[], Some(map))),
        with(FiberLook::Colored(colors), vec![(ground(0.0), grey(0.4))], lit(&[square], None)),
    ]
}

/// Next-event estimation alone, paths alone and both together find the same light.
#[test]
fn all_ways_of_looking_for_light_agree() {
    let camera = camera();
    for (number, scene) in scenes().iter().enumerate() {
        let by = |search| mean(&PathTracer { search, ..tracer(scene, &camera, None) }, 256);
        let [both, lights, onward] =
            [LightSearch::Both, LightSearch::Lights, LightSearch::Onward].map(by);
        for [other, error] in [lights, onward] {
            let spread = error.hypot(both[1]);
            // Chance of a deviation this large in one of twenty comparisons: 1e-4.
            assert!((other - both[0]).abs() < 4.6 * spread, "scene {number}: {other} {both:?}");
            assert!(spread < 0.1 * both[0], "scene {number} tells too little: {spread} {both:?}");
        }
    }
}

/// White hair and a white head in even light cannot be seen.
#[test]
fn what_is_white_in_even_light_is_not_seen() {
    let lights = || Lights::new(&[], Some(Sky::Constant(grey(0.7)))).expect("a sky");
    let camera = camera();
    let white = FiberOptics { tilt: CuticleTilt::NONE, ..optics(0.0) };
    for (name, look) in [
        ("far", look(FarField::new(optics(0.0)))),
        ("chiang", look(ChiangField::new(white))),
        ("matte", FiberLook::Colored(vec![Vector3::repeat(1.0); 300 * 24])),
    ] {
        let head = (ball(Point3::new(0.0, 0.05, 0.15), 0.04, 12, 0.0), grey(1.0));
        let scene = RenderScene::new(vec![hairs(look)], vec![head], lights()).expect("a scene");
        let [mean, error] = mean(&tracer(&scene, &camera, None), 256);
        // The lobes of far hair keep their energy to 7e-6 at every event, of which there are few.
        assert!((mean - 0.7).abs() < 5.0 * error + 1e-4, "{name}: {mean} {error}");
    }
}

/// Inside a ball whose walls keep a part of the light, every wall gets what the lamp sends and all
/// that is sent back: `E = I / (R^2 (1 - albedo))`.
#[test]
fn the_energy_of_a_closed_ball_is_balanced() {
    let (albedo, radius, intensity) = (0.75, 0.5, 2.0);
    let lamp = Light::Point { position: Point3::origin(), intensity: grey(intensity) };
    let lights = Lights::new(&[lamp], None).expect("a lamp");
    let walls = vec![(ball(Point3::origin(), radius, 64, 1.0), grey(albedo))];
    let scene = RenderScene::new(Vec::new(), walls, lights).expect("a scene");
    let view = Projection::Perspective { field_of_view: 2.0 };
    let camera = Camera::new(Point3::new(0.1, 0.0, 0.0), &Point3::new(1.0, 1.0, 0.0), &UP, view);
    let [mean, error] = mean(&tracer(&scene, &camera.expect("a camera"), None), 256);
    let exact = albedo / PI * intensity / (radius * radius * (1.0 - albedo));
    // Facets are nearer to the lamp than the ball, by 1 - cos(pi / 64) at most.
    let coarse = 2.0 * (1.0 - (PI / 64.0).cos());
    assert!((mean / exact - 1.0).abs() < 5.0 * error / exact + coarse, "{mean} {exact} {error}");
}

/// What an order leaves out is what pictures with it and without it differ by.
#[test]
fn what_an_order_leaves_out_is_told() {
    let (scene, camera) = (&scenes()[1], camera());
    let of = |order| tracer(scene, &camera, order).left_out([16, 16], 64);
    assert_eq!(of(None), 0.0);
    let orders = [0, 1, 4, 16].map(|order| of(Some(order)));
    // A path adds light with every event, and both go the same way.
    assert!(orders.windows(2).all(|pair| pair[1] <= pair[0]), "{orders:?}");
    assert!(orders[0] > orders[1] && orders[1] > 0.0, "{orders:?}");
}

/// A matte tube in light from the camera: radiance is the cosine, whose mean over the width is a
/// quarter of pi.
#[test]
fn a_matte_tube_is_the_cylinder() {
    let nodes = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|z| Point3::new(0.0, 0.0, z)).to_vec();
    let fiber = [FiberCurve::round(nodes, 1e-3)];
    let curves = Curves::new(CurveForm::Cubic, None, &fiber).expect("sound");
    let look = FiberLook::Colored(vec![Vector3::repeat(0.5); 5]);
    let irradiance = grey(3.0);
    let light = Light::Distant { toward: -Vector3::y(), irradiance, angular_radius: 0.0 };
    let lights = Lights::new(&[light], None).expect("a light");
    let scene = RenderScene::new(vec![Hairs { curves, look }], Vec::new(), lights).expect("sound");
    let view = Projection::Orthographic { width: 2e-3 };
    let camera = Camera::new(Point3::new(0.0, -1.0, 0.0), &Point3::origin(), &UP, view);
    let [mean, error] = mean(&tracer(&scene, &camera.expect("a camera"), Some(0)), 256);
    let exact = 0.5 / PI * 3.0 * FRAC_PI_4;
    assert!((mean - exact).abs() < 5.0 * error, "{mean} {exact} {error}");
}

/// One thread, two threads, and a picture that was stopped, saved and taken up again: the same
/// bits.
#[test]
fn a_picture_is_the_same_bits_however_it_is_made() {
    let scene = &scenes()[2];
    let camera = camera();
    let tracer = tracer(scene, &camera, Some(4));
    let size = [24, 16];
    let on = |threads: usize, samples: u32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let mut film = Film::new(size).expect("small");
        pool.install(|| tracer.expose(&mut film, samples, &|| false));
        film
    };
    let whole = on(1, 12);
    assert_eq!(on(2, 12), whole);
    let key = FilmKey { seed: 3, hash: [7; 32] };
    let (mut film, rows) = (on(2, 5), std::sync::atomic::AtomicU32::new(0));
    // Stopped after some rows.
    let stop = || rows.fetch_add(1, std::sync::atomic::Ordering::Relaxed) > 6;
    tracer.expose(&mut film, 9, &stop);
    assert!(film.pixels().iter().any(|p| p.samples() == 5));
    assert!(film.pixels().iter().any(|p| p.samples() == 9));
    let mut file = Vec::new();
    film.write_state(&mut file, &key).expect("memory");
    let mut film = Film::read_state(&mut Cursor::new(file), &key).expect("our own");
    tracer.expose(&mut film, 12, &|| false);
    assert_eq!(film, whole);
}
