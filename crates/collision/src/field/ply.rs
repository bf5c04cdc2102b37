//! Meshes from PLY.

use super::Soup;
use crate::CollisionError;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::io::BufRead;

impl Soup {
    /// Reads PLY, text or binary of either byte order. Polygons, also concave ones, become
    /// triangles; all but the positions and the faces is ignored.
    ///
    /// # Errors
    /// [`CollisionError::Read`] if it is no PLY, has no elements `vertex` and `face`, is cut off or
    /// longer than its head tells, or has a polygon that meets itself.
    pub fn read_ply(source: impl BufRead) -> Result<Self, CollisionError> {
        let mut reader = Reader::new(source);
        let header = Parser::<Ignored>::new().read_header(&mut reader).map_err(said)?;
        for name in ["vertex", "face"] {
            if !header.elements.contains_key(name) {
                return Err(refuse(None, format!("there is no element `{name}`")));
            }
        }
        // Nothing in the file bounds how many there are of what takes no place.
        if let Some((name, _)) = header.elements.iter().find(|(_, e)| e.properties.is_empty()) {
            return Err(refuse(None, format!("the element `{name}` has no properties")));
        }
        let mut soup = Self::default();
        let mut polygons = Vec::new();
        for (name, definition) in &header.elements {
            match name.as_str() {
                "vertex" => {
                    let parser = Parser::<Vertex>::new();
                    let read = parser.read_payload_for_element(&mut reader, definition, &header);
                    soup.vertices = read.map_err(said)?.iter().map(|v| v.0.into()).collect();
                }
                "face" => {
                    let parser = Parser::<FaceCorners>::new();
                    let read = parser.read_payload_for_element(&mut reader, definition, &header);
                    polygons = read.map_err(said)?;
                }
                _ => {
                    let parser = Parser::<Ignored>::new();
                    let read = parser.read_payload_for_element(&mut reader, definition, &header);
                    read.map_err(said)?;
                }
            }
        }
        let more =
            reader.into_inner().bytes().find(|b| !b.as_ref().is_ok_and(u8::is_ascii_whitespace));
        if let Some(more) = more {
            more.map_err(|error| refuse(None, error.to_string()))?;
            return Err(refuse(
                None,
                "it goes on after the elements that its head tells of".into(),
            ));
        }
        for (number, FaceCorners(corners)) in polygons.into_iter().enumerate() {
            soup.polygon(corners)
                .map_err(|problem| refuse(None, format!("face {number} {problem}")))?;
        }
        Ok(soup)
    }
}

fn refuse(line: Option<usize>, problem: String) -> CollisionError {
    CollisionError::Read { format: "PLY", line, problem }
}

/// What the reader says, in one line.
fn said(error: ParseError) -> CollisionError {
    let text = error.to_string();
    let words = text.split_once(": ").filter(|_| error.line().is_some());
    let problem = words.map_or(&*text, |(_, words)| words);
    refuse(error.line(), problem.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The position of a vertex; a coordinate that is left out is not a number, and refused later on.
struct Vertex([f64; 3]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([f64::NAN; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(axis) = ["x", "y", "z"].iter().position(|&axis| axis == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.0[axis] = match property {
            Property::Char(x) => x.into(),
            Property::UChar(x) => x.into(),
            Property::Short(x) => x.into(),
            Property::UShort(x) => x.into(),
            Property::Int(x) => x.into(),
            Property::UInt(x) => x.into(),
            Property::Float(x) => x.into(),
            Property::Double(x) => x,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// The corners of a face.
struct FaceCorners(Vec<u32>);

impl PropertyAccess for FaceCorners {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        // An index that is out of range is refused with the face.
        fn indices<T: TryInto<u32>>(list: Vec<T>) -> Vec<u32> {
            list.into_iter().map(|i| i.try_into().unwrap_or(u32::MAX)).collect()
        }
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListChar(list) => indices(list),
            Property::ListUChar(list) => indices(list),
            Property::ListShort(list) => indices(list),
            Property::ListUShort(list) => indices(list),
            Property::ListInt(list) => indices(list),
            Property::ListUInt(list) => list,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element of another kind.
struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Mesh;
    use proptest::prelude::*;

    const HEAD: &str = "ply\nformat ascii 1.0\ncomment a tetrahedron\nelement vertex 4\n\
        property float x\nproperty double y\nproperty int z\nproperty uchar red\n\
        element edge 1\nproperty short vertex1\nelement face 4\n\
        property list uchar int vertex_indices\nend_header\n";
    const BODY: &str =
        "0 0 0 9\n1 0 0 9\n0 1 0 9\n0 0 1 9\n7\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

    fn check(bytes: &[u8]) {
        let mesh = Mesh::new(Soup::read_ply(bytes).expect("a PLY")).expect("closed");
        assert_eq!(mesh.triangles().len(), 4);
        assert!((mesh.volume() - 1.0 / 6.0).abs() <= 1e-15);
    }

    /// The tetrahedron in binary, little-endian or not.
    fn in_binary(little: bool) -> Vec<u8> {
        let put = |bytes: &[u8]| {
            let mut bytes = bytes.to_vec();
            if !little {
                bytes.reverse();
            }
            bytes
        };
        let format = if little { "binary_little_endian" } else { "binary_big_endian" };
        let mut file = HEAD.replace("ascii", format).into_bytes();
        for (x, y, z) in [(0.0_f32, 0.0_f64, 0_i32), (1.0, 0.0, 0), (0.0, 1.0, 0), (0.0, 0.0, 1)] {
            file.extend(put(&x.to_le_bytes()));
            file.extend(put(&y.to_le_bytes()));
            file.extend(put(&z.to_le_bytes()));
            file.push(9);
        }
        file.extend(put(&7_i16.to_le_bytes()));
        for face in [[0_i32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
            file.push(3);
            face.iter().for_each(|i| file.extend(put(&i.to_le_bytes())));
        }
        file
    }

    #[test]
    fn a_tetrahedron_is_read_from_text_and_binary() {
        check(format!("{HEAD}{BODY}").as_bytes());
        check(format!("{HEAD}{BODY}\n\n").as_bytes());
        check(&in_binary(true));
        check(&in_binary(false));
    }

    #[test]
    fn what_is_cut_off_too_long_or_something_else_is_refused() {
        let text = format!("{HEAD}{BODY}");
        for length in 0..text.len() - 2 {
            let soup = Soup::read_ply(&text.as_bytes()[..length]);
            assert!(soup.is_err() || soup.and_then(Mesh::new).is_err(), "{length}");
        }
        let binary = in_binary(true);
        for length in 0..binary.len() {
            assert!(Soup::read_ply(&binary[..length]).is_err(), "{length}");
        }
        for long in [[text.as_bytes(), b"3 0 1 2\n"].concat(), [&binary[..], &[0]].concat()] {
            let error = Soup::read_ply(&long[..]).expect_err("too long").to_string();
            assert!(error.contains("goes on"), "{error}");
        }
        let error = Soup::read_ply(text.replace("0 1 0 9", "0 x 0 9").as_bytes());
        assert!(matches!(error, Err(CollisionError::Read { line: Some(16), .. })), "{error:?}");
        let crossed = text.replace("3 0 2 1", "5 0 1 2 3 0").replace("1 0 0 9", "3 0 0 9");
        assert!(Soup::read_ply(crossed.as_bytes()).and_then(Mesh::new).is_err());
    }

    #[test]
    fn elements_without_properties_are_refused() {
        let edges = "element edge 1\nproperty short vertex1\n";
        let head = HEAD.replace(edges, "element nothing 18446744073709551615\n");
        let head = head.replace("ascii", "binary_little_endian");
        let error = Soup::read_ply(head.as_bytes()).expect_err("endless").to_string();
        assert!(error.contains("nothing"), "{error}");
    }

    proptest! {
        #[test]
        fn changed_bytes_are_read_or_refused(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
            binary: bool,
        ) {
            let mut bytes = if binary { in_binary(true) } else { format!("{HEAD}{BODY}").into() };
            for (place, byte) in changes {
                *place.get_mut(&mut bytes) = byte;
            }
            let _ = Soup::read_ply(&bytes[..]).and_then(Mesh::new);
        }
    }
}
