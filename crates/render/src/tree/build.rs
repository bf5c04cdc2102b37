use super::bounds::RayBox;
use super::node::{LEAF, LeafThings, NONE, RayNode, WIDTH, short};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Candidates for a split along each axis.
const BINS: usize = 16;
const LAST_BIN: f32 = BINS as f32 - 1.0;
/// Boxes that are looked at, or twice as many, to find a split.
const SAMPLED: usize = 4096;
/// Things of which several threads take parts.
const MANY: usize = 1 << 14;
/// Levels of nodes after which parts are halved, so that a walk has room for what waits.
const DEEPEST: u32 = 9;

/// The nodes of a tree over boxes, the root first, and the things of every leaf.
pub(super) fn build(boxes: Vec<RayBox>) -> (Vec<RayNode>, Vec<LeafThings>) {
    let mut boxes = boxes;
    for (index, bounds) in (0..).zip(&mut boxes) {
        bounds.set_index(index);
    }
    if boxes.is_empty() {
        return (Vec::new(), Vec::new());
    }
    let Subtree { nodes, leaves } = Subtree::new(&mut boxes, 0);
    (nodes, leaves)
}

/// A node and all below it; indices count from here.
struct Subtree {
    nodes: Vec<RayNode>,
    leaves: Vec<LeafThings>,
}

impl Subtree {
    fn new(boxes: &mut [RayBox], level: u32) -> Self {
        let many = boxes.len() >= MANY;
        let (parts, count) = parted(boxes, level);
        let parts = &mut { parts }[..count];
        let below = |(_, part): &mut (RayBox, &mut [RayBox])| {
            (part.len() > WIDTH).then(|| Self::new(part, level + 1))
        };
        let children: Vec<_> = if many {
            parts.par_iter_mut().map(below).collect()
        } else {
            parts.iter_mut().map(below).collect()
        };
        let mut tree = Self { nodes: vec![RayNode::EMPTY], leaves: Vec::new() };
        for (lane, (child, (bounds, part))) in children.into_iter().zip(parts).enumerate() {
            let index = match child {
                Some(below) => tree.adopt(below),
                None => tree.add_leaf(part),
            };
            tree.nodes[0].set(lane, bounds, index);
        }
        tree
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

    /// Takes the nodes and leaves of another in; the index of its first node.
    fn adopt(&mut self, mut other: Self) -> u32 {
        let (node, leaf) = (short(self.nodes.len()), short(self.leaves.len()));
        for child in other.nodes.iter_mut().flat_map(|node| &mut node.children) {
            if *child != NONE {
                *child += if *child & LEAF == 0 { node } else { leaf };
            }
        }
        self.nodes.append(&mut other.nodes);
        self.leaves.append(&mut other.leaves);
        node
    }
}

type Parts<'a> = [(RayBox, &'a mut [RayBox]); WIDTH];

/// Boxes in at most eight parts, each with its hull; the largest is split as long as there is room.
fn parted(boxes: &mut [RayBox], level: u32) -> (Parts<'_>, usize) {
    let mut parts: Parts<'_> = std::array::from_fn(|_| (RayBox::EMPTY, &mut [][..]));
    parts[0] = (hull(boxes), boxes);
    let mut count = 1;
    while count < WIDTH {
        let wide = (0..count).filter(|&k| parts[k].1.len() > WIDTH);
        let area =
            |&a: &usize, &b: &usize| parts[a].0.half_area().total_cmp(&parts[b].0.half_area());
        let Some(largest) = wide.max_by(area) else { break };
        let part = std::mem::take(&mut parts[largest].1);
        let middle =
            if level < DEEPEST { Arch::new().dispatch(SplitKernel(part)) } else { part.len() / 2 };
        let (a, b) = part.split_at_mut(middle);
        parts[largest] = (hull(a), a);
        parts[count] = (hull(b), b);
        count += 1;
    }
    (parts, count)
}

/// The hull of boxes.
fn hull(boxes: &[RayBox]) -> RayBox {
    Arch::new().dispatch(HullKernel(boxes))
}

struct HullKernel<'a>(&'a [RayBox]);

impl NullaryFnOnce for HullKernel<'_> {
    type Output = RayBox;

    #[inline(always)]
    fn call(self) -> RayBox {
        let mut hull = RayBox::EMPTY;
        self.0.iter().for_each(|bounds| hull.hold(bounds));
        hull
    }
}

/// Reorders boxes into two parts that are not empty, where the surface area heuristic is least; the
/// length of the first.
struct SplitKernel<'a>(&'a mut [RayBox]);

impl NullaryFnOnce for SplitKernel<'_> {
    type Output = usize;

    #[inline(always)]
    fn call(self) -> usize {
        let Self(boxes) = self;
        // Of many boxes a part tells as well where to split.
        let every = (boxes.len() / SAMPLED).max(1);
        let mut centers = RayBox::EMPTY;
        for bounds in boxes.iter().step_by(every) {
            centers.hold(&bounds.center());
        }
        let slabs = [0, 1, 2].map(|axis| Slabs::new(&centers, axis));
        let mut counts = [[0_u32; BINS]; 3];
        let mut hulls = [[RayBox::EMPTY; BINS]; 3];
        for bounds in boxes.iter().step_by(every) {
            for axis in 0..3 {
                let bin = slabs[axis].bin(bounds);
                counts[axis][bin] += 1;
                hulls[axis][bin].hold(bounds);
            }
        }
        let mut best = (f32::INFINITY, 0, 0);
        for axis in (0..3).filter(|&axis| slabs[axis].scale > 0.0) {
            let (cost, bin) = cheapest(&counts[axis], &hulls[axis]);
            if cost < best.0 {
                best = (cost, axis, bin);
            }
        }
        let (_, axis, bin) = best;
        // All have one middle.
        if bin == 0 {
            return boxes.len() / 2;
        }
        let mut first = 0;
        for k in 0..boxes.len() {
            let below = slabs[axis].bin(&boxes[k]) < bin;
            boxes.swap(first, k);
            first += usize::from(below);
        }
        // A split of a part may be none of all.
        if first == 0 || first == boxes.len() { boxes.len() / 2 } else { first }
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
fn cheapest(counts: &[u32; BINS], hulls: &[RayBox; BINS]) -> (f32, usize) {
    let cost = |count: u32, hull: &RayBox| count.div_ceil(short(WIDTH)) as f32 * hull.half_area();
    let mut costs = [0.0; BINS];
    let (mut count, mut hull) = (0, RayBox::EMPTY);
    for b in (1..BINS).rev() {
        count += counts[b];
        hull.hold(&hulls[b]);
        costs[b] = cost(count, &hull);
    }
    (count, hull) = (0, RayBox::EMPTY);
    let mut best = (f32::INFINITY, 1);
    for b in 1..BINS {
        count += counts[b - 1];
        hull.hold(&hulls[b - 1]);
        let cost = costs[b] + cost(count, &hull);
        if cost < best.0 {
            best = (cost, b);
        }
    }
    best
}
