use nalgebra::Point3;

/// Center lines of many hairs, one behind the other in one array.
#[derive(Debug, Clone, PartialEq)]
pub struct HairCurves {
    points: Vec<Point3<f64>>,
    /// Where each curve begins, and where the last one ends.
    starts: Vec<usize>,
}

impl Default for HairCurves {
    fn default() -> Self {
        Self { points: Vec::new(), starts: vec![0] }
    }
}

impl HairCurves {
    /// Number of curves, also empty ones.
    #[must_use]
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// The points of all curves (world), m.
    #[must_use]
    pub fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// The curves (world), m, from the root on; a curve without points is a hair that found no
    /// place.
    pub fn iter(&self) -> impl Iterator<Item = &[Point3<f64>]> {
        self.starts.windows(2).map(|ends| &self.points[ends[0]..ends[1]])
    }

    pub(super) fn push(&mut self, curve: &[Point3<f64>]) {
        self.points.extend_from_slice(curve);
        self.starts.push(self.points.len());
    }

    /// Puts the curves of parts together in their order.
    pub(super) fn joined(parts: &[Self]) -> Self {
        let points = parts.iter().map(|part| part.points.len()).sum();
        let count: usize = parts.iter().map(Self::count).sum();
        let mut all =
            Self { points: Vec::with_capacity(points), starts: Vec::with_capacity(count + 1) };
        all.starts.push(0);
        for part in parts {
            let before = all.points.len();
            all.points.extend_from_slice(&part.points);
            all.starts.extend(part.starts[1..].iter().map(|start| before + start));
        }
        all
    }
}
