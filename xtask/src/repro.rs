use crate::root;
use anyhow::{Result, bail};
use xshell::{Shell, cmd};

/// A chapter of the thesis whose figures are drawn anew, or what is validated beside it.
struct Chapter {
    name: &'static str,
    /// The example that draws them, and its package.
    package: &'static str,
    example: &'static str,
}

const CHAPTERS: [Chapter; 9] = [
    Chapter { name: "ch2", package: "rapunzel-keratin", example: "ch2" },
    Chapter { name: "ch3-static", package: "rapunzel-rod-static", example: "ch3" },
    Chapter { name: "ch3-dynamic", package: "rapunzel-sim", example: "repro" },
    Chapter { name: "ch4", package: "rapunzel-sim", example: "ch4" },
    Chapter { name: "ch5", package: "rapunzel-hairgen", example: "ch5" },
    Chapter { name: "ch6", package: "rapunzel-render", example: "ch6" },
    Chapter { name: "ch7", package: "rapunzel-collision", example: "ch7" },
    Chapter { name: "ch8", package: "rapunzel-sim", example: "ch8" },
    Chapter { name: "validation", package: "rapunzel-sim", example: "validation" },
];

/// Draws the figures of one chapter, or of all, and compares what the thesis says of them with our
/// numbers: an SVG and CSV tables for each figure in `target/repro/CHAPTER`, with a page and a
/// manifest. The chapter gets what else it is told to do. Fails where a comparison does.
pub(crate) fn run(chapter: Option<&str>, arguments: &[String]) -> Result<()> {
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    for Chapter { name, package, example } in chosen(chapter)? {
        let target = ["--locked", "--release", "--package", package, "--example", example];
        cmd!(sh, "cargo run {target...} -- target/repro/{name} {arguments...}").run()?;
    }
    Ok(())
}

fn chosen(chapter: Option<&str>) -> Result<Vec<&'static Chapter>> {
    let chosen: Vec<_> =
        CHAPTERS.iter().filter(|c| chapter.is_none_or(|name| c.name == name)).collect();
    if chosen.is_empty() {
        let names: Vec<_> = CHAPTERS.iter().map(|c| c.name).collect();
        bail!("no such chapter; there are: {}", names.join(", "));
    }
    Ok(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chapters_are_found_by_name() {
        assert_eq!(chosen(None).expect("all").len(), CHAPTERS.len());
        assert_eq!(chosen(Some("ch3-dynamic")).expect("one")[0].example, "repro");
        let error = chosen(Some("ch99")).err().expect("there is none");
        assert!(error.to_string().contains("ch3-dynamic"), "{error}");
    }
}
