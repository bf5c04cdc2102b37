//! Boxes in groups of at most sixteen that lie together.
//!
//! The boxes are sorted along a space-filling curve and cut into runs of a hundred or so where the
//! curve enters another cell; only within these runs are they split by the surface area heuristic.
//! A tree that is split so from the root on has a few per cent fewer pairs of boxes to look at,
//! but takes four times as long to build.

use super::bounds::Bounds;
use pulp::{Arch, NullaryFnOnce};
use rapunzel_lanes::LANES_F32;

/// Runs of the curve are cut until they are no longer than this.
const RUN: usize = 96;
/// Candidates for a split.
const BINS: usize = 8;
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
    let item = |place: &CurvePlace| Hull::new(place.index, &boxes[place.index as usize]);
    let mut items: Vec<Hull> = curve.iter().map(item).collect();
    let ends = Arch::new().dispatch(Cut { curve: &curve, items: &mut items });
    Groups { order: items.iter().map(Hull::index).collect(), ends }
}

/// Cuts boxes on the curve into groups: reorders them and returns the ends of the groups.
struct Cut<'a> {
    curve: &'a [CurvePlace],
    items: &'a mut [Hull],
}

impl NullaryFnOnce for Cut<'_> {
    type Output = Vec<usize>;

    #[inline(always)]
    fn call(self) -> Vec<usize> {
        let Self { curve, items } = self;
        let mut ends = Vec::with_capacity(items.len() / (LANES_F32 / 2) + 1);
        let all = 0..items.len();
        let mut stack = vec![all];
        while let Some(range) = stack.pop() {
            if range.len() <= LANES_F32 {
                ends.push(range.end);
                continue;
            }
            let cut = if range.len() > RUN { enter_cell(&curve[range.clone()]) } else { None };
            let cut = match cut {
                Some(cut) => cut,
                None => split(&mut items[range.clone()]),
            };
            let middle = range.start + cut;
            stack.push(middle..range.end);
            stack.push(range.start..middle);
        }
        ends
    }
}

/// A box on the curve.
#[derive(Clone, Copy, Default)]
struct CurvePlace {
    /// Place of its centre: the bits of its cell's coordinates, interleaved.
    code: u32,
    index: u32,
}

fn sorted_along_curve(boxes: &[Bounds]) -> Vec<CurvePlace> {
    let mut hull = Bounds::EMPTY;
    for bounds in boxes {
        hull.hold(bounds);
    }
    let extent = (0..3).fold(0.0, |extent: f32, d| extent.max(hull.high[d] - hull.low[d]));
    // Cells are cubes: the curve divides the longest extent first. All halved, because the sum of
    // two finite numbers need not be finite.
    let scale = if extent > 0.0 { ((1 << BITS) - 1) as f32 / extent } else { 0.0 };
    let cell = |bounds: &Bounds, d: usize| {
        nearest((0.5 * bounds.low[d] + 0.5 * bounds.high[d] - hull.low[d]) * scale)
    };
    let place = |(index, bounds)| {
        let [x, y, z] = [cell(bounds, 0), cell(bounds, 1), cell(bounds, 2)];
        CurvePlace { code: spread(x) | spread(y) << 1 | spread(z) << 2, index }
    };
    let mut places: Vec<CurvePlace> = (0..).zip(boxes).map(place).collect();
    let mut other = vec![CurvePlace::default(); places.len()];
    for digit in 0..3 {
        sort_by_digit(&places, &mut other, digit * BITS);
        std::mem::swap(&mut places, &mut other);
    }
    places
}

/// The whole number nearest to `x` in 0..2^23, read off the last bits of a sum in which nothing
/// else has room: a conversion would test for numbers that do not occur here.
#[inline(always)]
fn nearest(x: f32) -> u32 {
    const ROOM: u32 = 1 << 23;
    (x + ROOM as f32).to_bits() % ROOM
}

/// Moves the lowest ten bits apart, two zeros between any two.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00FF;
    let x = (x | x << 8) & 0x0300_F00F;
    let x = (x | x << 4) & 0x030C_30C3;
    (x | x << 2) & 0x0924_9249
}

/// Sorts by the ten bits of the code from `shift` on; equal ones keep their order.
fn sort_by_digit(from: &[CurvePlace], to: &mut [CurvePlace], shift: u32) {
    let digit = |place: &CurvePlace| (place.code >> shift) as usize & ((1 << BITS) - 1);
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
fn enter_cell(curve: &[CurvePlace]) -> Option<usize> {
    let (first, last) = (curve.first()?.code, curve.last()?.code);
    let differ = (first ^ last).checked_ilog2()?;
    Some(curve.partition_point(|place| place.code >> differ & 1 == 0))
}

/// A box that is being grouped. The fourth lanes fill the registers; a box's index lies in one.
#[derive(Clone, Copy)]
#[repr(align(16))]
struct Hull {
    low: [f32; 4],
    high: [f32; 4],
}

impl Hull {
    const EMPTY: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    fn new(index: u32, bounds: &Bounds) -> Self {
        let ([x, y, z], [u, v, w]) = (bounds.low, bounds.high);
        Self { low: [x, y, z, f32::from_bits(index)], high: [u, v, w, 0.0] }
    }

    fn index(&self) -> u32 {
        self.low[3].to_bits()
    }

    /// Twice the coordinate of the centre.
    #[inline(always)]
    fn center(&self, axis: usize) -> f32 {
        self.low[axis] + self.high[axis]
    }

    #[inline(always)]
    fn hold(&mut self, low: &[f32; 4], high: &[f32; 4]) {
        for d in 0..4 {
            self.low[d] = if low[d] < self.low[d] { low[d] } else { self.low[d] };
            self.high[d] = if high[d] > self.high[d] { high[d] } else { self.high[d] };
        }
    }

    /// Half of the surface: the chance that another box meets it grows with that.
    #[inline(always)]
    fn half_area(&self) -> f32 {
        let (x, y) = (self.high[0] - self.low[0], self.high[1] - self.low[1]);
        let z = self.high[2] - self.low[2];
        x * y + y * z + z * x
    }
}

/// Reorders `items` into two parts that are not empty, where the surface area heuristic is least
/// among splits across the longest extent of the centres; the length of the first part.
#[inline(always)]
fn split(items: &mut [Hull]) -> usize {
    let mut centers = Hull::EMPTY;
    for item in &*items {
        let mut center = [0.0; 4];
        for d in 0..4 {
            center[d] = item.low[d] + item.high[d];
        }
        centers.hold(&center, &center);
    }
    let mut axis = 0;
    let mut extent = 0.0;
    for d in 0..3 {
        if centers.high[d] - centers.low[d] > extent {
            (axis, extent) = (d, centers.high[d] - centers.low[d]);
        }
    }
    let scale = (BINS as f32 - 1.0) / extent;
    if !(scale > 0.0 && scale < f32::INFINITY) {
        return items.len() / 2;
    }
    let bins = Bins { axis, low: centers.low[axis], scale };
    let best = bins.cheapest(items);
    let mut first = 0;
    for k in 0..items.len() {
        let below = bins.bin(&items[k]) < best;
        items.swap(first, k);
        first += usize::from(below);
    }
    first
}

/// Slabs across an axis, the first around the lowest centre and the last around the highest.
#[derive(Clone, Copy)]
struct Bins {
    axis: usize,
    low: f32,
    scale: f32,
}

impl Bins {
    #[inline(always)]
    fn bin(self, item: &Hull) -> usize {
        nearest((item.center(self.axis) - self.low) * self.scale) as usize % BINS
    }

    /// The first bin of the second part of the cheapest split; a part's cost is its number of
    /// groups times the surface of its hull. The first and the last bin are not empty.
    #[inline(always)]
    fn cheapest(self, items: &[Hull]) -> usize {
        let (mut counts, mut hulls) = ([0_usize; BINS], [Hull::EMPTY; BINS]);
        for item in items {
            let bin = self.bin(item);
            counts[bin] += 1;
            hulls[bin].hold(&item.low, &item.high);
        }
        let mut costs = [0.0; BINS];
        let (mut count, mut hull) = (0, Hull::EMPTY);
        for b in (1..BINS).rev() {
            count += counts[b];
            hull.hold(&hulls[b].low, &hulls[b].high);
            costs[b] = count.div_ceil(LANES_F32) as f32 * hull.half_area();
        }
        (count, hull) = (0, Hull::EMPTY);
        let (mut best, mut least) = (1, f32::INFINITY);
        for b in 1..BINS {
            count += counts[b - 1];
            hull.hold(&hulls[b - 1].low, &hulls[b - 1].high);
            let cost = costs[b] + count.div_ceil(LANES_F32) as f32 * hull.half_area();
            if cost < least {
                (best, least) = (b, cost);
            }
        }
        best
    }
}
