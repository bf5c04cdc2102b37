use super::curl::Curl;
use crate::HairgenError;
use crate::error::choice;
use serde::{Deserialize, Serialize};

/// How hairs follow guides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum HairPattern {
    /// In wisps: each hair follows the guide whose root is nearest, at its root's place in a
    /// generalized cylinder around that. The cylinder's radius at the root follows from how densely
    /// the guides stand: the cells of their roots fill the scalp.
    Wisps {
        /// Radius of a wisp at its tip over that at its root; linear in between.
        tip: f64,
        /// Turns of the hairs around their guide over its length; to the right if positive.
        turns: f64,
    },
    /// Between guides: each hair is a mean of the three whose pores are nearest on the disc. No
    /// wisps are seen.
    Between,
}

/// How hairs are laid along the guides.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HairOptions {
    /// How hairs follow guides.
    pub pattern: HairPattern,
    /// Curls about the way along the guides; straight where it is left out.
    pub curl: Option<Curl>,
    /// Number of segments of a hair that is not cut.
    pub segments: usize,
    /// Distance that hairs keep from the head, m; it grows from zero over the first segments.
    pub clearance: f64,
    /// Arc length that a hair may be outside of the hull before it is cut, m.
    pub outside: f64,
}

impl Default for HairOptions {
    fn default() -> Self {
        Self {
            pattern: HairPattern::Wisps { tip: 0.5, turns: 0.0 },
            curl: None,
            segments: 49,
            clearance: 0.0005,
            outside: 0.005,
        }
    }
}

impl HairOptions {
    pub(crate) fn validate(&self) -> Result<(), HairgenError> {
        let count = |x: f64| (1.0..=1e4).contains(&x);
        let segments = self.segments as f64;
        choice("the number of segments of a hair", segments, "between 1 and 10000", count)?;
        choice("the clearance of the head (m)", self.clearance, "at least 0", |x| x >= 0.0)?;
        choice("the length outside of the hull (m)", self.outside, "at least 0", |x| x >= 0.0)?;
        if let Some(curl) = &self.curl {
            curl.validate()?;
        }
        if let HairPattern::Wisps { tip, turns } = self.pattern {
            choice("the wisps' tip over root", tip, "at least 0", |x| x >= 0.0)?;
            choice("the turns of a wisp", turns, "between -1000 and 1000", |x| x.abs() <= 1e3)?;
        }
        Ok(())
    }
}
