use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A stream that one thread reads and several write to, each time a whole piece.
#[derive(Debug, Clone)]
pub(crate) struct SharedStream {
    reads: Arc<TcpStream>,
    writes: Arc<Mutex<TcpStream>>,
}

impl SharedStream {
    /// Gives up after so long without anything to read, or without anything being taken.
    pub(crate) fn new(stream: TcpStream, read: Duration, write: Duration) -> io::Result<Self> {
        stream.set_read_timeout(Some(read))?;
        stream.set_write_timeout(Some(write))?;
        stream.set_nodelay(true)?;
        let writes = Arc::new(Mutex::new(stream.try_clone()?));
        Ok(Self { reads: Arc::new(stream), writes })
    }

    /// Ends reading and writing, also where a thread waits for it.
    pub(crate) fn shut_down(&self) {
        let _ = self.reads.shutdown(Shutdown::Both);
    }
}

impl Read for SharedStream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        (&*self.reads).read(buffer)
    }
}

impl Write for SharedStream {
    /// Writes all of the piece.
    fn write(&mut self, piece: &[u8]) -> io::Result<usize> {
        let mut stream = self.writes.lock().unwrap_or_else(PoisonError::into_inner);
        let written = stream.write_all(piece);
        if written.is_err() {
            // Part of it may have gone: nothing after it would be understood.
            self.shut_down();
        }
        written.map(|()| piece.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
