//! Fields on grids, as files.

use nalgebra::{Point3, Vector3};
use rapunzel_electrostatics::{COULOMB_CONSTANT, Direct, ElectrostaticsError, FieldGrid, Method};

/// The file holds what was computed, where its header says, and the points stand x fastest.
#[test]
fn images_hold_potentials_and_fields() {
    let grid = FieldGrid {
        origin: Point3::new(0.1, 0.0, -0.1),
        spacing: Vector3::new(0.1, 0.2, 0.3),
        counts: [3, 2, 2],
    };
    let points = grid.points();
    assert!((points[1] - Point3::new(0.2, 0.0, -0.1)).norm() < 1e-15);
    assert!((points[3] - Point3::new(0.1, 0.2, -0.1)).norm() < 1e-15);
    let fields = Direct.fields(&[Point3::origin()], &[1e-12], &points).expect("valid");
    let mut file = Vec::new();
    grid.write_vti(&mut file, &fields).expect("written");
    let start = file.windows(2).position(|pair| pair == b"\n_").expect("data") + 2;
    let header = std::str::from_utf8(&file[..start]).expect("text");
    assert!(header.contains(r#"WholeExtent="0 2 0 1 0 1" Origin="0.1 0 -0.1""#), "{header}");
    assert!(
        header.contains(r#"Name="field" NumberOfComponents="3" format="appended" offset="104""#)
    );
    let bytes = |place: usize| file[start + place..][..8].try_into().expect("eight");
    assert_eq!(u64::from_le_bytes(bytes(0)), 96);
    assert_eq!(u64::from_le_bytes(bytes(104)), 288);
    for (k, point) in points.iter().enumerate() {
        let potential = f64::from_le_bytes(bytes(8 + 8 * k));
        let exact = COULOMB_CONSTANT * 1e-12 / point.coords.norm();
        assert!((potential / exact - 1.0).abs() < 1e-12, "{potential} V");
        let field = Vector3::from_fn(|c, _| f64::from_le_bytes(bytes(112 + 24 * k + 8 * c)));
        assert_eq!(field, fields.fields[k]);
    }
    let wrong = FieldGrid { counts: [3, 2, 1], ..grid };
    let result = wrong.write_vti(&mut Vec::new(), &fields);
    assert!(matches!(result, Err(ElectrostaticsError::Count { given: 12, needed: 6, .. })));
    let result = grid.write_vti(&mut [0_u8; 9].as_mut_slice(), &fields);
    assert!(matches!(result, Err(ElectrostaticsError::Write(_))));
}
