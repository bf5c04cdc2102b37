//! Fields and forces of charges, against direct sums and closed forms.

mod charging;
mod common;
mod grid;
mod head;
mod points;
mod segments;
