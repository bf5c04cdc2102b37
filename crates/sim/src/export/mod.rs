//! Frames of a simulation as files that other programs open.
//!
//! | module | file | for |
//! |---|---|---|
//! | [`vtp`] | VTK poly data, everything at full precision; the one format that is read back | ParaView |
//! | [`pvd`] | the times of a series of them | ParaView |
//! | [`usd`] | USD as text, all frames in one stage, with objects | Blender, Houdini, usdview |
//! | [`hair`] | Cem Yuksel's binary format; it holds fibres alone | LuxCore, hair tools |
//! | [`pov`] | POV-Ray scene description, with objects | POV-Ray |
//! | [`surface`] | surfaces of objects as VTK poly data, and their poses | ParaView |
//! | [`preview`] | a contact sheet as PNG | eyes |
//!
//! Writers take any [`std::io::Write`], [`vtp`] one that can [seek](std::io::Seek), check what they are given and never touch a file system.
//! Because a `vtp` holds a whole frame, the files of a whole series can be made at the end of a
//! run, or after its crash, from those.

mod error;
mod frame;
pub mod hair;
pub mod pov;
pub mod preview;
pub mod pvd;
#[cfg(test)]
mod sample;
pub mod surface;
pub mod usd;
pub mod vtp;

pub use error::ExportError;
pub use frame::{Frame, Strand};
