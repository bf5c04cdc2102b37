use nalgebra::Point3;
use std::ops::Range;

/// Strands as polylines, one after the other in the order of their file (world: meter, y up).
///
/// Every strand has at least two points and no two equal ones in a row; all numbers are finite.
#[derive(Debug, Clone, PartialEq)]
pub struct StrandSet {
    points: Vec<Point3<f64>>,
    /// Index of the first point of each strand, and the number of all points.
    offsets: Vec<usize>,
    radii: Option<Vec<f64>>,
    sources: Vec<usize>,
}

impl StrandSet {
    /// An empty set that takes strands with radii or without.
    pub(crate) fn new(has_radii: bool) -> Self {
        let radii = has_radii.then(Vec::new);
        Self { points: Vec::new(), offsets: vec![0], radii, sources: Vec::new() }
    }

    /// Adds a strand; `radii`, m, are empty or as many as its points.
    pub(crate) fn push(
        &mut self,
        source: usize,
        points: impl IntoIterator<Item = Point3<f64>>,
        radii: impl IntoIterator<Item = f64>,
    ) {
        self.points.extend(points);
        self.offsets.push(self.points.len());
        self.sources.push(source);
        if let Some(all) = &mut self.radii {
            all.extend(radii);
        }
    }

    /// Number of strands.
    #[must_use]
    pub fn len(&self) -> usize {
        self.sources.len()
    }

    /// Whether there are no strands.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sources.is_empty()
    }

    /// Points of all strands (world), m.
    #[must_use]
    pub fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// Range of the points of a strand.
    ///
    /// # Panics
    /// If there is no such strand.
    #[must_use]
    pub fn range(&self, strand: usize) -> Range<usize> {
        self.offsets[strand]..self.offsets[strand + 1]
    }

    /// Points of a strand from the root on (world), m.
    ///
    /// # Panics
    /// If there is no such strand.
    #[must_use]
    pub fn strand(&self, strand: usize) -> &[Point3<f64>] {
        &self.points[self.range(strand)]
    }

    /// All strands in order, each as its points (world), m.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[Point3<f64>]> {
        self.offsets.windows(2).map(|ends| &self.points[ends[0]..ends[1]])
    }

    /// Radii at all points, m, if the file has them.
    #[must_use]
    pub fn radii(&self) -> Option<&[f64]> {
        self.radii.as_deref()
    }

    /// Number of each strand in its file, from 0; it grows.
    #[must_use]
    pub fn sources(&self) -> &[usize] {
        &self.sources
    }

    /// Length of a strand, m.
    ///
    /// # Panics
    /// If there is no such strand.
    #[must_use]
    pub fn length(&self, strand: usize) -> f64 {
        length(self.strand(strand))
    }

    /// Points of a strand, to be moved.
    pub(crate) fn strand_mut(&mut self, strand: usize) -> &mut [Point3<f64>] {
        let range = self.range(strand);
        &mut self.points[range]
    }
}

/// Length of a polyline, m.
pub(crate) fn length(points: &[Point3<f64>]) -> f64 {
    points.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum()
}
