//! Boxes around the chords of rods, by which those that are far from each other are passed over.

use nalgebra::Vector3;
use rapunzel_collision::Capsule;
use std::ops::Range;

/// Chords in a box.
const BLOCK: usize = 8;

/// The chords of a rod in boxes.
pub(super) struct ChordBoxes(Vec<ChordBox>);

/// A box around the axes of chords that follow each other.
struct ChordBox {
    chords: Range<usize>,
    low: Vector3<f64>,
    high: Vector3<f64>,
    /// Largest radius, m.
    radius: f64,
}

impl ChordBoxes {
    /// Boxes around chords.
    pub(super) fn of(chords: &[Capsule]) -> Self {
        Self::swept(chords, chords)
    }

    /// Boxes around chords and all that they pass on straight ways to where they are then.
    pub(super) fn swept(from: &[Capsule], to: &[Capsule]) -> Self {
        let blocks = from.chunks(BLOCK).zip(to.chunks(BLOCK)).enumerate();
        let boxed = |(block, (from, to)): (usize, (&[Capsule], &[Capsule]))| {
            let capsules = || from.iter().chain(to);
            let ends = || capsules().flat_map(|one| [one.start.coords, one.end.coords]);
            ChordBox {
                chords: block * BLOCK..block * BLOCK + from.len(),
                low: ends().fold(Vector3::repeat(f64::INFINITY), |low, end| low.inf(&end)),
                high: ends().fold(Vector3::repeat(f64::NEG_INFINITY), |high, end| high.sup(&end)),
                radius: capsules().map(|one| one.radius).fold(0.0, f64::max),
            }
        };
        Self(blocks.map(boxed).collect())
    }

    /// Pairs of a chord here and one of another rod, all of those among them whose axes are no
    /// farther apart than `reach` times the sum of their radii. Cost: a look at all pairs of boxes.
    pub(super) fn pairs(&self, other: &Self, reach: f64) -> impl Iterator<Item = [usize; 2]> {
        let boxes = self.0.iter().flat_map(|one| other.0.iter().map(move |two| (one, two)));
        let near = boxes.filter(move |(one, two)| {
            let apart = (one.low - two.high).sup(&(two.low - one.high)).sup(&Vector3::zeros());
            let most = reach * (one.radius + two.radius);
            apart.norm_squared() <= most * most
        });
        near.flat_map(|(one, two)| {
            let others = two.chords.clone();
            one.chords.clone().flat_map(move |i| others.clone().map(move |j| [i, j]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    /// Two helices beside each other: no pair within reach is passed over, most of the others are.
    #[test]
    fn no_near_pair_is_passed_over() {
        let rod = |aside: f64| -> Vec<Capsule> {
            let node = |i: u32| {
                let angle = 0.1 * f64::from(i);
                Point3::new(aside + angle.cos(), angle.sin(), 0.05 * angle)
            };
            let chord = |i| Capsule { start: node(i), end: node(i + 1), radius: 0.01 };
            (0..300).map(chord).collect()
        };
        let (ones, others) = (rod(0.0), rod(0.7));
        let found: Vec<_> = ChordBoxes::of(&ones).pairs(&ChordBoxes::of(&others), 3.0).collect();
        let mut near = 0;
        for (i, one) in ones.iter().enumerate() {
            for (j, two) in others.iter().enumerate() {
                if one.closest(two).distance() <= 0.06 {
                    near += 1;
                    assert!(found.contains(&[i, j]), "{i} {j}");
                }
            }
        }
        assert!(near > 10 && found.len() < ones.len() * others.len() / 4, "{near} {}", found.len());
    }
}
