use crate::{root, tidy};
use anyhow::Result;
use xshell::{Shell, cmd};

/// One fibre, one second: a run that is over soon.
const SCENE: &str = "scenes/sine-under-gravity.ron";

/// Everything a change must pass, cheapest first.
pub(crate) fn run() -> Result<()> {
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    cmd!(sh, "cargo fmt --all --check").run()?;
    tidy::run()?;
    cmd!(sh, "cargo clippy --locked --workspace --all-targets -- -D warnings").run()?;
    // The same examples of the properties every time: a change fails for what it changes.
    let seed = sh.push_env("PROPTEST_RNG_SEED", "1");
    cmd!(sh, "cargo test --locked --workspace").run()?;
    drop(seed);
    // Two minutes: what is promised of every step of the reference scene.
    cmd!(sh, "cargo test --locked --package rapunzel-sim --test reference -- --ignored").run()?;
    let strict = sh.push_env("RUSTDOCFLAGS", "-D warnings");
    cmd!(sh, "cargo doc --locked --workspace --no-deps").run()?;
    drop(strict);
    let program = ["--locked", "--release", "--package", "rapunzel", "--"];
    cmd!(sh, "cargo run {program...} run {SCENE} --out target/ci-run --force").run()?;
    Ok(())
}
