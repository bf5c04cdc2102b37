use crate::film::fill;
use exr::prelude::{
    FlatSamples, Image, ReadChannels as _, ReadLayers as _, SpecificChannels, Vec2,
    WritableImage as _, f16,
};
use nalgebra::{Point3, Vector3};
use rapunzel_render::{
    Film, FilmPixel, FilmSample, FirstSurface, Lights, PathRandom, RenderError, Sky, SkyMap, Tone,
    read_exr_map, write_exr, write_png,
};
use rayon::prelude::*;
use std::io::Cursor;

const UP: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);

fn picture() -> Film {
    let mut film = Film::new([13, 7]).expect("a film");
    fill(&mut film, 0..3);
    film
}

fn exr_of(film: &Film) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write_exr(&mut out, film).expect("a vector takes all");
    out.into_inner()
}

#[test]
fn an_exr_has_all_numbers_to_the_bit() {
    let mut film = picture();
    let surface = grey_surface();
    let huge = FilmSample { radiance: Vector3::repeat(1e40), surface: Some(surface) };
    film.rows_mut().for_each(|row| row[2].add(&huge));
    let bytes = exr_of(&film);
    assert_eq!(bytes, exr_of(&film), "files of one picture differ");
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .expect("an EXR");
    let layer = image.layer_data;
    assert_eq!((layer.size.0, layer.size.1), (13, 7));
    let channel = |name: &str| {
        let list = &layer.channel_data.list;
        let found = list.iter().find(|channel| channel.name == *name);
        &found.unwrap_or_else(|| panic!("no channel {name}")).sample_data
    };
    assert_eq!(layer.channel_data.list.len(), 12);
    let assert_channel = |name: &str, of: &dyn Fn(&FilmPixel) -> f64| {
        let FlatSamples::F32(read) = channel(name) else { panic!("{name} is not single") };
        assert_eq!(read.len(), film.pixels().len());
        for (x, pixel) in read.iter().zip(film.pixels()) {
            assert_eq!(x.to_bits(), single(of(pixel)).to_bits(), "{name}");
        }
    };
    assert_channel("R", &|p| p.radiance().x);
    assert_channel("G", &|p| p.radiance().y);
    assert_channel("B", &|p| p.radiance().z);
    assert_channel("A", &FilmPixel::coverage);
    assert_channel("albedo.R", &|p| p.albedo().x);
    assert_channel("albedo.G", &|p| p.albedo().y);
    assert_channel("albedo.B", &|p| p.albedo().z);
    assert_channel("normal.X", &|p| p.normal().x);
    assert_channel("normal.Y", &|p| p.normal().y);
    assert_channel("normal.Z", &|p| p.normal().z);
    assert_channel("depth.Z", &|p| p.depth().unwrap_or(f64::INFINITY));
    let fibers: Vec<u32> = film.pixels().iter().map(FilmPixel::fiber).collect();
    assert!(fibers.contains(&FilmPixel::NO_FIBER) && fibers.contains(&5));
    assert_eq!(*channel("fiber.id"), FlatSamples::U32(fibers));
}

/// In single precision, cut off at its largest number.
#[expect(clippy::cast_possible_truncation, reason = "the file is in single precision")]
fn single(x: f64) -> f32 {
    let narrow = x as f32;
    if x.is_finite() && narrow.is_infinite() { f32::MAX } else { narrow }
}

fn grey_surface() -> FirstSurface {
    FirstSurface { albedo: Vector3::repeat(0.5), normal: UP, depth: 2.0, fiber: 1 }
}

/// Radiance that a map shows from the middle of each of its pixels.
fn shown(map: SkyMap, width: u32, height: u32) -> Vec<Vector3<f64>> {
    let lights = Lights::new(&[], Some(Sky::Map(map))).expect("a sky");
    let middle = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n) * std::f64::consts::PI;
    let pixels = (0..height).flat_map(|row| (0..width).map(move |column| (row, column)));
    let of = |(row, column)| {
        let (polar, azimuth) = (middle(row, height), -2.0 * middle(column, width));
        let across = -Vector3::new(azimuth.cos(), azimuth.sin(), 0.0) * polar.sin();
        lights.escaped(&(across + UP * polar.cos())).radiance
    };
    pixels.map(of).collect()
}

#[test]
fn a_written_picture_is_read_as_a_map() {
    let film = picture();
    let map = read_exr_map(Cursor::new(exr_of(&film)), &UP, 0.0).expect("a map");
    let expected: Vec<_> = film.pixels().iter().map(FilmPixel::radiance).collect();
    for (a, b) in shown(map, 13, 7).iter().zip(&expected) {
        // Half a unit in the last place of single precision.
        assert!((a - b).amax() <= 0.5 * f64::from(f32::EPSILON) * b.amax());
    }
}

#[test]
fn maps_may_be_in_half_precision() {
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        [at.0 as f32, at.1 as f32, 0.5].map(f16::from_f32).into()
    });
    let mut out = Cursor::new(Vec::new());
    let image = Image::from_channels((4, 2), channels);
    image.write().to_buffered(&mut out).expect("a vector takes all");
    out.set_position(0);
    let map = read_exr_map(out, &UP, 0.0).expect("a map");
    assert_eq!(shown(map, 4, 2)[6], Vector3::new(2.0, 1.0, 0.5));
}

#[test]
fn what_is_no_map_is_refused() {
    let read = |bytes: &[u8]| read_exr_map(Cursor::new(bytes), &UP, 0.0);
    let good = exr_of(&picture());
    assert!(matches!(read(b"P6 not an exr"), Err(RenderError::SkyMap { .. })));
    for end in 0..good.len() {
        assert!(matches!(read(&good[..end]), Err(RenderError::SkyMap { .. })), "{end}");
    }
    // Damage that is not noticed may not do any, either.
    let (mut told, mut random) = (0, PathRandom::new(1, 1, 1));
    for at in 0..good.len() {
        let mut bytes = good.clone();
        bytes[at] ^= 1 << (at % 8);
        match read(&bytes) {
            Ok(map) => {
                let lights = Lights::new(&[], Some(Sky::Map(map))).expect("a sky");
                let sample = lights.sample(&Point3::origin(), &mut random);
                assert!(sample.is_none_or(|s| s.pdf.is_finite() && s.pdf > 0.0));
            }
            Err(_) => told += 1,
        }
    }
    assert!(told > good.len() / 2, "{told} of {}", good.len());
    let black = Film::new([2, 1]).expect("a film");
    assert!(read(&exr_of(&black)).is_err_and(|e| e.to_string().contains("black")));
}

fn decoded(bytes: &[u8]) -> (png::OutputInfo, bool, Vec<u8>) {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut pixels).expect("pixels");
    (info, reader.info().srgb.is_some(), pixels)
}

#[test]
fn a_png_has_the_means_through_the_curve() {
    let film = picture();
    for (tone, exposure) in [(Tone::Srgb, -1.0), (Tone::Filmic, 0.5)] {
        let mut bytes = Vec::new();
        write_png(&mut bytes, &film, tone, exposure, false).expect("a vector takes all");
        let (info, srgb, pixels) = decoded(&bytes);
        assert_eq!((info.width, info.height, info.color_type), (13, 7, png::ColorType::Rgb));
        assert!(srgb);
        for (bytes, pixel) in pixels.chunks_exact(3).zip(film.pixels()) {
            let expected = tone.encoded(&pixel.radiance(), exposure);
            let near = |(byte, x): (&u8, &f64)| (f64::from(*byte) - 255.0 * x).abs() <= 0.5;
            assert!(bytes.iter().zip(&expected).all(near), "{bytes:?} {expected:?}");
        }
    }
}

#[test]
fn a_transparent_png_has_straight_alpha() {
    let mut film = Film::new([2, 1]).expect("a film");
    let hit = |surface| FilmSample { radiance: Vector3::repeat(0.18), surface };
    let miss = FilmSample { radiance: Vector3::zeros(), surface: None };
    film.rows_mut().for_each(|row| {
        row[0].add(&hit(Some(grey_surface())));
        row[0].add(&miss);
        row[1].add(&miss);
    });
    let mut bytes = Vec::new();
    write_png(&mut bytes, &film, Tone::Srgb, 0.0, true).expect("a vector takes all");
    let (info, _, pixels) = decoded(&bytes);
    assert_eq!(info.color_type, png::ColorType::Rgba);
    // 0.18 is 117.6 of 255 by the curve of sRGB; half is covered.
    assert_eq!(pixels, [118, 118, 118, 128, 0, 0, 0, 0]);
    let refused = write_png(&mut bytes, &film, Tone::Srgb, f64::NAN, true);
    assert!(matches!(refused, Err(RenderError::Parameter { .. })));
}
