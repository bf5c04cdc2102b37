use crate::{Known, Origin, ReadOptions, StrandFault, StrandReport, StrandSet, UpAxis};
use nalgebra::Point3;

/// Strands as their file has them, unchecked.
#[derive(Debug, Default)]
pub(crate) struct RawStrands {
    /// Number of points of each strand.
    pub(crate) counts: Vec<usize>,
    /// Points in units of the file, as many as the counts say.
    pub(crate) points: Vec<Point3<f64>>,
    /// Diameters at the points in units of the file; empty if there are none.
    pub(crate) widths: Vec<f64>,
    /// Strands that the reader itself refuses, by number, in order; these have no points.
    pub(crate) faults: Vec<(usize, StrandFault)>,
    /// Length of one unit, m, if the file states it.
    pub(crate) meters_per_unit: Option<f64>,
    /// Axis that points upward, if the file states it.
    pub(crate) up: Option<UpAxis>,
    /// Parts of the file that may hold strands and were not read.
    pub(crate) unread: Vec<String>,
}

impl RawStrands {
    /// Moves the strands to the world's frame and sorts out what cannot be a hair. `unit` is the
    /// length of one unit, m, of files of this format that do not state it.
    pub(crate) fn sorted(
        self,
        format: &'static str,
        unit: f64,
        options: &ReadOptions,
    ) -> (StrandSet, StrandReport) {
        let meters_per_unit = known(options.meters_per_unit, self.meters_per_unit, unit);
        let up = known(options.up, self.up, UpAxis::Y);
        let scale = meters_per_unit.value;
        let place = |p: &Point3<f64>| match up.value {
            UpAxis::Y => p * scale,
            UpAxis::Z => Point3::new(p.x, p.z, -p.y) * scale,
        };
        let mut set = StrandSet::new(!self.widths.is_empty());
        let mut report = StrandReport {
            format,
            found: self.counts.len(),
            meters_per_unit,
            up,
            merged: 0,
            refused: Vec::new(),
            unread: self.unread,
        };
        let mut faults = self.faults.into_iter().peekable();
        let (mut start, mut kept) = (0, Vec::new());
        for (number, &count) in self.counts.iter().enumerate() {
            let range = start..start + count;
            start = range.end;
            let points = || self.points[range.clone()].iter().map(place);
            let widths = self.widths.get(range.clone()).unwrap_or_default();
            kept.clear();
            kept.extend(points());
            kept.dedup();
            let fault = match faults.next_if(|(refused, _)| *refused == number) {
                Some((_, fault)) => Some(fault),
                None => fault(count, &kept, widths, options.most_points),
            };
            if let Some(fault) = fault {
                report.refused.push((number, fault));
                continue;
            }
            report.merged += count - kept.len();
            let mut last = None;
            let radii = points().zip(widths).filter(|(p, _)| last.replace(*p) != Some(*p));
            set.push(number, kept.iter().copied(), radii.map(|(_, width)| 0.5 * scale * width));
        }
        (set, report)
    }
}

impl StrandSet {
    /// Strands along curves (world: meter, y up); those that cannot be hairs are left out, as of a
    /// file.
    #[must_use]
    pub fn from_curves<'a>(curves: impl IntoIterator<Item = &'a [Point3<f64>]>) -> Self {
        let mut raw = RawStrands::default();
        for curve in curves {
            raw.counts.push(curve.len());
            raw.points.extend_from_slice(curve);
        }
        raw.sorted("curves", 1.0, &ReadOptions::default()).0
    }
}

fn known<T: Copy>(given: Option<T>, stated: Option<T>, usual: T) -> Known<T> {
    let (value, origin) = match (given, stated) {
        (Some(value), _) => (value, Origin::Given),
        (None, Some(value)) => (value, Origin::Stated),
        (None, None) => (usual, Origin::Assumed),
    };
    Known { value, origin }
}

/// Largest coordinate, m: beyond it squares of lengths would overflow.
const LARGEST: f64 = 1e100;

/// What is wrong with a strand of `count` points, of which `kept` differ from those before.
fn fault(count: usize, kept: &[Point3<f64>], widths: &[f64], most: usize) -> Option<StrandFault> {
    let is_number = |p: &Point3<f64>| p.iter().all(|x| x.abs() <= LARGEST);
    if count < 2 {
        Some(StrandFault::FewPoints)
    } else if count > most {
        Some(StrandFault::ManyPoints)
    } else if !kept.iter().all(is_number) {
        Some(StrandFault::NotFinite)
    } else if kept.len() < 2 {
        Some(StrandFault::NoLength)
    } else if !widths.iter().all(|&width| (0.0..=LARGEST).contains(&width)) {
        Some(StrandFault::Radius)
    } else {
        None
    }
}
