use super::{Clips, Prim, PrimShape, ROOT, Timeline, begin_prim, material};
use crate::ExportError;
use crate::text::{integers, list, single, triple};
use crate::vtp::Arrays;
use std::io::{BufRead, Seek, Write};
use std::ops::Range;

/// A layer of fibres or springs, made from the files of frames.
///
/// The files are opened as often as needed and read array by array, so that only a small part of a
/// frame of any size is in memory.
#[derive(Debug)]
pub struct Strands<F> {
    timeline: Timeline,
    /// Name of the prim that holds all others.
    scope: &'static str,
    prims: Vec<Prim>,
    /// Whether curves are smooth.
    smooth: bool,
    /// Function that opens a frame by its number.
    open: F,
    /// Index of the first point of each strand, and the number of all points.
    starts: Vec<usize>,
}

/// Approximate number of bytes of text of a point in a frame: position, velocity and direction.
const POINT: usize = 110;

impl<R: BufRead + Seek, F: Fn(usize) -> Result<R, ExportError>> Strands<F> {
    /// Creates the layer of `prims`; `open` opens a frame by its number, from 0.
    ///
    /// # Errors
    /// The errors of opening and reading the first frame; [`ExportError::Empty`] without frames or
    /// prims; [`ExportError::Series`] for prims of strands or points that do not exist.
    pub fn new(
        timeline: Timeline,
        scope: &'static str,
        prims: Vec<Prim>,
        open: F,
    ) -> Result<Self, ExportError> {
        if timeline.frames == 0 || prims.is_empty() {
            return Err(ExportError::Empty);
        }
        let counts = Arrays::open(open(0)?)?.counts()?;
        let mut starts = vec![0];
        starts.extend(counts.iter().scan(0, |end, count| {
            *end += count;
            Some(*end)
        }));
        let there = |shape: &PrimShape| match shape {
            PrimShape::Curves { strands, .. } => {
                strands.start < strands.end && strands.end <= counts.len()
            }
            PrimShape::Surface { vertices, faces } => {
                vertices
                    .iter()
                    .all(|[strand, point]| counts.get(*strand).is_some_and(|n| point < n))
                    && faces.iter().flatten().all(|&vertex| vertex < vertices.len())
            }
        };
        if !prims.iter().all(|prim| there(&prim.shape)) {
            return Err(ExportError::Series { index: 0, what: "it has no such strands" });
        }
        Ok(Self { timeline, scope, prims, smooth: false, open, starts })
    }

    /// Shows all curves as Catmull-Rom curves, which pass through the same points, instead of
    /// straight between them.
    #[must_use]
    pub fn smooth(self) -> Self {
        Self { smooth: true, ..self }
    }

    /// Ranges of the frames of each value clip, if a layer without clips would have more than
    /// `most` bytes; otherwise none.
    #[must_use]
    pub fn clips(&self, most: usize) -> Vec<Range<usize>> {
        let points = self.prims.iter().map(|prim| self.points(&prim.shape));
        let frame = POINT * points.sum::<usize>();
        if self.timeline.frames.saturating_mul(frame) <= most {
            return Vec::new();
        }
        let each = (most / frame).max(1);
        let firsts = (0..self.timeline.frames).step_by(each);
        firsts.map(|first| first..self.timeline.frames.min(first + each)).collect()
    }

    /// Writes the layer, with its own samples or with references to `clips`.
    ///
    /// # Errors
    /// The errors of frames that cannot be read, have other strands than the first, or hold numbers
    /// beyond single precision; fails if `out` does.
    pub fn write(&self, out: &mut impl Write, clips: Option<&Clips>) -> Result<(), ExportError> {
        let looks = format!("/{ROOT}/{}/Looks", self.scope);
        self.begin(out, "def", clips)?;
        writeln!(out, "        def Scope \"Looks\"\n        {{")?;
        for Prim { name, color, .. } in &self.prims {
            material(out, &looks, name, *color)?;
        }
        writeln!(out, "        }}")?;
        for Prim { name, shape, color } in &self.prims {
            let kind = match shape {
                PrimShape::Curves { .. } => "BasisCurves",
                PrimShape::Surface { .. } => "Mesh",
            };
            begin_prim(out, kind, name, &format!("{looks}/{name}"), *color)?;
            self.still(out, shape)?;
            if clips.is_none() {
                self.samples(out, shape, 0..self.timeline.frames)?;
            }
            writeln!(out, "        }}")?;
        }
        Ok(writeln!(out, "    }}\n}}")?)
    }

    /// Writes the value clip of a range of frames.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_clip(
        &self,
        out: &mut impl Write,
        frames: Range<usize>,
    ) -> Result<(), ExportError> {
        self.write_over(out, |out, shape| self.samples(out, shape, frames.clone()))
    }

    /// Writes the manifest of the value clips.
    ///
    /// # Errors
    /// Fails if `out` does.
    pub fn write_manifest(&self, out: &mut impl Write) -> Result<(), ExportError> {
        self.write_over(out, |out, shape| {
            let names = StrandQuantity::of(shape).iter().map(|quantity| quantity.attribute());
            names.chain([EXTENT]).try_for_each(|name| Ok(writeln!(out, "            {name}")?))
        })
    }

    fn write_over<W: Write>(
        &self,
        out: &mut W,
        mut attributes: impl FnMut(&mut W, &PrimShape) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        self.begin(out, "over", None)?;
        for Prim { name, shape, .. } in &self.prims {
            writeln!(out, "        over \"{name}\"\n        {{")?;
            attributes(out, shape)?;
            writeln!(out, "        }}")?;
        }
        Ok(writeln!(out, "    }}\n}}")?)
    }

    /// Writes the beginning of the layer, down to the prims.
    fn begin(
        &self,
        out: &mut impl Write,
        specifier: &str,
        clips: Option<&Clips>,
    ) -> Result<(), ExportError> {
        let kind = if specifier == "def" { "def Xform" } else { specifier };
        self.timeline.begin(out, "")?;
        write!(out, "\n{kind} \"{ROOT}\"\n{{\n    {kind} \"{}\"", self.scope)?;
        if let Some(Clips { manifest, files }) = clips {
            let last = self.timeline.last();
            write!(out, " (\n        clips = {{\n            dictionary default = {{\n")?;
            write!(out, "                double2[] active = ")?;
            list(out, files.iter().enumerate(), |out, (clip, (frames, _))| {
                Ok(write!(out, "({}, {clip})", self.timeline.code(frames.start))?)
            })?;
            write!(out, "\n                asset[] assetPaths = ")?;
            list(out, files, |out, (_, file)| Ok(write!(out, "@./{file}@")?))?;
            write!(
                out,
                r#"
                asset manifestAssetPath = @./{manifest}@
                string primPath = "/{ROOT}/{}"
                double2[] times = [(0, 0), ({last}, {last})]
            }}
        }}
    )"#,
                self.scope
            )?;
        }
        Ok(writeln!(out, "\n    {{")?)
    }

    /// Writes the attributes of a shape that are constant in time.
    fn still(&self, out: &mut impl Write, shape: &PrimShape) -> Result<(), ExportError> {
        match shape {
            PrimShape::Curves { strands, guide } => {
                if *guide {
                    writeln!(out, "            uniform token purpose = \"guide\"")?;
                }
                // Pinned curves begin and end at their first and last points.
                let form: &[_] = if self.smooth {
                    &["type = \"cubic\"", "basis = \"catmullRom\"", "wrap = \"pinned\""]
                } else {
                    &["type = \"linear\"", "wrap = \"nonperiodic\""]
                };
                for token in form {
                    writeln!(out, "            uniform token {token}")?;
                }
                write!(out, "            int[] curveVertexCounts = ")?;
                let starts = &self.starts[strands.start..=strands.end];
                integers(out, "points", starts.windows(2).map(|ends| ends[1] - ends[0]))?;
                write!(out, "\n            int[] primvars:id = ")?;
                integers(out, "strands", strands.clone())?;
                interpolation(out, "uniform")?;
                write!(out, "            {}", StrandQuantity::Director.attribute())?;
                interpolation(out, "vertex")?;
                self.widths(out, strands)
            }
            PrimShape::Surface { faces, .. } => {
                writeln!(
                    out,
                    "            uniform bool doubleSided = 1\n            uniform token \
                     subdivisionScheme = \"none\""
                )?;
                write!(out, "            int[] faceVertexCounts = ")?;
                integers(out, "vertices", faces.iter().map(Vec::len))?;
                write!(out, "\n            int[] faceVertexIndices = ")?;
                integers(out, "vertices", faces.iter().flatten().copied())?;
                Ok(writeln!(out)?)
            }
        }
    }

    /// Writes the diameters of strands, one value if all are the same.
    fn widths(&self, out: &mut impl Write, strands: &Range<usize>) -> Result<(), ExportError> {
        let points = self.starts[strands.start]..self.starts[strands.end];
        let mut first = self.frame(0)?;
        let all = first.radii(points.clone())?;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for radius in all {
            let radius = radius?;
            range = [range[0].min(radius), range[1].max(radius)];
        }
        let shown = if range[0] == range[1] { points.start..points.start + 1 } else { points };
        let kind = if shown.len() == 1 { "constant" } else { "vertex" };
        write!(out, "            float[] widths = ")?;
        list(out, first.radii(shown)?, |out, radius| single(out, 2.0 * radius?))?;
        interpolation(out, kind)
    }

    /// Writes the attributes of a shape that change in time, for a range of frames.
    fn samples(
        &self,
        out: &mut impl Write,
        shape: &PrimShape,
        frames: Range<usize>,
    ) -> Result<(), ExportError> {
        let radius = self.largest_radius(shape)?;
        let mut extents = Vec::new();
        for &quantity in StrandQuantity::of(shape) {
            writeln!(out, "            {}.timeSamples = {{", quantity.attribute())?;
            for frame in frames.clone() {
                let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
                write!(out, "                {}: ", self.timeline.code(frame))?;
                self.sample(out, quantity, shape, frame, |point| {
                    for (k, x) in point.into_iter().enumerate() {
                        bounds[0][k] = bounds[0][k].min(x - radius);
                        bounds[1][k] = bounds[1][k].max(x + radius);
                    }
                })?;
                writeln!(out, ",")?;
                if quantity == StrandQuantity::Position {
                    extents.push(bounds);
                }
            }
            writeln!(out, "            }}")?;
        }
        writeln!(out, "            {EXTENT}.timeSamples = {{")?;
        for (frame, bounds) in frames.zip(extents) {
            write!(out, "                {}: ", self.timeline.code(frame))?;
            list(out, bounds, triple)?;
            writeln!(out, ",")?;
        }
        Ok(writeln!(out, "            }}")?)
    }

    /// Writes a vector for each point of a shape in a frame, and passes it to `see`.
    fn sample(
        &self,
        out: &mut impl Write,
        quantity: StrandQuantity,
        shape: &PrimShape,
        frame: usize,
        mut see: impl FnMut([f64; 3]),
    ) -> Result<(), ExportError> {
        let mut arrays = self.frame(frame)?;
        let mut write = |out: &mut _, vector: Result<[f64; 3], ExportError>| {
            let vector = vector?;
            see(vector);
            triple(out, vector)
        };
        match shape {
            PrimShape::Curves { strands, .. } => {
                let points = self.starts[strands.start]..self.starts[strands.end];
                match quantity {
                    StrandQuantity::Position => list(out, arrays.positions(points)?, write),
                    StrandQuantity::Velocity => list(out, arrays.velocities(points)?, write),
                    StrandQuantity::Director => list(out, arrays.directors(points)?, write),
                }
            }
            PrimShape::Surface { vertices, .. } => {
                let points = 0..arrays.points();
                let all = match quantity {
                    StrandQuantity::Position => {
                        arrays.positions(points)?.collect::<Result<Vec<_>, _>>()
                    }
                    StrandQuantity::Velocity => arrays.velocities(points)?.collect(),
                    StrandQuantity::Director => arrays.directors(points)?.collect(),
                }?;
                let vertex = |[strand, point]: &[usize; 2]| all[self.starts[*strand] + point];
                list(out, vertices, |out, place| write(out, Ok(vertex(place))))
            }
        }
    }

    fn largest_radius(&self, shape: &PrimShape) -> Result<f64, ExportError> {
        let PrimShape::Curves { strands, .. } = shape else { return Ok(0.0) };
        let points = self.starts[strands.start]..self.starts[strands.end];
        let mut first = self.frame(0)?;
        first.radii(points)?.try_fold(0.0, |largest: f64, radius| Ok(largest.max(radius?)))
    }

    /// Number of points of a shape.
    fn points(&self, shape: &PrimShape) -> usize {
        match shape {
            PrimShape::Curves { strands, .. } => {
                self.starts[strands.end] - self.starts[strands.start]
            }
            PrimShape::Surface { vertices, .. } => vertices.len(),
        }
    }

    /// Opens a frame and checks that it is the requested one, with the points of the first.
    fn frame(&self, frame: usize) -> Result<Arrays<R>, ExportError> {
        let arrays = Arrays::open((self.open)(frame)?)?;
        if arrays.index() != frame {
            return Err(ExportError::Series { index: frame, what: "its number is another" });
        }
        if Some(&arrays.points()) != self.starts.last() {
            return Err(ExportError::Series { index: frame, what: "its points are not as many" });
        }
        Ok(arrays)
    }
}

/// Writes what the values of an attribute belong to.
fn interpolation(out: &mut impl Write, kind: &str) -> Result<(), ExportError> {
    Ok(writeln!(out, " (\n                interpolation = \"{kind}\"\n            )")?)
}

/// Type and name of the attribute with the box around a shape.
const EXTENT: &str = "float3[] extent";

/// A vector of each point that changes in time.
#[derive(Clone, Copy, PartialEq)]
enum StrandQuantity {
    Position,
    Velocity,
    Director,
}

impl StrandQuantity {
    /// Those that a shape has.
    fn of(shape: &PrimShape) -> &'static [Self] {
        match shape {
            PrimShape::Curves { .. } => &[Self::Position, Self::Velocity, Self::Director],
            PrimShape::Surface { .. } => &[Self::Position, Self::Velocity],
        }
    }

    /// Type and name of the attribute. The director is no `normals`: with these a curve is a flat
    /// ribbon.
    fn attribute(self) -> &'static str {
        match self {
            Self::Position => "point3f[] points",
            Self::Velocity => "vector3f[] velocities",
            Self::Director => "vector3f[] primvars:d1",
        }
    }
}
