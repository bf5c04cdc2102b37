//! How charge comes onto fibres, and flows on them.

use crate::ElectrostaticsError;
use crate::error::{check_charges, check_count, check_positive};

/// Steps in which a charge is dealt (thesis 4.5 and Algorithm 2, `COMPSTEP`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChargeDealing {
    /// One step with the whole charge.
    Once,
    /// Number of equal steps.
    Equal(usize),
    /// Number of steps that fall as the differences of a logarithm: after h of n steps the share
    /// `ln(1 + h)/ln(1 + n)` is dealt. The thesis says no more of its steps than "logarithmically
    /// falling".
    Falling(usize),
}

impl ChargeDealing {
    /// Shares of the charge that the steps deal, all together 1; no steps deal nothing.
    #[must_use]
    pub fn shares(self) -> Vec<f64> {
        match self {
            Self::Once => vec![1.0],
            Self::Equal(steps) => vec![1.0 / steps as f64; steps],
            Self::Falling(steps) => {
                let dealt = |h: usize| (h as f64).ln_1p() / (steps as f64).ln_1p();
                (0..steps).map(|h| dealt(h + 1) - dealt(h)).collect()
            }
        }
    }
}

/// Flow of charge along one fibre, `dq/dt = d/ds((1/r) dPhi/ds)`, with the potential `Phi = q/c` of
/// its own charge per length and that of all others.
///
/// For dry hair charge is frozen; this is for humid hair. A uniform fibre whose root is at the head
/// loses its charge in the time `4 r c L^2/pi^2` by a factor of e.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChargeFlow {
    /// Resistance a length, ohm/m.
    pub resistance: f64,
    /// Capacity a length, F/m: about `2 pi epsilon0/ln(L/a)`, 19 pF/m for hair.
    pub capacity: f64,
    /// Potential of the head, V, if the root (the start of the first segment) touches it; the tip
    /// is insulated.
    pub head: Option<f64>,
}

impl ChargeFlow {
    /// Moves the `charges` (C) of segments of the given `lengths` (m), root first, on by the time
    /// `step` (s), while the charges of others make the potentials `outer` (V) at them. Returns the
    /// charge (C) that has gone to the head.
    ///
    /// Implicit Euler: stable for any step, with an error of first order; an insulated fibre keeps
    /// its charge to rounding. Cost: O(segments).
    ///
    /// # Errors
    /// Numbers that are not finite, arrays that do not fit, and a resistance, capacity, length or
    /// time that is not positive.
    pub fn advance(
        &self,
        lengths: &[f64],
        outer: &[f64],
        charges: &mut [f64],
        step: f64,
    ) -> Result<f64, ElectrostaticsError> {
        self.check(lengths, outer, charges, step)?;
        let count = charges.len();
        if count == 0 {
            return Ok(0.0);
        }
        // Conductances between neighbors, the head before the first and nothing behind the last.
        let conductance = |k: usize| {
            let root = 2.0 / (self.resistance * lengths[0]);
            match k {
                0 => {
                    if self.head.is_some() {
                        root
                    } else {
                        0.0
                    }
                }
                k if k == count => 0.0,
                k => 2.0 / (self.resistance * (lengths[k - 1] + lengths[k])),
            }
        };
        let capacity = |k: usize| self.capacity * lengths[k];
        let head = self.head.unwrap_or(0.0);
        // For the potentials V: C (V - outer) - q = step * what flows in. Thomas's algorithm, of
        // whose pivots the part beyond the next conductance is kept, so that nothing cancels in
        // long steps.
        let (mut pivots, mut right) = (vec![0.0; count], vec![0.0; count]);
        let before = step * conductance(0);
        let mut beyond = capacity(0) + before;
        right[0] = charges[0] + capacity(0) * outer[0] + before * head;
        pivots[0] = beyond + step * conductance(1);
        for k in 1..count {
            let before = step * conductance(k);
            let ratio = before / pivots[k - 1];
            beyond = capacity(k) + ratio * beyond;
            pivots[k] = beyond + step * conductance(k + 1);
            right[k] = charges[k] + capacity(k) * outer[k] + ratio * right[k - 1];
        }
        let start: f64 = charges.iter().sum();
        let mut above = 0.0;
        for k in (0..count).rev() {
            above = (right[k] + step * conductance(k + 1) * above) / pivots[k];
            charges[k] = capacity(k) * (above - outer[k]);
        }
        let left: f64 = charges.iter().sum();
        Ok(if self.head.is_some() { start - left } else { 0.0 })
    }

    /// Refuses numbers that are not finite or not positive, and arrays that do not fit.
    fn check(
        &self,
        lengths: &[f64],
        outer: &[f64],
        charges: &[f64],
        step: f64,
    ) -> Result<(), ElectrostaticsError> {
        check_count("lengths", lengths.len(), charges.len())?;
        check_count("outer potentials", outer.len(), charges.len())?;
        check_charges(charges, charges.len())?;
        let positive = [
            ("the resistance a length", self.resistance),
            ("the capacity a length", self.capacity),
            ("the time", step),
        ];
        let lengths = lengths.iter().map(|length| ("the length of a segment", *length));
        let mut all = positive.into_iter().chain(lengths);
        all.try_for_each(|(what, value)| check_positive(what, value))?;
        for value in outer.iter().copied().chain(self.head) {
            if !value.is_finite() {
                let (what, range) = ("a potential", "finite");
                return Err(ElectrostaticsError::Setting { what, value, range });
            }
        }
        Ok(())
    }
}
