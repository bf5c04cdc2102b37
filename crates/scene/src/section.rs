use super::check::{Allowed, Check};
use rapunzel_fiber::Section;

/// Reports problems of the section of a fibre of a length.
pub(crate) fn check_section(check: &mut Check, section: &Section, length: f64) {
    // A rod must be slender, and a NaN length has been refused already.
    let thickest = if length > 0.0 { length / 10.0 } else { f64::MAX };
    let size = |c: &mut Check, name: &str, value| {
        c.number(name, value, Allowed::Positive, "m");
        if value > thickest {
            let message = format!(
                "is {value:?}, but must be at most {thickest:?} (m), a tenth of the length: \
                 a fibre is slender"
            );
            c.refuse(name, message);
        }
    };
    match *section {
        Section::Circle { radius } => size(check, "radius", radius),
        Section::Ellipse { a, b } => {
            size(check, "a", a);
            size(check, "b", b);
        }
    }
}
