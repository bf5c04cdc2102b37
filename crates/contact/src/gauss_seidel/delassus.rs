use crate::{Body, Contact, ContactError};
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::borrow::Cow;
use std::ops::Range;

/// What all contacts of some bodies do to each other: how points answer impulses on each other, and their
/// velocities.
#[derive(Debug)]
pub(crate) struct Delassus<'a> {
    patches: Vec<Patch<'a>>,
    /// Velocities of points, patch by patch.
    velocities: Vec<[f64; 3]>,
    /// By how much each number of these has changed, all ways together, since a contact there was looked at;
    /// [`WAITS`] while one is to be.
    changes: Vec<[f64; 3]>,
    /// By point of all bodies, if it is touched.
    places: Vec<Option<Place>>,
}

/// Less than any change.
const WAITS: f64 = f64::NEG_INFINITY;

/// What is left of the answers of two points less than this, relative to them, is rounding.
const ROUNDING: f64 = 1e-13;

/// Points that answer each other and no others.
#[derive(Debug)]
struct Patch<'a> {
    /// Which points.
    own: Range<usize>,
    matrix: Cow<'a, DMatrix<f64>>,
}

/// A point: its patch, and which of all points it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) patch: usize,
    pub(crate) point: usize,
}

impl<'a> Delassus<'a> {
    /// Asks every body for three columns per touched point, unless it has them at hand.
    pub(crate) fn new(
        bodies: &'a mut [&mut dyn Body],
        contacts: &[Contact],
        velocities: &[Vector3<f64>],
    ) -> Result<Self, ContactError> {
        let points = bodies.iter().map(|body| body.points()).sum();
        if velocities.len() != points {
            return Err(ContactError::Length {
                what: "velocities of points",
                expected: points,
                found: velocities.len(),
            });
        }
        finite("component of a velocity", velocities)?;
        let mut touched = vec![false; points];
        for (index, contact) in contacts.iter().enumerate() {
            contact.validate(index, points)?;
            touched[contact.first] = true;
            if let Some(second) = contact.second {
                touched[second] = true;
            }
        }
        let mut rest = &touched[..];
        let mut asked = Vec::with_capacity(bodies.len());
        for body in &mut *bodies {
            let (own, behind) = rest.split_at(body.points());
            rest = behind;
            let unknown = body.written_out().is_none();
            let touched = || (0..own.len()).filter(|&i| own[i]).collect();
            asked.push(unknown.then(|| ask(&mut **body, touched())));
        }
        let mut delassus = Self {
            patches: Vec::new(),
            velocities: Vec::new(),
            changes: Vec::new(),
            places: vec![None; points],
        };
        let bodies: &'a [&mut dyn Body] = bodies;
        let mut start = 0;
        for (index, (body, asked)) in bodies.iter().zip(asked).enumerate() {
            let before = delassus.patches.len();
            if let Some((points, matrix)) = asked {
                delassus.add(start, &points, Cow::Owned(matrix), velocities);
            } else {
                let groups = body.written_out().unwrap_or_default();
                if !each_once(body.points(), &groups) {
                    let why = "what it writes out is not of each of its points once".into();
                    return Err(ContactError::Body { body: index, why });
                }
                for (points, matrix) in groups {
                    delassus.add(start, points, Cow::Borrowed(matrix), velocities);
                }
            }
            let finite = |patch: &Patch| patch.matrix.iter().all(|x| x.is_finite());
            if !delassus.patches[before..].iter().all(finite) {
                let why = "its answer is not finite".into();
                return Err(ContactError::Body { body: index, why });
            }
            start += body.points();
        }
        delassus.changes = vec![[WAITS; 3]; delassus.velocities.len()];
        Ok(delassus)
    }

    /// Adds a patch of points of the body whose points begin at `start`.
    fn add(
        &mut self,
        start: usize,
        points: &[usize],
        matrix: Cow<'a, DMatrix<f64>>,
        velocities: &[Vector3<f64>],
    ) {
        let own = self.velocities.len()..self.velocities.len() + points.len();
        for (i, point) in points.iter().zip(own.clone()) {
            self.places[start + i] = Some(Place { patch: self.patches.len(), point });
            self.velocities.push(velocities[start + i].into());
        }
        self.patches.push(Patch { own, matrix });
    }

    /// Where the points of a contact are.
    pub(crate) fn places(&self, contact: &Contact) -> [Option<Place>; 2] {
        [Some(contact.first), contact.second].map(|point| point.and_then(|i| self.places[i]))
    }

    /// How many points there are.
    pub(crate) fn len(&self) -> usize {
        self.velocities.len()
    }

    /// The contact's own answer, in its frame; zero where both points can only move together.
    pub(crate) fn own_response(&self, contact: &Contact) -> Matrix3<f64> {
        let block = |of: Option<Place>, to: Option<Place>| match (of, to) {
            (Some(of), Some(to)) if of.patch == to.patch => {
                let Patch { own, matrix } = &self.patches[of.patch];
                let [row, column] = [of, to].map(|place| 3 * (place.point - own.start));
                matrix.fixed_view::<3, 3>(row, column).into_owned()
            }
            _ => Matrix3::zeros(),
        };
        let [first, second] = self.places(contact);
        let mut world = block(first, first);
        if second.is_some() {
            let apart = world + block(second, second);
            world = apart - block(first, second) - block(second, first);
            if world.trace() <= ROUNDING * apart.trace() {
                return Matrix3::zeros();
            }
        }
        let local = contact.frame.transpose() * world * contact.frame;
        0.5 * (local + local.transpose())
    }

    /// Velocity of the first point relative to the second, in the contact's frame, and its bias.
    pub(crate) fn relative_velocity(&self, contact: &Contact) -> Vector3<f64> {
        self.relative(contact, self.places(contact))
    }

    /// The same, by where the points of the contact are.
    #[inline(always)]
    pub(crate) fn relative(
        &self,
        contact: &Contact,
        [first, second]: [Option<Place>; 2],
    ) -> Vector3<f64> {
        let velocity = |place: Option<Place>| {
            place.map_or_else(Vector3::zeros, |place| self.velocities[place.point].into())
        };
        contact.frame.tr_mul(&(velocity(first) - velocity(second))) + contact.bias
    }

    /// Lets `impulse`, in the contact's frame, act.
    pub(crate) fn apply(&mut self, contact: &Contact, impulse: &Vector3<f64>) {
        self.push(self.places(contact), &(contact.frame * impulse));
    }

    /// Lets an impulse act on the first of two points, and against it on the second.
    #[inline(always)]
    pub(crate) fn push(&mut self, [first, second]: [Option<Place>; 2], impulse: &Vector3<f64>) {
        if let Some(place) = first {
            self.push_one(place, impulse);
        }
        if let Some(place) = second {
            self.push_one(place, &-impulse);
        }
    }

    #[inline(always)]
    fn push_one(&mut self, Place { patch, point }: Place, impulse: &Vector3<f64>) {
        let Patch { own, matrix } = &self.patches[patch];
        let size = 3 * own.len();
        let columns = &matrix.as_slice()[3 * (point - own.start) * size..][..3 * size];
        let (a, rest) = columns.split_at(size);
        let (b, c) = rest.split_at(size);
        let velocities = &mut self.velocities[own.clone()].as_flattened_mut()[..size];
        let changes = &mut self.changes[own.clone()].as_flattened_mut()[..size];
        for i in 0..size {
            let change = a[i] * impulse.x + b[i] * impulse.y + c[i] * impulse.z;
            velocities[i] += change;
            changes[i] += change.abs();
        }
    }

    /// Tells which points of a patch have changed by more than a bound, and says that they wait to be looked at.
    #[inline(always)]
    pub(crate) fn changed(&mut self, patch: usize, bound: f64, mut tell: impl FnMut(usize)) {
        let own = self.patches[patch].own.clone();
        let mut point = own.start;
        let (some, rest) = self.changes[own].as_chunks_mut::<8>();
        for some in some.iter_mut().map(|some| &mut some[..]).chain([rest]) {
            // Without a branch for each, as most have not.
            let mut any = false;
            for change in some.as_flattened() {
                any |= *change > bound;
            }
            if any {
                for (point, change) in (point..).zip(&mut *some) {
                    if change[0] > bound || change[1] > bound || change[2] > bound {
                        *change = [WAITS; 3];
                        tell(point);
                    }
                }
            }
            point += some.len();
        }
    }

    /// Says that points have been looked at.
    #[inline(always)]
    pub(crate) fn look_at(&mut self, places: [Option<Place>; 2]) {
        for place in places.into_iter().flatten() {
            self.changes[place.point] = [0.0; 3];
        }
    }
}

/// Whether groups have each of so many points once, and three rows and columns for it.
fn each_once(count: usize, groups: &[(&[usize], &DMatrix<f64>)]) -> bool {
    let mut points: Vec<usize> = groups.iter().flat_map(|(points, _)| *points).copied().collect();
    points.sort_unstable();
    let square = |size: usize| (3 * size, 3 * size);
    points.into_iter().eq(0..count)
        && groups.iter().all(|(points, matrix)| matrix.shape() == square(points.len()))
}

/// Asks a body how some of its points answer each other.
fn ask(body: &mut dyn Body, points: Vec<usize>) -> (Vec<usize>, DMatrix<f64>) {
    let mut impulses = vec![Vector3::zeros(); body.points()];
    let mut answer = impulses.clone();
    let mut matrix = DMatrix::zeros(3 * points.len(), 3 * points.len());
    for (place, &point) in points.iter().enumerate() {
        for axis in 0..3 {
            impulses[point][axis] = 1.0;
            body.respond(&impulses, &mut answer);
            impulses[point][axis] = 0.0;
            for (row, &i) in points.iter().enumerate() {
                matrix.fixed_view_mut::<3, 1>(3 * row, 3 * place + axis).copy_from(&answer[i]);
            }
        }
    }
    (points, matrix)
}

/// # Errors
/// [`ContactError::Invalid`] for a component that is not finite.
pub(crate) fn finite(what: &'static str, vectors: &[Vector3<f64>]) -> Result<(), ContactError> {
    match vectors.iter().flat_map(|v| v.iter()).find(|x| !x.is_finite()) {
        Some(&value) => Err(ContactError::Invalid { what, value, why: "it must be finite" }),
        None => Ok(()),
    }
}
