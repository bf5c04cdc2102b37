//! A plectoneme: its theory, and a rod that starts in one.

use nalgebra::{Point3, Vector3};
use rapunzel_rod_dynamic::RodState;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

/// Radius of the rod, m, stiffnesses against bending and torsion, N m^2, and mass per length, kg/m.
const RADIUS: f64 = 1e-3;
const BENDING: f64 = 1e-6;
const TORSION: f64 = 0.7e-6;
const LINEAR_DENSITY: f64 = 4e-3;
/// Length of a strand of the ply at the start, in radii.
const STRAND: f64 = 25.0;
/// Length of a step, s.
pub(crate) const DT: f64 = 2e-2;
/// Steps in which the start comes to rest, those in which the ends make a turn against each other,
/// and those of their turning that are not watched and that are.
const REST: u32 = 20;
const TURN: u32 = 60;
const BEFORE: u32 = 30;
const WATCHED: u32 = 40;

/// Two strands of one rod that wind about each other without friction, each at an angle to the axis
/// between them, at the distance of a radius from it (Clauvelin, Audoly and Neukirch, Elasticity
/// and electrostatics of plectonemic DNA, Biophys. J. 96, 2009).
///
/// Of a rod of length `L` under the tension `T` and the twisting moment `M` the length `l` is in
/// the ply, at the angle `a`, with the curvature `sin(a)^2 / r` and the writhe of a radian and
/// length `sin(2 a) / 2 r`. Twist and writhe are what its end has been turned by. What depends on
/// `l` and `a` of the energy is
/// `(B sin(a)^4 / 2 r^2 + T - M sin(2 a) / 2 r) l`, which is least in `a` and does not depend on
/// `l` where
///
/// ```text
/// M = 2 B sin(a)^3 cos(a) / (r cos(2 a)),    T = (B sin(a)^4 / r^2) (1 / 2 + 1 / cos(2 a)).
/// ```
///
/// With another turn of the end, which leaves the twist as it is, `4 pi r / sin(2 a)` of the rod
/// goes into the ply. However the ends of the ply look, that is exact for what is far from them:
/// the force along the rod and its energies of bending and twist are together the same all along,
/// and what is beyond a cut across the ply hangs on it freely.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ply {
    /// Angle between strand and axis, rad.
    pub(crate) angle: f64,
}

/// What a rod in a ply shows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    /// Distance between the ends of the rod, m.
    extension: f64,
    /// Twisting moment, N m, mean of the nodes.
    moment: f64,
    /// Angle of the ply in the middle of it, rad.
    angle: f64,
    /// Writhe and twist, in turns.
    writhe: f64,
    twist: f64,
}

/// What a ply does while the ends of its rod are turned against each other.
#[derive(Debug, Clone)]
pub(crate) struct Growth {
    /// What the ends come together by in a turn that leaves the twist as it is, m.
    pub(crate) slope: f64,
    /// Twisting moment, N m, and angle of the ply, rad, means.
    pub(crate) moment: f64,
    pub(crate) angle: f64,
    /// Turns of twist and writhe in a turn of the ends.
    pub(crate) link: f64,
    /// Distances between the ends, m, by turns.
    pub(crate) extensions: Vec<[f64; 2]>,
}

impl Ply {
    /// Twisting moment, N m.
    pub(crate) fn moment(self) -> f64 {
        let (sin, cos) = self.angle.sin_cos();
        2.0 * BENDING * sin.powi(3) * cos / (RADIUS * (2.0 * self.angle).cos())
    }

    /// Tension, N.
    pub(crate) fn tension(self) -> f64 {
        BENDING
            * (self.angle.sin().powi(2) / RADIUS).powi(2)
            * (0.5 + 1.0 / (2.0 * self.angle).cos())
    }

    /// What the ends of the rod come together by with a turn, m.
    pub(crate) fn slope(self) -> f64 {
        4.0 * PI * RADIUS / (2.0 * self.angle).sin()
    }

    /// Height of the arc over a segment of the strand, in its distance from the axis.
    pub(crate) fn sagitta(self) -> f64 {
        // Segments are as long as a radius.
        self.angle.sin().powi(2) / 8.0
    }

    /// Length over which tension straightens the rod, m: radius of the bends and of the loop.
    fn unit(self) -> f64 {
        (BENDING / self.tension()).sqrt()
    }

    /// One half of a curve whose middle is in the loop: a tail against x, a quarter of a circle
    /// down to the ply, the strand, which winds, and half of the loop. In radii.
    fn half(self, tail: f64, strand: f64) -> Vec<Point3<f64>> {
        let (ply, step) = (1.05_f64, 0.05);
        let bend = self.unit() / RADIUS;
        let opening = ((ply + bend) / (2.0 * bend)).acos();
        let lengths = [tail, 0.5 * PI * bend, strand, opening * bend, (0.5 * PI + opening) * bend];
        let turns = [0.0, -1.0 / bend, 0.0, -1.0 / bend, 1.0 / bend];
        // Along the meridian: distance from the axis, height, angle between course and `x`.
        let (mut out, mut high, mut course, mut around) = (-ply - bend - tail, bend, 0.0_f64, 0.0);
        let mut points = Vec::new();
        for (piece, (length, turn)) in lengths.into_iter().zip(turns).enumerate() {
            let count = (length / step).ceil();
            let ds = length / count;
            let mut way = 0.0_f64;
            while way < length - 0.5 * ds {
                points.push([out, high, around]);
                course += 0.5 * ds * turn;
                (out, high) = (out + ds * course.cos(), high + ds * course.sin());
                course += 0.5 * ds * turn;
                if piece == 2 {
                    // It begins and ends to wind over some radii.
                    let edge = way.min(length - way) / 6.0;
                    around += ds * self.angle.tan() * edge.min(1.0) / ply;
                }
                way += ds;
            }
        }
        let place = |[out, high, around]: [f64; 3]| {
            Point3::new(out * f64::cos(around), out * f64::sin(around), high)
        };
        let mut places: Vec<_> = points.into_iter().map(place).collect();
        places.push(place([0.0, high, around]));
        places
    }

    /// A curve with such a ply: its points, m. In the loop and where its tails come together it is
    /// only near to rest. Two more turns are left in its tails.
    pub(crate) fn curve(self) -> Vec<Point3<f64>> {
        let tail = 6.0 * self.unit() + self.slope();
        let mut half = self.half(tail / RADIUS, STRAND);
        // The other half is the same, turned by half a turn about the ply and about the loop.
        let last = half.len() - 1;
        let other: Vec<_> =
            half[..last].iter().rev().map(|p| Point3::new(-p.x, -p.y, p.z)).collect();
        half.extend(other);
        half.iter().map(|p| p * RADIUS).collect()
    }

    /// The scene of a rod that starts along a curve, in a file, of a length, m, with the twist that
    /// a ply asks for, in oil. Its tip is pulled with the force of the ply; when it has come
    /// to rest its ends are turned against each other, each by half of the turns, so that the ply
    /// need not turn about the line between them.
    pub(crate) fn scene(self, file: &str, length: f64) -> String {
        let segments = (length / RADIUS).round();
        let twist = (self.moment() / TORSION * length).to_degrees();
        let from = f64::from(REST) * DT;
        let until = from + f64::from(BEFORE + WATCHED) * DT;
        let angle = 180.0 * f64::from(BEFORE + WATCHED) / f64::from(TURN);
        format!(
            "(format: 1, duration: 100.0, fibers: [(
                length: {length:?}, segments: {segments}, section: Circle(radius: {RADIUS:?}),
                material: Measured(bending: ({BENDING:?}, {BENDING:?}), torsion: {TORSION:?},
                    linear_density: {LINEAR_DENSITY:?}),
                damping_time: 5e-3, initial: Curve(file: {file:?}, twist: {twist:?}),
                motion: Keyframes(points: [(time: 0), (time: {from:?}),
                    (time: {until:?}, rotation: ({:?}, 0, 0))]),
                tip: Led(
                    motion: Keyframes(points: [(time: 0), (time: {from:?}),
                        (time: {until:?}, rotation: ({angle:?}, 0, 0))]),
                    joint: Supported(translations: (Free, Held, Held),
                        rotations: (Held, Held, Held), force: (value: ({:?}, 0, 0)))),
            )],
            contact: (friction: Isotropic(0.0), residual: 1e-3),
            environment: (gravity: (0, 0, 0), viscosity: 0.01), stepper: (dt: {DT:?}))",
            -angle,
            self.tension(),
        )
    }
}

/// How the ply of [`Ply::scene`] grows; `next` takes a step and tells the state.
pub(crate) fn growth<E>(mut next: impl FnMut() -> Result<RodState, E>) -> Result<Growth, E> {
    for _ in 1..REST + BEFORE {
        next()?;
    }
    let mut all = Vec::new();
    for _ in 0..=WATCHED {
        all.push(see(&next()?));
    }
    let [first, last] = [all[0], all[all.len() - 1]];
    let mean = |of: fn(&Seen) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
    let turned = |steps: u32| f64::from(steps) / f64::from(TURN);
    Ok(Growth {
        slope: (first.extension - last.extension) / (last.writhe - first.writhe),
        moment: mean(|seen| seen.moment),
        angle: mean(|seen| seen.angle),
        link: (last.writhe + last.twist - first.writhe - first.twist) / turned(WATCHED),
        extensions: (0..).zip(&all).map(|(step, seen)| [turned(step), seen.extension]).collect(),
    })
}

/// Text of a file with the points of a curve.
pub(crate) fn text(points: &[Point3<f64>]) -> String {
    points.iter().fold(String::new(), |mut text, p| {
        let _ = writeln!(text, "{:?} {:?} {:?}", p.x, p.y, p.z);
        text
    })
}

/// Length of a curve.
pub(crate) fn length(points: &[Point3<f64>]) -> f64 {
    points.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum()
}

fn see(state: &RodState) -> Seen {
    let (nodes, frames) = (&state.positions, &state.frames);
    let inner = &state.curvatures[1..frames.len()];
    let moment = TORSION * inner.iter().map(|k| k.z).sum::<f64>() / inner.len() as f64;
    // Of the nodes before the loop the nearest ones behind it, where the strands touch.
    let half = frames.len() / 2;
    let middle = |e: usize| nodes[e] + 0.5 * (nodes[e + 1] - nodes[e]);
    let tangent = |e: usize| frames[e] * Vector3::z();
    let mut angles = Vec::new();
    for e in 0..half - 5 {
        let apart = |other: usize| (middle(other) - middle(e)).norm();
        let near = (half + 5..frames.len()).min_by(|a, b| apart(*a).total_cmp(&apart(*b)));
        let touching = near.filter(|other| apart(*other) < 2.2 * RADIUS);
        angles.extend(touching.map(|other| 0.5 * tangent(e).angle(&-tangent(other))));
    }
    // The ends of the ply look otherwise.
    let inside = &angles[angles.len() / 3..angles.len() - angles.len() / 3];
    Seen {
        extension: (nodes[nodes.len() - 1] - nodes[0]).norm(),
        moment,
        angle: inside.iter().sum::<f64>() / inside.len() as f64,
        writhe: writhe(nodes),
        twist: twist(state),
    }
}

/// Turns of the sections beside those of a frame that is carried along without a twist: exact for a
/// polygon.
fn twist(state: &RodState) -> f64 {
    let turned = |pair: &[nalgebra::Rotation3<f64>]| {
        let turn = nalgebra::UnitQuaternion::from_rotation_matrix(&(pair[0].inverse() * pair[1]));
        2.0 * turn.k.atan2(turn.w)
    };
    state.frames.windows(2).map(turned).sum::<f64>() / TAU
}

/// Writhe of a polygon whose ends go on straight, far: the sum over pairs of segments of the solid
/// angles in which they are seen to cross (Klenin and Langowski, Biopolymers 54, 2000).
fn writhe(nodes: &[Point3<f64>]) -> f64 {
    let last = nodes.len() - 1;
    let far = 1e4 * (nodes[last] - nodes[0]).norm();
    let mut all = vec![nodes[0] + far * (nodes[0] - nodes[1]).normalize()];
    all.extend_from_slice(nodes);
    all.push(nodes[last] + far * (nodes[last] - nodes[last - 1]).normalize());
    let mut sum = 0.0;
    for i in 0..all.len() - 1 {
        for j in i + 2..all.len() - 1 {
            sum += solid_angle([all[i], all[i + 1]], [all[j], all[j + 1]]);
        }
    }
    sum / TAU
}

/// Signed solid angle, of either side, in which two segments are seen to cross.
fn solid_angle([a, b]: [Point3<f64>; 2], [c, d]: [Point3<f64>; 2]) -> f64 {
    let sides = [(c - a, d - a), (d - a, d - b), (d - b, c - b), (c - b, c - a)];
    let normals = sides.map(|(p, q)| p.cross(&q));
    if normals.iter().any(|n| n.norm() == 0.0) {
        return 0.0;
    }
    let normals = normals.map(|n| n.normalize());
    let angle: f64 =
        (0..4).map(|k| normals[k].dot(&normals[(k + 1) % 4]).clamp(-1.0, 1.0).asin()).sum();
    angle * (d - c).cross(&(b - a)).dot(&(c - a)).signum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the energy of a ply goes with is least in the angle, and does not depend on the length
    /// of the ply, by differences.
    #[test]
    fn a_ply_is_in_equilibrium() {
        for degrees in [15.0_f64, 25.0, 35.0] {
            let ply = Ply { angle: degrees.to_radians() };
            let (tension, moment) = (ply.tension(), ply.moment());
            let energy = |a: f64| {
                0.5 * BENDING * (a.sin().powi(2) / RADIUS).powi(2) + tension
                    - moment * (2.0 * a).sin() / (2.0 * RADIUS)
            };
            let small = 1e-5;
            let slope = (energy(ply.angle + small) - energy(ply.angle - small)) / (2.0 * small);
            // The third derivative leaves the square of the difference.
            assert!(slope.abs() < 1e-8 * tension, "{degrees}: {slope:e}");
            assert!(energy(ply.angle).abs() < 1e-14 * tension.max(1.0), "{degrees}");
            // A turn more is one of writhe.
            let writhe = ply.slope() * (2.0 * ply.angle).sin() / (2.0 * RADIUS);
            assert!((writhe - TAU).abs() < 1e-12, "{writhe}");
        }
    }

    #[test]
    fn a_straight_polygon_has_no_writhe() {
        let nodes: Vec<_> = (0..9).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
        assert_eq!(writhe(&nodes), 0.0);
    }
}
