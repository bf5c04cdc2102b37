use std::io::Write;
use std::path::PathBuf;

/// A folder of the data that is not shipped: in `RAPUNZEL_DATA`, else beside the repository.
pub(crate) fn data(folder: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"));
    let path = std::env::var_os("RAPUNZEL_DATA").map_or_else(beside, PathBuf::from).join(folder);
    if path.exists() {
        return Some(path);
    }
    // Past the capture of the test runner: nobody shall take a skipped test for one that passed.
    let told = writeln!(
        std::io::stderr(),
        "SKIPPED: there is no {}; set RAPUNZEL_DATA to the folder that holds it",
        path.display()
    );
    told.expect("standard error is open");
    None
}
