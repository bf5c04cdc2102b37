//! The ponytail of `TressFX`, where it is at hand: as `.hair`, and as its own files hold it.

use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::Soup;
use rapunzel_oracles::data;
use rapunzel_strands::{ReadOptions, ScalpMesh, StrandFile, StrandFormat};
use std::fs;

/// Points of a `.tfx` in the frame of the `.hair`: (x, y, z) to 0.0029 (-x, y - 88, -z), from its
/// SOURCE.md.
fn tfx(bytes: &[u8]) -> Vec<Point3<f64>> {
    let count = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"));
    assert_eq!((f32::from_bits(count(0)), count(8)), (3.0, 16));
    let points = 16 * count(4) as usize;
    let numbers = bytes[296..296 + 12 * points].as_chunks::<4>().0.as_chunks::<3>().0;
    let place = |three: &[[u8; 4]; 3]| {
        let [x, y, z] = three.map(|four| f64::from(f32::from_le_bytes(four)));
        Point3::new(-x, y - 88.0, -z) * 0.0029
    };
    numbers.iter().map(place).collect()
}

#[test]
fn a_hairstyle_is_what_its_own_files_hold() {
    let Some(folder) = data("strands_ponytail") else { return };
    let bytes = fs::read(folder.join("ponytail.hair")).expect("readable");
    let file = StrandFile::read(&bytes, Some(StrandFormat::Hair), &ReadOptions::default());
    let StrandFile { strands, report } = file.expect("a hairstyle");
    assert_eq!((strands.len(), report.refused.len(), report.merged), (4933, 0, 0));
    assert!(strands.iter().all(|strand| strand.len() == 16));
    let parts = ["back.tfx", "front_top.tfx", "side.tfx", "tail.tfx"];
    let parts = parts.map(|name| tfx(&fs::read(folder.join(name)).expect("readable")));
    let own: Vec<_> = parts.concat();
    assert_eq!(own.len(), strands.points().len());
    // Single precision at 0.5 m.
    let apart = own.iter().zip(strands.points()).map(|(a, b)| (a - b).norm());
    let largest = apart.fold(0.0, f64::max);
    assert!(largest < 6e-8, "{largest}");

    let mut lengths: Vec<_> = (0..strands.len()).map(|k| strands.length(k)).collect();
    lengths.sort_by(f64::total_cmp);
    let [low, middle, high] = [0, lengths.len() / 2, lengths.len() - 1].map(|k| lengths[k]);
    assert!((low - 0.010).abs() < 1e-3 && (middle - 0.066).abs() < 1e-3, "{low} {middle}");
    assert!((high - 0.268).abs() < 1e-3, "{high}");
}

/// Roots lie from 22 mm below to 43 mm above the head, whose tail starts at a hair band.
#[test]
fn its_roots_are_put_on_its_head() {
    let Some(folder) = data("strands_ponytail") else { return };
    let bytes = fs::read(folder.join("ponytail.hair")).expect("readable");
    let file = StrandFile::read(&bytes, None, &ReadOptions::default()).expect("a hairstyle");
    let head = fs::read(folder.join("head.ply")).expect("readable");
    let head = Soup::read_ply(&head[..]).expect("a head");
    let scalp = ScalpMesh::new(&head).expect("a surface");
    let mut strands = file.strands;
    let lengths: Vec<_> = (0..strands.len()).map(|k| strands.length(k)).collect();
    let moved = strands.snap(&scalp, 0.03).expect("a distance");
    assert!(!moved.far.is_empty() && moved.far.iter().all(|&k| k >= 4459), "{:?}", moved.far);
    assert!(moved.largest <= 0.03 && moved.mean < 0.01, "{} {}", moved.largest, moved.mean);
    for (k, length) in lengths.iter().enumerate() {
        assert!((strands.length(k) - length).abs() < 1e-12);
    }
    let moved = strands.snap(&scalp, f64::INFINITY).expect("a distance");
    assert!((0.03..0.045).contains(&moved.largest), "{}", moved.largest);
    let farthest = strands.iter().map(|s| (scalp.nearest(&s[0]) - s[0]).norm());
    assert!(farthest.fold(0.0, f64::max) < 1e-12);
    assert_eq!(Vector3::zeros(), strands.strand(0)[0] - scalp.nearest(&strands.strand(0)[0]));
}
