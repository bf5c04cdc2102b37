use crate::file::{self, LARGEST_MESH};
use crate::storage::replace;
use crate::{Scene, SimError, Snapshot, Statistics, style};
use serde::{Deserialize, Serialize};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// First bytes of a checkpoint: the name and the version of the format.
const MAGIC: &[u8; 12] = b"RAPUNZEL\x07\0\0\0";
/// Where the rest begins, which is hashed.
const HEAD: u64 = 12 + 32;
/// Room for the texts in it.
const TEXT: usize = 256;
/// The program that can go on with a checkpoint: another version may compute other bits.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Everything from which a run goes on so that its output is the same, byte for byte, as if it had
/// never stopped.
///
/// The file is the magic number, the BLAKE3 hash of the rest, and the rest: the version of the
/// program as a length and text, then the checkpoint in postcard's format. What is written may be
/// the world as it is, without a copy of it.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Checkpoint<S = Snapshot> {
    /// Hash of the scene.
    pub(crate) scene: [u8; 32],
    pub(crate) snapshot: S,
    pub(crate) statistics: Statistics,
    /// How far each output has come, in the order of the observers.
    pub(crate) marks: Vec<u64>,
}

/// The hash that tells scenes apart: of the RON with all defaults filled in, the files that it
/// names, and those that its styles name.
pub(crate) fn scene_hash(scene: &Scene) -> Result<[u8; 32], SimError> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(scene.to_ron()?.as_bytes());
    for path in style::files(scene)? {
        let read = hasher.update_reader(file::open(&path, LARGEST_MESH)?);
        read.map_err(SimError::io("read", &path))?;
    }
    Ok(hasher.finalize().into())
}

impl<S: Serialize> Checkpoint<S> {
    /// Writes the checkpoint atomically, without waiting for the disk. It goes through the numbers
    /// once, and comes back to the head for their hash.
    pub(crate) fn write(&self, path: &Path) -> Result<(), SimError> {
        replace(path, |to| {
            to.write_all(MAGIC)?;
            to.write_all(&[0; 32])?;
            let mut hashing = BufWriter::new(Hashing { to, hasher: blake3::Hasher::new() });
            self.put(&mut hashing)?;
            hashing.flush()?;
            let hash = hashing.get_ref().hasher.finalize();
            drop(hashing);
            to.seek(SeekFrom::Start(MAGIC.len() as u64))?;
            to.write_all(hash.as_bytes())
        })
    }

    fn put(&self, to: &mut impl Write) -> io::Result<()> {
        let mut to = Telling { to, error: None };
        let written = postcard::to_io(&(VERSION, self), &mut to).map(|_| ());
        written.map_err(|error| to.error.unwrap_or_else(|| io::Error::other(error)))
    }
}

/// A writer of what is hashed on its way; made for writes of many bytes.
struct Hashing<'a, W> {
    to: &'a mut W,
    hasher: blake3::Hasher,
}

impl<W: Write> Write for Hashing<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.to.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// A writer that keeps its error, which postcard replaces by one of its own.
struct Telling<W> {
    to: W,
    error: Option<io::Error>,
}

impl<W: Write> Write for Telling<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.to.write(bytes).map_err(|error| self.keep(error))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush().map_err(|error| self.keep(error))
    }
}

impl<W> Telling<W> {
    fn keep(&mut self, error: io::Error) -> io::Error {
        let kind = error.kind();
        self.error = Some(error);
        kind.into()
    }
}

impl Checkpoint {
    /// Reads a checkpoint. It goes through the file twice, so that it is never held beside the
    /// numbers in it.
    pub(crate) fn read(path: &Path) -> Result<Self, SimError> {
        let broken = || unusable(path, &"it is damaged");
        let mut file = file::open(path, u64::MAX)?;
        let (mut magic, mut hash) = ([0; 12], [0; 32]);
        file.read_exact(&mut magic).map_err(|_| broken())?;
        if magic != *MAGIC {
            return Err(unusable(path, &"it is not a checkpoint of this version"));
        }
        file.read_exact(&mut hash).map_err(|_| broken())?;
        let mut hasher = blake3::Hasher::new();
        let hashed = hasher.update_reader(&mut file);
        let rewound = hashed.and_then(|_| file.seek(SeekFrom::Start(HEAD)));
        rewound.map_err(SimError::io("read", path))?;
        if hasher.finalize() != hash {
            return Err(broken());
        }
        let mut room = [0; TEXT];
        let taken = postcard::from_io::<String, _>((file, &mut room));
        let (version, (file, _)) = taken.map_err(|_| broken())?;
        if version != VERSION {
            let why = format!("it was written by version {version}, and this is {VERSION}");
            return Err(unusable(path, &why));
        }
        let mut room = [0; TEXT];
        let taken = postcard::from_io((file, &mut room));
        taken.map(|(checkpoint, _)| checkpoint).map_err(|_| broken())
    }
}

fn unusable(path: &Path, why: &dyn std::fmt::Display) -> SimError {
    let why = format!("cannot be used: {why}; force a new run");
    SimError::Checkpoint { path: path.to_owned(), why }
}
