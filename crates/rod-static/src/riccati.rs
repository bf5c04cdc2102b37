//! Variations of one rod whose nodes bear springs, eliminated from the tip.

use crate::chain::TipHold;
use crate::segment::Blocks;
use nalgebra::{Matrix3, Matrix6, SymmetricEigen, Vector3, Vector6};

/// Part of a unit of stiffness below which a freedom of the root counts as loose.
const LOOSE_ROOT: f64 = 1e-10;
/// Part about the tangent of a rotation of the root from which it is a spin.
const SPIN: f64 = 1.0 - 1e-9;

/// What holds the root of a rod.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RootSupport {
    /// A clamp.
    Clamped,
    /// A ball joint, which takes no moment.
    Joint,
    /// Nothing.
    Free,
}

/// What there is of some kind on the nodes of a rod and in the middles of its segments.
#[derive(Debug, Clone)]
pub(crate) struct OnRod<T> {
    pub(crate) nodes: Vec<T>,
    pub(crate) middles: Vec<T>,
}

impl<T: Clone> OnRod<T> {
    /// The same everywhere on a rod of so many segments.
    pub(crate) fn filled(with: &T, segments: usize) -> Self {
        Self { nodes: vec![with.clone(); segments + 1], middles: vec![with.clone(); segments] }
    }

    /// What there is at a station: the root, the middles of the segments, and the tip.
    pub(crate) fn at(&self, station: usize) -> &T {
        match station {
            0 => &self.nodes[0],
            s if s > self.middles.len() => &self.nodes[self.middles.len()],
            s => &self.middles[s - 1],
        }
    }

    /// What there is at all stations.
    pub(crate) fn stations(&self) -> Vec<T> {
        (0..self.middles.len() + 2).map(|station| self.at(station).clone()).collect()
    }

    pub(crate) fn at_mut(&mut self, station: usize) -> &mut T {
        match station {
            0 => &mut self.nodes[0],
            s if s > self.middles.len() => &mut self.nodes[self.middles.len()],
            s => &mut self.middles[s - 1],
        }
    }
}

/// The second variation of a rod's energy, in rotations and displacements of its nodes.
pub(crate) struct SecondVariation<'a> {
    /// Hessians of the segments.
    pub(crate) blocks: &'a [Blocks],
    /// Derivatives of the ends of the segments by the variations of their frames, world frame.
    pub(crate) motions: &'a [[Matrix3<f64>; 2]],
    /// Those of the middles of the segments.
    pub(crate) halves: &'a [[Matrix3<f64>; 2]],
    /// Stiffnesses of nodes and middles against displacements, N/m, world frame.
    pub(crate) springs: OnRod<Matrix3<f64>>,
    /// Multiple of the blocks' shifts that is added.
    pub(crate) shift: f64,
    /// Units of stiffness against rotations (N m) and displacements (N/m).
    pub(crate) units: [f64; 2],
    pub(crate) tip: TipHold,
    pub(crate) root: RootSupport,
}

/// The second variation, eliminated: what lies beyond a node is a quadratic function of the
/// rotation and the displacement of that node (Riccati's recursion), at a cost in proportion to the
/// number of segments.
pub(crate) struct RiccatiFactor {
    /// Inverse pivots of the nodes behind the root.
    inverse: Vec<Matrix3<f64>>,
    /// How the moments on these nodes depend on rotation and displacement of the node before.
    coupled: Vec<[Matrix3<f64>; 2]>,
    motions: Vec<[Matrix3<f64>; 2]>,
    halves: Vec<[Matrix3<f64>; 2]>,
    /// Inverse pivot of rotation and displacement of the root; zero where they are held.
    root: Matrix6<f64>,
    /// Number of variations that lower the energy, or leave it as it is at the root.
    pub(crate) negative: usize,
    /// The first eliminated node behind the root at which there are such, and one of them.
    falling: Option<(usize, Vector3<f64>)>,
    /// Whether the root has a freedom that nothing holds, other than the spin of the rod.
    pub(crate) loose: bool,
}

/// Rotations (rad, in the nodes' own axes) of the nodes of a rod, and displacements (m, world
/// frame).
#[derive(Debug, Clone)]
pub(crate) struct RodVariation {
    pub(crate) turns: Vec<Vector3<f64>>,
    pub(crate) ways: OnRod<Vector3<f64>>,
}

impl RiccatiFactor {
    /// Eliminates the nodes from the tip to the root. `None` if a pivot is singular.
    pub(crate) fn of(system: &SecondVariation<'_>) -> Option<Self> {
        let count = system.blocks.len();
        let mut factor = Self {
            inverse: vec![Matrix3::zeros(); count],
            coupled: vec![[Matrix3::zeros(); 2]; count],
            motions: system.motions.to_vec(),
            halves: system.halves.to_vec(),
            root: Matrix6::zeros(),
            negative: 0,
            falling: None,
            loose: false,
        };
        // The function of rotation and displacement: its three blocks.
        let (mut turn, mut cross, mut place) =
            (Matrix3::<f64>::zeros(), Matrix3::<f64>::zeros(), system.springs.nodes[count]);
        for i in (0..count).rev() {
            let (block, spring) = (&system.blocks[i], &system.springs.middles[i]);
            let [before, behind] = &system.motions[i];
            let [half_before, half_behind] = &system.halves[i];
            let own = Matrix3::from_diagonal_element(system.shift * block.shift);
            let (carried, sprung) = (cross * behind, half_behind.tr_mul(spring));
            let pivot = block.behind
                + own
                + turn
                + carried
                + carried.transpose()
                + behind.tr_mul(&(place * behind))
                + sprung * half_behind;
            let by_turn = block.mixed
                + cross * before
                + behind.tr_mul(&(place * before))
                + sprung * half_before;
            let by_place = cross + behind.tr_mul(&place) + sprung;
            let tip = if i + 1 == count { system.tip } else { TipHold::Free };
            let inverse = factor.pivot(i, &pivot, tip)?;
            let (first, second) = (inverse * by_turn, inverse * by_place);
            let sprung = half_before.tr_mul(spring);
            turn = block.before + own + before.tr_mul(&(place * before)) + sprung * half_before
                - by_turn.tr_mul(&first);
            cross = before.tr_mul(&place) + sprung - by_turn.tr_mul(&second);
            place += spring + system.springs.nodes[i] - by_place.tr_mul(&second);
            factor.inverse[i] = inverse;
            factor.coupled[i] = [by_turn, by_place];
        }
        factor.eliminate_root(system, &turn, &cross, &place);
        Some(factor)
    }

    fn pivot(&mut self, i: usize, pivot: &Matrix3<f64>, tip: TipHold) -> Option<Matrix3<f64>> {
        if tip == TipHold::Held {
            return Some(Matrix3::zeros());
        }
        let eigen = (0.5 * (pivot + pivot.transpose())).symmetric_eigen();
        let (least, value) = eigen.eigenvalues.argmin();
        if value <= 0.0 {
            self.negative += eigen.eigenvalues.iter().filter(|e| **e <= 0.0).count();
            self.falling.get_or_insert((i, eigen.eigenvectors.column(least).into_owned()));
        }
        pivot.try_inverse()
    }

    fn eliminate_root(
        &mut self,
        system: &SecondVariation<'_>,
        turn: &Matrix3<f64>,
        cross: &Matrix3<f64>,
        place: &Matrix3<f64>,
    ) {
        let free = match system.root {
            RootSupport::Clamped => return,
            RootSupport::Joint => 3,
            RootSupport::Free => 6,
        };
        let scale = Vector6::from_fn(|i, _| system.units[i / 3].sqrt().recip());
        let mut whole = Matrix6::zeros();
        whole.fixed_view_mut::<3, 3>(0, 0).copy_from(turn);
        whole.fixed_view_mut::<3, 3>(0, 3).copy_from(cross);
        whole.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross.transpose());
        whole.fixed_view_mut::<3, 3>(3, 3).copy_from(place);
        let mut scaled = Matrix6::from_fn(|i, j| scale[i] * whole[(i, j)] * scale[j]);
        scaled = 0.5 * (scaled + scaled.transpose());
        for i in 0..6 {
            scaled[(i, i)] += system.shift;
            if i >= free {
                scaled.row_mut(i).fill(0.0);
                scaled.column_mut(i).fill(0.0);
                scaled[(i, i)] = 1.0;
            }
        }
        let SymmetricEigen { eigenvectors, eigenvalues } = scaled.symmetric_eigen();
        for (value, way) in eigenvalues.iter().zip(eigenvectors.column_iter()) {
            // A round rod may spin about itself, which moves nothing.
            let spins = way[2].abs() > SPIN && value.abs() <= LOOSE_ROOT;
            if *value <= LOOSE_ROOT && !spins {
                self.negative += 1;
                self.loose |= value.abs() <= LOOSE_ROOT;
            }
        }
        // Loose freedoms stay where they are.
        let inverse = eigenvalues.map(|e| if e.abs() > LOOSE_ROOT { e.recip() } else { 0.0 });
        let inverse = eigenvectors * Matrix6::from_diagonal(&inverse) * eigenvectors.transpose();
        let held = |i: usize| if i < free { scale[i] } else { 0.0 };
        self.root = Matrix6::from_fn(|i, j| held(i) * inverse[(i, j)] * held(j));
    }

    /// The variation for given moments (N m, in the nodes' own axes) on all nodes, and forces (N,
    /// world frame).
    pub(crate) fn solve(
        &self,
        moments: &[Vector3<f64>],
        forces: &OnRod<Vector3<f64>>,
    ) -> RodVariation {
        let count = self.inverse.len();
        let mut parts = vec![Vector3::zeros(); count];
        let (mut moment, mut force) = (moments[count], forces.nodes[count]);
        for i in (0..count).rev() {
            let ([before, behind], [half_before, half_behind]) =
                (&self.motions[i], &self.halves[i]);
            let push = forces.middles[i];
            let part =
                self.inverse[i] * (moment + behind.tr_mul(&force) + half_behind.tr_mul(&push));
            let [by_turn, by_place] = &self.coupled[i];
            moment = moments[i] + before.tr_mul(&force) + half_before.tr_mul(&push)
                - by_turn.tr_mul(&part);
            force += push + forces.nodes[i] - by_place.tr_mul(&part);
            parts[i] = part;
        }
        let mut load = Vector6::zeros();
        load.fixed_rows_mut::<3>(0).copy_from(&moment);
        load.fixed_rows_mut::<3>(3).copy_from(&force);
        let root = self.root * load;
        let start = (root.fixed_rows::<3>(0).into_owned(), root.fixed_rows::<3>(3).into_owned());
        self.propagate(&parts, start, 0)
    }

    /// A variation along which the energy falls, where nodes behind the root have one.
    pub(crate) fn falling(&self) -> Option<RodVariation> {
        let (node, direction) = self.falling?;
        let mut parts = vec![Vector3::zeros(); self.inverse.len()];
        parts[node] = direction;
        Some(self.propagate(&parts, (Vector3::zeros(), Vector3::zeros()), node))
    }

    fn propagate(
        &self,
        parts: &[Vector3<f64>],
        root: (Vector3<f64>, Vector3<f64>),
        from: usize,
    ) -> RodVariation {
        let mut turns = vec![root.0; parts.len() + 1];
        let mut ways = OnRod::filled(&root.1, parts.len());
        for i in from..parts.len() {
            let [by_turn, by_place] = &self.coupled[i];
            let pushed = by_turn * turns[i] + by_place * ways.nodes[i];
            turns[i + 1] = parts[i] - self.inverse[i] * pushed;
            let moved =
                |by: &[Matrix3<f64>; 2]| ways.nodes[i] + by[0] * turns[i] + by[1] * turns[i + 1];
            let (end, middle) = (moved(&self.motions[i]), moved(&self.halves[i]));
            ways.nodes[i + 1] = end;
            ways.middles[i] = middle;
        }
        RodVariation { turns, ways }
    }
}
