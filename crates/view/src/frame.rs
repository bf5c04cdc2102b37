//! A frame as pages get it: positions and values in 16 bits each.

use nalgebra::{Isometry3, Point3};
use rapunzel_export::Strand;
use rapunzel_sim::Stepper;
use rapunzel_studio::{ColorRange, Coloring};

/// The first bytes of a frame.
const MARK: &[u8; 4] = b"RPF1";
/// Bytes of a frame beside its points and objects: its head, and extras of nothing.
const ROOM: usize = 80 + 16;
/// The largest number of 16 bits.
const MOST_UNITS: f64 = 65_535.0;
/// Positions farther from the origin than this, m, are not shown where they are.
const FARTHEST: f64 = 1e9;

/// What colors show, and between which values.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Colors {
    pub(crate) by: Option<Coloring>,
    /// Grows with the values, so that a color keeps its meaning from frame to frame.
    pub(crate) range: Option<ColorRange>,
}

/// Points of strands with what colors show at them. Kept from frame to frame, so that none is made
/// anew.
#[derive(Debug, Default)]
pub(crate) struct ShownPoints {
    /// m, world, one strand after another.
    pub(crate) points: Vec<Point3<f64>>,
    /// One a point, or none where nothing colors them.
    pub(crate) values: Vec<f64>,
}

impl ShownPoints {
    /// Those of strands.
    pub(crate) fn of_strands(strands: &[Strand], by: Option<Coloring>) -> Self {
        let points = strands.iter().flat_map(|strand| strand.points.iter().copied()).collect();
        let values = by.iter().flat_map(|by| {
            let of = |(index, strand)| by.of_strand(index, strand);
            strands.iter().enumerate().flat_map(of)
        });
        Self { points, values: values.collect() }
    }

    /// Those of what moves, as it is now.
    pub(crate) fn read(&mut self, stepper: &dyn Stepper, by: Option<Coloring>) {
        self.points.clear();
        stepper.points(&mut self.points);
        self.values.clear();
        by.iter().for_each(|by| stepper.values(*by, &mut self.values));
    }
}

/// What a frame says beside its points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrameHead {
    /// Number of its layout.
    pub(crate) layout: u32,
    /// Number of steps, or of the frame of a run.
    pub(crate) number: u64,
    /// Simulated time, s.
    pub(crate) time: f64,
}

/// The bytes of a frame, little-endian: mark, layout (u32), number (u64), time (f64), origin
/// (3 f64), unit (f64), lowest and highest value (2 f64), number of points and of objects (2 u32);
/// then x, y, z and value of every point (4 u16), place and quaternion of every object (7 f32), and
/// the extras.
///
/// A position is the origin and the unit times its numbers, so that it is off by half a unit at
/// most along each axis.
///
/// What is no number is shown at zero, and what is farther than can be shown at the edge.
pub(crate) fn frame(
    head: FrameHead,
    shown: &ShownPoints,
    poses: &[Isometry3<f64>],
    colors: &mut Colors,
) -> Vec<u8> {
    let ShownPoints { points, values } = shown;
    let (origin, unit) = bounds(points);
    let range = range(colors, values);
    let mut bytes = Vec::with_capacity(ROOM + 8 * points.len() + 28 * poses.len());
    bytes.extend(MARK);
    bytes.extend(head.layout.to_le_bytes());
    bytes.extend(head.number.to_le_bytes());
    for x in [head.time, origin.x, origin.y, origin.z, unit, range.low, range.high] {
        bytes.extend(x.to_le_bytes());
    }
    bytes.extend(count(points.len()).to_le_bytes());
    bytes.extend(count(poses.len()).to_le_bytes());
    let begin = bytes.len();
    bytes.resize(begin + 8 * points.len(), 0);
    let (units, width) = (unit.recip(), range.high - range.low);
    let steps = if width > 0.0 { MOST_UNITS / width } else { 0.0 };
    // Without colors every value is zero.
    let values = values.iter().copied().chain(std::iter::repeat(0.0));
    for ((to, point), value) in bytes[begin..].chunks_exact_mut(8).zip(points).zip(values) {
        let place = (reachable(point) - origin) * units;
        let numbers = [place.x, place.y, place.z, (value - range.low) * steps].map(sixteen);
        for (to, number) in to.chunks_exact_mut(2).zip(numbers) {
            to.copy_from_slice(&number.to_le_bytes());
        }
    }
    for pose in poses {
        let (place, turn) = (pose.translation.vector, pose.rotation.coords);
        for x in place.iter().chain(turn.iter()) {
            bytes.extend(single(*x).to_le_bytes());
        }
    }
    bytes
}

/// The range of colors, grown by values.
fn range(colors: &mut Colors, values: &[f64]) -> ColorRange {
    let now = ColorRange::of(values.iter().copied().filter(|value| value.is_finite()));
    let before = colors.range.unwrap_or(now);
    let range = ColorRange { low: before.low.min(now.low), high: before.high.max(now.high) };
    colors.range = Some(range);
    range
}

/// A point that can be shown.
fn reachable(point: &Point3<f64>) -> Point3<f64> {
    point.map(|x| if x.is_finite() { x.clamp(-FARTHEST, FARTHEST) } else { 0.0 })
}

/// The lowest corner of the box of all points, and the unit in which the longest of its sides has
/// all 16 bits.
fn bounds(points: &[Point3<f64>]) -> (Point3<f64>, f64) {
    let first = points.first().map_or_else(Point3::origin, reachable);
    let wider = |(low, high): (Point3<f64>, Point3<f64>), point: &Point3<f64>| {
        let point = reachable(point);
        (low.inf(&point), high.sup(&point))
    };
    let (low, high) = points.iter().fold((first, first), wider);
    (low, ((high - low).max() / MOST_UNITS).max(1e-12))
}

/// The nearest number of 16 bits.
pub(crate) fn sixteen(x: f64) -> u16 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let number = (x + 0.5) as u16;
    number
}

pub(crate) fn single(x: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "a picture needs no more")]
    let number = x as f32;
    number
}

/// A number of things, as pages count them.
pub(crate) fn count(of: usize) -> u32 {
    u32::try_from(of).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Vector3};

    fn strand(points: Vec<Point3<f64>>) -> Strand {
        let n = points.len();
        Strand {
            radii: vec![1e-3; n],
            velocities: (0..n).map(|k| Vector3::x() * k as f64).collect(),
            frames: vec![Rotation3::identity(); n - 1],
            curvatures: vec![Vector3::zeros(); n],
            forces: vec![Vector3::zeros(); n - 1],
            contact_forces: vec![Vector3::zeros(); n],
            charges: vec![0.0; n],
            points,
        }
    }

    fn number(bytes: &[u8], at: usize) -> f64 {
        f64::from_le_bytes(bytes[at..at + 8].try_into().expect("8 bytes"))
    }

    #[test]
    fn positions_are_off_by_half_a_unit_at_most() {
        let points: Vec<_> = (0..50)
            .map(|k| {
                let t = f64::from(k);
                Point3::new(0.3 + 0.01 * t.sin(), -4.0 + 0.02 * t.cos(), 0.07 * t)
            })
            .collect();
        let head = FrameHead { layout: 7, number: 3, time: 0.25 };
        let mut colors = Colors { by: Some(Coloring::Speed), range: None };
        let shown = ShownPoints::of_strands(&[strand(points.clone())], colors.by);
        let bytes = frame(head, &shown, &[Isometry3::identity()], &mut colors);
        assert_eq!(&bytes[..4], MARK);
        assert_eq!(bytes.len(), 80 + 8 * 50 + 28);
        let (origin, unit) = ([24, 32, 40].map(|at| number(&bytes, at)), number(&bytes, 48));
        assert!((unit * MOST_UNITS - 0.07 * 49.0).abs() < 1e-12);
        assert_eq!((number(&bytes, 56), number(&bytes, 64)), (0.0, 49.0));
        for (k, point) in points.iter().enumerate() {
            for axis in 0..3 {
                let at = 80 + 8 * k + 2 * axis;
                let of = u16::from_le_bytes([bytes[at], bytes[at + 1]]);
                let error = origin[axis] + unit * f64::from(of) - point[axis];
                assert!(error.abs() <= 0.5 * unit * (1.0 + 1e-9), "{k} {axis} {error}");
            }
        }
    }

    #[test]
    fn what_is_no_number_is_shown_at_the_origin() {
        let far = Point3::new(f64::NAN, f64::INFINITY, 1e300);
        let head = FrameHead { layout: 0, number: 0, time: 0.0 };
        let shown = ShownPoints { points: vec![far, Point3::origin()], values: Vec::new() };
        let bytes = frame(head, &shown, &[], &mut Colors::default());
        let unit = number(&bytes, 48);
        assert!(unit.is_finite() && unit > 0.0, "{unit}");
    }

    #[test]
    fn the_range_of_colors_grows_and_does_not_shrink() {
        let mut colors = Colors { by: Some(Coloring::Speed), range: None };
        assert_eq!(range(&mut colors, &[1.0, 3.0]), ColorRange { low: 0.0, high: 3.0 });
        assert_eq!(range(&mut colors, &[-1.0, 2.0]), ColorRange { low: -1.0, high: 3.0 });
        assert_eq!(range(&mut colors, &[f64::NAN]), ColorRange { low: -1.0, high: 3.0 });
    }
}
