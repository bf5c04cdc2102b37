use super::bounds::RayBox;
use super::node::{LEAF, LeafThings, NONE, RayNode, WIDTH, short};
use super::registers::of_eight;
use pulp::{Simd, WithSimd};
use rayon::prelude::*;

/// Candidates for a split along each axis.
const BINS: usize = 16;
const LAST_BIN: f32 = BINS as f32 - 1.0;
/// Boxes that are looked at, or twice as many, to find a split.
const SAMPLED: usize = 1024;
/// Things of which several threads take parts.
const MANY: usize = 1 << 14;
/// Levels of nodes after which parts are halved, so that a walk has room for what waits.
const DEEPEST: u32 = 9;

/// The nodes of a tree over boxes, the root first, and the things of every leaf.
pub(super) fn build(boxes: Vec<RayBox>) -> (Vec<RayNode>, Vec<LeafThings>) {
    let mut boxes = boxes;
    let mut tree = Subtree::default();
    if !boxes.is_empty() {
        tree.grow((of_eight(HullKernel(&boxes)), &mut boxes), 0);
    }
    (tree.nodes, tree.leaves)
}

/// Boxes and their hull.
type Part<'a> = (RayBox, &'a mut [RayBox]);

/// A node and all below it; indices count from here.
#[derive(Default)]
struct Subtree {
    nodes: Vec<RayNode>,
    leaves: Vec<LeafThings>,
}

impl Subtree {
    /// Adds a node over boxes and all below it; it as a child.
    fn grow(&mut self, part: Part<'_>, level: u32) -> u32 {
        let many = part.1.len() >= MANY;
        let (mut parts, count) = parted(part, level);
        let parts = &mut parts[..count];
        let node = self.nodes.len();
        self.nodes.push(RayNode::EMPTY);
        if many {
            let below = |(bounds, part): &mut Part<'_>| {
                let mut tree = Self::default();
                let child = tree.grow_child((*bounds, part), level);
                (*bounds, child, tree)
            };
            let children: Vec<_> = parts.par_iter_mut().map(below).collect();
            self.nodes.reserve(children.iter().map(|(.., tree)| tree.nodes.len()).sum());
            self.leaves.reserve(children.iter().map(|(.., tree)| tree.leaves.len()).sum());
            for (lane, (bounds, child, tree)) in children.into_iter().enumerate() {
                let child = child + self.adopt(tree, child & LEAF != 0);
                self.nodes[node].set(lane, &bounds, child);
            }
        } else {
            for (lane, (bounds, part)) in parts.iter_mut().enumerate() {
                let child = self.grow_child((*bounds, part), level);
                self.nodes[node].set(lane, bounds, child);
            }
        }
        short(node)
    }

    /// Adds a part of a node on a level; it as a child.
    fn grow_child(&mut self, part: Part<'_>, level: u32) -> u32 {
        if part.1.len() > WIDTH { self.grow(part, level + 1) } else { self.add_leaf(part.1) }
    }

    /// Adds a leaf; it as a child.
    fn add_leaf(&mut self, things: &[RayBox]) -> u32 {
        let mut leaf = [NONE; WIDTH];
        for (lane, thing) in things.iter().enumerate() {
            leaf[lane] = thing.index();
        }
        self.leaves.push(leaf);
        short(self.leaves.len() - 1) | LEAF
    }

    /// Takes the nodes and leaves of another in; by how much indices in it grow, of leaves or of
    /// nodes.
    fn adopt(&mut self, mut other: Self, leaves: bool) -> u32 {
        let (node, leaf) = (short(self.nodes.len()), short(self.leaves.len()));
        for child in other.nodes.iter_mut().flat_map(|node| &mut node.children) {
            if *child != NONE {
                *child += if *child & LEAF == 0 { node } else { leaf };
            }
        }
        self.nodes.append(&mut other.nodes);
        self.leaves.append(&mut other.leaves);
        if leaves { leaf } else { node }
    }
}

/// Boxes in at most eight parts; the largest is split as long as there is room.
fn parted(whole: Part<'_>, level: u32) -> ([Part<'_>; WIDTH], usize) {
    let mut parts: [Part<'_>; WIDTH] = std::array::from_fn(|_| (RayBox::EMPTY, &mut [][..]));
    parts[0] = whole;
    let mut count = 1;
    while count < WIDTH {
        let wide = (0..count).filter(|&k| parts[k].1.len() > WIDTH);
        let area =
            |&a: &usize, &b: &usize| parts[a].0.half_area().total_cmp(&parts[b].0.half_area());
        let Some(largest) = wide.max_by(area) else { break };
        let part = std::mem::take(&mut parts[largest].1);
        let (middle, [first, second]) = if level < DEEPEST { split(part) } else { halved(part) };
        let (a, b) = part.split_at_mut(middle);
        parts[largest] = (first, a);
        parts[count] = (second, b);
        count += 1;
    }
    (parts, count)
}

/// The hull of boxes.
#[inline(always)]
fn hull<S: Simd>(simd: S, boxes: &[RayBox]) -> RayBox {
    let mut hull = RayBox::EMPTY;
    boxes.iter().for_each(|bounds| hull.hold(simd, bounds));
    hull
}

struct HullKernel<'a>(&'a [RayBox]);

impl WithSimd for HullKernel<'_> {
    type Output = RayBox;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> RayBox {
        hull(simd, self.0)
    }
}

/// The length of the first half of boxes, and the hulls of both.
fn halved(boxes: &[RayBox]) -> (usize, [RayBox; 2]) {
    let middle = boxes.len() / 2;
    let (a, b) = boxes.split_at(middle);
    (middle, [a, b].map(|half| of_eight(HullKernel(half))))
}

/// Reorders boxes into two parts that are not empty, where the surface area heuristic is least; the
/// length of the first, and the hulls of both.
fn split(boxes: &mut [RayBox]) -> (usize, [RayBox; 2]) {
    of_eight(SplitKernel(boxes)).unwrap_or_else(|| halved(boxes))
}

/// What [`split`] does; nothing if the boxes have one middle, or a part of them does not tell where
/// to split all.
struct SplitKernel<'a>(&'a mut [RayBox]);

impl WithSimd for SplitKernel<'_> {
    type Output = Option<(usize, [RayBox; 2])>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self(boxes) = self;
        // Of many boxes a part tells as well where to split.
        let every = (boxes.len() / SAMPLED).max(1);
        let mut centers = RayBox::EMPTY;
        for bounds in boxes.iter().step_by(every) {
            centers.hold(simd, &bounds.center());
        }
        let slabs = [0, 1, 2].map(|axis| Slabs::new(&centers, axis));
        let mut counts = [[0_u32; BINS]; 3];
        let mut hulls = [[RayBox::EMPTY; BINS]; 3];
        for bounds in boxes.iter().step_by(every) {
            for axis in 0..3 {
                let bin = slabs[axis].bin(bounds);
                counts[axis][bin] += 1;
                hulls[axis][bin].hold(simd, bounds);
            }
        }
        let mut best = (f32::INFINITY, 0, 0);
        for axis in (0..3).filter(|&axis| slabs[axis].scale > 0.0) {
            let (cost, bin) = cheapest(simd, &counts[axis], &hulls[axis]);
            if cost < best.0 {
                best = (cost, axis, bin);
            }
        }
        let (_, axis, bin) = best;
        if bin == 0 {
            return None;
        }
        let (slabs, mut first) = (slabs[axis], 0);
        for k in 0..boxes.len() {
            let below = slabs.bin(&boxes[k]) < bin;
            boxes.swap(first, k);
            first += usize::from(below);
        }
        if first == 0 || first == boxes.len() {
            return None;
        }
        let hulls = if every == 1 {
            let (a, b) = hulls[axis].split_at(bin);
            [hull(simd, a), hull(simd, b)]
        } else {
            let (a, b) = boxes.split_at(first);
            [hull(simd, a), hull(simd, b)]
        };
        Some((first, hulls))
    }
}

/// Slabs across an axis, the first around the lowest middle and the last around the highest.
#[derive(Clone, Copy)]
struct Slabs {
    axis: usize,
    low: f32,
    /// Slabs per twice a length; zero where all middles are one, or no numbers.
    scale: f32,
}

impl Slabs {
    #[inline(always)]
    fn new(centers: &RayBox, axis: usize) -> Self {
        let low = centers.low(axis);
        let scale = LAST_BIN / (centers.high(axis) - low);
        Self { axis, low, scale: if scale < f32::INFINITY { scale } else { 0.0 } }
    }

    #[inline(always)]
    fn bin(self, bounds: &RayBox) -> usize {
        let middle = bounds.high(self.axis) + bounds.low(self.axis);
        let place = (middle - self.low) * self.scale;
        let place = if place > 0.0 { place } else { 0.0 };
        let place = if place < LAST_BIN { place } else { LAST_BIN };
        // Rounds to the nearest whole number: a conversion would test for what does not occur.
        const ROOM: f32 = 8_388_608.0;
        (place + ROOM).to_bits() as usize % BINS
    }
}

/// The cost of the cheapest split and the first slab of its second part; a part's cost is its
/// number of leaves times the surface of its hull. The first and the last slab are not empty.
#[inline(always)]
fn cheapest<S: Simd>(simd: S, counts: &[u32; BINS], hulls: &[RayBox; BINS]) -> (f32, usize) {
    let cost = |count: u32, hull: &RayBox| count.div_ceil(short(WIDTH)) as f32 * hull.half_area();
    let mut costs = [0.0; BINS];
    let (mut count, mut hull) = (0, RayBox::EMPTY);
    for b in (1..BINS).rev() {
        count += counts[b];
        hull.hold(simd, &hulls[b]);
        costs[b] = cost(count, &hull);
    }
    (count, hull) = (0, RayBox::EMPTY);
    let mut best = (f32::INFINITY, 1);
    for b in 1..BINS {
        count += counts[b - 1];
        hull.hold(simd, &hulls[b - 1]);
        let cost = costs[b] + cost(count, &hull);
        if cost < best.0 {
            best = (cost, b);
        }
    }
    best
}
