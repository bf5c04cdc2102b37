//! Guides and hairs between two balls; on one thread except where the name says two.

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use nalgebra::{Point2, Point3, Unit, Vector3};
use rapunzel_collision::field::Ball;
use rapunzel_hairgen::{
    DensityModel, GuideOptions, HairDensity, HairOptions, HairPattern, Pore, PreGuide, Region,
    VoxelFrame, dips_by_height, grow_hairs, grow_pre_guides, place_guides,
};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::f64::consts::{FRAC_PI_2, PI};
use std::hint::black_box;

const HEAD: Ball = Ball { center: Point3::new(0.0, 0.0, 0.0), radius: 0.09 };
const HULL: Ball = Ball { center: Point3::new(0.0, 0.0, 0.0), radius: 0.115 };
const BALLS: Region<'_> = Region { head: &HEAD, hull: &HULL };

/// Pores down to a little below the equator, whose hair leaves the top.
fn pores(count: usize) -> Vec<Pore> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let pore = |i: usize| {
        let height = 1.0 - 1.17 * (i as f64 + 0.5) / count as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let across = (1.0 - height * height).sqrt();
        let normal = Vector3::new(across * cos, height, across * sin);
        let south = Vector3::new(height * cos, -across, height * sin);
        let polar = 0.9 * height.acos() / FRAC_PI_2;
        Pore {
            position: Point3::from(normal * HEAD.radius),
            normal: Unit::new_normalize(normal),
            direction: Unit::new_normalize(normal * 0.36 + south * 0.93),
            length: 0.08,
            disc: Point2::new(polar * cos, polar * sin),
        }
    };
    (0..count).map(pore).collect()
}

fn pre_guides(options: &GuideOptions) -> Vec<PreGuide> {
    let pores = pores(300);
    let heights: Vec<f64> = pores.iter().map(|pore| pore.position.y).collect();
    let dips = dips_by_height(&heights, 0.1, 0.6);
    grow_pre_guides(&pores, &dips, BALLS, options).expect("pre-guides")
}

fn threads(count: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(count).build().expect("threads")
}

fn guides(c: &mut Criterion) {
    let options = GuideOptions::default();
    let one = threads(1);
    let mut group = c.benchmark_group("guides");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.bench_function("300 pre-guides", |b| {
        b.iter(|| one.install(|| pre_guides(black_box(&options))));
    });
    let pre = pre_guides(&options);
    let pores = pores(100);
    group.bench_function("100 guides", |b| {
        b.iter(|| one.install(|| place_guides(&pores, &pre, BALLS, None, &options)));
    });
    let corner = Point3::new(0.13, 0.13, 0.13);
    let frame = VoxelFrame::new(-corner, corner, 0.004).expect("voxels");
    group.bench_function("100 guides with density", |b| {
        b.iter(|| {
            let mut density = HairDensity::new(frame, DensityModel::Continuous { most: 0.5 });
            one.install(|| place_guides(&pores, &pre, BALLS, Some(&mut density), &options))
        });
    });
    group.finish();
}

/// The thesis's first style: 90,000 hairs of 50 points along 3,000 guides.
fn hairs(c: &mut Criterion) {
    let options = GuideOptions { equilibria: 10, ..GuideOptions::default() };
    let two = threads(2);
    let pre = pre_guides(&options);
    let own = pores(3000);
    let guides = place_guides(&own, &pre, BALLS, None, &options).expect("guides").guides;
    let mut group = c.benchmark_group("hairs");
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    let patterns = [
        ("in wisps", HairPattern::Wisps { tip: 0.3, turns: 1.0 }),
        ("between", HairPattern::Between),
    ];
    for count in [9000, 90_000] {
        let pores = pores(count);
        for (name, pattern) in patterns {
            let options = HairOptions { pattern, ..HairOptions::default() };
            group.bench_function(format!("{count} {name} on two threads"), |b| {
                b.iter(|| two.install(|| grow_hairs(&pores, &guides, &own, BALLS, &options)));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, guides, hairs);
criterion_main!(benches);
