use crate::ReproError;
use crate::plot::{Drawing, svg};
use serde::Serialize;
use std::fmt;
use std::fs;
use std::path::Path;

/// A figure of the thesis in the list of a program.
pub struct FigureEntry<D> {
    /// As the thesis numbers it; the name of its files.
    pub number: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// What draws it.
    pub draw: D,
}

/// A figure of the thesis, drawn anew.
pub struct Figure {
    /// What it starts from.
    pub scene: &'static str,
    /// What is changed in the scene, and which numbers the thesis leaves open.
    pub parameters: &'static str,
    /// Its parts, each with a table of its own.
    pub drawings: Vec<Drawing>,
    /// What the thesis says of it, with our numbers.
    pub checks: Vec<ClaimCheck>,
}

/// A claim of the thesis with a number of ours.
#[derive(Serialize)]
pub struct ClaimCheck {
    /// Which number.
    pub compared: String,
    /// The number, in its unit.
    pub obtained: f64,
    /// The unit of the number; empty for one without.
    pub unit: &'static str,
    /// What the number must be, in its unit.
    pub criterion: Criterion,
    /// What the thesis, or another theory, says.
    pub thesis: &'static str,
}

/// What a number must be.
#[derive(Serialize, Clone, Copy)]
pub enum Criterion {
    /// This or less.
    AtMost(f64),
    /// This or more.
    AtLeast(f64),
    /// From the first to the second.
    Within(f64, f64),
    /// Anything: only told, where the thesis gives no number to judge by, or ours is another claim.
    Told,
}

impl Criterion {
    /// Decimals that tell the ends of an interval apart, with one more; `None` where there is no
    /// interval, or it is too narrow to be written so.
    fn decimals(self) -> Option<usize> {
        let Self::Within(least, most) = self else { return None };
        let needed = (1.0 - (most - least).log10().floor()).max(2.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "2 to 12")]
        (needed <= 12.0).then_some(needed as usize)
    }
}

/// A claim of the thesis and our number.
pub fn check(
    compared: impl Into<String>,
    obtained: f64,
    unit: &'static str,
    criterion: Criterion,
    thesis: &'static str,
) -> ClaimCheck {
    ClaimCheck { compared: compared.into(), obtained, unit, criterion, thesis }
}

impl ClaimCheck {
    /// The number in digits, as many as its criterion has.
    pub(crate) fn told(&self) -> String {
        match self.criterion.decimals() {
            Some(count) => format!("{:.count$}", self.obtained),
            None => shown(self.obtained),
        }
    }

    /// A number that is none fails.
    pub(crate) fn holds(&self) -> bool {
        match self.criterion {
            Criterion::AtMost(most) => self.obtained <= most,
            Criterion::AtLeast(least) => self.obtained >= least,
            Criterion::Within(least, most) => (least..=most).contains(&self.obtained),
            Criterion::Told => self.obtained.is_finite(),
        }
    }
}

impl fmt::Display for Criterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtMost(most) => write!(f, "<= {most}"),
            Self::AtLeast(least) => write!(f, ">= {least}"),
            Self::Within(least, most) => match self.decimals() {
                Some(count) => write!(f, "{least:.count$} .. {most:.count$}"),
                None => write!(f, "{least} .. {most}"),
            },
            Self::Told => write!(f, "-"),
        }
    }
}

/// An entry of the manifest.
#[derive(Serialize)]
struct ManifestRecord<'a> {
    figure: &'a str,
    title: &'a str,
    scene: &'a str,
    parameters: &'a str,
    checks: &'a [ClaimCheck],
    holds: bool,
    files: Vec<String>,
}

/// Writes the drawings, their tables, other texts by their names, and the manifest to `folder`.
pub(crate) fn write<D>(
    folder: &Path,
    figures: &[(&FigureEntry<D>, Figure)],
    others: &[(&str, String)],
) -> Result<(), ReproError> {
    let refused = |path: &Path| {
        let path = path.to_owned();
        |source| ReproError::File { path, source }
    };
    fs::create_dir_all(folder).map_err(refused(folder))?;
    let atomically = |name: &str, text: &str| {
        let part = folder.join(format!("{name}.part"));
        let whole = folder.join(name);
        fs::write(&part, text).and_then(|()| fs::rename(&part, &whole)).map_err(refused(&whole))
    };
    let mut records = Vec::new();
    for (entry, figure) in figures {
        let number = entry.number;
        let drawn =
            svg(&figure.drawings).map_err(|source| ReproError::Drawing { number, source })?;
        let mut files = vec![(format!("{number}.svg"), drawn)];
        for (part, drawing) in ('a'..).zip(&figure.drawings) {
            files.push((format!("{number}{part}.csv"), drawing.csv()));
        }
        for (name, text) in &files {
            atomically(name, text)?;
        }
        records.push(ManifestRecord {
            figure: number,
            title: entry.title,
            scene: figure.scene,
            parameters: figure.parameters,
            checks: &figure.checks,
            holds: figure.checks.iter().all(ClaimCheck::holds),
            files: files.into_iter().map(|(name, _)| name).collect(),
        });
    }
    for (name, text) in others {
        atomically(name, text)?;
    }
    atomically("manifest.json", &(serde_json::to_string_pretty(&records)? + "\n"))
}

/// All checks as one table, and how many do not hold.
pub(crate) fn table<D>(figures: &[(&FigureEntry<D>, Figure)]) -> (String, usize) {
    let mut text = "| figure | compared | obtained | criterion | thesis | |\n".to_owned();
    text += "|---|---|---|---|---|---|\n";
    let mut failed = 0;
    for (entry, figure) in figures {
        for check in &figure.checks {
            let verdict = match (check.holds(), check.criterion) {
                (false, _) => "FAIL",
                (true, Criterion::Told) => "told",
                (true, _) => "pass",
            };
            failed += usize::from(!check.holds());
            text += &format!(
                "| {} | {} | {} {} | {} | {} | {verdict} |\n",
                entry.number,
                check.compared,
                check.told(),
                check.unit,
                check.criterion,
                check.thesis
            );
        }
    }
    (text, failed)
}

/// Three digits, small and large numbers with a power of ten.
fn shown(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        size if (0.01..1e4).contains(&size) => format!("{x:.3}"),
        _ => format!("{x:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_intervals_are_told_with_their_digits() {
        let criterion = Criterion::Within(0.124_561, 0.124_563);
        assert_eq!(check("a", 0.124_561_7, "m", criterion, "b").told(), "0.1245617");
        assert_eq!(criterion.to_string(), "0.1245610 .. 0.1245630");
        assert_eq!(Criterion::Within(1.9, 2.1).to_string(), "1.90 .. 2.10");
        assert_eq!(Criterion::Within(0.0, 1e-12).to_string(), "0 .. 0.000000000001");
    }

    #[test]
    fn a_number_that_is_none_never_holds() {
        let check = |obtained, criterion| check("a", obtained, "m", criterion, "b");
        let all = [Criterion::AtMost(1.0), Criterion::AtLeast(1.0), Criterion::Within(1.0, 2.0)];
        for criterion in all {
            assert!(check(1.0, criterion).holds(), "{criterion}");
            assert!(!check(f64::NAN, criterion).holds(), "{criterion}");
        }
        assert!(!check(1.1, all[0]).holds() && !check(0.9, all[1]).holds());
        assert!(!check(2.1, all[2]).holds());
    }
}
