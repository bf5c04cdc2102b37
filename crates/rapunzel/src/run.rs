use crate::arguments::RunOptions;
use crate::cost::{Steps, peak_memory};
use crate::failure::{Failure, INTERRUPTED, UNRESOLVED};
use crate::words::{build_stage, complain, say, spinner};
use crate::{check, info};
use indicatif::{ProgressBar, ProgressStyle};
use rapunzel_sim::{
    Cancel, ContactTimes, Control, Existing, MemoryEstimate, Outcome, Progress, RunFolder,
    SimError, Summary, World,
};
use std::fs::File;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{LazyLock, Mutex};
use std::time::{Duration, Instant};

/// The most threads for a core.
const MOST_THREADS: usize = 4;

pub(crate) static CANCEL: Cancel = Cancel::new();
static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);

/// Runs a scene into a folder.
pub(crate) fn run(options: &RunOptions, memory: f64, json: bool) -> Result<ExitCode, Failure> {
    start_threads(options.threads)?;
    let scene = check::read(&options.scene)?;
    let estimate = MemoryEstimate::new(&scene).map_err(Failure::of(&options.scene))?;
    estimate.within(memory).map_err(Failure::of(&options.scene))?;
    let existing = match (options.resume, options.force) {
        (true, _) => Existing::Resume,
        (_, true) => Existing::Overwrite,
        _ => Existing::Refuse,
    };
    let path = options.out.clone().unwrap_or_else(|| default_folder(&options.scene));
    let mut folder =
        RunFolder::open(&path, existing).map_err(|error| advise(error, &options.scene))?;
    folder.protect(&options.scene);
    start_log(&folder.log())?;
    catch_interrupts("interrupted within a step: --resume goes on from the last frame")?;

    let bar = if json { ProgressBar::hidden() } else { progress_bar() };
    let start = Instant::now();
    let (mut first, mut before): (Option<u64>, Option<Progress>) = (None, None);
    let mut progress = |now: &Progress| {
        match before {
            // A resumed run begins in the middle, which must not count as speed.
            None => {
                first = Some(now.steps);
                bar.set_length(now.planned_steps);
                bar.set_position(now.steps);
                bar.reset_eta();
            }
            Some(before) if before.statistics.halvings < now.statistics.halvings => {
                let halvings = now.statistics.halvings - before.statistics.halvings;
                tracing::warn!(time = now.time, halvings, "a step did not converge at once");
            }
            Some(_) => {}
        }
        bar.set_position(now.steps);
        bar.set_message(format!("t = {:.3} s", now.time));
        before = Some(*now);
    };
    let (interval, mut synced) = (Duration::from_secs_f64(options.sync_every), Instant::now());
    let mut sync_is_due = || {
        let due = synced.elapsed() >= interval;
        if due {
            synced = Instant::now();
        }
        due
    };
    let control = Control {
        sync_is_due: &mut sync_is_due,
        cancel: &CANCEL,
        progress: &mut progress,
        stopwatch: Some(|| BEGIN.elapsed()),
    };
    tracing::info!(scene = %options.scene.display(), resume = options.resume, "start");
    estimate.notes.iter().for_each(|note| tracing::warn!("{note}"));
    let run = |world: World| {
        for note in world.notes() {
            tracing::info!("{note}");
            bar.suspend(|| complain(note));
        }
        rapunzel_sim::run(&scene, world, &mut folder, control)
    };
    let building = spinner(json);
    let world = World::build_observed(&scene, &|stage| building.set_message(build_stage(stage)));
    building.finish_and_clear();
    let result = world.and_then(run);
    bar.finish_and_clear();
    let wall = start.elapsed().as_secs_f64();
    let steps = first.zip(before).map_or_else(Steps::default, |(first, last)| Steps {
        taken: last.steps - first,
        times: last.statistics.contact_times,
    });
    match result {
        Ok(summary) => {
            tracing::info!(wall_seconds = wall, outcome = ?summary.outcome, "end");
            tell(&summary, &path, wall, &steps, json)?;
            if folder.holds_older_run() {
                complain(&format!(
                    "stopped before the first frame after its start: nothing of this run is kept, and \
                     {} still holds the run before",
                    path.display()
                ));
            }
            let unresolved = summary.contact.is_some_and(|contact| contact.unresolved > 0)
                || summary.charge.is_some_and(|charge| charge.unsettled > 0);
            Ok(ExitCode::from(match summary.outcome {
                Outcome::Cancelled => INTERRUPTED,
                _ if unresolved => UNRESOLVED,
                _ => 0,
            }))
        }
        Err(error) => {
            tracing::error!(wall_seconds = wall, %error, "end");
            Err(advise(error, &options.scene))
        }
    }
}

/// `runs/` and the name of the scene.
fn default_folder(scene: &Path) -> PathBuf {
    Path::new("runs").join(scene.file_stem().unwrap_or_default())
}

/// The error, with the options of the command line that help.
fn advise(error: SimError, scene: &Path) -> Failure {
    match error {
        SimError::FolderNotEmpty(path) => Failure::File(format!(
            "{} is not empty: go on with the run in it with --resume, start anew with --force, or \
             choose another folder with --out",
            path.display()
        )),
        error => Failure::of(scene)(error),
    }
}

fn tell(
    summary: &Summary,
    folder: &Path,
    wall: f64,
    steps: &Steps,
    json: bool,
) -> Result<(), Failure> {
    if json {
        let ContactTimes { detection, laws, solver, rods } = steps.times;
        let object = serde_json::json!({
            "folder": folder, "wall_seconds": wall, "steps": steps.taken,
            "peak_memory_bytes": peak_memory(),
            "contact_seconds": {
                "solver": solver.as_secs_f64(), "detection": detection.as_secs_f64(),
                "laws": laws.as_secs_f64(), "rods": rods.as_secs_f64(),
            },
            "summary": summary,
        });
        return say(&object.to_string());
    }
    let report = info::report(summary, false);
    let took = steps.report(wall, summary.contact.is_some());
    let memory = peak_memory()
        .map_or(String::new(), |bytes| format!("\n  memory      {:.3} GB at most", bytes * 1e-9));
    say(&format!("{report}\n  took        {took}{memory}\n  results     {}", folder.display()))
}

fn progress_bar() -> ProgressBar {
    let style =
        ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}  {per_sec} steps  {eta} left");
    let bar = ProgressBar::new(0);
    // A constant template is right or wrong for all users alike; wrong, it falls back to plain.
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Appends what happens to the log in the run's folder.
fn start_log(path: &Path) -> Result<(), Failure> {
    let file = File::options()
        .append(true)
        .create(true)
        .open(path)
        .map_err(|error| Failure::File(format!("cannot write {}: {error}", path.display())))?;
    tracing_subscriber::fmt().with_ansi(false).with_writer(Mutex::new(file)).init();
    Ok(())
}

/// How long an interrupt waits for the step at hand.
const PATIENCE: Duration = Duration::from_millis(800);

/// Sets the number of threads, before anything is done in parallel.
pub(crate) fn start_threads(threads: Option<u16>) -> Result<(), Failure> {
    let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
    let (asked, most) = (threads.map_or(cores, usize::from), MOST_THREADS * cores);
    if asked > most {
        complain(&format!("{asked} threads would only slow {cores} cores; {most} are taken"));
    }
    // This thread is one of them: beside them it would have memory of its own, which it hardly
    // uses.
    let pool = rayon::ThreadPoolBuilder::new().use_current_thread();
    pool.num_threads(asked.min(most))
        .build_global()
        .map_err(|error| Failure::File(format!("cannot start threads: {error}")))
}

/// Sets what an interrupt does: the first asks for a checkpoint, and leaves at once if a step does
/// not end soon, saying `unheard`; so does the second. The run then is as a kill leaves it, and
/// goes on from its last frame.
pub(crate) fn catch_interrupts(unheard: &'static str) -> Result<(), Failure> {
    ctrlc::set_handler(move || {
        let asked_before = CANCEL.ask();
        std::thread::sleep(if asked_before { Duration::ZERO } else { PATIENCE });
        if asked_before || !CANCEL.is_heard() {
            complain(unheard);
            std::process::exit(INTERRUPTED.into());
        }
    })
    .map_err(|error| Failure::File(format!("cannot catch interrupts: {error}")))
}
