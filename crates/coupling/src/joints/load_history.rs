//! Loads of joints at the ends of the last steps, from which those of the next are foretold.

use nalgebra::Vector3;

/// Loads of joints at one instant, by group, N and N m.
pub(super) type Loads = Vec<Vec<Vector3<f64>>>;

/// Most steps before the last that loads are foretold from.
const STEPS: usize = 2;

/// Loads before the last ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct LoadHistory {
    /// Length of the steps at whose ends they were, s.
    dt: f64,
    /// The latest first.
    before: Vec<Loads>,
}

impl LoadHistory {
    /// Loads that follow some at the start of a step of `dt` seconds: by the polynomial through
    /// them and those before, where steps were as long.
    pub(super) fn foretold(&self, last: &Loads, dt: f64) -> Loads {
        let mut next = last.clone();
        let known = if self.dt == dt { self.before.len() } else { 0 };
        // Of values one step apart: 2, -1; 3, -3, 1.
        let weights: &[f64] = match known {
            0 => return next,
            1 => &[2.0, -1.0],
            _ => &[3.0, -3.0, 1.0],
        };
        next.iter_mut().flatten().for_each(|load| *load *= weights[0]);
        for (before, weight) in self.before.iter().zip(&weights[1..]) {
            let each = next.iter_mut().flatten().zip(before.iter().flatten());
            each.for_each(|(load, before)| *load += *weight * before);
        }
        next
    }

    /// Notes the loads from which a step of `dt` seconds has set out.
    pub(super) fn note(&mut self, start: Loads, dt: f64) {
        if self.dt != dt {
            self.forget();
        }
        self.dt = dt;
        self.before.insert(0, start);
        self.before.truncate(STEPS);
    }

    /// Forgets what was before a start of the motion.
    pub(super) fn forget(&mut self) {
        self.before.clear();
    }

    /// All numbers, as many for all of joints with as many loads.
    pub(super) fn numbers(&self, loads: usize) -> Vec<f64> {
        let mut numbers = vec![self.dt, self.before.len() as f64];
        numbers.extend(self.before.iter().flatten().flatten().flatten());
        numbers.resize(Self::count(loads), 0.0);
        numbers
    }

    /// How many numbers there are with so many numbers of loads.
    pub(super) fn count(loads: usize) -> usize {
        2 + STEPS * loads
    }

    /// The history with these numbers of loads as some are; `None` if these are none.
    pub(super) fn of_numbers(numbers: &[f64], like: &Loads) -> Option<Self> {
        let (&[dt, known], rest) = numbers.split_first_chunk()?;
        let (vectors, _) = rest.as_chunks::<3>();
        let mut vectors = vectors.iter().map(|&load| load.into());
        let one = || like.iter().map(|own| vectors.by_ref().take(own.len()).collect()).collect();
        let all: Vec<Loads> = std::iter::repeat_with(one).take(STEPS).collect();
        let known = (0..=STEPS).find(|count| *count as f64 == known)?;
        Some(Self { dt, before: all[..known].to_vec() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Loads that follow a polynomial are foretold exactly, of the first degree after one step and
    /// of the second after two; after a step of another length the last ones stay.
    #[test]
    fn polynomials_are_foretold() {
        let at = |t: f64, degree: i32| vec![vec![Vector3::new(1.0, t, t.powi(degree))]; 2];
        let mut history = LoadHistory::default();
        assert_eq!(history.foretold(&at(1.0, 2), 0.5), at(1.0, 2));
        history.note(at(1.0, 1), 0.5);
        assert_eq!(history.foretold(&at(2.0, 1), 0.5), at(3.0, 1));
        let mut history = LoadHistory::default();
        (1..4).for_each(|i| history.note(at(f64::from(i), 2), 0.5));
        assert_eq!(history.foretold(&at(4.0, 2), 0.5), at(5.0, 2));
        assert_eq!(history.foretold(&at(4.0, 2), 0.25), at(4.0, 2));
        let numbers = history.numbers(6);
        assert_eq!(LoadHistory::of_numbers(&numbers, &at(0.0, 1)), Some(history));
    }
}
