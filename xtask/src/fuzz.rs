use crate::root;
use anyhow::{Context, Result, bail};
use xshell::{Shell, cmd};

/// Every reader of a user's files, and the folder of files that are mutated.
const READERS: [(&str, &str); 10] = [
    ("scene", "scenes"),
    ("case", "scenes/static"),
    ("ply", "fuzz/seeds/ply"),
    ("stl", "fuzz/seeds/stl"),
    ("obj", "fuzz/seeds/obj"),
    ("curve", "fuzz/seeds/curve"),
    ("strands", "fuzz/seeds/strands"),
    ("style", "fuzz/seeds/style"),
    ("image", "fuzz/seeds/image"),
    ("checkpoint", CHECKPOINTS),
];

/// Where a checkpoint to mutate is made.
const CHECKPOINTS: &str = "target/fuzz/checkpoints";
/// Bytes of a checkpoint before what is hashed.
const HEAD: usize = 44;

/// What libFuzzer needs to see which ways are taken.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=3 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing";

/// Feeds one reader, or all, with mutated files, each for some seconds: none may panic, take ten
/// seconds for an input, or more than 2 GB. What does is left in `target/fuzz`, with all inputs
/// that took new ways.
pub(crate) fn run(arguments: &[String]) -> Result<()> {
    let (seconds, wanted) = match arguments {
        [] => ("60", None),
        [one] if one.parse::<u32>().is_ok() => (one.as_str(), None),
        [one] => ("60", Some(one)),
        [one, seconds] if seconds.parse::<u32>().is_ok() => (seconds.as_str(), Some(one)),
        _ => bail!("usage: cargo xtask fuzz [READER] [SECONDS]"),
    };
    let names = READERS.map(|(name, _)| name);
    if let Some(wanted) = wanted.filter(|wanted| !names.contains(&wanted.as_str())) {
        bail!("{wanted} is no reader; take one of {}", names.join(", "));
    }
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    let program = build(&sh)?;
    make_checkpoint(&sh)?;
    for (name, seeds) in READERS {
        if wanted.is_some_and(|wanted| wanted != name) {
            continue;
        }
        println!("{name}");
        let inputs = format!("target/fuzz/inputs/{name}");
        sh.create_dir(&inputs)?;
        let found = format!("-artifact_prefix=target/fuzz/found-{name}-");
        let time = format!("-max_total_time={seconds}");
        let limits = ["-timeout=10", "-rss_limit_mb=2048", "-print_final_stats=1"];
        let _reader = sh.push_env("FUZZ", name);
        cmd!(sh, "{program} {found} {time} {limits...} {inputs} {seeds}").run()?;
    }
    Ok(())
}

/// Builds the program of `fuzz`, with coverage.
fn build(sh: &Shell) -> Result<String> {
    let told = cmd!(sh, "rustc -vV").read()?;
    let host = told.lines().find_map(|line| line.strip_prefix("host: "));
    let host = host.context("rustc does not tell its host")?;
    // With a target, build scripts and macros are built without.
    let _flags = sh.push_env("RUSTFLAGS", COVERAGE);
    let build = ["--locked", "--manifest-path", "fuzz/Cargo.toml", "--target-dir", "target/fuzz"];
    cmd!(sh, "cargo build {build...} --target {host}").run()?;
    Ok(format!("target/fuzz/{host}/debug/rapunzel-fuzz"))
}

/// Makes a checkpoint without its head, which the program of `fuzz` puts before what it is given.
fn make_checkpoint(sh: &Shell) -> Result<()> {
    let run = ["run", "fuzz/seeds/scene.ron", "--out", "target/fuzz/run", "--force"];
    cmd!(sh, "cargo run --quiet --package rapunzel -- {run...}").run()?;
    let bytes = sh.read_binary_file("target/fuzz/run/checkpoint.bin")?;
    let body = bytes.get(HEAD..).context("a checkpoint has a head")?;
    sh.write_file(format!("{CHECKPOINTS}/small.bin"), body)?;
    Ok(())
}
