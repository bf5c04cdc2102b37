//! What holds bodies together at a contact; both feed [`crate::Contact::adhesion`].
mod bond;
mod capillary;

pub use bond::Bond;
pub use capillary::{Cylinders, wet_pair_energy};

use crate::ContactError;

fn positive(what: &'static str, value: f64) -> Result<f64, ContactError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(ContactError::Invalid { what, value, why: "it must be finite and positive" })
    }
}
