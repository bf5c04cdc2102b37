//! Files of a user's: the one place where they are opened.

use crate::SimError;
use std::fs::{self, File};
use std::io::{self, BufReader, Read};
use std::path::Path;

/// The largest text, bytes: of a scene, a case, a curve.
const LARGEST_TEXT: u64 = 64_000_000;
/// The largest mesh, bytes.
pub(crate) const LARGEST_MESH: u64 = 1_000_000_000;

/// Opens a file of at most `largest` bytes.
///
/// # Errors
/// [`SimError::Io`] also for what is no file, such as a device or a pipe, which is not opened: that
/// could wait for ever.
pub(crate) fn open(path: &Path, largest: u64) -> Result<BufReader<File>, SimError> {
    let refuse = |why: String| Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    let file = fs::metadata(path).and_then(|there| {
        if !there.is_file() {
            return refuse("it is no file, but a folder, a device or a pipe".into());
        }
        if there.len() > largest {
            let (size, most) = (there.len() as f64 * 1e-6, largest as f64 * 1e-6);
            return refuse(format!("it has {size:.0} MB, and at most {most:.0} MB are read"));
        }
        File::open(path)
    });
    file.map(BufReader::new).map_err(SimError::io("read", path))
}

/// The text of a file of at most 64 MB, without a byte order mark.
///
/// # Errors
/// [`SimError::Io`] if it cannot be read, is no file, too large, or not in UTF-8.
pub fn read_text(path: &Path) -> Result<String, SimError> {
    let mut text = String::new();
    let read = open(path, LARGEST_TEXT)?.read_to_string(&mut text);
    read.map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData => io::Error::new(error.kind(), "it is no text in UTF-8"),
        _ => error,
    })
    .map_err(SimError::io("read", path))?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// The ending of a file's name, in small letters.
pub(crate) fn kind(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_order_mark_is_taken_and_other_encodings_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.ron");
        fs::write(&path, "\u{feff}(a: 1)").expect("written");
        assert_eq!(read_text(&path).expect("a text"), "(a: 1)");
        fs::write(&path, b"\xff\xfe(\0a\0").expect("written");
        assert!(read_text(&path).expect_err("UTF-16").to_string().contains("UTF-8"));
    }

    #[test]
    fn what_is_no_file_or_too_large_is_refused_with_its_size() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(read_text(folder.path()).expect_err("a folder").to_string().contains("no file"));
        let path = folder.path().join("sparse");
        File::create(&path).and_then(|file| file.set_len(20_000_000_000)).expect("a sparse file");
        let error = read_text(&path).expect_err("too large").to_string();
        assert!(error.contains("20000 MB") && error.contains("64 MB"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_links_to_them_are_not_opened() {
        let folder = tempfile::tempdir().expect("a folder");
        let link = folder.path().join("mesh.obj");
        std::os::unix::fs::symlink("/dev/zero", &link).expect("a link");
        for path in [Path::new("/dev/zero"), &link] {
            assert!(
                open(path, LARGEST_MESH).expect_err("a device").to_string().contains("no file")
            );
        }
    }
}
