//! SI and Gaussian units.
//!
//! The crate takes and gives SI. The thesis's charges, `7.7e-4`, bear no unit; with its Coulomb
//! constant of 1 they are read as statcoulomb per centimeter, because then the field inside of its
//! tress is the "about 13 kV/m" that it states. Nanocoulomb per centimeter would give 38 kV/m,
//! coulomb per meter more than air can bear by a factor of 1e5. What follows: that is the field
//! *inside*; at the 12 cm at which Patel measured 20 to 120 kV/m the same charges make 0.86 kV/m,
//! so the agreement that the thesis states is a mix-up.

/// Coulomb's constant `1/(4 pi epsilon0)`, N m^2/C^2 (CODATA 2018).
pub const COULOMB_CONSTANT: f64 = 8.987_551_792_3e9;

/// A charge in statcoulomb (Gaussian units) in C: 1 statC is 10/c coulomb, c in cm/s.
#[must_use]
pub fn statcoulomb(charge: f64) -> f64 {
    charge * (10.0 / 29_979_245_800.0)
}

/// A line density in statC/cm in C/m.
#[must_use]
pub fn statcoulomb_per_centimeter(density: f64) -> f64 {
    statcoulomb(density) * 100.0
}

/// The thesis's charge of a hair, `7.7e-4` statC/cm (its sign is negative), C/m.
pub const THESIS_LINE_DENSITY: f64 = -7.7e-4 * 10.0 / 29_979_245_800.0 * 100.0;
