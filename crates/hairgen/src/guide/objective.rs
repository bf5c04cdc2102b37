use super::flow::GuideFlow;
use super::rod::{EndLoad, GuideRod};
use super::{GuideOptions, terms};
use crate::density::HairDensity;
use crate::{HairgenError, Region};
use nalgebra::{Matrix6, Vector6};
use rapunzel_rod_static::{Rest, Shape, ShapeDerivatives};

/// Part of the trace of the second derivatives that is added to each of them on the diagonal.
const DAMPING: f64 = 1e-6;

/// The terms of a guide's objective at its shape, without their weights and without units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Terms {
    /// Deviation from the directions of the pre-guides (5.8), from 0 to 2.
    pub direction: f64,
    /// Deviation from the curvatures of the pre-guides, times the length (5.9).
    pub curvature: f64,
    /// Nearness to head and hull, in units of the margin, and depth behind them (5.10).
    pub boundary: f64,
    /// Density of the hair that is there (5.11, 5.12).
    pub density: f64,
}

/// What a guide's end load minimizes (5.7).
pub(crate) struct Objective<'a> {
    pub(crate) flow: GuideFlow<'a>,
    pub(super) region: Region<'a>,
    pub(super) density: Option<&'a HairDensity>,
    pub(super) weights: [f64; 4],
    pub(super) margin: f64,
    pub(super) penalty: f64,
}

impl<'a> Objective<'a> {
    pub(crate) fn new(
        flow: GuideFlow<'a>,
        region: Region<'a>,
        density: Option<&'a HairDensity>,
        options: &GuideOptions,
    ) -> Result<Self, HairgenError> {
        let weights = options.weights.normalized()?;
        let GuideOptions { margin, penalty, .. } = *options;
        Ok(Self { flow, region, density, weights, margin, penalty })
    }

    /// The terms of a shape of `rod`, and the derivatives of their weighted sum.
    pub(super) fn terms(&self, rod: &GuideRod, shape: &Shape) -> (Terms, ShapeDerivatives) {
        let positions = shape.positions();
        let mut by = ShapeDerivatives::zeros(positions.len() - 1);
        let [first, second, third, fourth] = self.weights;
        let walls = [self.margin, self.penalty];
        let terms = Terms {
            direction: terms::direction(shape, &self.flow, first, &mut by),
            curvature: terms::curvature(&rod.bends(shape), rod.length, &self.flow, second, &mut by),
            boundary: terms::boundary(positions, self.region, walls, third, &mut by),
            density: self.density.map_or(0.0, |density| density.term(shape, fourth, &mut by)),
        };
        (terms, by)
    }

    /// The weighted sum of the terms.
    pub(super) fn value(&self, terms: &Terms) -> f64 {
        let parts = [terms.direction, terms.curvature, terms.boundary, terms.density];
        parts.iter().zip(self.weights).map(|(part, weight)| part * weight).sum()
    }

    /// The inverse of the second derivatives by the load at an equilibrium, as far as they are
    /// positive: those of the shape by the load are left out (Gauss and Newton), and those of the
    /// density. `None` where the equilibrium has no derivatives.
    pub(super) fn inverse_hessian(&self, rod: &GuideRod, rest: &Rest) -> Option<Matrix6<f64>> {
        let responses = rod.responses(rest).ok()?;
        let [first, second, third, _] = self.weights;
        let (walls, positions) = ([self.margin, self.penalty], rest.shape.positions());
        let mut lower = Matrix6::zeros();
        terms::direction_bend(&self.flow, first, &responses, &mut lower);
        let bends = rod.bends(&rest.shape);
        terms::curvature_bend(&bends, rod.length, &self.flow, second, &responses, &mut lower);
        terms::boundary_bend(positions, self.region, walls, third, &responses, &mut lower);
        let small = DAMPING * lower.trace();
        lower += Matrix6::from_diagonal_element(small);
        lower.cholesky().map(|factor| factor.inverse())
    }

    /// Value at an end load and the equilibrium there, reached from `start`; `None` without an
    /// equilibrium.
    pub(crate) fn at(
        &self,
        rod: &mut GuideRod,
        load: &Vector6<f64>,
        start: &Shape,
    ) -> Option<(f64, Shape)> {
        let rest = rod.relax(&EndLoad::of(load), start).ok()?;
        let (terms, _) = self.terms(rod, &rest.shape);
        let value = self.value(&terms);
        value.is_finite().then_some((value, rest.shape))
    }

    /// Value and gradient by the load at the equilibrium next to `start`; the gradient by the
    /// adjoint method. `None` without an equilibrium.
    pub(super) fn with_gradient(
        &self,
        rod: &mut GuideRod,
        load: &Vector6<f64>,
        start: &Shape,
    ) -> Option<(f64, Vector6<f64>, Rest)> {
        let rest = rod.relax_nearby(&EndLoad::of(load), start).ok()?;
        let (terms, by) = self.terms(rod, &rest.shape);
        let value = self.value(&terms);
        let gradient = rod.by_load(&rest, &by).ok()?;
        value.is_finite().then_some((value, gradient, rest))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{PreGuide, grow_pre_guides};
    use super::*;
    use crate::density::{DensityModel, VoxelFrame};
    use crate::{GuideWeights, Pore};
    use nalgebra::{Point2, Point3, Unit, Vector3};
    use proptest::prelude::*;
    use rapunzel_collision::field::Ball;

    const HEAD: Ball = Ball { center: Point3::new(0.0, 0.0, 0.0), radius: 0.1 };
    const HULL: Ball = Ball { center: Point3::new(0.0, 0.0, 0.0), radius: 0.12 };
    const REGION: Region<'_> = Region { head: &HEAD, hull: &HULL };

    fn pore(x: f64, z: f64, length: f64) -> Pore {
        let normal = Unit::new_normalize(Vector3::new(x, 1.0, z));
        let direction = Unit::new_normalize(normal.into_inner() + Vector3::new(1.2, 0.3, 0.4));
        let position = Point3::from(normal.into_inner() * 0.1);
        Pore { position, normal, direction, length, disc: Point2::new(x, z) }
    }

    /// Pre-guides around the top, and hair across it.
    fn hair(model: DensityModel, options: &GuideOptions) -> (Vec<PreGuide>, HairDensity) {
        let pores = [pore(0.1, 0.0, 0.08), pore(-0.1, 0.2, 0.07), pore(0.0, -0.2, 0.09)];
        let pre = grow_pre_guides(&pores, &[0.2, 0.3, 0.4], REGION, options).expect("pre-guides");
        let corner = Point3::new(0.14, 0.14, 0.14);
        let frame = VoxelFrame::new(-corner, corner, 0.01).expect("voxels");
        let mut density = HairDensity::new(frame, model);
        for i in 0..12 {
            let x = 0.005 * f64::from(i);
            density.add(&[Point3::new(x, 0.1, -0.05), Point3::new(0.04, 0.12 - x, 0.05)]);
        }
        (pre, density)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        /// The adjoint's gradient of each term against central differences of equilibria.
        #[test]
        fn the_gradient_is_that_of_differences(
            load in prop::array::uniform6(-2.0..2.0_f64),
            binary: bool,
            term in 0..4_usize,
        ) {
            let mut weights = [0.0; 4];
            weights[term] = 1.0;
            let [direction, curvature, boundary, density] = weights;
            let weights = GuideWeights { direction, curvature, boundary, density };
            let options = GuideOptions { weights, segments: 24, ..GuideOptions::default() };
            let model = if binary {
                DensityModel::Binary { radius: 0.003 }
            } else {
                DensityModel::Continuous { most: 0.5 }
            };
            let (pre, density) = hair(model, &options);
            let own = pore(0.02, 0.03, 0.08);
            let flow = GuideFlow::at(&own.position, &pre).expect("a flow");
            let objective = Objective::new(flow, REGION, Some(&density), &options);
            let objective = objective.expect("an objective");
            let mut rod = GuideRod::new(&own, 0, &options).expect("a rod");
            let load = Vector6::from(load);
            let straight = rod.straight();
            let found = objective.with_gradient(&mut rod, &load, &straight);
            // A few of the largest loads have none next to the straight rod.
            prop_assume!(found.is_some());
            let (value, gradient, rest) = found.expect("an equilibrium");
            for axis in 0..6 {
                let mut value = |h: f64| {
                    let mut there = load;
                    there[axis] += h;
                    objective.at(&mut rod, &there, &rest.shape).expect("an equilibrium").0
                };
                let difference = |value: &mut dyn FnMut(f64) -> f64, h: f64| {
                    (value(h) - value(-h)) / (2.0 * h)
                };
                // Voxels have kinks between them: near one the differences do not settle.
                let [coarse, fine] = [2e-5, 1e-5].map(|h| difference(&mut value, h));
                let size = gradient.norm() + 1e-3 * value(0.0);
                prop_assume!((coarse - fine).abs() < 1e-7 * size);
                let error = (gradient[axis] - fine).abs() / size;
                prop_assert!(error < 1e-6, "{term} {axis}: {error:e} {value}", value = value(0.0));
            }
            prop_assert!(value >= 0.0);
        }
    }
}
