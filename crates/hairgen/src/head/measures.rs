use serde::{Deserialize, Serialize};

/// Measures of a head, m.
///
/// The defaults are medians of British men of 19 to 65 years: 195 mm long, 155 mm broad, 225 mm
/// from chin to vertex (S. Pheasant, C. Haslegrave, Bodyspace, 3rd edition 2006).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HeadMeasures {
    /// Length from the forehead to the occiput, m.
    pub length: f64,
    /// Greatest breadth above the ears, m.
    pub breadth: f64,
    /// Height from the chin to the vertex, m.
    pub height: f64,
}

impl Default for HeadMeasures {
    fn default() -> Self {
        Self { length: 0.195, breadth: 0.155, height: 0.225 }
    }
}
