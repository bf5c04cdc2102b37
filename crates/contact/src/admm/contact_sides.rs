//! The sides of contacts, sorted by the points they are at.
use crate::Contact;
use rayon::prelude::*;
use std::ops::Range;

/// In place of the second point of a contact that has none.
const NO_POINT: u32 = u32::MAX;

/// Sides of contacts in the order of the points: what is asked of a body is read in one go.
#[derive(Debug, Clone)]
pub(super) struct ContactSides {
    /// First side at each point, and behind the last point the number of sides.
    starts: Vec<usize>,
    /// By side: its contact, and the bits in which the impulse on the side differs from the
    /// contact's impulse on its first point, none or the sign bit.
    contact_and_sign: Vec<[u32; 2]>,
    /// By contact: its first and second side; the number of sides where there is no second.
    by_contact: Vec<[u32; 2]>,
}

impl ContactSides {
    #[expect(clippy::cast_possible_truncation, reason = "so many contacts fit nowhere")]
    pub(super) fn new(contacts: &[Contact], points: usize) -> Self {
        // At first the contacts' points: little of all that a contact is, and read twice.
        let points_of =
            |c: &Contact| [c.first as u32, c.second.map_or(NO_POINT, |point| point as u32)];
        let mut by_contact: Vec<[u32; 2]> = contacts.par_iter().map(points_of).collect();
        // Counting sort by point: counts, their running sums, then every side to its place.
        let mut starts = vec![0; points + 1];
        for &point in by_contact.as_flattened().iter().filter(|&&point| point != NO_POINT) {
            starts[point as usize + 1] += 1;
        }
        for point in 0..points {
            starts[point + 1] += starts[point];
        }
        let mut next = starts.clone();
        let none = starts[points] as u32;
        let mut contact_and_sign = vec![[0; 2]; starts[points]];
        let mut sort = |contact: u32, point: u32, sign: u32| {
            if point == NO_POINT {
                return none;
            }
            let next = &mut next[point as usize];
            contact_and_sign[*next] = [contact, sign];
            *next += 1;
            *next as u32 - 1
        };
        for (i, [first, second]) in (0..).zip(&mut by_contact) {
            (*first, *second) = (sort(i, *first, 0), sort(i, *second, 1 << 31));
        }
        Self { starts, contact_and_sign, by_contact }
    }

    /// Number of sides.
    pub(super) fn len(&self) -> usize {
        self.contact_and_sign.len()
    }

    /// Sides at a point.
    pub(super) fn at_point(&self, point: usize) -> Range<usize> {
        self.starts[point]..self.starts[point + 1]
    }

    /// Sides at a range of points.
    pub(super) fn at_points(&self, points: &Range<usize>) -> Range<usize> {
        self.starts[points.start]..self.starts[points.end]
    }

    /// Contact of a side, and the bits in which components of the impulse on the side differ from
    /// those of the contact's impulse on its first point.
    pub(super) fn contact(&self, side: usize) -> (usize, u64) {
        let [contact, sign] = self.contact_and_sign[side];
        (contact as usize, u64::from(sign) << 32)
    }

    /// First and second side of each of a range of contacts; [`Self::len`] where there is no
    /// second.
    pub(super) fn of_contacts(&self, contacts: &Range<usize>) -> &[[u32; 2]] {
        &self.by_contact[contacts.clone()]
    }
}
