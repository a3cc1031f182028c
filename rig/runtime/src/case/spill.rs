//! Where a trace goes on when it outgrows memory.

use signal::Spill;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

/// A nameless temporary file, made when the first byte is written: most traces never need it.
#[derive(Debug, Default)]
struct Lazy {
    file: Option<File>,
}

impl Lazy {
    fn file(&mut self) -> io::Result<&mut File> {
        match &mut self.file {
            Some(file) => Ok(file),
            slot => Ok(slot.insert(tempfile::tempfile()?)),
        }
    }
}

impl Read for Lazy {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.file()?.read(into)
    }
}

impl Write for Lazy {
    fn write(&mut self, from: &[u8]) -> io::Result<usize> {
        self.file()?.write(from)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file()?.flush()
    }
}

impl Seek for Lazy {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file()?.seek(to)
    }
}

/// Room on disk for a trace; gone with it.
pub fn temporary() -> Box<dyn Spill> {
    Box::new(Lazy::default())
}
