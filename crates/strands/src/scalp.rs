use crate::{StrandSet, StrandsError};
use rapunzel_collision::field::SurfaceTree;

/// What snapping did to the roots of strands.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapped {
    /// Largest distance that a strand was moved, m.
    pub largest: f64,
    /// Mean distance that the strands were moved, m.
    pub mean: f64,
    /// Strands that stayed where they are, because their roots are too far from the scalp.
    pub far: Vec<usize>,
}

impl StrandSet {
    /// Moves every strand as a whole so that its root is the nearest point of a scalp.
    ///
    /// Its shape and length stay as they are, which is what a rod is made of; fading the move out
    /// toward the tip would bend and stretch it. Strands whose roots are farther than `most`, m,
    /// from the scalp stay too, and are listed: a tail that starts at a band, or a scalp in other
    /// units.
    ///
    /// # Errors
    /// [`StrandsError::Option`] if `most` is negative or not a number.
    pub fn snap(&mut self, scalp: &SurfaceTree, most: f64) -> Result<Snapped, StrandsError> {
        if most.is_nan() || most < 0.0 {
            let (what, must) = ("the farthest distance of a root", "zero or more");
            return Err(StrandsError::Option { what, value: most.to_string(), must });
        }
        let mut out = Snapped { largest: 0.0, mean: 0.0, far: Vec::new() };
        let mut sum = 0.0;
        for strand in 0..self.len() {
            let points = self.strand_mut(strand);
            let root = scalp.nearest(&points[0]).point;
            let way = root - points[0];
            if way.norm() > most {
                out.far.push(strand);
                continue;
            }
            points.iter_mut().for_each(|point| *point += way);
            // Exactly, without rounding.
            points[0] = root;
            out.largest = out.largest.max(way.norm());
            sum += way.norm();
        }
        let moved = self.len() - out.far.len();
        out.mean = sum / moved.max(1) as f64;
        Ok(out)
    }
}
