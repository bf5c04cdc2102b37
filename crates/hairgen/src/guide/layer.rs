use super::barrier;
use super::rod::GuideRod;
use crate::{GuideOptions, Pore, Region};
use nalgebra::{Point3, Vector3};
use rapunzel_collision::field::Sample;
use rapunzel_rod_static::{Shape, ShapeDerivatives};

/// Weight of the mean square of curvature times length against the walls of a layer: so small that
/// it decides only between shapes that are all deep enough.
const STIFFNESS: f64 = 1e-3;

/// The layer of hair that a pre-guide lies in: outside of the head, and so deep below the hull.
pub(super) struct Layer<'a> {
    region: Region<'a>,
    /// Depth below the hull over that which is possible.
    dip: f64,
    /// Thickness of the hair over the pore, m: the largest depth that is possible.
    thickness: f64,
    walls: [f64; 2],
}

impl<'a> Layer<'a> {
    pub(super) fn over(pore: &Pore, dip: f64, region: Region<'a>, options: &GuideOptions) -> Self {
        let thickness = (-region.hull.value(&pore.position)).max(0.0);
        Self { region, dip, thickness, walls: [options.margin, options.penalty] }
    }

    /// Largest depth below the hull that is asked for, m.
    pub(super) fn depth(&self) -> f64 {
        self.dip * self.thickness
    }

    /// How deep a point is in the head, and how much it lacks of the depth below the hull, m. The
    /// depth that is possible is the distance from the hull to the head, the sum of both fields,
    /// and no more than at the pore: below the neck there is no head to come near to.
    fn lacks(&self, point: &Point3<f64>) -> [Sample; 2] {
        let [head, hull] = self.region.walls(point);
        let across = -head.value - hull.value;
        let slope = if (0.0..self.thickness).contains(&across) {
            -(head.gradient + hull.gradient) * self.dip
        } else {
            Vector3::zeros()
        };
        let asked = self.dip * across.min(self.thickness).max(0.0);
        [head, Sample { value: hull.value + asked, gradient: hull.gradient + slope }]
    }

    /// Whether a point is outside of the head and deep enough.
    pub(super) fn holds(&self, point: &Point3<f64>) -> bool {
        self.lacks(point).iter().all(|lack| lack.value <= 0.0)
    }

    /// Whether it holds all of a shape behind the root.
    pub(super) fn holds_all(&self, shape: &Shape) -> bool {
        shape.positions()[1..].iter().all(|node| self.holds(node))
    }

    /// What a shape of `rod` costs: the walls of the layer, and a little for its bending; and the
    /// derivatives.
    pub(super) fn cost(&self, rod: &GuideRod, shape: &Shape) -> (f64, ShapeDerivatives) {
        let positions = shape.positions();
        let mut by = ShapeDerivatives::zeros(positions.len() - 1);
        let mut sum = barrier::boundary(positions, |p| self.lacks(p), self.walls, 1.0, &mut by);
        let bends = rod.bends(shape);
        let part = STIFFNESS / bends.len() as f64;
        for (by, bend) in by.curvatures.iter_mut().zip(&bends) {
            sum += part * bend.norm_squared();
            *by += bend * (2.0 * part * rod.length);
        }
        (sum, by)
    }
}
