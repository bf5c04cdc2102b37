use crate::formats::installed;
use crate::root;
use anyhow::{Context, Result, bail};
use xshell::{Shell, cmd};

/// Renderers, by the Python module that each is: its package and our script.
const PEERS: [(&str, &str, &str); 2] =
    [("mitsuba", "mitsuba==3.9.1", "peer_mitsuba.py"), ("bpy", "bpy==5.0.1", "peer_cycles.py")];
/// Fibres, and samples of a pixel.
const SIZES: [[u32; 2]; 2] = [[1000, 64], [10_000, 16]];
/// Radiance of the sky, which is most of the picture.
const SKY: f64 = 0.3;
/// Largest differences, of the mean of the picture and of that of the hair in it.
const ALLOWED: [f64; 2] = [0.005, 0.03];

/// Draws the hair that renderers are compared by, and lets others draw it with the same model of
/// scattering; fails where the means of the picture differ by more than 0.5 %, or those of the hair
/// by more than 3 %. Others are installed as `formats` does it.
pub(crate) fn run() -> Result<()> {
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    sh.create_dir("target/peers")?;
    sh.change_dir("target/peers");
    let packages = PEERS.map(|(_, package, _)| package);
    let python = std::env::var("PYTHON").unwrap_or_else(|_| installed(&sh, &packages));
    let mut apart = Vec::new();
    for [fibers, samples] in SIZES {
        let [count, paths] = [fibers, samples].map(|number| number.to_string());
        let stem = format!("wavy-{count}");
        let wavy = ["--locked", "--release", "--package", "rapunzel-render", "--example", "wavy"];
        let ours = cmd!(sh, "cargo run {wavy...} -- {count} {paths} chiang {stem}").read()?;
        println!("{count} fibres, ours\n{ours}");
        let covered = numbers(&ours, "coverage")?[0];
        for (module, _, script) in PEERS {
            let import = format!("import {module}");
            if cmd!(sh, "{python} -c {import}").quiet().ignore_stderr().run().is_err() {
                println!("skipped: {python} has no module {module}");
                continue;
            }
            let script = format!("../../xtask/check/{script}");
            let theirs = cmd!(sh, "{python} {script} {stem}.txt {paths}").read()?;
            println!("{count} fibres, {module}\n{theirs}");
            let differences =
                compared(&numbers(&ours, "mean")?, &numbers(&theirs, "mean")?, covered);
            let [picture, hair] = differences;
            println!("{module}: the picture differs by {picture:.4}, the hair by {hair:.4}");
            if picture > ALLOWED[0] || hair > ALLOWED[1] {
                apart.push(format!("{count} fibres by {module}"));
            }
        }
    }
    if !apart.is_empty() {
        bail!("the means are too far apart: {}", apart.join(", "));
    }
    Ok(())
}

/// The largest relative differences of the mean of the picture, and of its hair.
fn compared(ours: &[f64], theirs: &[f64], covered: f64) -> [f64; 2] {
    let hair = |mean: f64| (mean - (1.0 - covered) * SKY) / covered;
    let largest = |of: &dyn Fn(f64) -> f64| {
        let each = ours.iter().zip(theirs).map(|(a, b)| (of(*a) / of(*b) - 1.0).abs());
        each.fold(0.0, f64::max)
    };
    [largest(&|mean| mean), largest(&hair)]
}

/// The numbers of the line that begins with a name.
fn numbers(text: &str, name: &str) -> Result<Vec<f64>> {
    let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
    let line = line.with_context(|| format!("no line \"{name}\" in: {text}"))?;
    line.split_whitespace().map(|word| Ok(word.parse()?)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hair_is_what_the_sky_leaves() {
        // A fifth of the picture is hair of the radiance 0.2 here and 0.21 there.
        let [picture, hair] = compared(&[0.28], &[0.282], 0.2);
        assert!((picture - (1.0 - 0.28 / 0.282)).abs() < 1e-12);
        assert!((hair - (1.0 - 0.2 / 0.21)).abs() < 1e-12);
        assert_eq!(numbers("a 1\nmean 1 2.5", "mean").expect("there"), [1.0, 2.5]);
        assert!(numbers("means 1", "mean").is_err());
    }
}
