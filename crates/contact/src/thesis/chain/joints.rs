use super::link::{ChainLink, wall};
use super::springs::JointSprings;
use super::tridiagonal::Tridiagonal;
use super::{ChainForm, Coupling, CylinderChain, JointMethod};
use crate::ContactError;
use nalgebra::{Matrix3, Rotation3, SVector, Vector3};
use rapunzel_fiber::so3;

/// Newton's iterations for the joints of a step; three or four are usual.
const ITERATIONS: usize = 30;

/// Distance of a joint's frames, m, and their mean at the start of the step.
type Start = (f64, Rotation3<f64>);

/// A chain in a step: its segments' links and what its joints must fulfil.
pub(super) struct Joints<'a> {
    chain: &'a CylinderChain,
    dt: f64,
    /// Segment towards the tip of joint 0.
    first: usize,
    /// Springs that are unknowns, and the joints' distances and mean frames at the start.
    springs: Option<(&'a JointSprings, Vec<Option<Start>>)>,
    pub(super) links: Vec<ChainLink>,
    /// The links as the printed (8.87) moves those towards the tip.
    mirrored: Option<Vec<ChainLink>>,
}

/// The joints' impulses on every segment, summed: linear, N s, and angular, N m s.
pub(super) type JointSums = Vec<[Vector3<f64>; 2]>;

impl<'a> Joints<'a> {
    pub(super) fn new(
        chain: &'a CylinderChain,
        links: Vec<ChainLink>,
        dt: f64,
        form: &ChainForm,
    ) -> Self {
        let springs = chain.springs.as_ref().filter(|s| s.coupling != Coupling::Explicit);
        let springs = springs.map(|springs| {
            let bends = chain.bends();
            let frames = bends.iter().map(|b| b.as_ref().map(|b| (b.distance, b.mean))).collect();
            (springs, frames)
        });
        let mirrored = (!form.signs.is_corrected()).then(|| links.clone());
        let first = chain.segments.len() - chain.joints();
        Self { chain, dt, first, springs, links, mirrored }
    }

    /// Finds the joints' impulses; leaves the links at the end of the step. Returns the sums of
    /// impulses and the number of linear solves. `index` is the chain's, for the error.
    pub(super) fn close(
        &mut self,
        method: JointMethod,
        index: usize,
    ) -> Result<(JointSums, usize), ContactError> {
        match self.springs {
            Some(_) => self.solve::<6>(method, index),
            None => self.solve::<3>(method, index),
        }
    }

    fn solve<const D: usize>(
        &mut self,
        method: JointMethod,
        index: usize,
    ) -> Result<(JointSums, usize), ContactError> {
        let mut impulses = vec![SVector::<f64, D>::zeros(); self.chain.joints()];
        let (mut iterations, mut last) = (0, f64::INFINITY);
        loop {
            let mut residuals = self.residuals(&impulses);
            let (gap, joint) = widest(&residuals);
            let open = |gap| ContactError::Joint { chain: index, joint, gap, iterations };
            let rounding = self.rounding();
            if iterations == ITERATIONS || !gap.is_finite() {
                return Err(open(if gap.is_finite() { gap } else { f64::INFINITY }));
            }
            let done = gap <= rounding || (gap >= 0.5 * last && gap <= 1e3 * rounding);
            if done || (method == JointMethod::Linearized && iterations == 1) {
                return Ok((self.sums(&impulses), iterations));
            }
            if method == JointMethod::Linearized {
                self.links.iter_mut().for_each(ChainLink::linearize);
            }
            let mut matrix = self.matrix::<D>();
            matrix.solve(&mut residuals).map_err(|_| open(f64::INFINITY))?;
            for (impulse, correction) in impulses.iter_mut().zip(&residuals) {
                *impulse -= correction;
            }
            let sums = self.sums(&impulses);
            for (link, [impulse, angular]) in self.links.iter_mut().zip(&sums) {
                link.move_on(impulse, angular);
            }
            for (link, [impulse, angular]) in self.mirrored.iter_mut().flatten().zip(&sums) {
                link.move_on(&-impulse, &-angular);
            }
            (iterations, last) = (iterations + 1, gap);
        }
    }

    /// Gap of a joint that is rounding for positions of the size of these, m.
    fn rounding(&self) -> f64 {
        let reach = self.links.iter().map(|link| link.center.amax()).fold(0.0, f64::max);
        let length: f64 = self.chain.half_lengths.iter().sum();
        16.0 * f64::EPSILON * (reach + 2.0 * length)
    }

    fn inner(&self, l: usize) -> &ChainLink {
        &self.mirrored.as_ref().unwrap_or(&self.links)[l]
    }

    /// The rotation of joint `j` at the end of the step, `log(R_k^T R_l)`; `None` without springs.
    fn angle(&self, j: usize) -> Option<Vector3<f64>> {
        let (_, frames) = self.springs.as_ref()?;
        frames[j].as_ref()?;
        let l = j + self.first;
        let k = match l.checked_sub(1) {
            Some(k) => self.links[k].frame,
            None => wall(self.chain)?.1?,
        };
        Some(so3::log(&(k.inverse() * self.inner(l).frame)))
    }

    /// Per joint the gap (8.76), and `ds kappa_0 + ds/dt K^-1 F^T L* - theta` where springs are
    /// unknowns, with `F` the mean frame at the start; the orientation joint has `K^-1 = 0`.
    fn residuals<const D: usize>(&self, impulses: &[SVector<f64, D>]) -> Vec<SVector<f64, D>> {
        let wall = wall(self.chain);
        let residual = |j: usize| {
            let l = j + self.first;
            let outward = match (l.checked_sub(1), wall) {
                (Some(k), _) => self.links[k].end(1.0),
                (None, wall) => wall.map_or_else(Vector3::zeros, |(point, _)| point.coords),
            };
            let mut residual = SVector::<f64, D>::zeros();
            residual.rows_mut(0, 3).copy_from(&(outward - self.inner(l).end(-1.0)));
            if let Some((springs, frames)) = &self.springs {
                let angular = impulses[j].fixed_view::<3, 1>(3, 0).into_owned();
                let bend = match (&frames[j], self.angle(j)) {
                    (Some((distance, mean)), Some(angle)) => {
                        let moment = mean.inverse() * angular / self.dt;
                        *distance * (springs.natural[j] + springs.compliance() * moment) - angle
                    }
                    _ => angular,
                };
                residual.rows_mut(3, 3).copy_from(&bend);
            }
            residual
        };
        (0..impulses.len()).map(residual).collect()
    }

    /// The residuals' derivatives with respect to the impulses, (8.98).
    fn matrix<const D: usize>(&self) -> Tridiagonal<D> {
        let count = self.chain.joints();
        let mut matrix = Tridiagonal::default();
        let inner_sign = if self.mirrored.is_some() { -1.0 } else { 1.0 };
        for j in 0..count {
            let l = j + self.first;
            let bend = self.angle(j).map_or_else(Matrix3::zeros, |angle| {
                so3::right_jacobian_inverse(&angle) * self.inner(l).frame.inverse().matrix()
            });
            let mut diagonal = inner_sign * self.inner(l).couple::<D>(-1.0, -1.0, &bend);
            let mut lower = diagonal * 0.0;
            if let Some(k) = l.checked_sub(1) {
                diagonal += self.links[k].couple::<D>(1.0, 1.0, &bend);
                if j > 0 {
                    lower = self.links[k].couple(1.0, -1.0, &bend);
                }
            }
            let mut upper = diagonal * 0.0;
            if j + 1 < count {
                upper = inner_sign * self.inner(l).couple::<D>(-1.0, 1.0, &bend);
            }
            if let Some((springs, frames)) = &self.springs {
                let own = frames[j].as_ref().map_or_else(Matrix3::identity, |(distance, mean)| {
                    springs.compliance() * mean.inverse().matrix() * (*distance / self.dt)
                });
                let mut block = diagonal.view_mut((3, 3), (3, 3));
                block += own;
            }
            matrix.lower.push(lower);
            matrix.diagonal.push(diagonal);
            matrix.upper.push(upper);
        }
        matrix
    }

    fn sums<const D: usize>(&self, impulses: &[SVector<f64, D>]) -> JointSums {
        let sum = |(b, link): (usize, &ChainLink)| {
            let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
            let outward = impulses.get(b + 1 - self.first);
            let inward = b.checked_sub(self.first).and_then(|j| impulses.get(j));
            for (impulse, side) in [(outward, 1.0), (inward, -1.0)] {
                let Some(impulse) = impulse else { continue };
                let p = impulse.fixed_view::<3, 1>(0, 0).into_owned();
                linear += side * p;
                // Both the sign and the lever change sides.
                angular += link.lever.cross(&p);
                if D == 6 {
                    angular += side * impulse.fixed_view::<3, 1>(3, 0);
                }
            }
            [linear, angular]
        };
        self.links.iter().enumerate().map(sum).collect()
    }
}

/// Largest residual (m and rad alike) and its joint.
fn widest<const D: usize>(residuals: &[SVector<f64, D>]) -> (f64, usize) {
    residuals.iter().enumerate().fold((0.0, 0), |widest, (joint, residual)| {
        // A component that is no number is the widest.
        let size = residual
            .iter()
            .map(|x| x.abs())
            .fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a });
        if size > widest.0 || size.is_nan() { (size, joint) } else { widest }
    })
}
