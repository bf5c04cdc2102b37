//! Writes a swinging lock in every format into the folder that is named on the command line.

use nalgebra::{Point3, Vector3};
use rapunzel_fiber::generate::{Handedness, Helix, Lock, root_pose};
use rapunzel_fiber::{Fiber, Material, Section, so3};
use rapunzel_sim::export::{Frame, Strand, hair, pov, preview, pvd, usda, vtp};
use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Write};
use std::path::Path;

const FRAMES: usize = 9;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("name the folder to write to")?;
    fs::create_dir_all(&folder)?;
    write(Path::new(&folder), &sample()?)
}

/// A curly lock that swings like a pendulum.
fn sample() -> Result<Vec<Frame>, Box<dyn Error>> {
    let pose = root_pose(Point3::new(0.0, 0.0, 0.3), &-Vector3::z())?;
    let section = Section::Ellipse { a: 40e-6, b: 30e-6 };
    let straight = Fiber::uniform(0.25, 100, section, &Material::HAIR)?.with_root(pose);
    let curl = Helix { radius: 0.006, pitch: 0.07, handedness: Handedness::Right };
    let lock = Lock { count: 180, radius: 0.012, curvature_variation: 0.15, clumping: 0.8 };
    let fibers = lock.grow(&curl.bend(straight)?, 1)?;
    let frame = |index: usize| {
        let time = index as f64 / 24.0;
        let swing = Vector3::y() * (0.9 * (5.0 * time).cos());
        let strands = fibers.iter().map(|f| strand(f, &swing)).collect();
        Frame { index, time, strands }
    };
    Ok((0..FRAMES).map(frame).collect())
}

fn strand(fiber: &Fiber, swing: &Vector3<f64>) -> Strand {
    let turn = so3::exp(swing);
    let pivot = Point3::new(0.0, 0.0, 0.3);
    let (points, frames) = fiber.rest_shape();
    let points: Vec<_> = points.iter().map(|p| pivot + turn * (p - pivot)).collect();
    let segments = fiber.segments();
    Strand {
        radii: fiber.nodes().iter().map(|n| n.section.equivalent_radius()).collect(),
        velocities: points.iter().map(|p| swing.cross(&(p - pivot))).collect(),
        frames: frames[..segments].iter().map(|r| turn * r).collect(),
        curvatures: fiber.nodes().iter().map(|n| n.natural_curvature).collect(),
        forces: (0..segments).map(|j| 1e-6 * (segments - j) as f64 * -Vector3::z()).collect(),
        points,
    }
}

fn write(folder: &Path, frames: &[Frame]) -> Result<(), Box<dyn Error>> {
    let create = |name: &str| File::create(folder.join(name)).map(BufWriter::new);
    let names: Vec<String> = frames.iter().map(|f| format!("frame{}.vtp", f.index)).collect();
    let times: Vec<f64> = frames.iter().map(|f| f.time).collect();
    for (frame, name) in frames.iter().zip(&names) {
        let mut out = create(name)?;
        vtp::write(&mut out, frame)?;
        out.flush()?;
        fs::write(folder.join(name).with_extension("csv"), csv(frame)?)?;
    }
    pvd::write(
        &mut create("frames.pvd")?,
        times.iter().copied().zip(names.iter().map(String::as_str)),
    )?;
    // As after a crash: from the files of the frames.
    let read = |name: &String| vtp::read(&mut BufReader::new(File::open(folder.join(name))?));
    for (name, curve) in
        [("linear.usda", usda::Curve::Linear), ("smooth.usda", usda::Curve::CatmullRom)]
    {
        usda::write(&mut create(name)?, curve, &times, names.iter().map(read))?;
    }
    hair::write(&mut create("frame4.hair")?, &frames[4])?;
    pov::write(&mut create("frame4.inc")?, &frames[4])?;
    preview::write(&mut create("preview.png")?, frames)?;
    Ok(())
}

/// Points of `frame` as a table that names every bit.
fn csv(frame: &Frame) -> Result<String, std::fmt::Error> {
    let mut table = "fiber,x,y,z,radius,tension\n".to_owned();
    for (fiber, strand) in frame.strands.iter().enumerate() {
        for (i, (p, radius)) in strand.points.iter().zip(&strand.radii).enumerate() {
            let segment = i.min(strand.frames.len() - 1);
            let tangent = strand.frames[segment].matrix().column(2).into_owned();
            let tension = tangent.dot(&strand.forces[segment]);
            writeln!(table, "{fiber},{},{},{},{radius},{tension}", p.x, p.y, p.z)?;
        }
    }
    Ok(table)
}
