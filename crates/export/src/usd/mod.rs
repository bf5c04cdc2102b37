//! USD in text form: one stage of all that a run shows, metres, z up, a time code for each frame.
//!
//! The stage is a small [root](root()) with the layers of [strands](Strands), be they fibres or
//! springs, and of [objects](objects()) below it; each of them has the same range of time and can
//! be opened alone. Lengths are in single precision, as the schemas have them, with the fewest
//! digits that read back the same. Layers that would be large have their samples in value clips.
//! Curves have widths, velocities, `primvars:id`, which is the number of the strand, and
//! `primvars:d1`, the first axis of the section, of the segment that begins at the point.
//! The binary form, `.usdc`, is not written: there is no library for it yet that this workspace's
//! Rust compiles.

mod objects;
mod prim;
mod strands;
#[cfg(test)]
mod tests;

pub use objects::write as objects;
pub use prim::{Clips, Prim, PrimShape};
pub use strands::Strands;

use super::ExportError;
use std::io::Write;

/// Name of the prim that contains all others.
const ROOT: &str = "Scene";

/// Times of the frames of a series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timeline {
    /// Number of frames, at least one.
    pub frames: usize,
    /// Frames and time codes per second, 1/s.
    pub rate: f64,
    /// Time of the last frame, s; all others are at whole time codes.
    pub end: f64,
}

/// Largest distance of the last frame from a whole time code at which it counts as being on it: its
/// time is a sum of steps with rounding errors.
const ROUNDING: f64 = 1e-6;

impl Timeline {
    /// Time code of a frame.
    fn code(&self, frame: usize) -> f64 {
        if frame + 1 < self.frames {
            return frame as f64;
        }
        let code = self.end * self.rate;
        if (code - code.round()).abs() < ROUNDING { code.round() } else { code }
    }

    /// Time code of the last frame.
    fn last(&self) -> f64 {
        self.code(self.frames.saturating_sub(1))
    }

    /// Writes the beginning of a layer; `more` are lines of its metadata.
    fn begin(&self, out: &mut impl Write, more: &str) -> Result<(), ExportError> {
        let Self { rate, .. } = self;
        let end = self.last();
        write!(
            out,
            r#"#usda 1.0
(
    defaultPrim = "{ROOT}"
    startTimeCode = 0
    endTimeCode = {end}
    timeCodesPerSecond = {rate}
    framesPerSecond = {rate}
    metersPerUnit = 1
    upAxis = "Z"
{more})
"#
        )?;
        Ok(())
    }
}

/// Writes the root of a stage over the files of its layers, given relative to the root's folder.
///
/// # Errors
/// If `out` fails.
pub fn root(out: &mut impl Write, timeline: &Timeline, layers: &[&str]) -> Result<(), ExportError> {
    let layers: Vec<_> = layers.iter().map(|layer| format!("        @./{layer}@")).collect();
    timeline.begin(out, &format!("    subLayers = [\n{}\n    ]\n", layers.join(",\n")))
}

/// Writes the material of a plain surface at `path`, whose last part is `name`.
fn material(
    out: &mut impl Write,
    path: &str,
    name: &str,
    color: [f64; 3],
) -> Result<(), ExportError> {
    let [r, g, b] = color;
    write!(
        out,
        r#"            def Material "{name}"
            {{
                token outputs:surface.connect = <{path}/{name}/Surface.outputs:surface>
                def Shader "Surface"
                {{
                    uniform token info:id = "UsdPreviewSurface"
                    color3f inputs:diffuseColor = ({r}, {g}, {b})
                    float inputs:roughness = 0.4
                    token outputs:surface
                }}
            }}
"#
    )?;
    Ok(())
}

/// Writes the beginning of a prim of a layer's scope, with its colour and material.
fn begin_prim(
    out: &mut impl Write,
    kind: &str,
    name: &str,
    material: &str,
    color: [f64; 3],
) -> Result<(), ExportError> {
    let [r, g, b] = color;
    write!(
        out,
        r#"        def {kind} "{name}" (
            prepend apiSchemas = ["MaterialBindingAPI"]
        )
        {{
            rel material:binding = <{material}>
            color3f[] primvars:displayColor = [({r}, {g}, {b})]
"#
    )?;
    Ok(())
}
