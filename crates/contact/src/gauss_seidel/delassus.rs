use crate::{Body, Contact, ContactError, DelassusBlocks, UnitResponse, VectorLanes};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rapunzel_lanes::LANES;
use std::borrow::Cow;
use std::ops::Range;

/// A number for each of eight points.
type PointLanes = [f64; LANES];

/// Delassus operator of all touched points of some bodies, and their velocities as impulses act.
#[derive(Debug)]
pub(crate) struct Delassus<'b> {
    patches: Vec<PointPatch<'b>>,
    /// Velocities of points, patch by patch, m/s, world; the last register is of what is not moved.
    velocities: Vec<VectorLanes<f64>>,
    /// Change of each velocity since a contact there was looked at, summed over all impulses, m/s;
    /// [`WAITS`] while a contact is to be looked at, and where there is no point.
    changes: Vec<PointLanes>,
    /// Place of each point of all bodies; `None` where it is not touched.
    places: Vec<Option<PatchPoint>>,
}

/// Change of a velocity that stays less than any bound, m/s.
const WAITS: f64 = f64::NEG_INFINITY;

/// Points that answer each other and no others.
#[derive(Debug)]
struct PointPatch<'b> {
    /// Registers of the points' velocities.
    registers: Range<usize>,
    /// Operator of the points, dense.
    blocks: Cow<'b, DelassusBlocks>,
}

/// A point: its patch, and its number among all places for points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PatchPoint {
    /// Index of the patch.
    pub(crate) patch: usize,
    /// Number among all places for points, lane by lane of all registers.
    pub(crate) point: usize,
}

impl PatchPoint {
    /// Register among those of all patches, and lane in it.
    fn lane(self) -> (usize, usize) {
        (self.point / LANES, self.point % LANES)
    }
}

impl<'b> Delassus<'b> {
    /// Operator of the `bodies` at the points that the `contacts` touch, with the `velocities` of
    /// all points, m/s, world. Asks every body for three columns per touched point, unless its
    /// operator is at hand.
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
        check_finite("component of a velocity", velocities)?;
        let mut touched = vec![false; points];
        for (index, contact) in contacts.iter().enumerate() {
            contact.validate(index, points)?;
            touched[contact.first] = true;
            if let Some(second) = contact.second {
                touched[second] = true;
            }
        }
        // Columns of bodies without a dense operator, by unit impulses.
        let mut rest = &touched[..];
        let mut asked = Vec::with_capacity(bodies.len());
        for body in &mut *bodies {
            let (own, behind) = rest.split_at(body.points());
            rest = behind;
            let unknown = body.dense_delassus().is_none();
            let touched = || (0..own.len()).filter(|&i| own[i]).collect();
            asked.push(unknown.then(|| ask_columns(&mut **body, touched())));
        }
        let mut delassus = Self {
            patches: Vec::new(),
            velocities: Vec::new(),
            changes: Vec::new(),
            places: vec![None; points],
        };
        // Patches of points that answer each other, with their velocities.
        let mut start = 0;
        for (index, (body, asked)) in bodies.iter().zip(asked).enumerate() {
            let refused = |why: String| ContactError::Body { body: index, why };
            if let Some((points, matrix)) = asked {
                let blocks =
                    DelassusBlocks::new(&matrix).map_err(|error| refused(error.to_string()))?;
                delassus.add(start, &points, Cow::Owned(blocks), velocities);
            } else {
                let groups = body.dense_delassus().unwrap_or_default();
                if !each_once(body.points(), &groups) {
                    return Err(refused(
                        "what it writes out is not of each of its points once".into(),
                    ));
                }
                for (points, blocks) in groups {
                    delassus.add(start, points, Cow::Borrowed(blocks), velocities);
                }
            }
            start += body.points();
        }
        // The patch of what is not moved: no points, and a velocity of zero.
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
        blocks: Cow<'b, DelassusBlocks>,
        velocities: &[Vector3<f64>],
    ) {
        let count = points.len().div_ceil(LANES);
        let registers = self.velocities.len()..self.velocities.len() + count;
        self.velocities.resize(registers.end, [[0.0; LANES]; 3]);
        self.changes.resize(registers.end, [WAITS; LANES]);
        for (i, point) in points.iter().zip((LANES * registers.start)..) {
            let place = PatchPoint { patch: self.patches.len(), point };
            self.places[start + i] = Some(place);
            let (register, lane) = place.lane();
            for axis in 0..3 {
                self.velocities[register][axis][lane] = velocities[start + i][axis];
            }
        }
        self.patches.push(PointPatch { registers, blocks });
    }

    /// Places of the points of a contact.
    pub(crate) fn places(&self, contact: &Contact) -> [PatchPoint; 2] {
        let still = PatchPoint {
            patch: self.patches.len() - 1,
            point: LANES * (self.velocities.len() - 1),
        };
        [Some(contact.first), contact.second]
            .map(|point| point.and_then(|i| self.places[i]).unwrap_or(still))
    }

    /// Number of places for points.
    pub(crate) fn len(&self) -> usize {
        LANES * self.velocities.len()
    }

    /// Diagonal block of a contact, 1/kg, in its frame: the answer of its relative velocity to its
    /// own impulse, `W_11 + W_22 - W_12 - W_21`; zero where both points can only move together.
    pub(crate) fn own_response(&self, contact: &Contact) -> Matrix3<f64> {
        // W_ij of two points; zero where they are in different patches.
        let block = |of: PatchPoint, to: PatchPoint| {
            let PointPatch { registers, blocks } = &self.patches[to.patch];
            if of.patch != to.patch || registers.is_empty() {
                return Matrix3::zeros();
            }
            let [row, column] = [of, to].map(|place| place.point - LANES * registers.start);
            blocks.block(row, column)
        };
        let [first, second] = self.places(contact);
        let mut world = block(first, first);
        if contact.second.is_some() {
            let apart = world + block(second, second);
            world = apart - block(first, second) - block(second, first);
            let rounding = self.patches[first.patch].blocks.relative_rounding();
            if world.trace() <= rounding * apart.trace() {
                return Matrix3::zeros();
            }
        }
        // In the contact's frame, symmetric to the last bit.
        let local = contact.frame.transpose() * world * contact.frame;
        0.5 * (local + local.transpose())
    }

    /// Velocity of a contact's first point relative to the second, m/s, in its frame, bias
    /// included.
    pub(crate) fn relative_velocity(&self, contact: &Contact) -> Vector3<f64> {
        self.relative_at(contact, self.places(contact))
    }

    /// Velocity of a contact's first point relative to the second, m/s, in its frame, bias
    /// included, by the places of the points.
    #[inline(always)]
    pub(crate) fn relative_at(&self, contact: &Contact, places: [PatchPoint; 2]) -> Vector3<f64> {
        let [first, second] = places.map(|place| {
            let (register, lane) = place.lane();
            let [x, y, z] = &self.velocities[register];
            Vector3::new(x[lane], y[lane], z[lane])
        });
        contact.frame.tr_mul(&(first - second)) + contact.bias
    }

    /// Lets `impulse`, N s, in the contact's frame, act.
    pub(crate) fn apply(&mut self, contact: &Contact, impulse: &Vector3<f64>) {
        self.push(self.places(contact), &(contact.frame * impulse));
    }

    /// Lets an impulse, N s, world, act on the first of two points, and its opposite on the second.
    #[inline(always)]
    pub(crate) fn push(&mut self, [first, second]: [PatchPoint; 2], impulse: &Vector3<f64>) {
        self.push_one(first, impulse);
        self.push_one(second, &-impulse);
    }

    #[inline(always)]
    fn push_one(&mut self, PatchPoint { patch, point }: PatchPoint, impulse: &Vector3<f64>) {
        let PointPatch { registers, blocks } = &self.patches[patch];
        if registers.is_empty() {
            return;
        }
        let velocities = &mut self.velocities[registers.clone()];
        let changes = &mut self.changes[registers.clone()];
        match blocks.response_to(point - LANES * registers.start) {
            UnitResponse::Single(columns) => add_response(columns, impulse, velocities, changes),
            UnitResponse::Double(columns) => add_response(columns, impulse, velocities, changes),
        }
    }

    /// Writes into `changed` the points of a patch whose velocities have changed by more than a
    /// bound, m/s, notes that they wait to be looked at, and returns their number. `changed` must
    /// have a place for every point.
    #[inline(always)]
    pub(crate) fn changed_points(
        &mut self,
        patch: usize,
        bound: f64,
        changed: &mut [usize],
    ) -> usize {
        let registers = self.patches[patch].registers.clone();
        let mut count = 0;
        for (register, changes) in registers.clone().zip(&mut self.changes[registers]) {
            let changed = &mut changed[count..][..LANES];
            let mut some = 0;
            for lane in 0..LANES {
                // Without a branch, as none could be foreseen.
                let far = changes[lane] > bound;
                changed[some & (LANES - 1)] = LANES * register + lane;
                some += usize::from(far);
                changes[lane] = if far { WAITS } else { changes[lane] };
            }
            count += some;
        }
        count
    }

    /// Notes that contacts at points have been looked at.
    #[inline(always)]
    pub(crate) fn look_at(&mut self, places: [PatchPoint; 2]) {
        for place in places {
            let (register, lane) = place.lane();
            self.changes[register][lane] = 0.0;
        }
    }
}

/// Adds to the velocities of all points what an impulse on one causes, by its columns along each
/// axis, and to the changes the largest component of what was added.
#[inline(always)]
fn add_response<T: Copy + Into<f64>>(
    [a, b, c]: [&[VectorLanes<T>]; 3],
    impulse: &Vector3<f64>,
    velocities: &mut [VectorLanes<f64>],
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

/// Whether groups have each of `count` points once, and blocks of as many points as they have.
fn each_once(count: usize, groups: &[(&[usize], &DelassusBlocks)]) -> bool {
    let mut points: Vec<usize> = groups.iter().flat_map(|(points, _)| *points).copied().collect();
    points.sort_unstable();
    points.into_iter().eq(0..count)
        && groups.iter().all(|(points, blocks)| blocks.points() == points.len())
}

/// Dense operator of some points of a body, 1/kg, by unit impulses along each axis.
fn ask_columns(body: &mut dyn Body, points: Vec<usize>) -> (Vec<usize>, DMatrix<f64>) {
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

/// Refuses vectors with components that are not finite.
///
/// # Errors
/// [`ContactError::Invalid`] for a component that is not finite.
pub(crate) fn check_finite(
    what: &'static str,
    vectors: &[Vector3<f64>],
) -> Result<(), ContactError> {
    match vectors.iter().flat_map(|v| v.iter()).find(|x| !x.is_finite()) {
        Some(&value) => Err(ContactError::Invalid { what, value, why: "it must be finite" }),
        None => Ok(()),
    }
}
