//! Points, polygons and lines from Wavefront OBJ.

use super::Soup;
use crate::CollisionError;
use nalgebra::Point3;
use std::io::Read;

/// What an OBJ holds, of all its objects and groups together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Obj {
    /// The points, in the order of the file.
    pub points: Vec<Point3<f64>>,
    /// The faces.
    pub faces: Vec<ObjPolyline>,
    /// The lines.
    pub lines: Vec<ObjPolyline>,
}

/// Points that a line of an OBJ joins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObjPolyline {
    /// Number of the line in the file, from 1.
    pub line: usize,
    /// Indices of points, from 0.
    pub points: Vec<u32>,
}

impl Obj {
    /// Reads an OBJ. Numbers may count from the end; colours and weights after the coordinates,
    /// texture, normals, materials and whatever is not known are ignored.
    ///
    /// # Errors
    /// [`CollisionError::Read`], with the line, for a point without three numbers, and a face or
    /// line with a number that is that of no point.
    pub fn read(mut source: impl Read) -> Result<Self, CollisionError> {
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes).map_err(|error| refuse(None, error.to_string()))?;
        // Names may be in other encodings; some editors begin a text with a byte order mark.
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim_start_matches('\u{feff}');
        let mut obj = Self::default();
        let mut statement = String::new();
        for (line, part) in (1..).zip(text.lines()) {
            let part = part.split('#').next().unwrap_or_default().trim_end();
            // A line may go on in the next.
            match part.strip_suffix('\\') {
                Some(part) => statement = statement + part + " ",
                None if statement.is_empty() => obj.take(line, part)?,
                None => obj.take(line, &(std::mem::take(&mut statement) + part))?,
            }
        }
        let count = obj.points.len();
        let is_missing = |chain: &&ObjPolyline| chain.points.iter().any(|&p| p as usize >= count);
        match obj.faces.iter().chain(&obj.lines).find(is_missing) {
            None => Ok(obj),
            Some(chain) => {
                Err(refuse(Some(chain.line), format!("it joins a point beyond the {count}")))
            }
        }
    }

    fn take(&mut self, line: usize, statement: &str) -> Result<(), CollisionError> {
        let mut words = statement.split_ascii_whitespace();
        let kind = words.next();
        match kind {
            Some("v") => {
                let numbers = [(); 3].map(|()| words.next()?.parse().ok());
                let [Some(x), Some(y), Some(z)] = numbers else {
                    return Err(refuse(Some(line), "a point must have three numbers".into()));
                };
                self.points.push(Point3::new(x, y, z));
            }
            Some("f" | "l") => {
                let count = self.points.len();
                let points = words.map(|word| number(word, count)).collect::<Option<_>>();
                let problem = || "points are joined by their numbers, from 1 or from the end";
                let points = points.ok_or_else(|| refuse(Some(line), problem().into()))?;
                let chains = if kind == Some("f") { &mut self.faces } else { &mut self.lines };
                chains.push(ObjPolyline { line, points });
            }
            _ => {}
        }
        Ok(())
    }
}

fn refuse(line: Option<usize>, problem: String) -> CollisionError {
    CollisionError::Read { format: "OBJ", line, problem }
}

/// The index of the point in a reference like `7`, `-1` or `7/2/3`, after `count` points.
fn number(word: &str, count: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let index =
        if number < 0 { i64::try_from(count).ok()?.checked_add(number)? } else { number - 1 };
    u32::try_from(index).ok()
}

impl Soup {
    /// Reads all faces of a Wavefront OBJ, of all its objects together, on shared vertices.
    /// Polygons, also concave ones, become triangles.
    ///
    /// # Errors
    /// [`CollisionError::Read`], as [`Obj::read`], and for a polygon that meets itself.
    pub fn read_obj(source: impl Read) -> Result<Self, CollisionError> {
        let Obj { points, faces, .. } = Obj::read(source)?;
        let mut soup = Self { vertices: points, triangles: Vec::with_capacity(faces.len()) };
        for ObjPolyline { line, points } in faces {
            soup.polygon(points)
                .map_err(|problem| refuse(Some(line), format!("the face {problem}")))?;
        }
        Ok(soup)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Mesh;
    use proptest::prelude::*;

    fn read(text: &str) -> Obj {
        Obj::read(text.as_bytes()).expect("an OBJ")
    }

    #[test]
    fn faces_of_all_groups_share_their_vertices() {
        let text = "\u{feff}v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0\no first\nusemtl red\n\
            f 1/1/1 3//2 2\nl 1 2\ng second\nf 1 2 \\\n 4 # the last\nv 0 0 1\nf -4 -1 -2\nusemtl blue\nf 2 3 4\n";
        let mesh = Mesh::new(Soup::read_obj(text.as_bytes()).expect("an OBJ")).expect("closed");
        assert_eq!((mesh.triangles().len(), mesh.vertices().len()), (4, 4));
        assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-15);
        assert_eq!(read(text).lines, [ObjPolyline { line: 7, points: vec![0, 1] }]);
        assert_eq!(read(text).faces[1].line, 10);
    }

    /// An L-shaped prism, whose ends are concave hexagons: three boxes of 1 x 1 x 2.
    #[test]
    fn concave_faces_have_their_area() {
        let outline = [[1, 1], [0, 1], [0, 0], [2, 0], [2, 2], [1, 2]];
        let point = |z: i32| outline.map(|[x, y]| format!("v {x} {y} {z}\n")).concat();
        let side = |k: usize| {
            let next = k % 6 + 1;
            format!("f {k} {next} {} {}\n", next + 6, k + 6)
        };
        let sides: String = (1..=6).map(side).collect();
        let text = point(0) + &point(2) + &sides + "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
        let mesh = Mesh::new(Soup::read_obj(text.as_bytes()).expect("an OBJ")).expect("closed");
        assert!((mesh.volume() - 6.0).abs() < 1e-14);
        assert_eq!(mesh.triangles().len(), 20);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, line) in [
            ("v 1 2\n", 1),
            ("v 1 2 x\n", 1),
            ("v 1 2 3\n\nf 1 2 3\n", 3),
            ("v 1 2 3\nf 0 1 1\n", 2),
            ("v 1 2 3\nf -2 1 1\n", 2),
            ("v 1 2 3\nl 1 a\n", 2),
            ("v 1 2 3\nl 1 99999999999\n", 2),
            ("v 0 0 0\nv 2 0 0\nv 0 1 0\nv 1 1.5 0\nv 0.5 -1 0\nf 1 2 3 4 5\n", 6),
        ] {
            let error = Soup::read_obj(text.as_bytes()).expect_err(text);
            assert!(
                matches!(error, CollisionError::Read { line: Some(at), .. } if at == line),
                "{text}: {error}"
            );
        }
        for text in ["", "o", "nothing\nat all", "v nan 0 0\nf 1 1 1", "v 0 0 0\nf 1 1 1"] {
            let soup = Soup::read_obj(text.as_bytes()).expect("no more is known of it");
            assert!(Mesh::new(soup).is_err(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(
            text in "([vfl#] ?(-?[0-9]{1,3}(\\.[0-9])?[/ \\\\]?){0,6}\n?){0,9}",
        ) {
            let _ = Soup::read_obj(text.as_bytes()).and_then(Mesh::new);
        }
    }
}
