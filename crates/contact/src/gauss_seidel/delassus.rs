use crate::{Answer, Body, Contact, ContactError, DelassusBlocks, Eight};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rapunzel_lanes::LANES;
use std::borrow::Cow;
use std::ops::Range;

/// A number for each of eight points.
type PointLanes = [f64; LANES];

/// What all contacts of some bodies do to each other: how points answer impulses on each other, and their
/// velocities.
#[derive(Debug)]
pub(crate) struct Delassus<'b> {
    patches: Vec<Patch<'b>>,
    /// Velocities of points, patch by patch; the last of them are those of what is not moved.
    velocities: Vec<Eight<f64>>,
    /// By how much each of these has changed, all ways together, since a contact there was looked at;
    /// [`WAITS`] while one is to be, and where there is no point.
    changes: Vec<PointLanes>,
    /// By point of all bodies, if it is touched.
    places: Vec<Option<PatchPoint>>,
}

/// Less than any change.
const WAITS: f64 = f64::NEG_INFINITY;

/// Points that answer each other and no others.
#[derive(Debug)]
struct Patch<'b> {
    /// Where their velocities are.
    own: Range<usize>,
    answers: Cow<'b, DelassusBlocks>,
}

/// A point: its patch, and which of all points it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PatchPoint {
    pub(crate) patch: usize,
    pub(crate) point: usize,
}

impl PatchPoint {
    /// The register of its patch and its place there.
    fn lane(self) -> (usize, usize) {
        (self.point / LANES, self.point % LANES)
    }
}

impl<'b> Delassus<'b> {
    /// Asks every body for three columns per touched point, unless it has them at hand.
    pub(crate) fn new(
        bodies: &'b mut [&mut dyn Body],
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
        let mut start = 0;
        for (index, (body, asked)) in bodies.iter().zip(asked).enumerate() {
            let refused = |why: String| ContactError::Body { body: index, why };
            if let Some((points, matrix)) = asked {
                let answers =
                    DelassusBlocks::new(&matrix).map_err(|error| refused(error.to_string()))?;
                delassus.add(start, &points, Cow::Owned(answers), velocities);
            } else {
                let groups = body.written_out().unwrap_or_default();
                if !each_once(body.points(), &groups) {
                    return Err(refused(
                        "what it writes out is not of each of its points once".into(),
                    ));
                }
                for (points, answers) in groups {
                    delassus.add(start, points, Cow::Borrowed(answers), velocities);
                }
            }
            start += body.points();
        }
        let of_none = DelassusBlocks::new(&DMatrix::zeros(0, 0))?;
        delassus.add(0, &[], Cow::Owned(of_none), &[]);
        delassus.velocities.push([[0.0; LANES]; 3]);
        delassus.changes.push([WAITS; LANES]);
        Ok(delassus)
    }

    /// Adds a patch of points of the body whose points begin at `start`.
    fn add(
        &mut self,
        start: usize,
        points: &[usize],
        answers: Cow<'b, DelassusBlocks>,
        velocities: &[Vector3<f64>],
    ) {
        let count = points.len().div_ceil(LANES);
        let own = self.velocities.len()..self.velocities.len() + count;
        self.velocities.resize(own.end, [[0.0; LANES]; 3]);
        self.changes.resize(own.end, [WAITS; LANES]);
        for (i, point) in points.iter().zip((LANES * own.start)..) {
            let place = PatchPoint { patch: self.patches.len(), point };
            self.places[start + i] = Some(place);
            let (register, lane) = place.lane();
            for axis in 0..3 {
                self.velocities[register][axis][lane] = velocities[start + i][axis];
            }
        }
        self.patches.push(Patch { own, answers });
    }

    /// Where the points of a contact are.
    pub(crate) fn places(&self, contact: &Contact) -> [PatchPoint; 2] {
        let still = PatchPoint {
            patch: self.patches.len() - 1,
            point: LANES * (self.velocities.len() - 1),
        };
        [Some(contact.first), contact.second]
            .map(|point| point.and_then(|i| self.places[i]).unwrap_or(still))
    }

    /// How many points there is room for.
    pub(crate) fn len(&self) -> usize {
        LANES * self.velocities.len()
    }

    /// The contact's own answer, in its frame; zero where both points can only move together.
    pub(crate) fn own_response(&self, contact: &Contact) -> Matrix3<f64> {
        let block = |of: PatchPoint, to: PatchPoint| {
            let Patch { own, answers } = &self.patches[to.patch];
            if of.patch != to.patch || own.is_empty() {
                return Matrix3::zeros();
            }
            let [row, column] = [of, to].map(|place| place.point - LANES * own.start);
            answers.block(row, column)
        };
        let [first, second] = self.places(contact);
        let mut world = block(first, first);
        if contact.second.is_some() {
            let apart = world + block(second, second);
            world = apart - block(first, second) - block(second, first);
            let rounding = self.patches[first.patch].answers.rounding();
            if world.trace() <= rounding * apart.trace() {
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
    pub(crate) fn relative(&self, contact: &Contact, places: [PatchPoint; 2]) -> Vector3<f64> {
        let [first, second] = places.map(|place| {
            let (register, lane) = place.lane();
            let of = &self.velocities[register];
            Vector3::new(of[0][lane], of[1][lane], of[2][lane])
        });
        contact.frame.tr_mul(&(first - second)) + contact.bias
    }

    /// Lets `impulse`, in the contact's frame, act.
    pub(crate) fn apply(&mut self, contact: &Contact, impulse: &Vector3<f64>) {
        self.push(self.places(contact), &(contact.frame * impulse));
    }

    /// Lets an impulse act on the first of two points, and against it on the second.
    #[inline(always)]
    pub(crate) fn push(&mut self, [first, second]: [PatchPoint; 2], impulse: &Vector3<f64>) {
        self.push_one(first, impulse);
        self.push_one(second, &-impulse);
    }

    #[inline(always)]
    fn push_one(&mut self, PatchPoint { patch, point }: PatchPoint, impulse: &Vector3<f64>) {
        let Patch { own, answers } = &self.patches[patch];
        if own.is_empty() {
            return;
        }
        let velocities = &mut self.velocities[own.clone()];
        let changes = &mut self.changes[own.clone()];
        match answers.of(point - LANES * own.start) {
            Answer::Single(columns) => act(columns, impulse, velocities, changes),
            Answer::Double(columns) => act(columns, impulse, velocities, changes),
        }
    }

    /// Adds to `told` which points of a patch have changed by more than a bound, and says that they wait to be
    /// looked at. There must be room for all.
    #[inline(always)]
    pub(crate) fn changed(&mut self, patch: usize, bound: f64, told: &mut [usize]) -> usize {
        let own = self.patches[patch].own.clone();
        let mut count = 0;
        for (register, changes) in own.clone().zip(&mut self.changes[own]) {
            let told = &mut told[count..][..LANES];
            let mut some = 0;
            for lane in 0..LANES {
                // Without a branch, as none could be foreseen.
                let far = changes[lane] > bound;
                told[some & (LANES - 1)] = LANES * register + lane;
                some += usize::from(far);
                changes[lane] = if far { WAITS } else { changes[lane] };
            }
            count += some;
        }
        count
    }

    /// Says that points have been looked at.
    #[inline(always)]
    pub(crate) fn look_at(&mut self, places: [PatchPoint; 2]) {
        for place in places {
            let (register, lane) = place.lane();
            self.changes[register][lane] = 0.0;
        }
    }
}

/// Lets an impulse on a point act on the velocities of all, by what it does along each axis, and adds by how
/// much these change.
#[inline(always)]
fn act<T: Copy + Into<f64>>(
    [a, b, c]: [&[Eight<T>]; 3],
    impulse: &Vector3<f64>,
    velocities: &mut [Eight<f64>],
    changes: &mut [PointLanes],
) {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let size = a.len();
    let (b, c, velocities, changes) =
        (&b[..size], &c[..size], &mut velocities[..size], &mut changes[..size]);
    for i in 0..size {
        let (a, b, c) = (a[i], b[i], c[i]);
        let (mut v, mut most) = (velocities[i], [0.0; LANES]);
        for axis in 0..3 {
            let (a, b, c) = (a[axis], b[axis], c[axis]);
            let change: PointLanes = std::array::from_fn(|lane| {
                a[lane].into() * impulse.x + b[lane].into() * impulse.y + c[lane].into() * impulse.z
            });
            v[axis] = std::array::from_fn(|lane| v[axis][lane] + change[lane]);
            let size = change.map(f64::abs);
            most = std::array::from_fn(|lane| larger(size[lane], most[lane]));
        }
        velocities[i] = v;
        let old = changes[i];
        changes[i] = std::array::from_fn(|lane| old[lane] + most[lane]);
    }
}

/// Whether groups have each of so many points once, and its answers.
fn each_once(count: usize, groups: &[(&[usize], &DelassusBlocks)]) -> bool {
    let mut points: Vec<usize> = groups.iter().flat_map(|(points, _)| *points).copied().collect();
    points.sort_unstable();
    points.into_iter().eq(0..count)
        && groups.iter().all(|(points, answers)| answers.points() == points.len())
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
