//! The fast multipole method for point charges.

use super::accuracy::{
    Accuracy, COARSE_COORDINATES, MARGIN, SINGLE, SLOPE, capacity, check_accuracy, guess, low,
    opening, pairs_per_shift, thinning,
};
use super::downward::{BODIES_PER_TASK, Degrees, Descent, Far, Leaf, Task};
use super::reference::{Reference, wanted};
use super::single::SinglePairs;
use super::tree::{Cell, Octree};
use super::upward::{Multipoles, nothing, parts};
use crate::ElectrostaticsError;
use crate::direct_sum::{Cloud, add_pairs, direct_sums, places};
use crate::error::{check_charges, check_positions};
use crate::harmonics::{Coefficient, MAX_ORDER};
use crate::method::{Fields, Method};
use nalgebra::Point3;
use rayon::prelude::*;
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

/// Error of fields, as it was found at sampled targets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate {
    /// Degree of the expansions; `None` where all pairs were summed.
    pub order: Option<usize>,
    /// Number of targets whose fields were compared with the direct sum.
    pub samples: usize,
    /// Relative error of the fields over these targets.
    pub error: f64,
}

/// Fast multipole method (Greengard and Rokhlin, 1987, in the real solid harmonics of the thesis).
///
/// Cost: see the table in the README; memory beside the points about 60 bytes a point and 4 to 12
/// times `(order + 1)^2` bytes a cell, of which there are fewer than one for thirty points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Multipole {
    /// Required accuracy of the fields.
    pub accuracy: Accuracy,
}

impl Method for Multipole {
    fn fields(
        &self,
        sources: &[Point3<f64>],
        charges: &[f64],
        targets: &[Point3<f64>],
    ) -> Result<Fields, ElectrostaticsError> {
        let plan = MultipolePlan::new(sources, targets, self.accuracy)?;
        Ok(plan.fields(charges)?.0)
    }
}

/// Sources and targets in their trees, for any charges.
#[derive(Debug)]
pub struct MultipolePlan {
    accuracy: Accuracy,
    /// Tree of the sources.
    sources: Octree,
    /// Coordinates of the sources (world, m), in the order of their tree.
    places: Arc<[Vec<f64>; 3]>,
    /// Tree of the targets and their coordinates (world, m) in its order; `None` if the targets are
    /// the sources.
    targets: Option<(Octree, Arc<[Vec<f64>; 3]>)>,
}

impl MultipolePlan {
    /// Plan for `sources` and `targets` (world, m), which are sorted into trees. Targets that are
    /// equal to the sources cost nothing.
    ///
    /// # Errors
    /// Positions that are not finite, more than 2^32 of them, and an accuracy outside of
    /// its range.
    pub fn new(
        sources: &[Point3<f64>],
        targets: &[Point3<f64>],
        accuracy: Accuracy,
    ) -> Result<Self, ElectrostaticsError> {
        check_accuracy(accuracy)?;
        check_positions("source", sources)?;
        check_positions("target", targets)?;
        let capacity = capacity(accuracy);
        let plant = |points: &[Point3<f64>]| {
            let tree = Octree::new(points.len(), capacity, |i| [points[i]]);
            let sorted = places(tree.order.par_iter().map(|&i| points[i as usize]));
            (tree, Arc::new(sorted))
        };
        let (tree, sorted) = plant(sources);
        let targets = (sources != targets).then(|| plant(targets));
        Ok(Self { accuracy, sources: tree, places: sorted, targets })
    }

    /// Fields of `charges` (C) at the targets, and how exact they are.
    ///
    /// # Errors
    /// Charges that are not finite or not one for each source, and a tolerance out of
    /// reach.
    pub fn fields(&self, charges: &[f64]) -> Result<(Fields, Certificate), ElectrostaticsError> {
        check_charges(charges, self.sources.order.len())?;
        let unit = unit(charges);
        let charge = self.sources.order.par_iter().map(|&i| charges[i as usize] / unit).collect();
        let cloud = Cloud { x: Arc::clone(&self.places), charge };
        let own = (&self.sources, &self.places);
        let (tree, places) = self.targets.as_ref().map_or(own, |(tree, places)| (tree, places));
        let (plan, cloud) = (self, &cloud);
        // What is found in single precision, or partly so, may be too inexact or overflow.
        let opening = opening(self.accuracy);
        let single = || {
            let real = PhantomData::<f32>;
            PointSum { plan, cloud, targets: tree, places, opening, low: None, real }.run()
        };
        let double = |low| {
            let real = PhantomData::<f64>;
            PointSum { plan, cloud, targets: tree, places, opening, low, real }.run()
        };
        let finite = |(sums, _): &(Vec<[f64; 4]>, Certificate)| {
            sums.par_chunks(PART).all(|part| part.as_flattened().iter().all(|x| x.is_finite()))
        };
        let quick = match self.accuracy {
            Accuracy::Tolerance(tolerance) if tolerance >= SINGLE => single().ok(),
            Accuracy::Tolerance(tolerance) => double(Some(low(tolerance))).ok(),
            Accuracy::Order(_) => None,
        };
        let (sums, certificate) = match quick.filter(finite) {
            Some(found) => found,
            None => double(None)?,
        };
        let place = tree.places();
        Ok((Fields::new(unit, sums.len(), |i| sums[place[i] as usize]), certificate))
    }
}

/// Count of numbers that a thread looks at without a break.
const PART: usize = 4096;

/// Unit (C) in which the largest of `charges` is near one, so that squares of fields stay within
/// range; a power of two keeps their bits.
pub(crate) fn unit(charges: &[f64]) -> f64 {
    let largest = |part: &[f64]| part.iter().fold(0.0, |most: f64, q| most.max(q.abs()));
    let parts: Vec<_> = charges.par_chunks(PART).map(largest).collect();
    let most = largest(&parts);
    if most > 0.0 { most.log2().floor().exp2() } else { 1.0 }
}

/// Least length that distances are divided by, over the radius of all targets, so that no power of
/// theirs overflows.
const LEAST: f64 = 1e-8;

/// Sum of the fields of all sources at all targets, with expansions of the type `E`.
struct PointSum<'a, E> {
    /// Accuracy and trees.
    plan: &'a MultipolePlan,
    /// Sources in the order of their tree.
    cloud: &'a Cloud,
    /// Tree of the targets.
    targets: &'a Octree,
    /// Coordinates of the targets (world, m), in the order of their tree.
    places: &'a [Vec<f64>; 3],
    /// Largest ratio of the sum of the radii of two cells to their distance at which expansions
    /// are used.
    opening: f64,
    /// Degree from which on expansions are moved in single precision, if that is not `E`.
    low: Option<usize>,
    /// Precision of the expansions.
    real: PhantomData<E>,
}

impl<E: Coefficient> PointSum<'_, E> {
    /// Potential and its gradient at each target, in the order of their tree, and the error at
    /// samples.
    fn run(&self) -> Result<(Vec<[f64; 4]>, Certificate), ElectrostaticsError> {
        let (n, m) = (self.cloud.len(), self.places[0].len());
        let direct = || {
            let certificate = Certificate { order: None, samples: 0, error: 0.0 };
            (direct_sums(self.cloud, 0.0, self.places), certificate)
        };
        let tolerance = match self.plan.accuracy {
            Accuracy::Tolerance(tolerance) => tolerance,
            Accuracy::Order(_) => 0.0,
        };
        // Few pairs are summed directly, and targets of which the reference would take half.
        if tolerance > 0.0 && (n * m < 4_000_000 || m < 2 * wanted(n, m)) {
            return Ok(direct());
        }
        let reference = Reference::new(self.cloud, self.places, &self.strengths(), self.targets);
        let guess = guess(self.plan.accuracy);
        let (order, multipoles, error) = if tolerance > 0.0 {
            let multipoles = |order| {
                let multipoles = Multipoles::new(&self.plan.sources, self.cloud, 1, order);
                match self.low {
                    Some(low) if low <= order => multipoles.rounded(low),
                    _ => multipoles,
                }
            };
            let error = |multipoles: &Multipoles<E>, order| {
                let mut out = vec![[0.0; 4]; m];
                self.descend(multipoles, order, Some(&reference.samples), &mut out);
                reference.error(&out)
            };
            // Half the degree takes an eighth of the time, and tells which will be enough.
            find_order(guess.div_ceil(2), tolerance, multipoles, error)?
        } else {
            let multipoles = Multipoles::new(&self.plan.sources, self.cloud, 1, guess);
            (guess, multipoles, f64::NAN)
        };
        let mut out = nothing(m);
        self.descend(&multipoles, order, None, &mut out);
        let error = if error.is_nan() { reference.error(&out) } else { error };
        let samples = reference.samples.len();
        Ok((out, Certificate { order: Some(order), samples, error }))
    }

    /// Estimates of the square of the field at each target: what its own leaf makes, where targets
    /// are sources, else what quadrupoles make.
    fn strengths(&self) -> Vec<f64> {
        let square = |[_, x, y, z]: [f64; 4]| x * x + y * y + z * z;
        if self.plan.targets.is_none() {
            let mut leaves: Vec<_> =
                self.targets.cells.iter().filter(|cell| cell.is_leaf()).collect();
            leaves.sort_by_key(|leaf| leaf.bodies.start);
            let mut squares = vec![0.0; self.places[0].len()];
            let parts = parts(&mut squares, leaves.iter().map(|leaf| leaf.bodies.clone()));
            leaves.into_par_iter().zip(parts).with_max_len(64).for_each(
                |(leaf, (own, squares))| {
                    let mut out = vec![[0.0; 4]; own.len()];
                    self.add_near(leaf, &[own], &mut out);
                    squares.iter_mut().zip(out).for_each(|(to, out)| *to = square(out));
                },
            );
            squares
        } else {
            let mut out = vec![[0.0; 4]; self.places[0].len()];
            let multipoles = Multipoles::new(&self.plan.sources, self.cloud, 1, 2);
            self.descend(&multipoles, 2, None, &mut out);
            out.into_par_iter().map(square).collect()
        }
    }

    /// Adds the action of the bodies `near` on those of `cell`.
    fn add_near(&self, cell: &Cell, near: &[Range<usize>], out: &mut [[f64; 4]]) {
        if size_of::<E>() == size_of::<f64>() {
            add_pairs(self.cloud, near, 0.0, self.places, cell.bodies.clone(), out);
        } else {
            let least = LEAST * self.targets.cells[0].scale;
            let fine =
                !matches!(self.plan.accuracy, Accuracy::Tolerance(t) if t >= COARSE_COORDINATES);
            let own = if self.plan.targets.is_none() { cell.bodies.clone() } else { 0..0 };
            let (sources, ranges, places) = (self.cloud, near, self.places);
            SinglePairs { sources, ranges, places, cell, own, least, fine, out }.add();
        }
    }

    /// Adds to `out` the sums of all sources at the targets, or at the sampled ones, by expansions
    /// of degree `order`.
    fn descend(
        &self,
        multipoles: &Multipoles<E>,
        order: usize,
        samples: Option<&[usize]>,
        out: &mut [[f64; 4]],
    ) {
        Descent {
            sources: multipoles,
            targets: self.targets,
            leaf: self,
            order,
            opening: self.opening,
            degrees: Degrees::new(order, self.opening, thinning(self.plan.accuracy)),
            clearance: 0.0,
            direct: pairs_per_shift(order),
            grain: BODIES_PER_TASK,
            samples,
        }
        .run(out);
    }
}

impl<E: Coefficient> Leaf for PointSum<'_, E> {
    type Out = [f64; 4];

    fn receive(&self, cell: &Cell, far: &Far, near: &[Range<usize>], mut task: Task<[f64; 4]>) {
        let out = task.of(cell);
        far.add(cell, self.places, cell.bodies.clone(), out);
        self.add_near(cell, near, out);
    }
}

/// Smallest degree whose error at the samples is within the tolerance, with multipoles of this
/// degree or more and the error; `start` is the first degree that is tried.
pub(crate) fn find_order<'a, E: Coefficient>(
    start: usize,
    tolerance: f64,
    multipoles: impl Fn(usize) -> Multipoles<'a, E>,
    error: impl Fn(&Multipoles<'a, E>, usize) -> f64,
) -> Result<(usize, Multipoles<'a, E>, f64), ElectrostaticsError> {
    let allowed = MARGIN * tolerance;
    let mut order = start;
    let mut expansions = multipoles(order);
    let mut highest = order;
    let mut errors = [f64::NAN; MAX_ORDER + 1];
    loop {
        if errors[order].is_nan() {
            errors[order] = error(&expansions, order);
        }
        let reached = errors[order];
        if reached <= allowed {
            // What is almost too large is so with one degree less.
            let almost = reached > (-0.8 * SLOPE).exp() * allowed;
            if order == 1 || almost || errors[order - 1] > allowed {
                return Ok((order, expansions, reached));
            }
            order -= 1;
        } else {
            // An error that two degrees more leave as it is has another cause; one that is no
            // number is that of single precision out of its range.
            let earlier =
                errors[..order.saturating_sub(1)].iter().copied().fold(f64::INFINITY, f64::min);
            if order == MAX_ORDER || reached > 0.9 * earlier || !reached.is_finite() {
                return Err(ElectrostaticsError::OutOfReach { tolerance, reached, order });
            }
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some")]
            let more = ((reached / allowed).ln() / SLOPE).ceil().clamp(1.0, 40.0) as usize;
            order = (order + more).min(MAX_ORDER);
            if order > highest {
                expansions = multipoles(order);
                highest = order;
            }
        }
    }
}
