//! Anderson's acceleration of a fixed-point iteration (1965), which for linear equations is the
//! method of generalized minimal residuals.

use std::collections::VecDeque;

/// A change of the residual is used if by more than this part of it it is not a sum of older ones.
const INDEPENDENT: f64 = 1e-6;

/// The last iterates and residuals of `x -> x + r(x)`.
#[derive(Debug)]
pub(crate) struct AndersonAcceleration {
    /// Most changes that are kept.
    depth: usize,
    last: Option<[Vec<f64>; 2]>,
    /// Changes of the residual, oldest first, made orthonormal, with the changes of the iterate
    /// that go with them.
    changes: VecDeque<[Vec<f64>; 2]>,
}

impl AndersonAcceleration {
    pub(crate) fn new(depth: usize) -> Self {
        Self { depth, last: None, changes: VecDeque::new() }
    }

    /// Forgets all but the last iterate.
    pub(crate) fn forget(&mut self) {
        self.changes.clear();
    }

    /// The step from the iterate `x` with the residual `r` to the next: to where, as far as the
    /// last changes tell, the residual is least, and by that residual from there.
    pub(crate) fn step(&mut self, x: &[f64], r: &[f64]) -> Vec<f64> {
        if let Some([mut dx, mut dr]) = self.last.take() {
            for (change, now) in [(&mut dx, x), (&mut dr, r)] {
                change.iter_mut().zip(now).for_each(|(last, now)| *last = now - *last);
            }
            self.remember(dx, dr);
        }
        self.last = Some([x.to_vec(), r.to_vec()]);
        let (mut step, mut rest) = (vec![0.0; x.len()], r.to_vec());
        for [dx, dr] in &self.changes {
            let share = dot(dr, &rest);
            add(&mut step, -share, dx);
            add(&mut rest, -share, dr);
        }
        add(&mut step, 1.0, &rest);
        step
    }

    /// Adds a change to those that are kept, by Gram and Schmidt's method.
    fn remember(&mut self, mut dx: Vec<f64>, mut dr: Vec<f64>) {
        let size = dot(&dr, &dr).sqrt();
        // Twice is enough (Kahan).
        for [bx, br] in self.changes.iter().chain(&self.changes) {
            let share = dot(br, &dr);
            add(&mut dx, -share, bx);
            add(&mut dr, -share, br);
        }
        let left = dot(&dr, &dr).sqrt();
        if left <= INDEPENDENT * size {
            return;
        }
        dx.iter_mut().chain(dr.iter_mut()).for_each(|x| *x /= left);
        self.changes.push_back([dx, dr]);
        if self.changes.len() > self.depth {
            self.changes.pop_front();
        }
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `to += factor * what`.
pub(crate) fn add(to: &mut [f64], factor: f64, what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(to, what)| *to += factor * what);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear equations are solved in as many steps as they have unknowns, also where the plain
    /// iteration diverges.
    #[test]
    fn linear_equations_are_solved_like_by_minimal_residuals() {
        let n = 8;
        let matrix = |i: usize, j: usize| {
            if i == j { 1.5 + i as f64 } else { 0.3 * ((i * n + j) as f64).sin() }
        };
        let residual = |x: &[f64]| -> Vec<f64> {
            (0..n).map(|i| 1.0 - (0..n).map(|j| matrix(i, j) * x[j]).sum::<f64>()).collect()
        };
        let (mut anderson, mut x) = (AndersonAcceleration::new(n), vec![0.0; n]);
        for _ in 0..=n {
            let step = anderson.step(&x, &residual(&x));
            add(&mut x, 1.0, &step);
        }
        let left = residual(&x);
        assert!(dot(&left, &left).sqrt() < 1e-10, "{left:?}");
        let mut plain = AndersonAcceleration::new(n);
        assert_eq!(plain.step(&x, &left), left, "without memory it is the plain iteration");
    }
}
