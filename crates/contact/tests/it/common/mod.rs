//! What the integration tests share: small bodies with dense answers, random numbers.
pub(crate) mod incline;

use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};
use rapunzel_contact::{
    Body, Contact, ContactError, DelassusBlocks, GaussSeidel, LimitCurve, Report, Solver,
    Tolerance, Violation,
};

pub(crate) const G: f64 = 9.81;

/// A body with few coordinates: `mobility` is the inverse of its mass matrix (singular where
/// coordinates are constrained), `jacobian` maps its velocities to those of its points.
#[derive(Debug, Clone)]
pub(crate) struct Dense {
    pub(crate) mobility: DMatrix<f64>,
    pub(crate) jacobian: DMatrix<f64>,
    pub(crate) velocity: DVector<f64>,
    /// Answer without weights, `H A^-1 H^T`, 1/kg.
    bare: DMatrix<f64>,
    /// Answer with weights, 1/kg.
    response: DMatrix<f64>,
    /// Points and dense operator, if the body is to have one at hand.
    written: Option<(Vec<usize>, DelassusBlocks)>,
}

impl Dense {
    pub(crate) fn new(mobility: DMatrix<f64>, jacobian: DMatrix<f64>) -> Self {
        let bare = &jacobian * &mobility * jacobian.transpose();
        let velocity = DVector::zeros(mobility.nrows());
        Self { mobility, jacobian, velocity, response: bare.clone(), bare, written: None }
    }

    /// This body with its dense operator at hand.
    pub(crate) fn written(self) -> Self {
        let answers = DelassusBlocks::new(&self.bare).expect("a square of finite numbers");
        Self { written: Some(((0..self.points()).collect(), answers)), ..self }
    }

    pub(crate) fn particle(mass: f64) -> Self {
        Self::new(DMatrix::identity(3, 3) / mass, DMatrix::identity(3, 3))
    }

    /// A rigid body: velocities of the center of mass and angular ones, inertia in the world frame,
    /// points by their offset from the center of mass.
    pub(crate) fn rigid(mass: f64, inertia: &Matrix3<f64>, offsets: &[Vector3<f64>]) -> Self {
        let mut mobility = DMatrix::zeros(6, 6);
        mobility.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() / mass));
        mobility.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia.try_inverse().expect("regular"));
        let mut jacobian = DMatrix::zeros(3 * offsets.len(), 6);
        for (i, offset) in offsets.iter().enumerate() {
            jacobian.fixed_view_mut::<3, 3>(3 * i, 0).copy_from(&Matrix3::identity());
            jacobian.fixed_view_mut::<3, 3>(3 * i, 3).copy_from(&-offset.cross_matrix());
        }
        Self::new(mobility, jacobian)
    }

    pub(crate) fn sphere(mass: f64, radius: f64, directions: &[Vector3<f64>]) -> Self {
        let inertia = Matrix3::from_diagonal_element(0.4 * mass * radius * radius);
        let offsets: Vec<_> = directions.iter().map(|d| d * radius).collect();
        Self::rigid(mass, &inertia, &offsets)
    }

    /// A thin rod along `axis` (unit) with points at the given distances from its middle.
    pub(crate) fn rod(mass: f64, length: f64, axis: &Vector3<f64>, places: &[f64]) -> Self {
        let thin = Matrix3::identity() - axis * axis.transpose() * (1.0 - 1e-9);
        let offsets: Vec<_> = places.iter().map(|s| axis * *s).collect();
        Self::rigid(mass, &(thin * (mass * length * length / 12.0)), &offsets)
    }

    /// Takes away the velocities that `constraints` (rows) forbid.
    pub(crate) fn constrained(self, constraints: &DMatrix<f64>) -> Self {
        let columns = &self.mobility * constraints.transpose();
        let inverse = (constraints * &columns).try_inverse().expect("independent constraints");
        Self::new(&self.mobility - &columns * inverse * columns.transpose(), self.jacobian)
    }

    pub(crate) fn velocities(&self) -> Vec<Vector3<f64>> {
        vectors(&(&self.jacobian * &self.velocity))
    }

    /// Lets impulses on the points act.
    pub(crate) fn apply(&mut self, impulses: &[Vector3<f64>]) {
        self.velocity += &self.mobility * self.jacobian.transpose() * stacked(impulses);
    }

    /// Lets an impulse on the coordinates act.
    pub(crate) fn push(&mut self, impulse: &[f64]) {
        self.velocity += &self.mobility * DVector::from_row_slice(impulse);
    }

    pub(crate) fn kinetic_energy(&self) -> f64 {
        let mass = self.mobility.clone().try_inverse().expect("no constraints");
        0.5 * self.velocity.dot(&(mass * &self.velocity))
    }
}

impl Body for Dense {
    fn points(&self) -> usize {
        self.jacobian.nrows() / 3
    }

    fn set_weights(&mut self, weights: &[f64]) -> Result<(), ContactError> {
        let bare = &self.bare;
        self.response.copy_from(bare);
        if weights.iter().any(|weight| *weight > 0.0) {
            let masses = DMatrix::from_fn(bare.nrows(), bare.nrows(), |i, j| {
                if i == j { weights[i / 3] } else { 0.0 }
            });
            let system = DMatrix::identity(bare.nrows(), bare.nrows()) + bare * masses;
            self.response = system.lu().solve(bare).ok_or_else(|| ContactError::Body {
                body: 0,
                why: "the answer with weights is singular".into(),
            })?;
        }
        Ok(())
    }

    fn respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        velocities.copy_from_slice(&vectors(&(&self.bare * stacked(impulses))));
    }

    fn weighted_respond(&mut self, impulses: &[Vector3<f64>], velocities: &mut [Vector3<f64>]) {
        velocities.copy_from_slice(&vectors(&(&self.response * stacked(impulses))));
    }

    fn own_traces(&mut self, traces: &mut [f64]) {
        for (i, trace) in traces.iter_mut().enumerate() {
            *trace = self.bare.fixed_view::<3, 3>(3 * i, 3 * i).trace();
        }
    }

    fn dense_delassus(&self) -> Option<Vec<(&[usize], &DelassusBlocks)>> {
        self.written.as_ref().map(|(points, answers)| vec![(&points[..], answers)])
    }
}

fn stacked(vectors: &[Vector3<f64>]) -> DVector<f64> {
    DVector::from_iterator(3 * vectors.len(), vectors.iter().flat_map(|v| v.iter().copied()))
}

fn vectors(stacked: &DVector<f64>) -> Vec<Vector3<f64>> {
    stacked.as_slice().chunks_exact(3).map(Vector3::from_column_slice).collect()
}

/// A contact of point `first` with something fixed, or with point `second`; `t1` is chosen.
pub(crate) fn contact(
    first: usize,
    second: Option<usize>,
    normal: &Vector3<f64>,
    friction: LimitCurve,
) -> Contact {
    let help = if normal.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    along(first, second, normal, &help, friction)
}

/// A contact with `t1` along `axis`, as far as that is at a right angle to the normal.
pub(crate) fn along(
    first: usize,
    second: Option<usize>,
    normal: &Vector3<f64>,
    axis: &Vector3<f64>,
    friction: LimitCurve,
) -> Contact {
    let normal = normal.normalize();
    let t1 = (axis - normal * normal.dot(axis)).normalize();
    Contact {
        first,
        second,
        frame: Matrix3::from_columns(&[normal, t1, normal.cross(&t1)]),
        bias: Vector3::zeros(),
        friction,
        adhesion: 0.0,
        compliance: 0.0,
    }
}

pub(crate) fn circle(mu: f64) -> LimitCurve {
    LimitCurve::Circle { mu }
}

/// A solver that only stops at what rounding leaves.
pub(crate) fn exact() -> GaussSeidel {
    to(1e-12, 1e-12, 20_000)
}

/// A solver that stops at a residual and an error of velocities, m/s, or after so many iterations.
pub(crate) fn to(residual: f64, velocity: f64, iterations: usize) -> GaussSeidel {
    GaussSeidel::new(Tolerance { residual, normal: velocity, slip: velocity, iterations })
}

/// Solves the contacts from `impulses` and lets the impulses act on the bodies.
pub(crate) fn resolve(
    bodies: &mut [Dense],
    contacts: &[Contact],
    impulses: &mut [Vector3<f64>],
    solver: &mut dyn Solver,
) -> Report {
    act(bodies, contacts, impulses);
    let velocities: Vec<_> = bodies.iter().flat_map(Dense::velocities).collect();
    let before = impulses.to_vec();
    let mut dynamic: Vec<&mut dyn Body> = bodies.iter_mut().map(|b| b as &mut dyn Body).collect();
    let report = solver.solve(&mut dynamic, contacts, &velocities, impulses).expect("valid");
    let change: Vec<_> = std::iter::zip(&*impulses, &before).map(|(a, b)| a - b).collect();
    act(bodies, contacts, &change);
    report
}

/// Lets impulses in the contacts' frames act on the bodies.
pub(crate) fn act(bodies: &mut [Dense], contacts: &[Contact], impulses: &[Vector3<f64>]) {
    let mut points = vec![Vector3::zeros(); bodies.iter().map(Body::points).sum()];
    for (contact, impulse) in contacts.iter().zip(impulses) {
        let world = contact.frame * impulse;
        points[contact.first] += world;
        if let Some(second) = contact.second {
            points[second] -= world;
        }
    }
    let mut rest = &points[..];
    for body in bodies {
        let (own, others) = rest.split_at(body.points());
        body.apply(own);
        rest = others;
    }
}

/// `SplitMix64`.
pub(crate) struct Random(pub u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn below(&mut self, bound: usize) -> usize {
        let bound = u64::try_from(bound).expect("64 bits are enough");
        usize::try_from(self.bits() % bound).expect("less than the bound")
    }

    /// In [-1, 1).
    pub(crate) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    pub(crate) fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.signed(), self.signed(), self.signed())
    }

    pub(crate) fn direction(&mut self) -> Vector3<f64> {
        loop {
            let v = self.vector();
            if v.norm() > 0.1 && v.norm() < 1.0 {
                return v.normalize();
            }
        }
    }

    /// One of each kind in turn, with coefficients up to `most` and now and then zero.
    pub(crate) fn curve(&mut self, kind: usize, most: f64) -> LimitCurve {
        let mut mu = || if self.unit() < 0.1 { 0.0 } else { most * self.unit() };
        match kind % 4 {
            0 => LimitCurve::Circle { mu: mu() },
            1 => LimitCurve::Ellipse { mu: [mu(), mu()] },
            2 => LimitCurve::Quarters { mu: [mu(), mu(), mu(), mu()] },
            _ => {
                let count = 4 + self.below(20);
                let mut mu: Vec<_> = (0..count).map(|_| most * self.unit()).collect();
                if self.unit() < 0.3 {
                    // The origin is then a corner or on an edge.
                    let left_out = count / 2 + self.below(count / 2);
                    mu[..left_out].fill(0.0);
                }
                polygon(&mu)
            }
        }
    }
}

/// The hull of `mu` in equally spaced directions.
pub(crate) fn polygon(mu: &[f64]) -> LimitCurve {
    let step = std::f64::consts::TAU / mu.len() as f64;
    let points: Vec<_> = (0..mu.len())
        .map(|i| Vector2::new((step * i as f64).cos(), (step * i as f64).sin()) * mu[i])
        .chain([Vector2::zeros()])
        .collect();
    LimitCurve::Polygon(rapunzel_contact::Polygon::new(&points).expect("around the origin"))
}

/// Rigid bodies that touch each other and the ground at random points, with all kinds of curves.
/// Several contacts may be at one point.
pub(crate) fn heap(random: &mut Random, most: f64) -> (Vec<Dense>, Vec<Contact>) {
    let (count, per_body) = (8, 3);
    let bodies: Vec<_> = (0..count)
        .map(|_| {
            let offsets: Vec<_> = (0..per_body).map(|_| random.vector()).collect();
            let inertia = Matrix3::from_diagonal(&Vector3::new(0.4, 0.7, 0.5));
            let mut body = Dense::rigid(0.5 + random.unit(), &inertia, &offsets);
            let velocity = [random.vector(), random.vector()];
            for (i, x) in velocity.iter().flatten().enumerate() {
                body.velocity[i] = *x;
            }
            body
        })
        .collect();
    let contacts = (0..14)
        .map(|k| {
            let first = random.below(count * per_body);
            let other = random.below(count * per_body + 6);
            let apart = other < count * per_body && other / per_body != first / per_body;
            let curve = random.curve(k, most);
            let mut c = contact(first, apart.then_some(other), &random.direction(), curve);
            c.adhesion = if k % 4 == 0 { 0.1 * random.unit() } else { 0.0 };
            c.compliance = if k % 3 == 0 { 0.01 } else { 0.0 };
            c.bias = 0.1 * random.vector();
            c
        })
        .collect();
    (bodies, contacts)
}

/// The largest error of a velocity, m/s.
pub(crate) fn worst(bodies: &[Dense], contacts: &[Contact], impulses: &[Vector3<f64>]) -> f64 {
    let velocities: Vec<_> = bodies.iter().flat_map(Dense::velocities).collect();
    let violation = |(c, r): (&Contact, &Vector3<f64>)| {
        let u = c.relative(&velocities) + r * c.compliance;
        let found = Violation::new(c, &u, r, 1.0);
        found.normal.max(found.slip)
    };
    contacts.iter().zip(impulses).map(violation).fold(0.0, f64::max)
}
