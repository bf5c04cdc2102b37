//! Lines along the electric field.

use nalgebra::{Point3, Vector3};
use rapunzel_export::Strand;
use rapunzel_sim::{SimError, World};

/// Points of a line, world, m.
pub(crate) type FieldLine = Vec<Point3<f64>>;

/// Points along each side of the grid on which the field is asked for: as many in all as the sums
/// go through one by one.
const SIDE: usize = 16;
/// Lines at most.
const LINES: usize = 40;
/// Step along a line, over the distance of points of the grid, and steps at most.
const STEP: f64 = 0.3;
const STEPS: usize = 120;
/// Width of the grid over that of what is charged.
const WIDE: f64 = 2.0;

/// A field that is known on a cube of points.
struct FieldCube {
    low: Point3<f64>,
    spacing: f64,
    fields: Vec<Vector3<f64>>,
}

/// Lines that begin at nodes spread over all strands and follow the field both ways, as it is
/// between the points of a coarse grid: near fibres they do not show the field of each. Cost: one
/// call of the electric field.
///
/// # Errors
/// Those of [`World::electric_fields`].
pub(crate) fn field_lines(world: &World, strands: &[Strand]) -> Result<Vec<FieldLine>, SimError> {
    let points = || strands.iter().flat_map(|strand| &strand.points);
    let Some(first) = points().next() else { return Ok(Vec::new()) };
    let (low, high) = points().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    let middle = nalgebra::center(&low, &high);
    let width = WIDE * (high - low).max().max(1e-6);
    let spacing = width / (SIDE - 1) as f64;
    let low = middle - Vector3::repeat(0.5 * width);
    let target = |k: usize| {
        let index = [k % SIDE, k / SIDE % SIDE, k / (SIDE * SIDE)].map(|i| i as f64);
        low + spacing * Vector3::from(index)
    };
    let targets: Vec<_> = (0..SIDE.pow(3)).map(target).collect();
    let fields = world.electric_fields(&targets)?.fields;
    let cube = FieldCube { low, spacing, fields };
    let every = points().count().div_ceil(LINES).max(1);
    // Not the first node of each, which is in the skin.
    let seeds = points().skip(every / 2).step_by(every);
    Ok(seeds.map(|seed| cube.line(*seed)).filter(|line| line.len() > 2).collect())
}

impl FieldCube {
    /// The direction of the field at a place; none outside and where there is no field.
    fn direction(&self, at: &Point3<f64>) -> Option<Vector3<f64>> {
        let place = (at - self.low) / self.spacing;
        let last = (SIDE - 1) as f64;
        if !place.iter().all(|x| (0.0..last).contains(x)) {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside")]
        let cell = place.map(|x| x.floor() as usize);
        let within = place.map(f64::fract);
        let mut sum = Vector3::zeros();
        for corner in 0..8_usize {
            let up = [corner & 1, corner >> 1 & 1, corner >> 2];
            let [i, j, k] = [0, 1, 2].map(|d| cell[d] + up[d]);
            let weight = |d: usize| if up[d] == 1 { within[d] } else { 1.0 - within[d] };
            let field = self.fields.get(i + SIDE * (j + SIDE * k))?;
            sum += weight(0) * weight(1) * weight(2) * field;
        }
        sum.try_normalize(1e-300)
    }

    /// The line through a place, along the field.
    fn line(&self, seed: Point3<f64>) -> FieldLine {
        let mut line = self.half(seed, -1.0);
        line.reverse();
        line.push(seed);
        line.extend(self.half(seed, 1.0));
        line
    }

    /// The points of a line from a place on, along the field or against it, by the midpoint rule.
    fn half(&self, seed: Point3<f64>, sign: f64) -> FieldLine {
        let step = sign * STEP * self.spacing;
        let next = |at: &Point3<f64>| {
            let middle = at + 0.5 * step * self.direction(at)?;
            let after = at + step * self.direction(&middle)?;
            // Where it turns round, it has come to a charge.
            let on = (after - at).dot(&self.direction(&after)?) * sign;
            (on > 0.0).then_some(after)
        };
        std::iter::successors(next(&seed), |at| next(at)).take(STEPS).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cube of a point charge at the origin, of width 2.
    fn charge() -> FieldCube {
        let (low, spacing) = (Point3::new(-1.0, -1.0, -1.0), 2.0 / (SIDE - 1) as f64);
        let field = |k: usize| {
            let index = [k % SIDE, k / SIDE % SIDE, k / (SIDE * SIDE)].map(|i| i as f64);
            let from = low.coords + spacing * Vector3::from(index);
            from / from.norm().powi(3)
        };
        FieldCube { low, spacing, fields: (0..SIDE.pow(3)).map(field).collect() }
    }

    #[test]
    fn lines_of_a_point_charge_go_straight_away_from_it() {
        let cube = charge();
        let seed = Point3::new(0.2, 0.3, -0.1);
        let line = cube.half(seed, 1.0);
        let end = line.last().expect("a line");
        assert!(end.coords.amax() > 0.9, "{end}");
        let off = end.coords.cross(&seed.coords).norm() / (end.coords.norm() * seed.coords.norm());
        // The grid is as coarse as the way to the charge.
        assert!(off < 0.1, "{off}");
        let whole = cube.line(seed);
        assert!(whole.len() > line.len() && whole.contains(&seed));
        assert!(whole[0].coords.norm() < seed.coords.norm());
    }

    #[test]
    fn there_are_no_lines_without_a_field_or_outside() {
        let mut cube = charge();
        assert_eq!(cube.direction(&Point3::new(1.5, 0.0, 0.0)), None);
        cube.fields.fill(Vector3::zeros());
        assert_eq!(cube.direction(&Point3::new(0.1, 0.2, 0.3)), None);
        assert_eq!(cube.line(Point3::new(0.1, 0.2, 0.3)).len(), 1);
    }
}
