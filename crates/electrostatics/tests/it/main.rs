//! Fields and forces of charges, against direct sums and closed forms.

mod charging;
mod common;
mod fiber_properties;
mod grid;
mod head;
mod point_properties;
mod points;
mod segments;
