//! Boxes in groups of at most sixteen that lie together.
//!
//! The boxes are sorted along a space-filling curve and cut into runs of a hundred or so where the
//! curve enters another cell; only within these runs are they split by the surface area heuristic.
//! A tree that is split so from the root on has a few per cent fewer pairs of boxes to look at,
//! but takes four times as long to build.

use super::block::WIDTH;
use super::bounds::Bounds;

/// Runs of the curve are cut until they are no longer than this.
const RUN: usize = 128;
/// Candidates for a split.
const BINS: usize = 16;
/// Bits of the place on the curve, of one axis.
const BITS: u32 = 10;

/// Indices of boxes in an order in which groups lie together, and where every group ends in it.
pub(super) struct Groups {
    pub(super) order: Vec<u32>,
    pub(super) ends: Vec<usize>,
}

/// Groups `boxes`. Cost: 60 ns a box.
pub(super) fn group(boxes: &[Bounds]) -> Groups {
    let curve = sorted_along_curve(boxes);
    let mut items: Vec<Item> =
        curve.iter().map(|c| Item::new(c.index, &boxes[c.index as usize])).collect();
    let mut ends = Vec::with_capacity(boxes.len() / (WIDTH / 2) + 1);
    let mut stack = vec![0..boxes.len()];
    while let Some(range) = stack.pop() {
        if range.len() <= WIDTH {
            ends.push(range.end);
            continue;
        }
        let cut = if range.len() > RUN { enter_cell(&curve[range.clone()]) } else { None };
        let cut = cut.unwrap_or_else(|| split(&mut items[range.clone()]));
        let middle = range.start + cut;
        stack.push(middle..range.end);
        stack.push(range.start..middle);
    }
    Groups { order: items.iter().map(|item| item.index).collect(), ends }
}

/// A box on the curve.
#[derive(Clone, Copy, Default)]
struct Place {
    /// Place of its centre: the bits of its cell's coordinates, interleaved.
    code: u32,
    index: u32,
}

fn sorted_along_curve(boxes: &[Bounds]) -> Vec<Place> {
    let mut hull = Bounds::EMPTY;
    for bounds in boxes {
        hull.hold(bounds);
    }
    let extent = (0..3).fold(0.0, |extent: f32, d| extent.max(hull.high[d] - hull.low[d]));
    // Cells are cubes: the curve divides the longest extent first. Halves, because the sum of two
    // finite numbers may not be finite.
    let cells = (1 << BITS) as f32;
    let scale = if extent > 0.0 { cells / extent } else { 0.0 };
    let cell = |bounds: &Bounds, d: usize| {
        let center = 0.5 * bounds.low[d] + 0.5 * bounds.high[d];
        ((center - hull.low[d]) * scale).min(cells - 1.0) as u32
    };
    let place = |(index, bounds)| {
        let code =
            spread(cell(bounds, 0)) | spread(cell(bounds, 1)) << 1 | spread(cell(bounds, 2)) << 2;
        Place { code, index }
    };
    let mut places: Vec<Place> = (0..).zip(boxes).map(place).collect();
    let mut other = vec![Place::default(); places.len()];
    for digit in 0..3 {
        sort_by_digit(&places, &mut other, digit * BITS);
        std::mem::swap(&mut places, &mut other);
    }
    places
}

/// Moves the lowest ten bits apart, two zeros between any two.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00FF;
    let x = (x | x << 8) & 0x0300_F00F;
    let x = (x | x << 4) & 0x030C_30C3;
    (x | x << 2) & 0x0924_9249
}

/// Sorts by the ten bits of the code from `shift` on; equal ones keep their order.
fn sort_by_digit(from: &[Place], to: &mut [Place], shift: u32) {
    let digit = |place: &Place| (place.code >> shift) as usize & ((1 << BITS) - 1);
    let mut next = vec![0_u32; 1 << BITS];
    for place in from {
        next[digit(place)] += 1;
    }
    let mut sum = 0;
    for next in &mut next {
        sum += std::mem::replace(next, sum);
    }
    for place in from {
        let next = &mut next[digit(place)];
        to[*next as usize] = *place;
        *next += 1;
    }
}

/// Where the curve leaves the first half of the smallest cell that holds all of `curve`; none if
/// all are in one.
fn enter_cell(curve: &[Place]) -> Option<usize> {
    let (first, last) = (curve.first()?.code, curve.last()?.code);
    let differ = (first ^ last).checked_ilog2()?;
    Some(curve.partition_point(|place| place.code >> differ & 1 == 0))
}

/// A box that is being grouped; the fourth lanes only fill the registers.
#[derive(Clone, Copy)]
#[repr(align(16))]
struct Hull {
    low: [f32; 4],
    high: [f32; 4],
}

impl Hull {
    const EMPTY: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    fn hold(&mut self, other: &Self) {
        for d in 0..4 {
            self.low[d] = if other.low[d] < self.low[d] { other.low[d] } else { self.low[d] };
            self.high[d] = if other.high[d] > self.high[d] { other.high[d] } else { self.high[d] };
        }
    }

    /// Half of the surface: the chance that another box meets it grows with that.
    fn half_area(&self) -> f32 {
        let [x, y, z]: [f32; 3] = std::array::from_fn(|d| self.high[d] - self.low[d]);
        x * y + y * z + z * x
    }
}

#[derive(Clone, Copy)]
struct Item {
    hull: Hull,
    /// Centre, each coordinate twice.
    center: [f32; 3],
    index: u32,
}

impl Item {
    fn new(index: u32, bounds: &Bounds) -> Self {
        let [x, y, z] = bounds.low;
        let [u, v, w] = bounds.high;
        let hull = Hull { low: [x, y, z, 0.0], high: [u, v, w, 0.0] };
        Self { hull, center: [x + u, y + v, z + w], index }
    }
}

/// Reorders `items` into two parts that are not empty, where the surface area heuristic is least
/// among splits across the longest extent of the centres; the length of the first part.
fn split(items: &mut [Item]) -> usize {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for item in &*items {
        for d in 0..3 {
            low[d] = low[d].min(item.center[d]);
            high[d] = high[d].max(item.center[d]);
        }
    }
    let extent = |d: usize| high[d] - low[d];
    let axis = (0..3).fold(0, |axis, d| if extent(d) > extent(axis) { d } else { axis });
    let scale = BINS as f32 / extent(axis);
    if !scale.is_finite() {
        return items.len() / 2;
    }
    let bin = |item: &Item| (((item.center[axis] - low[axis]) * scale) as usize).min(BINS - 1);
    let best = cheapest(items, bin);
    let mut first = 0;
    for k in 0..items.len() {
        if bin(&items[k]) < best {
            items.swap(k, first);
            first += 1;
        }
    }
    first
}

/// The first bin of the second part of the cheapest split; a part's cost is its number of groups
/// times the surface of its hull. The first and the last bin are not empty.
fn cheapest(items: &[Item], bin: impl Fn(&Item) -> usize) -> usize {
    let mut bins = [(0_usize, Hull::EMPTY); BINS];
    for item in items {
        let (count, hull) = &mut bins[bin(item)];
        *count += 1;
        hull.hold(&item.hull);
    }
    let cost = |count: usize, hull: &Hull| count.div_ceil(WIDTH) as f32 * hull.half_area();
    let mut costs = [0.0; BINS];
    let (mut count, mut hull) = (0, Hull::EMPTY);
    for b in (1..BINS).rev() {
        count += bins[b].0;
        hull.hold(&bins[b].1);
        costs[b] = cost(count, &hull);
    }
    (count, hull) = (0, Hull::EMPTY);
    let (mut best, mut least) = (1, f32::INFINITY);
    for b in 1..BINS {
        count += bins[b - 1].0;
        hull.hold(&bins[b - 1].1);
        let cost = costs[b] + cost(count, &hull);
        if cost < least {
            (best, least) = (b, cost);
        }
    }
    best
}
