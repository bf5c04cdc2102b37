//! What cannot be a hair is told by its number.

use crate::common::read;
use nalgebra::Point3;
use rapunzel_strands::{ReadOptions, StrandFault, StrandFile, StrandFormat, StrandsError};

/// A `.data` of strands.
fn data(strands: &[Vec<[f32; 3]>]) -> Vec<u8> {
    let count = |n: usize| i32::try_from(n).expect("few").to_le_bytes();
    let mut bytes = count(strands.len()).to_vec();
    for points in strands {
        bytes.extend(count(points.len()));
        points.as_flattened().iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    }
    bytes
}

const A: [f32; 3] = [0.0, 0.25, 1.0];
const B: [f32; 3] = [1.0, 0.25, 1.0];
const C: [f32; 3] = [1.0, 0.5, 1.0];

#[test]
fn every_fault_has_its_number_and_the_rest_keeps_its_order() {
    let nan = [0.0, f32::NAN, 0.0];
    let strands = [
        vec![A, B],
        vec![],
        vec![A],
        vec![B, B, B],
        vec![C, nan],
        vec![A, A, B, B, C],
        vec![A; 9],
        vec![[f32::INFINITY; 3], A],
        vec![C, B],
    ];
    let options = ReadOptions { most_points: 8, ..ReadOptions::default() };
    let file = StrandFile::read(&data(&strands), Some(StrandFormat::Data), &options);
    let StrandFile { strands, report } = file.expect("a file");
    assert_eq!(strands.sources(), [0, 5, 8]);
    let point = |p: [f32; 3]| Point3::from(p.map(f64::from));
    assert_eq!(strands.strand(1), [A, B, C].map(point));
    assert_eq!((report.found, report.merged), (9, 2));
    assert_eq!(
        report.refused,
        [
            (1, StrandFault::FewPoints),
            (2, StrandFault::FewPoints),
            (3, StrandFault::NoLength),
            (4, StrandFault::NotFinite),
            (6, StrandFault::ManyPoints),
            (7, StrandFault::NotFinite),
        ]
    );
}

#[test]
fn a_report_on_a_million_strands_is_a_few_lines() {
    let mut bytes = data(&vec![vec![A]; 1_000_000]);
    bytes.extend(data(&[vec![A, B]]).split_off(4));
    bytes[..4].copy_from_slice(&1_000_001_i32.to_le_bytes());
    let file = read(&bytes);
    assert_eq!(file.strands.len(), 1);
    assert_eq!(
        file.report.to_string(),
        "DATA: 1 of 1000001 strands; 1 unit is 1 m (assumed), Y is up (assumed)\n\
         1000000 left out with fewer than two points: 0 1 2 3 4 5 6 7 and 999992 more"
    );
}

/// A `.hair` of two strands of two points, with a header of these flags and defaults.
fn hair(flags: u32, segments: u32, thickness: f32, arrays: &[u8]) -> Vec<u8> {
    let mut bytes = b"HAIR".to_vec();
    [2, 4, flags, segments].iter().for_each(|x: &u32| bytes.extend(x.to_le_bytes()));
    bytes.extend(thickness.to_le_bytes());
    bytes.resize(128, 0);
    bytes.extend(arrays);
    bytes
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[test]
fn hair_takes_its_defaults_and_passes_over_colors() {
    let points = floats(&[A, B, B, C].concat());
    let file = read(&hair(2, 1, 0.5, &points));
    assert_eq!(file.strands.radii(), Some(&[0.25; 4][..]));
    let file = read(&hair(2, 1, 0.0, &points));
    assert_eq!((file.strands.radii(), file.strands.len()), (None, 2));
    // Thicknesses of points, transparencies and colors; one strand of one segment, one of one.
    let segments = [1_u16.to_le_bytes(), 1_u16.to_le_bytes()].concat();
    let widths = floats(&[0.5, 0.25, -0.5, 0.5]);
    let more = floats(&[0.5; 4 + 12]);
    let all = [segments, points.clone(), widths, more].concat();
    let file = read(&hair(31, 9, 0.0, &all));
    assert_eq!(file.strands.radii(), Some(&[0.25, 0.125][..]));
    assert_eq!(file.report.refused, [(1, StrandFault::Radius)]);
    let long = StrandFile::read(&hair(31, 9, 0.0, &[all, vec![0]].concat()), None, &usual());
    assert!(long.expect_err("too long").to_string().contains("goes on"));
    let other = StrandFile::read(&hair(2, 2, 0.0, &points), None, &usual());
    assert!(other.expect_err("six points").to_string().contains("should have 6 points"));
    let none = StrandFile::read(&hair(1, 0, 0.0, &[0, 0, 0, 0]), None, &usual());
    assert!(none.expect_err("no points").to_string().contains("no points"));
}

fn usual() -> ReadOptions {
    ReadOptions::default()
}

#[test]
fn counts_of_gigabytes_in_small_files_are_refused() {
    let mut file = hair(2, u32::MAX, 0.0, &[]);
    file[4..12].fill(0xff);
    let error = StrandFile::read(&file, None, &usual()).expect_err("no points");
    let StrandsError::CutOff { needed, left: 0, .. } = error else { panic!("{error}") };
    assert_eq!(needed, 12 * u32::MAX as usize);
    for bytes in
        [&b"\xff\xff\xff\x7f\xff\xff\xff\x7f0000"[..], b"\x01\0\0\0\xff\xff\xff\x7f000000000000"]
    {
        let error = StrandFile::read(bytes, Some(StrandFormat::Data), &usual());
        assert!(matches!(error, Err(StrandsError::CutOff { .. })), "{error:?}");
    }
    let head = "ply\nformat binary_little_endian 1.0\ncomment points_per_strand 4294967295\n\
        element vertex 4294967295\nproperty float x\nend_header\n";
    let error = StrandFile::read(head.as_bytes(), None, &usual()).expect_err("nothing follows");
    assert!(matches!(error, StrandsError::Read { format: "PLY", .. }), "{error}");
}

/// Whatever the counts of a small file say, reading it takes a few times its own size.
#[test]
fn small_files_take_little_memory() {
    let layer = include_bytes!("../data/groom.usdc");
    let head = b"ply\nformat ascii 1.0\nelement vertex 4294967295\nproperty list uint int x\n\
        end_header\n4294967295 1\n";
    let mut files = vec![hair(2, u32::MAX, 0.0, &[]), hair(3, 0, 0.0, &[]), head.to_vec()];
    files[0][4..12].fill(0xff);
    files[1][4..8].fill(0xff);
    files.push(b"\xff\xff\xff\x7f\xff\xff\xff\x7f0000".to_vec());
    // Every eight bytes of a binary layer in turn as a large number.
    files.extend((8..layer.len() - 8).step_by(4).map(|at| {
        let mut bytes = layer.to_vec();
        bytes[at..at + 8].copy_from_slice(&0x0000_00ff_ffff_ffff_u64.to_le_bytes());
        bytes
    }));
    for bytes in files {
        let taken = allocation_counter::measure(|| {
            let _ = StrandFile::read(&bytes, None, &usual());
        });
        assert!(taken.bytes_max < 300 * bytes.len() as u64 + 10_000, "{}", taken.bytes_max);
    }
}

#[test]
fn ply_takes_its_counts_from_where_they_are() {
    let ply = |comment: &str, more: &str, end: &str| {
        format!(
            "ply\nformat ascii 1.0\n{comment}element vertex 4\nproperty double x\nproperty float \
             y\nproperty int z\n{more}end_header\n0 0 0\n1 0 0\n2 0 0\n3 0 0\n{end}"
        )
    };
    let counts = |text: &str, options: &ReadOptions| -> Vec<usize> {
        let file = StrandFile::read(text.as_bytes(), None, options).expect(text);
        file.strands.iter().map(<[_]>::len).collect()
    };
    let given = ReadOptions { points_per_strand: Some(4), ..usual() };
    assert_eq!(counts(&ply("", "", ""), &given), [4]);
    assert_eq!(counts(&ply("comment points_per_strand 2\n", "", ""), &usual()), [2, 2]);
    assert_eq!(counts(&ply("comment points_per_strand 2\n", "", ""), &given), [4]);
    assert_eq!(counts(&ply("obj_info points_per_strand: 4 of each\n", "", ""), &usual()), [4]);
    let strands = "element strand 2\nproperty uchar points\n";
    let file = StrandFile::read(ply("", strands, "3\n1\n").as_bytes(), None, &usual());
    let file = file.expect("a file");
    assert_eq!(file.report.refused, [(1, StrandFault::FewPoints)]);
    let edges = "element edge 2\nproperty int vertex1\nproperty int vertex2\n";
    assert_eq!(counts(&ply("", edges, "1 0\n3 2\n"), &usual()), [2, 2]);
    for (text, problem) in [
        (ply("", "", ""), "does not say how many points"),
        (ply("comment points_per_strand 3\n", "", ""), "no multiple of 3"),
        (ply("comment points_per_strand 0\n", "", ""), "no positive number"),
        (ply("comment points_per_strand\n", "", ""), "no positive number"),
        (ply("", strands, "3\n2\n"), "do not add up"),
        (ply("", edges, "1 0\n3 4\n"), "not there"),
        (ply("", edges, "1 0\n3 -1\n"), "not there"),
        (ply("comment points_per_strand 2\n", "", "7\n"), "goes on"),
        (
            ply("comment points_per_strand 2\n", "", "").replace("3 0 0\n", ""),
            "a number is expected",
        ),
        (ply("", "element nothing 9999999999\n", ""), "no properties"),
        (
            ply("comment points_per_strand 2\n", "", "")
                .replace("element vertex 4", "element vertex 0")
                .replace("0 0 0\n1 0 0\n2 0 0\n3 0 0\n", ""),
            "no strands",
        ),
    ] {
        let error = StrandFile::read(text.as_bytes(), None, &usual()).expect_err(&text);
        assert!(error.to_string().contains(problem), "{error}");
    }
}

/// Vertices with all types of numbers, after an element with a list, in either order of bytes.
#[test]
fn binary_ply_has_numbers_of_any_type() {
    for (name, is_little) in [("binary_little_endian", true), ("binary_big_endian", false)] {
        let mut bytes = format!(
            "ply\nformat {name} 1.0\ncomment points_per_strand 2\nelement other 1\nproperty list \
             ushort short some\nelement vertex 2\nproperty char a\nproperty double x\nproperty uint \
             y\nproperty uchar z\nproperty float radius\nend_header\n"
        )
        .into_bytes();
        let mut put = |number: &[u8]| {
            let mut number = number.to_vec();
            if !is_little {
                number.reverse();
            }
            bytes.extend(number);
        };
        put(&2_u16.to_le_bytes());
        put(&(-7_i16).to_le_bytes());
        put(&300_i16.to_le_bytes());
        for (x, y, radius) in [(0.1_f64, 70_000_u32, 0.5_f32), (0.2, 3, 0.25)] {
            put(&[1]);
            put(&x.to_le_bytes());
            put(&y.to_le_bytes());
            put(&[200]);
            put(&radius.to_le_bytes());
        }
        let strands = read(&bytes).strands;
        let points = [[0.1, 70_000.0, 200.0], [0.2, 3.0, 200.0]].map(Point3::from);
        assert_eq!(strands.strand(0), points);
        assert_eq!(strands.radii(), Some(&[0.5, 0.25][..]));
    }
}
