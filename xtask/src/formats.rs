use crate::root;
use anyhow::Result;
use xshell::{Shell, cmd};

/// Writes a lock in every format to `target/formats` and lets other programs open it: Python's
/// `vtk` and `usd-core`, each skipped, with a word, where the interpreter in `PYTHON` lacks it.
pub(crate) fn run() -> Result<()> {
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    let package = ["--locked", "--package", "rapunzel-sim"];
    cmd!(sh, "cargo run {package...} --example formats -- target/formats").run()?;

    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let has = |module: &str| {
        let import = format!("import {module}");
        let found = cmd!(sh, "{python} -c {import}").quiet().ignore_stderr().run().is_ok();
        if !found {
            println!("skipped: {python} has no module {module}");
        }
        found
    };
    sh.change_dir("target/formats");
    let check = "../../xtask/check";
    if has("vtk") {
        cmd!(sh, "{python} {check}/check_vtp.py frame4.vtp frame4.csv").run()?;
    }
    if has("pxr") {
        for file in ["linear.usda", "smooth.usda"] {
            cmd!(sh, "{python} {check}/check_usd.py {file} 4 frame4.csv").run()?;
        }
    }
    println!("look at target/formats/preview.png");
    Ok(())
}
