//! The tables of a run as a picture.

use super::Observer;
use crate::folder::PLOTS;
use crate::storage::replace;
use crate::{SimError, World};
use rapunzel_plot::{Chart, Curve, Drawing, svg};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// Most curves of a chart.
const MOST_CURVES: usize = 6;
/// Most charts of a page; what comes after them is told.
const MOST_CHARTS: usize = 40;
/// Most rows of a table that are drawn, evenly spaced.
const MOST_ROWS: usize = 1000;

/// Draws the tables of a run at its end.
///
/// What is drawn is read back from the tables, so that neither memory nor a restart matters.
#[derive(Debug)]
pub(crate) struct PlotWriter {
    folder: PathBuf,
    /// Names of the tables, in the order of their charts.
    tables: Vec<String>,
}

impl PlotWriter {
    /// The tables must be there, and whole, when the run ends.
    pub(crate) fn new(folder: &Path, tables: Vec<String>) -> Self {
        Self { folder: folder.to_owned(), tables }
    }

    fn write(&self) -> Result<(), SimError> {
        let mut charts = Vec::new();
        for table in &self.tables {
            let path = self.folder.join(table);
            charts.extend(charts_of(table, &path).map_err(SimError::io("read", &path))?);
        }
        let left = charts.len().saturating_sub(MOST_CHARTS);
        charts.truncate(MOST_CHARTS);
        if let (true, Some(last)) = (left > 0, charts.last_mut()) {
            last.title += &format!("; {left} more charts are left out");
        }
        let drawings: Vec<_> = charts.into_iter().map(Drawing::Chart).collect();
        let path = self.folder.join(PLOTS);
        let drawn =
            svg(&drawings).map_err(io::Error::other).map_err(SimError::io("draw", &path))?;
        replace(&path, |to| to.write_all(drawn.as_bytes()))
    }
}

impl Observer for PlotWriter {
    fn observe(&mut self, _: &World) -> Result<(), SimError> {
        Ok(())
    }

    fn mark(&mut self) -> Result<u64, SimError> {
        Ok(0)
    }

    fn list(&mut self) -> Result<(), SimError> {
        Ok(())
    }

    fn relocate(&mut self, folder: &Path) {
        self.folder = folder.to_owned();
    }

    fn rewind(&mut self, _: u64) -> Result<(), SimError> {
        Ok(())
    }

    fn finish(&mut self) -> Vec<SimError> {
        self.write().err().into_iter().collect()
    }
}

/// The charts of a table: columns of one unit that follow each other in one, works apart from the
/// energies that they make.
fn charts_of(table: &str, path: &Path) -> io::Result<Vec<Chart>> {
    let open = || File::open(path).map(BufReader::new);
    let rows = open()?.lines().count().saturating_sub(1);
    let stride = rows.div_ceil(MOST_ROWS).max(1);
    let mut lines = open()?.lines();
    let head = lines.next().transpose()?.unwrap_or_default();
    let names: Vec<&str> = head.split(',').skip(1).collect();
    let mut columns: Vec<Vec<[f64; 2]>> = vec![Vec::new(); names.len()];
    for (row, line) in lines.enumerate() {
        let line = line?;
        if row % stride != 0 && row + 1 != rows {
            continue;
        }
        // What is no number is a gap.
        let mut numbers = line.split(',').map(|x| x.parse().unwrap_or(f64::NAN));
        let time: f64 = numbers.next().unwrap_or(f64::NAN);
        for (column, y) in columns.iter_mut().zip(numbers) {
            column.push([time, y]);
        }
    }
    let curves: Vec<_> = names.iter().zip(columns).collect();
    let kind = |name: &str| (unit(name).map(str::to_owned), name.starts_with("work "));
    let alike = curves.chunk_by(|(a, _), (b, _)| kind(a) == kind(b));
    let chart = |curves: &[(&&str, Vec<[f64; 2]>)]| Chart {
        title: table.to_owned(),
        x: "time (s)",
        y: label(unit(curves[0].0)),
        log_from: None,
        curves: curves
            .iter()
            .map(|(name, points)| Curve { name: (**name).to_owned(), points: points.clone() })
            .collect(),
    };
    Ok(alike.flat_map(|alike| alike.chunks(MOST_CURVES)).map(chart).collect())
}

/// The unit in brackets at the end of a name.
fn unit(name: &str) -> Option<&str> {
    Some(name.strip_suffix(')')?.rsplit_once('(')?.1)
}

/// The label of an ordinate with a unit.
fn label(unit: Option<&str>) -> &'static str {
    match unit {
        Some("J") => "energy (J)",
        Some("m") => "length (m)",
        Some("m/s") => "speed (m/s)",
        Some("N") => "force (N)",
        Some("N m") => "moment (N m)",
        Some("1/m") => "curvature (1/m)",
        Some("rad/m") => "twist (rad/m)",
        Some("C") => "charge (C)",
        Some("V/m") => "field (V/m)",
        Some(_) => "in the unit of each",
        None => "number",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_one_unit_share_a_chart_and_long_tables_are_thinned() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.csv");
        let mut text = "time (s),kinetic (J),total (J),work of drag (J),listed,x (m)\n".to_owned();
        for row in 0..2500 {
            text += &format!("{},1,2,3,NaN,{}\n", 0.5 * f64::from(row), row);
        }
        std::fs::write(&path, text).expect("written");
        let charts = charts_of("a.csv", &path).expect("a table");
        let names: Vec<Vec<&str>> =
            charts.iter().map(|chart| chart.curves.iter().map(|c| &*c.name).collect()).collect();
        let right: [&[&str]; 4] =
            [&["kinetic (J)", "total (J)"], &["work of drag (J)"], &["listed"], &["x (m)"]];
        assert_eq!(names, right);
        let labels: Vec<_> = charts.iter().map(|chart| chart.y).collect();
        assert_eq!(labels, ["energy (J)", "energy (J)", "number", "length (m)"]);
        let last = &charts[3].curves[0].points;
        // Every third row, and the last one.
        assert_eq!((last.len(), last[1], last[834 - 1]), (834, [1.5, 3.0], [1249.5, 2499.0]));
        assert!(charts[2].curves[0].points.iter().all(|p| p[1].is_nan()));
    }
}
