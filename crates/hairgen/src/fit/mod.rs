//! From one scan of a head with its hair to what a hairstyle grows from: the bald head below, the
//! surface of the hair and the scalp within the hairline. The thesis takes this as given (5.3).

mod align;
mod cut;
mod deform;
mod scan;
mod similarity;
mod template;
mod view;

pub use scan::{fit, scalp_of};
pub use similarity::Similarity;
pub use template::{FitOptions, FitReport, FittedHead, HeadTemplate};
