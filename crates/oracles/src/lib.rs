#![doc = include_str!("../README.md")]

use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::env;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why there are no reference values.
#[derive(Debug, thiserror::Error)]
pub enum OracleError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The file has no cases of the type that the test asks for.
    #[error("{}: {source}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// Where it is otherwise.
        source: serde_json::Error,
    },
    /// The list of cases is empty.
    #[error("{}: it has no cases", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
}

#[derive(Deserialize)]
struct Oracle<Case> {
    cases: Vec<Case>,
}

/// The cases of the oracle file `name`, one at least, in the order of the file.
///
/// # Errors
/// If the file cannot be read, has no list `cases` of that type, or an empty one.
pub fn cases<Case: DeserializeOwned>(name: &str) -> Result<Vec<Case>, OracleError> {
    read(&path(name))
}

/// The oracle file `name` as one value, for the files that are no list of cases.
///
/// # Errors
/// If the file cannot be read or has another form.
pub fn whole<Form: DeserializeOwned>(name: &str) -> Result<Form, OracleError> {
    parse(&path(name))
}

fn path(name: &str) -> PathBuf {
    let shipped = || Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    env::var_os("RAPUNZEL_ORACLES").map_or_else(shipped, PathBuf::from).join(name)
}

fn read<Case: DeserializeOwned>(path: &Path) -> Result<Vec<Case>, OracleError> {
    let oracle: Oracle<Case> = parse(path)?;
    if oracle.cases.is_empty() {
        return Err(OracleError::Empty { path: path.to_owned() });
    }
    Ok(oracle.cases)
}

fn parse<Form: DeserializeOwned>(path: &Path) -> Result<Form, OracleError> {
    let owned = || path.to_owned();
    let text =
        fs::read_to_string(path).map_err(|source| OracleError::File { path: owned(), source })?;
    serde_json::from_str(&text).map_err(|source| OracleError::Form { path: owned(), source })
}

/// A file or folder of the data that is not shipped; `None`, told on standard error, if it is not
/// there.
#[must_use]
pub fn data(name: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let path = env::var_os("RAPUNZEL_DATA").map_or_else(beside, PathBuf::from).join(name);
    if path.exists() {
        return Some(path);
    }
    // Past the capture of the test runner: nobody shall take a skipped test for one that passed. If
    // standard error is closed, nobody can be told.
    let _ = writeln!(
        io::stderr(),
        "SKIPPED: there is no {}; set RAPUNZEL_DATA to the folder that holds it",
        path.display()
    );
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn all_files_have_cases_but_one() {
        let folder = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("data"));
        let paths = folder.expect("the copies").map(|entry| entry.expect("a file").path());
        let files: Vec<_> = paths.filter(|p| p.extension().is_some_and(|e| e == "json")).collect();
        assert!(!files.is_empty());
        for path in files {
            if path.ends_with("render.json") {
                assert!(matches!(parse::<Value>(&path), Ok(Value::Object(_))));
                continue;
            }
            assert!(read::<Value>(&path).is_ok(), "{}", path.display());
            assert!(matches!(read::<bool>(&path), Err(OracleError::Form { .. })));
        }
    }

    #[test]
    fn a_file_that_is_not_there_is_told() {
        assert!(matches!(read::<Value>(Path::new("no.json")), Err(OracleError::File { .. })));
    }
}
