//! Rods at rest on a floor, against theory.

use approx::assert_relative_eq;
use nalgebra::{DMatrix, Isometry3, Matrix3, Point3, Unit, UnitQuaternion, Vector3};
use rapunzel_rod_static::{
    AssemblyRest, AssemblyRod, Chain, EndCondition, EndHold, Gap, GapFunctions, GapTerm, Piece,
    Problem, Properties, RodAssembly, RootSupport, StaticError,
};
use std::f64::consts::FRAC_PI_2;

/// The half space below z = 0, for rods without thickness.
struct Floor;

impl GapFunctions for Floor {
    fn gaps(&self, positions: &[Vec<Point3<f64>>]) -> Vec<Gap> {
        let mut gaps = Vec::new();
        for (rod, nodes) in positions.iter().enumerate() {
            for (station, at) in nodes.iter().enumerate().skip(1) {
                let terms = vec![GapTerm { rod, station, derivative: Vector3::z() }];
                let (between, curvature) = ([rod, station, 0, 0], DMatrix::zeros(3, 3));
                gaps.push(Gap { between, value: at.z, terms, curvature });
            }
        }
        gaps
    }

    fn is_crossed(&self, _: &[Vec<Point3<f64>>], _: &[Vec<Point3<f64>>]) -> bool {
        false
    }

    fn thinnest(&self) -> f64 {
        f64::INFINITY
    }
}

const STIFFNESS: f64 = 0.02;

fn level(height: f64) -> Isometry3<f64> {
    let along_x = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2);
    Isometry3::from_parts(Vector3::new(0.0, 0.0, height).into(), along_x)
}

fn piece(length: f64, weight: f64, tip: f64) -> Piece {
    let load = Vector3::new(0.0, 0.0, -weight);
    let stiffness = Vector3::new(STIFFNESS, STIFFNESS, 0.7 * STIFFNESS);
    let uniform =
        Piece::uniform(length, Properties { stiffness, natural_curvature: Vector3::zeros(), load });
    uniform.with_end_load(Vector3::new(0.0, 0.0, -tip))
}

fn rest(
    height: f64,
    piece: Piece,
    segments: usize,
    root: RootSupport,
) -> Result<AssemblyRest, StaticError> {
    let chain = Chain::new(&level(height), &[piece], segments)?;
    let start = chain.natural_shape();
    RodAssembly::new(vec![AssemblyRod { chain, root, start }])?.relax(&Floor)
}

fn certified(rest: &AssemblyRest, length: f64) {
    let largest = rest.contacts.iter().map(|contact| contact.1).fold(0.0, f64::max);
    assert!(rest.penetration < 1e-9 * length, "{:e}", rest.penetration);
    assert!(rest.slackness < 1e-9 * length * largest, "{:e}", rest.slackness);
    assert!(rest.unbalanced < 1e-8 * length * largest, "{:e}", rest.unbalanced);
}

/// The tip of a cantilever that a force presses on the floor: the floor bears what is left of the
/// force, by the boundary value problem of an end that slides along the floor.
#[test]
fn a_cantilever_is_pressed_on_a_floor() {
    let (length, height, force) = (1.0, 0.4, 0.3);
    let hold = EndHold::Joint;
    let (point, along) = (Point3::origin(), Unit::new_normalize(Vector3::x()));
    let end = EndCondition::Sliding { point, along, force: 0.0, hold };
    let slides = Problem::new(&level(height), vec![piece(length, 0.0, 0.0)], end).expect("a rod");
    let exact = force + slides.solve().expect("an equilibrium").at(length).force.z;
    let error = |segments: usize| {
        let rest =
            rest(height, piece(length, 0.0, force), segments, RootSupport::Clamped).expect("rest");
        certified(&rest, length);
        assert_eq!(rest.contacts.len(), 1);
        assert_eq!(rest.contacts[0].0.terms[0].station, segments + 1);
        rest.contacts[0].1 - exact
    };
    let [coarse, fine] = [error(50), error(100)];
    assert_relative_eq!(coarse / fine, 4.0, max_relative = 0.01);
    assert!(fine.abs() < 1e-4 * exact, "{fine:e} of {exact}");
}

/// A heavy rod that lies on the floor and is lifted at its clamped end by a small height: the
/// length that is lifted, the moment at the clamp and the force where it touches down by the theory
/// of beams, `72 B h / w = l^4`, `w l^2 / 6`, `w l / 3`.
#[test]
fn a_rod_is_lifted_from_a_floor() {
    let (length, weight, height) = (2.0, 0.5, 1e-4);
    let rest = rest(height, piece(length, weight, 0.0), 400, RootSupport::Clamped).expect("rest");
    certified(&rest, length);
    let lifted = (72.0 * STIFFNESS * height / weight).powf(0.25);
    let h = length / 400.0;
    // Slopes are squared in what the theory leaves out; the place is known to a segment.
    let moment = rest.states[0][0].moment.norm();
    assert_relative_eq!(
        moment,
        weight * lifted * lifted / 6.0,
        max_relative = (h / lifted).powi(2)
    );
    let borne: f64 = rest.contacts.iter().map(|contact| contact.1).sum();
    let clamp = rest.states[0][0].force.z;
    assert_relative_eq!(borne - clamp, weight * length, max_relative = 1e-9);
    let first = (rest.contacts[0].0.terms[0].station as f64 - 0.5) * h;
    assert!((first - lifted).abs() < 2.0 * h, "{first} {lifted}");
}

/// The same lifted so far that slopes are large: of the length that is lifted the end lies flat on
/// the floor and bears no moment, a boundary value problem.
#[test]
fn a_rod_is_lifted_far() {
    let (length, weight, height) = (2.0, 0.5, 0.15);
    let hold = EndHold::Tangent(Unit::new_normalize(Vector3::x()));
    let (point, along) = (Point3::origin(), Unit::new_normalize(Vector3::x()));
    let end = EndCondition::Sliding { point, along, force: 0.0, hold };
    let lifted = |length: f64| {
        let rod = Problem::new(&level(height), vec![piece(length, weight, 0.0)], end);
        rod.expect("a rod").solve().expect("an equilibrium")
    };
    // The moment at the end grows with the length.
    let (mut short, mut long) = (0.5, 1.0);
    let sign = lifted(short).at(short).moment.y.signum();
    assert!(lifted(long).at(long).moment.y * sign < 0.0);
    while long - short > 1e-9 {
        let middle = 0.5 * (short + long);
        if lifted(middle).at(middle).moment.y * sign > 0.0 { short = middle } else { long = middle }
    }
    let exact = lifted(short);
    let rest = rest(height, piece(length, weight, 0.0), 400, RootSupport::Clamped).expect("rest");
    certified(&rest, length);
    let h = length / 400.0;
    let moment = exact.at(0.0).moment.norm();
    assert_relative_eq!(
        rest.states[0][0].moment.norm(),
        moment,
        max_relative = (h / short).powi(2)
    );
    let first = (rest.contacts[0].0.terms[0].station as f64 - 0.5) * h;
    assert!((first - short).abs() < 2.0 * h, "{first} {short}");
}

/// The outside of a cylinder about the y axis, of this radius.
struct Cylinder(f64);

impl GapFunctions for Cylinder {
    fn gaps(&self, positions: &[Vec<Point3<f64>>]) -> Vec<Gap> {
        let mut gaps = Vec::new();
        for (rod, nodes) in positions.iter().enumerate() {
            for (station, at) in nodes.iter().enumerate().skip(1) {
                let (distance, y) = (at.x.hypot(at.z), Vector3::y());
                let derivative = Vector3::new(at.x, 0.0, at.z) / distance;
                let bent =
                    Matrix3::identity() - derivative * derivative.transpose() - y * y.transpose();
                let curvature = DMatrix::from_column_slice(3, 3, (bent / distance).as_slice());
                let terms = vec![GapTerm { rod, station, derivative }];
                let (between, value) = ([rod, station, 0, 0], distance - self.0);
                gaps.push(Gap { between, value, terms, curvature });
            }
        }
        gaps
    }

    fn is_crossed(&self, _: &[Vec<Point3<f64>>], _: &[Vec<Point3<f64>>]) -> bool {
        false
    }

    fn thinnest(&self) -> f64 {
        self.0
    }
}

/// A limp rod that leaves its clamp along a cylinder and is drawn down around it: the tension in
/// its free part, less `B / 2 R^2`, presses by `T / R` where it lies on the cylinder.
#[test]
fn a_rod_is_drawn_around_a_cylinder() {
    let (radius, force, length) = (0.2, 10.0, 1.0);
    let chain = Chain::new(&level(radius), &[piece(length, 0.0, force)], 200).expect("a rod");
    let (root, start) = (RootSupport::Clamped, chain.natural_shape());
    let rods = vec![AssemblyRod { chain, root, start }];
    let rest = RodAssembly::new(rods).expect("rods").relax(&Cylinder(radius)).expect("rest");
    certified(&rest, length);
    let pressure = (force - 0.5 * STIFFNESS / (radius * radius)) / radius;
    let middle: Vec<_> =
        rest.contacts.iter().filter(|one| (20..40).contains(&one.0.terms[0].station)).collect();
    assert_eq!(middle.len(), 20);
    // By the square of the angle that a segment turns by.
    for (_, push) in middle {
        assert_relative_eq!(*push, pressure * length / 200.0, max_relative = 1e-3);
    }
}

#[test]
fn what_nothing_holds_is_told() {
    let found = rest(0.1, piece(1.0, 0.5, 0.0), 50, RootSupport::Free);
    assert_eq!(found.err(), Some(StaticError::Adrift { rod: 0 }));
}
