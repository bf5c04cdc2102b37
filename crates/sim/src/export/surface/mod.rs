//! Surfaces of objects: VTK poly data with the triangles of all, for ParaView, and a USD `Mesh` for
//! Blender. Vertices are in the world, where the objects are at that time.

mod usda;
mod vtp;

pub use usda::write as write_usda;
pub use vtp::{read as read_vtp, write as write_vtp};

use super::ExportError;
use rapunzel_collision::field::Soup;

/// Refuses vertices that are not finite, and corners that are no vertices.
pub(super) fn check(surface: &Soup) -> Result<(), ExportError> {
    let count = surface.vertices.len();
    let what = if !surface.vertices.iter().flat_map(|p| p.iter()).all(|x| x.is_finite()) {
        "has a vertex that is not finite; the simulation has failed"
    } else if surface.triangles.iter().flatten().any(|&v| v as usize >= count) {
        "has a triangle with a corner that is not there"
    } else {
        return Ok(());
    };
    Err(ExportError::Surface { what })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};
    use rapunzel_collision::field::shapes;

    fn objects() -> [Soup; 2] {
        [shapes::cuboid(Vector3::new(0.1, 1.0 / 3.0, 2.0)), shapes::sphere(0.7, 2)]
    }

    #[test]
    fn surfaces_survive_to_the_last_bit_as_one() {
        let mut bytes = Vec::new();
        write_vtp(&mut bytes, 0.1, &objects()).expect("memory");
        let found = read_vtp(&mut bytes.as_slice()).expect("our own file");
        let [a, b] = objects();
        assert_eq!(found.vertices, [a.vertices.clone(), b.vertices].concat());
        assert_eq!(found.triangles[..12], a.triangles);
        assert_eq!(found.triangles[12], b.triangles[0].map(|v| v + 8));
        for length in (0..bytes.len()).step_by(61) {
            assert!(read_vtp(&mut &bytes[..length]).is_err(), "cut to {length} bytes");
        }
        let mut broken = a;
        broken.vertices[3] = Point3::new(f64::NAN, 0.0, 0.0);
        assert!(matches!(write_vtp(&mut bytes, 0.0, &[broken]), Err(ExportError::Surface { .. })));
    }

    #[test]
    fn a_mesh_has_its_points_at_every_time() {
        let [a, b] = objects();
        let write = |times: &[f64], frames: Vec<Soup>| {
            let mut out = Vec::new();
            write_usda(&mut out, times, frames.into_iter().map(Ok))
                .map(|()| String::from_utf8(out).expect("text"))
        };
        let still = write(&[0.0], vec![a.clone()]).expect("one");
        assert!(
            still.contains("point3f[] points = [") && !still.contains("timeSamples"),
            "{still}"
        );
        let moving = write(&[0.0, 0.5], vec![a.clone(), a.clone()]).expect("two");
        assert!(moving.contains("point3f[] points.timeSamples = {\n            0: [("), "{moving}");
        assert!(moving.contains("timeCodesPerSecond = 2\n"), "{moving}");
        assert_eq!(moving.matches('{').count(), moving.matches('}').count());
        assert!(matches!(write(&[0.0, 0.5], vec![a.clone(), b]), Err(ExportError::Series { .. })));
        assert!(matches!(write(&[0.0, 0.5], vec![a]), Err(ExportError::Series { .. })));
        assert!(matches!(write(&[], vec![]), Err(ExportError::Empty)));
    }
}
