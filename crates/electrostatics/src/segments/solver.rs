//! Energy and nodal forces of charged fibres.

use super::near::{Lines, Loads, points};
use crate::error::{check_charges, check_count, check_positions};
use crate::multipole::engine::{Descent, Far, Leaf, Multipoles};
use crate::multipole::near::{Cloud, add_pairs};
use crate::multipole::solver::{OPENING, check_accuracy, find_order, guess};
use crate::multipole::tree::{Cell, Tree};
use crate::quadrature::gauss_legendre;
use crate::{Accuracy, COULOMB_CONSTANT, Certificate, ElectrostaticsError};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Layout;
use std::ops::Range;

/// Segments in a leaf, from measured rates: a pair of segments takes as long as some 100 pairs of
/// points.
const CAPACITY: usize = 8;

/// Segments whose forces are compared with the direct sum.
const SAMPLES: usize = 48;

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
    /// Points on each segment at which near pairs are integrated, 1 to 32. On the thesis's tress,
    /// whose segments of 3 mm come within 0.06 mm of each other, 4 leave an error of 1.3e-3 in the
    /// forces and 8 leave 1.2e-4.
    pub points: usize,
    /// How exact the forces of distant segments must be.
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
    /// How exact the far field is.
    pub certificate: Certificate,
}

impl ChargedFibers<'_> {
    /// Energy and forces with the nodes at `positions` (world, m).
    ///
    /// The energy is one number for each choice of near pairs: every near pair is the mean of the
    /// two one-sided rules, every far pair the same rule on both sides. So forces are its exact
    /// gradient, and there is no net force or moment, to rounding near and to the tolerance far.
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
        let per_body = guess(self.accuracy) / 3 + 2;
        let rule = gauss_legendre(per_body);
        let mut cloud = Cloud::default();
        let mut lines = Lines::new(self.points);
        for &i in &tree.order {
            let (segment, charge) = (i as usize, self.charges[i as usize] / unit);
            for (point, share) in points(&rule, ends(segment)) {
                cloud.push(point.into(), charge * share);
            }
            let fiber = self.layout.segment_fibers()[segment];
            #[expect(clippy::cast_possible_truncation, reason = "no more than 2^32 segments")]
            lines.push(ends(segment), charge, self.radii[fiber], [fiber as u32, i]);
        }
        let sum = Sum { tree: &tree, cloud, rule, lines };
        let (loads, certificate) = sum.run(self.accuracy)?;
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
        if !(1..=32).contains(&self.points) {
            let (what, range) = ("the number of points", "from 1 to 32");
            return Err(ElectrostaticsError::Setting { what, value: self.points as f64, range });
        }
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

struct Sum<'a> {
    tree: &'a Tree,
    cloud: Cloud,
    /// Points on each segment for expansions.
    rule: Vec<[f64; 2]>,
    lines: Lines,
}

impl Sum<'_> {
    fn run(&self, accuracy: Accuracy) -> Result<(Vec<Loads>, Certificate), ElectrostaticsError> {
        let count = self.tree.order.len();
        let mut out = vec![[0.0; 7]; count];
        if count <= 4 * CAPACITY {
            for (i, out) in out.iter_mut().enumerate() {
                self.lines.add(i, std::slice::from_ref(&(0..count)), out);
            }
            return Ok((out, Certificate { order: None, samples: 0, error: 0.0 }));
        }
        let samples: Vec<_> = (0..SAMPLES).map(|k| (2 * k + 1) * count / (2 * SAMPLES)).collect();
        let mut exact = vec![[0.0; 7]; count];
        let direct = Exact { sum: self, samples: &samples };
        let coarse = Multipoles::new(self.tree, &self.cloud, self.rule.len(), 1);
        self.descend(&direct, &coarse, 1, Some(&samples), &mut exact);
        let error = |out: &[Loads]| {
            let [mut errors, mut squares] = [0.0; 2];
            for &sample in &samples {
                for c in 1..7 {
                    errors += (out[sample][c] - exact[sample][c]).powi(2);
                    squares += exact[sample][c].powi(2);
                }
            }
            if errors > 0.0 { (errors / squares).sqrt() } else { 0.0 }
        };
        let multipoles = |order| Multipoles::new(self.tree, &self.cloud, self.rule.len(), order);
        let (order, multipoles) = match accuracy {
            Accuracy::Order(order) => (order, multipoles(order)),
            Accuracy::Tolerance(tolerance) => {
                let error = |multipoles: &Multipoles, order| {
                    let mut out = vec![[0.0; 7]; count];
                    self.descend(self, multipoles, order, Some(&samples), &mut out);
                    error(&out)
                };
                let found = find_order(guess(accuracy), tolerance, multipoles, error)?;
                (found.0, found.1)
            }
        };
        self.descend(self, &multipoles, order, None, &mut out);
        let error = error(&out);
        Ok((out, Certificate { order: Some(order), samples: SAMPLES, error }))
    }

    fn descend<L: Leaf<Out = Loads>>(
        &self,
        leaf: &L,
        sources: &Multipoles,
        order: usize,
        samples: Option<&[usize]>,
        out: &mut [Loads],
    ) {
        let (targets, opening) = (self.tree, OPENING);
        Descent { sources, targets, leaf, order, opening, direct: 0, samples }.run(out);
    }
}

impl Sum<'_> {
    /// Adds the loads of segment `i` in the potentials and gradients at its points.
    fn add_far(&self, i: usize, potentials: &[[f64; 4]], out: &mut Loads) {
        let charges = &self.cloud.charge[i * self.rule.len()..];
        for (([x, _], charge), [potential, gradient @ ..]) in
            self.rule.iter().zip(charges).zip(potentials)
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

    fn receive(&self, cell: &Cell, far: &Far, near: &[Range<usize>], out: &mut [Loads]) {
        let points = self.rule.len();
        let range = cell.bodies.start * points..cell.bodies.end * points;
        let mut potentials = vec![[0.0; 4]; range.len()];
        far.add(cell, &self.cloud.x, range, &mut potentials);
        for ((i, out), potentials) in
            cell.bodies.clone().zip(out).zip(potentials.chunks_exact(points))
        {
            self.add_far(i, potentials, out);
            self.lines.add(i, near, out);
        }
    }
}

/// The same near pairs, but without expansions, for some segments.
struct Exact<'a> {
    sum: &'a Sum<'a>,
    samples: &'a [usize],
}

impl Leaf for Exact<'_> {
    type Out = Loads;

    fn receive(&self, cell: &Cell, _: &Far, near: &[Range<usize>], out: &mut [Loads]) {
        let points = self.sum.rule.len();
        let mut near: Vec<_> = near.to_vec();
        near.sort_unstable_by_key(|range| range.start);
        let starts = std::iter::once(0).chain(near.iter().map(|range| range.end));
        let ends = near.iter().map(|range| range.start).chain([self.sum.tree.order.len()]);
        let far: Vec<_> = starts.zip(ends).map(|(a, b)| a * points..b * points).collect();
        for (i, out) in cell.bodies.clone().zip(out) {
            if self.samples.binary_search(&i).is_ok() {
                let mut potentials = vec![[0.0; 4]; points];
                let (cloud, range) = (&self.sum.cloud, i * points..(i + 1) * points);
                add_pairs(cloud, &far, &cloud.x, range, &mut potentials);
                self.sum.add_far(i, &potentials, out);
                self.sum.lines.add(i, &near, out);
            }
        }
    }
}
