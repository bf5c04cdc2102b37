//! What all pictures are taken of and with: wisps, lights, cameras, and the means of hair.

use crate::wavy::{RADIUS, wavy};
use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Section;
use rapunzel_render::{
    Camera, CurveForm, Curves, FiberCurve, FiberLook, Film, Hairs, Light, LightSearch, Lights,
    PathTracer, Projection, RenderScene, Tone,
};
use rapunzel_repro::Fallible;
use rapunzel_repro::plot::{Drawing, Image, Images};
use rapunzel_scattering::{ChiangField, FiberBsdf, FiberOptics, NearField, Pigments};
use std::f64::consts::TAU;

/// Angle of the scales of hair, rad (thesis 6.2).
pub(crate) const SCALES: f64 = 3.0 * TAU / 360.0;
/// The section of all fibres here.
pub(crate) const ROUND: Section = Section::Circle { radius: RADIUS };
/// Direction to the light in the scene of orders, and its irradiance, W/m^2.
pub(crate) const KEY: Vector3<f64> = Vector3::new(0.3, -0.8, 0.52);
const IRRADIANCE: f64 = 3.0;
/// Radiance behind the hair in pictures, before exposure.
const BACKDROP: f64 = 0.03;

pub(crate) type Bsdf = Box<dyn FiberBsdf + Send + Sync>;

/// Hair of pigments and a roughness, evenly in both ways.
pub(crate) fn hair(pigments: &Pigments, roughness: f64) -> Fallible<FiberOptics> {
    Ok(FiberOptics::hair(pigments.absorption()?, roughness, roughness, SCALES)?)
}

pub(crate) fn near(optics: FiberOptics) -> Fallible<Bsdf> {
    Ok(Box::new(NearField::new(optics, &ROUND)?))
}

/// The model of other renderers, whose scales lean to the root where hair's lean to the tip.
pub(crate) fn chiang(absorption: Vector3<f64>) -> Fallible<Bsdf> {
    Ok(Box::new(ChiangField::new(FiberOptics::hair(absorption, 0.3, 0.3, -SCALES)?)?))
}

/// An angle modulo a turn, in `[-pi, pi]`, rad.
pub(crate) fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// A wisp of wavy fibres that hangs from a height of 30 cm. The curves of other renderers begin and
/// end a node farther inside.
pub(crate) fn wisp(count: u32) -> Vec<FiberCurve> {
    let inside = |fiber: FiberCurve| {
        let nodes = fiber.nodes[1..fiber.nodes.len() - 1].to_vec();
        FiberCurve::round(nodes, RADIUS)
    };
    wavy(count, 48).into_iter().map(inside).collect()
}

/// Fibres in the light of a disc of an angular radius, rad, in a direction.
pub(crate) fn lit(
    fibers: &[FiberCurve],
    bsdf: Bsdf,
    toward: Vector3<f64>,
    angular_radius: f64,
) -> Fallible<RenderScene> {
    let irradiance = Vector3::repeat(IRRADIANCE);
    let lights = Lights::new(&[Light::Distant { toward, irradiance, angular_radius }], None)?;
    let curves = Curves::new(CurveForm::Cubic, None, fibers)?;
    let look = FiberLook::Scattering { bsdf, albedo: Vector3::repeat(0.5) };
    Ok(RenderScene::new(vec![Hairs { curves, look }], Vec::new(), lights)?)
}

/// The camera of the scene of orders: from the front, at 48 cm, over an angle of 20 degrees.
pub(crate) fn front() -> Fallible<Camera> {
    let (at, target) = (Point3::new(0.0, -0.48, 0.18), Point3::new(0.0, 0.0, 0.18));
    let view = Projection::Perspective { field_of_view: 20.0_f64.to_radians() };
    Ok(Camera::new(at, &target, &Vector3::z(), view)?)
}

/// A picture and what it says of hair.
pub(crate) struct Shot {
    film: Film,
    /// Mean radiance of hair, W/(m^2 sr): of all pixels over their mean coverage.
    pub(crate) mean: Vector3<f64>,
    /// Standard error of its luminance over that.
    pub(crate) error: f64,
}

impl Shot {
    /// A picture of a size and so many samples; `order` as in [`PathTracer`].
    pub(crate) fn of(
        scene: &RenderScene,
        camera: &Camera,
        order: Option<u32>,
        size: [u32; 2],
        samples: u32,
    ) -> Fallible<Self> {
        let mut film = Film::new(size)?;
        let tracer = PathTracer { scene, camera, seed: 6, order, search: LightSearch::Both };
        tracer.expose(&mut film, samples, &|| false);
        if film.rejected() > 0 {
            return Err("a sample is not finite".into());
        }
        let pixels = film.pixels();
        let coverage: f64 = pixels.iter().map(|p| p.coverage()).sum();
        let mean = pixels.iter().map(|p| p.radiance()).sum::<Vector3<f64>>() / coverage;
        let spread = film.standard_error().ok_or("one sample has no error")?;
        let error = spread * (pixels.len() as f64).sqrt() / coverage / luminance(&mean);
        Ok(Self { film, mean, error })
    }

    /// The picture, so many stops brighter, before grey.
    pub(crate) fn image(&self, caption: impl Into<String>, exposure: f64) -> Image {
        let pixel = |p: &rapunzel_render::FilmPixel| {
            let behind = Vector3::repeat(BACKDROP * (2.0_f64).powf(2.5 - exposure));
            let seen = p.radiance() + behind * (1.0 - p.coverage());
            Tone::Filmic.encoded(&seen, exposure).map(byte)
        };
        let pixels = self.film.pixels().iter().map(pixel).collect();
        Image { caption: caption.into(), width: self.film.size()[0] as usize, pixels }
    }

    /// Mean radiance of the columns, left to right.
    pub(crate) fn columns(&self) -> Vec<Vector3<f64>> {
        let [width, height] = self.film.size().map(|n| n as usize);
        let pixels = self.film.pixels();
        let column = |x: usize| {
            let all = (0..height).map(|y| pixels[y * width + x].radiance());
            all.sum::<Vector3<f64>>() / height as f64
        };
        (0..width).map(column).collect()
    }
}

/// A value in `[0, 1]` in 8 bits.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in [0, 255]")]
fn byte(value: f64) -> u8 {
    (255.0 * value).round() as u8
}

/// As the eye weighs colors (sRGB).
pub(crate) fn luminance(color: &Vector3<f64>) -> f64 {
    color.dot(&Vector3::new(0.2126, 0.7152, 0.0722))
}

/// Pictures side by side, whose pixels are so large, m.
pub(crate) fn images(
    title: &str,
    legend: &str,
    pixel: f64,
    columns: usize,
    images: Vec<Image>,
) -> Drawing {
    Drawing::Images(Images { title: title.into(), legend: legend.into(), pixel, columns, images })
}
