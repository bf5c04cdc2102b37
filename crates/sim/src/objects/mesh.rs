//! Meshes of objects from files.

use crate::SimError;
use crate::file::{self, LARGEST_MESH, kind};
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::{Mesh, Repairs, Soup};
use std::path::Path;

/// The mesh of an object in a file, with `scale` metres for its unit, and what was done to it if it
/// was to be repaired.
///
/// # Errors
/// [`SimError::Io`] for a file that cannot be read, [`SimError::Mesh`] for one that is not
/// understood or bounds nothing.
pub(crate) fn read_mesh(
    object: usize,
    path: &Path,
    scale: f64,
    repair: bool,
) -> Result<(Mesh, Repairs), SimError> {
    let file = file::open(path, LARGEST_MESH)?;
    let soup = match kind(path).as_str() {
        "ply" => Soup::read_ply(file),
        "stl" => Soup::read_stl(file),
        "obj" => Soup::read_obj(file),
        _ => {
            let problem = "only .ply, .stl and .obj are read".into();
            Err(CollisionError::Read { format: "a mesh", line: None, problem })
        }
    };
    let mesh = soup.and_then(|mut soup| {
        soup.vertices.iter_mut().for_each(|vertex| *vertex *= scale);
        if repair { Mesh::repaired(soup) } else { Ok((Mesh::new(soup)?, Repairs::default())) }
    });
    mesh.map_err(|source| SimError::Mesh { object, path: path.to_owned(), source })
}
