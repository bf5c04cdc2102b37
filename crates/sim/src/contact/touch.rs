use nalgebra::Vector3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What a fibre touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Partner {
    /// A fibre, perhaps itself.
    Fiber(u32),
    /// An object of the scene.
    Object(u32),
}

impl fmt::Display for Partner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fiber(fiber) => write!(f, "fibre {fiber}"),
            Self::Object(object) => write!(f, "objects[{object}]"),
        }
    }
}

/// A place where a fibre touches something, or nearly does, at the end of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touch {
    pub(crate) fiber: u32,
    pub(crate) partner: Partner,
    /// Segments within the fibres; that of an object is 0.
    pub(crate) segments: [u32; 2],
    /// Fractions along the segments.
    pub(crate) fractions: [f64; 2],
    /// Unit normal from the partner to the fibre, world.
    pub(crate) normal: Vector3<f64>,
    /// Along the fibre, from root to tip, world; not of unit length.
    pub(crate) axis: Vector3<f64>,
    /// The same of the partner; zero for an object.
    pub(crate) other_axis: Vector3<f64>,
    /// Distance of the surfaces at the end of the step, m.
    pub(crate) gap: f64,
    /// Mean velocity of the partner's surface over the step if that is led, m/s, world.
    pub(crate) drive: Vector3<f64>,
    /// From the partner's center of mass to the fibre's axis if that is a free object, m, world.
    pub(crate) lever: Vector3<f64>,
    /// Impulse on the fibre, N s, world.
    pub(crate) impulse: Vector3<f64>,
    /// Whether it has borne something, or would have closed, in this step.
    pub(crate) working: bool,
    /// Whether a bond holds it together.
    pub(crate) bonded: bool,
}

impl Touch {
    /// Where it is along both fibres, in segments from the root.
    pub(crate) fn at(&self) -> [f64; 2] {
        [0, 1].map(|i| f64::from(self.segments[i]) + self.fractions[i])
    }

    /// Angle from the fibre's axis to its partner's about the normal, rad.
    pub(crate) fn turn(&self) -> f64 {
        let across = self.normal.cross(&self.axis);
        self.other_axis.dot(&across).atan2(self.other_axis.dot(&self.axis))
    }

    /// By pair, then by place, then by segments: of two that name one node the same comes first
    /// whatever the order in which they were found. Places are not negative, so that their bits are
    /// in order.
    fn rank(&self) -> (u32, Partner, [u64; 2], [u32; 2]) {
        (self.fiber, self.partner, self.at().map(f64::to_bits), self.segments)
    }

    /// Whether two are of one pair, and not far from each other.
    pub(crate) fn near(&self, other: &Self) -> bool {
        let ([s, t], [u, v]) = (self.at(), other.at());
        (self.fiber, self.partner) == (other.fiber, other.partner)
            && (s - u).abs().max((t - v).abs()) < 0.1
    }

    /// Whether two touches of one pair lie beside each other with normals that face each other.
    pub(crate) fn opposes(&self, other: &Self) -> bool {
        let ([s, t], [u, v]) = (self.at(), other.at());
        (s - u).abs().max((t - v).abs()) < 1.0 && self.normal.dot(&other.normal) < 0.0
    }

    /// Whether two are the same place, named by two segments that share a node.
    pub(crate) fn same(&self, other: &Self) -> bool {
        let ([s, t], [u, v]) = (self.at(), other.at());
        (self.fiber, self.partner) == (other.fiber, other.partner)
            && (s - u).abs() < 1e-9
            && (t - v).abs() < 1e-9
    }
}

/// Sorts touches by pair and place.
pub(super) fn sort(touches: &mut Vec<Touch>) {
    // Touches are large: their ranks are sorted instead.
    let mut ranks: Vec<_> =
        touches.par_iter().enumerate().map(|(i, touch)| (touch.rank(), i)).collect();
    ranks.par_sort_unstable();
    *touches = ranks.into_par_iter().map(|(_, i)| touches[i]).collect();
}

/// The touches of a list together with those of another that are deeper than `depth`, in place of
/// those that oppose them and, if `replace`, of those near them.
pub(super) fn merged(list: Vec<Touch>, other: &[Touch], depth: f64, replace: bool) -> Vec<Touch> {
    let mut new: Vec<Touch> = other.iter().filter(|touch| touch.gap < -depth).copied().collect();
    let pair = |touch: &Touch| (touch.fiber, touch.partner);
    let mut merged = Vec::with_capacity(list.len() + new.len());
    for touch in list {
        let start = new.partition_point(|deep| pair(deep) < pair(&touch));
        let mut of_pair = new[start..].iter_mut().take_while(|deep| pair(deep) == pair(&touch));
        match of_pair.find(|deep| deep.opposes(&touch) || replace && deep.near(&touch)) {
            Some(deep) => {
                deep.bonded |= touch.bonded;
                if deep.impulse == Vector3::zeros() {
                    deep.impulse = touch.impulse;
                }
            }
            None => merged.push(touch),
        }
    }
    merged.append(&mut new);
    sort(&mut merged);
    merged
}
