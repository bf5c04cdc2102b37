use crate::root;
use anyhow::Result;
use xshell::{Shell, cmd};

/// The Python packages that read our files.
const READERS: [&str; 3] = ["vtk==9.7.2", "usd-core==26.11", "mitsuba==3.9.1"];

/// Writes the first frames of a simulated lock in every format to `target/formats` and lets other
/// programs open them and compare the numbers: Python's `vtk`, `usd-core` and `mitsuba`, each
/// skipped, with a word, where it cannot be had. They are installed into a virtual environment
/// beside the files, unless `PYTHON` names an interpreter to take instead.
pub(crate) fn run() -> Result<()> {
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    let package = ["--locked", "--release", "--package", "rapunzel-sim"];
    cmd!(sh, "cargo run {package...} --example formats -- target/formats").run()?;

    sh.change_dir("target/formats");
    let python = std::env::var("PYTHON").unwrap_or_else(|_| installed(&sh));
    let has = |module: &str| {
        let import = format!("import {module}");
        let found = cmd!(sh, "{python} -c {import}").quiet().ignore_stderr().run().is_ok();
        if !found {
            println!("skipped: {python} has no module {module}");
        }
        found
    };
    let check = "../../xtask/check";
    if has("vtk") {
        cmd!(sh, "{python} {check}/check_vtp.py frame4.vtp frame4.csv").run()?;
    }
    if has("pxr") {
        for file in ["fibers.usda", "scene.usda"] {
            cmd!(sh, "{python} {check}/check_usd.py {file} 4 frame4.csv").run()?;
        }
    }
    if has("mitsuba") {
        cmd!(sh, "{python} {check}/check_mitsuba.py frame4.xml frame4.csv frame4.png").run()?;
    }
    println!("look at target/formats/preview.png, and frame4.png by Mitsuba");
    Ok(())
}

/// The interpreter of a virtual environment with the readers, as far as they can be installed.
fn installed(sh: &Shell) -> String {
    let python = if cfg!(windows) { "venv/Scripts/python" } else { "venv/bin/python" };
    let install = || {
        if !sh.path_exists(python) {
            cmd!(sh, "python3 -m venv venv").run()?;
        }
        cmd!(sh, "{python} -m pip install --quiet --disable-pip-version-check {READERS...}").run()
    };
    if let Err(error) = install() {
        println!("cannot install {}: {error}", READERS.join(" and "));
    }
    python.to_owned()
}
