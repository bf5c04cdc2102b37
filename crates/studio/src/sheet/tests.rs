use super::*;
use nalgebra::{Isometry3, Point3, Rotation3};
use rapunzel_collision::field::{Soup, shapes};
use rapunzel_export::{Frame, Strand};

/// A frame of three fibres that wave as time goes.
fn waving(index: usize) -> Frame {
    let time = index as f64 / 30.0;
    let strand = |segments: usize| {
        let at = |i: usize| 0.3 * i as f64 / segments as f64;
        let point =
            |i: usize| Point3::new(0.05 * (7.0 * at(i) + 3.0 * time).sin(), 0.01 * time, at(i));
        Strand {
            points: (0..=segments).map(point).collect(),
            radii: vec![40e-6; segments + 1],
            velocities: vec![Vector3::zeros(); segments + 1],
            frames: vec![Rotation3::identity(); segments],
            curvatures: vec![Vector3::zeros(); segments + 1],
            forces: vec![Vector3::zeros(); segments],
            contact_forces: vec![Vector3::zeros(); segments + 1],
            charges: vec![0.0; segments + 1],
        }
    };
    Frame { index, time, strands: [5, 8, 11].map(strand).to_vec() }
}

fn picture(frame: Frame) -> PreviewFrame {
    PreviewFrame::new(frame, Vec::new()).expect("a sound frame")
}

fn decode(bytes: &[u8]) -> (png::OutputInfo, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    (reader.next_frame(&mut pixels).expect("pixels"), pixels)
}

#[test]
fn a_sheet_is_a_png_with_dark_fibers_on_paper() {
    let frames: Vec<PreviewFrame> = (0..30).map(waving).map(picture).collect();
    let mut bytes = Vec::new();
    write(&mut bytes, &frames, &[], &[]).expect("a sheet");
    let (info, pixels) = decode(&bytes);
    assert!(info.width <= 1650 && info.height <= 1050, "{info:?}");
    let dark = pixels.chunks(3).filter(|p| p[0] < 130).count();
    assert!(dark > 2000, "{dark} pixels of fibres");
    assert_eq!(pixels[..3], [246, 245, 242], "paper in the corner");
    let mut again = Vec::new();
    write(&mut again, &frames, &[], &[]).expect("a sheet");
    assert_eq!(bytes, again);
}

#[test]
fn a_small_picture_is_as_large_as_asked() {
    let frame = picture(waving(0));
    for largest in [[480, 360], [100, 360], [480, 50]] {
        let mut bytes = Vec::new();
        write_small(&mut bytes, &frame, &[], largest).expect("a picture");
        let (info, pixels) = decode(&bytes);
        let most = largest.map(u32::from);
        let touches = info.width == most[0] || info.height == most[1];
        assert!(info.width <= most[0] && info.height <= most[1] && touches, "{info:?}");
        // A line of 2.2 pixels along what is 1/1.08 of the longer side, dark half of the way.
        let dark = pixels.chunks(3).filter(|p| p[0] < 130).count();
        assert!(dark as f64 > 0.5 * f64::from(info.width.max(info.height)) / 1.08, "{dark}");
    }
    let none = picture(Frame { strands: Vec::new(), ..waving(0) });
    let refused = write_small(&mut Vec::new(), &none, &[], [9, 9]);
    assert!(matches!(refused, Err(StudioError::Frame(ExportError::Empty))));
}

#[test]
fn odd_shapes_have_a_sheet() {
    let mut line = waving(0);
    for p in line.strands.iter_mut().flat_map(|s| &mut s.points) {
        (p.x, p.y) = (0.0, 0.0);
    }
    let mut dot = line.clone();
    dot.strands.iter_mut().flat_map(|s| &mut s.points).for_each(|p| p.z = 0.0);
    for frame in [line, dot] {
        let mut bytes = Vec::new();
        write(&mut bytes, &[picture(frame)], &[], &[]).expect("a sheet");
        assert!(decode(&bytes).0.width >= 20);
    }
    assert!(matches!(
        write(&mut Vec::new(), &[], &[], &[]),
        Err(StudioError::Frame(ExportError::Empty))
    ));
}

/// A wall hides what is behind it, and nothing of what is before it.
#[test]
fn surfaces_hide_what_is_behind_them() {
    let frame = picture(waving(0));
    let dark = |offset: f64| {
        let wall = [[-0.2, -0.1], [0.2, -0.1], [0.2, 0.5], [-0.2, 0.5]];
        let surface = Soup {
            vertices: wall.map(|[x, z]| Point3::new(x, offset - 0.05 * x, z)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let wall = vec![Placed { pose: Isometry3::identity(), surface }];
        let mut bytes = Vec::new();
        write(&mut bytes, std::slice::from_ref(&frame), &[wall], &[]).expect("a sheet");
        decode(&bytes).1.chunks(3).filter(|p| p[0].saturating_sub(p[2]) > 20).count()
    };
    let (before, behind) = (dark(-0.1), dark(0.1));
    // The three fibres lie on one curve of 0.3 m, in a picture of 0.65 m and 900 pixels, which they
    // cover wholly for a pixel of every row at least, half as dark where they are far.
    assert!(before == 0 && behind > 400, "{before}, {behind}");
    let two = [Vec::new(), Vec::new()];
    let refused = write(&mut Vec::new(), &[frame.clone(), frame.clone(), frame], &two, &[]);
    assert!(matches!(refused, Err(StudioError::Frame(ExportError::Surface { .. }))));
}

/// A far object is in the picture with all its corners: the scale is that of both.
#[test]
fn nothing_is_cut_off() {
    let frame = picture(waving(0));
    let surface = shapes::cuboid(Vector3::repeat(0.1));
    let far = Isometry3::translation(3.0, 0.0, 0.0);
    let vertices = surface.vertices.iter().map(|p| far * p).collect();
    let cuboid = Placed { pose: far, surface: Soup { vertices, ..surface } };
    let mut bytes = Vec::new();
    write(&mut bytes, &[frame], &[vec![cuboid]], &[]).expect("a sheet");
    let (info, pixels) = decode(&bytes);
    let blue = |p: &[u8]| p[2] > p[0].saturating_add(10);
    let columns = || pixels.chunks(3).enumerate().filter(|(_, p)| blue(p));
    let columns = columns().map(|(i, _)| i % info.width as usize);
    let (first, last) = columns.fold((usize::MAX, 0), |(a, b), x| (a.min(x), b.max(x)));
    assert!(first < last && last + 10 < info.width as usize, "{first} to {last}");
}

/// Bars and rings: more ink, and only near the points.
#[test]
fn what_holds_a_fiber_is_marked() {
    let sheet = |supports: Vec<Support>| {
        let picture = PreviewFrame::new(waving(0), supports)?;
        let mut bytes = Vec::new();
        write(&mut bytes, &[picture], &[], &[]).map(|()| decode(&bytes))
    };
    let support = |clamped| Support { strand: 1, point: 0, clamped };
    let (info, bare) = sheet(Vec::new()).expect("a sheet");
    let changed = |clamped| {
        let (_, pixels) = sheet(vec![support(clamped)]).expect("a sheet");
        let pairs = pixels.chunks(3).zip(bare.chunks(3)).enumerate();
        let rows = pairs.filter(|(_, (a, b))| a != b).map(|(i, _)| i / info.width as usize);
        rows.collect::<Vec<_>>()
    };
    for rows in [changed(true), changed(false)] {
        let (first, last) = (rows.iter().min().expect("some"), rows.iter().max().expect("some"));
        assert!((last - first) as f64 <= 2.0 * (MARK_OF_FEW + 2.0), "{first} to {last}");
    }
    assert_ne!(changed(true), changed(false));
    let nowhere = sheet(vec![Support { strand: 3, point: 0, clamped: true }]);
    assert!(matches!(nowhere, Err(StudioError::Frame(ExportError::Series { .. }))));
}

/// The dark pixels of a rose come where wind blows, and its arrow lies the way it blows.
#[test]
fn a_rose_shows_the_wind() {
    let frame = picture(waving(0));
    let sheet = |winds: &[Vector3<f64>]| {
        let mut bytes = Vec::new();
        write(&mut bytes, std::slice::from_ref(&frame), &[], winds).map(|()| decode(&bytes))
    };
    let calm = sheet(&[]).expect("a sheet");
    assert_eq!(sheet(&[Vector3::zeros()]).expect("a sheet").1, calm.1);
    let width = calm.0.width as usize;
    // Pixels that changed in a window below the upper right corner, left to right and down.
    let changed = |wind: Vector3<f64>| {
        let (_, pixels) = sheet(&[wind]).expect("a sheet");
        let pairs = pixels.chunks(3).zip(calm.1.chunks(3)).enumerate();
        let places = pairs.filter(|(_, (a, b))| a != b).map(|(i, _)| [i % width, i / width]);
        places.collect::<Vec<_>>()
    };
    let up = changed(Vector3::new(0.0, 0.0, 3.0));
    let down = changed(Vector3::new(0.0, 0.0, -3.0));
    assert!(up.len() > 100 && up.iter().all(|[x, _]| *x > width / 2), "{}", up.len());
    // Both arrows have their shafts in common; the heads lie at opposite ends.
    let only = |a: &[[usize; 2]], b: &[[usize; 2]]| {
        let rows: Vec<_> = a.iter().filter(|p| !b.contains(p)).map(|p| p[1] as f64).collect();
        rows.iter().sum::<f64>() / rows.len() as f64
    };
    assert!(only(&up, &down) + 5.0 < only(&down, &up));
    let refused = [vec![Vector3::x(); 2], vec![Vector3::repeat(f64::NAN)]];
    for winds in refused {
        assert!(matches!(sheet(&winds), Err(StudioError::Wind { .. })));
    }
}
