//! Derivatives of the forces by the positions.

use crate::force::TINY;
use crate::spring::SpringRun;
use crate::{NodeVectors, System};
use nalgebra::{SMatrix, SVector};
use pulp::{Arch, Simd, WithSimd};

/// Number of springs taken at a time.
const CHUNK: usize = 128;

/// The symmetric matrix `inertia * M + damping * D + K` of a system in one state, which is never
/// assembled: only the contribution of each spring is stored.
///
/// The block of a spring is `a I + w w^T` for its two nodes and the opposite between them, with
/// `w = sqrt(b) d` along the spring: `a = k (1 - l0/l)`, `b = k l0/l`. A spring in compression has
/// `a < 0`; the convex form takes zero instead.
pub(crate) struct Tangent<'a, const D: usize> {
    system: &'a System<D>,
    inertia: f64,
    isotropic: Vec<f64>,
    axial: NodeVectors<D>,
    /// Vectors `w` of the dampers, along the springs as they are in the system; empty without
    /// dampers.
    dampers: NodeVectors<D>,
    /// Bends, each with the three blocks of its second derivatives.
    bends: Vec<[SMatrix<f64, D, D>; 3]>,
}

impl<'a, const D: usize> Tangent<'a, D> {
    /// The matrix at the positions `x`.
    pub(crate) fn new(
        system: &'a System<D>,
        x: &NodeVectors<D>,
        inertia: f64,
        damping: f64,
        convex: bool,
    ) -> Self {
        let springs = &system.springs;
        let mut tangent = Self {
            system,
            inertia,
            isotropic: vec![0.0; springs.len()],
            axial: NodeVectors::zeros(springs.len()),
            dampers: NodeVectors::zeros(0),
            bends: system.bends.iter().map(|bend| bend.hessian(x, convex)).collect(),
        };
        for (s, &[i, j]) in springs.nodes.iter().enumerate() {
            let apart = x.get(j) - x.get(i);
            let length = (apart.norm_squared() + TINY).sqrt();
            let (k, ratio) = (springs.stiffness[s], springs.rest_length[s] / length);
            let mut isotropic = k * (1.0 - ratio);
            let mut along = k * ratio;
            if convex && isotropic < 0.0 {
                (isotropic, along) = (0.0, k);
            }
            tangent.isotropic[s] = isotropic;
            tangent.axial.set(s, &(apart * (along.sqrt() / length)));
        }
        if springs.damped && damping > 0.0 {
            tangent.dampers = NodeVectors::zeros(springs.len());
            for (s, &[i, j]) in springs.nodes.iter().enumerate() {
                let apart = system.positions.get(j) - system.positions.get(i);
                let length = (apart.norm_squared() + TINY).sqrt();
                let root = (damping * springs.damping[s]).sqrt();
                tangent.dampers.set(s, &(apart * (root / length)));
            }
        }
        tangent
    }

    /// The system that the matrix belongs to.
    pub(crate) fn system(&self) -> &'a System<D> {
        self.system
    }

    /// `y = A z`.
    pub(crate) fn apply(&self, z: &NodeVectors<D>, y: &mut NodeVectors<D>) {
        Arch::new().dispatch(Apply { tangent: self, z, y });
    }

    /// Computes `y = A z` as [`Self::apply`] does, for callers that already run in SIMD lanes.
    #[inline(always)]
    pub(crate) fn apply_inline(&self, z: &NodeVectors<D>, y: &mut NodeVectors<D>) {
        self.apply_springs(z, y);
        for s in 0..self.dampers.len() {
            let [i, j] = self.system.springs.nodes[s];
            let w = self.dampers.get(s);
            let change = w * w.dot(&(z.get(j) - z.get(i)));
            y.add(i, &-change);
            y.add(j, &change);
        }
        for (bend, blocks) in self.system.bends.iter().zip(&self.bends) {
            let [a, b, c] = bend.nodes;
            let edges = [z.get(b) - z.get(a), z.get(c) - z.get(b)];
            let first = blocks[0] * edges[0] + blocks[1] * edges[1];
            let second = blocks[1].transpose() * edges[0] + blocks[2] * edges[1];
            y.add(a, &-first);
            y.add(b, &(first - second));
            y.add(c, &second);
        }
    }

    #[inline(always)]
    fn apply_springs(&self, z: &NodeVectors<D>, y: &mut NodeVectors<D>) {
        for axis in 0..D {
            let masses = self.system.masses.iter();
            for ((to, from), mass) in y.0[axis].iter_mut().zip(&z.0[axis]).zip(masses) {
                *to = self.inertia * mass * from;
            }
        }
        for run in &self.system.springs.runs {
            for done in (0..run.count).step_by(CHUNK) {
                let count = CHUNK.min(run.count - done);
                let (first, i, j) = (run.first + done, run.i + done, run.j + done);
                apply_chunk(self, &SpringRun { first, count, i, j, ..*run }, z, y);
            }
        }
    }

    /// Visits every block of the matrix by its row and column; blocks on the diagonal come in
    /// several parts to be added.
    pub(crate) fn blocks(&self, mut visit: impl FnMut(usize, usize, SMatrix<f64, D, D>)) {
        for (node, mass) in self.system.masses.iter().enumerate() {
            visit(node, node, SMatrix::from_diagonal_element(self.inertia * mass));
        }
        let mut pair = |[i, j]: [usize; 2], block: SMatrix<f64, D, D>| {
            for (row, column, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                visit(row, column, block * sign);
            }
        };
        for (s, &nodes) in self.system.springs.nodes.iter().enumerate() {
            pair(nodes, self.spring_block(s));
        }
        for (bend, [first, _, second]) in self.system.bends.iter().zip(&self.bends) {
            let [a, b, c] = bend.nodes;
            pair([a, b], *first);
            pair([b, c], *second);
        }
        for (bend, blocks) in self.system.bends.iter().zip(&self.bends) {
            let [a, b, c] = bend.nodes;
            let mixed = blocks[1];
            // (z_b - z_a) . mixed (z_c - z_b), and the transpose.
            for (row, column, sign) in [(b, c, 1.0), (b, b, -1.0), (a, c, -1.0), (a, b, 1.0)] {
                visit(row, column, mixed * sign);
                visit(column, row, mixed.transpose() * sign);
            }
        }
    }

    fn spring_block(&self, s: usize) -> SMatrix<f64, D, D> {
        let w = self.axial.get(s);
        let elastic = SMatrix::from_diagonal_element(self.isotropic[s]) + w * w.transpose();
        if self.dampers.is_empty() {
            return elastic;
        }
        let w = self.dampers.get(s);
        elastic + w * w.transpose()
    }

    /// Inverses of the diagonal on the motions that the supports allow, for a preconditioner; where
    /// the diagonal is not positive, its absolute value is used.
    pub(crate) fn inverse_diagonal(&self) -> NodeVectors<D> {
        let mut diagonal = NodeVectors::zeros(self.system.nodes());
        self.blocks(|row, column, block| {
            if row == column {
                diagonal.add(row, &block.diagonal());
            }
        });
        // Nodes that are tied have one preconditioner, or it would pull them apart.
        let supports = &self.system.supports;
        for tie in &supports.ties {
            let column = &mut diagonal.0[tie.axis];
            let mean = tie.nodes.iter().map(|&n| column[n]).sum::<f64>() / tie.nodes.len() as f64;
            tie.nodes.iter().for_each(|&node| column[node] = mean);
        }
        let inverse = |x: f64| if x == 0.0 { 1.0 } else { 1.0 / x.abs() };
        diagonal.0.iter_mut().flatten().for_each(|x| *x = inverse(*x));
        diagonal
    }
}

struct Apply<'a, const D: usize> {
    tangent: &'a Tangent<'a, D>,
    z: &'a NodeVectors<D>,
    y: &'a mut NodeVectors<D>,
}

impl<const D: usize> WithSimd for Apply<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.tangent.apply_inline(self.z, self.y);
    }
}

#[inline(always)]
fn apply_chunk<const D: usize>(
    tangent: &Tangent<D>,
    &SpringRun { first, count, i, j, .. }: &SpringRun,
    z: &NodeVectors<D>,
    y: &mut NodeVectors<D>,
) {
    if count == 1 {
        let apart = z.get(j) - z.get(i);
        let w = tangent.axial.get(first);
        let change: SVector<f64, D> = apart * tangent.isotropic[first] + w * w.dot(&apart);
        y.add(i, &-change);
        y.add(j, &change);
        return;
    }
    let count = count.min(CHUNK);
    let [a, b] = [i, j].map(|node| std::array::from_fn::<_, D, _>(|k| &z.0[k][node..node + count]));
    let w: [_; D] = std::array::from_fn(|k| &tangent.axial.0[k][first..first + count]);
    let isotropic = &tangent.isotropic[first..first + count];
    let mut change = [[0.0; CHUNK]; D];
    for s in 0..count {
        let apart: [f64; D] = std::array::from_fn(|k| b[k][s] - a[k][s]);
        let along: f64 = (0..D).map(|k| w[k][s] * apart[k]).sum();
        for k in 0..D {
            change[k][s] = isotropic[s] * apart[k] + w[k][s] * along;
        }
    }
    for (change, y) in change.iter().zip(&mut y.0) {
        let to = &mut y[i..i + count];
        for s in 0..count {
            to[s] -= change[s];
        }
        let to = &mut y[j..j + count];
        for s in 0..count {
            to[s] += change[s];
        }
    }
}
