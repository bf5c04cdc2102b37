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

    /// The curves as far as they do not come below a height, m, y up; empty where a root does.
    #[must_use]
    pub fn trimmed(&self, height: f64) -> Self {
        let mut all = Self::default();
        let mut kept = Vec::new();
        for curve in self.iter() {
            kept.clear();
            let above = curve.iter().take_while(|point| point.y >= height).count();
            kept.extend_from_slice(&curve[..above]);
            if let (Some(last), Some(next)) = (kept.last().copied(), curve.get(above)) {
                let part = (last.y - height) / (last.y - next.y);
                if part > 0.0 {
                    kept.push(last + (next - last) * part);
                }
            }
            if kept.len() < 2 {
                kept.clear();
            }
            all.push(&kept);
        }
        all
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trim_cuts_at_its_height() {
        let mut curves = HairCurves::default();
        let at = |x: f64, y: f64| Point3::new(x, y, 0.0);
        // Over the height and down, down and up again, never below, wholly below, none.
        curves.push(&[at(0.0, 1.0), at(1.0, 2.0), at(2.0, 0.0), at(3.0, -2.0)]);
        curves.push(&[at(0.0, 1.0), at(1.0, 0.0), at(2.0, 1.0)]);
        curves.push(&[at(0.0, 1.0), at(1.0, 0.5)]);
        curves.push(&[at(0.0, 0.0), at(1.0, 1.0)]);
        curves.push(&[]);
        let trimmed = curves.trimmed(0.5);
        let ends: Vec<_> = trimmed.iter().map(<[Point3<f64>]>::to_vec).collect();
        assert_eq!(ends[0], [at(0.0, 1.0), at(1.0, 2.0), at(1.75, 0.5)]);
        assert_eq!(ends[1], [at(0.0, 1.0), at(0.5, 0.5)]);
        assert_eq!(ends[2], [at(0.0, 1.0), at(1.0, 0.5)]);
        assert!(ends[3].is_empty() && ends[4].is_empty() && trimmed.count() == 5);
    }
}
