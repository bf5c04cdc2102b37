use nalgebra::Point;

/// The `COUNT` nearest of the `points` to a place, or all if they are fewer: their distances (m, or
/// what the points are given in) and their numbers, the nearest first; of equal ones the earlier.
pub(crate) fn nearest<const COUNT: usize, const D: usize>(
    place: &Point<f64, D>,
    points: impl Iterator<Item = Point<f64, D>>,
) -> Vec<(f64, usize)> {
    let mut near: Vec<(f64, usize)> = Vec::with_capacity(COUNT + 1);
    for (number, point) in points.enumerate() {
        let squared = (point - place).norm_squared();
        if near.len() < COUNT || near.last().is_some_and(|(farthest, _)| squared < *farthest) {
            let at = near.partition_point(|(distance, _)| *distance <= squared);
            near.insert(at, (squared, number));
            near.truncate(COUNT);
        }
    }
    near.into_iter().map(|(squared, number)| (squared.sqrt(), number)).collect()
}
