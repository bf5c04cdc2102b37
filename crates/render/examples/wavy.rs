//! The scene that renderers are compared by: `wavy FIBRES SAMPLES [chiang|near|far] [FILE.png]`.
//!
//! It prints the mean of the picture, its standard error, and what it cost, a name, a value and a
//! unit per line.
#![expect(clippy::print_stdout, reason = "it is what the example is for")]

#[path = "../tests/it/wavy.rs"]
mod wavy;

use nalgebra::{Point3, Vector3};
use rapunzel_fiber::Section;
use rapunzel_render::{
    Camera, CurveForm, Curves, FiberLook, Film, Hairs, Light, LightSearch, Lights, PathTracer,
    Projection, RenderScene, Sky, Tone, write_png,
};
use rapunzel_scattering::{ChiangField, FarField, FiberBsdf, FiberOptics, NearField};
use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::time::Instant;

/// Angle of the scales, rad: 3 degrees, which other renderers take to lean to the root where hair's
/// lean to the tip.
const SCALES: f64 = -0.052_359_877_559_829_89;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let word = |k: usize, default: &str| arguments.get(k).map_or(default.to_owned(), Clone::clone);
    let (count, samples): (u32, u32) = (word(0, "1000").parse()?, word(1, "64").parse()?);
    let absorption = Vector3::new(0.06, 0.10, 0.20);
    let optics = FiberOptics::hair(absorption, 0.3, 0.3, SCALES)?;
    let bsdf: Box<dyn FiberBsdf + Send + Sync> = match word(2, "chiang").as_str() {
        "near" => Box::new(NearField::new(optics, &Section::Circle { radius: wavy::RADIUS })?),
        "far" => Box::new(FarField::new(optics)?),
        _ => Box::new(ChiangField::new(optics)?),
    };
    let begun = Instant::now();
    let curves = Curves::new(CurveForm::Cubic, None, &wavy::wavy(count, 48))?;
    println!("build {:.3} s", begun.elapsed().as_secs_f64());
    println!("memory_of_curves {:.1} MiB", curves.bytes() as f64 / 1_048_576.0);
    let look = FiberLook::Scattering { bsdf, albedo: Vector3::repeat(0.5) };
    let scene = RenderScene::new(vec![Hairs { curves, look }], Vec::new(), lights()?)?;
    let (at, target) = (Point3::new(0.0, -0.48, 0.15), Point3::new(0.0, 0.0, 0.15));
    let view = Projection::Perspective { field_of_view: 36.0_f64.to_radians() };
    let camera = Camera::new(at, &target, &Vector3::z(), view)?;
    let tracer = PathTracer {
        scene: &scene,
        camera: &camera,
        seed: 1,
        order: Some(4),
        search: LightSearch::Both,
    };
    let mut film = Film::new([256; 2])?;
    let begun = Instant::now();
    tracer.expose(&mut film, samples, &|| false);
    let seconds = begun.elapsed().as_secs_f64();
    println!("render {seconds:.3} s");
    let traced = f64::from(256 * 256 * samples) / 1e6;
    println!("throughput {:.4} Msamples/s", traced / seconds);
    let pixels = film.pixels();
    let mean: Vector3<f64> =
        pixels.iter().map(|p| p.radiance()).sum::<Vector3<f64>>() / pixels.len() as f64;
    println!("mean_rgb {:.5},{:.5},{:.5} radiance", mean.x, mean.y, mean.z);
    if let Some(path) = arguments.get(3) {
        write_png(BufWriter::new(File::create(path)?), &film, Tone::Srgb, 0.0, false)?;
    }
    Ok(())
}

/// A square light of 12 cm, above on the right, and a grey sky.
fn lights() -> Result<Lights, Box<dyn Error>> {
    let center = Point3::new(0.2, -0.3, 0.45);
    let toward = (Point3::new(0.0, 0.0, 0.15) - center).normalize();
    let side = toward.cross(&Vector3::z()).normalize();
    let half_edges = [0.06 * side, 0.06 * toward.cross(&side)];
    let light = Light::Rectangle { center, half_edges, radiance: Vector3::repeat(20.0) };
    Ok(Lights::new(&[light], Some(Sky::Constant(Vector3::repeat(0.3))))?)
}
