//! A scene of Mitsuba 3: an XML with a picture of fibres and objects, beside it a text with the
//! fibres as [B-splines](rapunzel_fiber::spline), and the objects as
//! [OBJ](crate::obj::write_objects).
//!
//! The scene is in millimetres: Mitsuba moves the origin of a ray by 0.1 µm and more for every
//! millimetre that it is away from zero, and by 90 of its units of length in a million at least.
//! Its material `hair` is right on `bsplinecurve` only: on `linearcurve` light meets the fibre
//! again where it leaves it.

use super::surface::{COLOR, Placed};
use super::{ExportError, Frame};
use crate::framing::Framing;
use crate::text::{escaped, single};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::spline::control_points;
use std::f64::consts::FRAC_PI_2;
use std::io::Write;

/// Millimetres per metre.
const SCALE: f64 = 1e3;

/// How hair scatters light, for the model of Chiang et al. (2016).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MitsubaHair {
    /// Absorption per radius of the fibre, for red, green and blue, each at least 0: across the
    /// middle of a fibre `exp(-2 absorption)` of the light is left. Mitsuba's `sigma_a` is just
    /// this, although its documentation has it per length.
    pub absorption: [f64; 3],
    /// Refractive index of the fibre, above 1.
    pub refractive_index: f64,
    /// Roughness along the fibre, above 0 and at most 1.
    pub longitudinal_roughness: f64,
    /// Roughness around the fibre, above 0 and at most 1.
    pub azimuthal_roughness: f64,
    /// Tilt of the scales, rad, less than a right angle; positive if they open towards the tip.
    pub scale_tilt: f64,
}

impl MitsubaHair {
    /// Hair of this absorption, with the refractive index, roughness and scales that are usual.
    #[must_use]
    pub fn usual(absorption: [f64; 3]) -> Self {
        Self {
            absorption,
            refractive_index: 1.55,
            longitudinal_roughness: 0.3,
            azimuthal_roughness: 0.3,
            scale_tilt: 3.0_f64.to_radians(),
        }
    }

    fn check(&self) -> Result<(), ExportError> {
        let is_rough = |roughness: f64| roughness > 0.0 && roughness <= 1.0;
        let is_tilt = |tilt: f64| tilt.abs() < FRAC_PI_2;
        let what = if !self.absorption.iter().all(|a| *a >= 0.0 && a.is_finite()) {
            "an absorption that is negative or not finite"
        } else if !(self.refractive_index > 1.0 && self.refractive_index.is_finite()) {
            "a refractive index that is not above 1"
        } else if !(is_rough(self.longitudinal_roughness) && is_rough(self.azimuthal_roughness)) {
            "a roughness that is not above 0 and at most 1"
        } else if !is_tilt(self.scale_tilt) {
            "scales tilted by a right angle or more; the tilt is in radians"
        } else {
            return Ok(());
        };
        Err(ExportError::Look { what })
    }
}

/// Names of the files that a scene refers to, relative to its own folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SceneFiles<'a> {
    /// The fibres, by [`write_curves`].
    pub curves: &'a str,
    /// The objects, by [`write_objects`](crate::obj::write_objects); not there without objects.
    pub objects: &'a str,
}

/// Writes the control points of the strands of `frame`, with their radii, mm; the curves pass
/// through the points of the strands. Radii are those of the points, and run through these where
/// they change at a constant rate.
///
/// # Errors
/// Refuses invalid and empty frames, and numbers beyond single precision; fails if `out` does.
pub fn write_curves(out: &mut impl Write, frame: &Frame) -> Result<(), ExportError> {
    frame.validate()?;
    if frame.strands.is_empty() {
        return Err(ExportError::Empty);
    }
    for strand in &frame.strands {
        let before = |a: f64, b: f64| (2.0 * a - b).max(0.0);
        let (radii, last) = (&strand.radii, strand.radii.len() - 1);
        let radii = std::iter::once(before(radii[0], radii[1]))
            .chain(radii.iter().copied())
            .chain([before(radii[last], radii[last - 1])]);
        for (point, radius) in control_points(&strand.points).iter().zip(radii) {
            for x in &point.coords {
                single(out, SCALE * x)?;
                out.write_all(b" ")?;
            }
            single(out, SCALE * radius)?;
            out.write_all(b"\n")?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// Writes the scene of `frame` and `objects`, which are in `files`: hair that looks as `look` says,
/// matte objects, a camera that sees all, a lamp and an even sky. The parameter `spp` is the
/// number of samples for each pixel (`mitsuba -D spp=16 scene.xml`).
///
/// # Errors
/// Refuses invalid and empty frames, surfaces that are not finite, and looks that no hair has;
/// fails if `out` does.
pub fn write(
    out: &mut impl Write,
    frame: &Frame,
    objects: &[Placed],
    look: &MitsubaHair,
    files: SceneFiles,
) -> Result<(), ExportError> {
    let framing = Framing::of(frame, objects)?;
    look.check()?;
    writeln!(out, "<!-- Frame {} at {} s, in millimetres, z up. -->", frame.index, frame.time)?;
    writeln!(out, "<scene version=\"3.0.0\">\n    <default name=\"spp\" value=\"64\"/>")?;
    picture(out, &framing)?;
    hair(out, look, files.curves)?;
    if !objects.is_empty() {
        let [r, g, b] = COLOR;
        write!(
            out,
            r#"    <shape type="obj">
        <string name="filename" value="{}"/>
        <boolean name="face_normals" value="true"/>
        <transform name="to_world"><scale value="{SCALE}"/></transform>
        <bsdf type="twosided">
            <bsdf type="diffuse"><rgb name="reflectance" value="{r} {g} {b}"/></bsdf>
        </bsdf>
    </shape>
"#,
            escaped(files.objects)
        )?;
    }
    Ok(writeln!(out, "</scene>")?)
}

/// Writes camera, lamp and sky.
fn picture(out: &mut impl Write, framing: &Framing) -> Result<(), ExportError> {
    let radius = SCALE * framing.radius;
    let point = |p: &Point3<f64>| format!("{} {} {}", SCALE * p.x, SCALE * p.y, SCALE * p.z);
    let [eye, lamp, middle] = [&framing.eye, &framing.lamp, &framing.middle].map(point);
    let (near, far, half) = (0.01 * radius, 100.0 * radius, 2.0 * radius);
    write!(
        out,
        r#"    <integrator type="path">
        <integer name="max_depth" value="64"/>
        <integer name="rr_depth" value="16"/>
    </integrator>
    <sensor type="perspective">
        <float name="fov" value="24"/>
        <string name="fov_axis" value="smaller"/>
        <float name="near_clip" value="{near}"/>
        <float name="far_clip" value="{far}"/>
        <transform name="to_world">
            <lookat origin="{eye}" target="{middle}" up="0 0 1"/>
        </transform>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="800"/>
            <integer name="height" value="800"/>
        </film>
    </sensor>
    <emitter type="constant"><rgb name="radiance" value="0.5"/></emitter>
    <shape type="rectangle">
        <transform name="to_world">
            <scale value="{half}"/>
            <lookat origin="{lamp}" target="{middle}" up="0 0 1"/>
        </transform>
        <emitter type="area"><rgb name="radiance" value="20"/></emitter>
    </shape>
"#
    )?;
    Ok(())
}

/// Writes the fibres in the file `curves`.
fn hair(out: &mut impl Write, look: &MitsubaHair, curves: &str) -> Result<(), ExportError> {
    // Its scales open towards the root: measured, by the brightness of hair that hangs.
    let tilt = -look.scale_tilt.to_degrees();
    // Its colors are at most 1, but have a scale.
    let scale = Vector3::from(look.absorption).max().max(1.0);
    let [r, g, b] = look.absorption.map(|a| a / scale);
    write!(
        out,
        r#"    <shape type="bsplinecurve">
        <string name="filename" value="{}"/>
        <bsdf type="hair">
            <rgb name="sigma_a" value="{r} {g} {b}"/>
            <float name="scale" value="{scale}"/>
            <float name="int_ior" value="{}"/>
            <float name="longitudinal_roughness" value="{}"/>
            <float name="azimuthal_roughness" value="{}"/>
            <float name="scale_tilt" value="{}"/>
        </bsdf>
    </shape>
"#,
        escaped(curves),
        look.refractive_index,
        look.longitudinal_roughness,
        look.azimuthal_roughness,
        tilt
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::sample;
    use super::*;

    fn look() -> MitsubaHair {
        MitsubaHair { azimuthal_roughness: 0.25, ..MitsubaHair::usual([0.5, 1.0, 2.0]) }
    }

    const FILES: SceneFiles = SceneFiles { curves: "a&b.txt", objects: "c.obj" };

    #[test]
    fn curves_are_blocks_of_control_points_through_the_nodes() {
        let frame = sample::frame(1);
        let mut bytes = Vec::new();
        write_curves(&mut bytes, &frame).expect("memory");
        let text = String::from_utf8(bytes).expect("text");
        let curves: Vec<_> = text.trim_end().split("\n\n").collect();
        assert_eq!(curves.len(), 3);
        for (curve, strand) in curves.iter().zip(&frame.strands) {
            let row = |line: &str| -> Vec<f64> {
                line.split(' ').map(|x| x.parse().expect("a number")).collect()
            };
            let rows: Vec<_> = curve.lines().map(row).collect();
            assert_eq!(rows.len(), strand.points.len() + 2);
            for (i, point) in strand.points.iter().enumerate() {
                let at = |k: usize| (rows[i][k] + 4.0 * rows[i + 1][k] + rows[i + 2][k]) / 6.0;
                let found = Point3::new(at(0), at(1), at(2));
                // Of 300 mm, in single precision; the radius falls evenly.
                assert!((found - SCALE * point).amax() < 300.0 * f64::from(f32::EPSILON));
                let radius = SCALE * strand.radii[i];
                assert!((at(3) - radius).abs() < radius * f64::from(f32::EPSILON));
            }
        }
    }

    #[test]
    fn radii_do_not_fall_below_zero() {
        let mut frame = sample::frame(0);
        frame.strands.truncate(1);
        frame.strands[0].radii = vec![4e-5, 9e-5, 4e-5, 4e-5, 4e-5, 0.0];
        let mut bytes = Vec::new();
        write_curves(&mut bytes, &frame).expect("memory");
        let text = String::from_utf8(bytes).expect("text");
        let radii: Vec<_> = text.trim_end().lines().filter_map(|l| l.rsplit(' ').next()).collect();
        assert_eq!(radii, ["0", "0.04", "0.09", "0.04", "0.04", "0.04", "0", "0"]);
    }

    #[test]
    fn the_scene_has_all_that_a_picture_needs() {
        let (frame, objects) = (sample::frame(1), sample::objects(0.1));
        let scene = |objects: &[Placed]| {
            let mut bytes = Vec::new();
            write(&mut bytes, &frame, objects, &look(), FILES).expect("memory");
            String::from_utf8(bytes).expect("text")
        };
        let text = scene(&objects);
        let tilt = -look().scale_tilt.to_degrees();
        let tilt = format!(r#"<float name="scale_tilt" value="{tilt}"/>"#);
        for part in [
            r#"<shape type="bsplinecurve">"#,
            r#"value="a&amp;b.txt""#,
            r#"<rgb name="sigma_a" value="0.25 0.5 1"/>"#,
            r#"<float name="scale" value="2"/>"#,
            r#"<float name="int_ior" value="1.55"/>"#,
            r#"<float name="longitudinal_roughness" value="0.3"/>"#,
            r#"<float name="azimuthal_roughness" value="0.25"/>"#,
            tilt.as_str(),
            r#"value="c.obj""#,
            r#"<sensor type="perspective">"#,
            r#"<emitter type="constant">"#,
            r#"<emitter type="area">"#,
        ] {
            assert!(text.contains(part), "{part} not in {text}");
        }
        for element in ["scene", "shape", "bsdf", "sensor", "transform", "emitter", "film"] {
            let (open, close) = (format!("<{element} "), format!("</{element}>"));
            assert_eq!(text.matches(&open).count(), text.matches(&close).count(), "{element}");
        }
        assert!(!scene(&[]).contains("\"obj\""));
    }

    #[test]
    fn what_no_hair_looks_like_is_refused() {
        let refused = |look: MitsubaHair| {
            let result = write(&mut Vec::new(), &sample::frame(0), &[], &look, FILES);
            assert!(matches!(result, Err(ExportError::Look { .. })), "{look:?}");
        };
        refused(MitsubaHair { absorption: [0.1, -0.1, 0.1], ..look() });
        refused(MitsubaHair { absorption: [0.1, f64::NAN, 0.1], ..look() });
        refused(MitsubaHair { refractive_index: 1.0, ..look() });
        refused(MitsubaHair { longitudinal_roughness: 0.0, ..look() });
        refused(MitsubaHair { azimuthal_roughness: 1.5, ..look() });
        refused(MitsubaHair { scale_tilt: 3.0, ..look() });
        let none = Frame { index: 0, time: 0.0, strands: vec![] };
        let written = write(&mut Vec::new(), &none, &[], &look(), FILES);
        assert!(matches!(written, Err(ExportError::Empty)));
        assert!(matches!(write_curves(&mut Vec::new(), &none), Err(ExportError::Empty)));
    }
}
