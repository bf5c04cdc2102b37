//! Closed curves that fibres start along.

use crate::SimError;
use crate::scene::ClosedCurve;
use nalgebra::Point3;
use rapunzel_fiber::generate::LongKnot;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// What is wrong with a file, and in which of its lines.
type Fault = (Option<usize>, &'static str);

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
    let text = fs::read_to_string(path).map_err(SimError::io("read", path))?;
    let points = match kind(path).as_str() {
        "obj" => ring(&text),
        "txt" => lines(&text).map(|(line, words)| point(line, &words)).collect(),
        _ => Err((None, "only .obj and .txt are read")),
    };
    let refused = |(line, why)| SimError::Curve { bundle, path: path.clone(), line, why };
    let points = points.map_err(refused)?.into_iter().map(|p| scale * p).collect();
    Ok(LongKnot { points, spacing })
}

fn kind(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// Lines with something in them before a `#`, from 1, and their words.
fn lines(text: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
    let words = text.lines().map(|line| {
        line.split('#').next().unwrap_or_default().split_whitespace().collect::<Vec<_>>()
    });
    (1..).zip(words).filter(|(_, words)| !words.is_empty())
}

/// The point of a line.
fn point(line: usize, words: &[&str]) -> Result<Point3<f64>, Fault> {
    let fault = (Some(line), "a point must have three numbers");
    let numbers: Result<Vec<f64>, _> = words.iter().map(|word| word.parse()).collect();
    match numbers.as_deref() {
        Ok([x, y, z]) => Ok(Point3::new(*x, *y, *z)),
        _ => Err(fault),
    }
}

/// The points of an OBJ in the order in which its lines join them.
fn ring(text: &str) -> Result<Vec<Point3<f64>>, Fault> {
    let (mut points, mut joined) = (Vec::new(), BTreeMap::new());
    for (line, words) in lines(text) {
        match words.split_first() {
            Some((&"v", numbers)) => points.push(point(line, numbers)?),
            Some((&"l", ends)) => {
                let fault = (Some(line), "a line must join points by their numbers, from 1");
                let ends: Result<Vec<usize>, _> = ends.iter().map(|end| end.parse()).collect();
                for pair in ends.map_err(|_| fault)?.windows(2) {
                    if joined.insert(pair[0], pair[1]).is_some() {
                        return Err((Some(line), "two lines begin at one point: this is no ring"));
                    }
                }
            }
            _ => {}
        }
    }
    let mut order = Vec::new();
    let mut at = 1;
    loop {
        let open = (None, "its lines do not join all of its points to one ring");
        let place = points.get(at - 1).ok_or(open)?;
        order.push(*place);
        at = joined.remove(&at).filter(|next| *next > 0).ok_or(open)?;
        if at == 1 {
            return if order.len() == points.len() { Ok(order) } else { Err(open) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_is_read_in_the_order_of_its_lines() {
        let text = "# a curve\nv 0 0 0\nv 1 0 0 # east\nv 0 1 0\nvn 0 0 1\nl 1 3\n\nl 3 2 1\n";
        let expected = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]].map(Point3::from);
        assert_eq!(ring(text).expect("a ring"), expected);
    }

    #[test]
    fn what_is_no_ring_is_refused_with_its_line() {
        let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for (lines, line) in [
            ("l 1 2 3", None),
            ("l 1 2 1", None),
            ("l 1 2 3 4 1", None),
            ("l 1 2 0", None),
            ("l 1 2 2", None),
            ("", None),
            ("l 1 2 3 1\nl 2 1", Some(5)),
            ("l 1 2 x", Some(4)),
            ("v 1 2\nl 1 2 3 1", Some(4)),
        ] {
            let fault = ring(&format!("{three}{lines}")).expect_err("no ring");
            assert_eq!(fault.0, line, "{lines}");
        }
    }
}
