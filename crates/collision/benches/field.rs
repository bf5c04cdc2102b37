//! Values and gradients of a grid against a plain loop over a dense one, on the same lattice, and
//! against parry's signed distance to the triangles of the same ball.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Point3, Vector3};
use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::{TriMesh, TriMeshFlags};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rapunzel_collision::Capsule;
use rapunzel_collision::field::{
    Ball, ContactSearch, DistanceField, Grid, GridFrame, Sample, shapes,
};
use std::hint::black_box;

const RADIUS: f64 = 0.05;
const BAND: f64 = 4e-3;
const SIDE: usize = 128;
const SPACING: f64 = 0.14 / (SIDE - 1) as f64;
const POINTS: usize = 100_000;

/// What anyone would write first: one array, eight look-ups, doubles.
struct Dense {
    low: Point3<f64>,
    values: Vec<f32>,
}

impl Dense {
    fn new(field: &Ball, low: Point3<f64>) -> Self {
        let at = |n: usize| {
            let index = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)];
            field.value(&(low + SPACING * Vector3::from(index.map(|i| i as f64))))
        };
        #[expect(clippy::cast_possible_truncation, reason = "single precision is wanted")]
        let values = (0..SIDE.pow(3)).map(|n| at(n) as f32).collect();
        Self { low, values }
    }

    fn sample(&self, point: &Point3<f64>) -> Sample {
        let t = (point - self.low) / SPACING;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let [i, j, k] = [0, 1, 2].map(|a| t[a].clamp(0.0, (SIDE - 2) as f64) as usize);
        let (x, y, z) = (t.x - i as f64, t.y - j as f64, t.z - k as f64);
        let at = |n: usize| f64::from(self.values[(k * SIDE + j) * SIDE + i + n]);
        // Along x on the four edges, then along y on two faces, then along z.
        let edge = |n: usize| (at(n), at(n + 1) - at(n));
        let face = |n: usize| {
            let ((a, da), (b, db)) = (edge(n), edge(n + SIDE));
            let (low, high) = (a + x * da, b + x * db);
            (low + y * (high - low), da + y * (db - da), high - low)
        };
        let ((v0, x0, y0), (v1, x1, y1)) = (face(0), face(SIDE * SIDE));
        let gradient = Vector3::new(x0 + z * (x1 - x0), y0 + z * (y1 - y0), v1 - v0);
        Sample { value: v0 + z * (v1 - v0), gradient: gradient / SPACING }
    }
}

/// Points within a millimeter of a ball of 5 cm, in no order.
fn points() -> Vec<Point3<f64>> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut unit = || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
    let mut point = || {
        let direction = Vector3::new(unit(), unit(), unit()).normalize();
        Point3::from((RADIUS + 1e-3 * unit()) * direction)
    };
    (0..POINTS).map(|_| point()).collect()
}

fn queries(c: &mut Criterion) {
    let ball = Ball { center: Point3::origin(), radius: RADIUS };
    let low = Point3::from(Vector3::repeat(-0.07));
    let frame =
        GridFrame::new(low, Point3::from(Vector3::repeat(0.07)), SPACING).expect("a lattice");
    let grid = Grid::sample(&ball, frame, BAND).expect("a grid");
    let dense = Dense::new(&ball, low);
    let points = points();
    let mut samples = vec![Sample { value: 0.0, gradient: Vector3::zeros() }; POINTS];
    c.bench_function("plain loop/samples", |b| {
        b.iter(|| {
            for (sample, point) in samples.iter_mut().zip(&points) {
                *sample = dense.sample(point);
            }
            black_box(&mut samples);
        });
    });
    c.bench_function("field/samples one by one", |b| {
        b.iter(|| {
            for (sample, point) in samples.iter_mut().zip(&points) {
                *sample = grid.sample(point);
            }
            black_box(&mut samples);
        });
    });
    c.bench_function("field/samples at once", |b| {
        b.iter(|| grid.samples(black_box(&points), &mut samples));
    });
}

/// Points in single precision.
fn single(points: &[Point3<f64>]) -> Vec<Vector> {
    #[expect(clippy::cast_possible_truncation, reason = "parry's precision")]
    let single = |p: &Point3<f64>| Vector::new(p.x as f32, p.y as f32, p.z as f32);
    points.iter().map(single).collect()
}

/// The peer: 2048 triangles, as many as are shown of a ball.
fn parry(c: &mut Criterion) {
    let surface = shapes::sphere(RADIUS, 16);
    let vertices = single(&surface.vertices);
    let mesh = TriMesh::with_flags(vertices, surface.triangles, TriMeshFlags::ORIENTED);
    let (mesh, points) = (mesh.expect("a mesh"), single(&points()));
    let mut distances = vec![0.0; POINTS];
    c.bench_function("parry3d f32/samples", |b| {
        b.iter(|| {
            for (distance, point) in distances.iter_mut().zip(&points) {
                *distance = mesh.distance_to_local_point(*point, false);
            }
            black_box(&mut distances);
        });
    });
}

/// Segments of 3 mm near the ball, a third of them in touch: what a step does for every segment.
fn segments(c: &mut Criterion) {
    let ball = Ball { center: Point3::origin(), radius: RADIUS };
    let low = Point3::from(Vector3::repeat(-0.07));
    let frame =
        GridFrame::new(low, Point3::from(Vector3::repeat(0.07)), SPACING).expect("a lattice");
    let grid = Grid::sample(&ball, frame, BAND).expect("a grid");
    let points = points();
    let search = ContactSearch { margin: 5e-6, spacing: 0.3e-3, tolerance: 2e-6 };
    let axis = |ends: &[Point3<f64>]| {
        let direction = (ends[1] - ends[0]).normalize();
        Capsule { start: ends[0], end: ends[0] + 3e-3 * direction, radius: 35e-6 }
    };
    let capsules: Vec<_> = points.chunks_exact(2).take(1000).map(axis).collect();
    let mut contacts = Vec::new();
    c.bench_function("field/contacts of 1000 segments", |b| {
        b.iter(|| {
            contacts.clear();
            capsules.iter().for_each(|capsule| search.contacts(&grid, capsule, &mut contacts));
            black_box(contacts.len())
        });
    });
}

criterion_group!(benches, queries, parry, segments);
criterion_main!(benches);
