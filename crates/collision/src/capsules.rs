//! Fibres as chains of capsules: what every search looks at.

use crate::CollisionError;
use nalgebra::Point3;
use rapunzel_fiber::Layout;
use rapunzel_lanes::all_finite;

/// Two segments by their indices, the smaller first.
pub type Pair = [u32; 2];

/// All points within a radius of a straight segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// First end of the axis (world), m.
    pub start: Point3<f64>,
    /// Second end of the axis (world), m; may be the first.
    pub end: Point3<f64>,
    /// Radius, m.
    pub radius: f64,
}

/// Many fibres at one moment, every segment a capsule.
///
/// A borrowed view that has been checked once: all positions are finite, all radii positive, and
/// there is at least one segment. Everything in this crate that takes it can rely on that.
#[derive(Debug, Clone, Copy)]
pub struct Capsules<'a> {
    layout: &'a Layout,
    positions: &'a [Point3<f64>],
    radii: &'a [f64],
}

impl<'a> Capsules<'a> {
    /// Views fibres with nodes at `positions` (world), m, and one radius per segment, m.
    ///
    /// # Errors
    /// [`CollisionError::Empty`], [`CollisionError::TooMany`] nodes for indices of 32 bits,
    /// [`CollisionError::Count`] of either array,
    /// [`CollisionError::Position`] that is not finite, [`CollisionError::Radius`] that is not
    /// positive and finite. Cost: one pass over both arrays.
    pub fn new(
        layout: &'a Layout,
        positions: &'a [Point3<f64>],
        radii: &'a [f64],
    ) -> Result<Self, CollisionError> {
        if layout.segments() == 0 {
            return Err(CollisionError::Empty);
        }
        if u32::try_from(layout.nodes()).is_err() {
            return Err(CollisionError::TooMany { nodes: layout.nodes() });
        }
        count("positions", positions.len(), layout.nodes())?;
        count("radii", radii.len(), layout.segments())?;
        let capsules = Self { layout, positions, radii };
        // The search for the culprit only where there is one.
        if !all_finite(positions, |p| p.coords.into()) {
            capsules.check_positions()?;
        }
        // No early exit, so that the loop can be vectorised.
        if !radii.iter().fold(true, |sound, &r| sound & (r > 0.0) & (r < f64::INFINITY)) {
            return Err(capsules.bad_radius());
        }
        Ok(capsules)
    }

    fn check_positions(&self) -> Result<(), CollisionError> {
        for fiber in 0..self.layout.fibers() {
            for (node, p) in self.positions[self.layout.node_range(fiber)].iter().enumerate() {
                if !p.iter().all(|x| x.is_finite()) {
                    let position = p.coords.into();
                    return Err(CollisionError::Position { fiber, node, position });
                }
            }
        }
        Ok(())
    }

    fn bad_radius(&self) -> CollisionError {
        let bad = |&&r: &&f64| !(r > 0.0 && r.is_finite());
        let segment = self.radii.iter().position(|r| bad(&r)).unwrap_or_default();
        let radius = self.radii[segment];
        let fiber = self.layout.segment_fibers()[segment];
        let segment = segment - self.layout.segment_range(fiber).start;
        CollisionError::Radius { fiber, segment, radius }
    }

    /// Which segments belong to which fibre.
    #[must_use]
    pub fn layout(&self) -> &'a Layout {
        self.layout
    }

    /// Number of segments, at least one.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "there is always at least one segment")]
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// Positions of all nodes (world), m.
    #[must_use]
    pub fn positions(&self) -> &'a [Point3<f64>] {
        self.positions
    }

    /// Radii of all segments, m.
    #[must_use]
    pub fn radii(&self) -> &'a [f64] {
        self.radii
    }

    /// The capsule of `segment`.
    ///
    /// # Panics
    /// If there is no such segment, as indexing does.
    #[must_use]
    pub fn get(&self, segment: usize) -> Capsule {
        let [a, b] = self.layout.segment_nodes(segment);
        Capsule { start: self.positions[a], end: self.positions[b], radius: self.radii[segment] }
    }

    /// Whether two segments are one, or share a node: `s_u in {s_v, adj(s_v)}` of algorithm 3 of
    /// the thesis. Such pairs always touch and are never reported.
    ///
    /// # Panics
    /// If there is no such segment, as indexing does.
    #[must_use]
    pub fn adjacent(&self, first: usize, second: usize) -> bool {
        let fibers = self.layout.segment_fibers();
        first.abs_diff(second) <= 1 && fibers[first] == fibers[second]
    }
}

/// Checks that a length is at least zero, m.
pub(crate) fn length(what: &'static str, value: f64) -> Result<(), CollisionError> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(CollisionError::Length { what, value })
    }
}

/// Checks the length of an array.
pub(crate) fn count(what: &'static str, given: usize, needed: usize) -> Result<(), CollisionError> {
    if given == needed { Ok(()) } else { Err(CollisionError::Count { what, given, needed }) }
}

/// Radius of every segment, m, from radii at the nodes: the larger of its two ends, so that the
/// capsule holds the tapered segment.
///
/// # Panics
/// If there is not one radius per node.
#[must_use]
pub fn segment_radii(layout: &Layout, node_radii: &[f64]) -> Vec<f64> {
    assert_eq!(node_radii.len(), layout.nodes(), "an array over nodes has one element per node");
    let larger = |segment| {
        let [a, b] = layout.segment_nodes(segment);
        node_radii[a].max(node_radii[b])
    };
    (0..layout.segments()).map(larger).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(n: usize) -> Vec<Point3<f64>> {
        (0..n).map(|k| Point3::new(0.0, 0.0, k as f64)).collect()
    }

    #[test]
    fn bad_input_is_named() {
        let layout = Layout::new([2, 3]);
        let good = points(7);
        assert!(Capsules::new(&layout, &good, &[0.1; 5]).is_ok());
        let empty = Layout::new([]);
        assert_eq!(Capsules::new(&empty, &[], &[]).expect_err("refused"), CollisionError::Empty);
        let short = Capsules::new(&layout, &good[1..], &[0.1; 5]).expect_err("refused");
        let expected = CollisionError::Count { what: "positions", given: 6, needed: 7 };
        assert_eq!(short, expected);
        let short = Capsules::new(&layout, &good, &[0.1; 4]).expect_err("refused");
        assert_eq!(short, CollisionError::Count { what: "radii", given: 4, needed: 5 });
        for bad in [f64::INFINITY, f64::NEG_INFINITY] {
            let mut points = good.clone();
            points[5].y = bad;
            let error = Capsules::new(&layout, &points, &[0.1; 5]).expect_err("refused");
            let position = [0.0, bad, 5.0];
            assert_eq!(error, CollisionError::Position { fiber: 1, node: 2, position });
        }
        let mut nan = good.clone();
        nan[0].x = f64::NAN;
        let error = Capsules::new(&layout, &nan, &[0.1; 5]).expect_err("refused");
        assert!(matches!(error, CollisionError::Position { fiber: 0, node: 0, .. }));
        for radius in [0.0, -1.0, f64::INFINITY] {
            let radii = [0.1, 0.1, 0.1, radius, 0.1];
            let error = Capsules::new(&layout, &good, &radii).expect_err("refused");
            assert_eq!(error, CollisionError::Radius { fiber: 1, segment: 1, radius });
        }
    }

    #[test]
    fn positions_whose_sum_overflows_are_good() {
        let layout = Layout::new([1]);
        let far = [Point3::new(1e308, 1e308, 0.0), Point3::new(1e308, 0.0, 0.0)];
        assert!(Capsules::new(&layout, &far, &[1.0]).is_ok());
    }

    #[test]
    fn only_segments_that_share_a_node_are_adjacent() {
        let layout = Layout::new([2, 2]);
        let points = points(6);
        let capsules = Capsules::new(&layout, &points, &[0.1; 4]).expect("valid");
        let adjacent = |i, j| capsules.adjacent(i, j) && capsules.adjacent(j, i);
        assert!(adjacent(0, 0) && adjacent(0, 1) && adjacent(2, 3));
        assert!(!adjacent(1, 2) && !adjacent(0, 2) && !adjacent(0, 3));
    }

    #[test]
    fn a_tapered_segment_is_held_by_its_capsule() {
        let radii = segment_radii(&Layout::new([2, 1]), &[3.0, 2.0, 2.5, 1.0, 4.0]);
        assert_eq!(radii, [3.0, 2.5, 4.0]);
    }
}
