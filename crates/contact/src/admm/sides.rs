//! The sides of contacts, sorted by the points they are at.
use crate::Contact;
use rayon::prelude::*;
use std::ops::Range;

/// In place of the second point of a contact that has none.
const NONE: u32 = u32::MAX;

/// In the order of the points: what is asked of a body is read in one go.
#[derive(Debug, Clone)]
pub(super) struct Sides {
    /// Where those at each point start; one more than there are points.
    starts: Vec<usize>,
    /// Contact of each, and the bits in which its impulse there differs from that on its first point: none, or the
    /// highest.
    all: Vec<[u32; 2]>,
    /// Those of each contact; behind the last where it has no second.
    of_contact: Vec<[u32; 2]>,
}

impl Sides {
    #[expect(clippy::cast_possible_truncation, reason = "so many contacts fit nowhere")]
    pub(super) fn new(contacts: &[Contact], points: usize) -> Self {
        // At first its points: little of all that a contact is, and read twice.
        let points_of = |c: &Contact| [c.first as u32, c.second.map_or(NONE, |point| point as u32)];
        let mut of_contact: Vec<[u32; 2]> = contacts.par_iter().map(points_of).collect();
        let mut starts = vec![0; points + 1];
        for &point in of_contact.as_flattened().iter().filter(|&&point| point != NONE) {
            starts[point as usize + 1] += 1;
        }
        for point in 0..points {
            starts[point + 1] += starts[point];
        }
        let mut next = starts.clone();
        let none = starts[points] as u32;
        let mut all = vec![[0; 2]; starts[points]];
        let mut sort = |contact: u32, point: u32, sign: u32| {
            if point == NONE {
                return none;
            }
            let next = &mut next[point as usize];
            all[*next] = [contact, sign];
            *next += 1;
            *next as u32 - 1
        };
        for (i, [first, second]) in (0..).zip(&mut of_contact) {
            (*first, *second) = (sort(i, *first, 0), sort(i, *second, 1 << 31));
        }
        Self { starts, all, of_contact }
    }

    pub(super) fn len(&self) -> usize {
        self.all.len()
    }

    /// Those at a point.
    pub(super) fn at(&self, point: usize) -> Range<usize> {
        self.starts[point]..self.starts[point + 1]
    }

    /// Those at some points.
    pub(super) fn of(&self, points: &Range<usize>) -> Range<usize> {
        self.starts[points.start]..self.starts[points.end]
    }

    /// The contact of a side, and the bits in which numbers of its impulse there differ from those on the
    /// contact's first point.
    pub(super) fn contact(&self, side: usize) -> (usize, u64) {
        let [contact, sign] = self.all[side];
        (contact as usize, u64::from(sign) << 32)
    }

    /// The sides of some contacts; behind the last of all where one has no second.
    pub(super) fn of_contacts(&self, contacts: &Range<usize>) -> &[[u32; 2]] {
        &self.of_contact[contacts.clone()]
    }
}
