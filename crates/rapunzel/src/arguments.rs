use crate::templates;
use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand};
use rapunzel_keratin::lab::Instrument;
use rapunzel_keratin::{HairType, Thickness, Treatment};
use rapunzel_scattering::Pigments;
use rapunzel_studio::{Coloring, HairModel, pigments};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::str::FromStr;

/// Simulates hair and other slender fibres, fibre by fibre.
#[derive(Debug, Parser)]
#[command(version, after_help = AFTER_HELP, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print one JSON object to the standard output instead of text.
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Memory that a scene may be expected to take, GB [default: what this machine has for the
    /// program].
    #[arg(long, global = true, value_name = "GB", value_parser = gigabytes)]
    pub(crate) memory: Option<f64>,
}

/// Gigabytes as bytes.
fn gigabytes(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 => Ok(number * 1e9),
        _ => Err("must be a positive number".into()),
    }
}

const AFTER_HELP: &str = "\
Begin with:
  rapunzel new lock-under-gravity
  rapunzel run lock-under-gravity.ron
  rapunzel render runs/lock-under-gravity
or, for a rod at rest:
  rapunzel new static/hose-between-flanges
  rapunzel solve hose-between-flanges.ron
or, for a hairstyle:
  rapunzel new style/bob
  rapunzel grow bob.ron

Exit codes:
  0    done
  1    the physics does not come out: a step could not be solved, energy came from nowhere, or a case
       has no answer
  2    the command line is wrong
  3    the scene or the case is wrong
  4    a file or folder cannot be used
  5    done, but contacts or charged fibres missed their tolerances in some steps, or a case has no
       stable equilibrium that was found, as the report says
  130  interrupted; the run can be resumed";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a scene into a folder.
    Run(RunOptions),
    /// Read a scene and say what it would do.
    Check {
        /// The scene, a RON file.
        scene: PathBuf,
    },
    /// Find how one rod lies at rest: where it goes, what its ends carry, how long it must be.
    Solve(SolveOptions),
    /// Grow a hairstyle on a head.
    Grow(GrowOptions),
    /// Write a scene, a case or a style to begin with.
    #[command(arg_required_else_help = true)]
    New(NewOptions),
    /// Measure hair with an instrument of the laboratory, on simulated fibres, and plot what it
    /// reads.
    #[command(arg_required_else_help = true)]
    Lab(LabOptions),
    /// Draw a run, a scene, a style or a file of strands as a picture or a film.
    Render(RenderOptions),
    /// Show a scene that runs, a recorded run, a style or strands in a browser, with hands on it.
    View(ViewOptions),
    /// Say how the run in a folder stands.
    Info {
        /// The folder of a run.
        folder: PathBuf,
    },
}

#[derive(Debug, Args)]
pub(crate) struct RunOptions {
    /// The scene, a RON file.
    pub(crate) scene: PathBuf,
    /// The folder of the run [default: runs/ and the name of the scene].
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
    /// Go on with the run in the folder, from its last checkpoint.
    #[arg(long, conflicts_with = "force")]
    pub(crate) resume: bool,
    /// Start anew. The run that is in the folder is removed once the new one has a frame.
    #[arg(long)]
    pub(crate) force: bool,
    /// Threads, at most four for each core [default: all cores]. The results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Seconds of computing that a loss of power may cost: so often all is written through to the
    /// disk. A kill costs no whole frame.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, value_parser = seconds)]
    pub(crate) sync_every: f64,
}

fn seconds(text: &str) -> Result<f64, String> {
    let within = |x: &f64| (0.0..=86400.0).contains(x);
    text.parse().ok().filter(within).ok_or_else(|| "it must be 0 to 86400 seconds".to_owned())
}

#[derive(Debug, Args)]
pub(crate) struct SolveOptions {
    /// The case, a RON file.
    pub(crate) case: PathBuf,
    /// The folder of the answer, whose files are overwritten [default: runs/ and the name of the
    /// case].
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct GrowOptions {
    /// The style, a RON file.
    pub(crate) style: PathBuf,
    /// The folder of the hairs, whose files are overwritten [default: runs/ and the name of the
    /// style].
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct RenderOptions {
    /// The folder of a run or of a grown style, a scene or a style (RON), or a file of strands
    /// (usda, usdc, usdz, hair, data, obj, ply) or of a frame (vtp).
    pub(crate) what: PathBuf,
    /// The picture, a PNG; an EXR beside it if --exr [default: runs/NAME.png, or the folder
    /// runs/NAME-film].
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// The frame of a run, from 0 [default: the last].
    #[arg(long, conflicts_with_all = ["film", "turntable"])]
    pub(crate) frame: Option<usize>,
    /// Draw every frame of a run, into a folder of numbered pictures, and a film if ffmpeg is
    /// there.
    #[arg(long, conflicts_with = "turntable")]
    pub(crate) film: bool,
    /// Draw so many pictures around the last frame.
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(2..))]
    pub(crate) turntable: Option<u16>,
    /// Width and height, pixels.
    #[arg(long, default_value = "960x720", value_parser = size)]
    pub(crate) size: [u32; 2],
    /// Where the camera is: front, right, back, left, top, or AZIMUTH,ELEVATION in degrees, around
    /// all that is shown; or X,Y,Z:X,Y,Z, its place and what it looks at, m.
    #[arg(long, default_value = "20,12", value_parser = CameraPlace::from_str, allow_hyphen_values = true)]
    pub(crate) camera: CameraPlace,
    /// Field of view across the picture, degrees.
    #[arg(long, default_value_t = 30.0, value_parser = degrees)]
    pub(crate) view: f64,
    /// Paths for each pixel.
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) samples: u32,
    /// Order of scattering after which paths end: 0 is light that one fibre has scattered
    /// [default: paths end by chance, and nothing is left out].
    #[arg(long)]
    pub(crate) order: Option<u32>,
    /// Color of the hair: white, blond, brown, red or black.
    #[arg(long, default_value = "brown", value_parser = pigments)]
    pub(crate) hair: Pigments,
    /// Model of the scattering: near, far, or chiang, that of other renderers.
    #[arg(long, default_value = "near", value_parser = HairModel::from_str)]
    pub(crate) model: HairModel,
    /// Color fibres by strain, curvature, tension, speed, contact (force), charge or fibre instead,
    /// with a legend.
    #[arg(long, value_name = "QUANTITY", value_parser = Coloring::from_str)]
    pub(crate) color_by: Option<Coloring>,
    /// Straight pieces from node to node instead of smooth curves.
    #[arg(long)]
    pub(crate) linear: bool,
    /// How many times as thick fibres are drawn, where each stands for many.
    #[arg(long, default_value_t = 1.0, value_name = "TIMES")]
    pub(crate) thickness: f64,
    /// Leave the ground out.
    #[arg(long)]
    pub(crate) no_ground: bool,
    /// Light of the sky from an EXR in latitude and longitude instead of that of a studio.
    #[arg(long, value_name = "EXR")]
    pub(crate) sky: Option<PathBuf>,
    /// Time of exposure, s, for which fibres blur by their velocities.
    #[arg(long, default_value_t = 0.0, value_name = "SECONDS")]
    pub(crate) shutter: f64,
    /// Stops by which the picture is brightened.
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true)]
    pub(crate) exposure: f64,
    /// Write an EXR too, with albedo, normal, depth and number of the fibre.
    #[arg(long)]
    pub(crate) exr: bool,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Go on with the picture that was interrupted.
    #[arg(long, conflicts_with_all = ["film", "turntable"])]
    pub(crate) resume: bool,
    /// Threads, at most four for each core [default: all cores]. The picture does not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
}

#[derive(Debug, Args)]
pub(crate) struct ViewOptions {
    /// A scene or a style (RON), the folder of a run or of a grown style, or a file of strands or
    /// of a frame [default: a gallery of the scenes that ship].
    pub(crate) what: Option<PathBuf>,
    /// Another run, style or file of strands, which is shown beside WHAT or over it.
    #[arg(long, value_name = "WHAT", requires = "what")]
    pub(crate) beside: Option<PathBuf>,
    /// The address and port to listen at, 0 for any free port. Where other machines reach it, pages
    /// must bring a token, which is in the address that is printed.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:0")]
    pub(crate) listen: SocketAddr,
    /// Let the scene run from the start.
    #[arg(long)]
    pub(crate) run: bool,
    /// Open no browser.
    #[arg(long)]
    pub(crate) no_browser: bool,
    /// Threads, at most four for each core [default: all cores]. What is simulated does not depend
    /// on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
}

/// Width and height.
fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).map(|(w, h)| [w.parse(), h.parse()]);
    match sides {
        Some([Ok(width), Ok(height)]) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("it must be WIDTHxHEIGHT, such as 960x720".into()),
    }
}

fn degrees(text: &str) -> Result<f64, String> {
    let within = |x: &f64| *x >= 0.1 && *x <= 150.0;
    text.parse().ok().filter(within).ok_or_else(|| "it must be 0.1 to 150 degrees".to_owned())
}

/// Where a camera is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum CameraPlace {
    /// Around all that is shown: azimuth from the front to the right, and elevation, degrees.
    Around([f64; 2]),
    /// At a place, m, looking at another.
    At([[f64; 3]; 2]),
}

impl FromStr for CameraPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = |text: &str| -> Option<Vec<f64>> {
            text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect()
        };
        let around = match text {
            "front" => Some([0.0, 0.0]),
            "right" => Some([90.0, 0.0]),
            "back" => Some([180.0, 0.0]),
            "left" => Some([-90.0, 0.0]),
            "top" => Some([0.0, 90.0]),
            _ => numbers(text).and_then(|angles| angles.try_into().ok()),
        };
        let at = text.split_once(':').and_then(|(from, to)| {
            Some([numbers(from)?.try_into().ok()?, numbers(to)?.try_into().ok()?])
        });
        match (around, at) {
            (Some([_, elevation]), _) if !(-90.0..=90.0).contains(&elevation) => {
                Err("the elevation must be -90 to 90 degrees".into())
            }
            (Some(angles), _) => Ok(Self::Around(angles)),
            (_, Some(places)) => Ok(Self::At(places)),
            _ => Err(format!(
                "\"{text}\" is no place of a camera: take front, right, back, left, top, \
                 AZIMUTH,ELEVATION or X,Y,Z:X,Y,Z"
            )),
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct LabOptions {
    /// tensile, hysteresis, hook, pendulum, oscillation, capstan, waviness, curl-retention,
    /// tress-volume or combing.
    #[arg(value_parser = Instrument::from_str)]
    pub(crate) instrument: Instrument,
    /// The type of hair: West European, Chinese, Indian, African, Caucasian, Mongolian or
    /// Ethiopian.
    #[arg(long = "type", value_name = "TYPE", value_parser = HairType::from_str)]
    pub(crate) kind: HairType,
    /// Relative humidity, a fraction; 1 is wet.
    #[arg(long, default_value_t = 0.65)]
    pub(crate) humidity: f64,
    /// Temperature, C.
    #[arg(long, default_value_t = 23.0)]
    pub(crate) temperature: f64,
    /// The treatment: none, untreated, bleached, dyed blond, dyed black, permed or relaxed.
    #[arg(long, default_value = "none", value_parser = Treatment::from_str)]
    pub(crate) treatment: Treatment,
    /// The class of diameters for Young's modulus: any, thin or thick.
    #[arg(long, default_value = "any", value_parser = Thickness::from_str)]
    pub(crate) thickness: Thickness,
    /// Take values also where nobody measured.
    #[arg(long)]
    pub(crate) extrapolate: bool,
    /// What to vary: humidity=0.3:0.9:7 (from, to, how many), temperature likewise, or treatment.
    #[arg(long, value_parser = Sweep::from_str)]
    pub(crate) sweep: Option<Sweep>,
    /// The folder of table and plot, whose files are overwritten [default: runs/lab- and the name
    /// of the instrument].
    #[arg(long, value_name = "FOLDER")]
    pub(crate) out: Option<PathBuf>,
}

/// What a sweep varies.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Sweep {
    Humidity(Vec<f64>),
    Temperature(Vec<f64>),
    Treatment,
}

impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || {
            format!(
                "\"{text}\" is no sweep: take humidity=FROM:TO:COUNT, temperature=FROM:TO:COUNT with at \
                 least two, or treatment"
            )
        };
        let (name, values) = text.split_once('=').unwrap_or((text, ""));
        if name == "treatment" && values.is_empty() {
            return Ok(Self::Treatment);
        }
        let parts: Vec<_> = values.split(':').collect();
        let &[from, to, count] = &parts[..] else { return Err(refused()) };
        let ends = [from, to].map(|x| x.parse::<f64>().ok().filter(|x| x.is_finite()));
        let ([Some(from), Some(to)], Ok(count @ 2..=1000)) = (ends, count.parse::<u16>()) else {
            return Err(refused());
        };
        let last = f64::from(count - 1);
        let values = (0..count).map(|i| from + (to - from) * f64::from(i) / last).collect();
        match name {
            "humidity" => Ok(Self::Humidity(values)),
            "temperature" => Ok(Self::Temperature(values)),
            _ => Err(refused()),
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct NewOptions {
    /// The scene to copy, or the case of a rod at rest, whose name begins with static/, or the
    /// style, with style/.
    #[arg(value_parser = PossibleValuesParser::new(templates::NAMES))]
    pub(crate) template: String,
    /// The file to write [default: the name of the template and .ron].
    pub(crate) file: Option<PathBuf>,
    /// Overwrite the file if it is there.
    #[arg(long)]
    pub(crate) force: bool,
}
