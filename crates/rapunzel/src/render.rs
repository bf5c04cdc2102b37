use crate::arguments::{CameraPlace, RenderOptions};
use crate::failure::{Failure, INTERRUPTED};
use crate::run::{CANCEL, catch_interrupts, start_threads};
use crate::words::{build_stage, complain, growth_stage, say, spinner};
use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::{Point3, Vector3};
use rapunzel_render::{
    Camera, CurveForm, Film, FilmKey, LightSearch, PathTracer, Projection, RenderError,
    RenderScene, Sky, Tone, read_exr_map, write_exr, write_png,
};
use rapunzel_sim::{Shown, ShownFrame, ShownStage, SimError, write_atomically};
use rapunzel_studio::{
    ColorRange, Coloring, HairLook, StageOptions, StudioError, camera_around, hull, points, staged,
    write_with_legend,
};
use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::time::Instant;

/// Samples of a pixel between two marks of the progress bar.
const PASS: u32 = 4;
/// Frames of a film for each second of it, where nothing else is known.
const FILM_RATE: u32 = 24;
/// Longer side, pixels, and samples of a pixel of the pictures that tell what an order leaves out.
const PROBE: f64 = 96.0;
const PROBE_SAMPLES: u32 = 32;
/// Points of a frame that tell where it is.
const TELLING: usize = 20_000;

/// Draws pictures.
pub(crate) fn render(options: &RenderOptions, json: bool) -> Result<ExitCode, Failure> {
    start_threads(options.threads)?;
    catch_interrupts("interrupted: nothing is drawn")?;
    let path = &options.what;
    let bar = spinner(json);
    let at = |stage: ShownStage| match stage {
        ShownStage::Building(stage) => bar.set_message(build_stage(stage)),
        ShownStage::Growing(stage) => bar.set_message(growth_stage(stage)),
    };
    let shown = Shown::open(path, &at);
    bar.finish_and_clear();
    let shown = shown.map_err(Failure::of(path))?;
    let many = options.film || options.turntable.is_some();
    let pictures = pictures(options, &shown)?;
    let out = options.out.clone().unwrap_or_else(|| default_out(path, many));
    let folder = if many { Some(out.as_path()) } else { out.parent() };
    if let Some(folder) = folder {
        fs::create_dir_all(folder).map_err(|error| unusable(folder, &error))?;
    }
    let series = Series::new(&shown, &pictures, options.color_by).map_err(Failure::of(path))?;
    let stage_options = stage_options(options, &shown, &series)?;
    let start = Instant::now();
    let mut told = Vec::new();
    for (number, (index, turn)) in pictures.iter().enumerate() {
        let ShownFrame { frame, objects } = shown.frame(*index).map_err(Failure::of(path))?;
        let scene = staged(&frame, &objects, &stage_options).map_err(of_studio(path))?;
        let camera = camera(options, &series.points, *turn).map_err(of_studio(path))?;
        let file = if many { out.join(format!("picture-{number:04}.png")) } else { out.clone() };
        let Some(film) = expose(options, &scene, &camera, &file, json)? else {
            return Ok(ExitCode::from(INTERRUPTED));
        };
        write(options, &film, stage_options.coloring.as_ref(), &file)?;
        let left_out = options.order.map(|_| left_out(options, &scene, &camera));
        told.push(tell(&film, &file, start.elapsed().as_secs_f64(), left_out, json)?);
    }
    let joined = if many { encode(&out) } else { None };
    if json {
        say(&serde_json::json!({ "pictures": told, "film": joined }).to_string())?;
    } else if let Some(film) = joined {
        say(&film.display().to_string())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// What all pictures have in common.
struct Series {
    /// Points that a camera should have in its picture, m: of every frame as many as tell.
    points: Vec<Point3<f64>>,
    coloring: Option<(Coloring, ColorRange)>,
}

impl Series {
    fn new(
        shown: &Shown,
        pictures: &[(usize, f64)],
        color_by: Option<Coloring>,
    ) -> Result<Self, SimError> {
        let mut indices: Vec<_> = pictures.iter().map(|(index, _)| *index).collect();
        indices.dedup();
        let (mut all, mut range) = (Vec::new(), ColorRange::of([]));
        for index in &indices {
            let ShownFrame { frame, objects } = shown.frame(*index)?;
            let points = points(&frame, &objects);
            let every = if indices.len() > 1 { points.len().div_ceil(TELLING) } else { 1 };
            all.extend(points.into_iter().step_by(every.max(1)));
            if let Some(coloring) = color_by {
                let of = ColorRange::of(coloring.values(&frame));
                range = ColorRange::of([range.low, range.high, of.low, of.high]);
            }
        }
        Ok(Self { points: all, coloring: color_by.map(|coloring| (coloring, range)) })
    }
}

/// Indices of the frames to draw, each with the angle, degrees, by which the camera is turned.
fn pictures(options: &RenderOptions, shown: &Shown) -> Result<Vec<(usize, f64)>, Failure> {
    let last = shown.count() - 1;
    if options.film {
        return Ok((0..=last).map(|index| (index, 0.0)).collect());
    }
    if let Some(count) = options.turntable {
        let turn = |k: u16| (last, 360.0 * f64::from(k) / f64::from(count));
        return Ok((0..count).map(turn).collect());
    }
    match options.frame {
        Some(frame) if frame > last => Err(Failure::File(format!(
            "{} has the frames 0 to {last}, and no frame {frame}",
            options.what.display()
        ))),
        frame => Ok(vec![(frame.unwrap_or(last), 0.0)]),
    }
}

/// The camera, turned by an angle, degrees.
fn camera(
    options: &RenderOptions,
    points: &[Point3<f64>],
    turn: f64,
) -> Result<Camera, StudioError> {
    let view = options.view.to_radians();
    match options.camera {
        CameraPlace::Around([azimuth, elevation]) => {
            let aspect = f64::from(options.size[0]) / f64::from(options.size[1]);
            camera_around(points, [azimuth + turn, elevation].map(f64::to_radians), view, aspect)
        }
        CameraPlace::At(places) => {
            let [from, to] = places.map(Point3::from);
            let projection = Projection::Perspective { field_of_view: view };
            let level = (to - from).xy().norm() > 1e-6 * (to - from).norm();
            let up = if level { Vector3::z() } else { Vector3::y() };
            Ok(Camera::new(from, &to, &up, projection)?)
        }
    }
}

fn stage_options(
    options: &RenderOptions,
    shown: &Shown,
    series: &Series,
) -> Result<StageOptions, Failure> {
    let sky = options.sky.as_ref().map(|path| sky(path)).transpose()?;
    Ok(StageOptions {
        look: HairLook { pigments: options.hair, model: options.model, ..HairLook::default() },
        coloring: series.coloring,
        form: if options.linear { CurveForm::Linear } else { CurveForm::Cubic },
        ratio: shown.ratio(),
        thickness: options.thickness,
        exposure: options.shutter,
        ground: !options.no_ground,
        sky,
        hull: hull(&series.points),
    })
}

fn sky(path: &Path) -> Result<Sky, Failure> {
    let file = File::open(path).map_err(|error| unusable(path, &error))?;
    let map = read_exr_map(BufReader::new(file), &Vector3::z(), 0.0);
    map.map(Sky::Map).map_err(|error| Failure::File(format!("{}: {error}", path.display())))
}

/// Fills a film; none if it was interrupted, and then what there is of it lies beside the picture.
fn expose(
    options: &RenderOptions,
    scene: &RenderScene,
    camera: &Camera,
    file: &Path,
    json: bool,
) -> Result<Option<Film>, Failure> {
    let of = |error: RenderError| failed(file, &error);
    let tracer = tracer(options, scene, camera);
    let key = FilmKey { seed: options.seed, hash: hash(options, camera) };
    let kept = file.with_extension("part");
    let mut film = Film::new(options.size).map_err(of)?;
    if options.resume {
        let input = File::open(&kept).map_err(|error| unusable(&kept, &error))?;
        film = Film::read_state(&mut BufReader::new(input), &key).map_err(of)?;
    }
    let bar = if json { ProgressBar::hidden() } else { progress_bar(options.samples) };
    let stop = || CANCEL.hear();
    let mut done = 0;
    while done < options.samples && !stop() {
        done = (done + PASS).min(options.samples);
        tracer.expose(&mut film, done, &stop);
        bar.set_position(u64::from(done));
    }
    bar.finish_and_clear();
    if stop() {
        write_atomically(&kept, |to| film.write_state(to, &key).map_err(io::Error::other))
            .map_err(Failure::of(file))?;
        complain(&format!(
            "interrupted: {} holds what there is, and --resume goes on with it",
            kept.display()
        ));
        return Ok(None);
    }
    if options.resume {
        // What it held is in the picture.
        let _ = fs::remove_file(&kept);
    }
    Ok(Some(film))
}

fn tracer<'a>(
    options: &RenderOptions,
    scene: &'a RenderScene,
    camera: &'a Camera,
) -> PathTracer<'a> {
    let RenderOptions { seed, order, .. } = *options;
    PathTracer { scene, camera, seed, order, search: LightSearch::Both }
}

/// Which part of the light from fibres the order leaves out, by a small picture.
fn left_out(options: &RenderOptions, scene: &RenderScene, camera: &Camera) -> f64 {
    let [width, height] = options.size.map(f64::from);
    let scale = (PROBE / width.max(height)).min(1.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
    let size = [width, height].map(|side| (side * scale).ceil() as u32);
    tracer(options, scene, camera).left_out(size, PROBE_SAMPLES)
}

/// A number of all that decides the samples of a picture, as far as the command line says it.
fn hash(options: &RenderOptions, camera: &Camera) -> [u8; 32] {
    let RenderOptions { what, frame, size, order, hair, model, color_by, linear, .. } = options;
    let RenderOptions { no_ground, sky, shutter, thickness, .. } = options;
    let text = format!(
        "{what:?} {frame:?} {size:?} {order:?} {hair:?} {model:?} {color_by:?} {linear} {no_ground} \
         {sky:?} {shutter} {thickness} {camera:?}"
    );
    *blake3::hash(text.as_bytes()).as_bytes()
}

fn write(
    options: &RenderOptions,
    film: &Film,
    coloring: Option<&(Coloring, ColorRange)>,
    file: &Path,
) -> Result<(), Failure> {
    let (tone, exposure) = (Tone::Filmic, options.exposure);
    write_atomically(file, |to| match coloring {
        Some((coloring, range)) => {
            let tone = (Tone::Srgb, exposure);
            write_with_legend(to, film, tone, (*coloring, range)).map_err(io::Error::other)
        }
        None => write_png(to, film, tone, exposure, false).map_err(io::Error::other),
    })
    .map_err(Failure::of(file))?;
    if options.exr {
        let file = file.with_extension("exr");
        let wrote = write_atomically(&file, |to| write_exr(to, film).map_err(io::Error::other));
        wrote.map_err(Failure::of(&file))?;
    }
    Ok(())
}

/// Says what a picture is like, and gives it as JSON.
fn tell(
    film: &Film,
    file: &Path,
    seconds: f64,
    left_out: Option<f64>,
    json: bool,
) -> Result<serde_json::Value, Failure> {
    let count = film.pixels().len() as f64;
    let mean: Vector3<f64> =
        film.pixels().iter().map(|pixel| pixel.radiance()).sum::<Vector3<f64>>() / count;
    let error = film.standard_error().map(|error| error / count.sqrt());
    if film.rejected() > 0 {
        complain(&format!("warning: {} samples were no numbers, and left out", film.rejected()));
    }
    let object = serde_json::json!({
        "file": file, "wall_seconds": seconds, "mean_radiance": mean.as_slice(),
        "standard_error": error, "rejected": film.rejected(), "left_out_by_order": left_out,
    });
    if json {
        return Ok(object);
    }
    let noise = film.standard_error().filter(|_| mean.mean() > 0.0);
    let noise = noise.map_or(String::new(), |error| {
        format!(", noise of a pixel {:.1} % of the mean", 100.0 * error / mean.mean())
    });
    let order = left_out.map_or(String::new(), |part| {
        format!(", the order leaves out some {:.0} % of the light from fibres", 100.0 * part)
    });
    say(&format!("{}  {seconds:.1} s{noise}{order}", file.display()))?;
    Ok(object)
}

/// Joins numbered pictures to a film, where there is an encoder; its file.
fn encode(folder: &Path) -> Option<PathBuf> {
    let film = folder.join("film.mp4");
    let rate = FILM_RATE.to_string();
    let status = Command::new("ffmpeg")
        .args(["-y", "-loglevel", "error", "-framerate", &rate, "-i"])
        .arg(folder.join("picture-%04d.png"))
        .args(["-pix_fmt", "yuv420p", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"])
        .arg(&film)
        .stdin(Stdio::null())
        .status();
    match status {
        Ok(status) if status.success() => return Some(film),
        Ok(_) => complain("warning: ffmpeg made no film of the pictures"),
        Err(_) => complain("there is no ffmpeg here: the numbered pictures are the film"),
    }
    None
}

/// The picture among the runs, or the folder of pictures there.
fn default_out(what: &Path, many: bool) -> PathBuf {
    let stem = what.file_stem().unwrap_or_default().to_string_lossy();
    Path::new("runs").join(if many { format!("{stem}-film") } else { format!("{stem}.png") })
}

fn progress_bar(samples: u32) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos} of {len} samples  {eta} left");
    let bar = ProgressBar::new(u64::from(samples));
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn unusable(path: &Path, error: &io::Error) -> Failure {
    Failure::File(format!("cannot use {}: {error}", path.display()))
}

fn failed(path: &Path, error: &RenderError) -> Failure {
    Failure::File(format!("{}: {error}", path.display()))
}

fn of_studio(path: &Path) -> impl Fn(StudioError) -> Failure {
    move |error| Failure::File(format!("{}: {error}", path.display()))
}
