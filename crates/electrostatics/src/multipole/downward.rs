//! The way down the tree of the targets.
//!
//! Each target cell, from the root down, sorts the source cells that its parent left: those far
//! enough away become part of its local expansion, the others are split or left to its children.
//! Locals live only on the path from the root, and a cell's sums are made in the order of its list,
//! whatever thread makes them.

use super::points;
use super::tree::{Cell, Octree};
use super::upward::{Multipoles, parts, shift};
use crate::harmonics::{Coefficient, Gradient, HarmonicTables, TranslationKind, Translator, count};
use rayon::prelude::*;
use std::ops::Range;

/// Number of bodies below which a subtree is one task, where it matters not to them which are in
/// it: there are then tasks enough for all threads to end at the same time.
pub(crate) const BODIES_PER_TASK: usize = 8192;

/// Action on the bodies of a leaf of the targets.
pub(crate) trait Leaf: Sync {
    /// Result for each body.
    type Out: Send;

    /// Adds the action of the local expansion `far` and of the bodies `near` of the sources on the
    /// bodies of `cell`.
    fn receive(&self, cell: &Cell, far: &Far, near: &[Range<usize>], task: Task<Self::Out>);
}

/// Bodies that one thread handles: those of a subtree of the targets.
pub(crate) struct Task<'a, Out> {
    /// Range of the bodies, in the order of the tree.
    pub(crate) bodies: Range<usize>,
    /// Indices of the wanted ones of all bodies, ascending; `None` if all are.
    pub(crate) samples: Option<&'a [usize]>,
    /// Results for the bodies of the range.
    pub(crate) out: &'a mut [Out],
}

impl<Out> Task<'_, Out> {
    /// Whether body `j` is looked at in this task as well, so that pairs with it are found twice.
    pub(crate) fn both(&self, j: usize) -> bool {
        self.samples.is_none() && self.bodies.contains(&j)
    }

    /// Indices of the bodies of `cell` that are wanted.
    pub(crate) fn wanted(&self, cell: &Cell) -> Vec<usize> {
        match self.samples {
            Some(samples) => {
                let place = |body| samples.partition_point(|sample| *sample < body);
                samples[place(cell.bodies.start)..place(cell.bodies.end)].to_vec()
            }
            None => cell.bodies.clone().collect(),
        }
    }

    /// Result for body `i`.
    pub(crate) fn of_body(&mut self, i: usize) -> &mut Out {
        &mut self.out[i - self.bodies.start]
    }

    /// Results for the bodies of `cell`.
    pub(crate) fn of(&mut self, cell: &Cell) -> &mut [Out] {
        let first = self.bodies.start;
        &mut self.out[cell.bodies.start - first..cell.bodies.end - first]
    }
}

/// Local expansion of a leaf, with its derivatives.
pub(crate) struct Far {
    order: usize,
    gradient: Gradient,
}

impl Far {
    /// Adds to `out` the potential (1/m) and its gradient (1/m^2), for the charges of the sources,
    /// at the points `range` of `places` in `cell`.
    pub(crate) fn add(
        &self,
        cell: &Cell,
        places: &[Vec<f64>; 3],
        range: Range<usize>,
        out: &mut [[f64; 4]],
    ) {
        let mut work = points::work(self.order);
        points::add_local(self.order, cell, &self.gradient, places, range, &mut work, out);
    }
}

/// Degrees that are enough for the expansions of two cells.
pub(crate) struct Degrees {
    /// Ratios of radius to distance up to which each degree is enough, ascending; the last degree
    /// serves all.
    falls: Vec<f64>,
}

impl Degrees {
    /// Degrees at which expansions err as those of degree `order` do for equal cells at the least
    /// distance for `opening`, if their number of terms is the share `thinning` of the logarithm
    /// that this takes; zero leaves all of them the full degree.
    pub(crate) fn new(order: usize, opening: f64, thinning: f64) -> Self {
        let slowest = (opening / (2.0 - opening)).ln();
        let fall = |degree: usize| {
            if degree < order.min(2) {
                return 0.0;
            }
            let share = (degree + 1) as f64 / (order + 1) as f64;
            (slowest * share.powf(-1.0 / thinning)).exp()
        };
        Self { falls: (0..order).map(fall).collect() }
    }

    /// Degree for cells with these radii (m) at this distance (m). A term falls from degree to
    /// degree by at least the larger radius over the distance of its center from the other sphere.
    fn of(&self, radii: [f64; 2], distance: f64) -> usize {
        let falls = radii[0].max(radii[1]) / (distance - radii[0].min(radii[1]));
        self.falls.partition_point(|fall| *fall < falls)
    }
}

/// Way down a tree of targets, past the multipoles of the sources.
pub(crate) struct Descent<'a, L, E> {
    /// Multipoles of the sources.
    pub(crate) sources: &'a Multipoles<'a, E>,
    /// Tree of the targets.
    pub(crate) targets: &'a Octree,
    /// Action on the bodies of a leaf.
    pub(crate) leaf: &'a L,
    /// Degree of the local expansions, at most that of the multipoles.
    pub(crate) order: usize,
    /// Largest ratio of the sum of the radii of two cells to their distance at which expansions are
    /// used.
    pub(crate) opening: f64,
    /// Degrees of distant cells.
    pub(crate) degrees: Degrees,
    /// Least gap (m) between cells whose expansions are used.
    pub(crate) clearance: f64,
    /// Number of pairs of bodies up to which one by one is cheaper than by their cells.
    pub(crate) direct: usize,
    /// Number of bodies of the targets below which a subtree is one task.
    pub(crate) grain: usize,
    /// Indices of the wanted bodies of the targets, ascending; `None` if all are.
    pub(crate) samples: Option<&'a [usize]>,
}

impl<L: Leaf, E: Coefficient> Descent<'_, L, E> {
    /// Adds the results to `out`, one item for each body of the targets in the order of their tree.
    pub(crate) fn run(&self, out: &mut [L::Out]) {
        if self.targets.cells.is_empty() || self.sources.tree.cells.is_empty() {
            return;
        }
        // Cells above the tasks are visited level by level, the children of each by whichever
        // thread is free.
        let local = vec![E::from_f64(0.0); count(self.order)];
        let mut visits = vec![Visit { cell: 0, local, pending: vec![0] }];
        let mut tasks = Vec::new();
        while !visits.is_empty() {
            let (now, split): (Vec<_>, Vec<_>) = visits.into_iter().partition(|visit| {
                let cell = self.cell(visit);
                cell.is_leaf() || cell.bodies.len() <= self.grain
            });
            tasks.extend(now);
            let parts = |movers: &mut _, mut visit| {
                self.open(&mut visit, movers);
                self.children(&visit, movers)
            };
            visits =
                split.into_par_iter().map_init(|| self.movers(), parts).flatten_iter().collect();
        }
        tasks.sort_by_key(|visit| self.cell(visit).bodies.start);
        let parts = parts(out, tasks.iter().map(|visit| self.cell(visit).bodies.clone()));
        let task = |(visit, (bodies, out))| (visit, Task { bodies, samples: self.samples, out });
        let mut tasks: Vec<_> = tasks.into_iter().zip(parts).map(task).collect();
        // Threads take one after another, the largest first, so that they end at about the same
        // time; those of about the same size, as neighbors have much in common.
        tasks.sort_by_key(|(_, task)| std::cmp::Reverse(task.bodies.len().ilog2()));
        tasks.into_iter().par_bridge().for_each_init(
            || self.movers(),
            |movers, (visit, task)| self.visit(visit, movers, task),
        );
    }

    /// Target cell of a visit.
    fn cell(&self, visit: &Visit<E>) -> &Cell {
        &self.targets.cells[visit.cell]
    }

    /// Scratch space for one thread.
    fn movers(&self) -> Movers<E> {
        let single = || Single {
            translator: Translator::new(self.order),
            sums: vec![0.0; count(self.order)],
        };
        let single = self.sources.rounded.is_some().then(single);
        Movers { translator: Translator::new(self.order), single, lists: Lists::default() }
    }

    /// Adds the expansions `far`, of falling degree, to the local expansion of `cell` (M2L).
    fn add_far(&self, far: &[Distant], cell: &Cell, movers: &mut Movers<E>, local: &mut [E]) {
        let sources = self.sources;
        let cells = &sources.tree.cells;
        let highest = sources.rounded.as_ref().map_or(usize::MAX, |rounded| rounded.low - 1);
        let exact = |far: &Distant| {
            let source = far.cell as usize;
            let degree = far.degree.min(highest);
            shift(&cells[source], cell, sources.moments(source), degree)
        };
        let shifts: Vec<_> = far.iter().map(exact).collect();
        movers.translator.sum(TranslationKind::Far(0), &shifts, local);
        // Pairs of degrees of which one is higher are moved in single precision.
        if let (Some(rounded), Some(single)) = (&sources.rounded, &mut movers.single) {
            let higher = |far: &Distant| {
                let source = far.cell as usize;
                let size = count(sources.order);
                let moments = &rounded.moments[size * source..size * (source + 1)];
                shift(&cells[source], cell, moments, far.degree)
            };
            let higher: Vec<_> =
                far.iter().take_while(|far| far.degree > highest).map(higher).collect();
            single.sums.fill(0.0);
            single.translator.sum(TranslationKind::Far(rounded.low), &higher, &mut single.sums);
            for (local, sum) in local.iter_mut().zip(&single.sums) {
                *local = E::from_f64(local.to_f64() + f64::from(*sum));
            }
        }
    }

    /// Whether any body of `cell` is wanted.
    fn wanted(&self, cell: &Cell) -> bool {
        let Some(samples) = self.samples else { return true };
        let next = samples.partition_point(|sample| *sample < cell.bodies.start);
        samples.get(next).is_some_and(|sample| *sample < cell.bodies.end)
    }

    /// Visits the cell and all below it, within one task.
    fn visit(&self, mut visit: Visit<E>, movers: &mut Movers<E>, task: Task<L::Out>) {
        self.open(&mut visit, movers);
        let cell = self.cell(&visit);
        if cell.is_leaf() {
            let mut gradient = Gradient::default();
            let local: Vec<_> = visit.local.iter().map(|c| c.to_f64()).collect();
            gradient.set(HarmonicTables::get(), self.order, cell.scale, &local);
            let far = Far { order: self.order, gradient };
            self.leaf.receive(cell, &far, &movers.lists.near, task);
            return;
        }
        let Task { bodies, samples, out } = task;
        for child in self.children(&visit, movers) {
            let task = Task { bodies: bodies.clone(), samples, out: &mut *out };
            self.visit(child, movers, task);
        }
    }

    /// Sorts the source cells that the parent left, and adds the far ones to the local expansion of
    /// the visited cell.
    fn open(&self, visit: &mut Visit<E>, movers: &mut Movers<E>) {
        let mut lists = std::mem::take(&mut movers.lists);
        lists.sort(self, visit);
        lists.far.sort_by_key(|far| std::cmp::Reverse(far.degree));
        self.add_far(&lists.far, self.cell(visit), movers, &mut visit.local);
        movers.lists = lists;
    }

    /// Visits of the wanted children, with their local expansions (L2L) and the source cells left
    /// to them.
    fn children(&self, visit: &Visit<E>, movers: &mut Movers<E>) -> Vec<Visit<E>> {
        let (cell, cells) = (self.cell(visit), &self.targets.cells);
        let wanted: Vec<_> =
            cell.children.clone().filter(|&child| self.wanted(&cells[child])).collect();
        let to = |&child: &usize| shift(cell, &cells[child], &visit.local, self.order);
        let shifts: Vec<_> = wanted.iter().map(to).collect();
        let size = count(self.order);
        let mut locals = vec![E::from_f64(0.0); size * wanted.len()];
        movers.translator.each(TranslationKind::Local, &shifts, &mut locals);
        let child = |(cell, local): (usize, &[E])| Visit {
            cell,
            local: local.to_vec(),
            pending: movers.lists.pending.clone(),
        };
        wanted.into_iter().zip(locals.chunks_exact(size)).map(child).collect()
    }
}

/// Visit of a cell of the targets on the way down.
struct Visit<E> {
    /// Index of the cell.
    cell: usize,
    /// Local expansion of the cell, by what is far from the cells above it.
    local: Vec<E>,
    /// Indices of the source cells that the cells above left.
    pending: Vec<u32>,
}

/// Scratch space of one thread: what moves expansions, and the lists of the cell that it is at.
struct Movers<E> {
    translator: Translator<E>,
    single: Option<Single>,
    lists: Lists,
}

/// Scratch space for moving expansions in single precision, with the sum of some.
struct Single {
    translator: Translator<f32>,
    sums: Vec<f32>,
}

/// Source cell that is far away.
struct Distant {
    /// Index of the cell.
    cell: u32,
    /// Degree that the expansion of the cell needs at this distance.
    degree: usize,
}

/// Source cells that a target cell was left, as it sorts them.
#[derive(Default)]
struct Lists {
    /// Cells whose expansions are used.
    far: Vec<Distant>,
    /// Cells that are left to the children.
    pending: Vec<u32>,
    /// Ranges of bodies that act one by one.
    near: Vec<Range<usize>>,
    /// Cells that are yet to be sorted.
    stack: Vec<u32>,
}

impl Lists {
    /// Sorts the pending cells of a visit. The larger of two cells is split, of equal ones that
    /// with the greater index, so that within one tree a body is near to another if that is near to
    /// it.
    fn sort<L: Leaf, E: Coefficient>(&mut self, descent: &Descent<L, E>, visit: &Visit<E>) {
        let (own, target) = (visit.cell, descent.cell(visit));
        self.far.clear();
        self.pending.clear();
        self.near.clear();
        self.stack.extend(visit.pending.iter().rev());
        while let Some(index) = self.stack.pop() {
            let source = &descent.sources.tree.cells[index as usize];
            let larger = (source.radius, index as usize) > (target.radius, own);
            let reach = target.radius + source.radius;
            let distance = (source.center - target.center).norm();
            let pairs = source.bodies.len() * target.bodies.len();
            let leaves = target.is_leaf() && (source.is_leaf() || pairs <= descent.direct);
            // The criterion of acceptance: the spheres are small for the distance of their centers.
            if reach < descent.opening * distance && reach + descent.clearance <= distance {
                if leaves && pairs <= descent.direct {
                    self.near(&source.bodies);
                } else {
                    let degree = descent.degrees.of([source.radius, target.radius], distance);
                    self.far.push(Distant { cell: index, degree });
                }
            } else if leaves {
                self.near(&source.bodies);
            } else if !source.is_leaf() && (target.is_leaf() || larger) {
                #[expect(clippy::cast_possible_truncation, reason = "indices fit 32 bits")]
                self.stack.extend(source.children.clone().rev().map(|child| child as u32));
            } else {
                self.pending.push(index);
            }
        }
    }

    /// Adds a range of bodies to the near ones; one that follows the last is joined to it.
    fn near(&mut self, bodies: &Range<usize>) {
        match self.near.last_mut() {
            Some(last) if last.end == bodies.start => last.end = bodies.end,
            _ => self.near.push(bodies.clone()),
        }
    }
}
