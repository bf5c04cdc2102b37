use crate::root;
use anyhow::{Context, Result, bail};
use serde_json::Value;
use std::fs;
use std::path::Path;
use xshell::{Shell, cmd};

/// Runs all benchmarks and prints them as one table: case, measured, budget, thesis.
///
/// What a case may take and what the thesis reports stands beside the code that is timed, in
/// `crates/*/benches/budgets.csv`: rows `case,budget,thesis` such as
/// `rod/step/100,40 us,8.1 ms`; a dash where there is none. A budget may also be a share of what
/// another case of the same run took: `0.5 of rod/step/200`. A case over its budget is marked, not
/// refused: times depend on the machine.
pub(crate) fn run() -> Result<()> {
    let sh = Shell::new()?;
    sh.change_dir(root()?);
    let results = root()?.join("target/bench");
    sh.remove_path(&results)?;
    let _home = sh.push_env("CRITERION_HOME", &results);
    let metadata =
        cmd!(sh, "cargo metadata --locked --no-deps --format-version 1").quiet().read()?;
    let benches = benches(&serde_json::from_str(&metadata)?)?;
    if benches.is_empty() {
        bail!("there are no benchmarks yet; a crate keeps its own in benches/");
    }
    let mut budgets = Vec::new();
    for Bench { package, name, folder } in benches {
        cmd!(sh, "cargo bench --locked --package {package} --bench {name} -- --noplot").run()?;
        if let Ok(table) = fs::read_to_string(folder.clone() + "budgets.csv") {
            let own = parse(&table).with_context(|| format!("{folder}budgets.csv"))?;
            budgets
                .extend(own.into_iter().filter(|row| !budgets.contains(row)).collect::<Vec<_>>());
        }
    }
    let mut measured = Vec::new();
    collect(&results, &mut measured)?;
    measured.sort_by(|a, b| a.0.cmp(&b.0));
    print!("{}", table(&measured, &budgets));
    Ok(())
}

struct Bench {
    package: String,
    name: String,
    /// Folder of the benchmark, with a slash at the end.
    folder: String,
}

/// The benchmarks of the workspace.
fn benches(metadata: &Value) -> Result<Vec<Bench>> {
    let mut found = Vec::new();
    for package in metadata["packages"].as_array().context("no packages")? {
        let targets = package["targets"].as_array().context("no targets")?;
        for target in targets.iter().filter(|t| t["kind"][0] == "bench") {
            let text = |value: &Value| value.as_str().map(str::to_owned).context("no text");
            let path = text(&target["src_path"])?;
            let folder = path.rsplit_once('/').map(|(folder, _)| format!("{folder}/"));
            found.push(Bench {
                package: text(&package["name"])?,
                name: text(&target["name"])?,
                folder: folder.context("a benchmark lies in a folder")?,
            });
        }
    }
    Ok(found)
}

/// A case with its limit and the thesis's own time, s, if there are any.
type Budget = (String, Option<Limit>, Option<f64>);

/// What a case may take.
#[derive(Debug, Clone, PartialEq)]
enum Limit {
    /// A time, s.
    Time(f64),
    /// A share of what another case took.
    Share(f64, String),
}

impl Limit {
    fn parse(text: &str) -> Result<Option<Self>> {
        match text.split_once(" of ") {
            Some((share, case)) => {
                let share = share.parse().with_context(|| format!("`{share}` is no number"))?;
                Ok(Some(Self::Share(share, case.to_owned())))
            }
            None => Ok(seconds(text)?.map(Self::Time)),
        }
    }

    /// The limit in seconds, if all that it depends on was measured.
    fn time(&self, measured: &[(String, f64)]) -> Option<f64> {
        match self {
            Self::Time(time) => Some(*time),
            Self::Share(share, other) => {
                measured.iter().find(|(case, _)| case == other).map(|(_, time)| share * time)
            }
        }
    }
}

fn parse(table: &str) -> Result<Vec<Budget>> {
    let row = |line: &str| {
        // From the right: the name of a case may have commas of its own.
        let columns: Vec<&str> = line.rsplitn(3, ',').map(str::trim).collect();
        let [thesis, budget, case] = columns[..] else {
            bail!("`{line}` is not `case,budget,thesis`");
        };
        Ok((case.to_owned(), Limit::parse(budget)?, seconds(thesis)?))
    };
    let lines = table.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.map(row).collect()
}

const UNITS: [(&str, f64); 4] = [("ns", 1e-9), ("us", 1e-6), ("ms", 1e-3), ("s", 1.0)];

/// `"8.1 ms"` as seconds, `"-"` as nothing.
fn seconds(text: &str) -> Result<Option<f64>> {
    if text == "-" {
        return Ok(None);
    }
    let parsed = text.split_once(' ').and_then(|(number, unit)| {
        let (_, size) = UNITS.iter().find(|(name, _)| *name == unit)?;
        Some(number.parse::<f64>().ok()? * size)
    });
    parsed.map(Some).with_context(|| format!("`{text}` is no time such as `8.1 ms`, nor `-`"))
}

/// Case and median, s, of all results under `folder`, as criterion leaves them.
fn collect(folder: &Path, found: &mut Vec<(String, f64)>) -> Result<()> {
    let read = |name: &str| -> Result<Value> {
        Ok(serde_json::from_str(&fs::read_to_string(folder.join(name))?)?)
    };
    if folder.ends_with("new") && folder.join("estimates.json").exists() {
        let case = read("benchmark.json")?["full_id"].as_str().context("no name")?.to_owned();
        let median = read("estimates.json")?["median"]["point_estimate"].as_f64();
        found.push((case, 1e-9 * median.context("no median")?));
        return Ok(());
    }
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            collect(&entry.path(), found)?;
        }
    }
    Ok(())
}

/// The table as Markdown.
fn table(measured: &[(String, f64)], budgets: &[Budget]) -> String {
    let mut text = "| case | measured | budget | thesis |\n|---|---|---|---|\n".to_owned();
    for (case, time) in measured {
        let known = budgets.iter().find(|(name, ..)| name == case);
        let (limit, thesis) = known.map_or((None, None), |(_, limit, t)| (limit.as_ref(), *t));
        let budget = limit.and_then(|limit| limit.time(measured));
        let over = if budget.is_some_and(|b| *time > b) { " OVER" } else { "" };
        let show = |time: Option<f64>| time.map_or("-".to_owned(), shown);
        let share = match limit {
            Some(Limit::Share(share, other)) => format!(" ({share} of {other})"),
            _ => String::new(),
        };
        let row = [case.clone(), shown(*time) + over, show(budget) + &share, show(thesis)];
        text += &format!("| {} |\n", row.join(" | "));
    }
    for (case, ..) in budgets.iter().filter(|b| measured.iter().all(|m| m.0 != b.0)) {
        text += &format!("| {case} | NOT MEASURED | | |\n");
    }
    text
}

/// Three digits and the unit that suits.
fn shown(time: f64) -> String {
    let suits = UNITS.iter().find(|(_, size)| time < 999.5 * size);
    let (unit, size) = suits.unwrap_or(&UNITS[3]);
    let number = time / size;
    let digits = [100.0, 10.0].iter().filter(|limit| number < **limit).count();
    format!("{number:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_sets_measured_beside_budget() {
        let budgets =
            parse("# rods\nrod/step/100,40 us,8.1 ms\nrod/gone,-,2 s\nnet/2,0.5 of net/step,-\n")
                .expect("budgets");
        let measured =
            [("net/2".into(), 0.7), ("net/step".into(), 1.5), ("rod/step/100".into(), 41.26e-6)];
        let expected = "\
| case | measured | budget | thesis |
|---|---|---|---|
| net/2 | 700 ms | 750 ms (0.5 of net/step) | - |
| net/step | 1.50 s | - | - |
| rod/step/100 | 41.3 us OVER | 40.0 us | 8.10 ms |
| rod/gone | NOT MEASURED | | |
";
        assert_eq!(table(&measured, &budgets), expected);
    }

    #[test]
    fn times_have_units() {
        assert_eq!(shown(999.6e-9), "1.00 us");
        assert_eq!(shown(123.4e-3), "123 ms");
        assert_eq!(shown(4000.0), "4000 s");
        assert!(seconds("8.1").is_err());
        let named = parse("hair, 100 segments, 1 ms, -").expect("a budget");
        assert_eq!(named, [("hair, 100 segments".to_owned(), Some(Limit::Time(1e-3)), None)]);
        assert!(parse("a,1 ms").is_err());
    }
}
