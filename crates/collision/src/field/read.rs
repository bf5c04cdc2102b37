//! Meshes from files of the common formats.

use super::Soup;
use super::mesh::index;
use crate::CollisionError;
use nalgebra::Point3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::io::{BufRead, Read, Seek};

impl Soup {
    /// Reads PLY, text or binary of either byte order. Polygons become fans of triangles around their
    /// first corner; all but the positions and the faces is ignored.
    ///
    /// # Errors
    /// [`CollisionError::Read`] if the text is no PLY, or has no elements `vertex` and `face`.
    pub fn read_ply(source: impl BufRead) -> Result<Self, CollisionError> {
        let mut reader = Reader::new(source);
        let parser = Parser::<Element>::new();
        let refuse = |problem: String| CollisionError::Read { format: "PLY", problem };
        let header = parser.read_header(&mut reader).map_err(|e| refuse(e.to_string()))?;
        for name in ["vertex", "face"] {
            if !header.elements.contains_key(name) {
                return Err(refuse(format!("there is no element `{name}`")));
            }
        }
        let mut soup = Self::default();
        for (name, definition) in &header.elements {
            let elements = parser
                .read_payload_for_element(&mut reader, definition, &header)
                .map_err(|e| refuse(e.to_string()))?;
            match name.as_str() {
                "vertex" => soup.vertices = elements.iter().map(|e| e.position.into()).collect(),
                "face" => elements.iter().for_each(|e| soup.polygon(&e.corners)),
                _ => {}
            }
        }
        Ok(soup)
    }

    /// Reads all faces of a Wavefront OBJ, of all its objects together. Polygons become triangles;
    /// materials, normals and texture are ignored.
    ///
    /// # Errors
    /// [`CollisionError::Read`] if the text is no OBJ.
    pub fn read_obj(mut source: impl BufRead) -> Result<Self, CollisionError> {
        let options = tobj::LoadOptions {
            triangulate: true,
            ignore_points: true,
            ignore_lines: true,
            ..Default::default()
        };
        let no_material = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
        let (models, _) = tobj::load_obj_buf(&mut source, &options, no_material)
            .map_err(|e| CollisionError::Read { format: "OBJ", problem: e.to_string() })?;
        let mut soup = Self::default();
        for tobj::Model { mesh, .. } in models {
            let first = index(soup.vertices.len());
            let (points, triangles) = (mesh.positions.as_chunks().0, mesh.indices.as_chunks().0);
            soup.vertices.extend(points.iter().map(|&p: &[f64; 3]| Point3::from(p)));
            soup.triangles.extend(triangles.iter().map(|t| t.map(|v| v + first)));
        }
        Ok(soup)
    }

    /// Reads STL, text or binary. Equal vertices are merged; the normals are ignored.
    ///
    /// # Errors
    /// [`CollisionError::Read`] if the text is no STL.
    pub fn read_stl(mut source: impl Read + Seek) -> Result<Self, CollisionError> {
        let mesh = stl_io::read_stl(&mut source)
            .map_err(|e| CollisionError::Read { format: "STL", problem: e.to_string() })?;
        let mut soup = Self::default();
        soup.vertices.extend(mesh.vertices.iter().map(|v| Point3::from(v.0.map(f64::from))));
        for face in mesh.faces {
            soup.triangles.push(face.vertices.map(index));
        }
        Ok(soup)
    }

    fn polygon(&mut self, corners: &[u32]) {
        for k in 2..corners.len() {
            self.triangles.push([corners[0], corners[k - 1], corners[k]]);
        }
    }
}

/// A vertex or a face of a PLY.
struct Element {
    position: [f64; 3],
    corners: Vec<u32>,
}

impl PropertyAccess for Element {
    /// A coordinate that is left out is not a number, and the vertex is refused later on.
    fn new() -> Self {
        Self { position: [f64::NAN; 3], corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        // An index that is out of range is refused with the face.
        fn indices<T: TryInto<u32>>(list: Vec<T>) -> Vec<u32> {
            list.into_iter().map(|i| i.try_into().unwrap_or(u32::MAX)).collect()
        }
        let axis = ["x", "y", "z"].iter().position(|&axis| axis == name);
        let is_list = matches!(name, "vertex_indices" | "vertex_index");
        match (property, axis) {
            (Property::Float(x), Some(axis)) => self.position[axis] = f64::from(x),
            (Property::Double(x), Some(axis)) => self.position[axis] = x,
            (Property::Int(x), Some(axis)) => self.position[axis] = f64::from(x),
            (Property::Short(x), Some(axis)) => self.position[axis] = f64::from(x),
            (Property::ListInt(list), _) if is_list => self.corners = indices(list),
            (Property::ListUInt(list), _) if is_list => self.corners = list,
            (Property::ListShort(list), _) if is_list => self.corners = indices(list),
            (Property::ListUShort(list), _) if is_list => self.corners = indices(list),
            (Property::ListChar(list), _) if is_list => self.corners = indices(list),
            (Property::ListUChar(list), _) if is_list => self.corners = indices(list),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Mesh;
    use std::io::Cursor;

    const PLY: &str = "ply\nformat ascii 1.0\ncomment a tetrahedron\nelement vertex 4\n\
        property float x\nproperty double y\nproperty int z\nproperty uchar red\n\
        element face 4\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 9\n1 0 0 9\n0 1 0 9\n0 0 1 9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\no first\nf 1 3 2\nl 1 2\nf 1 2 4\n\
        v 0 0 1\no second\nf 1 4 3\nf 2 3 4\n";

    fn check(soup: Soup) {
        let (mesh, _) = Mesh::repaired(soup).expect("a mesh");
        assert_eq!(mesh.triangles().len(), 4);
        assert!((mesh.volume() - 1.0 / 6.0).abs() <= 1e-15);
    }

    #[test]
    fn a_tetrahedron_is_read_from_all_formats() {
        check(Soup::read_ply(PLY.as_bytes()).expect("a PLY"));
        check(Soup::read_obj(OBJ.as_bytes()).expect("an OBJ"));
        let soup = Soup::read_ply(PLY.as_bytes()).expect("a PLY");
        let facet = |t: &[u32; 3]| {
            let vertex = |p: Point3<f64>| format!("vertex {} {} {}\n", p.x, p.y, p.z);
            let corners: String = soup.corners(*t).map(vertex).concat();
            format!("facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n")
        };
        let facets: String = soup.triangles.iter().map(facet).collect();
        let stl = format!("solid a\n{facets}endsolid a\n");
        check(Soup::read_stl(Cursor::new(stl)).expect("an STL"));
    }

    #[test]
    fn what_is_cut_off_or_something_else_is_refused() {
        for length in 0..PLY.len() - 3 {
            let soup = Soup::read_ply(&PLY.as_bytes()[..length]);
            assert!(soup.is_err() || soup.and_then(Mesh::new).is_err(), "{length}");
        }
        for text in ["", "o", "f 1 2 3", "v 1 2\nf 1 1 1", "nothing\nat all", "v nan 0 0\nf 1 1 1"]
        {
            let obj = Soup::read_obj(text.as_bytes()).and_then(Mesh::new);
            assert!(obj.is_err(), "{text}");
            assert!(Soup::read_stl(Cursor::new(text)).and_then(Mesh::new).is_err(), "{text}");
            assert!(Soup::read_ply(text.as_bytes()).is_err(), "{text}");
        }
    }
}
