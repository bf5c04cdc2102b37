use nalgebra::Vector3;
use rapunzel_render::{
    Film, FilmKey, FilmPixel, FilmSample, FirstSurface, PathRandom, RenderError,
};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::io;

const SIZE: [u32; 2] = [40, 30];
const KEY: FilmKey = FilmKey { seed: 77, hash: [3; 32] };

/// The sample of a number of a pixel: pure noise.
pub(crate) fn noise(pixel: u64, number: u64) -> FilmSample {
    let mut random = PathRandom::new(KEY.seed, pixel, number);
    let mut vector = || Vector3::from([0; 3].map(|_| random.number()));
    let (radiance, albedo, normal, other) = (vector() * 4.0, vector(), vector(), vector());
    let fiber = u32::from(other.x > 0.5) * 5;
    let surface = FirstSurface { albedo, normal, depth: other.y, fiber };
    FilmSample { radiance, surface: (other.z > 0.25).then_some(surface) }
}

/// Adds the samples of the given numbers to every pixel.
pub(crate) fn fill(film: &mut Film, numbers: std::ops::Range<u64>) {
    let width = u64::from(film.size()[0]);
    film.rows_mut().enumerate().for_each(|(row, pixels)| {
        for (at, pixel) in (row as u64 * width..).zip(pixels) {
            numbers.clone().for_each(|number| pixel.add(&noise(at, number)));
        }
    });
}

fn filled(numbers: std::ops::Range<u64>) -> Film {
    let mut film = Film::new(SIZE).expect("a film");
    fill(&mut film, numbers);
    film
}

fn saved(film: &Film) -> Vec<u8> {
    let mut bytes = Vec::new();
    film.write_state(&mut bytes, &KEY).expect("a vector takes all");
    bytes
}

#[test]
fn a_pixel_has_the_means_of_its_samples() {
    let film = filled(0..50);
    let pixel = &film.pixels()[321];
    let samples: Vec<FilmSample> = (0..50).map(|number| noise(321, number)).collect();
    let surfaces: Vec<FirstSurface> = samples.iter().filter_map(|s| s.surface).collect();
    let close = |a: Vector3<f64>, b: Vector3<f64>| assert!((a - b).norm() < 1e-13, "{a} {b}");
    close(pixel.radiance(), samples.iter().map(|s| s.radiance).sum::<Vector3<f64>>() / 50.0);
    close(pixel.albedo(), surfaces.iter().map(|s| s.albedo).sum::<Vector3<f64>>() / 50.0);
    close(pixel.normal(), surfaces.iter().map(|s| s.normal).sum::<Vector3<f64>>() / 50.0);
    let depth = surfaces.iter().map(|s| s.depth).sum::<f64>() / surfaces.len() as f64;
    assert!((pixel.depth().expect("a depth") - depth).abs() < 1e-14);
    assert!((pixel.coverage() - surfaces.len() as f64 / 50.0).abs() < 1e-15);
    let first = samples[0].surface.map_or(FilmPixel::NO_FIBER, |s| s.fiber);
    assert_eq!((pixel.fiber(), pixel.samples(), pixel.rejected()), (first, 50, 0));
}

#[test]
fn the_standard_error_falls_as_theory_says() {
    let (some, more) = (filled(0..64), filled(64..576));
    let [of_some, of_more] = [&some, &more].map(|film| film.standard_error().expect("an error"));
    // Each color is even in [0, 4]: the variance of luminance is 16 / 12 of the squared weights.
    let weights = Vector3::<f64>::new(0.2126, 0.7152, 0.0722);
    let variance = weights.norm_squared() * 16.0 / 12.0;
    let expected = |count: f64| f64::sqrt(variance / count);
    // A variance of N numbers, less peaked than normal ones, is known to sqrt(2 / N), the mean of
    // 1200 to 35 times better; an error to half of that.
    for (error, count) in [(of_some, 64.0), (of_more, 512.0)] {
        let off = error / expected(count) - 1.0;
        assert!(off.abs() < 6.0 * 0.5 * f64::sqrt(2.0 / count / 1200.0), "{count}: {off}");
    }
    assert_eq!(filled(0..1).standard_error(), None);
    assert_eq!(filled(0..0).pixels()[0].radiance(), Vector3::zeros());
    assert_eq!(filled(0..0).pixels()[0].depth(), None);
}

#[test]
fn numbers_that_are_not_finite_are_counted_and_kept_out() {
    let mut film = filled(0..4);
    let before = film.clone();
    let good = noise(1, 2);
    let with = |x: f64| FilmSample { radiance: Vector3::new(1.0, x, 1.0), ..good };
    let surface = FirstSurface { depth: f64::NAN, ..noise(0, 0).surface.expect("a surface") };
    let bad = [
        with(f64::NAN),
        with(f64::INFINITY),
        // Its square is infinite.
        with(1e200),
        FilmSample { surface: Some(surface), ..good },
    ];
    film.rows_mut().for_each(|row| bad.iter().for_each(|sample| row[7].add(sample)));
    assert_eq!((film.rejected(), before.rejected()), (4 * 30, 0));
    for (now, then) in film.pixels().iter().zip(before.pixels()) {
        assert_eq!((now.radiance(), now.samples()), (then.radiance(), then.samples()));
        assert_eq!((now.standard_error(), now.depth()), (then.standard_error(), then.depth()));
    }
}

#[test]
fn a_picture_is_the_same_on_any_number_of_threads_and_after_a_stop() {
    let on = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        saved(&pool.install(|| filled(0..9)))
    };
    let whole = on(1);
    assert!(whole == on(3));
    let stopped = saved(&filled(0..5));
    let mut film = Film::read_state(&mut &stopped[..], &KEY).expect("a film");
    assert_eq!(film, filled(0..5));
    fill(&mut film, 5..9);
    assert!(saved(&film) == whole);
}

fn problem(result: Result<Film, RenderError>) -> &'static str {
    match result {
        Err(RenderError::PictureState { problem }) => problem,
        other => panic!("{other:?}"),
    }
}

#[test]
fn saved_pictures_that_are_damaged_or_foreign_are_refused() {
    let mut film = Film::new([3, 2]).expect("a film");
    fill(&mut film, 0..2);
    let bytes = saved(&film);
    let read = |bytes: &[u8]| Film::read_state(&mut &bytes[..], &KEY);
    for end in 0..bytes.len() {
        assert_eq!(problem(read(&bytes[..end])), "it is cut short");
    }
    for at in 0..bytes.len() {
        let mut bytes = bytes.clone();
        bytes[at] ^= 0x10;
        // A size that was changed may ask for more or less than there is.
        assert!(read(&bytes).is_err(), "byte {at}");
    }
    let mut damaged = bytes.clone();
    damaged[100] ^= 1;
    assert_eq!(problem(read(&damaged)), "it is damaged");
    for other in [FilmKey { seed: 78, ..KEY }, FilmKey { hash: [4; 32], ..KEY }] {
        let read = Film::read_state(&mut &bytes[..], &other);
        assert_eq!(problem(read), "it is of another scene or seed");
    }
    assert_eq!(problem(read(&[b'x'; 999])), "it is none of this version");
    // A size that is not there takes no memory.
    let mut large = bytes.clone();
    large[12..20].copy_from_slice(&[0, 64, 0, 0, 0, 64, 0, 0]);
    assert_eq!(problem(read(&large)), "it is cut short");
    large[12..20].copy_from_slice(&[255; 8]);
    assert!(matches!(read(&large), Err(RenderError::PictureSize { .. })));
}

#[test]
fn writers_and_readers_that_fail_are_told() {
    struct Broken;
    impl io::Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    impl io::Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::ErrorKind::TimedOut.into())
        }
    }
    let written = filled(0..1).write_state(&mut Broken, &KEY);
    assert!(matches!(written, Err(RenderError::Io(e)) if e.kind() == io::ErrorKind::StorageFull));
    let read = Film::read_state(&mut Broken, &KEY);
    assert!(matches!(read, Err(RenderError::Io(e)) if e.kind() == io::ErrorKind::TimedOut));
}

#[test]
fn pictures_that_cannot_be_held_are_refused() {
    for size in [[100_000, 100_000], [0, 5], [5, 0], [u32::MAX, u32::MAX], [1 << 28, 2]] {
        let error = Film::new(size).expect_err("no such picture");
        assert!(matches!(error, RenderError::PictureSize { .. }), "{size:?}");
    }
}
