//! Curves of USD, as text and binary: all `BasisCurves` of one layer where their ancestors put
//! them.
//!
//! A layer is read by itself, without what it refers to: sublayers, references, payloads, variants
//! and value clips are named in the report, not followed. The crate `openusd` follows them, but its
//! release for our compiler believes the counts and indices of a binary file, so that a damaged one
//! ends the program; and it decodes all samples of all attributes.

mod binary;
mod curves;
mod groom;
mod layer;
mod lexer;
mod marks;
mod packed;
mod rep;
mod text;
mod transform;

pub(crate) use marks::{BINARY_MARK, NAME, TEXT_MARK};

use crate::raw::RawStrands;
use crate::{ReadOptions, StrandsError};
use layer::UsdLayer;
use nalgebra::Matrix4;

pub(crate) fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawStrands, StrandsError> {
    let layer = if bytes.starts_with(BINARY_MARK) {
        binary::read(bytes, options.time)?
    } else if bytes.starts_with(TEXT_MARK) {
        text::read(bytes, options.time)?
    } else {
        let problem = "it begins neither with #usda nor as a binary layer; unpack a .usdz".into();
        return Err(StrandsError::Read { format: NAME, place: "the file".into(), problem });
    };
    let (meters_per_unit, up) = (layer.meters_per_unit, layer.up);
    let mut raw = RawStrands { meters_per_unit, up, ..RawStrands::default() };
    let fine = options.points_per_span;
    let mut places: Vec<Matrix4<f64>> = Vec::with_capacity(layer.prims.len());
    for (index, prim) in layer.prims.iter().enumerate() {
        let refuse = |problem: String| {
            let place = layer.path(index);
            StrandsError::Read { format: NAME, place, problem }
        };
        let own = transform::placement(prim).map_err(refuse)?;
        let parent = prim.parent.filter(|_| !own.is_reset);
        let place = parent.map_or(own.matrix, |parent| places[parent] * own.matrix);
        places.push(place);
        if !prim.is_shown {
            continue;
        }
        match prim.kind.as_str() {
            "BasisCurves" => groom::add(prim, &place, fine, &mut raw).map_err(refuse)?,
            "NurbsCurves" | "HermiteCurves" | "PointInstancer" => {
                raw.unread.push(format!("the {} at {}", prim.kind, layer.path(index)));
            }
            _ => {}
        }
    }
    let UsdLayer { unread, .. } = layer;
    raw.unread.extend(unread);
    if !raw.widths.is_empty() && raw.widths.len() != raw.points.len() {
        raw.widths.clear();
        raw.unread.push("the widths, because some curves have none".into());
    }
    Ok(raw)
}
