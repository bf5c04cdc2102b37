use crate::page::page;
use crate::report::{self, Figure, FigureEntry};
use crate::{Fallible, NotRun, ReproError};
use std::path::PathBuf;
use std::process::ExitCode;

/// Draws all figures into a folder, the first of the arguments, or those whose numbers follow it,
/// with a page that shows them, and prints what was compared; `draw` is handed what an entry has
/// for that. The program fails if a check does, a figure cannot be drawn, or none has a number that
/// is asked for.
pub fn main<D>(
    figures: &[FigureEntry<D>],
    arguments: impl Iterator<Item = String>,
    draw: impl Fn(&D) -> Fallible<Figure>,
) -> ExitCode {
    main_beside(figures, &[], arguments, draw)
}

/// Draws all figures into a folder, the first of the arguments, or those whose numbers follow it,
/// with a page that shows them and lists what is `not_run`, and prints what was compared; `draw` is
/// handed what an entry has for that. The program fails if a check does, a figure cannot be drawn,
/// or none has a number that is asked for.
pub fn main_beside<D>(
    figures: &[FigureEntry<D>],
    not_run: &[NotRun],
    arguments: impl Iterator<Item = String>,
    draw: impl Fn(&D) -> Fallible<Figure>,
) -> ExitCode {
    match run(figures, not_run, arguments, draw) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(failed) => {
            eprintln!("{failed} checks fail");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// How many checks fail.
fn run<D>(
    entries: &[FigureEntry<D>],
    not_run: &[NotRun],
    mut arguments: impl Iterator<Item = String>,
    draw: impl Fn(&D) -> Fallible<Figure>,
) -> Result<usize, ReproError> {
    let folder = PathBuf::from(arguments.next().ok_or(ReproError::NoFolder)?);
    let wanted: Vec<String> = arguments.collect();
    let mut figures = Vec::new();
    for entry in entries {
        if wanted.is_empty() || wanted.iter().any(|number| number == entry.number) {
            println!("{}  {}", entry.number, entry.title);
            let number = entry.number;
            let figure =
                draw(&entry.draw).map_err(|source| ReproError::Figure { number, source })?;
            figures.push((entry, figure));
        }
    }
    if figures.is_empty() {
        return Err(ReproError::NoSuchFigure(wanted.join(", ")));
    }
    report::write(&folder, &figures, &[("page.html", page(&figures, not_run))])?;
    let (table, failed) = report::table(&figures);
    println!("\n{table}");
    Ok(failed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Chart, Curve, Drawing};
    use crate::{Criterion, check};

    fn figure(obtained: &f64) -> Fallible<Figure> {
        let curves = vec![Curve { name: "c".into(), points: vec![[0.0, 1.0], [1.0, *obtained]] }];
        let chart = Chart { title: "t".into(), x: "x", y: "y", log_from: None, curves };
        Ok(Figure {
            scene: "none",
            parameters: "none",
            drawings: vec![Drawing::Chart(chart)],
            checks: vec![check("a", *obtained, "m", Criterion::AtMost(2.0), "b")],
        })
    }

    #[test]
    fn what_is_wanted_is_drawn_and_what_fails_is_counted() {
        let entries = [("1", 1.0), ("2", 3.0)].map(|(number, draw)| FigureEntry {
            number,
            title: "title",
            draw,
        });
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().to_str().expect("a name");
        let run = |words: &[&str]| {
            let arguments = words.iter().map(|&word| word.to_owned());
            run(&entries, &[], arguments, figure)
        };
        assert!(matches!(run(&[]), Err(ReproError::NoFolder)));
        assert!(matches!(run(&[path, "3"]), Err(ReproError::NoSuchFigure(_))));
        assert_eq!(run(&[path, "1"]).expect("drawn"), 0);
        let files = || {
            let entries = std::fs::read_dir(folder.path()).expect("a folder");
            let mut names: Vec<_> = entries.map(|e| e.expect("a file").file_name()).collect();
            names.sort();
            names
        };
        assert_eq!(files(), ["1.svg", "1a.csv", "manifest.json", "page.html"]);
        assert_eq!(run(&[path]).expect("drawn"), 1);
        assert_eq!(files().len(), 6);
        let table = std::fs::read_to_string(folder.path().join("2a.csv")).expect("a table");
        assert_eq!(table, "curve,\"x\",\"y\"\n\"c\",0,1\n\"c\",1,3\n");
    }
}
