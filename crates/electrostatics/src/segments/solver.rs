//! Energy and nodal forces of charged fibres.

use super::near::{Lines, Loads, SOFTENING};
use super::skew::nearly_parallel;
use crate::error::{check_charges, check_count, check_positions};
use crate::method::direct_sums;
use crate::multipole::engine::{Descent, Far, Leaf, Multipoles, Task};
use crate::multipole::near::{Cloud, add_pairs};
use crate::multipole::solver::{check_accuracy, find_order, guess, thinning};
use crate::multipole::tree::{Cell, Tree};
use crate::quadrature::gauss_legendre;
use crate::{Accuracy, COULOMB_CONSTANT, Certificate, ElectrostaticsError};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Layout;
use std::ops::Range;

/// Segments in a leaf, from measured rates.
const CAPACITY: usize = 40;

/// Segments whose forces are compared with the direct sum.
const SAMPLES: usize = 48;

/// Distance of two segments over their length up to which the closed form is used.
const REACH: f64 = 1.4;

/// Largest ratio of radii to distance at which expansions are used: all of their pairs are beyond
/// [`REACH`].
const OPENING: f64 = 1.0 / REACH;

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
    /// The energy is one number for each choice of close pairs: these are integrated in closed form, all
    /// others by the same points on both segments. So forces are its exact gradient, and there is no
    /// net force or moment, to rounding near and to the tolerance far.
    /// Cost: see the README.
    ///
    /// # Errors
    /// Arrays that do not fit, positions or charges that are not finite, radii that are not positive,
    /// segments without length, and an accuracy out of range or reach.
    pub fn forces(&self, positions: &[Point3<f64>]) -> Result<Electrostatics, ElectrostaticsError> {
        self.check(positions)?;
        let nodes = |segment: usize| self.layout.segment_nodes(segment);
        let ends = |segment: usize| nodes(segment).map(|node| positions[node]);
        let count = self.layout.segments();
        let unit = self.charges.iter().fold(0.0, |unit: f64, q| unit.max(q.abs()));
        let unit = if unit > 0.0 { unit.log2().floor().exp2() } else { 1.0 };
        let tree = Tree::new(count, CAPACITY, ends);
        let mut points = points(self.accuracy);
        let (loads, certificate) = loop {
            match self.sum(&tree, unit, points, ends).run(self.accuracy) {
                Err(ElectrostaticsError::OutOfReach { .. }) if points < MOST_POINTS => points += 1,
                result => break result?,
            }
        };
        let factor = COULOMB_CONSTANT * unit * unit;
        let mut result = Electrostatics {
            energy: factor * loads.iter().map(|load| load[0]).sum::<f64>(),
            forces: vec![Vector3::zeros(); positions.len()],
            certificate,
        };
        let mut ordered = vec![0; count];
        tree.order.iter().enumerate().for_each(|(k, &i)| ordered[i as usize] = k);
        for (segment, k) in ordered.into_iter().enumerate() {
            let [_, ax, ay, az, bx, by, bz] = loads[k];
            let [a, b] = nodes(segment);
            result.forces[a] += factor * Vector3::new(ax, ay, az);
            result.forces[b] += factor * Vector3::new(bx, by, bz);
        }
        Ok(result)
    }

    /// The segments in the order of `tree`, and as `points` points each.
    fn sum<'a>(
        &self,
        tree: &'a Tree,
        unit: f64,
        points: usize,
        ends: impl Fn(usize) -> [Point3<f64>; 2],
    ) -> Sum<'a> {
        let tolerance = match self.accuracy {
            Accuracy::Tolerance(tolerance) => tolerance,
            Accuracy::Order(_) => 1e-6,
        };
        let rule = gauss_legendre(points);
        let mut cloud = Cloud::default();
        let mut lines = Lines::new(&rule, nearly_parallel(tolerance));
        for &i in &tree.order {
            let (segment, charge) = (i as usize, self.charges[i as usize] / unit);
            let [start, end] = ends(segment).map(|x| x.coords);
            for [x, w] in &rule {
                let point = (start * (1.0 - x) + end * (1.0 + x)) * 0.5;
                cloud.push(point.into(), charge * 0.5 * w);
            }
            let fiber = self.layout.segment_fibers()[segment];
            #[expect(clippy::cast_possible_truncation, reason = "no more than 2^32 segments")]
            lines.push(ends(segment), charge, self.radii[fiber], [fiber as u32, i]);
        }
        Sum { tree, cloud, rule, lines, accuracy: self.accuracy }
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

/// Most points that a segment is taken as.
const MOST_POINTS: usize = 14;

/// Points that a segment is first taken as beyond [`REACH`], from measured errors: each reduces them by the
/// square of `2 REACH`.
fn points(accuracy: Accuracy) -> usize {
    1 + (2 * guess(accuracy) / 5).max(1)
}

struct Sum<'a> {
    tree: &'a Tree,
    cloud: Cloud,
    /// Points on each segment.
    rule: Vec<[f64; 2]>,
    lines: Lines,
    accuracy: Accuracy,
}

impl Sum<'_> {
    fn run(&self, accuracy: Accuracy) -> Result<(Vec<Loads>, Certificate), ElectrostaticsError> {
        let count = self.tree.order.len();
        let mut out = vec![[0.0; 7]; count];
        if count <= SAMPLES {
            let all: Vec<_> = (0..count).collect();
            let exact = self.exact(&all, f64::INFINITY);
            return Ok((exact, Certificate { order: None, samples: 0, error: 0.0 }));
        }
        let samples: Vec<_> = (0..SAMPLES).map(|k| (2 * k + 1) * count / (2 * SAMPLES)).collect();
        let exact = self.exact(&samples, 3.0 * REACH);
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
        let multipoles = |order| Multipoles::new(self.tree, &self.cloud, self.rule.len(), order);
        let (order, multipoles) = match accuracy {
            Accuracy::Order(order) => (order, multipoles(order)),
            Accuracy::Tolerance(tolerance) => {
                let error = |multipoles: &Multipoles<f64>, order| {
                    let mut out = vec![[0.0; 7]; count];
                    self.descend(multipoles, order, Some(&samples), &mut out);
                    error(&out)
                };
                let found = find_order(guess(accuracy), tolerance, multipoles, error)?;
                (found.0, found.1)
            }
        };
        self.descend(&multipoles, order, None, &mut out);
        let error = error(&out);
        Ok((out, Certificate { order: Some(order), samples: SAMPLES, error }))
    }

    fn descend(
        &self,
        sources: &Multipoles<f64>,
        order: usize,
        samples: Option<&[usize]>,
        out: &mut [Loads],
    ) {
        let (targets, opening) = (self.tree, OPENING);
        let thinning = thinning(self.accuracy);
        Descent { sources, targets, leaf: self, order, opening, thinning, direct: 0, samples }
            .run(out);
    }

    /// The loads of `samples` without expansions, with the closed form up to the distance `reach`.
    fn exact(&self, samples: &[usize], reach: f64) -> Vec<Loads> {
        let points = self.rule.len();
        let own = || samples.iter().flat_map(|i| i * points..(i + 1) * points);
        let places = [0, 1, 2].map(|d| own().map(|k| self.cloud.x[d][k]).collect());
        let sums = direct_sums(&self.cloud, SOFTENING, &places);
        let mut out = vec![[0.0; 7]; samples.len()];
        for ((&i, out), sums) in samples.iter().zip(&mut out).zip(sums.chunks_exact(points)) {
            self.add_points(i, sums, out);
            let task = Task { bodies: i..i + 1, complete: false, out: std::slice::from_mut(out) };
            let all = 0..self.tree.order.len();
            self.lines.add_close(i..i + 1, std::slice::from_ref(&all), reach, task);
        }
        out
    }

    /// Adds the loads of segment `i` in the potentials and gradients at its points.
    fn add_points(&self, i: usize, sums: &[[f64; 4]], out: &mut Loads) {
        let charges = &self.cloud.charge[i * self.rule.len()..];
        for (([x, _], charge), [potential, gradient @ ..]) in
            self.rule.iter().zip(charges).zip(sums)
        {
            out[0] += 0.5 * charge * potential;
            for c in 0..3 {
                let force = -charge * gradient[c];
                out[1 + c] += 0.5 * (1.0 - x) * force;
                out[4 + c] += 0.5 * (1.0 + x) * force;
            }
        }
    }
}

impl Leaf for Sum<'_> {
    type Out = Loads;

    fn receive(&self, cell: &Cell, far: &Far, near: &[Range<usize>], mut task: Task<Loads>) {
        let points = self.rule.len();
        let scaled = |range: &Range<usize>| range.start * points..range.end * points;
        let own = scaled(&cell.bodies);
        let sources: Vec<_> = near.iter().map(scaled).collect();
        let mut sums = vec![[0.0; 4]; own.len()];
        far.add(cell, &self.cloud.x, own.clone(), &mut sums);
        add_pairs(&self.cloud, &sources, SOFTENING, &self.cloud.x, own, &mut sums);
        for ((i, out), sums) in
            cell.bodies.clone().zip(task.of(cell)).zip(sums.chunks_exact(points))
        {
            self.add_points(i, sums, out);
        }
        self.lines.add_close(cell.bodies.clone(), near, REACH, task);
    }
}
