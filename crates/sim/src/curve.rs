//! Closed curves that fibres start along.

use crate::SimError;
use crate::file::{self, kind};
use crate::scene::ClosedCurve;
use nalgebra::Point3;
use rapunzel_collision::CollisionError;
use rapunzel_collision::field::Obj;
use rapunzel_fiber::generate::LongKnot;

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
    let Obj { points, lines, .. } = Obj::read(text.as_bytes()).map_err(|error| match error {
        CollisionError::Read { line, problem, .. } => (line, problem),
        error => (None, error.to_string()),
    })?;
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
