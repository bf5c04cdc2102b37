//! All hairs of a style, each out of its own pore, along the guides (thesis 5.3.5).

mod curl;
mod curves;
mod grow;
mod line;
mod options;
mod rein;

pub use curl::{Curl, CurlShape};
pub use curves::HairCurves;
pub use grow::grow_hairs;
pub use options::{HairOptions, HairPattern};
