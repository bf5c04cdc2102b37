use crate::{root, tidy};
use anyhow::Result;
use std::time::{Duration, Instant};
use xshell::{Shell, cmd};

/// What is promised of every step of the reference scene.
const REFERENCE: &str = "reference::";

/// Everything a change must pass, cheapest first; at the end, what each part took.
pub(crate) fn run() -> Result<()> {
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    // Nothing is built twice: one set of features (that of the workspace), one profile, and no
    // state for a next build.
    sh.set_var("CARGO_INCREMENTAL", "0");
    let workspace = ["--locked", "--workspace"];
    let mut parts = Parts::default();
    parts.time("format", || Ok(cmd!(sh, "cargo fmt --all --check").run()?))?;
    parts.time("house rules", tidy::run)?;
    // A workspace of its own, of which nothing else here needs the lock file.
    parts.time("lock file of fuzz", || {
        let metadata = ["metadata", "--locked", "--format-version", "1"];
        let fuzz = ["--manifest-path", "fuzz/Cargo.toml"];
        Ok(cmd!(sh, "cargo {metadata...} {fuzz...}").ignore_stdout().run()?)
    })?;
    parts.time("clippy", || {
        let warnings = ["-D", "warnings"];
        Ok(cmd!(sh, "cargo clippy {workspace...} --all-targets -- {warnings...}").run()?)
    })?;
    parts.time("documentation", || {
        let _strict = sh.push_env("RUSTDOCFLAGS", "-D warnings");
        Ok(cmd!(sh, "cargo doc {workspace...} --no-deps --all-features").run()?)
    })?;
    parts.time("build of tests and program", || {
        Ok(cmd!(sh, "cargo test {workspace...} --no-run").run()?)
    })?;
    // The same examples of the properties every time: a change fails for what it changes.
    let _seed = sh.push_env("PROPTEST_RNG_SEED", "1");
    parts.time("tests", || Ok(cmd!(sh, "cargo test {workspace...}").run()?))?;
    parts.time("reference scene", || {
        Ok(cmd!(sh, "cargo test {workspace...} --test it {REFERENCE} -- --ignored").run()?)
    })?;
    parts.print();
    Ok(())
}

/// Parts of a check and how long each took.
#[derive(Default)]
struct Parts(Vec<(&'static str, Duration)>);

impl Parts {
    fn time(&mut self, name: &'static str, part: impl FnOnce() -> Result<()>) -> Result<()> {
        let start = Instant::now();
        part()?;
        self.0.push((name, start.elapsed()));
        Ok(())
    }

    fn print(&self) {
        for (name, time) in &self.0 {
            println!("{:>7.1} s  {name}", time.as_secs_f64());
        }
    }
}
