use crate::file::{self, LARGEST_MESH};
use crate::storage::replace;
use crate::world::WholeNumbers;
use crate::{Scene, SimError, Snapshot, Statistics, World, style};
use serde::Serialize;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// First bytes of a checkpoint: the name and the version of the format.
const MAGIC: &[u8; 12] = b"RAPUNZEL\x09\0\0\0";
/// Where the rest begins, which is hashed.
const HEAD: u64 = 12 + 32;
/// Room for the texts in it.
const TEXT: usize = 256;
/// The program that can go on with a checkpoint: another version may compute other bits.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Everything from which a run goes on so that its output is the same, byte for byte, as if it had
/// never stopped.
///
/// The file is the magic number, the BLAKE3 hash of the rest, and the rest: in postcard's format
/// the version of the program as a length and text, and all that is not the stepper's; then the
/// number of lists that the stepper has saved, and of each its length and its numbers, all of eight
/// bytes, the lowest first.
#[derive(Debug)]
pub(crate) struct Checkpoint {
    /// Hash of the scene.
    pub(crate) scene: [u8; 32],
    pub(crate) snapshot: Snapshot,
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

impl Checkpoint {
    /// Writes a checkpoint of a world atomically, without waiting for the disk. It goes through the
    /// numbers once, and comes back to the head for their hash.
    pub(crate) fn write(
        world: &World,
        scene: [u8; 32],
        statistics: Statistics,
        marks: &[u64],
        path: &Path,
    ) -> Result<(), SimError> {
        replace(path, |to| {
            to.write_all(MAGIC)?;
            to.write_all(&[0; 32])?;
            let mut hashing = BufWriter::new(Hashing { to, hasher: blake3::Hasher::new() });
            put(&mut hashing, &(VERSION, scene, world.whole_numbers(), statistics, marks))?;
            put_lists(&mut hashing, world)?;
            hashing.flush()?;
            let hash = hashing.get_ref().hasher.finalize();
            drop(hashing);
            to.seek(SeekFrom::Start(MAGIC.len() as u64))?;
            to.write_all(hash.as_bytes())
        })
    }
}

/// Writes what is serialised.
fn put(to: &mut impl Write, what: &impl Serialize) -> io::Result<()> {
    let mut to = Telling { to, error: None };
    let written = postcard::to_io(what, &mut to).map(|_| ());
    written.map_err(|error| to.error.unwrap_or_else(|| io::Error::other(error)))
}

/// Writes the lists of numbers that the stepper of a world saves, one at a time.
fn put_lists(to: &mut impl Write, world: &World) -> io::Result<()> {
    let lists = world.stepper().save();
    to.write_all(&(lists.size_hint().0 as u64).to_le_bytes())?;
    let mut bytes = Vec::new();
    for list in lists {
        to.write_all(&(list.len() as u64).to_le_bytes())?;
        bytes.resize(8 * list.len(), 0);
        for (bytes, number) in bytes.as_chunks_mut().0.iter_mut().zip(list) {
            *bytes = number.to_le_bytes();
        }
        to.write_all(&bytes)?;
    }
    Ok(())
}

/// Reads the lists of numbers that [`put_lists`] wrote, and the end of the file behind them.
fn take_lists(from: &mut impl Read) -> io::Result<Vec<Vec<f64>>> {
    fn length(from: &mut impl Read) -> io::Result<u64> {
        let mut bytes = [0; 8];
        from.read_exact(&mut bytes)?;
        Ok(u64::from_le_bytes(bytes))
    }
    let (mut lists, mut bytes) = (Vec::new(), Vec::new());
    for _ in 0..length(from)? {
        let size = length(from)?.saturating_mul(8);
        bytes.clear();
        // A length alone takes no room.
        if from.take(size).read_to_end(&mut bytes)? as u64 != size {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        lists.push(bytes.as_chunks().0.iter().copied().map(f64::from_le_bytes).collect());
    }
    let is_end = from.read(&mut [0])? == 0;
    if is_end { Ok(lists) } else { Err(io::ErrorKind::InvalidData.into()) }
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
        let taken = postcard::from_io::<(_, WholeNumbers, _, _), _>((file, &mut room));
        let ((scene, whole, statistics, marks), (mut file, _)) = taken.map_err(|_| broken())?;
        let stepper = take_lists(&mut file).map_err(|_| broken())?;
        Ok(Self { scene, snapshot: Snapshot { whole, stepper }, statistics, marks })
    }
}

fn unusable(path: &Path, why: &dyn std::fmt::Display) -> SimError {
    let why = format!("cannot be used: {why}; force a new run");
    SimError::Checkpoint { path: path.to_owned(), why }
}
