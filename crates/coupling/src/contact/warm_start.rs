//! Impulses of the step before, from which the search for those of this step starts.

use super::contact_work::ContactWork;
use crate::body_ref::BodyRef;
use crate::contact_point::{ContactImpulse, ContactPoint};
use crate::contact_report::ContactReport;
use crate::held_places::HeldPlace;
use nalgebra::Vector3;
use rayon::prelude::*;

/// The contacts of the last part of a step.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct WarmStart {
    /// Contacts that bore something or are bonded, by pair and place.
    pub(crate) bearing: Vec<CachedImpulse>,
    /// Impulses of joints in the part, N s, and then the moments of impulses of what bends at
    /// them, N m s, world.
    pub(crate) joints: Vec<Vector3<f64>>,
    /// Length of the part, s; `None` before the first.
    pub(crate) dt: Option<f64>,
    /// Work of contacts since the start.
    pub(crate) work: ContactWork,
    /// Report on the whole step.
    pub(crate) report: ContactReport,
}

/// A contact that bore something or is bonded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CachedImpulse {
    pub(crate) push: ContactImpulse,
    /// How far the first side has slipped from where it stuck, m, world.
    drift: Vector3<f64>,
    /// How far aside the first side is pressed by rolling resistance, m, world.
    lean: Vector3<f64>,
    /// Whether it has not slid.
    rests: bool,
    bonded: bool,
}

/// A contact that bore something in the last part of a step, or is bonded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveContact {
    /// What touches. A fibre comes before an object, of two fibres the one with the smaller number,
    /// and of two objects one that moves freely.
    pub sides: [BodyRef; 2],
    /// Where along each side that is a fibre: in segments from the root.
    pub at: [f64; 2],
    /// Where the force acts on the first side, m, world: from the axis of a fibre, or the center of
    /// mass of an object.
    pub lever: Vector3<f64>,
    /// Mean force on the first side over the substep, N, world.
    pub force: Vector3<f64>,
    /// Whether a bond of glue holds it.
    pub bonded: bool,
}

impl WarmStart {
    /// The contacts that bore something or are bonded.
    pub(crate) fn bearings(&self) -> impl Iterator<Item = ActiveContact> {
        let dt = self.dt.unwrap_or(1.0);
        self.bearing.iter().map(move |one| ActiveContact {
            sides: one.push.sides,
            at: one.push.at(),
            lever: one.push.levers[0],
            force: one.push.impulse / dt,
            bonded: one.bonded,
        })
    }
}

/// Numbers of a saved contact.
const CACHED_NUMBERS: usize = 25;
/// Contacts in a list of saved numbers, at most.
const LISTED: usize = 4096;

impl CachedImpulse {
    /// From the axis of a side that is a fibre to where it was touched, m, world.
    pub(crate) fn offset(&self, side: usize) -> Vector3<f64> {
        self.push.levers[side] - self.lean
    }

    fn numbers(&self) -> [f64; CACHED_NUMBERS] {
        let ContactImpulse { sides, segments, fractions, levers: [a, b], impulse, .. } = self.push;
        let [(p, i), (q, j)] = sides.map(|side| match side {
            BodyRef::Fiber(fiber) => (0.0, f64::from(fiber)),
            BodyRef::Object(object) => (1.0, f64::from(object)),
        });
        let [s, t] = segments.map(f64::from);
        let [u, v] = fractions;
        let [rests, bonded] = [self.rests, self.bonded].map(|it| f64::from(u8::from(it)));
        let (x, d, l) = (impulse, self.drift, self.lean);
        [
            p, i, q, j, s, t, u, v, a.x, a.y, a.z, b.x, b.y, b.z, x.x, x.y, x.z, d.x, d.y, d.z,
            l.x, l.y, l.z, rests, bonded,
        ]
    }

    fn from_numbers(numbers: &[f64; CACHED_NUMBERS]) -> Self {
        let [p, i, q, j, s, t, u, v, ax, ay, az, bx, by, bz, x, y, z, rest @ ..] = *numbers;
        let [dx, dy, dz, lx, ly, lz, rests, bonded] = rest;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saved from u32"
        )]
        let whole = |number: f64| number as u32;
        let side = |kind: f64, number: f64| {
            if kind == 0.0 { BodyRef::Fiber(whole(number)) } else { BodyRef::Object(whole(number)) }
        };
        let push = ContactImpulse {
            sides: [side(p, i), side(q, j)],
            segments: [s, t].map(whole),
            fractions: [u, v],
            levers: [Vector3::new(ax, ay, az), Vector3::new(bx, by, bz)],
            impulse: Vector3::new(x, y, z),
            couple: false,
        };
        let (drift, lean) = (Vector3::new(dx, dy, dz), Vector3::new(lx, ly, lz));
        Self { push, drift, lean, rests: rests != 0.0, bonded: bonded != 0.0 }
    }
}

impl WarmStart {
    /// What contacts bear here, of fibres that have these other numbers, which rise.
    pub(crate) fn renumbered(&self, numbers: &[u32]) -> Self {
        let renumber = |one: &CachedImpulse| {
            let mut one = *one;
            for side in &mut one.push.sides {
                if let BodyRef::Fiber(fiber) = side {
                    *fiber = numbers[*fiber as usize];
                }
            }
            one
        };
        let bearing = self.bearing.iter().map(renumber).collect();
        Self { bearing, dt: self.dt, ..Self::default() }
    }

    /// All numbers that determine what follows: those of the whole, then some contacts in each
    /// list.
    pub(crate) fn save(&self) -> impl ExactSizeIterator<Item = Vec<f64>> {
        let (work, lists) = (self.work.numbers(), self.bearing.len().div_ceil(LISTED));
        (0..lists + 1).map(move |list| match list.checked_sub(1) {
            None => {
                // Before the first part joints bear nothing.
                let joints = self.joints.iter().flatten().copied().filter(|_| self.dt.is_some());
                work.into_iter().chain(self.dt).chain(joints).collect()
            }
            Some(list) => {
                let end = self.bearing.len().min((list + 1) * LISTED);
                let own = &self.bearing[list * LISTED..end];
                own.iter().flat_map(CachedImpulse::numbers).collect()
            }
        })
    }

    /// The memory of saved numbers; `None` if these are no memory.
    pub(crate) fn restored(saved: &[Vec<f64>]) -> Option<Self> {
        let (whole, lists) = saved.split_first()?;
        let (work, rest) = whole.split_first_chunk()?;
        let (dt, joints) = rest.split_at(rest.len().min(1));
        let (joints, rest) = joints.as_chunks::<3>();
        if !rest.is_empty() {
            return None;
        }
        let joints = joints.iter().map(|&impulse| impulse.into()).collect();
        let mut bearing = Vec::new();
        for list in lists {
            let (contacts, rest) = list.as_chunks::<CACHED_NUMBERS>();
            bearing.extend(contacts.iter().map(CachedImpulse::from_numbers));
            if !rest.is_empty() {
                return None;
            }
        }
        let (work, report) = (ContactWork::from_numbers(work), ContactReport::default());
        Some(Self { bearing, joints, dt: dt.first().copied(), work, report })
    }
}

/// How far a contact may have moved to be the same, in segments.
const REACH: f64 = 1.0;

/// What contacts of the step before are expected to do in this one.
pub(crate) struct ExpectedImpulses<'a> {
    /// Cached impulses by pair and place.
    pub(crate) known: &'a [CachedImpulse],
    /// Factor of the impulses.
    pub(crate) scale: f64,
}

impl ExpectedImpulses<'_> {
    /// Where fibres rest on objects.
    pub(crate) fn held_places(&self) -> impl Iterator<Item = HeldPlace> {
        self.known.iter().filter(|one| one.rests).filter_map(|one| match one.push.sides {
            [BodyRef::Fiber(fiber), BodyRef::Object(object)] => {
                Some(HeldPlace { pair: [fiber, object], at: one.push.at()[0] })
            }
            _ => None,
        })
    }

    /// The contact of the same pair that is nearest to a contact point, if it may be the same.
    pub(crate) fn nearest(&self, point: &ContactPoint) -> Option<&CachedImpulse> {
        let first = self.known.partition_point(|one| one.push.sides < point.sides);
        let of_pair = self.known[first..].iter().take_while(|one| one.push.sides == point.sides);
        let both = of_pair.map(|one| (point.apart(one.push.at()), one));
        let nearest = both.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.filter(|(apart, _)| *apart < REACH).map(|(_, one)| one)
    }

    pub(crate) fn pushes(&self) -> impl Iterator<Item = ContactImpulse> + Clone {
        self.known
            .iter()
            .map(|one| ContactImpulse { impulse: self.scale * one.push.impulse, ..one.push })
    }
}

/// Gives the impulses and bonds of remembered contacts to the contact points of their pairs that
/// are nearest: what held something still holds it there. Both are sorted by pair and place.
pub(crate) fn match_cached(expected: &ExpectedImpulses, points: &mut [ContactPoint]) {
    let ExpectedImpulses { known, scale } = *expected;
    points.par_chunk_by_mut(|a, b| a.sides == b.sides).for_each(|group| {
        let sides = group[0].sides;
        let known = &known[known.partition_point(|r| r.push.sides < sides)..];
        let of_pair = known.iter().take_while(|r| r.push.sides == sides);
        match_pair(of_pair, scale, group);
    });
}

/// Gives the impulses and bonds of cached contacts of one pair to the nearest of its points.
fn match_pair<'a>(
    known: impl Iterator<Item = &'a CachedImpulse>,
    scale: f64,
    mut group: &mut [ContactPoint],
) {
    for point in &mut *group {
        (point.impulse, point.bonded) = (Vector3::zeros(), false);
        (point.drift, point.lean) = (Vector3::zeros(), Vector3::zeros());
    }
    for one in known {
        let place = one.push.at();
        // Those that come before are out of reach of all that follow.
        let before = group.iter().take_while(|point| point.at()[0] <= place[0] - REACH).count();
        group = &mut group[before..];
        let ahead = group.iter_mut().take_while(|point| point.at()[0] < place[0] + REACH);
        let both = ahead.map(|point| (point.apart(place), point));
        let nearest = both.min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, point)) = nearest.filter(|near| near.0 < REACH) {
            let given = scale * one.push.impulse;
            // Of several it has drifted and leans as they have by what they bear.
            let [own, new] = [point.impulse, given].map(|impulse| impulse.norm());
            if new > 0.0 {
                point.drift = (point.drift * own + one.drift * new) / (own + new);
                point.lean = (point.lean * own + one.lean * new) / (own + new);
            }
            point.impulse += given;
            point.bonded |= one.bonded;
        }
    }
}

/// The impulses that are expected of contact points, N s, world.
pub(crate) fn cached_impulses(
    expected: &ExpectedImpulses,
    points: &[ContactPoint],
) -> Vec<Vector3<f64>> {
    let mut points = points.to_vec();
    match_cached(expected, &mut points);
    points.into_iter().map(|point| point.impulse).collect()
}

/// A bond for each pair of some contact points, where the gap is least, if that is at most `range`,
/// m.
pub(crate) fn bonds_within(points: &[ContactPoint], range: f64) -> Vec<CachedImpulse> {
    let pairs = points.chunk_by(|a, b| a.sides == b.sides);
    let nearest = pairs.filter_map(|pair| pair.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)));
    let bonded = nearest
        .filter(|point| point.gap <= range)
        .map(|point| ContactPoint { bonded: true, ..*point });
    let mut bonds = Vec::new();
    cache_impulses(&bonded.collect::<Vec<_>>(), &mut bonds);
    bonds
}

/// Writes what is to be remembered of some contact points, in their order.
pub(crate) fn cache_impulses(points: &[ContactPoint], remembered: &mut Vec<CachedImpulse>) {
    remembered.clear();
    let lasts = |point: &ContactPoint| point.bonded || point.impulse != Vector3::zeros();
    let lasting: Vec<&ContactPoint> = points.par_iter().filter(|point| lasts(point)).collect();
    // Of a known number each is written where it stays.
    remembered.par_extend(lasting.into_par_iter().map(|point| CachedImpulse {
        push: point.push(point.impulse),
        drift: point.drift,
        lean: point.lean,
        rests: point.rests,
        bonded: point.bonded,
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn remembered(place: f64, push: f64, bonded: bool) -> CachedImpulse {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is small")]
        let segment = place as u32;
        let push = ContactImpulse {
            sides: [BodyRef::Fiber(0), BodyRef::Fiber(1)],
            segments: [segment; 2],
            fractions: [place.fract(); 2],
            levers: [Vector3::zeros(); 2],
            impulse: Vector3::z() * push,
            couple: false,
        };
        let (drift, lean) = (Vector3::x() * place, Vector3::y() * place);
        CachedImpulse { push, drift, lean, rests: false, bonded }
    }

    /// A contact point of which no more is known than what is cached.
    fn point(CachedImpulse { push, drift, lean, rests, bonded }: CachedImpulse) -> ContactPoint {
        let ContactImpulse { sides, segments, fractions, impulse, .. } = push;
        let normal = Vector3::zeros();
        ContactPoint {
            sides,
            segments,
            fractions,
            normal,
            impulse,
            drift,
            lean,
            rests,
            bonded,
            ..ContactPoint::IDLE
        }
    }

    proptest! {
        /// Of all contact points of a pair the nearest gets an impulse, as if every one had been
        /// looked at.
        #[test]
        fn impulses_go_to_the_nearest(
            mut known in prop::collection::vec((0..40_u32, 0..40_u32), 0..20),
            mut places in prop::collection::vec((0..40_u32, 0..40_u32), 1..20),
        ) {
            known.sort_unstable();
            places.sort_unstable();
            let at = |&(s, t): &(u32, u32)| {
                let mut one = remembered(0.0, 1.0, false);
                one.push.segments = [s / 4, t / 4];
                one.push.fractions = [s, t].map(|x| f64::from(x % 4) / 4.0);
                one
            };
            let known: Vec<_> = known.iter().map(at).collect();
            let mut points: Vec<_> = places.iter().map(|place| point(at(place))).collect();
            let mut expected = vec![0.0; points.len()];
            for one in &known {
                let apart = |i: &usize| points[*i].apart(one.push.at());
                let nearest = (0..points.len()).min_by(|i, j| apart(i).total_cmp(&apart(j)));
                if let Some(i) = nearest.filter(|i| apart(i) < REACH) {
                    expected[i] += 1.0;
                }
            }
            match_cached(&ExpectedImpulses { known: &known, scale: 1.0 }, &mut points);
            let found: Vec<f64> = points.iter().map(|point| point.impulse.z).collect();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn saved_contacts_come_back() {
        for rests in [false, true] {
            let one = CachedImpulse { rests, ..remembered(2.5, 3.0, !rests) };
            assert_eq!(CachedImpulse::from_numbers(&one.numbers()), one);
        }
    }

    /// Two of three go to the only contact point that is left near them, one is too far from any.
    #[test]
    fn impulses_of_touches_that_are_gone_go_to_their_neighbours() {
        let known = [(2.0, 1.0, false), (2.5, 2.0, true), (6.0, 4.0, false)];
        let known = known.map(|(place, push, bonded)| remembered(place, push, bonded));
        let mut points = [remembered(2.1, 7.0, false), remembered(4.0, 8.0, true)].map(point);
        match_cached(&ExpectedImpulses { known: &known, scale: 2.0 }, &mut points);
        assert_eq!(points.map(|point| point.impulse.z), [6.0, 0.0]);
        assert_eq!(points.map(|point| point.bonded), [true, false]);
        // They drifted and lean by their places, and the second bore twice as much.
        assert!((points[0].drift.x - 7.0 / 3.0).abs() < 1e-15 && points[1].drift.x == 0.0);
        assert!((points[0].lean.y - 7.0 / 3.0).abs() < 1e-15 && points[1].lean.y == 0.0);
    }
}
