//! Surfaces of objects as VTK poly data for ParaView: the triangles of all objects, with vertices
//! in the world at the time of the file, and the poses of the objects.

mod vtp;

pub use vtp::{read, read_poses, write};

use super::ExportError;
use nalgebra::Isometry3;
use rapunzel_collision::field::Soup;

/// Colour of objects: red, green and blue, linear.
pub(super) const COLOR: [f64; 3] = [0.4, 0.45, 0.5];

/// An object with its pose and its surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// Pose of the object, from its own frame to the world, m.
    pub pose: Isometry3<f64>,
    /// Surface of the object in the world, m.
    pub surface: Soup,
}

/// Refuses vertices that are not finite, and corners that refer to no vertex.
///
/// # Errors
/// [`ExportError::Surface`] says which.
pub fn check(surface: &Soup) -> Result<(), ExportError> {
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
    use super::super::sample;
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn objects_survive_to_the_last_bit() {
        let objects = sample::objects(0.3);
        let mut bytes = Vec::new();
        write(&mut bytes, 0.1, &objects).expect("memory");
        assert_eq!(read(&mut bytes.as_slice()).expect("our own file"), objects);
        let poses: Vec<_> = objects.iter().map(|object| object.pose).collect();
        assert_eq!(read_poses(&mut bytes.as_slice()).expect("our own file"), poses);
        for length in (0..bytes.len()).step_by(61) {
            assert!(read(&mut &bytes[..length]).is_err(), "cut to {length} bytes");
        }
        let mut broken = objects;
        broken[1].surface.vertices[3] = Point3::new(f64::NAN, 0.0, 0.0);
        assert!(matches!(write(&mut bytes, 0.0, &broken), Err(ExportError::Surface { .. })));
    }

    /// A count of vertices, or a corner, that lies.
    #[test]
    fn damage_is_an_error_not_a_panic() {
        let mut whole = Vec::new();
        write(&mut whole, 0.1, &sample::objects(0.3)).expect("memory");
        for at in (0..whole.len()).step_by(7) {
            let mut bad = whole.clone();
            bad[at] = bad[at].wrapping_add(127);
            // Whatever it reads then, it returns.
            if let Ok(objects) = read(&mut bad.as_slice()) {
                assert!(objects.iter().all(|object| check(&object.surface).is_ok()));
            }
        }
    }
}
