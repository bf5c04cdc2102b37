//! The laboratory of the program.

use crate::common::rapunzel;
use std::fs;
use std::path::Path;
use std::process::Output;

fn lab(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = rapunzel();
    command.current_dir(folder).arg("lab").args(arguments).output().expect("the program")
}

#[test]
fn an_instrument_gives_a_table_and_a_plot() {
    let folder = tempfile::tempdir().expect("a folder");
    let done = lab(folder.path(), &["tensile", "--type", "Chinese", "--humidity", "1"]);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    let told = String::from_utf8_lossy(&done.stdout);
    assert!(told.contains("Young's modulus in tension") && told.contains("as put in"), "{told}");
    let out = folder.path().join("runs/lab-tensile");
    let table = fs::read_to_string(out.join("table.csv")).expect("a table");
    assert!(table.starts_with("\"strain\",\"stress (MPa)\""), "{table}");
    assert_eq!(table.lines().count(), 602, "a head and 601 points");
    assert!(fs::read_to_string(out.join("plot.svg")).expect("a plot").starts_with("<svg"));
}

#[test]
fn a_sweep_is_one_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let sweep = |name: &str, of: &str| {
        let arguments = [name, "--json", "--type", "Caucasian", "--sweep", of, "--out", "swept"];
        let done = lab(folder.path(), &arguments);
        assert_eq!(done.status.code(), Some(0), "{done:?}");
        fs::read_to_string(folder.path().join("swept/table.csv")).expect("a table")
    };
    let hook = sweep("hook", "humidity=0.3:0.9:7");
    assert_eq!(hook.lines().count(), 8, "{hook}");
    assert!(hook.lines().last().is_some_and(|row| row.starts_with("\"0.9000\",")), "{hook}");
    let treated = sweep("tensile", "treatment");
    assert!(treated.contains("\"bleached\",") && treated.lines().count() == 8, "{treated}");
}

#[test]
fn what_is_not_known_is_refused_with_what_is_nearest() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = |arguments: &[&str], code| {
        let done = lab(folder.path(), arguments);
        assert_eq!(done.status.code(), Some(code), "{done:?}");
        String::from_utf8_lossy(&done.stderr).into_owned()
    };
    let name = told(&["hok", "--type", "Chinese"], 2);
    assert!(name.contains("no instrument \"hok\"; did you mean hook"), "{name}");
    let kind = told(&["hook", "--type", "Chineze"], 2);
    assert!(kind.contains("did you mean Chinese"), "{kind}");
    let sweep = told(&["hook", "--type", "Chinese", "--sweep", "humidity=0.3"], 2);
    assert!(sweep.contains("humidity=FROM:TO:COUNT"), "{sweep}");
    let humidity = told(&["hook", "--type", "Chinese", "--humidity", "65"], 3);
    assert!(humidity.contains("must lie in [0, 1]"), "{humidity}");
    let unmeasured = told(&["pendulum", "--type", "Chinese", "--humidity", "0.4"], 3);
    assert!(unmeasured.contains("logarithmic decrement is measured"), "{unmeasured}");
    assert!(!folder.path().join("runs").exists(), "and nothing is written");
}
