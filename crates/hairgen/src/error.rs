use std::path::PathBuf;
use thiserror::Error;

/// What can be wrong with what a hairstyle is made of.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum HairgenError {
    /// A surface that is no solid, or a grid that cannot be made.
    #[error("{what}: {source}")]
    Surface {
        /// Which surface.
        what: &'static str,
        /// What is wrong with it.
        source: rapunzel_collision::CollisionError,
    },
    /// A pore out of which no hair can grow.
    #[error("pore {pore}: {problem}")]
    Pore {
        /// Number of the pore, counted from 0.
        pore: usize,
        /// What is wrong with it, and what to do.
        problem: &'static str,
    },
    /// A hair of a pore that is no rod.
    #[error("the rod of pore {pore}: {source}")]
    Rod {
        /// Number of the pore, counted from 0.
        pore: usize,
        /// What is wrong with it.
        source: rapunzel_rod_static::StaticError,
    },
    /// An option outside of its range.
    #[error("{option} is {value}, but must be {range}")]
    Choice {
        /// Name of the option, with its unit.
        option: &'static str,
        /// The value that was given.
        value: f64,
        /// What it must be.
        range: &'static str,
    },
    /// A list of another length than the pores.
    #[error("{what} are {given}, but must be {wanted}, one for each pore")]
    Count {
        /// Which list.
        what: &'static str,
        /// Number of its entries.
        given: usize,
        /// Number that is needed.
        wanted: usize,
    },
    /// Nothing to make hairs from.
    #[error("there are no {what}; {remedy}")]
    Nothing {
        /// What is missing.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// Voxels of hair density that cannot be made.
    #[error("the voxels of hair density: {problem}")]
    Voxels {
        /// What is wrong, and what to do.
        problem: &'static str,
    },
    /// A measure that no head and no hair has.
    #[error("{what} of {value} m is no measure of a head or its hair; give meters")]
    Measure {
        /// Which measure.
        what: &'static str,
        /// Its value, m.
        value: f64,
    },
    /// A hairline that bounds no part of a head.
    #[error("the hairline {problem}")]
    Hairline {
        /// What must be changed.
        problem: &'static str,
    },
    /// Too few cells for a disc.
    #[error("{around} sectors and {rings} rings make no disc; give at least 3 and 1")]
    Resolution {
        /// Sectors that were asked for.
        around: u32,
        /// Rings that were asked for.
        rings: u32,
    },
    /// A scan that is no head in meters, centimeters or millimeters.
    #[error(
        "the scan is {size} units large, which is no head in meters, centimeters or millimeters; \
         give `meters_per_unit`"
    )]
    Units {
        /// Its largest extent, units of the scan.
        size: f64,
    },
    /// A scan in which no face was found.
    #[error(
        "the head finds no face in the scan: off by {rms} m; turn the scan so that y is up and the \
         face looks along z"
    )]
    NoFace {
        /// Root mean square of the distances that were kept, m.
        rms: f64,
    },
    /// A file of a style that cannot be used.
    #[error("{}: {problem}", file.display())]
    File {
        /// Its path, as the style gives it.
        file: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// A volume of hair about a head that is not the parametric one.
    #[error("a volume of hair needs the parametric head; give the hair as a surface")]
    VolumeWithoutHead,
    /// Hair of a scan where no head is fitted to one.
    #[error("the hair is that of a scan, but the head is not fitted to one; give `head: Scan(..)`")]
    HairWithoutScan,
    /// A number of hairs that is no style.
    #[error("{count} hairs are no style; give 1 to {most}, or another density")]
    HairCount {
        /// The number.
        count: usize,
        /// The largest allowed.
        most: usize,
    },
    /// A scalp of nothing.
    #[error("the scalp has no triangles; give an open surface")]
    EmptyScalp,
    /// Parts of the scalp that meet in a vertex alone.
    #[error(
        "around vertex {vertex} the triangles of the scalp are no fan but several that meet there \
         only; give each its own vertex, or remove all but one"
    )]
    ScalpPinch {
        /// Index of the vertex.
        vertex: u32,
    },
    /// A scalp of several parts.
    #[error(
        "the scalp is in {parts} parts, vertex {vertex} not in the first; keep one, or merge \
         vertices that are at one place"
    )]
    ScalpParts {
        /// Number of connected parts.
        parts: usize,
        /// Index of a vertex of the second part.
        vertex: u32,
    },
    /// A scalp without a border.
    #[error("the scalp is closed; cut out the part where hair grows, along the hairline")]
    ClosedScalp,
    /// A scalp with more than one border.
    #[error(
        "the scalp has {loops} borders, the shortest at vertex {vertex}; close all holes but the \
         hairline"
    )]
    ScalpHoles {
        /// Number of borders.
        loops: usize,
        /// Index of a vertex of the shortest.
        vertex: u32,
    },
    /// A scalp with handles.
    #[error("the scalp has one border, but {handles} handles, like a cup; cut and close them")]
    ScalpHandles {
        /// Number of handles.
        handles: usize,
    },
    /// A surface that is none of a head in meters.
    #[error(
        "{what} is {size} m large, but must have {least} to {most} m; scale it to meters: files \
         are often in millimeters or centimeters"
    )]
    Size {
        /// Which surface.
        what: &'static str,
        /// Its size, m.
        size: f64,
        /// Least allowed, m.
        least: f64,
        /// Largest allowed, m.
        most: f64,
    },
    /// A head that does not stand about the origin.
    #[error(
        "{what} must hold the origin, between the ears, with y up and the face along z; move and \
         turn the mesh"
    )]
    HeadOrigin {
        /// Which head.
        what: &'static str,
    },
    /// A scalp that is no part of its head.
    #[error(
        "the scalp lies {distance} m off the head or more near ({}, {}, {}); both must be in one \
         frame and unit, the scalp a part of the head's surface",
        place[0], place[1], place[2]
    )]
    ScalpOff {
        /// Distance from the surface of the head, m, as far as it is known.
        distance: f64,
        /// Place on the scalp (world), m.
        place: [f64; 3],
    },
    /// No space between head and hair.
    #[error(
        "the surface of the hair is nowhere more than {least} m above the scalp: it lies on or in \
         the head; give that of head and hair together, in the frame of the head"
    )]
    NoRoom {
        /// Height that it must have somewhere, m.
        least: f64,
    },
    /// Guides that all found no place.
    #[error(
        "none of {guides} guides finds a place between head and hair; hair of {length} m may be \
         too long for the surface of the hair, which is {size} m large: shorten it, or widen the \
         surface"
    )]
    NoPlace {
        /// Number of guides.
        guides: usize,
        /// Length of the first, m.
        length: f64,
        /// Diagonal of the box of the hair's surface, m.
        size: f64,
    },
    /// Axes of a head that span no plane.
    #[error("the axes of the head, up {up:?} and front {front:?}, must be finite and not parallel")]
    HeadAxes {
        /// The direction that was given for up (world).
        up: [f64; 3],
        /// The direction that was given for the front (world).
        front: [f64; 3],
    },
    /// A whorl that turns or reaches nowhere.
    #[error(
        "the whorl turns by {turn} rad over {reach} m; the first must be finite, the second \
         positive too"
    )]
    Whorl {
        /// Angle, rad.
        turn: f64,
        /// Length over which it falls, m.
        reach: f64,
    },
    /// A place that is not in the disc.
    #[error("({}, {}) is no place in the unit disc; give finite coordinates", place[0], place[1])]
    Place {
        /// The place.
        place: [f64; 2],
    },
    /// A border of the wrong size.
    #[error("{given} places are given for the border of the scalp, which has {needed} vertices")]
    BorderCount {
        /// Number of places.
        given: usize,
        /// Number of vertices of the border.
        needed: usize,
    },
    /// A map of the scalp to the plane that is not one-to-one.
    #[error(
        "face {face} of the scalp has no area in the plane or is turned over, one of {count}; \
         the border must be mapped to a convex polygon, and the mesh must have no long spikes or \
         folds: smooth it there"
    )]
    Flipped {
        /// Index of the first such triangle.
        face: usize,
        /// Number of such triangles.
        count: usize,
    },
    /// Equations on a surface without a solution.
    #[error("the equations on the surface: {0}; remove triangles with tiny angles")]
    Linear(#[from] rapunzel_linalg::LinalgError),
    /// A file that is no PNG image.
    #[error("this cannot be read as PNG: {problem}; export it again")]
    ImageFile {
        /// What its reader says.
        problem: String,
    },
    /// An image of the wrong size.
    #[error(
        "the image has {width} x {height} pixels, but must be square, with 2 to 4096 pixels a side"
    )]
    ImageSize {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// An image of the wrong kind.
    #[error("the image has {found}; export it as plain grey with 8 bits")]
    ImageKind {
        /// What it has and should not have.
        found: String,
    },
    /// A value over the disc out of its range.
    #[error(
        "{what} is {value} at ({}, {}) of the disc, but must be between {least:?} and {most:?}",
        place[0], place[1]
    )]
    DiscValue {
        /// Which value, with its unit.
        what: &'static str,
        /// The value.
        value: f64,
        /// Place in the disc.
        place: [f64; 2],
        /// Least value allowed.
        least: f64,
        /// Largest value allowed.
        most: f64,
    },
    /// More pores than can be placed.
    #[error(
        "{count} pores on a scalp with so uneven a density take more than {most} places to choose \
         from; ask for fewer, or lower the peaks of the density"
    )]
    TooManyPores {
        /// The number that was asked for.
        count: usize,
        /// The largest number of places.
        most: usize,
    },
    /// Pores on a scalp on which nothing grows.
    #[error("{count} pores are asked for, but the density is zero all over the scalp")]
    Bald {
        /// The number that was asked for.
        count: usize,
    },
}

impl HairgenError {
    /// What is wrong with the mesh of a scalp.
    pub(crate) fn scalp(source: rapunzel_collision::CollisionError) -> Self {
        match source {
            rapunzel_collision::CollisionError::NoTriangles => Self::EmptyScalp,
            source => Self::Surface { what: "the scalp", source },
        }
    }
}

/// Checks that an option is in its range; NaN is in none.
pub(crate) fn choice(
    option: &'static str,
    value: f64,
    range: &'static str,
    allowed: impl Fn(f64) -> bool,
) -> Result<(), HairgenError> {
    if value.is_finite() && allowed(value) {
        Ok(())
    } else {
        Err(HairgenError::Choice { option, value, range })
    }
}
