//! The values of a grid along a line: in each cell a cubic polynomial, which its Bernstein
//! coefficients bound.

use super::grid::{CELLS, Grid, SIDE};
use nalgebra::{Point3, Vector3};

/// What single precision may add to a value, relative to the largest corner: a dozen roundings.
const CELL_ROUNDING: f64 = 1e-6;

impl Grid {
    /// A lower bound of the values on the straight way between two points (world), m. It is off by
    /// a part of the second differences within a cell. Cost: the cells on the way.
    pub(super) fn least_on(&self, start: &Point3<f64>, end: &Point3<f64>) -> f64 {
        let size = Vector3::from(self.frame.cells);
        let [from, to] = [start, end].map(|p| (p - self.frame.origin) * self.frame.inverse);
        let way = to - from;
        // Outside of the box all is farther than the band.
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let mut times = [0.0, size[axis]].map(|face| (face - from[axis]) / way[axis]);
            if way[axis] == 0.0 {
                let is_between = (0.0..=size[axis]).contains(&from[axis]);
                let never = [f64::INFINITY, f64::NEG_INFINITY];
                times = if is_between { [f64::NEG_INFINITY, f64::INFINITY] } else { never };
            }
            enter = enter.max(times[0].min(times[1]));
            leave = leave.min(times[0].max(times[1]));
        }
        if !way.iter().chain(from.iter()).all(|x| x.is_finite()) {
            return f64::NEG_INFINITY;
        }
        if enter > leave {
            return self.band;
        }
        let mut least = if enter > 0.0 || leave < 1.0 { self.band } else { f64::INFINITY };
        // From cell to cell through the face that comes next (Amanatides and Woo 1987).
        let first = from + way * enter;
        let mut low = Vector3::from_fn(|axis, _| {
            let place =
                if way[axis] < 0.0 { first[axis].ceil() - 1.0 } else { first[axis].floor() };
            place.clamp(0.0, size[axis] - 1.0)
        });
        let mut time = enter;
        loop {
            let ahead = |axis: usize| {
                let face = if way[axis] < 0.0 { low[axis] } else { low[axis] + 1.0 };
                let until = (face - from[axis]) / way[axis];
                if way[axis] == 0.0 { f64::INFINITY } else { until }
            };
            let times = [0, 1, 2].map(ahead);
            let axis = (0..3).min_by(|&i, &j| times[i].total_cmp(&times[j])).unwrap_or(0);
            let next = times[axis].clamp(time, leave);
            let ends = [time, next].map(|t| (from + way * t - low).map(|x| x.clamp(0.0, 1.0)));
            least = least.min(self.least_in(&low, ends));
            low[axis] += way[axis].signum();
            if next >= leave || low[axis] < 0.0 || low[axis] >= size[axis] {
                return least;
            }
            time = next;
        }
    }

    /// A lower bound in the cell with this lowest node, between two places in it, in its side.
    fn least_in(&self, low: &Vector3<f64>, [a, b]: [Vector3<f64>; 2]) -> f64 {
        let [bx, by, _] = self.frame.blocks;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole")]
        let [x, y, z] = [low.x, low.y, low.z].map(|index| index as usize);
        let block = x / CELLS + bx * (y / CELLS + by * (z / CELLS));
        let place = x % CELLS + SIDE * (y % CELLS + SIDE * (z % CELLS));
        let corners = self.corners_at(self.starts[block] as usize + place).map(f64::from);
        let rounding = CELL_ROUNDING * corners.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
        let lerp = |a: f64, b: f64, t: f64| a + t * (b - a);
        // The values at the eight corners of the box between both places: along x, then y, then z.
        let edges: [[f64; 2]; 4] = std::array::from_fn(|k| {
            [a.x, b.x].map(|t| lerp(corners[2 * k], corners[2 * k + 1], t))
        });
        let value = |i: usize, j: usize, k: usize| {
            let (ty, tz) = ([a.y, b.y][j], [a.z, b.z][k]);
            let [low, high] = [0, 2].map(|e| lerp(edges[e][i], edges[e + 1][i], ty));
            lerp(low, high, tz)
        };
        // Bernstein coefficients of the cubic are means of the polar form.
        let first = (value(1, 0, 0) + value(0, 1, 0) + value(0, 0, 1)) / 3.0;
        let second = (value(1, 1, 0) + value(1, 0, 1) + value(0, 1, 1)) / 3.0;
        value(0, 0, 0).min(first).min(second).min(value(1, 1, 1)) - rounding
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Ball, DistanceField, GridFrame};
    use super::*;
    use proptest::prelude::*;
    use std::sync::OnceLock;

    /// A ball of 1 m on a lattice of 5 cm, off its middle.
    fn grid() -> &'static Grid {
        static GRID: OnceLock<Grid> = OnceLock::new();
        GRID.get_or_init(|| {
            let ball = Ball { center: Point3::new(0.01, 0.02, 0.03), radius: 1.0 };
            let frame =
                GridFrame::new(Point3::new(-1.5, -1.5, -1.5), Point3::new(1.5, 1.5, 1.5), 0.05);
            Grid::sample(&ball, frame.expect("a frame"), 0.3).expect("a grid")
        })
    }

    proptest! {
        /// No sample is below the bound, and one is near it: within what the curvature of the
        /// interpolant in a cell can hide.
        #[test]
        fn the_bound_of_a_line_is_the_least_of_its_samples(
            from in prop::array::uniform3(-2.0..2.0_f64),
            to in prop::array::uniform3(-2.0..2.0_f64),
            along in prop::sample::select(vec![[true; 3], [true, false, false], [false, true, true], [false; 3]]),
        ) {
            let grid = grid();
            let start = Point3::from(from);
            let end = Point3::from(std::array::from_fn(|k| if along[k] { to[k] } else { from[k] }));
            let bound = grid.least_between(&start, &end);
            let samples = (0..=4000).map(|i| {
                grid.value(&(start + (end - start) * (f64::from(i) / 4000.0)))
            });
            let least = samples.fold(f64::INFINITY, f64::min);
            prop_assert!(bound <= least + 1e-12, "{bound} {least}");
            // Second differences of a cell are at most its diagonal squared over the radius, of the
            // clipped ones at most the diagonal; between samples the slope counts.
            let near = least.abs() < 0.2;
            let most = if near { 0.05_f64.powi(2) * 3.0 / 0.7 } else { 0.05 * 3.0_f64.sqrt() };
            prop_assert!(least.min(0.3) - bound.min(0.3) < most + 2e-3, "{bound} {least}");
        }

        /// On nodes, edges and faces of cells, where the way runs along them or begins on them.
        #[test]
        fn lines_on_faces_of_cells_are_bounded(
            from in prop::array::uniform3(-28..28_i32),
            way in prop::array::uniform3(-2..=2_i32),
        ) {
            let grid = grid();
            let at = |index: [i32; 3]| Point3::from(index.map(|i| -1.5 + 0.05 * f64::from(i + 30)));
            let start = at(from);
            let end = at(std::array::from_fn(|k| from[k] + 7 * way[k]));
            let bound = grid.least_between(&start, &end);
            for i in 0..=200 {
                let value = grid.value(&(start + (end - start) * (f64::from(i) / 200.0)));
                prop_assert!(bound <= value + 1e-12, "{bound} {value}");
            }
        }
    }

    #[test]
    fn a_line_that_is_nowhere_has_no_bound() {
        let nowhere = Point3::new(f64::NAN, 0.0, 0.0);
        assert_eq!(grid().least_between(&nowhere, &Point3::origin()), f64::NEG_INFINITY);
    }
}
