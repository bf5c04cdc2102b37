use crate::options::ReadOptions;
use crate::{StrandReport, StrandSet, StrandsError, data, hair, obj, ply, usd};

/// Formats of strands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum StrandFormat {
    /// Cem Yuksel's binary format, `.hair`.
    Hair,
    /// The binary format of USC-HairSalon, `.data`.
    Data,
    /// USD, as text or binary: `.usda`, `.usdc` or `.usd`.
    Usd,
    /// Point sets or edges in PLY, as text or binary.
    Ply,
    /// Lines in Wavefront OBJ.
    Obj,
}

impl StrandFormat {
    /// The format of files with this extension, in upper or lower case, without a dot.
    #[must_use]
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "hair" => Some(Self::Hair),
            "data" => Some(Self::Data),
            "usd" | "usda" | "usdc" => Some(Self::Usd),
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            _ => None,
        }
    }

    /// The format that the first bytes tell; `.data` has no mark of its own and is told by its
    /// counts, which must lead from strand to strand to the end of the file.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let is = |mark: &[u8]| bytes.starts_with(mark);
        if is(hair::MARK) {
            Some(Self::Hair)
        } else if is(usd::BINARY_MARK) || is(usd::TEXT_MARK) {
            Some(Self::Usd)
        } else if is(b"ply\n") || is(b"ply\r") {
            Some(Self::Ply)
        } else if obj::is_likely(bytes) {
            Some(Self::Obj)
        } else {
            data::is_likely(bytes).then_some(Self::Data)
        }
    }
}

/// Strands of a file, with what the reader has to say of them.
#[derive(Debug, Clone, PartialEq)]
pub struct StrandFile {
    /// Strands that can be hairs (world: meter, y up).
    pub strands: StrandSet,
    /// What was found, assumed and left out.
    pub report: StrandReport,
}

impl StrandFile {
    /// Reads the bytes of a file; without a `format` it is told from the bytes.
    ///
    /// A strand that cannot be a hair is left out and reported by its number. Cost: linear in the
    /// bytes, in memory too, whatever their counts say.
    ///
    /// # Errors
    /// [`StrandsError::Unknown`] if the format cannot be told, [`StrandsError::Option`] for options
    /// out of range, [`StrandsError::CutOff`] and [`StrandsError::Read`], with the place, for files
    /// that break the rules of their format or hold no strands.
    pub fn read(
        bytes: &[u8],
        format: Option<StrandFormat>,
        options: &ReadOptions,
    ) -> Result<Self, StrandsError> {
        options.check()?;
        let told = || StrandFormat::from_bytes(bytes).ok_or(StrandsError::Unknown);
        let (raw, name, unit) = match format.map_or_else(told, Ok)? {
            StrandFormat::Hair => (hair::read(bytes)?, hair::NAME, 1.0),
            StrandFormat::Data => (data::read(bytes)?, data::NAME, 1.0),
            StrandFormat::Usd => (usd::read(bytes, options)?, usd::NAME, 0.01),
            StrandFormat::Ply => (ply::read(bytes, options)?, ply::NAME, 1.0),
            StrandFormat::Obj => (obj::read(bytes)?, obj::NAME, 1.0),
        };
        if raw.counts.is_empty() {
            let problem = match &raw.unread[..] {
                [] => "it holds no strands".to_owned(),
                unread => format!("it holds no strands itself, but {}", unread.join("; ")),
            };
            return Err(StrandsError::Read { format: name, place: "the file".into(), problem });
        }
        let (strands, report) = raw.sorted(name, unit, options);
        Ok(Self { strands, report })
    }
}
