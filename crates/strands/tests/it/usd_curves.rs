//! Cubic curves of USD against what their bases are made of.

use nalgebra::Point3;
use rapunzel_strands::{ReadOptions, StrandFault, StrandFile, StrandSet};

/// The curves of one prim with these control points, `fine` points a span.
fn curves(
    words: [&str; 2],
    counts: &[usize],
    controls: &[f64],
    more: &str,
    fine: usize,
) -> StrandFile {
    let [basis, wrap] = words;
    let points: Vec<_> =
        controls.iter().enumerate().map(|(k, x)| format!("({x}, {k}, 1)")).collect();
    let text = format!(
        "#usda 1.0\n(metersPerUnit = 1)\ndef BasisCurves \"a\" {{\nuniform token basis = \
         \"{basis}\"\nuniform token wrap = \"{wrap}\"\nint[] curveVertexCounts = \
         {counts:?}\npoint3f[] points = [{}]\n{more}}}\n",
        points.join(", ")
    );
    let options = ReadOptions { points_per_span: fine, ..ReadOptions::default() };
    StrandFile::read(text.as_bytes(), None, &options).expect("curves")
}

fn xs(set: &StrandSet) -> Vec<f64> {
    set.strand(0).iter().map(|point| point.x).collect()
}

/// A cubic has one symmetric function of three arguments that is linear in each and is the cubic
/// where all are equal; its values are the control points. That of t³ is their product.
#[test]
fn a_cubic_is_reproduced() {
    let blossom = |a: usize, b: usize, c: usize| (a * b * c) as f64;
    let bspline: Vec<_> = (0..7).map(|k| blossom(k, k + 1, k + 2)).collect();
    let file = curves(["bspline", "nonperiodic"], &[7], &bspline, "", 5);
    let x = xs(&file.strands);
    assert_eq!(x.len(), 4 * 5 + 1);
    for (k, x) in x.iter().enumerate() {
        let t = 2.0 + k as f64 / 5.0;
        assert!((x - t.powi(3)).abs() < 1e-12 * t.powi(3), "{x} at {t}");
    }
    let mut bezier = vec![0.0];
    for k in 0..3 {
        bezier.extend([
            blossom(k, k, k + 1),
            blossom(k, k + 1, k + 1),
            blossom(k + 1, k + 1, k + 1),
        ]);
    }
    for wrap in ["nonperiodic", "pinned"] {
        let x = xs(&curves(["bezier", wrap], &[10], &bezier, "", 8).strands);
        assert_eq!(x.len(), 3 * 8 + 1);
        for (k, x) in x.iter().enumerate() {
            assert!((x - (k as f64 / 8.0).powi(3)).abs() < 1e-12);
        }
    }
}

/// Catmull-Rom splines reproduce squares, and pass through their control points.
#[test]
fn a_square_is_reproduced() {
    let squares: Vec<_> = (0..6).map(|k| f64::from(k * k)).collect();
    let x = xs(&curves(["catmullRom", "nonperiodic"], &[6], &squares, "", 4).strands);
    assert_eq!(x.len(), 3 * 4 + 1);
    for (k, x) in x.iter().enumerate() {
        let t = 1.0 + k as f64 / 4.0;
        assert!((x - t * t).abs() < 1e-12);
    }
}

#[test]
fn pinned_curves_reach_their_ends_and_closed_ones_their_start() {
    let controls = [0.5, 2.0, -1.0, 4.0, 0.25, 3.0];
    for basis in ["bspline", "catmullRom"] {
        let file = curves([basis, "pinned"], &[6], &controls, "", 3);
        let points = file.strands.strand(0);
        assert_eq!(points.len(), 5 * 3 + 1);
        assert!((points[0] - Point3::new(0.5, 0.0, 1.0)).norm() < 1e-14);
        assert!((points[15] - Point3::new(3.0, 5.0, 1.0)).norm() < 1e-14);
        let straight = curves([basis, "pinned"], &[2], &[1.0, 2.0], "", 2);
        for (x, expected) in xs(&straight.strands).iter().zip([1.0, 1.5, 2.0]) {
            assert!((x - expected).abs() < 1e-14);
        }
        let file = curves([basis, "periodic"], &[6], &controls, "", 3);
        let points = file.strands.strand(0);
        assert_eq!(points.len(), 6 * 3 + 1);
        assert!((points[0] - points[18]).norm() < 1e-14);
    }
    let file = curves(["bezier", "periodic"], &[6], &controls, "", 3);
    let points = file.strands.strand(0);
    assert_eq!((points.len(), points[0]), (2 * 3 + 1, points[6]));
    let linear = "uniform token type = \"linear\"\n";
    let file = curves(["bezier", "periodic"], &[6], &controls, linear, 3);
    assert_eq!((file.strands.strand(0).len(), xs(&file.strands)[6]), (7, 0.5));
}

#[test]
fn curves_of_too_few_points_are_told() {
    let controls = [0.0, 1.0, 3.0, 6.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 9.0];
    let file = curves(["bspline", "nonperiodic"], &[4, 3, 1, 0, 3], &controls, "", 2);
    assert_eq!(file.strands.len(), 1);
    let few = StrandFault::FewPoints;
    let odd = StrandFault::ControlPoints;
    assert_eq!(file.report.refused, [(1, odd), (2, few), (3, few), (4, odd)]);
    let file = curves(["bezier", "nonperiodic"], &[5, 6], &controls, "", 2);
    assert_eq!(file.report.refused, [(0, odd), (1, odd)]);
    assert!(file.strands.is_empty());
}

/// Widths of control points go as these do; those of the ends of spans linearly.
#[test]
fn widths_follow_their_curves() {
    let controls = [0.0, 1.0, 2.0, 3.0, 4.0];
    let radii = |widths: &str, interpolation: &str| {
        let widths =
            format!("float[] widths = [{widths}] (\n interpolation = \"{interpolation}\"\n)\n");
        let file = curves(["bspline", "nonperiodic"], &[5], &controls, &widths, 2);
        file.strands.radii().expect("radii").to_vec()
    };
    let close = |radii: &[f64], expected: [f64; 5]| {
        assert_eq!(radii.len(), 5);
        assert!(radii.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14), "{radii:?}");
    };
    close(&radii("0, 2, 4, 6, 8", "vertex"), [1.0, 1.5, 2.0, 2.5, 3.0]);
    close(&radii("2, 4, 8", "varying"), [1.0, 1.5, 2.0, 3.0, 4.0]);
    close(&radii("2", "constant"), [1.0; 5]);
    close(&radii("2", "uniform"), [1.0; 5]);
    // What does not suit is taken by its number.
    close(&radii("2, 4, 8", "vertex"), [1.0, 1.5, 2.0, 3.0, 4.0]);
}
