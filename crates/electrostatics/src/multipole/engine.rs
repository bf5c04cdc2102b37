//! Up one tree and down another.
//!
//! Multipoles of all source cells are made first. Then each target cell, from the root down, sorts
//! the source cells that its parent left: those far enough away become part of its local expansion,
//! the others are split or left to its children. Locals live only on the path from the root, and a
//! cell's sums are made in the order of its list, whatever thread makes them.

use super::near::Cloud;
use super::points;
use super::tree::{Cell, Tree};
use crate::harmonics::{Coefficient, Gradient, Kind, Shift, Tables, Translator, count};
use rayon::prelude::*;
use std::ops::Range;

/// Bodies below which a subtree is one task, where it matters not to them which are in it: there are
/// then tasks enough for all threads to end at the same time.
pub(crate) const GRAIN: usize = 8192;

/// The multipoles of all cells of a tree.
pub(crate) struct Multipoles<'a, E> {
    pub(crate) tree: &'a Tree,
    order: usize,
    moments: Vec<E>,
    rounded: Option<Rounded>,
}

/// Moments in single precision, for what degrees from `low` on take part in.
struct Rounded {
    low: usize,
    moments: Vec<f32>,
}

impl<'a, E: Coefficient> Multipoles<'a, E> {
    /// Multipoles of degree up to `order`; `cloud` holds `per_body` points for each body of the tree,
    /// in its order.
    pub(crate) fn new(tree: &'a Tree, cloud: &Cloud, per_body: usize, order: usize) -> Self {
        let size = count(order);
        let mut moments = vec![E::from_f64(0.0); size * tree.cells.len()];
        let mut below = 0..0;
        for level in tree.levels.windows(2).rev() {
            let (above, deeper) =
                moments[size * level[0]..].split_at_mut(size * (level[1] - level[0]));
            let deeper = &deeper[..size * below.len()];
            let cells = &tree.cells[level[0]..level[1]];
            let scratch = || (points::work(order), vec![0.0; size], Translator::<E>::new(order));
            // Those with many points or children may stand together.
            let cells = cells.par_iter().zip(above.par_chunks_exact_mut(size));
            let cells = cells.with_min_len(16).with_max_len(512);
            cells.for_each_init(scratch, |(work, leaf, translator), (cell, moments)| {
                if cell.is_leaf() {
                    let range = scaled(&cell.bodies, per_body);
                    points::multipole(order, cell, cloud, range, work, leaf);
                    moments.iter_mut().zip(leaf).for_each(|(m, leaf)| *m = E::from_f64(*leaf));
                    return;
                }
                let shift = |child: usize| {
                    let coefficients = &deeper[size * (child - below.start)..][..size];
                    shift(&tree.cells[child], cell, coefficients, order)
                };
                let shifts: Vec<_> = cell.children.clone().map(shift).collect();
                translator.sum(Kind::Multipole, &shifts, moments);
            });
            below = level[0]..level[1];
        }
        Self { tree, order, moments, rounded: None }
    }

    /// The same, that are moved far in single precision but for what degrees below `low` do to each
    /// other: the others are small.
    pub(crate) fn rounded(mut self, low: usize) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
        let moments = self.moments.par_iter().map(|moment| moment.to_f64() as f32).collect();
        self.rounded = Some(Rounded { low, moments });
        self
    }

    /// The coefficients of a cell.
    pub(crate) fn moments(&self, cell: usize) -> &[E] {
        &self.moments[count(self.order) * cell..][..count(self.order)]
    }
}

/// What all bodies are to be found, nothing yet. All threads write it, as memory that is read before it is
/// written takes twice as long, and more where other threads run.
pub(crate) fn nothing<const N: usize>(bodies: usize) -> Vec<[f64; N]> {
    (0..bodies).into_par_iter().map(|_| [0.0; N]).collect()
}

/// The parts of `all` for these ascending `ranges`.
pub(crate) fn parts<T>(
    mut all: &mut [T],
    ranges: impl Iterator<Item = Range<usize>>,
) -> Vec<(Range<usize>, &mut [T])> {
    let mut first = 0;
    let part = |range: Range<usize>| {
        let (_, rest) = std::mem::take(&mut all).split_at_mut(range.start - first);
        let (part, rest) = rest.split_at_mut(range.len());
        (all, first) = (rest, range.end);
        (range, part)
    };
    ranges.map(part).collect()
}

/// The points of `bodies`.
pub(crate) fn scaled(bodies: &Range<usize>, per_body: usize) -> Range<usize> {
    bodies.start * per_body..bodies.end * per_body
}

fn shift<'a, E>(from: &Cell, to: &Cell, coefficients: &'a [E], degree: usize) -> Shift<'a, E> {
    let (offset, scales) = (to.center - from.center, [from.scale, to.scale]);
    Shift { coefficients, degrees: [degree; 2], offset, scales }
}

/// What a leaf of the targets does with what has come down to it.
pub(crate) trait Leaf: Sync {
    /// What is found for each body.
    type Out: Send;

    /// Adds what the local expansion `far` and the bodies `near` of the sources do to the bodies of
    /// `cell`.
    fn receive(&self, cell: &Cell, far: &Far, near: &[Range<usize>], task: Task<Self::Out>);
}

/// The bodies of one thread: a leaf of them and all of its neighbors.
pub(crate) struct Task<'a, Out> {
    /// Which bodies they are.
    pub(crate) bodies: Range<usize>,
    /// Which of all bodies are wanted, ascending; without, all.
    pub(crate) samples: Option<&'a [usize]>,
    /// What is found for each of them.
    pub(crate) out: &'a mut [Out],
}

impl<Out> Task<'_, Out> {
    /// Whether body `j` is looked at in this task as well, so that pairs with it are found twice.
    pub(crate) fn both(&self, j: usize) -> bool {
        self.samples.is_none() && self.bodies.contains(&j)
    }

    /// The bodies of `cell` that are wanted.
    pub(crate) fn wanted(&self, cell: &Cell) -> Vec<usize> {
        match self.samples {
            Some(samples) => {
                let place = |body| samples.partition_point(|sample| *sample < body);
                samples[place(cell.bodies.start)..place(cell.bodies.end)].to_vec()
            }
            None => cell.bodies.clone().collect(),
        }
    }

    /// What is found for body `i`.
    pub(crate) fn of_body(&mut self, i: usize) -> &mut Out {
        &mut self.out[i - self.bodies.start]
    }

    /// What is found for the bodies of `cell`.
    pub(crate) fn of(&mut self, cell: &Cell) -> &mut [Out] {
        let first = self.bodies.start;
        &mut self.out[cell.bodies.start - first..cell.bodies.end - first]
    }
}

/// The local expansion of a leaf.
pub(crate) struct Far {
    order: usize,
    gradient: Gradient,
}

impl Far {
    /// Adds the potential and its gradient at some points in `cell`.
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

/// Which degree is enough for the expansions of two cells.
pub(crate) struct Degrees {
    /// Ratios up to which each degree is enough, ascending; the last serves all.
    falls: Vec<f64>,
}

impl Degrees {
    /// The degrees at which expansions err as those of degree `order` do for equal cells at the least
    /// distance for `opening`, if their number of terms is the share `thinning` of the logarithm that
    /// this takes; zero leaves all of them the full degree.
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

    /// The degree for cells with these radii and at this distance. A term falls from degree to degree by
    /// at least the larger radius over the distance of its center from the other sphere.
    fn of(&self, radii: [f64; 2], distance: f64) -> usize {
        let falls = radii[0].max(radii[1]) / (distance - radii[0].min(radii[1]));
        self.falls.partition_point(|fall| *fall < falls)
    }
}

/// The way down.
pub(crate) struct Descent<'a, L, E> {
    pub(crate) sources: &'a Multipoles<'a, E>,
    pub(crate) targets: &'a Tree,
    pub(crate) leaf: &'a L,
    /// Degree of the expansions; at most that of the multipoles.
    pub(crate) order: usize,
    /// Largest ratio of the sum of the radii of two cells to their distance.
    pub(crate) opening: f64,
    /// Degrees of distant cells.
    pub(crate) degrees: Degrees,
    /// Least length between cells whose expansions are used.
    pub(crate) clearance: f64,
    /// Pairs of bodies that are cheaper one by one than by their cells.
    pub(crate) direct: usize,
    /// Bodies of the targets below which a subtree is one task.
    pub(crate) grain: usize,
    /// Bodies of the targets, ascending, that are wanted; without, all.
    pub(crate) samples: Option<&'a [usize]>,
}

impl<L: Leaf, E: Coefficient> Descent<'_, L, E> {
    /// Adds to `out`, which has one item for each target in the order of its tree.
    pub(crate) fn run(&self, out: &mut [L::Out]) {
        if self.targets.cells.is_empty() || self.sources.tree.cells.is_empty() {
            return;
        }
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
        // Threads take one after another, the largest first, so that they end at about the same time; those
        // of about the same size, as neighbors have much in common.
        tasks.sort_by_key(|(_, task)| std::cmp::Reverse(task.bodies.len().ilog2()));
        tasks.into_iter().par_bridge().for_each_init(
            || self.movers(),
            |movers, (visit, task)| self.visit(visit, movers, task),
        );
    }

    fn cell(&self, visit: &Visit<E>) -> &Cell {
        &self.targets.cells[visit.cell]
    }

    fn movers(&self) -> Movers<E> {
        let single = || Single {
            translator: Translator::new(self.order),
            sums: vec![0.0; count(self.order)],
        };
        let single = self.sources.rounded.is_some().then(single);
        Movers { translator: Translator::new(self.order), single, lists: Lists::default() }
    }

    /// Adds the expansions `far`, of falling degree, to the local expansion of `cell`.
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
        movers.translator.sum(Kind::Far(0), &shifts, local);
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
            single.translator.sum(Kind::Far(rounded.low), &higher, &mut single.sums);
            for (local, sum) in local.iter_mut().zip(&single.sums) {
                *local = E::from_f64(local.to_f64() + f64::from(*sum));
            }
        }
    }

    fn wanted(&self, cell: &Cell) -> bool {
        let Some(samples) = self.samples else { return true };
        let next = samples.partition_point(|sample| *sample < cell.bodies.start);
        samples.get(next).is_some_and(|sample| *sample < cell.bodies.end)
    }

    fn visit(&self, mut visit: Visit<E>, movers: &mut Movers<E>, task: Task<L::Out>) {
        self.open(&mut visit, movers);
        let cell = self.cell(&visit);
        if cell.is_leaf() {
            let mut gradient = Gradient::default();
            let local: Vec<_> = visit.local.iter().map(|c| c.to_f64()).collect();
            gradient.set(Tables::get(), self.order, cell.scale, &local);
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

    /// Sorts what the parent left, and adds what is far to the local expansion.
    fn open(&self, visit: &mut Visit<E>, movers: &mut Movers<E>) {
        let mut lists = std::mem::take(&mut movers.lists);
        lists.sort(self, visit);
        lists.far.sort_by_key(|far| std::cmp::Reverse(far.degree));
        self.add_far(&lists.far, self.cell(visit), movers, &mut visit.local);
        movers.lists = lists;
    }

    /// The children that are wanted, with what is left to them.
    fn children(&self, visit: &Visit<E>, movers: &mut Movers<E>) -> Vec<Visit<E>> {
        let (cell, cells) = (self.cell(visit), &self.targets.cells);
        let wanted: Vec<_> =
            cell.children.clone().filter(|&child| self.wanted(&cells[child])).collect();
        let to = |&child: &usize| shift(cell, &cells[child], &visit.local, self.order);
        let shifts: Vec<_> = wanted.iter().map(to).collect();
        let size = count(self.order);
        let mut locals = vec![E::from_f64(0.0); size * wanted.len()];
        movers.translator.each(Kind::Local, &shifts, &mut locals);
        let child = |(cell, local): (usize, &[E])| Visit {
            cell,
            local: local.to_vec(),
            pending: movers.lists.pending.clone(),
        };
        wanted.into_iter().zip(locals.chunks_exact(size)).map(child).collect()
    }
}

/// A cell of the targets on the way down.
struct Visit<E> {
    cell: usize,
    /// Its local expansion, by what is far from its parents.
    local: Vec<E>,
    /// Source cells that those left.
    pending: Vec<u32>,
}

/// What moves the expansions of one thread, and the lists of the cell that it is at.
struct Movers<E> {
    translator: Translator<E>,
    single: Option<Single>,
    lists: Lists,
}

/// The same in single precision, with space for a sum.
struct Single {
    translator: Translator<f32>,
    sums: Vec<f32>,
}

/// A source cell that is far away.
struct Distant {
    cell: u32,
    /// Degree that its expansion needs there.
    degree: usize,
}

/// What becomes of the source cells that a target cell was left.
#[derive(Default)]
struct Lists {
    far: Vec<Distant>,
    pending: Vec<u32>,
    near: Vec<Range<usize>>,
    /// Those that are yet to be sorted.
    stack: Vec<u32>,
}

impl Lists {
    /// The larger of two cells is split, of equal ones that with the greater index, so that within
    /// one tree a body is near to another if that is near to it.
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

    /// Adds bodies; those that follow the last ones are joined to them.
    fn near(&mut self, bodies: &Range<usize>) {
        match self.near.last_mut() {
            Some(last) if last.end == bodies.start => last.end = bodies.end,
            _ => self.near.push(bodies.clone()),
        }
    }
}
