//! Lines in Wavefront OBJ.

use crate::StrandsError;
use crate::chains::joined;
use crate::raw::RawStrands;
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::Obj;

pub(crate) const NAME: &str = "OBJ";

/// Every line is a strand; if all are single edges, those that share points are joined.
pub(crate) fn read(bytes: &[u8]) -> Result<RawStrands, StrandsError> {
    let Obj { points, lines, .. } = Obj::read(bytes).map_err(refuse)?;
    let edges: Vec<_> = lines.iter().filter_map(|l| l.points.first_chunk::<2>().copied()).collect();
    if lines.iter().all(|line| line.points.len() == 2) {
        return Ok(joined(&edges, &points, &[]));
    }
    let all = lines.iter().flat_map(|line| &line.points);
    Ok(RawStrands {
        counts: lines.iter().map(|line| line.points.len()).collect(),
        points: all.map(|&point| points[point as usize]).collect(),
        ..RawStrands::default()
    })
}

fn refuse(error: CollisionError) -> StrandsError {
    match error {
        CollisionError::Read { line, problem, .. } => {
            let place = line.map_or_else(|| "the file".into(), |line| format!("line {line}"));
            StrandsError::Read { format: NAME, place, problem }
        }
        other => {
            let (place, problem) = ("the file".into(), other.to_string());
            StrandsError::Read { format: NAME, place, problem }
        }
    }
}

/// Whether the first statement of a text is one of OBJ.
pub(crate) fn is_likely(bytes: &[u8]) -> bool {
    let words = ["v", "vt", "vn", "o", "g", "s", "l", "f", "mtllib", "usemtl"];
    let mut lines = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && line[0] != b'#').unwrap_or_default();
    let word = first.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    words.iter().any(|known| known.as_bytes() == word) && first.len() > word.len()
}
