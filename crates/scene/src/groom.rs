use super::arrangement::MOST_FIBERS;
use super::check::{Allowed, Check};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Fibres along the curves of a groom, and where they are in the world.
///
/// A groom has its z axis up; a head in it looks along the negative y axis. Its origin is at the
/// position of the bundle's root.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Groom {
    /// Where the curves come from.
    pub from: GroomSource,
    /// Rotation of the groom: about the world's fixed x, then y, then z axes, degrees.
    #[serde(default)]
    pub turn: [f64; 3],
    /// A ball outside of which roots are left out: a tress that is cut from the groom.
    #[serde(default)]
    pub roots_within: Option<RootBall>,
    /// Natural shape of the fibres.
    #[serde(default)]
    pub natural: GroomShape,
}

/// The curves of a groom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum GroomSource {
    /// A hairstyle, grown when the scene is built.
    Style {
        /// Path of the style, relative to the folder of the scene.
        file: PathBuf,
        /// Number of hairs, in place of the style's own.
        hairs: usize,
    },
    /// Strands in a file, resampled at equal arc lengths. What cannot be a fibre is left out.
    Strands {
        /// Path of a `.hair`, `.data`, `.usd`, `.usda`, `.usdc`, `.ply` or `.obj` file, relative to
        /// the folder of the scene.
        file: PathBuf,
        /// Metres for a unit of the file, in place of what it states.
        #[serde(default)]
        scale: Option<f64>,
        /// Axis of the file that points up, in place of what it states.
        #[serde(default)]
        up: Option<GroomUpAxis>,
    },
}

/// An axis that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum GroomUpAxis {
    /// The second.
    Y,
    /// The third.
    Z,
}

/// A ball in a groom.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RootBall {
    /// Its middle, m, in the frame of the groom.
    pub center: [f64; 3],
    /// Its radius, m.
    pub radius: f64,
}

/// The natural shape of fibres that lie along given curves at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum GroomShape {
    /// The one with which the curve is an equilibrium under all loads of the start, those of
    /// contacts included, but without wind: nothing sags, and wind blows the fibres away from it. A
    /// fibre that would not stay, because the equilibrium is unstable or takes more than the
    /// largest change of curvature, starts in an equilibrium nearby.
    SagFree {
        /// Largest difference of the natural curvature from the curve's own, 1/m.
        #[serde(default = "largest_change")]
        most: f64,
    },
    /// The same, but a dead force and a following couple on each tip, which stay, bear as much as
    /// they can, as in the thesis's guides; the natural curvature bears the rest.
    EndLoads {
        /// Largest difference of the natural curvature from the curve's own, 1/m.
        #[serde(default = "largest_change")]
        most: f64,
    },
    /// The curve itself: the fibres sag by their weight.
    Drawn,
}

/// The curvature of a ring of 1 cm, 1/m: straight hair that must be curled more than that to stay
/// where it is drawn sags instead.
fn largest_change() -> f64 {
    100.0
}

impl Default for GroomShape {
    fn default() -> Self {
        Self::SagFree { most: largest_change() }
    }
}

impl GroomSource {
    /// Path of the file.
    #[must_use]
    pub fn file(&self) -> &Path {
        let (Self::Style { file, .. } | Self::Strands { file, .. }) = self;
        file
    }
}

impl Groom {
    pub(super) fn check(&self, check: &mut Check) {
        check.within("from", |c| match &self.from {
            GroomSource::Style { hairs, .. } => c.count("hairs", *hairs, 1, MOST_FIBERS),
            GroomSource::Strands { scale, .. } => {
                if let Some(scale) = scale {
                    c.number("scale", *scale, Allowed::Positive, "m");
                }
            }
        });
        check.vector("turn", &self.turn, "degrees");
        if let Some(RootBall { center, radius }) = &self.roots_within {
            check.within("roots_within", |c| {
                c.vector("center", center, "m");
                c.number("radius", *radius, Allowed::Positive, "m");
            });
        }
        if let GroomShape::SagFree { most } | GroomShape::EndLoads { most } = self.natural {
            check.within("natural", |c| c.number("most", most, Allowed::NonNegative, "1/m"));
        }
    }

    /// Makes the path relative to the folder of the scene.
    pub(super) fn seen_from(&mut self, folder: &Path) {
        let (GroomSource::Style { file, .. } | GroomSource::Strands { file, .. }) = &mut self.from;
        *file = folder.join(&*file);
    }
}
