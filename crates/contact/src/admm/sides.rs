//! The sides of contacts, sorted by the points they are at.
use crate::Contact;
use std::ops::Range;

/// In the order of the points: what is asked of a body is read in one go.
#[derive(Debug, Clone)]
pub(super) struct Sides {
    /// Where those at each point start; one more than there are points.
    starts: Vec<usize>,
    /// Contact of each, and the sign of its impulse there.
    all: Vec<(u32, f32)>,
    /// Those of each contact; behind the last where it has no second.
    of_contact: Vec<[u32; 2]>,
}

impl Sides {
    #[expect(clippy::cast_possible_truncation, reason = "so many contacts fit nowhere")]
    pub(super) fn new(contacts: &[Contact], points: usize) -> Self {
        let sides = |c: &Contact| [Some((c.first, 1.0)), c.second.map(|point| (point, -1.0))];
        let mut starts = vec![0; points + 1];
        for (point, _) in contacts.iter().flat_map(sides).flatten() {
            starts[point + 1] += 1;
        }
        for point in 0..points {
            starts[point + 1] += starts[point];
        }
        let mut next = starts.clone();
        let none = starts[points] as u32;
        let mut all = vec![(0, 0.0); starts[points]];
        let mut sort = |(i, contact): (usize, &Contact)| {
            sides(contact).map(|side| {
                let Some((point, sign)) = side else { return none };
                let at = next[point];
                all[at] = (i as u32, sign);
                next[point] += 1;
                at as u32
            })
        };
        let of_contact = contacts.iter().enumerate().map(&mut sort).collect();
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

    /// The contact of a side, and the sign of its impulse there.
    pub(super) fn contact(&self, side: usize) -> (usize, f64) {
        let (contact, sign) = self.all[side];
        (contact as usize, f64::from(sign))
    }

    /// The sides of some contacts; behind the last of all where one has no second.
    pub(super) fn of_contacts(&self, contacts: &Range<usize>) -> &[[u32; 2]] {
        &self.of_contact[contacts.clone()]
    }
}
