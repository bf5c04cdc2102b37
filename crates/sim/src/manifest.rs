use crate::storage::PARTIAL;
use std::collections::BTreeSet;
use std::fmt;
use std::path::Path;

/// The files of a run, which it lists in its folder before it writes them: the mark by which a run
/// folder is known, and all that may be removed from it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Manifest(Vec<Entry>);

/// Names in a folder, with `/` between folder and file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Entry {
    One(String),
    /// `stem-000000.extension` and so on.
    Series {
        stem: String,
        extension: String,
        /// How many there may be.
        count: u64,
    },
}

/// The first line of the text.
const HEAD: &str = "# The files of a Rapunzel run, which it may overwrite and remove";

impl Entry {
    /// A series of files in a folder.
    pub(crate) fn series(stem: &str, extension: &str, count: u64) -> Self {
        Self::Series { stem: stem.into(), extension: extension.into(), count }
    }

    fn contains(&self, name: &str) -> bool {
        match self {
            Self::One(one) => one == name,
            Self::Series { stem, extension, count } => {
                let number = name.strip_prefix(stem.as_str()).and_then(|rest| {
                    rest.strip_prefix('-')?.strip_suffix(extension.as_str())?.strip_suffix('.')
                });
                // The number as it is written, so that "+1" and "1" are names of somebody else's.
                number.is_some_and(|text| {
                    let number = text.parse().ok().filter(|number: &u64| number < count);
                    number.is_some_and(|number| format!("{number:06}") == text)
                })
            }
        }
    }

    fn parse(line: &str) -> Option<Self> {
        let Some((stem, rest)) = line.split_once("-{") else { return Some(Self::One(line.into())) };
        let (count, extension) = rest.split_once("}.")?;
        let count = count.strip_prefix("0..")?.parse().ok()?;
        Some(Self::series(stem, extension, count))
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::One(name) => f.write_str(name),
            Self::Series { stem, extension, count } => {
                write!(f, "{stem}-{{0..{count}}}.{extension}")
            }
        }
    }
}

impl From<&str> for Entry {
    fn from(name: &str) -> Self {
        Self::One(name.into())
    }
}

impl FromIterator<Entry> for Manifest {
    fn from_iter<I: IntoIterator<Item = Entry>>(entries: I) -> Self {
        Self(entries.into_iter().collect())
    }
}

impl fmt::Display for Manifest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{HEAD}")?;
        self.0.iter().try_for_each(|entry| writeln!(f, "{entry}"))
    }
}

impl Manifest {
    /// Reads what [`fmt::Display`] writes; nothing from another text.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut lines = text.lines();
        if lines.next() != Some(HEAD) {
            return None;
        }
        lines.map(Entry::parse).collect::<Option<_>>().map(Self)
    }

    /// Whether a file of this name, as seen from the folder of the run, is one of the run's, or
    /// what a kill left of one.
    pub(crate) fn owns(&self, name: &str) -> bool {
        let name = name.strip_suffix(PARTIAL).unwrap_or(name);
        self.0.iter().any(|entry| entry.contains(name))
    }

    /// The folders that hold files of the run, as seen from the folder of the run, without that
    /// one.
    pub(crate) fn folders(&self) -> BTreeSet<&str> {
        let names = self.0.iter().map(|entry| match entry {
            Entry::One(name) | Entry::Series { stem: name, .. } => name.as_str(),
        });
        let folders = names.filter_map(|name| Path::new(name).parent()?.to_str());
        folders.filter(|folder| !folder.is_empty()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        [Entry::from("scene.ron"), Entry::series("frames/frame", "vtp", 11)].into_iter().collect()
    }

    #[test]
    fn it_reads_what_it_wrote_and_nothing_else() {
        let text = manifest().to_string();
        assert_eq!(Manifest::parse(&text), Some(manifest()));
        assert_eq!(Manifest::parse(&text.replace("Rapunzel", "Gretel")), None);
        assert_eq!(Manifest::parse(&text.replace("0..", "1..")), None);
        assert_eq!(Manifest::parse(""), None);
    }

    #[test]
    fn a_series_is_its_numbers_and_no_more() {
        let manifest = manifest();
        for ours in [
            "scene.ron",
            "frames/frame-000000.vtp",
            "frames/frame-000010.vtp",
            "frames/frame-000010.vtp.partial",
        ] {
            assert!(manifest.owns(ours), "{ours}");
        }
        for theirs in [
            "frames/frame-000011.vtp",
            "frames/frame-10.vtp",
            "frames/frame-+00010.vtp",
            "frames/frame-000010.png",
            "frames/frame-000010_vtp",
            "frames/frame-notes.vtp",
            "frames/scene.ron",
            "frame-000000.vtp",
            "scene.ron.bak",
        ] {
            assert!(!manifest.owns(theirs), "{theirs}");
        }
        assert_eq!(manifest.folders().into_iter().collect::<Vec<_>>(), ["frames"]);
    }
}
