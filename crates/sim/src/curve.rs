//! Curves that fibres start along.

use crate::SimError;
use crate::file::{self, kind};
use crate::scene::ClosedCurve;
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::Obj;
use rapunzel_fiber::generate::LongKnot;
use std::path::Path;

/// What is wrong with a file, and in which of its lines.
pub(crate) type Fault = (Option<usize>, String);

/// A knot after `curve` with `scale` metres for its unit, for the fibres of a bundle.
pub(crate) fn knot(
    curve: &ClosedCurve,
    scale: f64,
    spacing: f64,
    bundle: usize,
) -> Result<LongKnot, SimError> {
    let path = match curve {
        ClosedCurve::FigureEight => return Ok(LongKnot::figure_eight(scale, spacing)),
        ClosedCurve::File(path) => path,
    };
    let text = file::read_text(path)?;
    let points = match kind(path).as_str() {
        "obj" => ring(&text),
        "txt" => points(&text),
        _ => Err((None, "only .obj and .txt are read".into())),
    };
    let refused = |(line, why)| SimError::Curve { bundle, path: path.clone(), line, why };
    let points = points.map_err(refused)?.into_iter().map(|p| scale * p).collect();
    Ok(LongKnot { points, spacing })
}

/// The points of an open curve in a file, with `scale` metres for its unit, for a bundle.
pub(crate) fn open_curve(
    path: &Path,
    scale: f64,
    bundle: usize,
) -> Result<Vec<Point3<f64>>, SimError> {
    let text = file::read_text(path)?;
    let points = match kind(path).as_str() {
        "obj" => chain(&text),
        "txt" => points(&text),
        _ => Err((None, "only .txt, .obj and the .csv of `rapunzel solve` are read".into())),
    };
    let refused = |(line, why)| SimError::Curve { bundle, path: path.to_owned(), line, why };
    Ok(points.map_err(refused)?.into_iter().map(|p| scale * p).collect())
}

/// A curve with material frames, as `rapunzel solve` writes it.
#[derive(Debug)]
pub(crate) struct CurveTable {
    /// Arc lengths, m, from zero on.
    ways: Vec<f64>,
    pub(crate) positions: Vec<Point3<f64>>,
    pub(crate) frames: Vec<UnitQuaternion<f64>>,
    /// Curvatures at the first and the last station, material frame, 1/m.
    pub(crate) curvatures: (Vector3<f64>, Vector3<f64>),
}

/// Columns of a table: arc length, position, three directors, force, moment and curvature.
const TABLE: usize = 22;

impl CurveTable {
    /// The table in a file, with `scale` metres for its unit.
    pub(crate) fn read(path: &Path, scale: f64, bundle: usize) -> Result<Self, SimError> {
        let text = file::read_text(path)?;
        Self::parse(&text, scale).map_err(|(line, why)| SimError::Curve {
            bundle,
            path: path.to_owned(),
            line,
            why,
        })
    }

    fn parse(text: &str, scale: f64) -> Result<Self, Fault> {
        let (mut ways, mut positions, mut frames) = (Vec::new(), Vec::new(), Vec::new());
        let mut curvatures = Vec::new();
        for (number, line) in (1..).zip(text.lines()).skip(1) {
            let fault = |why: &str| (Some(number), why.to_owned());
            let row: Result<Vec<f64>, _> =
                line.split(',').map(|word| word.trim().parse()).collect();
            let row = row.map_err(|_| fault("a station must have numbers between commas"))?;
            if row.len() != TABLE || row.iter().any(|x| !x.is_finite()) {
                return Err(fault(
                    "a station must have 22 finite numbers, as `rapunzel solve` writes",
                ));
            }
            let vector = |i: usize| Vector3::new(row[i], row[i + 1], row[i + 2]);
            let matrix = Matrix3::from_columns(&[vector(4), vector(7), vector(10)]);
            let turn = (matrix.transpose() * matrix - Matrix3::identity()).amax();
            if turn > 1e-6 || matrix.determinant() < 0.0 {
                return Err(fault("d1, d2 and d3 must be orthonormal, d3 = d1 x d2"));
            }
            let way = scale * row[0];
            if ways.last().is_some_and(|last| *last >= way) {
                return Err(fault("the arc length must grow from line to line"));
            }
            ways.push(way);
            positions.push(scale * Point3::from(vector(1)));
            let frame = Rotation3::from_matrix_unchecked(matrix);
            frames.push(UnitQuaternion::from_rotation_matrix(&frame));
            curvatures.push(vector(19) / scale);
        }
        let [first, .., last] = curvatures[..] else {
            return Err((None, "there must be two stations or more".into()));
        };
        Ok(Self { ways, positions, frames, curvatures: (first, last) })
    }

    /// Length from the first station to the last, m.
    pub(crate) fn length(&self) -> f64 {
        self.ways[self.ways.len() - 1] - self.ways[0]
    }

    /// Pose at the last station.
    pub(crate) fn last(&self) -> Option<Isometry3<f64>> {
        let (place, turn) = (self.positions.last()?, self.frames.last()?);
        Some(Isometry3::from_parts(place.coords.into(), *turn))
    }

    /// Frame at an arc length from the first station, m, turned evenly between stations.
    pub(crate) fn frame(&self, way: f64) -> UnitQuaternion<f64> {
        let way = self.ways[0] + way;
        let i = self.ways.partition_point(|w| *w <= way).clamp(1, self.ways.len() - 1);
        let part = (way - self.ways[i - 1]) / (self.ways[i] - self.ways[i - 1]);
        let turn = (self.frames[i - 1].inverse() * self.frames[i]).scaled_axis();
        self.frames[i - 1] * UnitQuaternion::from_scaled_axis(part * turn)
    }
}

/// The points of an OBJ in the order of its only line.
fn chain(text: &str) -> Result<Vec<Point3<f64>>, Fault> {
    let Obj { points, lines, .. } = read_obj(text)?;
    let [line] = &lines[..] else {
        let problem = format!("there are {} lines of points; give one", lines.len());
        return Err((lines.get(1).map(|line| line.line), problem));
    };
    Ok(line.points.iter().map(|point| points[*point as usize]).collect())
}

fn read_obj(text: &str) -> Result<Obj, Fault> {
    Obj::read(text.as_bytes()).map_err(|error| match error {
        CollisionError::Read { line, problem, .. } => (line, problem),
        error => (None, error.to_string()),
    })
}

/// The points of a text, one in every line that has something before a `#`.
pub(crate) fn points(text: &str) -> Result<Vec<Point3<f64>>, Fault> {
    let mut points = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let words = line.split('#').next().unwrap_or_default().split_whitespace();
        let coordinates: Result<Vec<f64>, _> = words.map(str::parse).collect();
        match coordinates.as_deref() {
            Ok([]) => {}
            Ok(&[x, y, z]) => points.push(Point3::new(x, y, z)),
            _ => return Err((Some(number), "a point must have three numbers".into())),
        }
    }
    Ok(points)
}

/// A line of an OBJ from one point to another.
#[derive(Debug, Clone, Copy)]
struct CurveSide {
    to: usize,
    /// Line of the file, from 1.
    line: usize,
    /// Whether it is written in this direction.
    forward: bool,
}

/// The points of an OBJ in the order in which its lines, written in any order and direction, join
/// them to one ring: from the first point on the way that all lines are written, else to the
/// neighbour with the smaller number.
fn ring(text: &str) -> Result<Vec<Point3<f64>>, Fault> {
    let Obj { points, lines, .. } = read_obj(text)?;
    let mut sides: Vec<Vec<CurveSide>> = vec![Vec::new(); points.len()];
    for chain in &lines {
        let line = chain.line;
        for pair in chain.points.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|point| point as usize);
            for (from, to, forward) in [(a, b, true), (b, a, false)] {
                if from == to || sides[from].iter().any(|side| side.to == to) {
                    return Err((
                        Some(line),
                        "joins a point to itself, or two points again".into(),
                    ));
                }
                if sides[from].len() == 2 {
                    let number = from + 1;
                    let problem = format!("the curve branches: point {number} has a third line");
                    return Err((Some(line), problem));
                }
                sides[from].push(CurveSide { to, line, forward });
            }
        }
    }
    let open = |(point, sides): (usize, &Vec<CurveSide>)| match sides[..] {
        [] => Some((None, format!("point {} is on no line", point + 1))),
        [CurveSide { line, .. }] => {
            let problem = format!("the curve ends at point {}; join it to a ring", point + 1);
            Some((Some(line), problem))
        }
        _ => None,
    };
    if let Some(fault) = sides.iter().enumerate().find_map(open) {
        return Err(fault);
    }
    let Some(first) = sides.first() else { return Err((None, "there are no points".into())) };
    let one_way = sides.iter().all(|sides| sides[0].forward != sides[1].forward);
    let start = first.iter().min_by_key(|side| (one_way && !side.forward, side.to));
    let (mut order, mut last, mut at) = (vec![points[0]], 0, start.map_or(0, |side| side.to));
    while at != 0 {
        order.push(points[at]);
        let next = usize::from(sides[at][0].to == last);
        (last, at) = (at, sides[at][next].to);
    }
    if order.len() < points.len() {
        let problem = format!("the first ring has {} of {} points", order.len(), points.len());
        return Err((None, problem + "; leave one ring"));
    }
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_ring_is_read_the_way_of_its_lines() {
        let text =
            "# a curve\nv 0 0 0\nv 1 0 0 # east\nv 0 1 0 1 0 0\nvn 0 0 1\nl 1 3\n\nl 3 -2 1\n";
        let expected = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]].map(Point3::from);
        assert_eq!(ring(text).expect("a ring"), expected);
    }

    proptest! {
        /// As modellers write it: sides in any order and direction, by either way of counting.
        #[test]
        fn a_ring_is_that_of_its_sides_in_any_order(
            sides in (3..30_i64).prop_flat_map(|n| {
                let sides: Vec<_> = (0..n).map(|k| (k, (k + 1) % n)).collect();
                let ways = prop::collection::vec(any::<(bool, bool)>(), sides.len());
                (Just(sides).prop_shuffle(), ways)
            }),
        ) {
            let (sides, ways) = sides;
            let n = i64::try_from(sides.len()).expect("few");
            let points: String = (0..n).map(|k| format!("v {k} 0 {}\n", k * k)).collect();
            let side = |(&(a, b), &(turned, from_end)): (&(i64, i64), &(bool, bool))| {
                let (a, b) = if turned { (b, a) } else { (a, b) };
                let shift = if from_end { -n } else { 1 };
                format!("l {} {}\n", a + shift, b + shift)
            };
            let lines: String = sides.iter().zip(&ways).map(side).collect();
            let order = ring(&(points + &lines)).expect("a ring");
            let order: Vec<f64> = order.iter().map(|p| p.x).collect();
            let up: Vec<f64> = (0..n).map(|k| k as f64).collect();
            let all_turned = ways.iter().all(|way| way.0);
            let down: Vec<f64> = (0..n).map(|k| ((n - k) % n) as f64).collect();
            prop_assert_eq!(order, if all_turned { down } else { up });
        }
    }

    #[test]
    fn what_is_no_ring_is_refused_with_its_line() {
        let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for (lines, line) in [
            ("l 1 2 3", Some(4)),
            ("l 1 2 1", Some(4)),
            ("l 1 2 3 4 1", Some(4)),
            ("l 1 2 0", Some(4)),
            ("l 1 2 2", Some(4)),
            ("", None),
            ("l 1 2 3 1\nl 2 1", Some(5)),
            ("l 1 2 x", Some(4)),
            ("v 1 2\nl 1 2 3 1", Some(4)),
            ("v 2 0 0\nl 1 2 3 1\nl 4 2", Some(6)),
            ("v 2 0 0\nl 1 2 3 1", None),
            ("v 2 0 0\nv 2 1 0\nv 2 2 0\nl 1 2 3 1\nl 4 5 6 4", None),
        ] {
            let fault = ring(&format!("{three}{lines}")).expect_err("no ring");
            assert_eq!(fault.0, line, "{lines}: {}", fault.1);
        }
        assert!(ring("").is_err());
    }

    #[test]
    fn points_of_a_text_are_in_its_lines() {
        let read = points("# x y z\n0 0 1\n\n 2e0 3 4 # last\n").expect("points");
        assert_eq!(read, [[0.0, 0.0, 1.0], [2.0, 3.0, 4.0]].map(Point3::from));
        assert_eq!(points("0 0 1\n2 3").expect_err("two numbers").0, Some(2));
    }
}
