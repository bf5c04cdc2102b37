//! Edges that are joined to strands.

use crate::common::read;
use nalgebra::Point3;
use proptest::prelude::*;
use rapunzel_strands::StrandFault;
use std::fmt::Write;

#[test]
fn edges_become_strands_from_their_lower_end_on() {
    // A path 0-3-1 and one 2-4-5-6, a branch at 8, a ring 11-12-13, an edge to itself, one twice.
    let edges = [
        [3, 0],
        [1, 3],
        [4, 2],
        [5, 4],
        [5, 6],
        [7, 8],
        [8, 9],
        [8, 10],
        [11, 12],
        [12, 13],
        [13, 11],
        [14, 14],
        [5, 4],
    ];
    let mut text = String::new();
    (0..15).for_each(|k| writeln!(text, "v {k} 0 0").expect("memory"));
    for [a, b] in edges {
        writeln!(text, "l {} {}", a + 1, b + 1).expect("memory");
    }
    let file = read(text.as_bytes());
    let x = |k| file.strands.strand(k).iter().map(|p| p.x).collect::<Vec<_>>();
    assert_eq!(x(0), [0.0, 3.0, 1.0]);
    assert_eq!(x(1), [2.0, 4.0, 5.0, 6.0]);
    assert_eq!(file.report.refused, [(2, StrandFault::Branch), (3, StrandFault::Ring)]);
    assert_eq!(file.strands.len(), 2);
}

#[test]
fn lines_of_more_points_are_strands_themselves() {
    let text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nl 3 2 1\nl 2 1\n";
    let file = read(text.as_bytes());
    assert_eq!(file.strands.strand(0)[0], Point3::new(2.0, 0.0, 0.0));
    assert_eq!(file.strands.strand(1), [[1.0, 0.0, 0.0], [0.0; 3]].map(Point3::from));
}

proptest! {
    /// Chains over shuffled points and edges come back whole.
    #[test]
    fn shuffled_chains_are_found(
        lengths in prop::collection::vec(2..9_usize, 1..6),
        seed in any::<u64>(),
    ) {
        let count: usize = lengths.iter().sum();
        let order: Vec<usize> = shuffled(count, seed);
        let (mut edges, mut start) = (Vec::new(), 0);
        for length in &lengths {
            edges.extend((start..start + length - 1).map(|k| [order[k], order[k + 1]]));
            start += length;
        }
        let places = shuffled(edges.len(), seed / 3);
        // The x of a point is its place on the chains.
        let mut at = vec![0; count];
        order.iter().enumerate().for_each(|(place, &point)| at[point] = place);
        let mut text: String = at.iter().map(|x| format!("v {x} 0 0\n")).collect();
        for place in places {
            let [a, b] = edges[place];
            let [a, b] = if (seed >> (place % 64)) & 1 == 1 { [a, b] } else { [b, a] };
            writeln!(text, "l {} {}", a + 1, b + 1).expect("memory");
        }
        let file = read(text.as_bytes());
        prop_assert!(file.report.refused.is_empty());
        let mut found: Vec<usize> = file.strands.iter().map(<[_]>::len).collect();
        let mut expected = lengths.clone();
        found.sort_unstable();
        expected.sort_unstable();
        prop_assert_eq!(found, expected);
        for strand in file.strands.iter() {
            prop_assert!(strand.windows(2).all(|p| (p[1].x - p[0].x).abs() == 1.0));
        }
    }
}

/// The numbers below `count` in an order that depends on `seed`.
fn shuffled(count: usize, seed: u64) -> Vec<usize> {
    let key =
        |k: &usize| (*k as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut all: Vec<usize> = (0..count).collect();
    all.sort_by_key(|k| key(k) >> 20);
    all
}
