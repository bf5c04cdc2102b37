use crate::{ColorRange, Coloring, HairLook, StudioError};
use nalgebra::{Point3, Vector3};
use rapunzel_export::surface::{self, Placed};
use rapunzel_export::{ExportError, Frame, Strand};
use rapunzel_render::{
    Camera, CurveForm, Curves, FiberCurve, FiberLook, Hairs, Light, Lights, RenderError,
    RenderScene, Sky, TriangleMesh,
};

/// Angle, rad, at which an edge of an object stays sharp.
const OBJECT_CREASE: f64 = 0.6;
/// Albedo of objects: unglazed clay.
const CLAY: [f64; 3] = [0.50, 0.36, 0.29];
/// Albedo of the ground.
const GROUND: [f64; 3] = [0.30, 0.31, 0.33];
/// Width of the ground over the extent of all that stands on it.
const WIDE: f64 = 40.0;

/// How a frame is set up for a picture.
#[derive(Debug, Clone)]
pub struct StageOptions {
    /// How hair scatters light.
    pub look: HairLook,
    /// A quantity that fibres show instead, and the range of its colors.
    pub coloring: Option<(Coloring, ColorRange)>,
    /// How fibres run through their nodes.
    pub form: CurveForm,
    /// Ratio of the second semi-axis of the sections to the first; none if they are round.
    pub ratio: Option<f64>,
    /// How many times as thick fibres are drawn, where each stands for many.
    pub thickness: f64,
    /// Time of exposure, s, about the time of the frame.
    pub exposure: f64,
    /// Whether all stands on a ground.
    pub ground: bool,
    /// The light; that of a studio if there is none.
    pub sky: Option<Sky>,
    /// Two corners of the box (world), m, on whose bottom the ground is and by whose size lamps are
    /// set up; that of the frame if there is none. The pictures of a film have one.
    pub hull: Option<[Point3<f64>; 2]>,
}

impl Default for StageOptions {
    fn default() -> Self {
        Self {
            look: HairLook::default(),
            coloring: None,
            form: CurveForm::Cubic,
            ratio: None,
            thickness: 1.0,
            exposure: 0.0,
            ground: true,
            sky: None,
            hull: None,
        }
    }
}

/// The fibres and the objects of a frame, set up for a picture; z is up.
///
/// # Errors
/// [`StudioError::Frame`] for frames and surfaces that are not sound or show nothing,
/// [`StudioError::Look`] and [`StudioError::Render`] for options that are out of range.
pub fn staged(
    frame: &Frame,
    objects: &[Placed],
    options: &StageOptions,
) -> Result<RenderScene, StudioError> {
    frame.validate()?;
    let StageOptions { exposure, thickness, .. } = *options;
    for (what, value) in
        [("the time of exposure (s)", exposure), ("the thickness of fibres", thickness)]
    {
        if !(value >= 0.0 && value.is_finite()) {
            let must = "finite and not negative";
            return Err(RenderError::Parameter { what, value, must }.into());
        }
    }
    objects.iter().try_for_each(|object| surface::check(&object.surface))?;
    let hull = options.hull.or_else(|| hull(&points(frame, objects)));
    let Some([low, high]) = hull else { return Err(ExportError::Empty.into()) };
    let extent = (high - low).norm().max(1e-6);

    let fibers: Vec<_> = frame.strands.iter().map(|strand| fiber(strand, options)).collect();
    let curves = Curves::new(options.form, options.ratio, &fibers)?;
    let look = match &options.coloring {
        None => options.look.fiber_look(options.ratio)?,
        Some((coloring, range)) => {
            let color = |value: f64| coloring.color(value, range).cast::<f32>();
            FiberLook::Colored(coloring.values(frame).into_iter().map(color).collect())
        }
    };
    let mesh = |object: &Placed| {
        let surface = &object.surface;
        let (vertices, triangles) = (surface.vertices.clone(), surface.triangles.clone());
        Ok((TriangleMesh::new(vertices, triangles, OBJECT_CREASE)?, Vector3::from(CLAY)))
    };
    let mut bodies = objects.iter().map(mesh).collect::<Result<Vec<_>, StudioError>>()?;
    if options.ground {
        let middle = nalgebra::center(&low, &high);
        // A little below, so that what lies at the bottom lies on it.
        let z = low.z - 1e-3 * extent;
        bodies.push((ground(&middle, z, WIDE * extent)?, Vector3::from(GROUND)));
    }
    let lights = match &options.sky {
        Some(sky) => Lights::new(&[], Some(sky.clone()))?,
        None => studio_lights(&low, &high)?,
    };
    Ok(RenderScene::new(vec![Hairs { curves, look }], bodies, lights)?)
}

/// Points of fibres and objects (world), m.
#[must_use]
pub fn points(frame: &Frame, objects: &[Placed]) -> Vec<Point3<f64>> {
    let fibers = frame.strands.iter().flat_map(|strand| &strand.points);
    fibers.chain(objects.iter().flat_map(|object| &object.surface.vertices)).copied().collect()
}

/// Two corners of the box of some points; none if there are none.
#[must_use]
pub fn hull(points: &[Point3<f64>]) -> Option<[Point3<f64>; 2]> {
    let first = *points.first()?;
    Some(points.iter().fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]))
}

/// A camera that has some points in its picture, `azimuth` to the right of the front (the side of
/// negative y) and `elevation` above the level, rad; `field_of_view`, rad, is that of the width,
/// and `aspect` the ratio of width to height.
///
/// # Errors
/// [`StudioError::Render`] if an angle is out of range, or all is one point.
pub fn camera_around(
    points: &[Point3<f64>],
    [azimuth, elevation]: [f64; 2],
    field_of_view: f64,
    aspect: f64,
) -> Result<Camera, StudioError> {
    let ((sin, cos), (rise, level)) = (azimuth.sin_cos(), elevation.sin_cos());
    let sight = Vector3::new(-sin * level, cos * level, -rise);
    // From straight above, the front is below.
    let up = if level.abs() < 1e-6 { Vector3::new(-sin, cos, 0.0) } else { Vector3::z() };
    Ok(Camera::framing(points, &sight, &up, field_of_view, aspect)?)
}

fn fiber(strand: &Strand, options: &StageOptions) -> FiberCurve {
    let StageOptions { exposure, thickness, .. } = *options;
    let mut nodes = strand.points.clone();
    let mut ways = Vec::new();
    if exposure > 0.0 {
        // The frame is the middle of the exposure.
        ways = strand.velocities.iter().map(|velocity| velocity * exposure).collect();
        nodes.iter_mut().zip(&ways).for_each(|(node, way)| *node -= 0.5 * way);
    }
    let last = strand.frames.len() - 1;
    let axis = |k: usize| strand.frames[k.min(last)].matrix().column(0).into_owned();
    let axes = (0..strand.points.len()).map(axis).collect();
    let radii = strand.radii.iter().map(|radius| radius * thickness).collect();
    FiberCurve { nodes, radii, axes, ways }
}

/// A square.
fn ground(middle: &Point3<f64>, z: f64, width: f64) -> Result<TriangleMesh, StudioError> {
    let corner = |x: f64, y: f64| Point3::new(middle.x + x * width, middle.y + y * width, z);
    let corners = vec![corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
    Ok(TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]], 0.0)?)
}

/// A large lamp on the left in front, a small one behind on the right, whose light outlines, and an
/// even sky.
fn studio_lights(low: &Point3<f64>, high: &Point3<f64>) -> Result<Lights, StudioError> {
    let (middle, extent) = (nalgebra::center(low, high), (high - low).norm().max(1e-6));
    let lamp = |from: Vector3<f64>, size: f64, radiance: f64| {
        let toward = -from.normalize();
        let side = toward.cross(&Vector3::z()).normalize();
        Light::Rectangle {
            center: middle + from * extent,
            half_edges: [side * (size * extent), toward.cross(&side) * (size * extent)],
            radiance: Vector3::repeat(radiance),
        }
    };
    let key = lamp(Vector3::new(-1.2, -1.8, 1.8), 0.5, 24.0);
    let rim = lamp(Vector3::new(1.2, 1.6, 1.4), 0.3, 50.0);
    let sky = Sky::Gradient {
        zenith: Vector3::new(0.50, 0.53, 0.58),
        horizon: Vector3::new(0.24, 0.25, 0.27),
        ground: Vector3::new(0.24, 0.25, 0.27),
        up: Vector3::z(),
    };
    Ok(Lights::new(&[key, rim], Some(sky))?)
}
