use crate::arguments::{LabOptions, Sweep};
use crate::failure::Failure;
use crate::words::say;
use rapunzel_keratin::{Climate, KeratinError, Treatment};
use rapunzel_plot::{Chart, Curve, Drawing, svg};
use rapunzel_sim::lab::{LabSample, Number, Reading, measure};
use rapunzel_sim::scene::{Keratin, Law};
use rapunzel_sim::{SimError, claim, write_atomically};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// One measurement of a sweep, or the only one.
struct Measurement {
    /// What was varied: its place on the axis of the plot, and in words.
    at: (f64, String),
    reading: Reading,
}

const TABLE: &str = "table.csv";
const PLOT: &str = "plot.svg";

/// Measures a sample, or several, into a folder: a table and a plot.
pub(crate) fn lab(options: &LabOptions, json: bool) -> Result<ExitCode, Failure> {
    let name = options.instrument.name();
    let folder =
        options.out.clone().unwrap_or_else(|| Path::new("runs").join(format!("lab-{name}")));
    let refused = Failure::of(Path::new(name));
    let measured: Vec<Measurement> = samples(options)
        .map_err(|error| refused(error.into()))?
        .into_iter()
        .map(|(at, sample)| Ok(Measurement { at, reading: measure(options.instrument, &sample)? }))
        .collect::<Result<_, SimError>>()
        .map_err(refused)?;
    let (axis, swept) = match options.sweep {
        None => ("", false),
        Some(Sweep::Humidity(_)) => ("relative humidity", true),
        Some(Sweep::Temperature(_)) => ("temperature (C)", true),
        Some(Sweep::Treatment) => ("treatment, in the order of the table", true),
    };
    let table = if swept { table(axis, &measured) } else { record(&measured[0].reading) };
    let title = format!("{name}: {} hair", options.kind.name());
    let charts =
        if swept { sweep_charts(&title, axis, &measured) } else { chart(&title, &measured) };
    claim(&folder, &[TABLE, PLOT]).map_err(Failure::of(&folder))?;
    let write = |file: &str, text: String| -> Result<PathBuf, Failure> {
        let path = folder.join(file);
        write_atomically(&path, |to| to.write_all(text.as_bytes())).map_err(Failure::of(&path))?;
        Ok(path)
    };
    let table = write(TABLE, table)?;
    let drawn = svg(&charts).map_err(|error| Failure::File(error.to_string()))?;
    let plot = write(PLOT, drawn)?;
    if json {
        let rows: Vec<_> = measured.iter().map(as_json).collect();
        let object = serde_json::json!({
            "instrument": name, "measured": rows, "table": table, "plot": plot,
        });
        say(&object.to_string())?;
    } else {
        for one in &measured {
            say(&if swept { format!("{axis} {}", one.at.1) } else { title.clone() })?;
            one.reading.numbers.iter().try_for_each(|number| say(&told(number)))?;
        }
        say(&format!("  table       {}\n  plot        {}", table.display(), plot.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A sample and what is varied: its place on the axis of the plot, and in words.
type Varied = ((f64, String), LabSample);

/// The samples, each with what is varied.
fn samples(options: &LabOptions) -> Result<Vec<Varied>, KeratinError> {
    let of = |humidity, temperature, treatment| -> Result<LabSample, KeratinError> {
        let LabOptions { kind, thickness, extrapolate, .. } = *options;
        let keratin = Keratin { kind, treatment, thickness, law: Law::Elastic, extrapolate };
        Ok(LabSample { keratin, climate: Climate::new(humidity, temperature)? })
    };
    let LabOptions { humidity, temperature, treatment, .. } = *options;
    let number = |x: f64| (x, format!("{x:.4}"));
    match &options.sweep {
        None => Ok(vec![((0.0, String::new()), of(humidity, temperature, treatment)?)]),
        Some(Sweep::Humidity(values)) => {
            values.iter().map(|&h| Ok((number(h), of(h, temperature, treatment)?))).collect()
        }
        Some(Sweep::Temperature(values)) => {
            values.iter().map(|&t| Ok((number(t), of(humidity, t, treatment)?))).collect()
        }
        Some(Sweep::Treatment) => (0_u8..)
            .zip(Treatment::ALL)
            .map(|(i, &one)| {
                Ok(((f64::from(i), one.name().to_owned()), of(humidity, temperature, one)?))
            })
            .collect(),
    }
}

/// A number as a line.
fn told(number: &Number) -> String {
    let Number { name, unit, value, put_in } = number;
    let put_in = put_in.map_or(String::new(), |x| {
        format!("  ({:+.2} % of {x:.6e}, as put in)", 100.0 * (value / x - 1.0))
    });
    format!("  {name:<36} {value:.6e} {unit}{put_in}")
}

/// Rows of a sweep.
fn table(axis: &str, measured: &[Measurement]) -> String {
    let mut rows = format!("\"{axis}\"");
    for Number { name, unit, put_in, .. } in &measured[0].reading.numbers {
        let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
        rows += &format!(",\"{name}{unit}\"");
        if put_in.is_some() {
            rows += &format!(",\"{name}{unit}, as put in\"");
        }
    }
    for one in measured {
        rows += &format!("\n\"{}\"", one.at.1);
        for number in &one.reading.numbers {
            rows += &format!(",{:e}", number.value);
            if let Some(put_in) = number.put_in {
                rows += &format!(",{put_in:e}");
            }
        }
    }
    rows + "\n"
}

/// The record of a measurement.
fn record(reading: &Reading) -> String {
    let [x, y] = reading.record.axes;
    let points = reading.record.points.iter().map(|[x, y]| format!("{x:e},{y:e}\n"));
    format!("\"{x}\",\"{y}\"\n") + &points.collect::<String>()
}

fn chart(title: &str, measured: &[Measurement]) -> Vec<Drawing> {
    let reading = &measured[0].reading;
    let first = &reading.numbers[0];
    let curve = Curve { name: short(first), points: reading.record.points.clone() };
    let [x, y] = reading.record.axes;
    let title = title.to_owned();
    vec![Drawing::Chart(Chart { title, x, y, log_from: None, curves: vec![curve] })]
}

/// What was read first over what was varied, and all records.
fn sweep_charts(title: &str, axis: &'static str, measured: &[Measurement]) -> Vec<Drawing> {
    let first = &measured[0].reading.numbers[0];
    // Labels have room for a few digits only.
    let largest = measured.iter().map(|one| one.reading.numbers[0].value.abs()).fold(0.0, f64::max);
    let thousands = (largest.max(f64::MIN_POSITIVE).log10() / 3.0).floor();
    let power = if first.unit.is_empty() { 1.0 } else { 10_f64.powf(3.0 * thousands) };
    let of = |value: fn(&Number) -> Option<f64>| {
        let point =
            |one: &Measurement| value(&one.reading.numbers[0]).map(|y| [one.at.0, y / power]);
        measured.iter().filter_map(point).collect::<Vec<_>>()
    };
    let mut curves = vec![Curve { name: "read".into(), points: of(|n| Some(n.value)) }];
    let put_in = of(|number| number.put_in);
    if !put_in.is_empty() {
        curves.push(Curve { name: "as put in".into(), points: put_in });
    }
    let unit = match first.unit {
        "" => String::new(),
        unit if power == 1.0 => format!(" in {unit}"),
        unit => format!(" in {power:e} {unit}"),
    };
    let summary = Chart {
        title: format!("{title}: {}{unit}", first.name),
        x: axis,
        y: first.name,
        log_from: None,
        curves,
    };
    let [x, y] = measured[0].reading.record.axes;
    let records = measured
        .iter()
        .map(|one| Curve { name: one.at.1.clone(), points: one.reading.record.points.clone() })
        .collect();
    let all = Chart { title: "records".into(), x, y, log_from: None, curves: records };
    vec![Drawing::Chart(summary), Drawing::Chart(all)]
}

fn short(number: &Number) -> String {
    format!("{} {:.4e} {}", number.name, number.value, number.unit)
}

fn as_json(one: &Measurement) -> serde_json::Value {
    let numbers: Vec<_> = one
        .reading
        .numbers
        .iter()
        .map(|n| {
            serde_json::json!({
                "name": n.name, "unit": n.unit, "value": n.value, "put_in": n.put_in,
            })
        })
        .collect();
    serde_json::json!({ "at": one.at.1, "numbers": numbers })
}
