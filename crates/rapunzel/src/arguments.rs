use crate::templates;
use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Simulates hair and other slender fibres, fibre by fibre.
#[derive(Debug, Parser)]
#[command(version, after_help = AFTER_HELP, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Print one JSON object to the standard output instead of text.
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

const AFTER_HELP: &str = "\
Begin with:
  rapunzel new lock-under-gravity
  rapunzel run lock-under-gravity.ron
or, for a rod at rest:
  rapunzel new static/hose-between-flanges
  rapunzel solve hose-between-flanges.ron

Exit codes:
  0    done
  1    a fibre's step could not be solved, or a case has no answer
  2    the command line is wrong
  3    the scene or the case is wrong
  4    a file or folder cannot be used
  5    done, but contacts missed their tolerances in some steps, as the report says
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
    /// Write a scene or a case to begin with.
    #[command(arg_required_else_help = true)]
    New(NewOptions),
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
    /// Remove the run that is in the folder, and start anew.
    #[arg(long)]
    pub(crate) force: bool,
    /// Threads [default: all cores]. The results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Frames from checkpoint to checkpoint.
    #[arg(long, value_name = "FRAMES", default_value_t = 10)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) checkpoint_every: u64,
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
pub(crate) struct NewOptions {
    /// The scene to copy, or the case of a rod at rest, whose name begins with static/.
    #[arg(value_parser = PossibleValuesParser::new(templates::NAMES))]
    pub(crate) template: String,
    /// The file to write [default: the name of the template and .ron].
    pub(crate) file: Option<PathBuf>,
    /// Overwrite the file if it is there.
    #[arg(long)]
    pub(crate) force: bool,
}
