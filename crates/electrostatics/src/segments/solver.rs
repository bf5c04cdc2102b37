//! Energy and nodal forces of charged fibres.

use super::lines::{Lines, Loads};
use super::near::add_close;
use super::pairs::Columns;
use super::parallel::Parallel;
use super::reference::{STRICTEST, exact};
use super::rules::{Node, Rules};
use crate::error::{check_charges, check_count, check_positions};
use crate::multipole::engine::{Degrees, Descent, Far, Leaf, Multipoles, Task};
use crate::multipole::near::Cloud;
use crate::multipole::solver::{SINGLE, check_accuracy, find_order, guess, thinning};
use crate::multipole::tree::{Cell, Tree};
use crate::real::Real;
use crate::{Accuracy, COULOMB_CONSTANT, Certificate, ElectrostaticsError};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Layout;
use rayon::prelude::*;
use std::ops::Range;

/// Segments in a leaf, from measured rates.
const CAPACITY: usize = 64;

/// Segments whose forces are compared with the direct sum.
const SAMPLES: usize = 48;

/// Largest ratio of radii to distance at which expansions are used.
const OPENING: f64 = 0.76;

/// Charged fibres: the straight segments between their nodes, each with its charge spread evenly.
///
/// A segment acts on itself and on its neighbors by the kernel `1/sqrt(r^2 + a^2)` with the radius a
/// of the fibre; for a ring this gives the self-force `lambda^2/R (ln(8R/a) - 1)` of a charged torus,
/// if segments are longer than ten radii. All others act as lines, which for round fibres that do
/// not overlap is exact.
#[derive(Debug, Clone)]
pub struct ChargedFibers<'a> {
    /// How nodes and segments are numbered.
    pub layout: &'a Layout,
    /// Charge of each segment, C; a charge density that varies along a fibre is constant in a segment.
    pub charges: &'a [f64],
    /// Radius of each fibre, m.
    pub radii: &'a [f64],
    /// How exact the forces on the nodes must be: the root of the sum of their squared errors over that
    /// of their squares.
    pub accuracy: Accuracy,
}

/// What charged fibres do to each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Electrostatics {
    /// Their energy with their own, J.
    pub energy: f64,
    /// Forces on the nodes (world), N: the negative gradient of the energy, each segment keeping its
    /// charge.
    pub forces: Vec<Vector3<f64>>,
    /// How exact the forces are, at sampled segments.
    pub certificate: Certificate,
}

impl ChargedFibers<'_> {
    /// Energy and forces with the nodes at `positions` (world, m).
    ///
    /// Close pairs are integrated in closed form, all others by points of a rule on both. A segment may see
    /// another by a better rule than that sees it, so forces are the gradient of the energy, and there is
    /// no net force or moment, to the tolerance.
    /// Cost: see the README.
    ///
    /// # Errors
    /// Arrays that do not fit, positions or charges that are not finite, radii that are not positive,
    /// segments without length, and an accuracy out of range or reach.
    pub fn forces(&self, positions: &[Point3<f64>]) -> Result<Electrostatics, ElectrostaticsError> {
        self.check(positions)?;
        let ends = |segment| self.layout.segment_nodes(segment).map(|node| positions[node]);
        let count = self.layout.segments();
        let unit = self.charges.iter().fold(0.0, |unit: f64, q| unit.max(q.abs()));
        let unit = if unit > 0.0 { unit.log2().floor().exp2() } else { 1.0 };
        let tree = Tree::new(count, CAPACITY, ends);
        let lines = self.lines(&tree, unit, ends);
        let (loads, certificate) = self.loads(&tree, &lines)?;
        let factor = COULOMB_CONSTANT * unit * unit;
        let mut places = vec![0; count];
        tree.order.iter().enumerate().for_each(|(k, &i)| places[i as usize] = k);
        let forces = |fiber: usize| {
            let mut forces = vec![Vector3::zeros(); self.layout.node_range(fiber).len()];
            for (a, segment) in self.layout.segment_range(fiber).enumerate() {
                let [_, start @ .., bx, by, bz] = loads[places[segment]];
                forces[a] += factor * Vector3::from(start);
                forces[a + 1] += factor * Vector3::new(bx, by, bz);
            }
            forces
        };
        Ok(Electrostatics {
            energy: factor * loads.iter().map(|load| load[0]).sum::<f64>(),
            forces: (0..self.layout.fibers()).into_par_iter().flat_map_iter(forces).collect(),
            certificate,
        })
    }

    /// The loads in the order of `tree`; with stricter rules for segments where these are not enough.
    fn loads(
        &self,
        tree: &Tree,
        lines: &Lines,
    ) -> Result<(Vec<Loads>, Certificate), ElectrostaticsError> {
        let (tolerance, adaptive) = match self.accuracy {
            Accuracy::Tolerance(tolerance) => (tolerance, true),
            Accuracy::Order(_) => (1e-6, false),
        };
        if adaptive && tolerance >= SINGLE {
            let found = Sum::<f32>::new(tree, lines, tolerance, self.accuracy).run();
            let finite = |(loads, _): &(Vec<Loads>, Certificate)| {
                loads.as_flattened().iter().all(|x| x.is_finite())
            };
            if let Some(found) = found.ok().filter(finite) {
                return Ok(found);
            }
        }
        let mut strictness = 1.0;
        loop {
            let error = strictness * tolerance;
            match Sum::<f64>::new(tree, lines, error, self.accuracy).run() {
                Err(ElectrostaticsError::OutOfReach { .. }) if error > STRICTEST => {
                    strictness *= 0.03;
                }
                result => return result,
            }
        }
    }

    /// The segments in the order of `tree`.
    fn lines(&self, tree: &Tree, unit: f64, ends: impl Fn(usize) -> [Point3<f64>; 2]) -> Lines {
        let mut lines = Lines::default();
        for &i in &tree.order {
            let segment = i as usize;
            let fiber = self.layout.segment_fibers()[segment];
            let charge = self.charges[segment] / unit;
            #[expect(clippy::cast_possible_truncation, reason = "no more than 2^32 segments")]
            lines.push(ends(segment), charge, self.radii[fiber], [fiber as u32, i]);
        }
        lines
    }

    /// The second derivative of the energy in the direction `v` (m, one vector a node), N: the
    /// central difference of the forces over a step of 1e-5 of the mean segment at the largest `v`.
    ///
    /// Relative error about 1e-6 if the tolerance is 1e-9 or less. Cost: two calls of
    /// [`forces`](Self::forces).
    ///
    /// # Errors
    /// Those of `forces`, and a direction that does not have one vector a node.
    pub fn hessian_product(
        &self,
        positions: &[Point3<f64>],
        v: &[Vector3<f64>],
    ) -> Result<Vec<Vector3<f64>>, ElectrostaticsError> {
        self.check(positions)?;
        check_count("vectors of the direction", v.len(), positions.len())?;
        let largest = v.iter().map(Vector3::norm).fold(0.0, f64::max);
        if largest == 0.0 {
            return Ok(vec![Vector3::zeros(); v.len()]);
        }
        let length = |segment: usize| {
            let [a, b] = self.layout.segment_nodes(segment);
            (positions[b] - positions[a]).norm()
        };
        let mean =
            (0..self.layout.segments()).map(length).sum::<f64>() / self.layout.segments() as f64;
        let step = 1e-5 * mean / largest;
        let moved = |step: f64| -> Result<_, ElectrostaticsError> {
            let moved: Vec<_> = positions.iter().zip(v).map(|(x, v)| x + step * v).collect();
            Ok(self.forces(&moved)?.forces)
        };
        let (ahead, behind) = (moved(step)?, moved(-step)?);
        Ok(ahead.iter().zip(&behind).map(|(a, b)| (b - a) / (2.0 * step)).collect())
    }

    fn check(&self, positions: &[Point3<f64>]) -> Result<(), ElectrostaticsError> {
        check_accuracy(self.accuracy)?;
        check_count("positions", positions.len(), self.layout.nodes())?;
        check_count("radii", self.radii.len(), self.layout.fibers())?;
        check_positions("node", positions)?;
        check_charges(self.charges, self.layout.segments())?;
        if let Some(&value) = self.radii.iter().find(|r| !(**r > 0.0 && r.is_finite())) {
            let (what, range) = ("a radius", "positive and finite");
            return Err(ElectrostaticsError::Setting { what, value, range });
        }
        for segment in 0..self.layout.segments() {
            let [a, b] = self.layout.segment_nodes(segment);
            if positions[a] == positions[b] {
                let (what, range) = ("the length of a segment", "positive");
                return Err(ElectrostaticsError::Setting { what, value: 0.0, range });
            }
        }
        Ok(())
    }
}

/// Error of rules over the tolerance of the forces, from measured errors.
const SHARE: f64 = 0.7;

/// Relative error of closed forms at worst: with a smaller tolerance the certificate says what was
/// reached.
const CLOSED: f64 = 2e-11;

struct Sum<'a, E> {
    tree: &'a Tree,
    lines: &'a Lines,
    rules: Rules<E>,
    /// Each segment as the points of the rule for those far away.
    cloud: Cloud,
    parallel: Parallel,
    /// Least distance of cells whose expansions are used.
    clearance: f64,
    accuracy: Accuracy,
}

impl<'a, E: Real> Sum<'a, E> {
    fn new(tree: &'a Tree, lines: &'a Lines, error: f64, accuracy: Accuracy) -> Self {
        let rules = Rules::<E>::new((SHARE * error).min(0.1));
        let points = rules.far();
        let each = |value: &(dyn Fn(usize, &Node<E>) -> f64 + Sync)| {
            let at = |k: usize| value(k / points.len(), &points[k % points.len()]);
            (0..lines.count() * points.len()).into_par_iter().map(at).collect()
        };
        let [x, y, z, a, b, c, .., charge] = &lines.bars;
        let place =
            |x: &Vec<f64>, half: &Vec<f64>| each(&|i, node| x[i] + node.place.double() * half[i]);
        let charge = each(&|i, node| charge[i] * node.weight.double());
        let cloud = Cloud { x: [place(x, a), place(y, b), place(z, c)], charge };
        let longest = (0..lines.count()).map(|i| lines.length(i)).fold(0.0, f64::max);
        let clearance = 0.5 * rules.clearance() * longest;
        let parallel = Parallel::new(error);
        Self { tree, lines, rules, cloud, parallel, clearance, accuracy }
    }

    fn run(&self) -> Result<(Vec<Loads>, Certificate), ElectrostaticsError> {
        let count = self.tree.order.len();
        let mut out = vec![[0.0; 7]; count];
        if count <= SAMPLES {
            let all: Vec<_> = (0..count).collect();
            return Ok((
                exact(self.lines, self.accuracy, &all),
                Certificate { order: None, samples: 0, error: 0.0 },
            ));
        }
        let samples: Vec<_> = (0..SAMPLES).map(|k| (2 * k + 1) * count / (2 * SAMPLES)).collect();
        let exact = exact(self.lines, self.accuracy, &samples);
        let error = |out: &[Loads]| {
            let [mut errors, mut squares] = [0.0; 2];
            for (&sample, exact) in samples.iter().zip(&exact) {
                for c in 1..7 {
                    errors += (out[sample][c] - exact[c]).powi(2);
                    squares += exact[c].powi(2);
                }
            }
            if errors > 0.0 { (errors / squares).sqrt() } else { 0.0 }
        };
        let multipoles =
            |order| Multipoles::<E>::new(self.tree, &self.cloud, self.rules.far().len(), order);
        let (order, multipoles) = match self.accuracy {
            Accuracy::Order(order) => (order, multipoles(order)),
            Accuracy::Tolerance(tolerance) => {
                let error = |multipoles: &Multipoles<E>, order| {
                    let mut out = vec![[0.0; 7]; count];
                    self.descend(multipoles, order, Some(&samples), &mut out);
                    error(&out)
                };
                let found = find_order(guess(self.accuracy) + 1, tolerance, multipoles, error)?;
                (found.0, found.1)
            }
        };
        self.descend(&multipoles, order, None, &mut out);
        let reached = error(&out);
        match self.accuracy {
            Accuracy::Tolerance(tolerance) if reached > tolerance.max(CLOSED) => {
                Err(ElectrostaticsError::OutOfReach { tolerance, reached, order })
            }
            _ => Ok((out, Certificate { order: Some(order), samples: SAMPLES, error: reached })),
        }
    }

    fn descend(
        &self,
        sources: &Multipoles<E>,
        order: usize,
        samples: Option<&[usize]>,
        out: &mut [Loads],
    ) {
        let (targets, opening, clearance) = (self.tree, OPENING, self.clearance);
        let (leaf, direct) = (self, 0);
        let degrees = Degrees::new(order, opening, thinning(self.accuracy));
        Descent { sources, targets, leaf, order, opening, degrees, clearance, direct, samples }
            .run(out);
    }

    /// Adds the loads of segment `i` in the potentials and gradients at its points.
    fn add_points(&self, i: usize, sums: &[[f64; 4]], out: &mut Loads) {
        let rule = self.rules.far();
        let charges = &self.cloud.charge[i * rule.len()..];
        for ((node, charge), [potential, gradient @ ..]) in rule.iter().zip(charges).zip(sums) {
            let x = node.place.double();
            out[0] += 0.5 * charge * potential;
            for c in 0..3 {
                let force = -charge * gradient[c];
                out[1 + c] += 0.5 * (1.0 - x) * force;
                out[4 + c] += 0.5 * (1.0 + x) * force;
            }
        }
    }
}

impl<E: Real> Leaf for Sum<'_, E> {
    type Out = Loads;

    fn receive(&self, cell: &Cell, far: &Far, near: &[Range<usize>], mut task: Task<Loads>) {
        let points = self.rules.far().len();
        let own = cell.bodies.start * points..cell.bodies.end * points;
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
        let mut columns = Columns::new(self.lines, cell.center.into(), [&alone, &mutual]);
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
