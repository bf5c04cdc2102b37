//! Meshes from STL.

use super::Soup;
use super::mesh::index;
use crate::CollisionError;
use nalgebra::Point3;
use std::collections::BTreeMap;
use std::io::Read;

/// Bytes before the first triangle of a binary file, and of each triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

impl Soup {
    /// Reads STL, text or binary, all of its solids together. Equal vertices are merged; names,
    /// normals and colours are ignored.
    ///
    /// A file is binary if it is as long as the count in its head tells, whatever it begins with:
    /// some programs begin binary files with `solid` as texts do.
    ///
    /// # Errors
    /// [`CollisionError::Read`] if it is no STL, cut off, or longer than its head tells.
    pub fn read_stl(mut source: impl Read) -> Result<Self, CollisionError> {
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes).map_err(|error| refuse(None, error.to_string()))?;
        let count = bytes.get(HEAD - 4..HEAD).map(|count| u32_of(count) as usize);
        let told = count.map(|count| HEAD + TRIANGLE * count);
        let begin = bytes.trim_ascii_start();
        let is_text = begin.len() >= 5 && begin[..5].eq_ignore_ascii_case(b"solid");
        let corners = match told {
            Some(told) if told == bytes.len() => binary(&bytes),
            // Numbers and the padding of the head have bytes of zero.
            _ if is_text && !bytes.contains(&0) => text(&String::from_utf8_lossy(&bytes))?,
            Some(told) => {
                let problem = format!(
                    "its head tells of {} triangles, {told} bytes in all, but it has {}: it is cut \
                     off, or damaged",
                    count.unwrap_or_default(),
                    bytes.len()
                );
                return Err(refuse(None, problem));
            }
            None => return Err(refuse(None, "it is no text, and shorter than a head".into())),
        };
        Ok(Self::merged(&corners))
    }

    /// Triangles from their corners in threes, equal ones as one vertex.
    fn merged(corners: &[[f32; 3]]) -> Self {
        let mut soup = Self::default();
        let mut known = BTreeMap::new();
        let mut vertex = |corner: &[f32; 3]| {
            // The two zeros are one place.
            let place = corner.map(|x| (x + 0.0).to_bits());
            *known.entry(place).or_insert_with(|| {
                soup.vertices.push(Point3::from(corner.map(f64::from)));
                index(soup.vertices.len() - 1)
            })
        };
        soup.triangles = corners
            .as_chunks()
            .0
            .iter()
            .map(|triangle: &[_; 3]| triangle.each_ref().map(&mut vertex))
            .collect();
        soup
    }
}

fn refuse(line: Option<usize>, problem: String) -> CollisionError {
    CollisionError::Read { format: "STL", line, problem }
}

fn u32_of(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte))
}

/// Corners of the triangles of a binary file, whose length has been checked.
fn binary(bytes: &[u8]) -> Vec<[f32; 3]> {
    let numbers =
        |corner: &[u8; 12]| [0, 4, 8].map(|at| f32::from_bits(u32_of(&corner[at..at + 4])));
    let (triangles, _) = bytes[HEAD..].as_chunks::<TRIANGLE>();
    // The normal is first; two bytes come after the corners.
    triangles.iter().flat_map(|triangle| triangle[12..48].as_chunks().0).map(numbers).collect()
}

/// Corners of the triangles of a text.
fn text(text: &str) -> Result<Vec<[f32; 3]>, CollisionError> {
    let mut corners = Vec::new();
    // Whether a solid is open, and the corners before the open facet.
    let (mut solid, mut facet) = (false, None);
    for (number, line) in (1..).zip(text.lines()) {
        let refuse = |problem: &str| Err(refuse(Some(number), problem.into()));
        let mut words = line.split_whitespace();
        let Some(word) = words.next() else { continue };
        let mut word = word.to_ascii_lowercase();
        if word == "end" {
            word += &words.next().unwrap_or_default().to_ascii_lowercase();
        }
        match (word.as_str(), solid, facet) {
            ("solid", false, _) => solid = true,
            ("endsolid", true, None) => solid = false,
            ("facet", true, None) => facet = Some(corners.len()),
            ("outer" | "endloop", true, Some(_)) => {}
            ("endfacet", true, Some(first)) => {
                if corners.len() != first + 3 {
                    return refuse("a facet must have three corners");
                }
                facet = None;
            }
            ("vertex", true, Some(_)) => {
                let numbers: Result<Vec<f32>, _> = words.map(str::parse).collect();
                match numbers.as_deref() {
                    Ok(&[x, y, z]) => corners.push([x, y, z]),
                    _ => return refuse("a vertex must have three numbers"),
                }
            }
            _ => return refuse(&format!("`{word}` has no place here")),
        }
    }
    if solid {
        return Err(refuse(None, "it is cut off: its last solid has no end".into()));
    }
    Ok(corners)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Mesh, shapes};
    use nalgebra::Vector3;
    use proptest::prelude::*;

    /// Two boxes of 1 x 2 x 3, 4 m apart.
    fn boxes() -> [Soup; 2] {
        [0.0, 4.0].map(|x| {
            let mut soup = shapes::cuboid(Vector3::new(0.5, 1.0, 1.5));
            soup.vertices.iter_mut().for_each(|p| p.x += x);
            soup
        })
    }

    fn facets(soup: &Soup) -> String {
        let facet = |t: &[u32; 3]| {
            let vertex = |p: Point3<f64>| format!("vertex {} {:e} {}\n", p.x, p.y, p.z);
            let corners: String = soup.corners(*t).map(vertex).concat();
            format!("facet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\n")
        };
        soup.triangles.iter().map(facet).collect()
    }

    fn in_text() -> String {
        let [first, second] = boxes().map(|soup| facets(&soup));
        format!("solid a 'b c\n{first}endsolid a\n\nsolid\n{second}endsolid\n")
    }

    fn in_binary(head: &[u8]) -> Vec<u8> {
        let mut bytes = head.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(24_u32.to_le_bytes());
        for soup in boxes() {
            for &triangle in &soup.triangles {
                bytes.extend([0; 12]);
                for corner in soup.corners(triangle) {
                    #[expect(clippy::cast_possible_truncation, reason = "few digits")]
                    bytes.extend(corner.iter().flat_map(|&x| (x as f32).to_le_bytes()));
                }
                bytes.extend([0; 2]);
            }
        }
        bytes
    }

    fn check(bytes: &[u8]) {
        let mesh = Mesh::new(Soup::read_stl(bytes).expect("an STL")).expect("closed");
        assert_eq!((mesh.triangles().len(), mesh.vertices().len()), (24, 16));
        assert!((mesh.volume() - 12.0).abs() < 1e-12);
    }

    #[test]
    fn all_solids_of_a_text_are_read_in_any_dialect() {
        check(in_text().as_bytes());
        check(in_text().to_uppercase().as_bytes());
        check(in_text().replace("endsolid", "end solid").replace("endloop", "end loop").as_bytes());
        check(in_text().replace('\n', "\r\n").as_bytes());
        check(format!("\n  {}", in_text().replace("vertex", "\tvertex")).as_bytes());
        // A name in Latin-1.
        check(&in_text().bytes().map(|b| if b == b'\'' { 0xE9 } else { b }).collect::<Vec<_>>());
    }

    #[test]
    fn a_binary_file_may_begin_with_anything() {
        for head in [&b"binary"[..], b"solid part1", b"SOLID\n", b"", &[0; 80]] {
            check(&in_binary(head));
        }
    }

    #[test]
    fn what_is_cut_off_too_long_or_something_else_is_refused() {
        let (text, binary) = (in_text(), in_binary(b"solid"));
        let cut = text.rfind("endsolid").expect("an end");
        let first = text.find("\n\n").expect("a blank line");
        for length in (first + 7..cut).step_by(7) {
            assert!(Soup::read_stl(&text.as_bytes()[..length]).is_err(), "{length}");
        }
        for length in (1..binary.len()).step_by(3) {
            assert!(Soup::read_stl(&binary[..length]).is_err(), "{length}");
        }
        let long = [&binary[..], &[7; 50]].concat();
        let error = Soup::read_stl(&long[..]).expect_err("too long").to_string();
        assert!(error.contains("1284 bytes in all, but it has 1334"), "{error}");
        for (bad, line) in [
            ("solid\nfacet\nvertex 1 2\n", 3),
            ("solid\nfacet\nouter loop\nvertex 1 2 3\nendloop\nendfacet\nendsolid", 6),
            ("solid\nfacet\nfacet", 3),
            ("solid\nvertex 1 2 3", 2),
            ("solid\nendfacet", 2),
            ("solid\nsolid\n", 2),
            ("solid a\nendsolid\nvertex 0 0 0", 3),
            ("solid a\nwhat", 2),
        ] {
            let error = Soup::read_stl(bad.as_bytes()).expect_err(bad);
            assert!(
                matches!(error, CollisionError::Read { line: Some(at), .. } if at == line),
                "{bad}: {error}"
            );
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = Soup::read_stl(&bytes[..]);
            let text = String::from_utf8_lossy(&bytes);
            let _ = Soup::read_stl(format!("solid\nfacet\nvertex {text}").as_bytes());
        }
    }
}
