//! What segments do to each other, and a conductor to them.

use super::columns::SegmentColumns;
use super::lines::{Loads, SegmentLines};
use super::near::add_close;
use super::parallel::Parallel;
use super::reference::{STRICTEST, exact};
use super::rules::{Node, Rules};
use crate::direct_sum::Cloud;
use crate::harmonics::{Coefficient, MAX_ORDER};
use crate::head::outside::ExteriorBodies;
use crate::multipole::accuracy::{SINGLE, guess, thinning};
use crate::multipole::downward::{Degrees, Descent, Far, Leaf, Task};
use crate::multipole::samples::{SAMPLES, error, samples};
use crate::multipole::solver::find_order;
use crate::multipole::tree::{Cell, Octree};
use crate::multipole::upward::{Multipoles, nothing, scaled};
use crate::{Accuracy, Certificate, Condition, ConductingSurface, ElectrostaticsError};
use rayon::prelude::*;
use std::ops::Range;

/// Largest ratio of radii to distance at which expansions of segments are used.
const SEGMENT_OPENING: f64 = 0.79;

/// Least and most number of bodies below which a subtree is one task: pairs within one need be
/// looked at once, and there must be tasks enough for all threads.
const TASK: [usize; 2] = [8192, 131_072];

/// Number of subtrees that are one task each, about, if they have that many bodies.
const TASKS: usize = 16;

/// Number of bodies below which a subtree is one task, for a tree of so many `bodies`.
fn grain(bodies: usize) -> usize {
    (bodies / TASKS).clamp(TASK[0], TASK[1])
}

/// Conductor beside the segments.
#[derive(Clone, Copy)]
pub(super) struct Beside<'a> {
    /// Surface of the conductor.
    pub(super) surface: &'a ConductingSurface,
    /// Known potential or charge of the conductor.
    pub(super) condition: Condition,
    /// Unit of the charges of the segments, C.
    pub(super) unit: f64,
}

/// Solution for all segments.
pub(super) struct SegmentSolution {
    /// Loads of the segments, in the order of their tree.
    pub(super) loads: Vec<Loads>,
    /// Energy of the conductor beside that of the segments, J.
    pub(super) energy: f64,
    /// Error of the loads at sampled segments.
    pub(super) certificate: Certificate,
}

/// Loads of `lines`, which are in the order of `tree`; with stricter rules where these are not
/// enough.
pub(super) fn loads(
    tree: &Octree,
    lines: &SegmentLines,
    beside: Option<Beside>,
    accuracy: Accuracy,
) -> Result<SegmentSolution, ElectrostaticsError> {
    let (tolerance, adaptive) = match accuracy {
        Accuracy::Tolerance(tolerance) => (tolerance, true),
        Accuracy::Order(_) => (1e-6, false),
    };
    if adaptive && tolerance >= SINGLE {
        let found = SegmentSum::<f32>::new(tree, lines, beside, tolerance, accuracy).run();
        let finite =
            |found: &SegmentSolution| found.loads.as_flattened().iter().all(|x| x.is_finite());
        if let Some(found) = found.ok().filter(finite) {
            return Ok(found);
        }
    }
    let mut strictness = 1.0;
    loop {
        let error = strictness * tolerance;
        match SegmentSum::<f64>::new(tree, lines, beside, error, accuracy).run() {
            Err(ElectrostaticsError::OutOfReach { .. }) if error > STRICTEST => {
                strictness *= 0.03;
            }
            result => return result,
        }
    }
}

/// Error of rules over the tolerance of the forces, from measured errors of both.
const RULE_SHARE: f64 = 0.7;

/// Relative error of closed forms at worst: with a smaller tolerance the certificate says what was
/// reached.
const CLOSED: f64 = 2e-11;

/// Pairs of segments that cost little: of so many the action is found without expansions, which in
/// a small cloud may err at few segments by more than at all samples.
const SAMPLED_PAIRS: usize = 40_000;

/// Sum of the actions of all segments on each other, with expansions of the type `E`.
struct SegmentSum<'a, E> {
    /// Tree of the segments.
    tree: &'a Octree,
    /// Segments in the order of the tree.
    lines: &'a SegmentLines,
    /// Conductor beside the segments, if there is one.
    beside: Option<Beside<'a>>,
    /// Rules for pairs that are not close.
    rules: Rules<E>,
    /// Points of each segment by the rule for those far away.
    cloud: Cloud,
    /// Integrals for close pairs that are nearly parallel.
    parallel: Parallel,
    /// Least gap (m) between cells whose expansions are used.
    clearance: f64,
    /// Required accuracy of the forces.
    accuracy: Accuracy,
}

impl<'a, E: Coefficient> SegmentSum<'a, E> {
    /// Sum with rules that err by about `error`.
    fn new(
        tree: &'a Octree,
        lines: &'a SegmentLines,
        beside: Option<Beside<'a>>,
        error: f64,
        accuracy: Accuracy,
    ) -> Self {
        let rules = Rules::<E>::new((RULE_SHARE * error).min(0.1));
        let points = rules.far();
        let each = |value: &(dyn Fn(usize, &Node<E>) -> f64 + Sync)| {
            let at = |k: usize| value(k / points.len(), &points[k % points.len()]);
            (0..lines.count() * points.len()).into_par_iter().map(at).collect()
        };
        let [x, y, z, a, b, c, .., charge] = &lines.bars;
        let place =
            |x: &Vec<f64>, half: &Vec<f64>| each(&|i, node| x[i] + node.place.to_f64() * half[i]);
        let charge = each(&|i, node| charge[i] * node.weight.to_f64());
        let cloud = Cloud::new([place(x, a), place(y, b), place(z, c)], charge);
        let longest = (0..lines.count()).map(|i| lines.length(i)).fold(0.0, f64::max);
        let clearance = 0.5 * rules.clearance() * longest;
        let parallel = Parallel::new(error);
        Self { tree, lines, beside, rules, cloud, parallel, clearance, accuracy }
    }

    /// Loads of all segments, by each other and by the conductor.
    fn run(&self) -> Result<SegmentSolution, ElectrostaticsError> {
        let (mut loads, mut certificate, multipoles, order) = self.mutual()?;
        let Some(Beside { surface, condition, unit }) = self.beside else {
            return Ok(SegmentSolution { loads, energy: 0.0, certificate });
        };
        let per_body = self.rules.far().len();
        let outside = ExteriorBodies { tree: self.tree, cloud: &self.cloud, per_body };
        surface.check_bodies(outside)?;
        let add = |i: usize, sums: &[[f64; 4]], out: &mut Loads| self.add_points(i, sums, out);
        let (charged, sources) = ((outside, unit), (&multipoles, order));
        let [energy, error] =
            surface.act(condition, charged, sources, self.accuracy, &add, &mut loads)?;
        certificate.error = certificate.error.max(error);
        Ok(SegmentSolution { loads, energy, certificate })
    }

    /// Loads of the segments by each other, with the multipoles of the segments and the degree of
    /// these.
    fn mutual(
        &self,
    ) -> Result<(Vec<Loads>, Certificate, Multipoles<'_, E>, usize), ElectrostaticsError> {
        let count = self.tree.order.len();
        let multipoles =
            |order| Multipoles::<E>::new(self.tree, &self.cloud, self.rules.far().len(), order);
        let order = (guess(self.accuracy) + 1).min(MAX_ORDER);
        let wanted = (SAMPLED_PAIRS / count.max(1)).max(SAMPLES);
        if count <= wanted {
            let all: Vec<_> = (0..count).collect();
            let certificate = Certificate { order: None, samples: 0, error: 0.0 };
            return Ok((
                exact(self.lines, self.accuracy, &all),
                certificate,
                multipoles(order),
                order,
            ));
        }
        let samples = samples(count, wanted);
        let exact = exact(self.lines, self.accuracy, &samples);
        let (order, multipoles) = match self.accuracy {
            Accuracy::Order(order) => (order, multipoles(order)),
            Accuracy::Tolerance(tolerance) => {
                let error = |multipoles: &Multipoles<E>, order| {
                    let mut out = vec![[0.0; 7]; count];
                    self.descend(multipoles, order, Some(&samples), &mut out);
                    error(&samples, &out, &exact)
                };
                let (order, multipoles, _) = find_order(order, tolerance, multipoles, error)?;
                (order, multipoles)
            }
        };
        let mut out = nothing(count);
        self.descend(&multipoles, order, None, &mut out);
        let reached = error(&samples, &out, &exact);
        match self.accuracy {
            Accuracy::Tolerance(tolerance) if reached > tolerance.max(CLOSED) => {
                Err(ElectrostaticsError::OutOfReach { tolerance, reached, order })
            }
            _ => {
                let certificate =
                    Certificate { order: Some(order), samples: samples.len(), error: reached };
                Ok((out, certificate, multipoles, order))
            }
        }
    }

    /// Adds to `out` the loads of all segments, or of the sampled ones, by expansions of degree
    /// `order` and by close pairs.
    fn descend(
        &self,
        sources: &Multipoles<E>,
        order: usize,
        samples: Option<&[usize]>,
        out: &mut [Loads],
    ) {
        let (targets, opening, clearance) = (self.tree, SEGMENT_OPENING, self.clearance);
        let (leaf, direct) = (self, 0);
        let degrees = Degrees::new(order, opening, thinning(self.accuracy));
        let grain = grain(targets.order.len());
        Descent {
            sources,
            targets,
            leaf,
            order,
            opening,
            degrees,
            clearance,
            direct,
            grain,
            samples,
        }
        .run(out);
    }

    /// Adds to `out` the loads of segment `i` by the potentials and gradients `sums` at its points:
    /// the force at a point is shared by the ends as a lever.
    fn add_points(&self, i: usize, sums: &[[f64; 4]], out: &mut Loads) {
        let rule = self.rules.far();
        let charges = &self.cloud.charge[i * rule.len()..];
        for ((node, charge), [potential, gradient @ ..]) in rule.iter().zip(charges).zip(sums) {
            let x = node.place.to_f64();
            out[0] += 0.5 * charge * potential;
            for c in 0..3 {
                let force = -charge * gradient[c];
                out[1 + c] += 0.5 * (1.0 - x) * force;
                out[4 + c] += 0.5 * (1.0 + x) * force;
            }
        }
    }
}

impl<E: Coefficient> Leaf for SegmentSum<'_, E> {
    type Out = Loads;

    fn receive(&self, cell: &Cell, far: &Far, near: &[Range<usize>], mut task: Task<Loads>) {
        let points = self.rules.far().len();
        // Far field: local expansions at the points of the rule.
        let own = scaled(&cell.bodies, points);
        let mut sums = vec![[0.0; 4]; own.len()];
        far.add(cell, &self.cloud.x, own, &mut sums);
        let out = task.of(cell);
        for ((i, out), sums) in cell.bodies.clone().zip(&mut *out).zip(sums.chunks_exact(points)) {
            self.add_points(i, sums, out);
            self.lines.add_self(i, out);
        }
        // Pairs with segments that come later in the task are found here for both.
        let within = |part: Range<usize>| {
            let common =
                move |near: &Range<usize>| near.start.max(part.start)..near.end.min(part.end);
            near.iter().map(common).filter(|range| !range.is_empty())
        };
        let (first, last) = (task.bodies.start, task.bodies.end);
        let (alone, mutual): (Vec<_>, Vec<_>) = match task.samples {
            Some(_) => (near.to_vec(), Vec::new()),
            None => (
                within(0..first)
                    .chain(within(cell.bodies.clone()))
                    .chain(within(last..usize::MAX))
                    .collect(),
                within(cell.bodies.end..last).collect(),
            ),
        };
        // Near field: rules where one serves, else closed forms.
        let mut columns = SegmentColumns::new(self.lines, cell.center.into(), [&alone, &mutual]);
        let targets = task.wanted(cell);
        let mut loads = vec![[0.0; 7]; targets.len()];
        let mut pairs = columns.act(self.lines, &self.rules, &targets, &mut loads);
        for (j, loads) in targets.into_iter().zip(loads).chain(columns.felt()) {
            task.of_body(j).iter_mut().zip(loads).for_each(|(sum, load)| *sum += load);
        }
        pairs.retain(|&[i, j]| j > i || !task.both(j));
        add_close(self.lines, &pairs, &self.parallel, task);
    }
}
