//! Grey images and what they mean on the disc.

use nalgebra::{Point2, Vector2};
use png::{BitDepth, ColorType, Encoder};
use proptest::prelude::*;
use rapunzel_hairgen::HairgenError;
use rapunzel_hairgen::growth::{DiscField, GreyImage};
use std::f64::consts::TAU;

/// A PNG of some bytes.
pub(crate) fn png(size: [u32; 2], color: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == ColorType::Indexed {
        encoder.set_palette(vec![0; 6]);
    }
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(data).expect("pixels");
    writer.finish().expect("written");
    bytes
}

#[test]
fn grey_and_equal_colors_are_read() {
    let grey = png([2, 2], ColorType::Grayscale, BitDepth::Eight, &[0, 51, 102, 255]);
    let image = GreyImage::from_png(&grey).expect("an image");
    let colors: Vec<u8> = [0, 51, 102, 255].iter().flat_map(|v| [*v; 3]).collect();
    let colored = png([2, 2], ColorType::Rgb, BitDepth::Eight, &colors);
    assert_eq!(GreyImage::from_png(&colored), Ok(image.clone()));
    assert_eq!(GreyImage::new(2, vec![0, 51, 102, 255]), Ok(image.clone()));
    // The first row is at the top.
    let at = |x: f64, y: f64| image.value(&Point2::new(x, y));
    assert_eq!(at(-0.5, 0.5), 0.0);
    assert_eq!(at(0.9, 0.9), 0.2);
    assert_eq!(at(-7.0, -7.0), 0.4);
    assert_eq!(at(0.5, -0.5), 1.0);
    assert!((at(0.0, 0.0) - 0.4).abs() < 1e-15);
    assert!(at(f64::NAN, 0.0).is_finite());
}

#[test]
fn other_images_are_refused_and_told() {
    let refused = |bytes: &[u8]| GreyImage::from_png(bytes).expect_err("refused");
    let eight = BitDepth::Eight;
    let size = refused(&png([3, 2], ColorType::Grayscale, eight, &[0; 6]));
    assert_eq!(size, HairgenError::ImageSize { width: 3, height: 2 });
    let size = refused(&png([1, 1], ColorType::Grayscale, eight, &[0]));
    assert_eq!(size, HairgenError::ImageSize { width: 1, height: 1 });
    let large = vec![0; 5000 * 5000];
    let size = refused(&png([5000, 5000], ColorType::Grayscale, eight, &large));
    assert_eq!(size, HairgenError::ImageSize { width: 5000, height: 5000 });
    let kinds = [
        (png([2, 2], ColorType::Grayscale, BitDepth::Sixteen, &[0; 8]), "16 bits"),
        (png([2, 2], ColorType::Grayscale, BitDepth::Four, &[0; 2]), "4 bits"),
        (png([2, 2], ColorType::Indexed, eight, &[0; 4]), "palette"),
        (png([2, 2], ColorType::Rgba, eight, &[0; 16]), "transparency"),
        (png([2, 2], ColorType::GrayscaleAlpha, eight, &[0; 8]), "transparency"),
        (png([2, 2], ColorType::Rgb, eight, &[0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]), "colors"),
    ];
    for (bytes, what) in kinds {
        let error = refused(&bytes);
        assert!(matches!(error, HairgenError::ImageKind { .. }), "{error}");
        assert!(error.to_string().contains(what), "{error}");
    }
    let whole = png([2, 2], ColorType::Grayscale, eight, &[0; 4]);
    for bytes in [&b""[..], b"JFIF", &whole[..whole.len() / 2]] {
        assert!(matches!(refused(bytes), HairgenError::ImageFile { .. }));
    }
    assert!(GreyImage::new(0, vec![]).is_err() && GreyImage::new(2, vec![0; 6]).is_err());
}

#[test]
fn directions_mix_over_the_full_turn() {
    // Just less than a full turn beside none: between them it is about none, not half a turn.
    let image = GreyImage::new(2, vec![254, 0, 254, 0]).expect("an image");
    let field = DiscField::image(image, 0.0, TAU);
    let middle = field.direction(&Point2::origin()).normalize();
    assert!(middle.dot(&Vector2::x()) > 0.999, "{middle}");
    let wrong = DiscField::Constant(field.value(&Point2::origin()));
    assert!(wrong.direction(&Point2::origin()).dot(&Vector2::x()) < -0.999);
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        // With the signature of a PNG before them, and into a good one.
        let mut signed = vec![0x89, b'P', b'N', b'G', 13, 10, 26, 10];
        signed.extend(&bytes);
        let good = png([2, 2], ColorType::Grayscale, BitDepth::Eight, &[0; 4]);
        let mut changed = good.clone();
        for two in bytes.chunks_exact(2) {
            let place = usize::from(two[0]) % changed.len();
            changed[place] = two[1];
        }
        prop_assert!(GreyImage::from_png(&signed).is_err());
        if let Ok(image) = GreyImage::from_png(&changed) {
            prop_assert!(image.side() >= 2);
        }
    }

    #[test]
    fn values_lie_between_black_and_white(
        pixels in prop::collection::vec(any::<u8>(), 16),
        place in prop::array::uniform2(-1.5..1.5_f64),
        ends in prop::array::uniform2(-5.0..5.0_f64),
    ) {
        let image = GreyImage::new(4, pixels).expect("an image");
        let value = DiscField::image(image, ends[0], ends[1]).value(&Point2::from(place));
        let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        prop_assert!((low - 1e-12..=high + 1e-12).contains(&value));
    }
}
