//! Styles of files and numbers with faults: mended and told, or refused with what to do.

use crate::growth::image::png;
use nalgebra::{Point3, Vector3};
use png::{BitDepth, ColorType};
use rapunzel_collision::field::{Repairs, Soup, shapes};
use rapunzel_hairgen::HairgenError;
use rapunzel_hairgen::fit::FitOptions;
use rapunzel_hairgen::head::{HairVolume, HeadMeasures, ParametricHead};
use rapunzel_hairgen::style::{HairSource, Hairstyle, HeadSource, ScalpField, Style};
use std::io;
use std::path::Path;

const HEAD: f64 = 0.095;
const HULL: f64 = 0.125;

/// Files by their names.
type Files = Vec<(&'static str, Vec<u8>)>;

/// A mesh as OBJ, its numbers to the last bit.
fn obj(soup: &Soup) -> Vec<u8> {
    let point = |p: &Point3<f64>| format!("v {} {} {}\n", p.x, p.y, p.z);
    let face = |t: &[u32; 3]| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    let vertices: String = soup.vertices.iter().map(point).collect();
    let faces: String = soup.triangles.iter().map(face).collect();
    (vertices + &faces).into_bytes()
}

fn ball(radius: f64) -> Soup {
    shapes::sphere(radius, 24)
}

/// The part of a ball above the level of its middle.
fn cap(radius: f64) -> Soup {
    let mut cap = ball(radius);
    let vertices = &cap.vertices;
    cap.triangles.retain(|t| t.iter().all(|&v| vertices[v as usize].y > -1e-9));
    cap
}

fn moved(mut soup: Soup, by: Vector3<f64>) -> Soup {
    soup.vertices.iter_mut().for_each(|p| *p += by);
    soup
}

fn scaled(mut soup: Soup, by: f64) -> Soup {
    soup.vertices.iter_mut().for_each(|p| *p *= by);
    soup
}

/// Two meshes in one.
fn both(mut a: Soup, b: &Soup) -> Soup {
    let count = u32::try_from(a.vertices.len()).expect("few");
    a.vertices.extend(&b.vertices);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + count)));
    a
}

fn turned(mut soup: Soup, every: usize) -> Soup {
    soup.triangles.iter_mut().step_by(every).for_each(|t| t.swap(1, 2));
    soup
}

/// Short hair between balls.
fn balls() -> Style {
    Style {
        head: HeadSource::Mesh { file: "head.obj".into(), hairline: Default::default() },
        hair: HairSource::Solid("hair.obj".into()),
        hairs: Some(100),
        guides: 20,
        length: ScalpField::Constant(0.05),
        ..Style::default()
    }
}

/// The files of [`balls`], some of them in place of the good ones.
fn files(others: Files) -> Files {
    let mut files = others;
    files.extend([("head.obj", obj(&ball(HEAD))), ("hair.obj", obj(&ball(HULL)))]);
    files
}

fn grow(style: &Style, others: Files) -> Result<Hairstyle, HairgenError> {
    let files = files(others);
    let read = |path: &Path| {
        let file = files.iter().find(|(name, _)| Path::new(name) == path);
        file.map(|(_, bytes)| bytes.clone()).ok_or_else(|| io::ErrorKind::NotFound.into())
    };
    style.grow(&read, &|_| {})
}

fn refused(style: &Style, others: Files) -> HairgenError {
    grow(style, others).expect_err("refused")
}

/// What a user reads.
fn said(style: &Style, others: Files) -> String {
    refused(style, others).to_string()
}

#[test]
fn good_files_grow_and_need_nothing() {
    let Hairstyle { report, .. } = grow(&balls(), vec![]).expect("a style");
    assert_eq!((&report.mended[..], &report.crossed[..]), (&[][..], &[][..]));
    assert_eq!((report.bare, report.hairs.in_head), (0.0, 0));
    assert!((report.asked - 100.0 * 0.05).abs() < 1e-12 && report.scalp_off < 1e-3);
    assert!(report.hairs.length > 0.8 * report.asked, "{report}");
}

#[test]
fn faults_of_solids_are_mended_and_told() {
    let faults = |radius: f64| {
        let good = ball(radius);
        let count = good.triangles.len();
        let mut open = good.clone();
        // The face at the lowest vertex and those around it.
        open.triangles.retain(|t| t.iter().any(|&v| good.vertices[v as usize].y > -0.9 * radius));
        let mut fin = good.clone();
        let [a, b, _] = fin.triangles[0];
        fin.triangles.push([a, b, u32::try_from(fin.vertices.len()).expect("few")]);
        fin.vertices.push(Point3::new(0.0, 1.5 * radius, 0.0));
        let corners = good.triangles.as_flattened().iter().map(|&v| good.vertices[v as usize]);
        let loose = Soup {
            vertices: corners.collect(),
            triangles: (0..).take(count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
        };
        let merged = loose.vertices.len() - good.vertices.len();
        let none = Repairs::default();
        [
            (open, Repairs { closed_holes: 1, ..none }),
            (turned(good.clone(), 7), Repairs { reversed_faces: count.div_ceil(7), ..none }),
            (turned(good, 1), Repairs { reversed_faces: count, ..none }),
            (fin, Repairs { non_manifold_faces: 3, closed_holes: 1, ..none }),
            (loose, Repairs { merged_vertices: merged, ..none }),
        ]
    };
    for (file, what, radius) in [("head.obj", "the head", HEAD), ("hair.obj", "the hair", HULL)] {
        for (soup, repairs) in faults(radius) {
            let grown = grow(&balls(), vec![(file, obj(&soup))]).expect("mended");
            assert_eq!(grown.report.mended, [(what, repairs)]);
            assert!(grown.report.to_string().contains(&format!("mended      {what}: {repairs}")));
            assert_eq!(grown.report.hairs.in_head, 0, "{what}, {repairs}");
            assert!(grown.report.hairs.without_place.len() < 10, "{what}, {repairs}");
        }
    }
}

#[test]
fn faults_of_scalps_are_mended_and_told() {
    let style = Style { scalp: Some("scalp.obj".into()), ..balls() };
    let good = cap(HEAD);
    let count = good.triangles.len();
    let none = Repairs::default();
    let vertices = good.triangles.as_flattened().iter().map(|&v| good.vertices[v as usize]);
    let loose = Soup {
        vertices: vertices.collect(),
        triangles: (0..).take(count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
    };
    for (soup, reversed) in
        [(good.clone(), 0), (turned(good, 1), count), (turned(loose, 5), count.div_ceil(5))]
    {
        let grown = grow(&style, vec![("scalp.obj", obj(&soup))]).expect("mended");
        let told =
            grown.report.mended.iter().map(|(what, repairs)| (*what, repairs.reversed_faces));
        let expected = (reversed > 0).then_some(("the scalp", reversed));
        assert_eq!(told.collect::<Vec<_>>(), expected.into_iter().collect::<Vec<_>>());
        assert!(grown.report.mended.iter().all(|(_, r)| r.closed_holes == none.closed_holes));
        assert!(grown.pores.iter().all(|pore| pore.normal.dot(&pore.position.coords) > 0.0));
        assert_eq!(grown.report.hairs.in_head, 0);
    }
}

#[test]
fn surfaces_that_cut_through_themselves_are_told() {
    let bump = |radius: f64| both(ball(radius), &moved(ball(0.02), Vector3::z() * radius));
    for (file, what, soup) in
        [("head.obj", "the head", bump(HEAD)), ("hair.obj", "the hair", bump(HULL))]
    {
        let grown = grow(&balls(), vec![(file, obj(&soup))]).expect("a style");
        let [crossed] = &grown.report.crossed[..] else { panic!("{}", grown.report) };
        assert_eq!(crossed.what, what);
        // Both balls are cut along a circle where the small one leaves the large one.
        let radius = if file == "head.obj" { HEAD } else { HULL };
        assert!((crossed.place.coords.norm() / radius - 1.0).abs() < 0.01, "{crossed}");
        assert!(grown.report.to_string().contains("cuts through itself"), "{}", grown.report);
    }
}

#[test]
fn what_leaves_no_room_is_refused() {
    let no_room = |others| {
        let error = refused(&balls(), others);
        assert!(matches!(error, HairgenError::NoRoom { .. }), "{error}");
    };
    // The hair in the head, on it, and so thin that it is nothing.
    for radius in [0.08, HEAD, HEAD + 5e-4] {
        no_room(vec![("hair.obj", obj(&ball(radius)))]);
    }
    let shell = HairSource::Shell { file: "shell.obj".into(), thickness: 2e-3 };
    let error = refused(&Style { hair: shell, ..balls() }, vec![("shell.obj", obj(&cap(0.05)))]);
    assert!(matches!(error, HairgenError::NoRoom { .. }), "{error}");
}

#[test]
fn a_bare_part_of_the_scalp_is_told_and_its_guides_are_not_forced() {
    // The head looks out of the hair at the front.
    let behind = moved(ball(0.11), Vector3::new(0.0, 0.0, -0.03));
    let grown = grow(&balls(), vec![("hair.obj", obj(&behind))]).expect("a style");
    let report = grown.report;
    assert!((0.05..0.6).contains(&report.bare), "{report}");
    assert!(report.to_string().contains("of the scalp is outside"), "{report}");
    assert!(!report.guides_without_place.is_empty() && report.guides > 0, "{report}");
    assert_eq!(report.guides + report.guides_without_place.len(), 20);
    assert_eq!(report.hairs.in_head, 0);
}

#[test]
fn a_scalp_that_is_no_disc_is_refused() {
    let style = Style { scalp: Some("scalp.obj".into()), ..balls() };
    let refused = |soup: &Soup| refused(&style, vec![("scalp.obj", obj(soup))]);
    let near = |soup: &Soup, place: Point3<f64>| {
        let middle = |t: &[u32; 3]| {
            t.map(|v| soup.vertices[v as usize].coords).iter().sum::<Vector3<f64>>() / 3.0
        };
        let off = |t: &[u32; 3]| (middle(t) - place.coords).norm();
        (0..soup.triangles.len())
            .min_by(|&a, &b| off(&soup.triangles[a]).total_cmp(&off(&soup.triangles[b])))
    };
    let mut holed = cap(HEAD);
    let hole = near(&holed, Point3::new(0.03, 0.08, 0.04)).expect("a face");
    holed.triangles.remove(hole);
    assert!(matches!(refused(&holed), HairgenError::ScalpHoles { loops: 2, .. }));
    // A band has two borders.
    let mut band = cap(HEAD);
    band.triangles.retain(|t| t.iter().any(|&v| band.vertices[v as usize].y < 0.07));
    assert!(matches!(refused(&band), HairgenError::ScalpHoles { loops: 2, .. }));
    assert_eq!(refused(&ball(HEAD)), HairgenError::ClosedScalp);
    let two = both(cap(HEAD), &moved(cap(HEAD), Vector3::y() * 0.01));
    assert!(matches!(refused(&two), HairgenError::ScalpParts { parts: 2, .. }));
    assert_eq!(refused(&Soup::default()), HairgenError::EmptyScalp);
    let mut fin = cap(HEAD);
    let [a, b, _] = fin.triangles[9];
    fin.triangles.push([a, b, u32::try_from(fin.vertices.len()).expect("few")]);
    fin.vertices.push(Point3::new(0.0, 0.1, 0.0));
    assert!(refused(&fin).to_string().contains("more than two faces"));
}

#[test]
fn other_units_and_frames_are_refused() {
    let size = |style: &Style, others| match refused(style, others) {
        HairgenError::Size { what, .. } => what,
        error => panic!("{error}"),
    };
    let head = obj(&scaled(ball(HEAD), 1000.0));
    assert_eq!(size(&balls(), vec![("head.obj", head)]), "the head");
    let hair = obj(&scaled(ball(HULL), 100.0));
    assert_eq!(size(&balls(), vec![("hair.obj", hair)]), "the hair");
    let style = Style { scalp: Some("scalp.obj".into()), ..balls() };
    let scalp = |soup: &Soup| vec![("scalp.obj", obj(soup))];
    assert_eq!(size(&style, scalp(&scaled(cap(HEAD), 1000.0))), "the scalp");
    let off = refused(&style, scalp(&moved(cap(HEAD), Vector3::x() * 0.2)));
    assert!(matches!(off, HairgenError::ScalpOff { .. }), "{off}");
    let beside = obj(&moved(ball(HEAD), Vector3::x()));
    let words = said(&balls(), vec![("head.obj", beside)]);
    assert!(words.contains("the head must hold the origin"), "{words}");
    // A scan says its unit by its size; one that is given must fit.
    let options = FitOptions { meters_per_unit: Some(1.0), ..FitOptions::default() };
    let scan = |options| HeadSource::Scan {
        file: "head.obj".into(),
        template: None,
        hairline: Default::default(),
        options,
    };
    let style = Style { head: scan(options), hair: HairSource::Scan, ..balls() };
    let head = obj(&scaled(ball(HEAD), 1000.0));
    assert_eq!(size(&style, vec![("head.obj", head)]), "the scan");
}

/// A scan in millimeters with a hole and with faces turned.
#[test]
fn a_scan_is_mended_and_its_unit_told() {
    let head = ParametricHead::new(HeadMeasures::default(), Default::default()).expect("a head");
    let mut scan = scaled(head.hull(&HairVolume::AFRO).expect("a hull"), 1000.0);
    scan.triangles.truncate(scan.triangles.len() - 1);
    let head = HeadSource::Scan {
        file: "scan.obj".into(),
        template: None,
        hairline: Default::default(),
        options: FitOptions::default(),
    };
    let style = Style { head, hair: HairSource::Scan, ..balls() };
    let report = grow(&style, vec![("scan.obj", obj(&turned(scan, 1000)))]).expect("mended").report;
    let [("the scan", repairs)] = report.mended[..] else { panic!("{report}") };
    assert!(repairs.closed_holes == 1 && repairs.reversed_faces > 0, "{report}");
    assert!(report.to_string().contains("a unit is 0.001 m"), "{report}");
    assert_eq!(report.hairs.in_head, 0);
}

#[test]
fn images_are_refused_by_their_names() {
    let grey = |side: u32| {
        let pixels = vec![255; (side * side) as usize];
        png([side, side], ColorType::Grayscale, BitDepth::Eight, &pixels)
    };
    let field = |black| ScalpField::Image { file: "map.png".into(), black, white: 0.05 };
    let with_length = |black| Style { length: field(black), ..balls() };
    let wide = png([4, 2], ColorType::Grayscale, BitDepth::Eight, &[0; 8]);
    let deep = png([2, 2], ColorType::Grayscale, BitDepth::Sixteen, &[0; 8]);
    for (bytes, words) in [
        (wide, "4 x 2 pixels, but must be square"),
        (deep, "16 bits a channel; export it as plain grey with 8 bits"),
        (b"GIF89a".to_vec(), "cannot be read as PNG"),
    ] {
        let error = said(&with_length(0.0), vec![("map.png", bytes)]);
        assert!(error.starts_with("map.png: ") && error.contains(words), "{error}");
    }
    assert!(said(&with_length(0.0), vec![]).starts_with("map.png: "));
    grow(&with_length(0.0), vec![("map.png", grey(2))]).expect("white everywhere");
    // Black is no length where a pore is.
    let dark = png([2, 2], ColorType::Grayscale, BitDepth::Eight, &[0; 4]);
    let error = refused(&with_length(0.0), vec![("map.png", dark)]);
    assert!(matches!(error, HairgenError::DiscValue { value: 0.0, .. }), "{error}");
    let tilt = ScalpField::Image { file: "map.png".into(), black: 0.0, white: 100.0 };
    let error = said(&Style { tilt: Some(tilt), ..balls() }, vec![("map.png", grey(2))]);
    assert_eq!(error, "the tilt (degrees) is 100, but must be between 0 and 90");
}

#[test]
fn hair_that_is_too_long_is_cut_or_refused() {
    let long = |length| Style { length: ScalpField::Constant(length), ..balls() };
    // Four times around the head: too little of every guide is left.
    let error = said(&long(2.5), vec![]);
    assert!(error.starts_with("none of 20 guides finds a place"), "{error}");
    let report = grow(&long(0.3), vec![]).expect("a style").report;
    assert!((report.asked - 30.0).abs() < 1e-9 && report.hairs.length < 29.0, "{report}");
    assert!(report.to_string().contains("of 30.0 asked for"), "{report}");
    assert!(report.hairs.outside <= 1e-3 * report.hairs.length, "{report}");
}
