//! Simulates a swinging lock and writes it in every format into the folder that is named on the
//! command line.

use nalgebra::Vector3;
use rapunzel_export::{Frame, Strand, hair, mitsuba, pov, pvd, usd, vtp};
use rapunzel_fiber::Fiber;
use rapunzel_scattering::Pigments;
use rapunzel_sim::{Plan, Scene, World};
use rapunzel_studio::sheet;
use std::error::Error;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Write};
use std::path::Path;

const FRAMES: usize = 9;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("name the folder to write to")?;
    fs::create_dir_all(&folder)?;
    write(Path::new(&folder), &simulated()?)
}

/// The first frames of the scene with the swinging lock.
fn simulated() -> Result<Vec<Frame>, Box<dyn Error>> {
    let scene = Scene::from_ron(include_str!("../../../scenes/lock-under-gravity.ron"))?;
    let (plan, mut world) = (Plan::new(&scene), World::build(&scene)?);
    let mut frames = vec![frame(&world, 0)];
    for index in 1..FRAMES {
        for _ in 0..plan.steps_per_frame {
            world.step(plan.dt)?;
        }
        frames.push(frame(&world, index));
    }
    Ok(frames)
}

fn frame(world: &World, index: usize) -> Frame {
    let strand = |(i, fiber): (usize, &Fiber)| {
        let state = world.state(i);
        let nodes = state.positions.len();
        Strand {
            points: state.positions,
            radii: fiber.nodes().iter().map(|n| n.section.equivalent_radius()).collect(),
            velocities: state.velocities,
            frames: state.frames,
            curvatures: state.curvatures,
            forces: state.forces,
            contact_forces: vec![Vector3::zeros(); nodes],
            charges: vec![0.0; nodes],
        }
    };
    let strands = world.assembly().fibers().iter().enumerate().map(strand).collect();
    Frame { index, time: world.time(), strands }
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
        times.iter().zip(&names).map(|(time, name)| (*time, 0, name.as_str())),
    )?;
    // As after a crash: from the files of the frames.
    let (frames_per_second, end) = (30.0, times[FRAMES - 1]);
    let timeline = usd::Timeline { frames: FRAMES, rate: frames_per_second, end };
    let shape = usd::PrimShape::Curves { strands: 0..frames[0].strands.len(), guide: false };
    let prim = usd::Prim { name: "Lock".to_owned(), shape, color: [0.09, 0.045, 0.02] };
    let open = |index: usize| Ok(BufReader::new(File::open(folder.join(&names[index]))?));
    let strands = usd::Strands::new(timeline, "Fibers", vec![prim], open)?;
    strands.write(&mut create("fibers.usda")?, None)?;
    usd::root(&mut create("scene.usda")?, &timeline, &["fibers.usda"])?;
    hair::write(&mut create("frame4.hair")?, &frames[4])?;
    pov::write(&mut create("frame4.pov")?, &frames[4], &[])?;
    mitsuba::write_curves(&mut create("frame4.txt")?, &frames[4])?;
    let look = mitsuba::MitsubaHair::usual(Pigments::BROWN.absorption()?.into());
    let files = mitsuba::SceneFiles { curves: "frame4.txt", objects: "" };
    mitsuba::write(&mut create("frame4.xml")?, &frames[4], &[], &look, files)?;
    let pictures = frames.iter().cloned().map(|frame| sheet::PreviewFrame::new(frame, Vec::new()));
    let pictures = pictures.collect::<Result<Vec<_>, _>>()?;
    sheet::write(&mut create("preview.png")?, &pictures, &[], &[])?;
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
