//! How pores are spread.

use super::{cap, flat, mesh, scan};
use nalgebra::{Point2, Point3};
use rapunzel_hairgen::growth::{DiscField, GreyImage, GrowthOptions, GrowthRegion, ScalpMesh};
use rapunzel_hairgen::{HairgenError, Pore};
use std::f64::consts::{FRAC_PI_2, PI};

fn region(scalp: ScalpMesh, density: DiscField) -> GrowthRegion {
    GrowthRegion::new(scalp, GrowthOptions { density, ..Default::default() }).expect("a region")
}

fn pores(region: &GrowthRegion, count: usize) -> Vec<Pore> {
    let pores = region.pores(count, 1).expect("pores");
    assert_eq!(pores.len(), count);
    pores
}

/// Distances to the nearest other pore, m.
fn nearest(pores: &[Pore]) -> Vec<f64> {
    let of = |(i, pore): (usize, &Pore)| {
        let others = pores.iter().enumerate().filter(|(j, _)| *j != i);
        let squared = others.map(|(_, other)| (other.position - pore.position).norm_squared());
        squared.fold(f64::INFINITY, f64::min).sqrt()
    };
    pores.iter().enumerate().map(of).collect()
}

/// The largest distance that so many points can all have on an area: that of a hexagonal lattice.
fn hexagonal(area: f64, count: usize) -> f64 {
    (2.0 * area / (3.0_f64.sqrt() * count as f64)).sqrt()
}

#[test]
fn pores_lie_on_the_scalp_at_their_places() {
    let region = region(mesh(cap(0.1, FRAC_PI_2, 40, 20)), DiscField::Constant(3e4));
    let (scalp, map) = (region.mesh(), region.map());
    assert!((region.count() as f64 - 3e4 * scalp.area()).abs() <= 0.5);
    for pore in pores(&region, region.count()) {
        let point = scalp.nearest(&pore.position);
        assert!((scalp.position(&point) - pore.position).norm() < 1e-16);
        assert!((map.place(&point) - pore.disc).norm() < 1e-12);
        assert!((scalp.normal(&point).into_inner() - pore.normal.into_inner()).norm() < 1e-9);
        assert!(pore.length == 0.2 && (pore.direction.norm() - 1.0).abs() < 1e-12);
    }
}

/// Blue noise: at random points the nearest of 3000 would be at about `1 / sqrt(n)` of the mean
/// spacing; here none is nearer than 0.6 of the hexagonal lattice's distance. Also for the first
/// ones.
#[test]
fn no_two_pores_are_near_and_no_two_of_the_first() {
    let region = region(mesh(cap(0.1, FRAC_PI_2, 40, 20)), DiscField::Constant(1e6));
    let area = region.mesh().area();
    let all = pores(&region, 4000);
    for first in [60, 500, 1000, 2500, 4000] {
        let distances = nearest(&all[..first]);
        let relative = distances.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        let relative = relative / hexagonal(area, first);
        let mean = distances.iter().sum::<f64>() / first as f64 / hexagonal(area, first);
        println!("{first} pores: least distance {relative:.3} of a lattice's, mean {mean:.3}");
        assert!(relative > 0.5 && mean > 0.7, "{first}: {relative}, {mean}");
    }
}

/// Counts in blocks of the disc against the integral of the density over the same faces.
fn check_blocks(region: &GrowthRegion, density: &DiscField, count: usize, side: usize) -> f64 {
    let (scalp, map) = (region.mesh(), region.map());
    let block = |p: &Point2<f64>| {
        let index = |x: f64| (0..side).rfind(|k| x >= 2.0 * *k as f64 / side as f64 - 1.0);
        index(p.y).unwrap_or(0) * side + index(p.x).unwrap_or(0)
    };
    let mut expected = vec![0.0; side * side];
    let parts = 40;
    for (face, area) in (0..).zip(scalp.areas()) {
        let [a, b, c] = map.corners(face);
        for k in 0..parts * parts {
            let [u, v] = [k % parts, k / parts].map(|i| (f64::from(i) + 0.5) / f64::from(parts));
            let [u, v] = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
            let place = a + u * (b - a) + v * (c - a);
            expected[block(&place)] += area * density.value(&place) / f64::from(parts * parts);
        }
    }
    let mut found = vec![0.0; side * side];
    for pore in pores(region, count) {
        found[block(&pore.disc)] += 1.0;
    }
    let whole: f64 = expected.iter().sum();
    let large = expected.iter().zip(found).map(|(e, f)| (e * count as f64 / whole, f));
    let large = large.filter(|(e, _)| *e > 1000.0);
    let errors: Vec<f64> = large.map(|(e, f)| (f / e - 1.0).abs()).collect();
    assert!(errors.len() >= 10, "{} blocks", errors.len());
    assert!((region.count() as f64 / whole - 1.0).abs() < 2e-3, "{} for {whole}", region.count());
    errors.iter().fold(0.0, |a, b| a.max(*b))
}

/// Rings and a slope, from nothing to white.
fn picture(side: usize) -> GreyImage {
    let value = |k: usize| {
        let [x, y] = [k % side, k / side].map(|i| (2.0 * i as f64 + 1.0) / side as f64 - 1.0);
        let wave = 0.5 + 0.5 * (9.0 * x.hypot(y)).cos();
        let grey = 255.0 * wave * (0.6 + 0.4 * x);
        (0..=255_u8).rfind(|v| f64::from(*v) <= grey).unwrap_or(0)
    };
    GreyImage::new(side, (0..side * side).map(value).collect()).expect("an image")
}

#[test]
fn pores_follow_the_image() {
    for name in super::SCALPS {
        let Some(scalp) = scan(name) else { continue };
        let white = 3.4e6;
        let density = DiscField::image(picture(128), 0.0, white);
        let region = region(scalp, density.clone());
        let worst = check_blocks(&region, &density, region.count(), 7);
        println!("{name}: {} pores, {:.2} % off in the worst block", region.count(), 100.0 * worst);
        assert!(worst < 0.03, "{worst}");
    }
}

#[test]
fn few_pores_have_the_proportions_of_many() {
    let density = DiscField::function(|p| 2e5 * (1.0 + 0.9 * p.x));
    let region = region(mesh(cap(0.1, FRAC_PI_2, 40, 20)), density.clone());
    let worst = check_blocks(&region, &density, 40_000, 5);
    println!("{:.2} % off in the worst block", 100.0 * worst);
    assert!(worst < 0.03, "{worst}");
    // The mean of a linear function over what is symmetric.
    let half = region.mesh().area();
    assert!((region.count() as f64 - 2e5 * half).abs() < 2.0);
}

#[test]
fn nothing_grows_where_the_image_is_black() {
    let spot = |p: &Point2<f64>| if (p - Point2::new(0.4, 0.0)).norm() < 0.1 { 1e6 } else { 0.0 };
    let region = region(mesh(flat(48, 20)), DiscField::function(spot));
    let expected = 1e6 * PI * 0.01;
    assert!((region.count() as f64 / expected - 1.0).abs() < 0.01, "{}", region.count());
    let found = pores(&region, 300);
    assert!(found.iter().all(|p| spot(&p.disc) > 0.0));
    let refused = region.pores(1_000_000, 1).expect_err("refused");
    assert!(matches!(refused, HairgenError::TooManyPores { count: 1_000_000, .. }));
}

#[test]
fn nothing_and_little_are_possible() {
    let nothing = region(mesh(flat(8, 2)), DiscField::Constant(0.0));
    assert_eq!((nothing.count(), nothing.pores(0, 1)), (0, Ok(vec![])));
    assert_eq!(nothing.pores(1, 1).expect_err("refused"), HairgenError::Bald { count: 1 });
    let some = region(mesh(flat(8, 2)), DiscField::Constant(1.0));
    for count in 1..20 {
        let found = pores(&some, count);
        assert!(found.iter().all(|p| p.position.coords.norm() <= 1.0 && p.position.y == 0.0));
    }
}

#[test]
fn bad_densities_and_lengths_are_told_with_the_place() {
    for bad in [-1.0, f64::NAN, f64::INFINITY, 1e12] {
        let density = DiscField::function(move |p| if p.x > 0.5 { bad } else { 1e3 });
        let options = GrowthOptions { density, ..Default::default() };
        let error = GrowthRegion::new(mesh(flat(8, 4)), options).expect_err("refused");
        let HairgenError::DiscValue { place: [x, _], .. } = error else { panic!("{error}") };
        assert!(x > 0.5);
    }
    for bad in [0.0, -0.1, f64::NAN, 200.0] {
        let (density, length) = (DiscField::Constant(1e2), DiscField::Constant(bad));
        let options = GrowthOptions { density, length, ..Default::default() };
        let region = GrowthRegion::new(mesh(flat(8, 4)), options).expect("a region");
        let error = region.pores(10, 1).expect_err("refused");
        assert!(matches!(error, HairgenError::DiscValue { what: "length (m)", .. }), "{error}");
    }
}

#[test]
fn a_seed_is_a_seed_on_any_number_of_threads() {
    let region = region(mesh(cap(0.1, FRAC_PI_2, 40, 20)), DiscField::Constant(1e5));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let alone = pool.install(|| region.pores(3000, 7));
    assert_eq!(alone, region.pores(3000, 7));
    assert_ne!(alone, region.pores(3000, 8));
}

#[test]
fn one_pore_is_where_it_is_asked_for() {
    let region = region(mesh(flat(8, 4)), DiscField::Constant(1e3));
    let pore = region.pore_near(&Point3::new(0.3, 2.0, 0.1)).expect("a pore");
    assert!((pore.position - Point3::new(0.3, 0.0, 0.1)).norm() < 1e-15);
    assert!((pore.disc - Point2::new(0.3, -0.1)).norm() < 1e-12);
}
