use serde::{Deserialize, Serialize};
use std::fmt;

/// One of the two that touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum BodyRef {
    /// A fibre, which may touch itself.
    Fiber(u32),
    /// An object of the scene.
    Object(u32),
}

impl BodyRef {
    pub(crate) fn is_object(&self) -> bool {
        matches!(self, Self::Object(_))
    }
}

impl fmt::Display for BodyRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fiber(fiber) => write!(f, "fibre {fiber}"),
            Self::Object(object) => write!(f, "objects[{object}]"),
        }
    }
}
