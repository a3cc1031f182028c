//! The trace file.
//!
//! ```text
//! magic    8 bytes  89 53 52 54 0D 0A 1A 0A
//! version  u16      1
//! chunk    tag u8, length u32, CRC-32 of tag and payload u32, payload; all numbers little-endian
//!   S      one signal definition, in the order of their numbers
//!   N      one note: key, value
//!   E      the next piece of the event stream; an event may cross from one piece into the next
//!   Z      number of events u64, digest 32 bytes; the last chunk
//! ```
//!
//! All S and N come before the first E. The file does not depend on how the trace was held in memory.

use std::io::{self, Read, Write};

use super::code::{CodeFault, CodeReader, CodecState, MAX_EVENT, put_text};
use super::error::{TraceError, TraceTransfer};
use super::info::{info_bytes, put_info, read_info};
use super::segment::Fetched;
use super::{Trace, note_bytes};

/// The file format that this program writes and reads.
pub(super) const VERSION: u16 = 1;

const MAGIC: [u8; 8] = [0x89, b'S', b'R', b'T', 0x0d, 0x0a, 0x1a, 0x0a];
const PIECE: usize = 64 * 1024;

/// How large a trace file may become in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadLimits {
    /// Bytes that the loaded trace may take, roughly.
    pub bytes: u64,
}

impl Default for LoadLimits {
    /// One gigabyte: about 170 million changes of a Boolean.
    fn default() -> Self {
        LoadLimits { bytes: 1 << 30 }
    }
}

impl Trace {
    /// Writes the trace file.
    ///
    /// # Errors
    /// [`TraceError::Io`] if writing, or reading a stored segment, fails; [`TraceError::TooLarge`] for a definition or note
    /// of four gigabytes.
    pub fn save(&self, out: &mut dyn Write) -> Result<(), TraceError> {
        put(out, &MAGIC)?;
        put(out, &VERSION.to_le_bytes())?;
        let mut payload = Vec::new();
        for info in &self.signals {
            payload.clear();
            put_info(&mut payload, info);
            put_chunk(out, b'S', &payload)?;
        }
        for (key, value) in self.notes() {
            payload.clear();
            put_text(&mut payload, key);
            put_text(&mut payload, value);
            put_chunk(out, b'N', &payload)?;
        }
        payload.clear();
        let mut fetched = Fetched::default();
        for segment in 0..self.segments.count() {
            let Some((_, mut stream)) = self.segments.get(segment, &mut fetched)? else { break };
            while !stream.is_empty() {
                let (now, later) = stream.split_at(stream.len().min(PIECE - payload.len()));
                payload.extend_from_slice(now);
                stream = later;
                if payload.len() == PIECE {
                    put_chunk(out, b'E', &payload)?;
                    payload.clear();
                }
            }
        }
        if !payload.is_empty() {
            put_chunk(out, b'E', &payload)?;
        }
        payload.clear();
        payload.extend_from_slice(&self.events.to_le_bytes());
        payload.extend_from_slice(&self.digest());
        put_chunk(out, b'Z', &payload)?;
        out.flush().map_err(|error| TraceError::Io { transfer: TraceTransfer::Save, kind: error.kind() })
    }

    /// Reads a trace file of any origin into memory and proves that it is whole.
    ///
    /// # Errors
    /// Every variant of [`TraceError`] that speaks of a file, with the byte at which it is wrong.
    pub fn load(input: &mut dyn Read, limits: LoadLimits) -> Result<Trace, TraceError> {
        let mut source = SourceBytes { input, offset: 0 };
        let mut magic = [0; MAGIC.len()];
        if source.fill(&mut magic)? < magic.len() || magic != MAGIC {
            return Err(TraceError::NotATrace);
        }
        let mut version = [0; 2];
        source.exact(&mut version)?;
        let version = u16::from_le_bytes(version);
        if version != VERSION {
            return Err(TraceError::Version(version));
        }
        let mut loader = Loader {
            trace: Trace::new(),
            state: CodecState::default(),
            pending: Vec::new(),
            in_events: false,
            left: limits.bytes,
            limit: limits.bytes,
        };
        let mut payload = Vec::new();
        loop {
            let offset = source.offset;
            let tag = source.chunk(&mut payload, loader.left, loader.limit)?;
            let done = match tag {
                b'S' => loader.signal(&payload, offset),
                b'N' => loader.note(&payload, offset),
                b'E' => loader.events(&payload, offset),
                b'Z' => return loader.finish(&payload, offset),
                _ => Err(TraceError::Malformed { offset }),
            };
            done?;
        }
    }
}

fn put(out: &mut dyn Write, bytes: &[u8]) -> Result<(), TraceError> {
    out.write_all(bytes).map_err(|error| TraceError::Io { transfer: TraceTransfer::Save, kind: error.kind() })
}

fn put_chunk(out: &mut dyn Write, tag: u8, payload: &[u8]) -> Result<(), TraceError> {
    let length =
        u32::try_from(payload.len()).map_err(|_| TraceError::TooLarge { limit: u64::from(u32::MAX) })?;
    put(out, &[tag])?;
    put(out, &length.to_le_bytes())?;
    put(out, &checksum(tag, payload).to_le_bytes())?;
    put(out, payload)
}

fn checksum(tag: u8, payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&[tag]);
    hasher.update(payload);
    hasher.finalize()
}

/// A file of any origin, with the byte at which reading stands.
struct SourceBytes<'a> {
    input: &'a mut dyn Read,
    offset: u64,
}

impl SourceBytes<'_> {
    /// Reads as much as there is; how much that was.
    fn fill(&mut self, into: &mut [u8]) -> Result<usize, TraceError> {
        let mut have = 0;
        while have < into.len() {
            match self.input.read(&mut into[have..]) {
                Ok(0) => break,
                Ok(count) => have += count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => {
                    return Err(TraceError::Io { transfer: TraceTransfer::Load, kind: error.kind() });
                }
            }
        }
        self.offset += have as u64;
        Ok(have)
    }

    fn exact(&mut self, into: &mut [u8]) -> Result<(), TraceError> {
        if self.fill(into)? < into.len() {
            Err(TraceError::Truncated { offset: self.offset })
        } else {
            Ok(())
        }
    }

    /// Reads one chunk and returns its tag.
    fn chunk(&mut self, payload: &mut Vec<u8>, left: u64, limit: u64) -> Result<u8, TraceError> {
        let offset = self.offset;
        let mut head = [0; 9];
        self.exact(&mut head)?;
        let [tag, l0, l1, l2, l3, c0, c1, c2, c3] = head;
        let length = u32::from_le_bytes([l0, l1, l2, l3]);
        // The last chunk is not charged for.
        if tag != b'Z' && u64::from(length) > left {
            return Err(TraceError::TooLarge { limit });
        }
        if matches!(tag, b'Z' | b'E') && length as usize > PIECE {
            return Err(TraceError::Malformed { offset });
        }
        // The length is only believed as far as there are bytes.
        payload.clear();
        let mut missing = length as usize;
        while missing > 0 {
            let have = payload.len();
            payload.resize(have + missing.min(PIECE), 0);
            self.exact(&mut payload[have..])?;
            missing -= payload.len() - have;
        }
        if checksum(tag, payload) != u32::from_le_bytes([c0, c1, c2, c3]) {
            return Err(TraceError::Checksum { offset });
        }
        Ok(tag)
    }
}

/// A trace that is being loaded.
struct Loader {
    trace: Trace,
    state: CodecState,
    /// The beginning of an event whose end is in the next chunk.
    pending: Vec<u8>,
    in_events: bool,
    /// Memory that may still be taken.
    left: u64,
    limit: u64,
}

impl Loader {
    fn charge(&mut self, bytes: usize) -> Result<(), TraceError> {
        self.left = self.left.checked_sub(bytes as u64).ok_or(TraceError::TooLarge { limit: self.limit })?;
        Ok(())
    }

    fn signal(&mut self, payload: &[u8], offset: u64) -> Result<(), TraceError> {
        if self.in_events {
            return Err(TraceError::Malformed { offset });
        }
        let info = read_info(payload).map_err(|_| TraceError::Malformed { offset })?;
        self.charge(info_bytes(&info))?;
        self.trace.define(info)?;
        Ok(())
    }

    fn note(&mut self, payload: &[u8], offset: u64) -> Result<(), TraceError> {
        let mut reader = CodeReader::new(payload);
        let (key, value) = match (reader.text(), reader.text()) {
            (Ok(key), Ok(value)) if reader.rest().is_empty() && !self.in_events => (key, value),
            _ => return Err(TraceError::Malformed { offset }),
        };
        self.charge(note_bytes(key) + value.len())?;
        self.trace.set_note(key, value.to_string());
        Ok(())
    }

    fn events(&mut self, payload: &[u8], offset: u64) -> Result<(), TraceError> {
        self.in_events = true;
        self.charge(payload.len())?;
        self.pending.extend_from_slice(payload);
        let mut at = 0;
        loop {
            match self.state.decode(&self.pending[at..], self.trace.signals.len()) {
                Ok((event, length)) => {
                    at += length;
                    self.trace.append(event)?;
                }
                Err(CodeFault::Short) if self.pending.len() - at < MAX_EVENT => break,
                Err(_) => return Err(TraceError::Malformed { offset }),
            }
        }
        self.pending.drain(..at);
        Ok(())
    }

    fn finish(self, payload: &[u8], offset: u64) -> Result<Trace, TraceError> {
        let Some((count, digest)) = payload.split_first_chunk::<8>() else {
            return Err(TraceError::Malformed { offset });
        };
        if !self.pending.is_empty() || digest.len() != 32 {
            return Err(TraceError::Malformed { offset });
        }
        if u64::from_le_bytes(*count) != self.trace.len() || digest != self.trace.digest() {
            return Err(TraceError::DigestMismatch);
        }
        Ok(self.trace)
    }
}
