use crate::fit::FitOptions;
use crate::head::{HairVolume, Hairline, HeadMeasures};
use crate::{DensityModel, GuideOptions, HairOptions};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A hairstyle as a file says it. Paths are relative to the folder of the style.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Style {
    /// What the hair grows on.
    #[serde(default)]
    pub head: HeadSource,
    /// What the hair fills.
    #[serde(default)]
    pub hair: HairSource,
    /// A mesh of the scalp, in place of the part of the head within the hairline: an open surface,
    /// PLY, OBJ or STL.
    #[serde(default)]
    pub scalp: Option<PathBuf>,
    /// Hairs per m^2 of scalp, where their number is not given.
    #[serde(default = "density")]
    pub density: ScalpField,
    /// Number of hairs, spread in proportion to the density.
    #[serde(default)]
    pub hairs: Option<usize>,
    /// Length of the hairs, m.
    #[serde(default = "length")]
    pub length: ScalpField,
    /// To which side hair grows along the scalp.
    #[serde(default)]
    pub flow: FlowSpec,
    /// Angle from the scalp's normal to the direction of growth, degrees; by the height on the head
    /// where it is not given.
    #[serde(default)]
    pub tilt: Option<ScalpField>,
    /// Pre-guides per m^2 of scalp, which tell the guides where hair flows.
    #[serde(default = "pre_guides")]
    pub pre_guides: f64,
    /// Number of guides.
    #[serde(default = "guides")]
    pub guides: usize,
    /// Depth below the surface of the hair to which pre-guides dip, of the way to the head: of the
    /// highest ones and of the lowest. Long hair hangs instead.
    #[serde(default = "dips")]
    pub dips: [f64; 2],
    /// How guides are laid.
    #[serde(default)]
    pub guide: GuideSpec,
    /// How the other hairs follow the guides.
    #[serde(default)]
    pub strands: HairOptions,
    /// Height over the origin of the head at which hair is cut off, m, as with scissors; not where
    /// it is left out. Guides do not know of it: hair hangs as long hair does.
    #[serde(default)]
    pub trim: Option<f64>,
    /// Seed of all random numbers.
    #[serde(default)]
    pub seed: u64,
}

impl Default for Style {
    /// What an empty file says: a bob.
    fn default() -> Self {
        Self {
            head: HeadSource::default(),
            hair: HairSource::default(),
            scalp: None,
            density: density(),
            hairs: None,
            length: length(),
            flow: FlowSpec::default(),
            tilt: None,
            pre_guides: pre_guides(),
            guides: guides(),
            dips: dips(),
            guide: GuideSpec::default(),
            strands: HairOptions::default(),
            trim: None,
            seed: 0,
        }
    }
}

impl Style {
    /// Paths of the files that the style names, as it says them.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let (head, template) = match &self.head {
            HeadSource::Parametric { .. } => (None, None),
            HeadSource::Mesh { file, .. } => (Some(file), None),
            HeadSource::Scan { file, template, .. } => (Some(file), template.as_ref()),
        };
        let hair = match &self.hair {
            HairSource::Volume(_) | HairSource::Scan => None,
            HairSource::Solid(file) | HairSource::Shell { file, .. } => Some(file),
        };
        let angle = match &self.flow {
            FlowSpec::Whorl { .. } => None,
            FlowSpec::Angle(field) => Some(field),
        };
        let fields = [Some(&self.density), Some(&self.length), angle, self.tilt.as_ref()];
        let images = fields.into_iter().flatten().filter_map(|field| match field {
            ScalpField::Constant(_) => None,
            ScalpField::Image { file, .. } => Some(file),
        });
        let meshes = [head, template, hair, self.scalp.as_ref()].into_iter().flatten();
        meshes.chain(images).map(PathBuf::as_path)
    }
}

fn density() -> ScalpField {
    ScalpField::Constant(crate::growth::SPARSE_DENSITY)
}

fn length() -> ScalpField {
    ScalpField::Constant(0.2)
}

fn pre_guides() -> f64 {
    1e4
}

fn guides() -> usize {
    1000
}

fn dips() -> [f64; 2] {
    [0.1, 0.7]
}

/// What hair grows on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum HeadSource {
    /// The parametric head.
    Parametric {
        /// Its measures.
        #[serde(default)]
        measures: HeadMeasures,
        /// The rim of its scalp.
        #[serde(default)]
        hairline: Hairline,
    },
    /// A bald head in meters: y up, the face along z, the origin between the ears.
    Mesh {
        /// PLY, OBJ or STL.
        file: PathBuf,
        /// The rim of its scalp.
        #[serde(default)]
        hairline: Hairline,
    },
    /// A scan of a head with its hair, y up, the face along z: the head is fitted to it.
    Scan {
        /// PLY, OBJ or STL.
        file: PathBuf,
        /// The head that is fitted, PLY, OBJ or STL as for `Mesh`; the parametric one where it is
        /// left out.
        #[serde(default)]
        template: Option<PathBuf>,
        /// The rim of its scalp.
        #[serde(default)]
        hairline: Hairline,
        /// How it is fitted.
        #[serde(default)]
        options: FitOptions,
    },
}

impl Default for HeadSource {
    fn default() -> Self {
        Self::Parametric { measures: HeadMeasures::default(), hairline: Hairline::default() }
    }
}

/// What hair fills.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum HairSource {
    /// A volume about the parametric head.
    Volume(HairVolume),
    /// The closed surface of head and hair together: PLY, OBJ or STL, in the frame of the head.
    Solid(PathBuf),
    /// An open surface of hair, which hair does not cross: a shell of a thickness, m.
    Shell {
        /// PLY, OBJ or STL.
        file: PathBuf,
        /// Thickness of the shell, m.
        thickness: f64,
    },
    /// The scan that the head was fitted to.
    Scan,
}

impl Default for HairSource {
    fn default() -> Self {
        Self::Volume(HairVolume::BOB)
    }
}

/// A number at every place of the scalp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ScalpField {
    /// The same everywhere.
    Constant(f64),
    /// A square grey image of 8 bits on the disc that the scalp is mapped to: seen from above, the
    /// face at the lower edge.
    Image {
        /// PNG.
        file: PathBuf,
        /// Value of black.
        black: f64,
        /// Value of white.
        white: f64,
    },
}

/// To which side hair grows along the scalp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum FlowSpec {
    /// Away from a whorl, in a spiral that becomes straight.
    Whorl {
        /// Its middle in the disc; far up and back where it is left out.
        #[serde(default)]
        place: Option<[f64; 2]>,
        /// Angle from straight away to the direction beside the middle, degrees, counter-clockwise
        /// seen from outside.
        #[serde(default = "turn")]
        turn: f64,
        /// Distance over which this angle falls by the factor e, m.
        #[serde(default = "reach")]
        reach: f64,
    },
    /// By the angle of the direction in the disc, degrees from x to y.
    Angle(ScalpField),
}

fn turn() -> f64 {
    -70.0
}

fn reach() -> f64 {
    0.04
}

impl Default for FlowSpec {
    fn default() -> Self {
        Self::Whorl { place: None, turn: turn(), reach: reach() }
    }
}

/// How guides are laid, and how they keep apart.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuideSpec {
    /// How one guide is laid.
    pub options: GuideOptions,
    /// How hair that is there counts for guides that are laid after it; not at all where it is left
    /// out.
    pub density: Option<DensityModel>,
    /// Side of the voxels of the density, m.
    pub voxel: Voxel,
}

/// The side of a voxel, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Voxel(pub f64);

impl Default for Voxel {
    fn default() -> Self {
        Self(4e-3)
    }
}
